"""Control of a variable pump, and a metering throttle behind its compensator."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from vvdp.base.errors import ParameterError
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.compensated_throttle import (
    CompensatedThrottle,
    compensator_rate,
    compensator_side,
    flow_opening,
    metering_share,
)
from vvdp.hydraulics.pump import Pump, delivery
from vvdp.hydraulics.variable_pump import PumpControl, held_level, swivel_rate, swivel_share, swivel_side

CONTROL = PumpControl(margin=20e5, highest_pressure=110e5, proportional_band=100e5, reset_time=0.01)
THROTTLE = CompensatedThrottle(
    conductance=8e-7,
    compensator_conductance=1.2e-6,
    metering_drop=7e5,
    override_pressure=1e5,
    transition_pressure=1e3,
    opening_time=5e-3,
)


def test_level_by_hand():
    assert held_level(CONTROL, 40e5, 10e5, 55e5) == 75e5  # 20 bar above the highest
    assert held_level(CONTROL, 10e5, 95e5, 10e5) == 110e5  # 115 bar are cut off


@given(st.floats(0.0, 2e7), st.floats(0.0, 2e7))
def test_a_margin_as_large_as_the_highest_pressure_holds_that_whatever_the_load(one, other):
    assert held_level(replace(CONTROL, margin=CONTROL.highest_pressure), one, other, one) == CONTROL.highest_pressure


def test_swivel_by_hand():
    # 5 bar of a band of 100 bar: a twentieth more, which is made up in 10 ms
    assert swivel_share(5e5, 0.3, CONTROL) == pytest.approx(0.35, rel=1e-12)
    assert swivel_rate(5e5, 0.3, CONTROL) == pytest.approx(5.0, rel=1e-12)
    assert (swivel_share(-40e5, 0.3, CONTROL), swivel_share(80e5, 0.3, CONTROL)) == (0.0, 1.0)
    assert [int(swivel_side(each, 0.3, CONTROL)) for each in (-40e5, 5e5, 80e5)] == [0, 1, 2]


@given(st.floats(0.0, 1.0), st.floats(-1.0, 1.0))
def test_a_control_rests_only_where_nothing_is_missing_or_at_an_end(swivel, missing):
    """Nothing winds up: beyond an end its state goes there, and comes back at once when the pressure is exceeded."""
    rate, share = (law(missing * 50e5, swivel, CONTROL) for law in (swivel_rate, swivel_share))
    assert rate * missing >= 0.0
    assert (rate == 0.0) == (missing == 0.0 or share == swivel)
    assert -1e-15 <= swivel + rate * CONTROL.reset_time <= 1.0 + 1e-15


def test_a_controlled_pump_comes_to_its_level_without_a_remainder():
    """A volume of 0.4 l at 1 GPa with 40 lpm at most; 10 lpm are taken whatever the pressure."""

    def rates(t, x):
        share = swivel_share(50e5 - x[0], x[1], CONTROL)
        return [1e9 / 0.4e-3 * (6.67e-4 * share - 1.67e-4), swivel_rate(50e5 - x[0], x[1], CONTROL)]

    found = solve_ivp(rates, (0.0, 0.5), (40e5, 0.0), rtol=1e-9, atol=(1.0, 1e-9))
    assert found.y[0, -1] == pytest.approx(50e5, rel=1e-6)
    assert found.y[1, -1] == pytest.approx(1.67 / 6.67, rel=1e-6)
    assert found.y[0].max() < 65e5


def test_a_pump_displaces_its_share_and_keeps_its_dead_volume():
    pump = Pump(displacement=3.6e-6, leakage_conductance=0.0, friction_torque=0.0, dead_volume=1e-6)
    inlet, outlet = FluidState(1e5, 1.0, 1.4e9, 0.0), FluidState(1e7, 0.99, 1.4e9, 9.9e6)
    full, half = delivery(0.0, inlet, outlet, pump), delivery(0.0, inlet, outlet, pump, 0.5)
    assert full.displacement == pytest.approx(3.6e-6 - 1e-6 * (1.0 / 0.99 - 1.0), rel=1e-12)
    assert full.displacement - half.displacement == pytest.approx(1.8e-6, rel=1e-12)


def test_metering_throttle_by_hand():
    # 1e-4 m^3/s over 8e-7 at 7 bar; 6e-7 and 8e-7 in series share a drop as 64 to 36
    assert flow_opening(THROTTLE, 1e-4) == pytest.approx(1e-4 / (8e-7 * 7e5**0.5), rel=1e-12)
    assert metering_share(1.0, 0.5, THROTTLE) == pytest.approx(0.36, rel=1e-12)
    assert (metering_share(0.0, 0.5, THROTTLE), metering_share(0.5, 0.0, THROTTLE)) == (1.0, 0.0)
    # 6.6 bar: open by 0.4, in 5 ms
    assert compensator_rate(6.6e5, 0.1, THROTTLE) == pytest.approx(60.0, rel=1e-12)
    assert [int(compensator_side(each, THROTTLE)) for each in (8e5, 6.6e5, 1e5)] == [0, 1, 2]


@given(st.floats(0.02, 0.5), st.floats(8e5, 2e7))
def test_a_compensator_holds_the_drop_over_its_throttle_whatever_the_supply(opening, drop):
    """At rest the throttle has between 6 and 7 bar."""
    found = solve_ivp(
        lambda t, y: [compensator_rate(metering_share(opening, y[0], THROTTLE) * drop, y[0], THROTTLE)],
        (0.0, 0.2), (1.0,), method="LSODA", rtol=1e-8, atol=1e-10,
    )  # fmt: skip
    assert 6e5 <= metering_share(opening, found.y[0, -1], THROTTLE) * drop <= 7e5


@pytest.mark.parametrize("name", ["highest_pressure", "proportional_band", "reset_time"])
def test_a_control_needs_its_values(name):
    with pytest.raises(ParameterError, match=f"PumpControl.{name}: .* must be greater than 0"):
        replace(CONTROL, **{name: 0.0})


@pytest.mark.parametrize(
    ("name", "value"),
    [("conductance", 0.0), ("compensator_conductance", 0.0), ("opening_time", 0.0), ("override_pressure", 8e5)],
)
def test_a_throttle_needs_its_values(name, value):
    with pytest.raises(ParameterError, match=f"CompensatedThrottle.{name}: "):
        replace(THROTTLE, **{name: value})
