"""A spool that jams while the bench runs: how soon the program that watches it says so, and what it states."""

from typing import NamedTuple

import numpy as np
import pytest

from vvdp.base.arrays import Array
from vvdp.base.display import percent
from vvdp.estimation.estimator import Estimate
from vvdp.evaluation.bench import rotary_bench
from vvdp.evaluation.summary import Summary, summary
from vvdp.runs.bench import bench_series
from vvdp.runs.bench_charts import bench_charts
from vvdp.runs.run import RecordedRun
from vvdp.simulation.record import record_of
from vvdp.simulation.run import Run, simulate
from vvdp.systems.system import System, load_system

pytestmark = pytest.mark.heavy

SETTINGS = ("run.window=0 s",)
SOON = 0.02
"""Time within which a jam is to be told [s]: half a turn at 25 turns/s, four sectors."""
JAMS = tuple(0.8 + 0.0073 * i for i in range(8))
"""When the spool jams [s]: at other angles, and at other places between two samples."""


class Jam(NamedTuple):
    """A run in which the spool jams: its numbers, the estimate of each sample, its time and the true speed."""

    system: System
    run: Run
    numbers: Summary
    times: Array
    speed: Array
    estimate: Estimate


def _fault(at, torque):
    return {"jams": "spool", "torque": f"{torque} N*m", "begin": f"{at} s"}


def jam(at, torque, seed, until):
    """A run of the prototype in which dry friction of `torque` [N m] seizes the spool `at` a time [s]."""
    fault = [f"faults.jam.{key}={value}" for key, value in _fault(at, torque).items()]
    system = load_system("prototype", [*SETTINGS, *fault, f"encoder.seed={seed}"], until=until)
    run = simulate(system.model, system.case, system.stepping)
    sampled = run.memory["encoder"]
    return Jam(system, run, summary(system, run), sampled.time, sampled.speed, run.command.estimate)


@pytest.fixture(scope="module")
def jams():
    """Five newton metres stop the spool within 2 ms, each time with other noise."""
    return {at: jam(at, 5.0, seed, "1.1 s") for seed, at in enumerate(JAMS, start=1)}


def test_a_jam_is_told_within_20_ms(jams):
    for at, found in jams.items():
        before, after = found.times <= at, found.times > at + SOON
        assert found.speed[before][-1] == pytest.approx(154.7, abs=5.0)
        assert np.all(np.abs(found.speed[found.times > at + 0.003]) < 0.01)
        told = found.times[found.estimate.standstill > 0.5]
        assert told[0] > at
        assert told[0] - at < SOON
        assert np.all(found.estimate.standstill[after] > 0.5)
        assert found.numbers["standstill_time_s"] == pytest.approx(1.1 - told[0], abs=0.003)


def test_the_speed_is_known_to_fall_when_the_jam_is_told(jams):
    for at, found in jams.items():
        after = found.times > at + SOON
        assert np.all(found.estimate.speed[after] < 0.1 * 154.7)


def test_the_stated_deviations_hold_through_the_jam(jams):
    """Shares of the time from 0.5 s on, over all jams; a single run has few independent errors of the angle."""
    for name in ("angle", "speed"):
        covered = np.array([found.numbers[f"spool_{name}_coverage"] for found in jams.values()])
        assert 0.90 <= covered.mean() <= 0.99, (name, covered)
        assert covered.min() > 0.90, (name, covered)


def test_a_spool_jams_with_the_motor_that_drives_it():
    """As from the command line: a stiff coupling, and a motor that stops."""
    driven = (
        "spool_drive.coupling=1 N*m*s",
        'operation.spool_motor_speed={step = ["1500 rpm", "0 rpm"], at = "0.8 s"}',
    )
    system = load_system("prototype", [*SETTINGS, *driven], until="1 s")
    run = simulate(system.model, system.case, system.stepping)
    told = run.memory["encoder"].time[run.command.estimate.standstill > 0.5]
    assert 0.8 < told[0] < 0.8 + SOON
    assert summary(system, run)["standstill_time_s"] == pytest.approx(1.0 - told[0], abs=0.003)


def test_a_spool_that_turns_is_never_said_to_stand():
    found = jam(10.0, 5.0, 3, "3 s")
    assert found.times[-1] > 2.9
    assert np.max(found.estimate.standstill) < 0.1
    assert found.numbers["standstill_time_s"] == 0.0


def test_the_page_shows_the_errors_that_the_numbers_count(jams):
    """The share of the time in which the drawn error lies inside of the drawn band is the coverage of the summary."""
    found = jams[JAMS[0]]
    shown = RecordedRun(found.system, record_of(found.run), found.numbers, {})
    series = bench_series(shown, rotary_bench(found.system, "test"))
    late = series["time_s"] >= 0.5
    t = series["time_s"][late]
    for name, unit in (("angle", "rad"), ("speed", "rad_s")):
        error, band = (series[f"{name}_{column}_{unit}"][late] for column in ("error", "band_high"))
        share = np.trapezoid(1.0 * (np.abs(error) <= band), t) / (t[-1] - t[0])
        assert share == pytest.approx(found.numbers[f"spool_{name}_coverage"], abs=1e-12)
    chart = next(c for c in bench_charts(shown, rotary_bench(found.system, "test"), series, {}) if c.name == "estimate")
    assert [panel.label for panel in chart.panels] == ["speed", "angle error", "speed error", "standstill"]
    assert percent(found.numbers["spool_speed_coverage"]) in chart.caption
