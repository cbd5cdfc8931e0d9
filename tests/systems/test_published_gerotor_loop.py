"""The closed loop of chapter 4 as the specification has it, in the compiled loop: what of its figures is met, and what
is not. Peaks are in per cent of the stroke, from the sixth second on; where nothing else is said the sensor has no
white noise. No observer knows of the drive's lag."""

from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
from tests.systems.axial_texts import change, change_table, run_of

from vvdp.sensing.axial_sensor import pollution_at
from vvdp.systems.system import shipped_systems

pytestmark = pytest.mark.heavy

STROKE = 20.32e-3
SETTLED = 6.0
"""From so long after the start on errors count [s]."""
QUIET = "0.001 um"
NOISY = "20 um"
TRAPEZOID = "{ table = [" + '["0 s", "0"], ' + ", ".join(
    f'["{t + 2} s", "0"], ["{t + 3} s", "1"], ["{t + 5} s", "1"], ["{t + 6} s", "0"]' for t in (0, 5, 10)
) + "] }"  # fmt: skip
"""The trapezoid of eq. 4.16, corrected."""


class Rows(NamedTuple):
    """What the samples show: true position, reference, estimate, command, errors of the believed pollution."""

    true: np.ndarray
    reference: np.ndarray
    estimate: np.ndarray
    command: np.ndarray
    pollution_error: np.ndarray


def published_text(noise: str = QUIET, seed: int = 1) -> str:
    """The shipped drive, its reference sharp and its lag unknown to the controller, put through the trapezoid."""
    text = change(shipped_systems()["axial-gerotor"], "calibration", lag="0.1 ms")
    text = change(text, "axial_sensor", noise=noise, seed=str(seed))
    text = change(text, "axial_reference", filter_rate="500 1/s")
    return change(change(text, "operation", duty_ratio=TRAPEZOID), "run", until="16 s")


def ideal(text: str) -> str:
    """A drive without dead band, asymmetry and lag, and known as it is."""
    text = change(text, "gerotor", lag="0.1 ms")
    both = {"largest_flow": "1.8 lpm", "forward_dead_band": "0", "backward_dead_band": "0", "backward_gain": "1"}
    return change(change(text, "characteristic", **both), "calibration", **both, straight_flow="0.0001 lpm")


def constant(text: str) -> str:
    """Half of the stroke, held."""
    return change(text, "operation", duty_ratio="0.5")


def lumped(text: str) -> str:
    """The lumped filter tells the position."""
    return change_table(text, "programs.drive.observer", type="lumped-observer", bandwidth="60 rad/s")


def in_time(text: str, frequency: float) -> str:
    """The angle of a clock in place of the spool's: a pollution that is taken to have a frequency [Hz]."""
    text = change_table(text, "nodes.clock", type="driven-shaft", speed=f"{frequency} rev/s")
    return change_table(text, "programs.drive.observer", angle="clock.angle", speed="clock.speed")


def generator(text: str) -> str:
    """The signal generator of 20 states, 2 ms and a spool at 25 Hz."""
    values = {"noise_period": "40 ms", "sensor_deviation": "30 um", "position_drift": "3 um", "generator_drift": "3 um"}
    text = change_table(text, "programs.drive.observer", type="generator-observer", **values)
    text = change(text, "axial_observer", sample_period="2 ms")
    text = change(text, "run", sample_period="2 ms", record_interval="2 ms")
    return change(text, "operation", spool_speed="25 rev/s")


@cache
def rows(text: str) -> Rows:
    """The samples of a run; what is shown of a sample stands in the row of the next."""
    system, run = run_of(text)
    programs = system.circuit.network.programs
    period, near = programs["drive_law"].settings.sample_period, programs["drive_sensor"].settings.near
    at = np.flatnonzero(np.abs(run.times / period % 1.0 - 0.5) > 0.5 - 1e-6)
    at = at[run.times[at] > SETTLED]
    now, after = at[:-1], at[1:]
    seen = run.command.drive_observer
    added = np.array([pollution_at(float(angle), near) for angle in run.state.spool[now]])
    return Rows(
        true=run.state.drive_gerotor.position[now],
        reference=run.command.drive_reference.value[after],
        estimate=seen.position[after],
        command=run.command.drive_law.command[after],
        pollution_error=seen.pollution[after] - added,
    )


def peak(metres: np.ndarray) -> float:
    """Largest error, in per cent of the stroke."""
    return 100.0 * float(np.max(np.abs(metres))) / STROKE


def tracking(text: str) -> float:
    found = rows(text)
    return peak(found.true - found.reference)


def late_tracking(text: str) -> float:
    """The same against the reference of the sample before."""
    found = rows(text)
    return peak(found.true[1:] - found.reference[:-1])


def rms(metres: np.ndarray) -> float:
    return float(np.sqrt(np.mean(metres**2)))


@pytest.mark.thorough
def test_signal_generator_separates():
    """0.077 % here. The published 0.21 % is met against the reference of the sample before: the spool moves 0.20 % of
    its stroke in 2 ms. What is left of the pollution is 5.3 um, of the position 4.7 um rms, over 20 seeds."""
    text = ideal(generator(published_text()))
    assert tracking(text) == pytest.approx(0.077, abs=0.01)
    assert late_tracking(text) == pytest.approx(0.21, rel=0.25)
    found = [rows(ideal(generator(published_text(NOISY, seed)))) for seed in range(1, 21)]
    assert np.mean([rms(each.estimate - each.true) for each in found]) == pytest.approx(4.5e-6, rel=0.15)
    assert np.mean([rms(each.pollution_error) for each in found]) == pytest.approx(4.5e-6, rel=0.25)


