"""A circuit that a network writes against the same one written by hand: time per evaluation and per run."""

from functools import partial
from statistics import median
from typing import NamedTuple

import numpy as np

from benchmarks.measure import ROUNDS, interleaved, ratios, report, run_as_command, spread
from vvdp.base.conservation import Books, Stored
from vvdp.base.kinds import Area, Density, Energy, Flow, Kink, Mode, Pressure, PressureTime, TankVolume, Volume
from vvdp.base.params import Params
from vvdp.components.flow_sources import FLOW_SOURCE
from vvdp.components.library import UsualOil
from vvdp.components.resistances import ORIFICE
from vvdp.components.switching_valves import PULSED_SWITCHING_VALVE, PulsedThreeWayValve
from vvdp.fluid.mixture import fluid_state
from vvdp.fluid.oil import Oil, density
from vvdp.hydraulics.flow import flow_side, passage
from vvdp.hydraulics.flow_source import FlowSource
from vvdp.hydraulics.orifice import Orifice, orifice_flow
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
from vvdp.network.network import Network
from vvdp.network.nodes import Chamber
from vvdp.simulation.layout import vectors
from vvdp.simulation.link import link
from vvdp.simulation.model import Case, Model
from vvdp.simulation.run import Stepping, simulate

OIL = UsualOil()
VALVE = PulsedThreeWayValve(
    natural_frequency=200.0, damping_ratio=0.7, stroke=1e-3, lap=-1e-4, full_area=3e-5,
    discharge_coefficient=0.61, transition_pressure=5e3, frequency=75.0, duty_ratio=0.5,
)  # fmt: skip
ORIFICE_VALUES = Orifice(discharge_coefficient=0.61, transition_pressure=5e3)
FLOW, INLET, LOAD, AREA = 20e-3 / 60.0, 20e-6, 200e-6, 4.7e-6
EVALUATIONS = 20_000


class Supplied(NamedTuple):
    pump: Energy


class Spent(NamedTuple):
    valve: Energy
    load: Energy


class Totals(NamedTuple):
    """As many as a network keeps."""

    tank_pressure: PressureTime
    inlet_pressure: PressureTime
    load_pressure: PressureTime
    pump_flow: TankVolume
    to_load: TankVolume
    to_tank: TankVolume
    load_flow: TankVolume


class State(NamedTuple):
    inlet: Pressure
    load_line: Pressure
    valve: SpoolState
    books: Books


class Outputs(NamedTuple):
    load_flow: Flow


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


class Values(Params):
    oil: Oil
    pump_flow: Flow
    inlet_volume: Volume
    valve: PulsedThreeWayValve
    load_volume: Volume
    load_area: Area
    orifice: Orifice


def conditions(t: float, p: Values) -> Held:
    """The oil's density at 40 degC."""
    return Held(density(313.15, p.oil))


def circuit(t: float, s: State, u: Command, p: Values) -> tuple[State, Outputs, Modes]:
    """A constant flow, an inlet, a switching valve on pulses, a load line and an orifice."""
    tank = fluid_state(p.oil.reference_pressure, p.oil)
    inlet, load = fluid_state(s.inlet, p.oil), fluid_state(s.load_line, p.oil)
    areas, rho = port_areas(s.valve.position, p.valve), u.held.density
    to_load = passage(orifice_flow(areas.first, s.inlet - s.load_line, rho, p.valve), inlet, load)
    to_tank = passage(orifice_flow(areas.second, s.inlet - p.oil.reference_pressure, rho, p.valve), inlet, tank)
    out = passage(orifice_flow(p.load_area, s.load_line - p.oil.reference_pressure, rho, p.orifice), load, tank)
    into_valve = -to_load.flow - to_tank.flow
    rates = State(
        inlet=closed_volume_rate(p.pump_flow + into_valve, 0.0, p.inlet_volume, inlet),
        load_line=closed_volume_rate(to_load.flow - out.flow, 0.0, p.load_volume, load),
        valve=spool_rate(pulse_train(t, p.valve), s.valve, u.modes.at_first, u.modes.at_second, p.valve),
        books=Books(
            supplied=Supplied(p.pump_flow * (inlet.enthalpy - tank.enthalpy)),
            spent=Spent(to_load.loss + to_tank.loss, out.loss),
            taken_in=p.pump_flow,
            given_out=to_tank.flow + out.flow,
            totals=Totals(tank.pressure, s.inlet, s.load_line, p.pump_flow, to_load.flow, to_tank.flow, out.flow),
        ),
    )
    sides = port_sides(s.valve.position, p.valve)
    ends = spool_ends(s.valve, u.modes.at_first, u.modes.at_second, p.valve)
    back, drained = flow_side(to_tank.flow), flow_side(out.flow)
    return rates, Outputs(out.flow), Modes(sides.first, sides.second, ends.first, ends.second, back, drained)


