"""A rotary valve with the pump and the relief valve at its inlet, and where it works at the start of a run."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

from vvdp.base.display import with_unit
from vvdp.base.errors import ConfigError, Fault
from vvdp.base.kinds import PRESSURE_DIFFERENCE, TIME
from vvdp.base.params import Params
from vvdp.base.signal import Signal, signal_value
from vvdp.base.tables import nearest
from vvdp.evaluation.bench_parts import asked_duty_ratio
from vvdp.evaluation.valve_numbers import PlacedValve, placed_valves
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.pump import Pump
from vvdp.hydraulics.relief_valve import ReliefValve
from vvdp.network.network import Network, Part
from vvdp.network.nodes import Connection, DrivenShaft, OilVolume, Source
from vvdp.simulation.values import flat, leaves
from vvdp.systems.extras import LoadedSystem
from vvdp.valve.flow_map import quasi_steady_mean
from vvdp.valve.operating_point import OperatingPoint, SetPoint, operating_point
from vvdp.valve.rotary import RotaryValve

Values = TypeVar("Values", bound=Params)


@dataclass(frozen=True, kw_only=True)
class ValveUnit:
    """A rotary valve, what feeds it, and where it works at the start: pressures absolute [Pa].

    inlet_volume   between pump, relief valve and nozzles [m^3]
    pump_speed     [rad/s], and temperature of the oil [K]
    makes_pressure whether the load makes its own pressure; else a source holds it
    is_softened    whether more than pump and relief valve is joined to the inlet
    """

    valve: RotaryValve
    oil: Oil
    pump: Pump
    relief_valve: ReliefValve
    inlet_volume: float
    pump_speed: float
    temperature: float
    duty_ratio: float
    load_pressure: float
    tank_pressure: float
    makes_pressure: bool
    is_softened: bool

    @property
    def nominal_flow(self) -> float:
        """Flow that the pump displaces [m^3/s]."""
        return self.pump.displacement * self.pump_speed

    def set_point(self, load_pressure: float) -> SetPoint:
        """Where the valve works against `load_pressure` [Pa, absolute]."""
        return SetPoint(
            flow=self.nominal_flow,
            temperature=self.temperature,
            duty_ratio=self.duty_ratio,
            load_pressure=load_pressure,
            relief_pressure=self.relief_valve.cracking_pressure,
            tank_pressure=self.tank_pressure,
            relief_override=self.relief_valve.override_pressure,
            relief_rated_flow=self.relief_valve.rated_flow,
            pump_leakage=self.pump.leakage_conductance,
        )

    def operating_point(self, load_pressure: float) -> OperatingPoint:
        """The valve's analytic drops, speeds and losses against `load_pressure` [Pa, absolute]."""
        return operating_point(self.set_point(load_pressure), self.inlet_volume, self.oil, self.valve)

    def delivered_flow(self, load_pressure: float) -> float:
        """Flow that the pump delivers at its mean pressure [m^3/s]; `load_pressure` [Pa, absolute]."""
        point = self.set_point(load_pressure)
        if point.flow <= 0.0 or point.pump_leakage == 0.0:
            return point.flow
        return point.flow - quasi_steady_mean(point.duty_ratio, point.condition(self.oil), self.valve).pump_leakage_flow

    def average_limits(self) -> Iterator[str]:
        """Effects of the relief valve and of soft switching that no quasi-steady average contains, a sentence each."""
        relief = self.relief_valve
        if relief.opening_time > 0.0:
            lag = with_unit(relief.opening_time, TIME)
            yield f"the relief valve opens with a lag of {lag}, which is in no quasi-steady average"
        if relief.reseat_drop > 0.0:
            drop = with_unit(relief.reseat_drop, PRESSURE_DIFFERENCE)
            yield f"the relief valve closes only {drop} below its setting, which is in no quasi-steady average"
        if self.is_softened:
            yield "a check valve past the load port, or a chamber that takes the flow, is in no closed form"


