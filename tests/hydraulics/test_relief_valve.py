import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from vvdp.base.errors import ParameterError
from vvdp.fluid.mixture import fluid_state
from vvdp.hydraulics.flow import passage
from vvdp.hydraulics.relief_valve import (
    LoadReliefValve,
    ReliefValve,
    opened_relief_flow,
    relief_flow,
    relief_mode,
    relief_opening,
    relief_opening_rate,
    setting_fall,
)
from vvdp.hydraulics.volume import closed_volume_rate

RATED = 40e-3 / 60.0
TANK = 1e5


def relief(override, time, reseat=0.0):
    return ReliefValve(
        cracking_pressure=61e5, override_pressure=override, rated_flow=RATED, opening_time=time, reseat_drop=reseat
    )


def mode(pressure, surplus, valve, before=0.0, tank=TANK):
    """The mode in which a valve comes to rest."""
    for _ in range(4):
        found = np.floor(relief_mode(pressure, tank, surplus, before, valve))
        if found == before:
            return found
        before = found
    raise AssertionError("the valve chatters")


def flow_over(pressure, tank, opening, surplus, valve):
    return relief_flow(pressure, tank, opening, surplus, mode(pressure, surplus, valve, tank=tank), valve)


STATIC, SLOW, IDEAL = relief(5e5, 0.0), relief(5e5, 5e-3), relief(0.0, 0.0)


def test_static_by_hand():
    assert flow_over(66e5, TANK, 0.0, 0.0, STATIC) == pytest.approx(RATED, rel=1e-14)
    # half open; root of 62.5/65 bar, transition ((1 + 1e-4)/(1 + 1e-4 (65/62.5)^2))^(1/4)
    share = 62.5 / 65.0
    transition = ((1.0 + 1e-4) / (1.0 + 1e-4 / share**2)) ** 0.25
    assert flow_over(63.5e5, TANK, 0.0, 0.0, STATIC) == pytest.approx(
        0.5 * RATED * np.sqrt(share) * transition, rel=1e-13
    )
    assert flow_over(61e5, TANK, 0.0, 0.0, STATIC) == 0.0
    assert flow_over(20e5, TANK, 1.0, 1.0, STATIC) == 0.0
    assert relief_opening_rate(70e5, 0.3, 1.0, STATIC) == 0.0


def test_first_order_opening_by_hand():
    # (70 - 61)/5 = 1.8; (1.8 - 0.3)/5 ms = 300 1/s
    assert relief_opening_rate(70e5, 0.3, 1.0, SLOW) == pytest.approx(300.0, rel=1e-13)
    assert flow_over(66e5, TANK, 0.25, 0.0, SLOW) == pytest.approx(0.25 * RATED, rel=1e-14)
    # open and the pressure gone: oil comes back, finite and of the right sign
    assert flow_over(0.5e5, TANK, 0.25, 0.0, SLOW) < 0.0
    assert flow_over(TANK, TANK, 0.25, 0.0, SLOW) == 0.0


def test_the_settled_opening_is_the_static_valve():
    for pressure in (50e5, 61e5, 64e5, 80e5):
        open_ = mode(pressure, 0.0, SLOW)
        y = relief_opening(pressure, open_, SLOW)
        assert relief_opening_rate(pressure, y, open_, SLOW) == 0.0
        assert flow_over(pressure, TANK, y, 0.0, SLOW) == flow_over(pressure, TANK, 0.0, 0.0, STATIC)


def test_ideal_by_hand():
    assert flow_over(61e5, TANK, 0.0, 3e-4, IDEAL) == 3e-4
    assert flow_over(61e5, TANK, 0.0, -3e-4, IDEAL) == 0.0
    assert flow_over(60e5, TANK, 0.0, 3e-4, IDEAL) == 0.0


def test_the_ideal_valve_opens_with_pressure_and_surplus_and_shuts_without_surplus():
    assert mode(60e5, 3e-4, IDEAL) == 0.0 and mode(61.1e5, -3e-4, IDEAL) == 0.0 and mode(61.1e5, 3e-4, IDEAL) == 1.0
    assert mode(61e5 - 1.0, 3e-4, IDEAL, before=1.0) == 1.0  # a hair below, where the step ended that shut it
    assert mode(61e5, -1e-9, IDEAL, before=1.0) == 0.0
    assert mode(61.1e5, 3e-4, IDEAL, before=1.0, tank=70e5) == 0.0  # nothing to a side under a higher pressure


def test_a_valve_that_reseats_below_its_cracking_pressure():
    """By hand: open at 61 bar it stands at 6/(5 + 6) of its rated opening, and it shuts at 55 bar only."""
    valve = relief(5e5, 0.0, reseat=6e5)
    assert mode(60e5, 0.0, valve) == 0.0 and mode(61e5, 0.0, valve) == 1.0
    assert mode(56e5, 0.0, valve, before=1.0) == 1.0 and mode(54.9e5, 0.0, valve, before=1.0) == 0.0
    assert relief_opening(61e5, 1.0, valve) == pytest.approx(6.0 / 11.0, rel=1e-14)
    assert relief_opening(66e5, 1.0, valve) == pytest.approx(1.0, rel=1e-14)
    assert relief_opening(60e5, 0.0, valve) == 0.0


