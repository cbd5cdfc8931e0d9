"""Truth in closed form."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from tests.words import wording

from vvdp.base.errors import ParameterError
from vvdp.comparison.motion import Lag, Ramps, Ripple, steady

SPEEDS = st.floats(-200.0, 200.0)


def test_by_hand():
    """From 0 to 100 rad/s with 0.1 s: one time constant after the change 100 (1 - 1/e) = 63.212 rad/s, and
    100 (0.1 - 0.1 (1 - 1/e)) = 10/e = 3.6788 rad."""
    motion = Lag(0.0, 100.0, 0.5, 0.1)
    assert motion.speed(np.array([0.2, 0.5, 0.6])) == pytest.approx([0.0, 0.0, 63.21206], rel=1e-6)
    assert motion.angle(np.array([0.2, 0.5, 0.6])) == pytest.approx([0.0, 0.0, 3.678794], rel=1e-6)


@given(SPEEDS, SPEEDS, st.floats(0.0, 2.0), st.floats(0.01, 1.0), st.floats(0.0, 4.0))
def test_the_angle_is_the_integral_of_the_speed(before, after, at, constant, end):
    motion = Lag(before, after, at, constant)
    found, _ = quad(lambda t: float(motion.speed(np.array([t]))[0]), 0.0, end, points=[at], epsabs=1e-9, limit=200)
    assert motion.angle(np.array([end]))[0] == pytest.approx(found, abs=1e-6)


def test_the_acceleration_is_the_slope_of_the_speed():
    motion, times = Lag(70.0, 150.0, 1.0, 0.03), np.array([0.3, 1.01, 1.2])
    slope = (motion.speed(times + 1e-6) - motion.speed(times - 1e-6)) / 2e-6
    assert motion.acceleration(times) == pytest.approx(slope, rel=1e-6, abs=1e-9)


def test_steady_is_steady():
    motion = steady(150.0)
    assert motion.step is None
    times = np.linspace(0.0, 5.0, 11)
    assert motion.speed(times) == pytest.approx(150.0)
    assert motion.angle(times) == pytest.approx(150.0 * times)


def test_a_ripple_by_hand():
    """By 0.6 once a turn about 10 rad/s, k = 2: from 10 (1 + 0.6)/0.8 = 20 rad/s at angle 0 to 5 rad/s at half a turn,
    and at a quarter of the period, s = pi/4, the angle is 2 atan 2 = 2.2143 rad, cos = -0.6: 10 (1 - 0.36)/0.8 = 8."""
    motion, period = Ripple(10.0, 0.6, 1.0), 2.0 * np.pi / 10.0
    at = period * np.array([0.0, 0.25, 0.5, 1.0, 7.0])
    assert motion.angle(at) == pytest.approx([0.0, 2.214297, np.pi, 2 * np.pi, 14 * np.pi], rel=1e-6)
    assert motion.speed(at) == pytest.approx([20.0, 8.0, 5.0, 20.0, 20.0], rel=1e-6)
    assert motion.travel(at) == pytest.approx(motion.angle(at))


@given(st.floats(1.0, 200.0), st.floats(0.0, 0.5), st.integers(1, 8), st.floats(0.0, 0.5))
def test_the_angle_of_a_ripple_is_the_integral_of_its_speed(mean, share, per_turn, end):
    motion = Ripple(mean, share, float(per_turn))
    times = np.linspace(0.0, end, 20001)
    speed = motion.speed(times)
    found = np.sum(0.5 * (speed[1:] + speed[:-1]) * np.diff(times))
    assert motion.angle(np.array([end]))[0] == pytest.approx(found, rel=1e-5, abs=1e-6)


def test_a_stop_by_hand():
    """155 rad/s for 2 s, down to rest within 50 ms: 310 + 155 0.025 = 313.875 rad; as much again while it restarts at
    4 s, so that at 5 s it has come to 313.875 + 3.875 + 155 0.95 = 465.0 rad."""
    motion = Ramps((0.0, 2.0, 2.05, 4.0, 4.05), (155.0, 155.0, 0.0, 0.0, 155.0))
    at = np.array([1.0, 2.025, 3.0, 5.0])
    assert motion.speed(at) == pytest.approx([155.0, 77.5, 0.0, 155.0])
    assert motion.angle(at) == pytest.approx([155.0, 310.0 + 0.025 * 116.25, 313.875, 465.0])
    assert motion.travel(at) == pytest.approx(motion.angle(at))


def test_a_reversal_by_hand():
    """100 rad/s for 1 s, to -100 within 1 s: it turns at 1.5 s, 125 rad on, is back at 100 at 2 s and at 0 at 3 s."""
    motion, at = Ramps((0.0, 1.0, 2.0), (100.0, 100.0, -100.0)), np.array([1.0, 1.5, 2.0, 3.0])
    assert motion.angle(at) == pytest.approx([100.0, 125.0, 100.0, 0.0])
    assert motion.travel(at) == pytest.approx([100.0, 125.0, 150.0, 250.0])


def test_a_reversal_to_another_speed_turns_where_its_line_crosses_zero():
    """From 100 to -50 rad/s within 1.5 s: 50 rad within the first second, 12.5 back within the rest."""
    motion = Ramps((0.0, 1.5), (100.0, -50.0))
    assert motion.angle(np.array([1.5])) == pytest.approx([37.5])
    assert motion.travel(np.array([1.0, 1.5, 2.5])) == pytest.approx([50.0, 62.5, 112.5])


def test_what_the_flow_alone_would_do():
    assert Ripple(10.0, 0.6, 1.0).by_flow == steady(10.0)
    assert Ramps((0.0, 1.0, 2.0), (100.0, 100.0, -100.0)).by_flow == steady(100.0)
    step = Lag(70.0, 150.0, 1.0, 0.03)
    assert step.by_flow is step is step.step


@pytest.mark.parametrize(
    ("motion", "told"),
    [
        (lambda: Lag(0.0, 1.0, 0.0, 0.0), wording.compare.time_constant.format(value="0 ms")),
        (lambda: Ripple(10.0, 1.0, 3.0), wording.compare.ripple_by.format(amplitude=1)),
        (lambda: Ramps((0.5, 1.0), (1.0, 2.0)), wording.compare.times_increase),
    ],
)
def test_motions_that_cannot_be_are_refused(motion, told):
    with pytest.raises(ParameterError, match=told):
        motion()
