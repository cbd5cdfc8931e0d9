"""Brake, cartridge and priority valves, compensators, closing pilots: values by hand, and the laws that they obey."""

import numpy as np
import pytest

from vvdp.base.errors import ParameterError
from vvdp.components.balanced_valves import (
    brake_valve,
    cartridge_valve,
    downstream_compensator,
    priority_valve,
    upstream_compensator,
    upstream_start,
)
from vvdp.components.self_acting_valves import pilot_closed_check_valve
from vvdp.fluid.mixture import fluid_state
from vvdp.hydraulics.balanced_valve import BalancedValve, CartridgeValve
from vvdp.hydraulics.counterbalance_valve import SequenceValve
from vvdp.hydraulics.opening import OpeningState
from vvdp.hydraulics.pilot_check_valve import PilotCheckValve

SHUT = OpeningState(0.0)
VALUES = {"cracking_pressure": 7e5, "override_pressure": 2e5, "rated_flow": 1e-3, "rated_drop": 5e5}
BALANCED = BalancedValve(**VALUES)
BRAKE = SequenceValve(**VALUES, reverse_cracking_pressure=5e4, reverse_override_pressure=4.5e5)


@pytest.fixture
def at(oil):
    return lambda pressure: fluid_state(pressure, oil)


def actual(q, side):
    """A flow of tank volumes at the pressure of the side that it comes from."""
    return q * side.volume_ratio


def test_a_brake_valve_opens_by_its_pilot_and_not_by_its_load(at):
    """Half of 2 bar above 7 bar, whatever the load; 5 bar pass the rated flow."""
    a, b = at(6e5), at(1e5)
    assert actual(brake_valve(a, b, at(9e5), SHUT, BRAKE).flow, a) == pytest.approx(5e-4, rel=1e-12)
    assert brake_valve(at(300e5), b, at(8e5), SHUT, BRAKE).flow == 0.0
    back = brake_valve(b, a, at(1e5), SHUT, BRAKE)
    assert actual(back.flow, a) == pytest.approx(-1e-3, rel=1e-12)  # over the check valve


def test_a_cartridge_valve_obeys_the_balance_of_forces_on_its_poppet(at):
    values = CartridgeValve(**VALUES, ring_ratio=0.6)
    a, b = at(40e5), at(35e5)
    # 40 + 0.6 35 - 1.6 P_x = 8 bar at half lift
    half = cartridge_valve(a, b, at((61.0 - 8.0) / 1.6 * 1e5), SHUT, values)
    assert actual(half.flow, a) == pytest.approx(5e-4, rel=1e-9)
    # Joined to b it is a check valve: the lift is P_a - P_b, or less than nothing the other way
    assert cartridge_valve(a, b, b, SHUT, values).flow == 0.0
    assert cartridge_valve(at(50e5), b, b, SHUT, values).flow > 0.0
    assert cartridge_valve(b, at(50e5), at(50e5), SHUT, values).flow == 0.0
    # The pilot at the tank leaves it open either way
    assert cartridge_valve(b, a, at(1e5), SHUT, values).flow < 0.0


@pytest.mark.parametrize(("drop", "opening"), [(6e5, 1.0), (7.5e5, 0.75), (10e5, 0.0)])
def test_an_upstream_compensator_shuts_as_its_drop_grows_and_a_downstream_one_opens(at, drop, opening):
    load = at(50e5)
    metered = at(50e5 + drop)
    a, out = at(50e5 + drop + 5e5), at(50e5 + drop - 5e5)
    before = upstream_compensator(a, metered, load, SHUT, BALANCED)
    behind = downstream_compensator(metered, out, load, SHUT, BALANCED)
    assert actual(before.flow, a) == pytest.approx(opening * 1e-3, rel=1e-9, abs=1e-18)
    assert actual(behind.flow, metered) == pytest.approx((1.0 - opening) * 1e-3, rel=1e-9, abs=1e-18)
    assert before.side == behind.side


def test_an_upstream_compensator_begins_open_and_follows_with_its_time(at):
    slow = BalancedValve(**VALUES, opening_time=5e-3)
    assert upstream_start(slow) == (1.0,)
    found = upstream_compensator(at(90e5), at(58e5), at(50e5), OpeningState(1.0), slow)
    assert found.rates.opening == pytest.approx(-100.0)  # (0.5 - 1)/5 ms


def test_what_a_priority_valve_takes_from_one_port_it_gives_to_the_other(at):
    inlet, low = at(65e5), at(10e5)
    for drop in np.linspace(5e5, 11e5, 7) + 1e3:
        first = at(50e5 + drop)
        found = priority_valve(inlet, first, low, at(50e5), SHUT, BALANCED)
        y = float(np.clip((drop - 7e5) / 2e5, 0.0, 1.0))
        share = actual(found.excess, inlet) / 1e-3 / np.sqrt(55.0 / 5.0)
        assert share == pytest.approx(y, abs=1e-4)
        assert actual(found.priority, inlet) == pytest.approx((1.0 - y) * 1e-3 * np.sqrt(3.0 - drop / 5e5), rel=1e-3)
        assert found.inlet == -found.priority - found.excess


def test_a_pilot_holds_a_check_valve_shut(at):
    """Half lift: 4 bar - 3 (P_x - P_b) are 1.5 bar."""
    values = PilotCheckValve(cracking_pressure=0.5e5, rated_flow=6e-4, rated_drop=2.5e5, pilot_ratio=3.0)
    a, b = at(5e5), at(1e5)
    free = pilot_closed_check_valve(a, b, at(0.5e5), SHUT, values)
    assert actual(free.flow, a) == pytest.approx(6e-4 * np.sqrt(4.0 / 2.5), rel=1e-4)
    half = pilot_closed_check_valve(a, b, at(1e5 + 2.5e5 / 3.0), SHUT, values)
    assert half.flow == pytest.approx(0.5 * free.flow, rel=1e-9)
    assert pilot_closed_check_valve(a, b, at(3e5), SHUT, values).flow == 0.0


@pytest.mark.parametrize("name", list(VALUES))
def test_values_of_nothing_are_refused(name):
    with pytest.raises(ParameterError, match=name):
        BalancedValve(**{**VALUES, name: 0.0})