def test_a_stiff_static_valve_goes_over_into_the_ideal_one():
    for override in (1e5, 1e3, 1e1):
        stiff = relief(override, 0.0)
        held = brentq(lambda p, v=stiff: flow_over(p, TANK, 0.0, 0.0, v) - 3e-4, 61e5, 70e5, xtol=1e-6)
        assert 0.0 < held - 61e5 < override  # less than its rated flow: less than its override


def test_the_ideal_valve_holds_its_setting_and_lets_go(oil):
    """Fill and empty a volume: the pressure stays at the setting, off by no more than the step that found it."""

    def rates(t, y):
        fluid = fluid_state(y[0], oil)
        q = 6e-4 * np.cos(40.0 * t)
        surplus = fluid.volume_ratio * q
        gone = passage(flow_over(y[0], TANK, 0.0, surplus, IDEAL), fluid, fluid_state(TANK, oil))
        return [closed_volume_rate(q - gone.flow, 0.0, 1e-3, fluid)]

    run = solve_ivp(rates, (0.0, 0.07), [50e5], rtol=1e-9, atol=1e-3, max_step=1e-4)
    assert run.status == 0
    assert run.y[0].max() == pytest.approx(61e5, rel=1e-5)
    assert run.y[0, -1] < 60e5  # the flow has reversed: it follows at once


@given(pressure=st.floats(0.0, 2e8), opening=st.floats(0.0, 3.0), surplus=st.floats(-1e-2, 1e-2))
def test_always_finite_and_passive(oil, pressure, opening, surplus):
    for valve in (STATIC, SLOW, IDEAL):
        flow = flow_over(pressure, TANK, opening, surplus, valve)
        through = passage(flow, fluid_state(pressure, oil), fluid_state(TANK, oil))
        # A surplus below 1e-16 of the rated flow counts as none, whatever its sign.
        assert np.isfinite(flow) and through.loss >= -2e-16 * RATED * pressure
        assert np.isfinite(relief_opening_rate(pressure, opening, 1.0, valve))
    above_setting = flow_over(pressure, 3e7, opening, surplus, SLOW)
    assert np.isfinite(above_setting) and above_setting * (pressure - 3e7) >= 0.0


def test_contradictions_are_refused():
    with pytest.raises(ParameterError, match=r"opening_time: .* must be 0 if override_pressure is 0"):
        relief(0.0, 1e-3)
    with pytest.raises(ParameterError, match=r"reseat_drop: .* must be 0 if override_pressure is 0"):
        relief(0.0, 0.0, reseat=1e5)
    with pytest.raises(ParameterError, match=r"reseat_drop: .* must be less than cracking_pressure"):
        relief(5e5, 0.0, reseat=61e5)
    with pytest.raises(ParameterError, match="rated_flow"):
        ReliefValve(cracking_pressure=61e5, override_pressure=5e5, rated_flow=0.0, opening_time=0.0)
    with pytest.raises(ParameterError, match="cracking_pressure"):
        ReliefValve(cracking_pressure=0.0, override_pressure=5e5, rated_flow=RATED, opening_time=0.0)


@pytest.mark.parametrize(("load", "setting"), [(0.0, 30e5), (10e5, 30e5), (25e5, 45e5), (50e5, 60e5)])
def test_a_setting_follows_the_load_between_its_ends(load, setting):
    """20 bar above the load, from 30 bar on and up to the cracking pressure of 60."""
    relief = LoadReliefValve(
        cracking_pressure=60e5, override_pressure=5e5, rated_flow=40.0 / 60e3, margin=20e5, least_pressure=30e5
    )
    fall = setting_fall(load, relief)
    assert relief.cracking_pressure - fall == pytest.approx(setting)
    assert relief_mode(setting - 1.0 + fall, 0.0, 0.0, 0.0, relief) < 1.0
    assert relief_mode(setting + 1.0 + fall, 0.0, 0.0, 0.0, relief) >= 1.0
    # Fully open at the override it passes what the opening does at that drop: Q_r root(setting + 5 bar)/root(65 bar)
    y = relief_opening(setting + 5e5 + fall, 1.0, relief)
    flow = opened_relief_flow(setting + 5e5, 0.0, y, relief)
    assert (y, flow) == pytest.approx((1.0, relief.rated_flow * np.sqrt((setting + 5e5) / 65e5)), rel=1e-3)


def test_a_relief_valve_that_follows_needs_an_override():
    with pytest.raises(ParameterError, match="override_pressure: 0 bar must be greater than 0"):
        LoadReliefValve(
            cracking_pressure=60e5, override_pressure=0.0, rated_flow=1e-3, margin=20e5, least_pressure=30e5
        )
