"""Numbers that docs/models/axial-control.md spells out, worked out by the systems that it names.

Those of the Lyapunov function, of noise and of resonance are held by tests/systems/test_published_loop.py.
"""

import re
from pathlib import Path

import numpy as np
import pytest
from tests.systems.axial_texts import (
    MILD,
    TABLE,
    backstepping_text,
    change,
    raw_text,
    rename,
    rows_from,
    run_of,
    sample_text,
    tracking,
    trapezoid_text,
)
from tests.systems.test_duty_control import SHIPPED, driven_text, errors, found_in, load_pressures
from tests.systems.test_duty_control import SINE as SINE_DUTY
from tests.systems.test_published_loop import aerated, held_text, sine_text

from vvdp.systems.system import shipped_systems

pytestmark = pytest.mark.heavy

MODELS = Path(__file__).parents[2] / "docs" / "models"
TEXT = (MODELS / "axial-control.md").read_text("utf-8")
PAGE = " ".join(TEXT.split())
TRAPEZOID = trapezoid_text()
SHORT = trapezoid_text(pause=0.15)
SINE = sine_text(TRAPEZOID)


def printed(text):
    """The same with the published feedforward."""
    return rename(text, "passivity", "printed_passivity")


RIGHT = MILD | {"pressure_weight": "5e-13 m^3/Pa"}
CASES = {
    "passivity law": TRAPEZOID,
    "backstepping, its table": backstepping_text(TRAPEZOID, TABLE),
    "backstepping with the passive gains": backstepping_text(TRAPEZOID, MILD),
    "and $\\lambda_2$ = 5e-13 m^3/Pa": backstepping_text(TRAPEZOID, RIGHT),
    "30 % of air, 10 % believed, 20 N s/m unknown: passive": aerated(TRAPEZOID),
    "the same: backstepping": aerated(backstepping_text(TRAPEZOID, TABLE)),
    "passive with the published feedforward, pauses of 0.15 s": aerated(printed(SHORT)),
    "backstepping, pauses of 0.15 s": aerated(backstepping_text(SHORT, TABLE)),
    "sampled every 0.2 ms": sample_text(TRAPEZOID, 0.2),
    "every 2 ms": sample_text(TRAPEZOID, 2.0),
    "every 3 ms": sample_text(TRAPEZOID, 3.0),
    "every 4 ms": sample_text(TRAPEZOID, 4.0),
    "published feedforward, every 3 ms": sample_text(printed(TRAPEZOID), 3.0),
    "published feedforward, every 4 ms": sample_text(printed(TRAPEZOID), 4.0),
    **{f"with a hold, every {period:g} ms": held_text(period) for period in (1.0, 2.0, 3.0, 4.0, 5.0)},
}
SINES = {
    "sine of 1.5 mm, 5 Hz, velocity low-passed at 1 Hz: passive": SINE,
    "the same with $\\lambda_3$ = 1e-10": change(SINE, "passivity", flow_gain="1e-10 m^3/(s*Pa)"),
}


def row_of(name: str) -> list[float]:
    (row,) = re.findall(rf"^\| {re.escape(name)} \|(.*)\|$", TEXT, re.MULTILINE)
    found = (re.search(r"[\d.]+", cell) for cell in row.split("|"))
    return [float(cell[0]) if cell else np.nan for cell in found]


@pytest.mark.sampled(4)
@pytest.mark.parametrize("name", [*CASES, *SINES])
def test_figures_of_chapter_5(name):
    found = tracking(CASES[name]) if name in CASES else tracking(SINES[name], 1.0)
    assert row_of(name)[1] == pytest.approx(found, rel=0.01)


def test_causes_on_the_page():
    """Of what differs from the specified figures: the trapezoid's period and the feedforward; no valve at its end."""
    short, long = (tracking(aerated(printed(text))) for text in (SHORT, TRAPEZOID))
    assert long / short == pytest.approx(np.sqrt(0.4 / 0.5), abs=1e-3)
    assert "= 0.894 times as large" in PAGE
    exact = [tracking(aerated(text)) / tracking(aerated(printed(text))) for text in (SHORT, TRAPEZOID)]
    assert [f"{ratio:.3f}" for ratio in exact] == ["1.058", "1.058"] and "has 1.058 times the error" in PAGE
    for name in ("published feedforward, every 3 ms", "published feedforward, every 4 ms"):
        specified, found = row_of(name)
        assert abs(found / specified - 1.0) < 0.055
    assert np.max(np.abs(rows_from(sample_text(TRAPEZOID, 3.0), 0.6).shown.drive)) < 0.999


def test_every_row_is_worked_out():
    rows = TEXT.split("| case | specified | here |")[1].split("\n\n")[0].splitlines()[2:]
    assert [row.split(" | ")[0].removeprefix("| ") for row in rows] == [*CASES, *SINES]


