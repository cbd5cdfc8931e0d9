"""Rivals whose pump has losses of its own: the law that enables pistons, and powers in closed form at a steady load."""

from dataclasses import replace

import numpy as np
import pytest

from vvdp.control.duty_cycle import DutyCycle
from vvdp.fluid.mixture import fluid_state
from vvdp.hydraulics.digital_pump import stroke_share
from vvdp.machines.duties import shipped_duties
from vvdp.programs.piston_law import FlowDemand, PistonLaw, piston_start, piston_step
from vvdp.rivals.rival_account import system_for
from vvdp.rivals.rival_circuits import CIRCUITS, with_value
from vvdp.simulation.run import simulate
from vvdp.systems.system import load_system

A, B = 20.26e-4, 10.77e-4
"""Areas of the cylinder [m^2]."""
FRICTION, VALVE = 2000.0, 1e-6
"""Of the rod [N s/m], and of an edge of the directional valve [m^3/(s Pa^0.5)]."""
D, OMEGA = 22.222222e-6 / (2.0 * np.pi), 60.0 * np.pi
"""Displacement of the pump per angle [m^3/rad], and its speed [rad/s]."""
LAW = PistonLaw(pistons=12.0, largest_flow=6e-4)


def orders(share, count, law=LAW):
    """What the law commands for a constant share of the largest flow."""
    memory, found = piston_start(law), []
    for _ in range(count):
        memory, order = piston_step(0.0, memory, FlowDemand(share * law.largest_flow), law)
        found.append(order)
    return found


def test_a_third_of_the_flow_enables_every_third_piston():
    """Owed 1/3, 2/3: the second one, then every third; two of six deliver at a time."""
    found = orders(1.0 / 3.0, 12)
    assert [order.actuated for order in found] == [0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0]
    assert [order.enabled for order in found[6:]] == pytest.approx([1.0 / 3.0] * 6)


@pytest.mark.parametrize("share", [0.0, 0.07, 0.5, 0.93, 1.0])
def test_strokes_are_the_flow_within_half_a_stroke(share):
    done = np.cumsum([order.actuated for order in orders(share, 500)])
    assert np.max(np.abs(done - share * np.arange(1.0, 501.0))) <= 0.5 + 1e-9


def test_sums_are_those_of_the_enabled_pistons_in_their_stroke():
    """Against the sum over the last six pistons, of any pattern, for 200 revolutions: equal to rounding."""
    rng, memory, pump = np.random.default_rng(4), piston_start(LAW), PUMP
    enabled = []
    for number in range(2400):
        memory, order = piston_step(0.0, memory, FlowDemand(rng.uniform(0.0, 6e-4)), LAW)
        enabled.append(order.actuated)
        angles = [2.0 * np.pi * (number - back) / 12.0 for back in range(6) if number >= back and enabled[-1 - back]]
        assert (order.cosine, order.sine) == pytest.approx((np.sum(np.cos(angles)), np.sum(np.sin(angles))), abs=1e-9)
        assert order.enabled == len(angles) / 6.0
        theta = 2.0 * np.pi * number / 12.0 + 0.2
        by_hand = np.pi / 12.0 * sum(np.sin(theta - angle) for angle in angles)
        assert stroke_share(theta, order.cosine, order.sine, pump) == pytest.approx(by_hand, abs=1e-9)


def circuit(name):
    return next(each for each in CIRCUITS if each.name == name)


PUMP = load_system("digital-pump-control").circuit.network.parts["pump"].values[0]


def steady():
    """A ramp long enough to be steady: 10 cm/s against 4 kN out, and driven by it back."""
    cycle = DutyCycle(times=(0.0, 2.0, 4.0), positions=(0.05, 0.25, 0.05), forces=(-4e3,) * 3)
    return replace(shipped_duties()[0], name="steady", cycle=cycle)


