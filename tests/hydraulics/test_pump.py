from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from vvdp.base.errors import ParameterError
from vvdp.fluid.mixture import FluidState, fluid_state
from vvdp.hydraulics.pump import Pump, against, delivery, is_ideal, pump_friction_power, tank_displacement

PUMP = Pump(
    displacement=22.8e-6 / (2.0 * np.pi),
    leakage_conductance=2e-12,
    ripple_amplitude=0.03,
    ripple_count=10.0,
    friction_torque=1.5,
)


TANK = FluidState(1e5, 1.0, 1e9, 0.0)


def test_pump_by_hand():
    # 22.8 cc/rev * 30 rev/s
    assert tank_displacement(0.0, TANK, PUMP) * 2.0 * np.pi * 30.0 == pytest.approx(6.84e-4, rel=1e-14)
    crest = tank_displacement(np.pi / 20.0, TANK, PUMP)  # 10 * pi/20 = pi/2
    assert crest * 2.0 * np.pi * 30.0 == pytest.approx(6.84e-4 * 1.03, rel=1e-14)
    boosted = tank_displacement(0.0, FluidState(1e6, 0.8, 1e9, 2e6), PUMP)  # 1/0.8 more mass in the same volume
    assert boosted == pytest.approx(1.25 * 22.8e-6 / (2.0 * np.pi), rel=1e-14)


def test_ripple_leaves_the_mean():
    mean, _ = quad(lambda angle: tank_displacement(angle, TANK, PUMP), 0.0, 2.0 * np.pi, limit=200)
    assert mean == pytest.approx(22.8e-6, rel=1e-10)  # one revolution displaces 22.8 cc


def test_friction_by_hand():
    assert pump_friction_power(-200.0, PUMP) == pump_friction_power(200.0, PUMP) == 300.0  # 1.5 N m * 200 rad/s
    assert [against(1.5, w) for w in (-3.0, 0.0, 1e-9)] == [-1.5, 0.0, 1.5]
    assert all(against(1.5, w) * w == pump_friction_power(w, PUMP) for w in (-3.0, 0.0, 7.0))


BARE = Pump(displacement=25e-6 / (2.0 * np.pi), leakage_conductance=0.0, friction_torque=0.0)


def chambers(**changed: float) -> Pump:
    """A pump without ripple, leakage and friction."""
    return replace(BARE, **changed)


def test_what_the_chambers_take_by_hand():
    """Oil of constant modulus, nu = 1 - P/beta: 99 bar over 1.4 GPa."""
    inlet, rise = FluidState(0.0, 1.0, 1.4e9, 0.0), 99e5
    outlet = FluidState(rise, 1.0 - rise / 1.4e9, 1.4e9, rise - 0.5 * rise**2 / 1.4e9)
    pump = chambers(precompression=0.0, dead_volume=5e-6 / (2.0 * np.pi))
    d = delivery(0.0, inlet, outlet, pump).displacement
    # 5 cc hold 5 * 99e5/1.4e9/(1 - 0.0070714) = 0.0356090 cc more under pressure
    assert d * 2.0 * np.pi == pytest.approx(25e-6 - 0.0356090e-6, rel=1e-8)
    # per revolution 25e-6 * 99e5 = 247.5 J of work; 24.964391e-6 * (99e5 - 35003.57) = 246.273629 J into the oil
    assert delivery(0.0, inlet, outlet, pump).unused_torque * 2.0 * np.pi == pytest.approx(1.226371, rel=1e-6)
    # V P^2/(2 beta) with the 25 cc swept, and twice the 5 cc: filled once, emptied once
    estimate = 35e-6 * rise**2 / 2.8e9
    assert delivery(0.0, inlet, outlet, pump).unused_torque * 2.0 * np.pi == pytest.approx(estimate, rel=0.01)


@given(low=st.floats(2e4, 3e7), high=st.floats(2e4, 3e7), air=st.floats(0.0, 0.2), c=st.floats(0.0, 1.0))
def test_joining_chambers_only_loses(oil, low, high, air, c):
    mixture = replace(oil, air_fraction=air)
    inlet, outlet = fluid_state(low, mixture), fluid_state(high, mixture)
    pump = chambers(precompression=c, dead_volume=0.3 * BARE.displacement)
    d = delivery(0.0, inlet, outlet, pump).displacement
    assert d >= 0.0
    # rounding: a few ulp of the work
    assert delivery(0.0, inlet, outlet, pump).unused_torque >= -1e-12 * BARE.displacement * max(low, high)
    full = delivery(0.0, inlet, outlet, replace(pump, precompression=0.0)).unused_torque
    assert delivery(0.0, inlet, outlet, pump).unused_torque == pytest.approx((1.0 - c) * full, rel=1e-12, abs=1e-300)


def test_the_loss_is_the_indicated_work_less_what_the_oil_gained(oil):
    """The diagram of a chamber that is joined at once, its areas taken one by one."""
    inlet, outlet = fluid_state(101325.0, oil), fluid_state(150e5, oil)
    V, dead = 2.5e-6, 0.6e-6  # of one of ten chambers
    pump = chambers(precompression=0.0, dead_volume=10.0 * dead / (2.0 * np.pi))
    filled, left = (V + dead) / inlet.volume_ratio, dead / outlet.volume_ratio  # tank volumes
    work = V * (outlet.pressure - inlet.pressure)
    lost = work - (filled - left) * (outlet.enthalpy - inlet.enthalpy)
    d = delivery(0.0, inlet, outlet, pump).displacement
    assert d * 2.0 * np.pi == pytest.approx(10.0 * (filled - left), rel=1e-13)
    assert delivery(0.0, inlet, outlet, pump).unused_torque * 2.0 * np.pi == pytest.approx(10.0 * lost, rel=1e-9)


def test_a_dead_volume_that_takes_all_stops_the_flow(oil):
    soft = replace(oil, air_fraction=0.3)
    inlet, outlet = fluid_state(101325.0, soft), fluid_state(3e7, soft)
    assert delivery(0.0, inlet, outlet, chambers(dead_volume=10.0 * BARE.displacement)).displacement == 0.0


def test_an_ideal_pump_is_the_plain_one(oil):
    inlet, outlet = fluid_state(101325.0, oil), fluid_state(150e5, oil)
    assert is_ideal(BARE) and not is_ideal(chambers(dead_volume=1e-9)) and not is_ideal(chambers(precompression=0.9))
    assert delivery(0.0, inlet, outlet, BARE) == (tank_displacement(0.0, inlet, BARE), 0.0)


@pytest.mark.parametrize("name", ["friction_torque", "dead_volume", "precompression"])
def test_what_would_give_power_is_refused(name):
    with pytest.raises(ParameterError, match=name):
        chambers(**{name: -1e-9})
