"""Rivals whose pump follows the load: powers and losses in closed form at steady loads, one to three cylinders."""

from dataclasses import replace

import numpy as np
import pytest

from vvdp.comparison.circuit_trials import run_pair
from vvdp.control.duty_cycle import DutyCycle
from vvdp.fluid.mixture import fluid_state
from vvdp.machines.duties import known_cylinder, shipped_duties, sized_duty
from vvdp.rivals.rival_account import joint_score, system_for
from vvdp.rivals.rival_circuits import CIRCUITS, PUMP_FRICTION, SINKS, with_value
from vvdp.rivals.sizing import SUFFIXES
from vvdp.simulation.run import simulate

pytestmark = pytest.mark.heavy

A, B = 20.26e-4, 10.77e-4
"""Areas of the cylinder [m^2]."""
FRICTION = 2000.0
"""Viscous friction of the rod [N s/m]."""
VALVE = 1e-6
"""Conductance of an edge of the directional valve [m^3/(s Pa^0.5)]."""
RETURN = 3e-7
"""Of the throttle in the return."""
PUMP_FLOW, LEAKAGE, MARGIN, SPEED = 40.0 / 60e3, 2e-12, 20e5, 60.0 * np.pi
ONE, THREE = ((4000.0, 0.25),), ((1500.0, 0.15), (4000.0, 0.25), (500.0, 0.10))
"""Against extending, and how far each cylinder goes in 2 s from 50 mm [N, m]; of several, the second is the highest."""


def circuit(name):
    return next(each for each in CIRCUITS if each.name == name)


def duty(loads):
    """Ramps long enough to be steady, of a cylinder for each load."""
    first, *further = (moved(*each) for each in loads)
    return replace(first, further=tuple(further))


def moved(force, far):
    cycle = DutyCycle(times=(0.0, 2.0, 4.0), positions=(0.05, far, 0.05), forces=(-force,) * 3)
    return replace(sized_duty("steady", "", "", cycle, *known_cylinder()), return_conductance=RETURN)


class Course:
    """A run on steady ramps, with the means of going out and of coming back in its last round."""

    def __init__(self, name, loads, **pump):
        self.loads = loads
        changed = circuit(name)
        for key, value in pump.items():
            changed = with_value(changed, name, f"components.pump.{key}", value)
        self.system = system_for(changed, duty(loads))
        self.run = simulate(self.system.model, self.system.case, self.system.stepping)
        since = self.run.times - 2.0 * duty(loads).period
        self.ways = ((since > 1.6) & (since < 1.95), 1.0, A, B), ((since > 3.6) & (since < 3.95), -1.0, B, A)

    def power(self, books, rows):
        """Mean power of a book over rows [W]."""
        times, values = self.run.times[rows], books[rows]
        return (values[-1] - values[0]) / (times[-1] - times[0])

    def drawn(self, rows):
        return self.power(self.run.state.books.supplied.pump_shaft, rows)

    def line(self, k, way):
        """Pressure that the supply of cylinder k needs: P_s A_s = F + b v + P_r A_r, P_r as the return is open."""
        rows, sign, into, out = way
        suffix, (force, far) = SUFFIXES[k], self.loads[k]
        v = (far - 0.05) / 2.0
        u = np.mean(getattr(self.run.command, f"loop{suffix}").opening[rows])
        behind = (out * v) ** 2 * (1.0 / (RETURN * u) ** 2 + 1.0 / VALVE**2)
        return (sign * force + FRICTION * v + behind * out) / into + (into * v / VALVE) ** 2

    def flow(self, k, way):
        return way[2] * (self.loads[k][1] - 0.05) / 2.0

    def valve_loss(self, k, rows):
        spent = getattr(self.run.state.books.spent, f"flow_valve{SUFFIXES[k]}")
        return self.power(spent.metering, rows) + self.power(spent.compensator, rows)


@pytest.fixture(scope="module")
def sensing():
    return Course("load-sensing", ONE, friction_torque=3.0)


@pytest.fixture(scope="module")
def three():
    return Course("load-sensing", THREE)


def test_load_sensing_gives_the_flow_at_a_margin_above_the_load(sensing):
    """(A v + G P) P + T_f omega with P = P_line + 20 bar, of which 20 bar A v are lost before the line."""
    for way in sensing.ways:
        level = sensing.line(0, way) + MARGIN
        expected = (sensing.flow(0, way) + LEAKAGE * level) * level + 3.0 * SPEED
        assert sensing.drawn(way[0]) == pytest.approx(expected, rel=1e-2)
        assert sensing.valve_loss(0, way[0]) == pytest.approx(MARGIN * sensing.flow(0, way), rel=1e-2)


@pytest.mark.thorough
def test_three_loads_lose_the_margin_and_what_each_lies_below_the_highest(three):
    """margin Q + (P_max - P_i) Q_i over the valves of each, and (Q + G P) P from the drive."""
    for way in three.ways:
        lines, flows = ([of(k, way) for k in range(3)] for of in (three.line, three.flow))
        highest = max(lines)
        for k in range(3):
            assert three.valve_loss(k, way[0]) == pytest.approx((highest + MARGIN - lines[k]) * flows[k], rel=1e-2)
        level = highest + MARGIN
        assert three.drawn(way[0]) == pytest.approx((sum(flows) + LEAKAGE * level) * level, rel=1e-2)