class Course:
    """A run on the steady ramp, with the means of going out and of coming back in its last round."""

    def __init__(self, name, **pump):
        changed = circuit(name)
        for key, value in pump.items():
            changed = with_value(changed, name, f"components.pump.{key}", value)
        self.duty = steady()
        self.system = system_for(changed, self.duty)
        self.run = simulate(self.system.model, self.system.case, self.system.stepping)
        since = self.run.times - 2.0 * self.duty.period
        self.ways = ((since > 1.2) & (since < 1.8), 1.0, A, B), ((since > 3.2) & (since < 3.8), -1.0, B, A)

    def power(self, books, rows):
        times, values = self.run.times[rows], books[rows]
        return (values[-1] - values[0]) / (times[-1] - times[0])

    def level(self, way):
        """P_s A_s = F + b v + P_r A_r with P_r = (A_r v/(K u))^2, and the edge of the directional valve before it."""
        rows, sign, into, out = way
        u = np.mean(self.run.command.loop.opening[rows])
        behind = (out * 0.1) ** 2 * (1.0 / (self.duty.return_conductance * u) ** 2 + 1.0 / VALVE**2)
        return (sign * 4e3 + FRICTION * 0.1 + behind * out) / into + (into * 0.1 / VALVE) ** 2


@pytest.fixture(scope="module")
def measured():
    return Course("measured-pump")


@pytest.fixture(scope="module")
def digital():
    return Course("digital-pump", friction_torque=3.0)


def test_the_measured_pump_draws_its_flow_its_slip_and_its_drag(measured):
    """(A v + C_s D/mu P) P + T omega, T = C_v mu D omega + C_f D P + 26.8 s rho D^(5/3) omega^2.

    Out at 27.9 bar: 23.5e3 0.0387 3.537e-6 188.5 = 0.606, 0.0537 3.537e-6 27.9e5 = 0.530 and 0.208 N m: 253 W."""
    oil = measured.system.circuit.network.oil
    mu, rho = oil.density * oil.viscosity_40, oil.density
    lost = measured.power(measured.run.state.books.spent.pump.friction, measured.ways[0][0])
    assert lost == pytest.approx(253.0, rel=1e-2)
    for way in measured.ways:
        level, flow = measured.level(way), way[2] * 0.1
        slip = 4.26e-9 * D / mu * level
        torque = 23.5e3 * mu * D * OMEGA + 0.0537 * D * level
        torque += 26.8 * (flow + slip) / (D * OMEGA) * rho * D ** (5.0 / 3.0) * OMEGA**2
        drawn = measured.power(measured.run.state.books.supplied.pump_shaft, way[0])
        lost = measured.power(measured.run.state.books.spent.pump.friction, way[0])
        assert lost == pytest.approx(torque * OMEGA, rel=1e-2)
        assert drawn == pytest.approx((flow + slip) * level + torque * OMEGA, rel=1e-2)


def test_a_pump_of_enabled_pistons_draws_its_flow_its_valves_and_its_drag(digital):
    """((A v + e G P)(1 + what compression keeps) P + T_f omega + 360/s ((2 - e) E_b + e E), e as the strokes need."""
    oil, valve = digital.system.circuit.network.oil, PUMP
    volume, tank = 22.222222e-6 / 12.0, fluid_state(101325.0, oil)
    breath = volume**3 * OMEGA**2 / (6.0 * valve.valve_conductance**2)
    for way in digital.ways:
        level, flow = digital.level(way), way[2] * 0.1
        line = fluid_state(level + 101325.0, oil)
        stroke = D * OMEGA * (1.0 - (1.0 / line.volume_ratio - 1.0))
        enabled = flow / line.volume_ratio / (stroke - 2e-12 * level / line.volume_ratio)
        books = digital.run.state.books
        drawn = digital.power(books.supplied.pump_shaft, way[0]) + digital.power(books.supplied.pump, way[0])
        valves = 360.0 * ((2.0 - enabled) * breath + enabled * 0.2)
        assert np.mean(digital.run.command.pistons.enabled[way[0]]) == pytest.approx(enabled, rel=2e-2)
        lost = digital.power(books.spent.pump.breathing, way[0]) + digital.power(books.spent.pump.actuation, way[0])
        assert lost == pytest.approx(valves, rel=1e-2)
        expected = enabled * stroke * (line.enthalpy - tank.enthalpy) + 3.0 * OMEGA + valves
        assert drawn == pytest.approx(expected, rel=2e-2)
