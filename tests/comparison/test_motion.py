"""Truth in closed form."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from vvdp.base.errors import ParameterError
from vvdp.comparison.motion import Motion, steady

SPEEDS = st.floats(-200.0, 200.0)


def test_by_hand():
    """From 0 to 100 rad/s with 0.1 s: one time constant after the change 100 (1 - 1/e) = 63.212 rad/s, and
    100 (0.1 - 0.1 (1 - 1/e)) = 10/e = 3.6788 rad."""
    motion = Motion(0.0, 100.0, 0.5, 0.1)
    assert motion.speed(np.array([0.2, 0.5, 0.6])) == pytest.approx([0.0, 0.0, 63.21206], rel=1e-6)
    assert motion.angle(np.array([0.2, 0.5, 0.6])) == pytest.approx([0.0, 0.0, 3.678794], rel=1e-6)


@given(SPEEDS, SPEEDS, st.floats(0.0, 2.0), st.floats(0.01, 1.0), st.floats(0.0, 4.0))
def test_the_angle_is_the_integral_of_the_speed(before, after, at, constant, end):
    motion = Motion(before, after, at, constant)
    found, _ = quad(lambda t: float(motion.speed(np.array([t]))[0]), 0.0, end, points=[at], epsabs=1e-9, limit=200)
    assert motion.angle(np.array([end]))[0] == pytest.approx(found, abs=1e-6)


def test_the_acceleration_is_the_slope_of_the_speed():
    motion, times = Motion(70.0, 150.0, 1.0, 0.03), np.array([0.3, 1.01, 1.2])
    slope = (motion.speed(times + 1e-6) - motion.speed(times - 1e-6)) / 2e-6
    assert motion.acceleration(times) == pytest.approx(slope, rel=1e-6, abs=1e-9)


def test_steady_is_steady():
    motion = steady(150.0)
    assert not motion.changes
    times = np.linspace(0.0, 5.0, 11)
    assert motion.speed(times) == pytest.approx(150.0)
    assert motion.angle(times) == pytest.approx(150.0 * times)


def test_a_lag_without_a_time_is_refused():
    with pytest.raises(ParameterError, match="time constant of 0 s"):
        Motion(0.0, 1.0, 0.0, 0.0)