def test_friction_on_both_pages():
    chamber = shipped_systems()["axial-chamber"]
    rubbed = change(chamber, "axial_friction", viscous_friction="20 N*s/m")

    def error(text):
        return 1e6 * found_in(text)["spool_position_error_rms_m"]

    known, unknown = (f"{error(text):.1f}" for text in (chamber, change(chamber, "passivity", friction="0 N*s/m")))
    assert f"leave an error of {known} um rms against its moving reference, and {unknown} um with" in PAGE
    of_law = " ".join((MODELS / "passivity-control.md").read_text("utf-8").split())
    unknown = error(change(rubbed, "passivity", friction="0 N*s/m"))
    assert f"within {error(rubbed):.1f} um rms, and within {unknown:.0f} um if the law knows no friction" in of_law
    assert found_in(rubbed)["storage_rises"] == 0.0
    assert f"up to {4.0 * (2594.0 + 55.0) / 50.0:.0f} N s/m" in of_law


def test_published_feedforward_on_the_page():
    assert "0.5 % of the error" in PAGE and "a factor of 7.5" in PAGE
    printed = rename(TRAPEZOID, "passivity", "printed_passivity")
    assert tracking(printed) / tracking(TRAPEZOID) - 1.0 == pytest.approx(0.005, abs=0.001)
    slow = sample_text(change(TRAPEZOID, "passivity", flow_gain="3e-11 m^3/(s*Pa)"), 0.2)
    assert tracking(rename(slow, "passivity", "printed_passivity")) / tracking(slow) == pytest.approx(7.5, abs=0.1)


@pytest.mark.thorough
def test_storage_on_the_page():
    raw = found_in(raw_text(SHIPPED))
    samples = 1e3 * (raw["duration_s"] - raw["control_begin_s"] - 1.0)
    assert f"and {raw['storage_rises']:.0f} of {samples:.0f} samples with raw feedback" in PAGE
    assert f"by up to {1e3 * raw['storage_rise_largest_J']:.2f} mJ" in PAGE
    assert f"at a storage of {1e3 * raw['storage_largest_J']:.2f} mJ" in PAGE


@pytest.mark.slow
def test_ten_seeds_on_the_page():
    held, raw = errors(SHIPPED, 10), errors(raw_text(SHIPPED), 10)
    for name, column in (
        ("position against the reference", held[:, 0]),
        ("error of the estimate", held[:, 1]),
        ("position with raw feedback", raw[:, 0]),
    ):
        assert row_of(name) == pytest.approx([np.mean(column), np.max(column)], rel=0.03)
    printed = errors(rename(SHIPPED, "passivity", "printed_passivity"), 10)
    worse = float(re.search(r"is (\d+) % worse in the mean", PAGE)[1])
    assert 100.0 * (np.mean(printed[:, 0]) / np.mean(held[:, 0]) - 1.0) == pytest.approx(worse, abs=1.5)


def test_changing_duty_ratio_on_the_pages():
    found = found_in(change(change(SHIPPED, "operation", duty_ratio=SINE_DUTY), "run", until="3 s", average_from="2 s"))
    error, stated = (1e6 * found[f"spool_estimate_{word}_rms_m"] for word in ("error", "deviation"))
    covered = 100.0 * found["spool_estimate_coverage"]
    assert (
        f"is {error:.0f} um rms and its stated standard deviation {stated:.0f} um, {covered:.0f} % of the errors"
        in PAGE
    )
    observer = " ".join((MODELS / "axial-observer.md").read_text("utf-8").split())
    assert f"is off by {error:.0f} um rms and states {stated:.0f} um." in observer
    filtered = " ".join((MODELS / "event-filter.md").read_text("utf-8").split())
    assert f"cannot turn back within {1e3 * (138.0 / 7.034) ** 2 / 2e4:.0f} ms" in filtered


@pytest.mark.thorough
def test_witness_on_the_page():
    held, raw = load_pressures(driven_text()), load_pressures(raw_text(driven_text()))
    assert f"between {np.min(held):.2f} and {np.max(held):.2f} bar with the observer" in PAGE
    assert f"from {np.min(raw):.1f} to {np.max(raw):.1f} bar" in PAGE


def test_time_without_current_on_the_page():
    found = []
    for duty in (0.1, 0.5, 1.0, 1.2):
        text = change(SHIPPED, "operation", duty_ratio=str(duty))
        text = change(change(text, "axial_sequence", stop_time="1 s"), "run", until="1.1 s", average_from="1.05 s")
        _, run = run_of(text)
        found.append(1e3 * (run.times[(run.times > 1.0) & (run.state.slide.position < 0.0)][0] - 1.0))
    times = "after {:.1f}, {:.1f}, {:.1f} and {:.1f} ms".format(*found)
    assert times in PAGE
