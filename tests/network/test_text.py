"""What a network writes is what a person would have written."""

import ast
from typing import NamedTuple

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.conservation import Books, Stored
from vvdp.base.errors import NetworkError
from vvdp.base.kinds import Area, Density, Energy, Flow, Kink, Mode, Pressure, PressureTime, Volume
from vvdp.base.params import Params
from vvdp.base.signal import step
from vvdp.components.flow_sources import FLOW_SOURCE
from vvdp.components.pipes import add_pipe
from vvdp.components.resistances import ORIFICE
from vvdp.components.rods import CYLINDER
from vvdp.components.self_acting_valves import CHECK_VALVE, RELIEF_VALVE
from vvdp.components.switching_valves import PULSED_SWITCHING_VALVE, PulsedThreeWayValve
from vvdp.fluid.mixture import FluidState, fluid_state
from vvdp.fluid.oil import Oil, density
from vvdp.hydraulics.flow import Passage, flow_side, passage
from vvdp.hydraulics.flow_source import FlowSource
from vvdp.hydraulics.orifice import Orifice, orifice_flow
from vvdp.hydraulics.pipe import LinePipe
from vvdp.hydraulics.switching_valve import (
    SpoolState,
    port_areas,
    port_sides,
    pulse_stop,
    pulse_train,
    spool_ends,
    spool_rate,
)
from vvdp.hydraulics.volume import closed_volume_contents, closed_volume_rate
from vvdp.network.build import build
from vvdp.network.component import Component
from vvdp.network.network import Network
from vvdp.network.nodes import Chamber, Rotor
from vvdp.simulation.balance import balance
from vvdp.simulation.model import Case, Model
from vvdp.simulation.run import Stepping, simulate
from vvdp.simulation.values import flat

GOLDEN = """
def circuit(t, s, u, p):
    h = u.held
    tank = state_at(signal_value(t, p.tank_pressure), h.tank, p.oil)
    line = plain_state(s.line, p.oil)
    supply = flow_source(tank, line, signal_value(t, p.supply_flow), p.supply)
    load = orifice(line, tank, signal_value(t, p.load_area), h.medium, p.load)
    into_tank = -supply.flow + load.flow
    taken_in = maximum(supply.flow, 0.0) + maximum(-load.flow, 0.0)
    rates = State(
        line=closed_volume_rate(supply.flow - load.flow, 0.0, p.line.volume, line),
        books=Books(
            supplied=Supplied(
                tank=-tank.enthalpy * into_tank,
                supply=supply.supplied,
            ),
            spent=Spent(
                load=load.loss,
            ),
            taken_in=taken_in,
            given_out=taken_in + into_tank,
            totals=Totals(
                tank_pressure=tank.pressure,
                line_pressure=line.pressure,
                supply_flow=supply.flow,
                supply_flow_actual=supply.flow * line.volume_ratio,
                load_flow=load.flow,
                load_flow_actual=load.flow * tank.volume_ratio,
            ),
        ),
    )
    outputs = Outputs(
        tank_pressure=tank.pressure,
        supply_flow=supply.flow,
        load_flow=load.flow,
    )
    modes = Modes(
        supply_a_flow=flow_side(-supply.flow),
        load_b_flow=flow_side(load.flow),
    )
    return rates, outputs, modes


def conditions(t, p):
    temperature = signal_value(t, p.temperature)
    medium = Medium(density(temperature, p.oil), dynamic_viscosity(temperature, p.oil))
    return Held(
        medium=medium,
        tank=plain_state(signal_value(t, p.tank_pressure), p.oil),
    )


def stored(s, p):
    line = plain_state(s.line, p.oil)
    in_line = closed_volume_contents(line, p.line.volume, p.oil)
    energy = in_line.energy
    return Stored(energy, in_line.volume)


def start(p):
    return State(
        line=p.start.line,
        books=EMPTY_BOOKS,
    )


def stop(t, u, p):
    next_stop = np.inf
    next_stop = minimum(next_stop, signal_stop(t, p.temperature))
    next_stop = minimum(next_stop, signal_stop(t, p.tank_pressure))
    next_stop = minimum(next_stop, signal_stop(t, p.supply_flow))
    next_stop = minimum(next_stop, signal_stop(t, p.load_area))
    return next_stop
"""


