"""Programs of a network: rates, phases, latencies, instruments, events, and what they read of each other."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest
from tests.network.drawn_unit import Moves, add_unit, prototype_unit
from tests.words import wording

from vvdp.base.errors import NetworkError
from vvdp.base.kinds import (
    Count,
    Fraction,
    Position,
    Pressure,
    Ratio,
    Speed,
    Time,
)
from vvdp.base.params import Params
from vvdp.base.select import clip
from vvdp.base.signal import constant
from vvdp.components.controlled_valves import UNLOADING_VALVE
from vvdp.components.flow_sources import FLOW_SOURCE
from vvdp.components.machines import PUMP
from vvdp.components.resistances import ORIFICE
from vvdp.components.self_acting_valves import CHECK_VALVE
from vvdp.components.switching_valves import MODULATED_TWO_WAY_VALVE, ModulatedTwoWayValve
from vvdp.hydraulics.seat_valve import SeatValve
from vvdp.hydraulics.volume import Vessel
from vvdp.network.build import build
from vvdp.network.network import Network
from vvdp.network.nodes import Connection
from vvdp.network.program import ProgramType
from vvdp.programs.unloading import UNLOADING, UnloadingSettings
from vvdp.sensing.instrument import ideal_instrument
from vvdp.simulation.balance import balance
from vvdp.simulation.run import Run, Stepping, simulate


class Level(NamedTuple):
    pressure: Pressure


class Opening(NamedTuple):
    opening: Fraction


class Sum(NamedTuple):
    opening: Fraction


class Gain(Params):
    reference: Pressure
    gain: Ratio


class Watched(NamedTuple):
    time: Time
    opening: Fraction


class Counted(NamedTuple):
    calls: Count
    last: Time
    seen: Fraction


def control_start(settings: Gain) -> Sum:
    return Sum(0.5)


def control(t: float, memory: Sum, reading: Level, settings: Gain) -> tuple[Sum, Opening]:
    opening = clip(memory.opening + settings.gain * (reading.pressure - settings.reference) / 1e6, 0.0, 1.0)
    return Sum(opening), Opening(opening)


def watch_start(settings: Any) -> Counted:
    return Counted(0.0, 0.0, 0.0)


def watch(t: float, memory: Counted, reading: Watched, settings: Any) -> tuple[Counted, Counted]:
    after = Counted(memory.calls + 1.0, reading.time, reading.opening)
    return after, after


CONTROL = ProgramType(control, Level, Opening(0.5), Gain, control_start)
WATCH = ProgramType(watch, Watched, Counted(0.0, 0.0, 0.0), None, watch_start)
GAIN = Gain(reference=3e6, gain=0.05)


def metered_area(opening: float) -> float:
    return 4e-6 * opening


@pytest.fixture
def controlled(oil, of):
    """A line whose pressure a program holds by an orifice."""

    def draw(**program: Any) -> Network:
        net = Network(oil)
        net.tank("tank")
        net.volume("line", of.chamber, start=2e6)
        net.add("supply", FLOW_SOURCE, of.source, a="tank", b="line", flow=2e-4)
        area = Connection(metered_area, ("controller.opening",))
        net.add("load", ORIFICE, of.orifice, a="line", b="tank", area=area)
        given = {"period": 2e-3, "phase": 1e-3, "latency": 5e-4, **program}
        net.program("controller", CONTROL, GAIN, reads={"pressure": "line.pressure"}, **given)
        return net

    return draw


STEPPING = Stepping(until=0.1, sample_period=1e-3, record_interval=1e-3)


def run(net: Network, stepping: Stepping = STEPPING) -> Run:
    circuit = build(net)
    return simulate(circuit.model, circuit.case, stepping)


def test_programs_have_their_own_rates(controlled):
    net = controlled()
    net.program("counter", WATCH, reads={"time": "t", "opening": "controller.opening"}, period=5e-3)
    found = run(net)
    assert found.final_memory["counter"].calls == 20.0 or found.final_memory["counter"].calls == 21.0
    late = found.command.counter
    assert set(np.round(np.diff(np.unique(late.last)), 9)) == {5e-3}
    assert np.ptp(found.command.controller.opening) > 0.0
    assert balance(found).is_trusted


def test_program_reads_the_command_of_another(controlled):
    """As it is in force at the sample."""
    net = controlled()
    net.program("counter", WATCH, reads={"time": "t", "opening": "controller.opening"}, period=1e-3, phase=7e-4)
    found = run(net)
    counter, opening = found.command.counter, found.command.controller.opening
    asked = found.times.searchsorted(counter.last + 1e-9) - 1
    asked, seen = asked[100:], counter.seen[100:]
    assert np.array_equal(seen, opening[asked]) and np.ptp(seen) > 0.0
    assert np.array_equal(found.outputs.controller_opening, opening)


def test_latency_delays_the_command(controlled):
    begun = []
    for latency in (0.0, 2e-3):
        found = run(controlled(latency=latency))
        begun.append(found.times[np.argmax(found.command.controller.opening != 0.5)])
    assert begun[1] - begun[0] == pytest.approx(2e-3, abs=1e-9)


def test_another_program_changes_nothing(controlled):
    """To the last bit, where it ends no step elsewhere; it has a period and a phase of the controller's."""
    alone, net = run(controlled()), controlled()
    net.program("counter", WATCH, reads={"time": "t", "opening": "controller.opening"}, period=2e-3, phase=1e-3)
    beside = run(net)
    assert np.array_equal(alone.state.line, beside.state.line)
    assert np.array_equal(alone.command.controller.opening, beside.command.controller.opening)


