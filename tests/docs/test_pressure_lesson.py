"""The numbers of the lesson about the pulsing pressure are those of its runs, and its calculation by hand adds up."""

import re
from pathlib import Path

import numpy as np
import pytest

from vvdp.base.tables import with_settings
from vvdp.runs.simulate import run_system
from vvdp.systems.system import load_system

PAGE = (Path(__file__).parents[2] / "docs/tutorials/why-the-pressure-pulses.md").read_text("utf-8")
ROWS = [[cell.strip(" `") for cell in line.split("|")[1:-1]] for line in PAGE.splitlines() if line.startswith("| ")][1:]


def measured(change):
    """The numbers of a row, in its order."""
    system = load_system("prototype")
    if "=" in change:
        system = system.read_from(with_settings(system.table, [change]))
    run = run_system(system)
    last = run.times > 0.95 * run.times[-1]
    inlet, load = run.pressure("inlet")[last] / 1e5, run.pressure("load_line")[last] / 1e5
    mean = run.summary["pressure_mean_load_line_Pa"] / 1e5
    return [inlet.min(), inlet.max(), mean, np.ptp(load), run.summary["pwm_frequency_Hz"]], run


def test_the_table_has_its_rows():
    assert len(ROWS) == 6 and all(len(row) == 6 for row in ROWS)


@pytest.mark.parametrize("row", ROWS, ids=[row[0] for row in ROWS])
def test_each_row_is_its_run(row):
    found, _ = measured(row[0])
    assert [f"{value:.1f}" for value in found] == row[1:]


def test_the_calculation_by_hand():
    found, run = measured("none")
    share, flow = run.summary["load_flow_fraction"], 6e4 * run.summary["flow_mean_load_m3_s"]
    period = 1e3 / found[-1]
    assert f"{flow:.1f} L/min all the time" in PAGE
    assert f"{share:.2f} of the period of {period:.1f} ms" in PAGE.replace("\n", " ")
    volume = 17.1e3 / 60.0 * 0.58 * 13.5e-3  # cm^3, of L/min and s
    assert f"= {volume:.1f}\\ \\text{{cm}}^3" in PAGE
    gas = 50.0 * (51.0 / 101.0) ** (1.0 / 1.3)
    compliance = gas / (1.3 * 101.0)
    assert f"= {gas:.1f}$ cm³" in PAGE and f"= {compliance:.3f}$ cm³/bar" in PAGE
    (ripple,) = re.findall(r"Delta V / C = ([\d.]+)\$ bar", PAGE)
    assert float(ripple) == pytest.approx(2.2 / compliance, abs=0.15)
    assert found[3] < float(ripple) < 1.5 * found[3]  # what is left out makes the volume softer
