"""Edges of the pressure wave: known waves, waves of the valve's law with spikes, noise, and simulated ones."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vvdp.base.errors import ParameterError
from vvdp.estimation.pressure_edges import (
    HIGH_SHARE,
    PressureEdges,
    PressureSample,
    followed_plateau,
    pressure_edges,
    pressure_edges_start,
    pressure_edges_step,
)
from vvdp.simulation.replay import Replay
from vvdp.simulation.run import simulate
from vvdp.systems.system import load_system

SETTINGS = pressure_edges()
BAR = 1e5


@pytest.fixture(scope="module")
def edges_replay():
    return Replay(pressure_edges_step, pressure_edges_start(0.0, BAR), PressureSample(0.0, BAR), SETTINGS)


@pytest.fixture(scope="module")
def pressure_edges_of(edges_replay):
    """Times, intervals and polarities of the edges of a wave after `since`, and all that was shown."""

    def run(times, pressures, since=0.0):
        rows = np.column_stack([times, pressures])
        shown = edges_replay(pressure_edges_start(times[0], pressures[0]), rows).shown
        told = shown[(shown[:, 1] > 0.0) & (shown[:, 2] > since)]
        return told[:, 2], told[:, 3], told[:, 4], shown

    return run


def trapezoid(t, period, duty, ramp, low=7.0 * BAR, high=107.0 * BAR):
    """A pulse whose ramps cross the middle at 0 and at duty * period."""
    place = (t + 0.5 * period * (1.0 - duty)) % period - 0.5 * period * (1.0 - duty)
    up, down = 0.5 + place / ramp, 0.5 - (place - duty * period) / ramp
    return low + (high - low) * np.clip(np.where(up < down, up, down), 0.0, 1.0)


def test_a_plateau_by_hand():
    """Up by a share of 0.05 of the step of 100, down by the rest; never beyond the value."""
    assert followed_plateau(1000.0, 2000.0, 0.05, 100.0) == 1005.0
    assert followed_plateau(1000.0, 0.0, 0.05, 100.0) == 905.0
    assert followed_plateau(1000.0, 1001.0, 0.05, 100.0) == 1001.0


def test_a_plateau_settles_at_its_quantile():
    values = np.random.default_rng(1).uniform(0.0, 1.0, 200000)
    plateau, seen = 0.9, []
    for value in values:
        plateau = followed_plateau(plateau, value, 0.3, 2e-3)
        seen.append(plateau)
    # Spread of the follower: variance step q (1 - q)/(2 f) = 2e-3 * 0.21 / 2; correlated over 1/step = 500 values.
    spread = np.sqrt(2e-3 * 0.21 / 2.0)
    assert np.mean(seen[5000:]) == pytest.approx(0.3, abs=4.0 * spread / np.sqrt(195000 / 1000))


def test_ramps_are_timed_by_their_crossing(pressure_edges_of):
    """A ramp over 1 ms, sampled every 0.1 ms: the interpolation is exact, rising at 0, 16, 32 ... ms."""
    t = np.arange(0.0, 2.0, 1e-4)
    times, intervals, polarity, _ = pressure_edges_of(t, trapezoid(t, 16.03e-3, 0.4, 1e-3), since=1.0)
    place = times % 16.03e-3
    # The plateaus, and with them the level, ripple by up to 1 % of the swing, 0.01 ms on this ramp.
    np.testing.assert_allclose((place[polarity > 0.0] + 8e-3) % 16.03e-3 - 8e-3, 0.0, atol=1.5e-5)
    np.testing.assert_allclose(place[polarity < 0.0], 0.4 * 16.03e-3, atol=1.5e-5)
    np.testing.assert_array_equal(polarity[1:], -polarity[:-1])
    np.testing.assert_allclose(intervals, 1e-5, rtol=0.02)  # a tenth of the swing between two samples


def test_a_step_is_known_to_the_sampling_period(pressure_edges_of):
    t = np.arange(0.0, 1.0, 1e-3)
    times, intervals, polarity, _ = pressure_edges_of(t, trapezoid(t, 16.18e-3, 0.4, 1e-5), since=0.5)
    assert np.median(intervals) == pytest.approx(1e-3, rel=1e-6)
    up = times[polarity > 0.0]
    assert np.abs((up + 8e-3) % 16.18e-3 - 8e-3).max() < 1e-3


@settings(max_examples=60, deadline=None)
@given(st.floats(0.15, 0.85), st.floats(6.0, 200.0), st.floats(2.0, 30.0), st.floats(0.0, 1.0))
def test_every_pulse_has_two_edges(pressure_edges_of, duty, swing, low, noise):
    """Whatever the levels, from the least swing on, with noise up to 10 % of the swing and below the least swing."""
    t = np.arange(0.0, 1.2, 1e-3)
    wave = trapezoid(t, 15.3e-3, duty, 1e-3, low * BAR, (low + swing) * BAR)
    top = noise * min(0.1 * swing, 2.0) * BAR
    wave += top * np.random.default_rng(2).standard_normal(t.size).clip(-2.5, 2.5) / 2.5
    times, _, polarity, _ = pressure_edges_of(t, wave)
    assert times.size == pytest.approx(2.0 * (1.2 - 4.0 * SETTINGS.level_time) / 15.3e-3, abs=2.5)
    np.testing.assert_array_equal(polarity[1:], -polarity[:-1])


def test_no_edges_without_a_swing(pressure_edges_of):
    t = np.arange(0.0, 1.0, 1e-3)
    times, *_ = pressure_edges_of(t, 100.0 * BAR + 1.9 * BAR * np.sin(2.0 * np.pi * 60.0 * t))
    assert times.size == 0


def test_invariant_to_start_of_time_and_to_all_levels_shifted(pressure_edges_of):
    t = np.arange(0.0, 1.0, 1e-3)
    wave = trapezoid(t, 15.3e-3, 0.5, 2e-3)
    times, *_ = pressure_edges_of(t, wave)
    later, *_ = pressure_edges_of(t + 64.0, wave + 16.0 * BAR)
    np.testing.assert_allclose(later - 64.0, times, atol=1e-9)


def test_spikes_at_the_relief_setting_are_no_edges(pressure_edges_of):
    """Load 30 bar, relief 120 bar at every transition, spikes to 200 bar: the plateau is found between the spikes."""
    t = np.arange(0.0, 2.0, 1e-3)
    wave = trapezoid(t, 16.18e-3, 0.5, 1e-3, 7.0 * BAR, 37.0 * BAR)
    place = t % 16.18e-3
    for at, top in ((0.2e-3, 200.0), (7.0e-3, 120.0)):
        wave = np.where(abs(place - at - 0.5e-3) < 0.5e-3, top * BAR, wave)
    _, _, polarity, shown = pressure_edges_of(t, wave, since=0.5)
    assert polarity.size == pytest.approx(2.0 * 1.5 / 16.18e-3, abs=2.0)
    assert shown[-1, 7] == pytest.approx(37.0 * BAR, rel=0.05)


def test_levels_follow_a_changed_load(pressure_edges_of):
    """From 100 to 60 bar: no edge is lost or doubled on the way."""
    t = np.arange(0.0, 2.0, 1e-3)
    high = np.where(t < 1.0, 107.0 * BAR, 67.0 * BAR)
    _, _, polarity, shown = pressure_edges_of(t, trapezoid(t, 15.3e-3, 0.5, 1e-3, 7.0 * BAR, high), since=0.5)
    assert polarity.size == pytest.approx(2.0 * 1.5 / 15.3e-3, abs=2.0)
    assert shown[-1, 7] == pytest.approx(67.0 * BAR, rel=0.02)


SIMULATED = {
    "published": [],
    "low load": ["load.pressure=15 bar"],
    "short pulses": ["load.pressure=30 bar", "operation.duty_ratio=0.25"],
    "slow relief valve": [
        "relief_valve.override_pressure=10 bar",
        "relief_valve.opening_time=5 ms",
        "load.pressure=40 bar",
    ],
}


@pytest.mark.parametrize("case", SIMULATED)
@pytest.mark.parametrize("period", [1e-3, 1e-4])
def test_simulated_waves_of_the_prototype_have_two_edges_a_section(pressure_edges_of, case, period):
    """Spikes to 246 bar with the slow relief valve; edges counted against the angle that the spool turned."""
    system = load_system("prototype-constant-load", [*SIMULATED[case], "run.window=1 s"], until="1 s")
    run = simulate(system.model, system.case, system.stepping)
    t = np.arange(0.05, 0.999, period)
    _, _, polarity, _ = pressure_edges_of(t, np.interp(t, run.times, run.state.inlet))
    # The last edge may still wait for its confirmation.
    turned = np.diff(np.interp([0.05 + 4.0 * SETTINGS.level_time, t[-1]], run.times, run.state.spool.angle))[0]
    assert polarity.size == pytest.approx(2.0 * 3.0 * turned / (2.0 * np.pi), abs=1.5)
    np.testing.assert_array_equal(polarity[1:], -polarity[:-1])


def test_compiled_pass_is_the_plain_one(pressure_edges_of):
    t = np.arange(0.0, 0.8, 1e-3)
    wave = trapezoid(t, 15.3e-3, 0.5, 2e-3)
    *_, shown = pressure_edges_of(t, wave)
    memory, plain = pressure_edges_start(t[0], wave[0]), []
    for sample in zip(t.tolist(), wave.tolist(), strict=True):
        memory, told = pressure_edges_step(memory, PressureSample(*sample), SETTINGS)
        plain.append(told)
    np.testing.assert_allclose(shown, plain, rtol=1e-12, atol=1e-12)


def test_settings_that_contradict_are_refused():
    with pytest.raises(ParameterError, match="reaches a plateau"):
        PressureEdges(level_share=0.3, hysteresis=0.3, least_swing=1e5, level_time=0.1)
    with pytest.raises(ParameterError, match="between 0 and 1"):
        PressureEdges(level_share=1.0, hysteresis=0.0, least_swing=1e5, level_time=0.1)
    with pytest.raises(ParameterError, match="must be greater than 0"):
        PressureEdges(level_share=0.5, hysteresis=0.1, least_swing=0.0, level_time=0.1)
    assert 0.0 < HIGH_SHARE < 1.0