def test_instrument_stands_between(controlled):
    """A range that is cut off, as the program sees it; an ideal one changes nothing."""
    ideal = run(controlled(sensors={"pressure": ideal_instrument(0.0, 1e8)}))
    cut = run(controlled(sensors={"pressure": ideal_instrument(0.0, 2.5e6)}))
    plain = run(controlled())
    assert np.array_equal(ideal.state.line, plain.state.line)
    assert np.min(cut.command.controller.opening) < np.min(plain.command.controller.opening)
    memory = cut.final_memory["controller"]
    assert memory.pressure_sensor.saturated > 0.0
    assert memory.opening == cut.command.controller.opening[-1]


def test_event_program_unloads_a_pump(oil, of):
    """It charges to the cut-out pressure, unloads, and loads again at the cut-in pressure."""
    net = Network(oil)
    net.tank("tank")
    net.volume("pump_line", of.chamber, start=2e6)
    vessel = Vessel(oil_volume=2e-4, hose_compliance=0.0, gas_volume=2e-4, precharge_pressure=3e6, gas_exponent=1.3)
    net.volume("accumulator", vessel, start=6e6)
    net.add("supply", FLOW_SOURCE, of.source, a="tank", b="pump_line", flow=3e-4)
    net.add("check_valve", CHECK_VALVE, of.check, a="pump_line", b="accumulator")
    seat = SeatValve(rated_flow=1e-3, rated_drop=5e5, lag=2e-3)
    net.add("unload", UNLOADING_VALVE, seat, a="pump_line", b="tank", unloaded="switch.unloaded")
    net.add("load", ORIFICE, of.orifice, a="accumulator", b="tank", area=1.5e-6)
    settings = UnloadingSettings(cut_out_pressure=1e7, cut_in_pressure=8e6)
    net.program("switch", UNLOADING, settings, reads={"pilot_pressure": "accumulator.pressure"})
    found = run(net, Stepping(until=1.0, record_interval=1e-3))
    pressure, unloaded = found.state.accumulator, found.command.switch.unloaded
    turns = np.flatnonzero(np.diff(unloaded))
    assert len(turns) >= 3
    levels = {True: 1e7, False: 8e6}
    for i in turns:
        assert pressure[i] == pytest.approx(levels[bool(unloaded[i + 1])], rel=5e-3)
    assert balance(found).is_trusted


def test_edge_that_a_program_sets_is_a_stop(oil, of):
    """The duty ratio of a pulsed valve comes from a program: the next edge follows from its command."""
    valve = ModulatedTwoWayValve(
        natural_frequency=400.0, damping_ratio=0.7, stroke=1e-3, lap=0.0, full_area=1e-5, discharge_coefficient=0.6,
        transition_pressure=1e4, normally_open=0.0, frequency=50.0,
    )  # fmt: skip
    net = Network(oil)
    net.tank("tank")
    net.volume("line", of.chamber, start=2e6)
    net.add("valve", MODULATED_TWO_WAY_VALVE, valve, a="line", b="tank", duty_ratio="controller.opening")
    net.program("controller", CONTROL, GAIN, reads={"pressure": "line.pressure"})
    circuit = build(net)
    command = circuit.case.command
    assert circuit.model.stop(0.001, command, circuit.case.params) == pytest.approx(0.01)
    other = command._replace(controller=Opening(0.2))
    assert circuit.model.stop(0.001, other, circuit.case.params) == pytest.approx(0.004)


# Spool and pumps that programs move


class Order(NamedTuple):
    position: Position
    speed: Speed
    motor_speed: Speed


def order(t: float, memory: Any, reading: Level, settings: Any) -> tuple[Any, Order]:
    return memory, Order(5e-3, 188.0, 0.0)


ORDER = ProgramType(order, Level, Order(5e-3, 188.0, 0.0))


def test_program_moves_spool_and_shafts(of):
    """A command is as good as a number."""
    unit = prototype_unit()
    found = []
    for moves in (Moves(188.0, 5e-3, 0.0), Moves("moves.speed", "moves.position", "moves.motor_speed")):
        net = Network(unit.oil)
        net.tank("tank")
        net.volume("load_line", of.chamber, start=1e6)
        net.add("load", ORIFICE, of.orifice, a="load_line", b="tank", area=1e-5)
        add_unit(net, unit, "load_line", moves)
        net.program("moves", ORDER, reads={"pressure": "inlet.pressure"})
        circuit = build(net)
        rates, outputs, _ = circuit.model.circuit(0.01, circuit.case.state, circuit.case.command, circuit.case.params)
        found.append((rates.inlet, rates.spool.speed, outputs.pump_flow, outputs.valve_load_opening))
        assert outputs.pump_flow > 0.0
    assert found[0] == found[1]