def chosen_valve(system: LoadedSystem, verb: str, part: str = "", option: str = "--part") -> PlacedValve:
    """The rotary valve of a system; of several the one that is called `part`, or is alone in the part of that name.

    Raises ConfigError, which names `verb`, if there is none, or if `option` does not choose one of several.
    """
    found = {each.name: each for each in placed_valves(system.circuit.network)}
    name = part.replace(".", "_")
    if chosen := next((each for each in found.values() if name in (each.name, each.part.name)), None):
        return chosen
    names = ", ".join(found)
    if part and found:
        raise ConfigError([Fault(option, 0, part, f"no such rotary valve{nearest(name, list(found))}")])
    if len(found) != 1:
        several = f"has several: give {option}, one of {names}" if found else "has none"
        message = f"`vvdp {verb}` needs a pump unit with a rotary valve; this circuit {several}"
        raise ConfigError([Fault(system.name, 0, "", message)])
    return next(iter(found.values()))


def valve_unit(system: LoadedSystem, verb: str, part: str = "") -> ValveUnit:
    """The rotary valve of a system with what feeds it, found in its network.

    verb  that needs it, for messages
    part  name of the valve where there are several, or of the part that it is alone in

    Raises ConfigError if there is none, or no pump of fixed displacement or no relief valve at its inlet.
    """
    placed, network = chosen_valve(system, verb, part), system.circuit.network
    inlet, load, tank = (placed.part.nodes[port] for port in ("inlet", "load", "tank"))
    pump, pump_values = neighbour(network, Pump, "outlet", inlet) or _lacking(system, verb, placed.name, "pump")
    relief, relief_values = neighbour(network, ReliefValve, "a", inlet) or _lacking(
        system, verb, placed.name, "relief valve"
    )
    known, volume = start_numbers(system), network.nodes[inlet]
    assert isinstance(volume, OilVolume)
    beside = {each.name for each in network.parts.values() if inlet in each.nodes.values()}
    shaft = pump.nodes["shaft"]
    speed: Source = f"{shaft}.speed"
    if isinstance(node := network.nodes[shaft], DrivenShaft):
        speed = node.speed
    return ValveUnit(
        valve=placed.values,
        oil=volume.oil,
        pump=pump_values,
        relief_valve=relief_values,
        inlet_volume=float(getattr(volume.values, "volume", 0.0)),
        pump_speed=at_start(speed, known),
        temperature=float(signal_value(0.0, network.temperature)),
        duty_ratio=_duty_ratio(system, placed, known),
        load_pressure=pressure_at(network, load, known),
        tank_pressure=pressure_at(network, tank, known),
        makes_pressure=isinstance(network.nodes[load], OilVolume),
        is_softened=bool(beside - {placed.part.name, pump.name, relief.name}),
    )


def neighbour(network: Network, kind: type[Values], port: str, node: str) -> tuple[Part, Values] | None:
    """The component with values of a `kind` whose port is joined to a node."""
    for part in network.parts.values():
        for value in part.values:
            if isinstance(value, kind) and part.nodes.get(port) == node:
                return part, value
    return None


def _lacking(system: LoadedSystem, verb: str, name: str, what: str) -> Any:
    message = f"`vvdp {verb}` needs a {what} at the inlet of the rotary valve {name!r}; there is none"
    raise ConfigError([Fault(system.name, 0, "", message)])


def start_numbers(system: LoadedSystem) -> Mapping[str, float]:
    """Numbers of states and commands before the run, by their paths."""
    case = system.case
    values = (case.state, case.command)
    return {path: number for each in values for (path, _, _), number in zip(leaves(each), flat(each), strict=True)}


def at_start(source: Source, known: Mapping[str, float]) -> float:
    """The value of a source at the start; 0 where that is the output of a component."""
    if isinstance(source, Signal):
        return float(signal_value(0.0, source))
    if isinstance(source, Connection):
        values = (each if isinstance(each, Params) else at_start(each, known) for each in source.sources)
        return float(source.function(*values))
    return float(known.get(source, 0.0) if isinstance(source, str) else source)


def _duty_ratio(system: LoadedSystem, placed: PlacedValve, known: Mapping[str, float]) -> float:
    """The duty ratio at the start: as the file asks for it, else the axial position over the length of the helix."""
    asked = asked_duty_ratio(system)
    if asked is not None:
        return float(signal_value(0.0, asked))
    return at_start(placed.part.inputs["axial_position"], known) / placed.values.helix_length


def pressure_at(network: Network, name: str, known: Mapping[str, float]) -> float:
    """The pressure of a node at the start [Pa, absolute]."""
    node: Any = network.nodes[name]
    return float(known[name]) if isinstance(node, OilVolume) else at_start(node.pressure, known)