@pytest.fixture
def small(oil, of):
    """A source of flow, a line and an orifice."""

    def draw() -> Network:
        net = Network(oil)
        net.tank("tank")
        net.volume("line", of.chamber, start=2e5)
        net.add("supply", FLOW_SOURCE, of.source, a="tank", b="line", flow=1e-4)
        net.add("load", ORIFICE, of.orifice, a="line", b="tank", area=1e-6)
        return net

    return draw


def test_text_is_what_a_person_would_write(small):
    assert build(small()).text.strip().splitlines() == GOLDEN.strip().splitlines()


def test_text_is_the_same_each_time(small):
    assert build(small()).text == build(small()).text


def test_long_lines_are_folded(oil, of):
    net = Network(oil)
    net.tank("tank")
    ends = [f"a_long_name_of_a_volume_number_{i}" for i in range(4)]
    for name in ends:
        net.volume(name, of.chamber, start=2e5)
    for i, name in enumerate(ends):
        for j, other in enumerate(ends[i + 1 :]):
            net.add(f"an_orifice_from_{i}_to_{i + j + 1}_with_a_name", ORIFICE, of.orifice, a=name, b=other, area=1e-6)
        net.add(f"a_relief_valve_at_the_volume_{i}", RELIEF_VALVE, of.relief, a=name, b="tank")
    net.rod("a_rod_with_a_rather_long_name")
    net.add("cylinder", CYLINDER, of.cylinder, a=ends[0], b=ends[1], rod="a_rod_with_a_rather_long_name")
    values = LinePipe(length=2.0, diameter=0.02, hose_compliance=1e-10)
    add_pipe(net, "hose", values, {"a": ends[2], "b": ends[3]}, 1e6)
    text = build(net).text
    assert max(map(len, text.splitlines())) <= 120
    ast.parse(text)


# Names


class Values(Params):
    area: Area
    orifice: Orifice


class State(NamedTuple):
    """A state that a person calls as the network calls its own."""

    opened: Pressure


class Lagged(NamedTuple):
    flow: Flow
    loss: Energy
    rates: State


def stop(a: FluidState, b: FluidState, values: Orifice) -> Passage:
    """A law that a person calls as the network calls a function of its own."""
    return passage(orifice_flow(1e-6, a.pressure - b.pressure, 870.0, values), a, b)


def mark(a: FluidState, b: FluidState, values: Orifice) -> Passage:
    return passage(orifice_flow(2e-6, a.pressure - b.pressure, 870.0, values), a, b)


@pytest.mark.parametrize(("law", "area"), [(stop, 1e-6), (mark, 2e-6)])
def test_law_may_be_called_as_a_function_of_the_text(small, of, law, area):
    net = small()
    net.add("own", Component(law, symbol="orifice"), of.orifice, a="line", b="tank")
    circuit = build(net)
    case = circuit.case
    outputs = circuit.model.circuit(0.0, case.state, case.command, case.params)[1]
    assert outputs.own_flow == pytest.approx(orifice_flow(area, 2e5 - 101325.0, 870.0, of.orifice), rel=1e-2)
    assert circuit.model.stop(0.0, case.command, case.params) == np.inf
    assert circuit.model.mark(0.0, case.state, case.command, case.params) == 0.0


def test_component_may_be_called_as_its_type(oil, of):
    net = Network(oil)
    net.tank("orifice")
    net.volume("fluid_state", of.chamber, start=2e5)
    net.volume("signal_value", of.chamber, start=2e5)
    net.rod("rod")
    net.add("cylinder", CYLINDER, of.cylinder, a="fluid_state", b="signal_value", rod="rod")
    net.add("check_valve", CHECK_VALVE, of.check, a="fluid_state", b="orifice")
    case = build(net).case
    rates = build(net).model.circuit(0.0, case.state, case.command, case.params)[0]
    assert rates.rod.velocity == pytest.approx(1e-3 * (2e5 - 101325.0) / 10.0)


