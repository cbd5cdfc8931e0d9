"""Numbers that docs/models/gerotor-control.md spells out, from runs of shipped systems and of the published loops."""

import re
from pathlib import Path

import numpy as np
import pytest
from tests.systems.axial_texts import change, run_of
from tests.systems.test_published_gerotor_loop import (
    NOISY,
    STROKE,
    constant,
    generator,
    ideal,
    in_time,
    late_tracking,
    lumped,
    peak,
    published_text,
    rows,
    tracking,
)

from vvdp.evaluation.summary import summary
from vvdp.systems.system import shipped_systems

pytestmark = pytest.mark.heavy

PAGE = (Path(__file__).parents[2] / "docs" / "models" / "gerotor-control.md").read_text("utf-8")
WORDS = " ".join(PAGE.split())
TEXT, IDEAL = published_text(), ideal(published_text())


def cells(case: str) -> list[float]:
    """The numbers of our column in the row of a case, the first where the page has several."""
    row = next(row for row in PAGE.splitlines() if row.startswith(f"| {case} |"))
    return [float(number) for number in re.findall(r"[\d.]+", row.split("|")[3])]


def drifting() -> str:
    speed = '{ sine = "10 rev/s", amplitude = "0.5 rev/s", frequency = "0.1 Hz" }'
    return change(change(constant(IDEAL), "operation", spool_speed=speed), "run", until="26 s")


@pytest.mark.sampled(4)
@pytest.mark.parametrize(
    ("case", "text"),
    [
        ("signal generator, 20 states, 25 Hz, 2 ms, ideal map", ideal(generator(TEXT))),
        ("periodic filter, ideal map", IDEAL),
        ("lumped filter, ideal map", lumped(IDEAL)),
        ("lumped filter, dead band", lumped(TEXT)),
        ("periodic filter, dead band", TEXT),
        ("basis in time, off by 0.5 Hz: tracking", in_time(IDEAL, 9.5)),
        ("speed of 10 +- 0.5 Hz, basis in time", in_time(drifting(), 10.0)),
        ("the same, basis in the spool's angle, white noise", change(drifting(), "axial_sensor", noise=NOISY)),
    ],
)
def test_tracking_of_the_table(case, text):
    told = cells(case)
    assert tracking(text) == pytest.approx(told[0], rel=0.03)
    if len(told) > 1:
        assert late_tracking(text) == pytest.approx(told[1], rel=0.05)


@pytest.mark.thorough
def test_estimates_and_commands_of_the_table():
    held, biased = rows(lumped(constant(TEXT))), rows(in_time(IDEAL, 9.5))
    assert cells("constant reference, dead band, lumped filter: estimate") == pytest.approx(
        [peak(held.estimate - held.reference)], rel=0.01
    )
    assert cells("the same, swing of the command") == pytest.approx([np.ptp(held.command)], rel=0.01)
    assert cells("the same, estimate") == pytest.approx([peak(biased.estimate - biased.true)], rel=0.01)
    assert f"swings by {50.0 * np.ptp(held.true) / STROKE:.2f} %" in WORDS
    quiet = [rows(constant(published_text(NOISY, seed))) for seed in range(1, 21)]
    estimate = np.mean([peak(each.estimate - each.reference) for each in quiet])
    swing = np.mean([np.ptp(each.command) for each in quiet])
    assert cells("the same, periodic filter: estimate, 20 seeds") == pytest.approx([estimate], rel=0.05)
    assert cells("the same, swing of the command, 20 seeds") == pytest.approx([swing], rel=0.05)


@pytest.mark.thorough
def test_numbers_of_the_shipped_systems():
    found = summary(*run_of(shipped_systems()["axial-gerotor"]))
    assert f"{1e6 * found['spool_position_error_rms_m']:.0f} um rms against the reference" in WORDS
    assert f"{1e3 * found['spool_position_error_max_m']:.2f} mm at most" in WORDS
    assert f"a periodic sensor error of {1e3 * found['pollution_rms_m']:.2f} mm rms" in WORDS
    stated = f"stated standard deviation of `axial-gerotor`, {1e6 * found['spool_estimate_deviation_rms_m']:.0f} um"
    assert stated in WORDS
    _, run = run_of(shipped_systems()["axial-gerotor"])
    back = np.flatnonzero((run.times > 5.0) & (run.times < 5.5))
    ahead = run.command.drive_observer.position[back + 1] - run.state.drive_gerotor.position[back]
    assert 1e6 * np.mean(ahead) == pytest.approx(-65.0, abs=4.0)
    assert "ahead by 65 um" in WORDS
    unit = summary(*run_of(shipped_systems()["vvdp-duty-control-gerotor"]))
    assert f"its angle from the encoder: {1e6 * unit['spool_position_error_rms_m']:.0f} um rms" in WORDS


SINE = '{ sine = "0.5", amplitude = "0.3", frequency = "0.25 Hz" }'
TIGHT = ("axial_observer", {"position_drift": "3 um"})
GAINS = ("calibration", {"largest_flow": "1.8 lpm", "backward_gain": "0.9"})
BAND = ("calibration", {"backward_dead_band": "0.08"})


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    ("case", "changes"),
    [
        ("as shipped, 10 um", ()),
        ("as shipped, 3 um", (TIGHT,)),
        ("true gains, 3 um", (TIGHT, GAINS)),
        ("true dead band, 3 um", (TIGHT, BAND)),
        ("true in both, 3 um", (TIGHT, GAINS, BAND)),
        ("as shipped, 3 um, no periodic sensor error", (TIGHT, ("axial_sensor", {"pollution_scale": "0 mm"}))),
    ],
)
def test_an_error_of_the_map_is_what_the_estimate_is_off_by(case, changes):
    text = change(shipped_systems()["vvdp-duty-control-gerotor"], "operation", duty_ratio=SINE)
    text = change(text, "run", until="5.5 s")
    for table, values in changes:
        text = change(text, table, **values)
    found = summary(*run_of(text))
    row = next(row for row in PAGE.splitlines() if row.startswith(f"| {case} |"))
    names = ("estimate_error_rms_m", "estimate_deviation_rms_m", "estimate_coverage", "position_error_rms_m")
    told = [float(cell.split()[0]) for cell in row.split("|")[2:6]]
    shown = [found[f"spool_{name}"] for name in names]
    assert told == [round(1e2 * each if each == shown[2] else 1e6 * each) for each in shown]
