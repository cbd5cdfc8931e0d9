"""Experiments of docs/models/displacement-control.md on a narrow return valve."""

import re
from pathlib import Path

import pytest

from vvdp.evaluation.summary import summary
from vvdp.simulation.run import simulate
from vvdp.systems.system import load_system

PAGE = (Path(__file__).parents[2] / "docs" / "models" / "displacement-control.md").read_text("utf-8")
ROW = re.compile(r"\| ([\d.]+e-7) \| (none|`([\w.]+)` ([^|]+)) \| ([\d.]+) cm \| ([\d.]+) bar \|")
CONDUCTANCE = " m^3/(s*Pa^0.5)"
UNITS = {"belief.return_conductance": CONDUCTANCE, "direction.dwell": " s", "direction.hysteresis_velocity": " mm/s"}
ROWS = ROW.findall(PAGE)


def test_the_page_has_its_experiments():
    assert len(ROWS) == 10


@pytest.mark.thorough
@pytest.mark.parametrize(("valve", "_", "key", "value", "error", "pressure"), ROWS)
def test_an_experiment_comes_to_what_the_page_says(valve, _, key, value, error, pressure):
    settings = {
        "supply_support.support_conductance": "0 m^3/(s*Pa)",
        "valve.jet_exponent": "0",
        "directional_valve.return_conductance": valve + CONDUCTANCE,
        "belief.return_conductance": valve + CONDUCTANCE,
    }
    if key:
        settings[key] = value.strip() + UNITS.get(key, "")
    system = load_system("displacement-control", [f"{name}={entry}" for name, entry in settings.items()])
    found = summary(system, simulate(system.model, system.case, system.stepping))
    assert 100.0 * found["tracking_error_max_m"] == pytest.approx(float(error), abs=1e-3)
    assert 1e-5 * found["pressure_max_chamber_b_Pa"] == pytest.approx(float(pressure), abs=0.1)
