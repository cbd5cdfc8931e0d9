"""The motor of a pump: its ramp, its coast-down."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from vvdp.base.errors import ParameterError
from vvdp.hydraulics.pump_motor import NEAR, PumpMotor, motor_acceleration

MOTOR = PumpMotor(start_time=0.3, coast_time=0.1)


def course(command, first, times, rated=188.5):
    """Speeds over time, by another integrator."""
    found = solve_ivp(
        lambda _, w: [motor_acceleration(command, w[0], rated, MOTOR)],
        (0.0, times[-1]),
        [first],
        t_eval=times,
        rtol=1e-9,
    )
    return found.y[0]


def test_ramp_in_closed_form():
    """Straight up to 98 %, then what is missing falls by e every 2 % of 0.3 s."""
    times = np.linspace(0.0, 0.4, 41)
    end = (1.0 - NEAR) * 0.3
    ramp, rest = times / 0.3, 1.0 - NEAR * np.exp(-(times - end) / (NEAR * 0.3))
    np.testing.assert_allclose(course(1.0, 0.0, times), 188.5 * np.where(times < end, ramp, rest), atol=188.5 * 2e-4)


def test_coast_down_in_closed_form():
    times = np.linspace(0.0, 0.5, 26)
    np.testing.assert_allclose(course(0.0, 188.5, times), 188.5 * np.exp(-times / 0.1), rtol=1e-4)


def test_a_lower_rated_speed_is_followed_down():
    assert course(1.0, 188.5, np.array([0.0, 0.5]), rated=100.0)[-1] == pytest.approx(100.0, rel=1e-6)
    assert motor_acceleration(1.0, 100.0, 0.0, MOTOR) == 0.0


def test_no_motor_is_infinitely_fast():
    with pytest.raises(ParameterError, match="coast_time"):
        PumpMotor(start_time=0.3, coast_time=0.0)