def test_oscillation_stops_with_the_periodic_filter():
    """1.13 % with the lumped filter, 0.04 % with the periodic one, 0.11 % against the reference one sample before."""
    text = ideal(published_text())
    assert tracking(lumped(text)) == pytest.approx(1.03, rel=0.25)
    assert tracking(text) == pytest.approx(0.042, abs=0.01)
    assert late_tracking(text) == pytest.approx(0.10, rel=0.25)


def test_dead_band_and_lag_at_the_corners_are_left():
    """1.69 and 1.13 %."""
    text = published_text()
    assert tracking(lumped(text)) == pytest.approx(2.09, rel=0.25)
    assert tracking(text) == pytest.approx(1.26, rel=0.25)


@pytest.mark.thorough
def test_constant_reference_is_held_within_the_dead_band():
    """The estimate is off by 2.35 % with the lumped filter and by 0.06 % with the periodic one, better than the 0.09 %
    published; the command swings by 0.55 and by 0.023, in the mean of 20 seeds, by then at the edge of the dead band
    of 0.08, where the spool creeps."""
    found = rows(lumped(constant(published_text())))
    assert peak(found.estimate - found.reference) == pytest.approx(2.33, rel=0.10)
    assert np.ptp(found.command) == pytest.approx(0.53, rel=0.15)
    held = [rows(constant(published_text(NOISY, seed))) for seed in range(1, 21)]
    assert 0.04 < np.mean([peak(each.estimate - each.reference) for each in held]) < 0.09
    assert np.mean([np.ptp(each.command) for each in held]) == pytest.approx(0.023, rel=0.15)
    assert all(np.min(each.command) > -0.09 and np.max(each.command) < 0.06 for each in held)
    assert all(np.ptp(each.true) < 2e-4 * STROKE and peak(each.true - each.reference) < 0.09 for each in held)


def test_the_spool_itself_swings_less_than_its_estimate():
    """Not as published, 0.57 %: 0.75 %. The straight way through the dead band decides: 0.58 % where it is wide."""
    text = lumped(constant(published_text()))
    swings = []
    for each in (text, change(text, "calibration", straight_flow="0.72 lpm")):
        found = rows(each)
        swings.append(50.0 * np.ptp(found.true) / STROKE)
        assert swings[-1] < 0.4 * 50.0 * np.ptp(found.estimate) / STROKE
    assert swings[0] == pytest.approx(0.75, abs=0.04)
    assert swings[1] == pytest.approx(0.57, rel=0.10)


def test_bias_of_half_a_hertz():
    """Less than the lumped filter leaves: 0.51 % of tracking, 1.5 % of the estimate, 0.235 mm of the pollution."""
    text = ideal(published_text())
    found = rows(in_time(text, 9.5))
    assert peak(found.true - found.reference) == pytest.approx(0.59, rel=0.25)
    assert peak(found.estimate - found.true) == pytest.approx(1.28, rel=0.25)
    assert rms(found.pollution_error) == pytest.approx(0.22e-3, rel=0.10)
    assert tracking(in_time(text, 9.5)) < 0.5 * tracking(lumped(text))


def test_bias_with_too_little_drift_is_worse_than_the_lumped_filter():
    """3.4 against 2.4 %; published 2.38 against 2.33 %."""
    text = change(constant(published_text()), "axial_observer", coefficient_drift="0.15 um")
    found, plain = rows(in_time(text, 9.5)), rows(lumped(constant(published_text())))
    assert peak(found.estimate - found.reference) > peak(plain.estimate - plain.reference)


def test_speed_that_drifts():
    """By 5 % to and fro in 10 s: 0.56 % with the basis in time, 0.038 % with that in the angle."""
    drift = '{ sine = "10 rev/s", amplitude = "0.5 rev/s", frequency = "0.1 Hz" }'
    text = change(change(constant(ideal(published_text())), "operation", spool_speed=drift), "run", until="26 s")
    noisy = change(text, "axial_sensor", noise=NOISY)
    assert tracking(in_time(text, 10.0)) == pytest.approx(0.62, rel=0.25)
    assert tracking(in_time(text, 10.0)) > 0.5
    assert tracking(noisy) == pytest.approx(0.036, rel=0.25)
    assert tracking(noisy) < 0.05


def lines(text: str) -> np.ndarray:
    """Amplitudes of the command at the spool's frequency and at twice that."""
    u = rows(text).command[-8000:]
    found = 2.0 * np.abs(np.fft.rfft(u - np.mean(u))) / u.size
    return found[[80, 160]]


def test_command_has_a_line_at_twice_the_spool_frequency():
    """With the lumped filter, and gone with the periodic one. It is the larger of the two, as published, where the
    second harmonic of the pollution is the largest; with the pollution of the specification it is 30 % of the first."""
    text = constant(published_text(NOISY))
    first, second = lines(lumped(text))
    assert second == pytest.approx(0.30 * first, rel=0.1)
    assert second > 0.05
    assert np.all(lines(text) < 1e-3)
    twice = with_large_second(text)
    assert np.diff(lines(lumped(twice)))[0] > 0.0


def with_large_second(text: str) -> str:
    """The second harmonic the largest."""
    largest = '{ value = ["0.3", "1", "0.30", "0.15", "0.08"] }'
    return change_table(text, "programs.drive.sensor", pollution_amplitudes=largest)