def test_command_turns_a_pump(oil, of):
    net = Network(oil)
    net.tank("tank")
    net.volume("line", of.chamber, start=2e6)
    net.driven_shaft("shaft", "moves.speed")
    net.add("pump", PUMP, replace(of.pump, ripple_amplitude=0.0), inlet="tank", outlet="line", shaft="shaft")
    net.program("moves", ORDER, reads={"pressure": "line.pressure"})
    found = run(net, Stepping(until=0.01))
    assert found.state.shaft[-1] == pytest.approx(1.88)


# What is refused


@pytest.mark.parametrize(
    ("reads", "told"),
    [
        ({"pressure": "lime.pressure"}, "'lime.pressure' " + wording.network.leads_nowhere.format(meant="line")),
        (
            {"pressure": "line.presure"},
            wording.network.node_has_no.format(node="line", name="presure", meant="pressure"),
        ),
        ({"pressure": "load.flow"}, r"controller.pressure is a pressure level \[Pa\], 'load.flow' is a volume flow"),
        ({"pressure": "line.enthalpy"}, "'line.enthalpy', " + wording.network.no_sensor_measures),
        ({}, wording.network.reads_differs.format(kind="pressure")),
        ({"pressure": "line.pressure", "flow": "load.flow"}, wording.network.differ_in.format(kind="flow")),
    ],
)
def test_reading_that_is_none(oil, of, reads, told):
    net = Network(oil)
    net.tank("tank")
    net.volume("line", of.chamber, start=2e6)
    net.add("load", ORIFICE, of.orifice, a="line", b="tank", area=1e-6)
    with pytest.raises(NetworkError, match=told):
        net.program("controller", CONTROL, GAIN, reads=reads)
        build(net)


def test_event_program_reads_states_alone(oil, of):
    net = Network(oil)
    net.tank("tank")
    net.volume("line", of.chamber, start=2e6)
    net.add("load", ORIFICE, of.orifice, a="line", b="tank", area=constant(1e-6))
    net.program("switch", UNLOADING, UnloadingSettings(cut_out_pressure=2e7, cut_in_pressure=1e7),
                reads={"pilot_pressure": "tank.pressure"})  # fmt: skip
    with pytest.raises(NetworkError, match=wording.network.reads_states_alone):
        build(net)


def test_settings_of_another_class_are_refused(controlled, of):
    net = controlled()
    with pytest.raises(NetworkError, match=wording.network.expected_program.format(program="Gain")):
        net.program("second", CONTROL, of.orifice, reads={"pressure": "line.pressure"})


class ShaftReading(NamedTuple):
    speed: Speed


class SeenSpeed(NamedTuple):
    speed: Speed


def show_speed(t: float, memory: Any, reading: ShaftReading, settings: Any) -> tuple[Any, SeenSpeed]:
    return memory, SeenSpeed(reading.speed)


def test_a_program_reads_the_speed_of_a_driven_shaft(oil, of):
    net = Network(oil)
    net.tank("tank")
    net.volume("line", of.chamber, start=1e6)
    net.driven_shaft("shaft", 150.0)
    net.add("pump", PUMP, of.pump, inlet="tank", outlet="line", shaft="shaft")
    net.add("load", ORIFICE, of.orifice, a="line", b="tank", area=1e-5)
    net.program("sensor", ProgramType(show_speed, ShaftReading, SeenSpeed(0.0)), reads={"speed": "shaft.speed"})
    run = simulate(build(net).model, build(net).case, Stepping(until=2e-3))
    assert np.all(run.command.sensor.speed[1:] == 150.0)


class Pair(NamedTuple):
    time: Time
    pressure: Pressure


def held_pressure(t, memory, reading, settings):
    return memory, Sum(settings.gain * (reading.pressure - settings.reference) + 0.0 * reading.time + 0.5)


@pytest.mark.parametrize("names", [("time", "pressure"), ("pressure", "time")])
def test_readings_behind_instruments_keep_their_names(oil, of, names):
    """However `reads` is ordered."""
    net = Network(oil)
    net.tank("tank")
    net.volume("line", of.chamber, start=2e6)
    net.add("load", ORIFICE, of.orifice, a="line", b="tank", area=1e-6)
    paths = {"time": "t", "pressure": "line.pressure"}
    kind = ProgramType(held_pressure, Pair, Sum(0.5), Gain, lambda settings: Sum(0.5))
    net.program("watch", kind, GAIN, reads={n: paths[n] for n in names}, sensors={"time": ideal_instrument(0.0, 1e6)})
    circuit = build(net)
    program = circuit.model.programs["watch"]
    case = circuit.case
    reading = program.measure(0.25, case.state, None, case.params)
    _, command = program.step(0.25, case.memory["watch"], reading, case.settings["watch"])
    assert command.opening == GAIN.gain * (2e6 - GAIN.reference) + 0.5