def stored(s: State, p: Values) -> Stored:
    """Energy and oil of both volumes."""
    inlet = closed_volume_contents(fluid_state(s.inlet, p.oil), p.inlet_volume, p.oil)
    load = closed_volume_contents(fluid_state(s.load_line, p.oil), p.load_volume, p.oil)
    return Stored(inlet.energy + load.energy, inlet.volume + load.volume)


def stop(t: float, u: Command, p: Values) -> float:
    """The next edge of the pulses."""
    return pulse_stop(t, p.valve)


def by_hand() -> tuple[Model, Case]:
    """The circuit above."""
    values = Values(
        oil=OIL, pump_flow=FLOW, inlet_volume=INLET, valve=VALVE, load_volume=LOAD, load_area=AREA,
        orifice=ORIFICE_VALUES,
    )  # fmt: skip
    books = Books(Supplied(0.0), Spent(0.0, 0.0), 0.0, 0.0, Totals(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    state = State(5e5, 10e5, SpoolState(0.0, 0.0), books)
    model = Model(circuit, stored=stored, conditions=conditions, stop=stop)
    return model, Case(state, values, Command(conditions(0.0, values), Modes(*[0.0] * 6)))


def as_network() -> tuple[Model, Case]:
    """The same drawn."""
    net = Network(OIL)
    net.tank("tank")
    net.volume("inlet", Chamber(volume=INLET), start=5e5)
    net.volume("load_line", Chamber(volume=LOAD), start=10e5)
    net.add("supply", FLOW_SOURCE, FlowSource(counted_at_outlet=0.0), a="tank", b="inlet", flow=FLOW)
    net.add("valve", PULSED_SWITCHING_VALVE, VALVE, pressure="inlet", first="load_line", second="tank")
    net.add("load", ORIFICE, ORIFICE_VALUES, a="load_line", b="tank", area=AREA)
    found = build(net)
    return found.model, found.case


def main(short: bool) -> None:
    """Compiles both, then takes them in turns."""
    until, count, rounds = (0.05, 200, 1) if short else (1.0, EVALUATIONS, ROUNDS)
    forms, stepping = {"by hand": by_hand(), "network": as_network()}, Stepping(until=until, window=0.1 * until)
    linked = {name: link(*form) for name, form in forms.items()}
    runs = {name: simulate(*form, stepping) for name, form in forms.items()}

    def evaluate(name: str) -> None:
        rates, flat = linked[name].rates, vectors(forms[name][1])
        dy = np.zeros(flat.state.size + len(forms[name][1].command.modes))
        for _ in range(count):
            rates(0.01, flat.state, flat.command, flat.params, dy)

    evaluations = interleaved({name: partial(evaluate, name) for name in forms}, rounds)
    whole = interleaved({name: partial(simulate, *form, stepping) for name, form in forms.items()}, rounds)
    for name in forms:
        report(f"evaluation, {name}", spread(evaluations[name], "us", 1e6 / count))
        report(f"run of {until:g} s, {name}", f"{spread(whole[name], 'ms', 1e3)}, {runs[name].steps} steps")
    for what, times, most in (("evaluation", evaluations, 1.05), ("run", whole, 1.10)):
        share = ratios(times, "network", "by hand")
        report(f"{what}, network over by hand", spread(share, "times"), f"{most:g}", median(share) <= most)
    assert runs["network"].steps == runs["by hand"].steps


if __name__ == "__main__":
    run_as_command(main)