def test_the_margin_is_held_to_nothing(three):
    for rows, *_ in three.ways:
        state = three.run.state
        highest = np.max([state.supply[rows], state.supply_second[rows], state.supply_third[rows]], axis=0)
        assert np.mean(state.pump_line[rows] - highest) == pytest.approx(MARGIN, rel=1e-3)


def test_a_pressure_compensated_pump_gives_the_flow_at_one_pressure():
    """(A v + G P) P, P = 60 bar, whatever the load."""
    found = Course("constant-pressure", ONE)
    for way in found.ways:
        expected = (found.flow(0, way) + LEAKAGE * 60e5) * 60e5
        assert found.drawn(way[0]) == pytest.approx(expected, rel=1e-2)
        assert found.valve_loss(0, way[0]) == pytest.approx((60e5 - found.line(0, way)) * found.flow(0, way), rel=1e-2)


EDGE_MARGIN = 10e5
"""Of a pump that is told the pressure of the chamber that is fed [Pa]."""


@pytest.mark.parametrize("loads", [ONE, THREE])
def test_independent_valves_take_the_flow_at_a_margin_above_the_load(loads):
    """(Q + G P) P with P = P_s + 10 bar, P_s A_s = F + b v + P_r A_r and P_r = (A_r v/(K_r u))^2: no valve but one."""
    found = Course("independent-valves", loads)
    for way in found.ways:
        rows, sign, into, out = way
        lines = []
        for (force, far), suffix in zip(loads, SUFFIXES, strict=False):
            speed, command = (far - 0.05) / 2.0, getattr(found.run.command, f"loop{suffix}")
            u = np.mean((command.return_b if sign > 0.0 else command.return_a)[rows])
            lines.append((sign * force + FRICTION * speed + (out * speed / (RETURN * u)) ** 2 * out) / into)
        level, flow = max(lines) + EDGE_MARGIN, sum(found.flow(k, way) for k in range(len(loads)))
        assert found.drawn(rows) == pytest.approx((flow + LEAKAGE * level) * level, rel=1e-2)


def test_independent_units_take_the_flow_at_a_margin_above_the_chamber_that_is_fed():
    """(A v + G P) P with P = P_s + 10 bar; P_s is that of the codes, which come and go, 6 bar at most when driven."""
    found = Course("independent-units", ONE)
    for way in found.ways:
        state = found.run.state
        fed = np.mean((state.chamber_a if way[1] > 0.0 else state.chamber_b)[way[0]]) - 101325.0
        level = fed + EDGE_MARGIN
        assert found.drawn(way[0]) == pytest.approx((found.flow(0, way) + LEAKAGE * level) * level, rel=2e-2)
        assert way[1] > 0.0 or 0.0 < fed < 7e5


def test_a_pump_that_is_bled_off_gives_all_its_flow_at_the_pressure_of_the_load():
    """Q_p h(P), of which what the cylinder does not take, Q_p - (A v + G P)/nu in tank volumes, over the throttle."""
    found = Course("bleed-off", ONE)
    for way in found.ways:
        level, oil = found.line(0, way), found.system.circuit.network.oil
        supply = fluid_state(level + oil.reference_pressure, oil)
        assert found.drawn(way[0]) == pytest.approx(PUMP_FLOW * supply.enthalpy, rel=1e-2)
        assert supply.enthalpy == pytest.approx(level, rel=0.01)
        bled = found.power(found.run.state.books.spent.bleed_valve, way[0])
        left = PUMP_FLOW - (found.flow(0, way) + LEAKAGE * level) / supply.volume_ratio
        assert bled == pytest.approx(left * supply.enthalpy, rel=1e-2)


def test_friction_of_the_pump_is_its_torque_times_its_speed(sensing):
    books = sensing.run.state.books.spent.pump.friction
    for rows, *_ in sensing.ways:
        assert sensing.power(books, rows) == pytest.approx(3.0 * SPEED, rel=1e-9)
    assert PUMP_FRICTION in SINKS


# Several cylinders


def test_circuits_that_move_one_cylinder_are_there_once_for_each():
    """Their powers are the sum of what each comes to alone."""
    alone = [run_pair(circuit("four-valves"), each).score for each in duty(THREE).alone]
    together = run_pair(circuit("four-valves"), duty(THREE)).score
    assert together == joint_score(alone)
    assert together.drawn == sum(each.drawn for each in alone) > 1.15 * alone[1].drawn
    assert together.pressure_min == min(each.pressure_min for each in alone)


def test_a_share_of_a_shared_pump_grows_dear_with_unequal_loads():
    """What load sensing draws over a pump for each rises from one to three cylinders: 20 bar first, then all below."""
    one, three = (next(each for each in shipped_duties() if each.name == name) for name in ("heavy", "three-loads"))
    ratios = []
    for loads in (one, three):
        shared, apart = (run_pair(circuit(name), loads).score for name in ("load-sensing", "ideal-pump"))
        assert shared.delivered == pytest.approx(apart.delivered, rel=0.01)
        ratios.append(shared.drawn / apart.drawn)
    assert ratios == pytest.approx([1.56, 2.17], abs=0.05)
