"""The tracking loop: its linear part against scipy.signal, the counting detector, rest."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import signal

from vvdp.base.errors import ParameterError
from vvdp.estimation.baselines.tracking_loop import (
    Tracked,
    correct,
    tracking_loop,
    tracking_loop_estimator,
)
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import equal_wheel
from vvdp.simulation.replay import Replay

WHEEL = equal_wheel(8)
SECTOR, TURN = np.pi / 4.0, 2.0 * np.pi
BANDWIDTH, H = 50.0, 1e-3


@pytest.fixture(scope="module")
def replay():
    found = tracking_loop_estimator(tracking_loop(WHEEL))
    return Replay(found.step, found.memory, Reading(0.0, 0.0, 0.0, 0.0, 0.0), found.settings)


def linear(angles, bandwidth, h):
    """What the loop makes of angles that it is given, not counted."""
    reached, shown = Tracked(0.0, 0.0), []
    for angle in angles:
        predicted = Tracked(reached.angle + h * reached.speed, reached.speed)
        reached = correct(predicted, angle - predicted.angle, h, bandwidth)
        shown.append(reached)
    return np.array(shown)


def filters(bandwidth, h):
    """Transfer functions from angle to angle and speed, (numerator, denominator) in 1/z."""
    _, poles, _ = signal.cont2discrete(([2.0 * bandwidth, bandwidth**2], [1.0, 2.0 * bandwidth, bandwidth**2]), h)
    _, minus_two_z, z_squared = poles
    a, b = 1.0 - z_squared, 1.0 + minus_two_z + z_squared  # of an alpha-beta filter with these poles
    return ([a, b - a, 0.0], poles), ([b / h, -b / h, 0.0], poles)


def test_one_step_by_hand():
    """b h = ln 2: z = 1/2. theta = 1 + 0.75 x 0.2 = 1.15, omega = 3 + 0.25 x 0.2 / 0.01 = 8."""
    found = correct(Tracked(1.0, 3.0), 0.2, 0.01, 100.0 * np.log(2.0))
    assert found == pytest.approx((1.15, 8.0))


@pytest.mark.parametrize("bandwidth", [5.0, 50.0, 3000.0])
def test_linear_part_has_the_poles_of_the_continuous_loop(bandwidth):
    """Against scipy's filter with the denominator that scipy's discretisation finds; also where b h = 3."""
    angles = np.cumsum(np.random.default_rng(1).normal(size=400))
    found = linear(angles, bandwidth, H)
    for column, (numerator, denominator) in zip(found.T, filters(bandwidth, H), strict=True):
        np.testing.assert_allclose(column, signal.lfilter(numerator, denominator, angles), rtol=1e-8, atol=1e-8)


def test_step_response_tends_to_the_continuous_one_to_first_order():
    """(2 b s + b^2)/(s + b)^2 of scipy.signal.step; twice as many samples, half the error."""
    off = []
    for h in (1e-3, 5e-4, 2.5e-4):
        times = h * np.arange(round(0.2 / h) + 1)
        _, wanted = signal.step(([2.0 * BANDWIDTH, BANDWIDTH**2], [1.0, 2.0 * BANDWIDTH, BANDWIDTH**2]), T=times)
        np.testing.assert_allclose(wanted, 1.0 - np.exp(-BANDWIDTH * times) * (1.0 - BANDWIDTH * times), atol=1e-9)
        off.append(np.abs(linear(np.ones(times.size - 1), BANDWIDTH, h)[:, 0] - wanted[1:]).max())
    np.testing.assert_allclose([off[0] / off[1], off[1] / off[2]], 2.0, rtol=0.05)


def test_small_steps_are_those_of_the_gains_2b_and_b_squared():
    found = correct(Tracked(0.0, 0.0), 1.0, 1e-6, BANDWIDTH)
    assert found.angle / 1e-6 == pytest.approx(2.0 * BANDWIDTH, rel=1e-4)
    assert found.speed / 1e-6 == pytest.approx(BANDWIDTH**2, rel=1e-4)


def test_an_even_speed_is_followed_without_lag():
    found = linear(155.0 * H * np.arange(1, 1001), BANDWIDTH, H)
    assert found[-1] == pytest.approx((155.0, 155.0), rel=1e-9)


@pytest.mark.parametrize("motion", ["jump", "start"])
def test_counting_stays_within_a_sector_s_worth_of_the_linear_response(replay, motion):
    """The counted error is that of the last edge, and up to a sector more: its effect is at most sector x sum |g|."""
    times = H * np.arange(1, 121)
    numbers = np.full(120, 400.0) if motion == "jump" else np.floor(155.0 * times / SECTOR)
    rows = np.column_stack([times, np.diff(numbers, prepend=0.0), times, 0.0 * times, 0.0 * times])
    found = tracking_loop_estimator(tracking_loop(WHEEL, BANDWIDTH))
    shown = replay(found.memory, rows).shown
    impulse = np.zeros(2000)
    impulse[0] = 1.0
    for column, (numerator, denominator) in enumerate(filters(BANDWIDTH, H)):
        wanted = signal.lfilter(numerator, denominator, SECTOR * numbers)
        reach = SECTOR * np.abs(signal.lfilter(numerator, denominator, impulse)).sum()
        off = np.abs(shown[:, column] - wanted)
        assert off.max() <= reach
        assert off.max() < 0.25 * np.abs(wanted).max()


@pytest.mark.parametrize("frequency", [10.3, 24.7, 39.1])
def test_mean_speed_is_true(replay, sampled_edges, frequency):
    """What the loop adds to the angle is h omega^ + (1 - z^2) e, to the speed (1 - z)^2 e / h, and neither runs away.

    So the means of omega^ and omega differ by at most
    (range of the angle error + range of omega^ h (1 + z)/(1 - z)) / T.
    """
    times = H * np.arange(4001)
    angles = 0.2 + TURN * frequency * times
    found = tracking_loop_estimator(tracking_loop(WHEEL), 0.0, 0.2, TURN * frequency)
    shown = replay(found.memory, sampled_edges(WHEEL.edges, times, angles)).shown[1000:]
    z = np.exp(-BANDWIDTH * H)
    slack = np.ptp(shown[:, 0] - angles[1000:]) + np.ptp(shown[:, 1]) * H * (1.0 + z) / (1.0 - z)
    assert abs(np.mean(shown[:, 1]) - TURN * frequency) <= slack / 3.0 + 1e-9
    assert np.abs(shown[:, 0] - angles[1000:]).max() < 0.5 * SECTOR


def test_a_stopped_shaft_comes_to_rest_in_its_sector(replay, sampled_edges):
    times = H * np.arange(2001)
    angles = 155.0 * times.clip(max=0.1)
    found = tracking_loop_estimator(tracking_loop(WHEEL))
    shown = replay(found.memory, sampled_edges(WHEEL.edges, times, angles)).shown
    assert not shown[1000:, 1].any()
    assert abs(shown[-1, 0] - 15.5) < SECTOR
    assert np.ptp(shown[1000:, 0]) == 0.0


def test_the_start_is_followed_until_the_count_objects(stepped):
    """No edge, 20 rad/s: the first sector of 0.785 rad is left at 39.3 ms."""
    times = H * np.arange(1, 200)
    rows = np.column_stack([times, *[0.0 * times] * 4])
    shown, _ = stepped(tracking_loop_estimator(tracking_loop(WHEEL), 0.0, 0.0, 20.0), rows)
    np.testing.assert_allclose(shown[:39, 1], 20.0)
    assert (shown[39:, 1] < 20.0).all()
    assert np.isnan(shown[:, 2:4]).all()
    assert np.isfinite(shown[:, [0, 1, 4, 5, 6]]).all()


def test_a_second_sample_at_the_same_time_changes_nothing(stepped):
    found = tracking_loop_estimator(tracking_loop(WHEEL), 1.0, 0.1, 20.0)
    shown, _ = stepped(found, np.array([[1.0, 0.0, 0.0, 0.0, 0.0]]))
    assert tuple(shown[0, :2]) == (0.1, 20.0)


def test_compiled_is_plain(replay, sampled_edges, stepped):
    times = H * np.arange(600)
    rows = sampled_edges(WHEEL.edges, times, 0.3 + 150.0 * times + 50.0 * times**2)
    found = tracking_loop_estimator(tracking_loop(WHEEL))
    np.testing.assert_allclose(replay(found.memory, rows).shown, stepped(found, rows)[0], rtol=1e-10)


def test_no_bandwidth_is_refused():
    with pytest.raises(ParameterError, match="0 rad/s"):
        replace(tracking_loop(WHEEL), bandwidth=0.0)