@pytest.mark.parametrize("name", ["into_tank", "surplus_line", "supply_walls", "in_line"])
def test_name_that_the_text_needs_is_refused(small, of, name):
    net = small()
    net.volume(name, of.chamber, start=2e5)
    with pytest.raises(NetworkError, match=f"{name!r} {wording.network.another_name_becomes}"):
        build(net)


def test_node_may_begin_as_stores_do(oil, of):
    net = Network(oil)
    net.volume("in_front", of.chamber, start=2e5)
    net.volume("behind", of.chamber, start=2e5)
    net.rod("in_rod")
    net.add("cylinder", CYLINDER, of.cylinder, a="in_front", b="behind", rod="in_rod")
    circuit = build(net)
    assert circuit.model.stored(circuit.case.state, circuit.case.params).volume > 0.0


def test_two_results_of_one_name_are_refused(oil, of):
    net = Network(oil)
    net.shaft("spool", Rotor(inertia=1.0), angle=1.0)
    net.volume("spool_angle", of.chamber, start=2e5)
    net.tank("tank")
    net.add("load", ORIFICE, of.orifice, a="spool_angle", b="tank", area=1e-6)
    with pytest.raises(NetworkError, match="'spool_angle'"):
        build(net)


# Against the same circuit written by hand


class Supplied(NamedTuple):
    pump: Energy


class Spent(NamedTuple):
    valve: Energy
    load: Energy


class Totals(NamedTuple):
    load_pressure: PressureTime


class HandState(NamedTuple):
    inlet: Pressure
    load_line: Pressure
    valve: SpoolState
    books: Books


class Outputs(NamedTuple):
    load_flow: Flow


class HandValues(Params):
    oil: Oil
    pump_flow: Flow
    inlet_volume: Volume
    valve: PulsedThreeWayValve
    load_volume: Volume
    load_area: Area
    orifice: Orifice


class Held(NamedTuple):
    density: Density


class Modes(NamedTuple):
    first_side: Kink
    second_side: Kink
    at_first: Mode
    at_second: Mode
    returned: Kink
    drained: Kink


class Command(NamedTuple):
    held: Held
    modes: Modes


def hand_conditions(t: float, p: HandValues) -> Held:
    return Held(density(313.15, p.oil))


def hand_circuit(t: float, s: HandState, u: Command, p: HandValues) -> tuple[HandState, Outputs, Modes]:
    tank = fluid_state(p.oil.reference_pressure, p.oil)
    inlet, load = fluid_state(s.inlet, p.oil), fluid_state(s.load_line, p.oil)
    areas, rho = port_areas(s.valve.position, p.valve), u.held.density
    to_load = passage(orifice_flow(areas.first, s.inlet - s.load_line, rho, p.valve), inlet, load)
    to_tank = passage(orifice_flow(areas.second, s.inlet - p.oil.reference_pressure, rho, p.valve), inlet, tank)
    out = passage(orifice_flow(p.load_area, s.load_line - p.oil.reference_pressure, rho, p.orifice), load, tank)
    into_valve = -to_load.flow - to_tank.flow  # in this order, since another rounds otherwise and takes other steps
    rates = HandState(
        inlet=closed_volume_rate(p.pump_flow + into_valve, 0.0, p.inlet_volume, inlet),
        load_line=closed_volume_rate(to_load.flow - out.flow, 0.0, p.load_volume, load),
        valve=spool_rate(pulse_train(t, p.valve), s.valve, u.modes.at_first, u.modes.at_second, p.valve),
        books=Books(
            supplied=Supplied(p.pump_flow * (inlet.enthalpy - tank.enthalpy)),
            spent=Spent(to_load.loss + to_tank.loss, out.loss),
            taken_in=p.pump_flow,
            given_out=to_tank.flow + out.flow,
            totals=Totals(s.load_line),
        ),
    )
    sides = port_sides(s.valve.position, p.valve)
    ends = spool_ends(s.valve, u.modes.at_first, u.modes.at_second, p.valve)
    back, drained = flow_side(to_tank.flow), flow_side(out.flow)
    return rates, Outputs(out.flow), Modes(sides.first, sides.second, ends.first, ends.second, back, drained)


def hand_stored(s: HandState, p: HandValues) -> Stored:
    inlet = closed_volume_contents(fluid_state(s.inlet, p.oil), p.inlet_volume, p.oil)
    load = closed_volume_contents(fluid_state(s.load_line, p.oil), p.load_volume, p.oil)
    return Stored(inlet.energy + load.energy, inlet.volume + load.volume)


