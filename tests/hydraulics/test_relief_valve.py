import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from vvdp.base.errors import ParameterError
from vvdp.fluid.mixture import fluid_state
from vvdp.hydraulics.flow import passage
from vvdp.hydraulics.relief_valve import ReliefValve, relief_flow, relief_opening, relief_opening_rate
from vvdp.hydraulics.volume import closed_volume_rate

RATED = 40e-3 / 60.0
TANK = 1e5


def relief(override, time):
    return ReliefValve(cracking_pressure=61e5, override_pressure=override, rated_flow=RATED, opening_time=time)


STATIC, SLOW, IDEAL = relief(5e5, 0.0), relief(5e5, 5e-3), relief(0.0, 0.0)


def test_static_by_hand():
    assert relief_flow(66e5, TANK, 0.0, 0.0, STATIC) == pytest.approx(RATED, rel=1e-14)
    # half open; root of 62.5/65 bar, transition ((1 + 1e-4)/(1 + 1e-4 (65/62.5)^2))^(1/4)
    share = 62.5 / 65.0
    transition = ((1.0 + 1e-4) / (1.0 + 1e-4 / share**2)) ** 0.25
    assert relief_flow(63.5e5, TANK, 0.0, 0.0, STATIC) == pytest.approx(
        0.5 * RATED * np.sqrt(share) * transition, rel=1e-13
    )
    assert relief_flow(61e5, TANK, 0.0, 0.0, STATIC) == 0.0
    assert relief_flow(20e5, TANK, 1.0, 1.0, STATIC) == 0.0
    assert relief_opening_rate(70e5, 0.3, STATIC) == 0.0


def test_first_order_opening_by_hand():
    # (70 - 61)/5 = 1.8; (1.8 - 0.3)/5 ms = 300 1/s
    assert relief_opening_rate(70e5, 0.3, SLOW) == pytest.approx(300.0, rel=1e-13)
    assert relief_flow(66e5, TANK, 0.25, 0.0, SLOW) == pytest.approx(0.25 * RATED, rel=1e-14)
    # open and the pressure gone: oil comes back, finite and of the right sign
    assert relief_flow(0.5e5, TANK, 0.25, 0.0, SLOW) < 0.0
    assert relief_flow(TANK, TANK, 0.25, 0.0, SLOW) == 0.0


def test_the_settled_opening_is_the_static_valve():
    for pressure in (50e5, 61e5, 64e5, 80e5):
        y = relief_opening(pressure, SLOW)
        assert relief_opening_rate(pressure, y, SLOW) == 0.0
        assert relief_flow(pressure, TANK, y, 0.0, SLOW) == relief_flow(pressure, TANK, 0.0, 0.0, STATIC)


def test_ideal_by_hand():
    assert relief_flow(61e5, TANK, 0.0, 3e-4, IDEAL) == 3e-4
    assert relief_flow(61e5, TANK, 0.0, -3e-4, IDEAL) == 0.0
    assert relief_flow(60e5, TANK, 0.0, 3e-4, IDEAL) == 0.0


def test_a_stiff_static_valve_goes_over_into_the_ideal_one():
    for override in (1e5, 1e3, 1e1):
        stiff = relief(override, 0.0)
        held = brentq(lambda p, v=stiff: relief_flow(p, TANK, 0.0, 0.0, v) - 3e-4, 61e5, 70e5, xtol=1e-6)
        assert 0.0 < held - 61e5 < override  # less than its rated flow: less than its override


def test_the_ideal_valve_holds_its_setting_and_lets_go(oil):
    """Fill and empty a volume: the pressure stays at the setting, off by no more than the step that found it."""

    def rates(t, y):
        fluid = fluid_state(y[0], oil)
        q = 6e-4 * np.cos(40.0 * t)
        surplus = fluid.volume_ratio * q
        gone = passage(relief_flow(y[0], TANK, 0.0, surplus, IDEAL), fluid, fluid_state(TANK, oil))
        return [closed_volume_rate(q - gone.flow, 0.0, 1e-3, fluid)]

    run = solve_ivp(rates, (0.0, 0.07), [50e5], rtol=1e-9, atol=1e-3, max_step=1e-4)
    assert run.status == 0
    assert run.y[0].max() == pytest.approx(61e5, rel=1e-5)
    assert run.y[0, -1] < 60e5  # the flow has reversed: it follows at once


@given(pressure=st.floats(0.0, 2e8), opening=st.floats(0.0, 3.0), surplus=st.floats(-1e-2, 1e-2))
def test_always_finite_and_passive(oil, pressure, opening, surplus):
    for valve in (STATIC, SLOW, IDEAL):
        flow = relief_flow(pressure, TANK, opening, surplus, valve)
        through = passage(flow, fluid_state(pressure, oil), fluid_state(TANK, oil))
        assert np.isfinite(flow) and through.loss >= 0.0
        assert np.isfinite(relief_opening_rate(pressure, opening, valve))
    above_setting = relief_flow(pressure, 3e7, opening, surplus, SLOW)
    assert np.isfinite(above_setting) and above_setting * (pressure - 3e7) >= 0.0


def test_contradictions_are_refused():
    with pytest.raises(ParameterError, match="contradicts opening_time"):
        relief(0.0, 1e-3)
    with pytest.raises(ParameterError, match="rated_flow"):
        ReliefValve(cracking_pressure=61e5, override_pressure=5e5, rated_flow=0.0, opening_time=0.0)
    with pytest.raises(ParameterError, match="cracking_pressure"):
        ReliefValve(cracking_pressure=0.0, override_pressure=5e5, rated_flow=RATED, opening_time=0.0)