def hand_stop(t: float, u: Command, p: HandValues) -> float:
    return pulse_stop(t, p.valve)


VALVE = PulsedThreeWayValve(
    natural_frequency=200.0, damping_ratio=0.7, stroke=1e-3, lap=-1e-4, full_area=3e-5,
    discharge_coefficient=0.61, transition_pressure=5e3, frequency=75.0, duty_ratio=0.5,
)  # fmt: skip
FLOW, INLET, LOAD, AREA = 20e-3 / 60.0, 20e-6, 200e-6, 4.7e-6


def drawn(oil: Oil, orifice: Orifice) -> Network:
    net = Network(oil)
    net.tank("tank")
    net.volume("inlet", Chamber(volume=INLET), start=5e5)
    net.volume("load_line", Chamber(volume=LOAD), start=10e5)
    net.add("supply", FLOW_SOURCE, FlowSource(counted_at_outlet=0.0), a="tank", b="inlet", flow=FLOW)
    net.add("valve", PULSED_SWITCHING_VALVE, VALVE, pressure="inlet", first="load_line", second="tank")
    net.add("load", ORIFICE, orifice, a="load_line", b="tank", area=AREA)
    return net


def written(oil: Oil, orifice: Orifice) -> tuple[Model, Case]:
    empty = Books(Supplied(0.0), Spent(0.0, 0.0), 0.0, 0.0, Totals(0.0))
    values = HandValues(
        oil=oil, pump_flow=FLOW, inlet_volume=INLET, valve=VALVE, load_volume=LOAD, load_area=AREA, orifice=orifice
    )
    model = Model(hand_circuit, stored=hand_stored, conditions=hand_conditions, stop=hand_stop)
    state = HandState(5e5, 10e5, SpoolState(0.0, 0.0), empty)
    return model, Case(state, values, Command(hand_conditions(0.0, values), Modes(*[0.0] * 6)))


def test_network_is_the_circuit_written_by_hand(oil, of):
    network = build(drawn(oil, of.orifice))
    stepping = Stepping(until=0.2, sample_period=1e-2)
    one = simulate(network.model, network.case, stepping)
    other = simulate(*written(oil, of.orifice), stepping)
    assert one.steps == other.steps
    for path in ("inlet", "load_line"):
        assert getattr(one.state, path)[-1] == pytest.approx(getattr(other.state, path)[-1], rel=1e-12)
    mine, theirs = one.state.books, other.state.books
    assert mine.supplied.supply[-1] + mine.supplied.tank[-1] == pytest.approx(theirs.supplied.pump[-1], rel=1e-12)
    assert mine.spent.valve[-1] == pytest.approx(theirs.spent.valve[-1], rel=1e-12)
    assert mine.spent.load[-1] == pytest.approx(theirs.spent.load[-1], rel=1e-12)
    assert mine.taken_in[-1] == pytest.approx(theirs.taken_in[-1], rel=1e-12)
    assert mine.given_out[-1] == pytest.approx(theirs.given_out[-1], rel=1e-12)
    assert mine.totals.load_line_pressure[-1] == pytest.approx(theirs.totals.load_pressure[-1], rel=1e-12)
    assert balance(one).is_trusted and balance(other).is_trusted


def test_stop_has_every_signal(oil, of):
    """Also those of tanks, sources and driven shafts, and inside of connections."""
    net = Network(oil, temperature=step(300.0, 320.0, 1.0))
    net.tank("tank", step(1e5, 2e5, 2.0))
    net.pressure_source("source", step(1e5, 2e5, 3.0))
    net.driven_shaft("shaft", step(0.0, 1.0, 4.0))
    net.add("load", ORIFICE, of.orifice, a="source", b="tank", area=step(0.0, 1e-6, 5.0))
    circuit = build(net)
    case, t = circuit.case, 0.0
    for expected in (1.0, 2.0, 3.0, 4.0, 5.0, np.inf):
        t = circuit.model.stop(t, case.command, case.params)
        assert t == expected
    assert flat(case.state).size > 0
