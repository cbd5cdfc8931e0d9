"""A network being drawn: nodes, components between them, programs that watch and command it."""

import keyword
import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from types import NoneType
from typing import Any

from vvdp.base.errors import NetworkError
from vvdp.base.kinds import PRESSURE_LEVEL, Kind
from vvdp.base.params import Params, field_kinds
from vvdp.base.signal import Signal, constant, signal_value
from vvdp.base.tables import nearest
from vvdp.fluid.oil import Oil, modulus_at
from vvdp.hydraulics.pipe import LinePipe
from vvdp.hydraulics.volume import Vessel
from vvdp.network.assembly import Assembly, Group, InnerCircuit
from vvdp.network.component import Component, Role, check_component
from vvdp.network.nodes import (
    UNRATED,
    Chamber,
    Connection,
    DrivenShaft,
    HydraulicNode,
    Junction,
    Load,
    Node,
    OilVolume,
    PressureSource,
    Rod,
    Rotor,
    Shaft,
    Source,
    Start,
    Tank,
    kind_of_node,
)
from vvdp.network.program import ProgramType
from vvdp.sensing.instrument import Instrument
from vvdp.simulation.values import leaves, names

ROOM_TEMPERATURE = constant(313.15)
"""Temperature of the oil where none is given: 40 degC, at which data sheets give the density."""
RESERVED = frozenset(
    (
        *("t", "s", "u", "p", "h", "m", "r", "z", "rates", "books", "start", "held", "medium", "temperature", "energy"),
        *("oil", "state", "outputs", "params", "command", "values", "total", "transition", "full_open", "time"),
        *("next_stop", "taken_in", "check", "modes"),
    )
)
NAME = re.compile(r"[a-z][a-z0-9_]*")
NEARLY_VACUUM = 1e3
"""A pressure below this [Pa, absolute] was meant in another unit."""
JOINS = {
    Role.PORT: (OilVolume, Tank, PressureSource, Junction),
    Role.SHAFT: (Shaft, DrivenShaft),
    Role.SHAFT_SPEED: (Shaft, DrivenShaft),
    Role.ROD: (Rod,),
}


@dataclass(frozen=True)
class Part:
    """A component in its place: the values, the nodes at its ports, the sources of its inputs, its first state."""

    name: str
    component: Component
    values: tuple[Params, ...]
    nodes: Mapping[str, str]
    inputs: Mapping[str, Source]
    start: Any = None


@dataclass(frozen=True)
class ProgramPart:
    """A program in its place: what it reads, its values, the sensors before it, and when it is called [s].

    `actuators` stand behind it: what becomes of fields of its command on their way to the circuit. Of the fields
    `previous` it reads the commands that other programs gave before this instant.
    """

    name: str
    type: ProgramType
    settings: Params | None
    reads: Mapping[str, Source]
    sensors: Mapping[str, Instrument]
    period: float | None
    phase: float
    latency: float
    previous: frozenset[str] = frozenset()
    actuators: Mapping[str, Instrument] = field(default_factory=dict)


class Network:
    """Nodes, components and programs by name, in the order in which they were added.

    `values` are parameter classes that components share, or that hold the signals that are connected to them; they
    appear under their names in the parameters of the circuit. Each method that adds raises `NetworkError` where a
    name is taken or cannot be one, a node is unknown, a port is open or joins the wrong kind of node, or an input is
    missing. `extras` makes of a system what it brings along beyond others: numbers, figures. Where several components
    mark periods, a period ends by those of the one that was added first.
    """

    def __init__(self, oil: Oil, *, temperature: Signal = ROOM_TEMPERATURE, **values: Params) -> None:
        if reserved := RESERVED & values.keys():
            raise NetworkError(f"{min(reserved)!r} is reserved; call the values otherwise")
        self.temperature = _check_source("temperature", temperature)
        self._oils: dict[Oil, Oil] = {}
        self.oil = self._at_first(oil)
        own = {name: self._at_first(value) if isinstance(value, Oil) else value for name, value in values.items()}
        self.values: dict[str, Params] = {"oil": self.oil, **own}
        self.nodes: dict[str, Node] = {}
        self.parts: dict[str, Part] = {}
        self.programs: dict[str, ProgramPart] = {}
        self.positions: dict[str, tuple[float, float]] = {}
        self.groups: dict[str, Group] = {}
        self.circuits: dict[str, InnerCircuit] = {}
        self.extras: Callable[[Any, Mapping[str, Any]], Any] | None = None

    def volume(self, name: str, values: Chamber | Vessel, *, start: Start, oil: Oil | None = None) -> None:
        """Add oil under one pressure, at first `start` [Pa, absolute]."""
        _check_values(name, values, Chamber, Vessel)
        _check_pressure(name, "start", self.start_value(start))
        self._add_node(OilVolume(name, values, start, self._at_first(oil or self.oil)))

    def tank(self, name: str, pressure: Signal | None = None, oil: Oil | None = None) -> None:
        """Add a tank, at the oil's reference pressure or another [Pa, absolute]."""
        medium = self._at_first(oil or self.oil)
        held = constant(medium.reference_pressure) if pressure is None else _check_source(name, pressure)
        _check_pressure(name, "pressure", *held.extremes)
        self._add_node(Tank(name, held, medium))

    def pressure_source(self, name: str, pressure: Source, oil: Oil | None = None) -> None:
        """Add a source or sink that holds its pressure [Pa, absolute]."""
        source = _signal(name, pressure)
        if isinstance(source, Signal):
            _check_pressure(name, "pressure", *source.extremes)
        self._add_node(PressureSource(name, source, self._at_first(oil or self.oil)))

    def junction(self, name: str, oil: Oil | None = None) -> None:
        """Add a place without oil, whose pressure is the one at which as much flows in as out."""
        self._add_node(Junction(name, self._at_first(oil or self.oil)))

    def shaft(self, name: str, values: Rotor | None = None, *, angle: Start = 0.0, speed: Start = 0.0) -> None:
        """Add a shaft that turns freely, at first at `angle` [rad] with `speed` [rad/s]."""
        _check_values(name, values, Rotor, NoneType)
        self._add_node(Shaft(name, values, angle, speed))

    def driven_shaft(self, name: str, speed: Source, rated_power: float = UNRATED) -> None:
        """Add a shaft whose speed [rad/s] is prescribed or commanded, by a drive of a rated power [W]."""
        self._add_node(DrivenShaft(name, _signal(name, speed), rated_power))

    def rod(self, name: str, values: Load | None = None, *, position: Start = 0.0, velocity: Start = 0.0) -> None:
        """Add a mass that moves along a line, at first at `position` [m] with `velocity` [m/s]."""
        _check_values(name, values, Load, NoneType)
        self._add_node(Rod(name, values, position, velocity))

    def add(self, name: str, component: Component, *values: Params, start: Any = None, **joints: Source) -> None:
        """Add a component; `joints` give the node of each port and the source of each input, by their names."""
        self.check_name(name)
        check_component(component)
        classes = component.params
        if [type(v) for v in values] != list(classes) and not all(map(isinstance, values, classes)):
            expected = ", ".join(c.__name__ for c in classes) or "none"
            given = ", ".join(type(v).__name__ for v in values) or "none"
            raise NetworkError(f"{name}: {component.name} takes the values {expected}; {given} given")
        if len(values) != len(classes):
            raise NetworkError(
                f"{name}: {component.name} takes {len(classes)} parameter classes, "
                f"{', '.join(c.__name__ for c in classes)}; {len(values)} given"
            )
        component = component.suited(*values) if component.suited else component
        nodes = {
            port: self._node_at(name, port, role, joints.pop(port, None)) for port, role in component.ports.items()
        }
        inputs = {a.name: self._source(name, a.name, a.kind, joints.pop(a.name, a.default)) for a in component.inputs}
        if joints:
            known = [*component.ports, *(a.name for a in component.inputs)]
            raise NetworkError(
                f"{name}: {component.name} has no port or input {next(iter(joints))!r}"
                + nearest(next(iter(joints)), known)
            )
        self._check_oils(name, component, nodes)
        _check_start(name, component, start)
        self.parts[name] = Part(name=name, component=component, values=values, nodes=nodes, inputs=inputs, start=start)

    def add_chain(
        self,
        name: str,
        assembly: Assembly,
        pipe: LinePipe,
        nodes: Mapping[str, str],
        components: tuple[Component, Component],
        start: Start,
    ) -> None:
        """Add a pipe as a chain: volumes `name_1` ..., columns between them, and at the ends the first component."""
        self.check_name(name)
        _check_pressure(name, "start", self.start_value(start))
        if self.values.get(name, pipe) is not pipe:
            raise NetworkError(f"{name}: the network has other values of this name")
        self.values[name] = pipe
        ends = [self._node_at(name, port, Role.PORT, nodes.get(port)) for port in assembly.ports]
        node = self.nodes[ends[0]]
        assert isinstance(node, HydraulicNode)
        inside = [f"{name}_{i}" for i in range(1, int(pipe.pieces) + 1)]
        for volume in inside:
            self.check_name(volume)
            self.nodes[volume] = OilVolume(volume, pipe, start, node.oil)
        column, piece = components
        places = [ends[0], *inside, ends[1]]
        parts = [
            f"{name}_from_{ends[0]}",
            *(f"{name}_{i}_to_{i + 1}" for i in range(1, len(inside))),
            f"{name}_to_{ends[1]}",
        ]
        for number, part in enumerate(parts):
            law = piece if 0 < number < len(parts) - 1 else column
            self.add(part, law, pipe, a=places[number], b=places[number + 1])
        self.groups[name] = Group(
            assembly, pipe, dict(zip(assembly.ports, ends, strict=True)), tuple(parts), tuple(inside)
        )

    def program(
        self,
        name: str,
        kind: ProgramType,
        settings: Params | None = None,
        *,
        reads: Mapping[str, Source | float],
        sensors: Mapping[str, Instrument] | None = None,
        period: float | None = None,
        phase: float = 0.0,
        latency: float = 0.0,
        previous: bool | Collection[str] = False,
    ) -> None:
        """Add a program that is called at `phase` and every `period` [s], and acts `latency` [s] later.

        `reads` gives the path of each field of its reading: "t", a node's "inlet.pressure", a result "load.flow",
        another program's "encoder.speed" (as it is at this instant; of the fields that `previous` names, or of all
        with True, as it was before), or a value over time; `sensors` the instruments through which fields are measured.
        """
        self.check_name(name)
        fields, usual = set(names(kind.reading)), set(kind.defaults)
        if odd := (set(reads) - fields) | (fields - usual - set(reads)):
            raise NetworkError(f"{name}: its reading and what `reads` gives differ in {', '.join(sorted(odd))}")
        if unknown := set(sensors or {}) - fields:
            raise NetworkError(f"{name}: a sensor for {', '.join(sorted(unknown))}, which it does not read")
        if kind.settings is not None and not isinstance(settings, kind.settings):
            raise NetworkError(f"{name}: settings are {settings!r}; expected {kind.settings.__name__}")
        self.programs[name] = ProgramPart(
            name=name,
            type=kind,
            settings=settings,
            reads={field: self._read(name, kind, field, source) for field, source in reads.items()},
            sensors=dict(sensors or {}),
            period=period,
            phase=phase,
            latency=latency,
            previous=frozenset(reads if previous is True else previous or ()),
        )

    def _read(self, name: str, kind: ProgramType, field: str, source: Source | float) -> Source:
        if isinstance(source, Connection):
            raise NetworkError(f"{name}.{field}: a program reads one quantity; write a program that combines several")
        return self._source(name, field, field_kinds(kind.reading)[field], source)

    def place(self, name: str, x: float, y: float) -> None:
        """Draw the node or component `name` at a place of the diagram's grid."""
        self.positions[name] = (float(x), float(y))

    def parts_inside(self, circuit: str) -> tuple[str, ...]:
        """Names of the components inside of a circuit that is one part, those of its pipes included."""
        names = self.circuits[circuit].names
        pieces = {piece for name, group in self.groups.items() if name in names for piece in group.parts}
        return tuple(name for name in self.parts if name in names or name in pieces)

    def start_value(self, start: Start) -> float:
        """The number of a start value. Raises NetworkError where its path leads nowhere."""
        if not isinstance(start, str):
            return float(start)
        table, _, key = start.partition(".")
        found = getattr(self.values.get(table), key, None)
        if not isinstance(found, int | float):
            raise NetworkError(
                f"start {start!r} is neither a number in SI nor the path of one among {', '.join(self.values)}"
            )
        return float(found)

    def _at_first(self, oil: Oil) -> Oil:
        """The oil with the modulus that it has when a run begins, and keeps: the one place where that is set."""
        if oil.bulk_modulus_fall == 0.0:
            return oil
        modulus = float(modulus_at(signal_value(0.0, self.temperature), oil))
        return self._oils.setdefault(oil, replace(oil, liquid_bulk_modulus=modulus, bulk_modulus_fall=0.0))

    def _add_node(self, node: Node) -> None:
        self.check_name(node.name)
        self.nodes[node.name] = node

    def check_name(self, name: str) -> None:
        """Raises NetworkError where `name` cannot be given to a further node, component or program."""
        if not NAME.fullmatch(name):
            raise NetworkError(f"{name!r} cannot be a name; use small letters, digits and _, beginning with a letter")
        if name in RESERVED or keyword.iskeyword(name):
            raise NetworkError(
                f"the name {name!r} is reserved for the equations that are written from the network; choose another, "
                f"for example '{name}_1'"
            )
        if any(name in taken for taken in (self.nodes, self.parts, self.programs, self.groups)):
            raise NetworkError(f"the name {name!r} is taken; nodes, components and programs need one each")

    def _node_at(self, name: str, port: str, role: Role, node: object) -> str:
        if node is None:
            fit = [n for n, value in self.nodes.items() if isinstance(value, JOINS[role])]
            raise NetworkError(f"{name}: port {port!r} is open; join it to one of {', '.join(fit) or 'no node yet'}")
        if not isinstance(node, str) or node not in self.nodes:
            raise NetworkError(
                f"{name}: port {port!r} ends at {node!r}, which is no node" + nearest(str(node), list(self.nodes))
            )
        if not isinstance(self.nodes[node], JOINS[role]):
            wanted = " or ".join(kind_of_node(cls) for cls in JOINS[role])
            raise NetworkError(
                f"{name}: port {port!r} joins a {wanted}; {node!r} is a {kind_of_node(self.nodes[node])}"
            )
        for group, whole in self.groups.items():
            if node in whole.nodes:
                raise NetworkError(f"{name}: port {port!r} ends at {node!r}, inside of {group!r}")
        return node

    def _source(self, name: str, key: str, kind: Kind | None, source: object) -> Source:
        if source is None:
            example = f", such as {kind.example!r}," if kind else ""
            raise NetworkError(f"{name}: input {key!r} is not connected; give a signal{example} or a path")
        signal = _signal(f"{name}.{key}", source)
        if not isinstance(signal, Signal):
            return signal
        for value in signal.extremes:
            if kind and (fault := kind.fault(value)):
                raise NetworkError(f"{name}.{key}: {fault}")
        return signal

    def _check_oils(self, name: str, component: Component, nodes: Mapping[str, str]) -> None:
        found = [(port, self.nodes[nodes[port]]) for port in component.hydraulic_ports]
        oils = {id(node.oil): node.oil for _, node in found if isinstance(node, HydraulicNode)}
        if len(oils) == 1 or not oils:
            return
        ends = ", ".join(f"{port} at {node.name}" for port, node in found)
        if not component.moves_walls:
            raise NetworkError(f"{name} joins nodes of different oils: {ends}")
        if len({oil.reference_pressure for oil in oils.values()}) > 1:
            raise NetworkError(f"{name} joins oils of different reference pressures: {ends}")


def _signal(name: str, source: object) -> Source:
    if isinstance(source, int | float):
        return constant(float(source))
    if isinstance(source, Connection):
        _check_connection(name, source)
    if isinstance(source, Signal | str | Connection):
        return source
    raise NetworkError(f"{name}: {source!r} is no source; expected a number in SI, a Signal, a path or a Connection")


def _check_source(name: str, source: object) -> Signal:
    found = _signal(name, source)
    if not isinstance(found, Signal):
        raise NetworkError(f"{name}: {source!r} is calculated once per sample; expected a number in SI or a Signal")
    return found


def _check_connection(name: str, connection: Connection) -> None:
    function = connection.function
    if not callable(function) or not hasattr(function, "__name__"):
        raise NetworkError(f"{name}: {function!r} cannot be connected; write a plain function")
    for source in connection.sources:
        if not isinstance(source, Signal | Params | str):
            raise NetworkError(
                f"{name}: {source!r} cannot be an argument of {function.__name__}; expected a Signal (constant(...) "
                "for a number), a path, or a parameter class"
            )


def _check_values(name: str, values: object, *classes: type) -> None:
    if not isinstance(values, classes):
        expected = " or ".join(cls.__name__ for cls in classes if cls is not NoneType)
        raise NetworkError(f"{name}: its values are {values!r}; expected {expected}")


def _check_start(name: str, component: Component, start: object) -> None:
    if start is None:
        return
    if component.state is None:
        raise NetworkError(f"{name}: {component.name} has no state, and nothing to start")
    if not isinstance(start, component.state):
        raise NetworkError(f"{name}: starts from {start!r}; expected {component.state.__name__}")
    for path, value, kind in leaves(start):
        if not isinstance(value, int | float):
            raise NetworkError(f"{name}: {path!r} of its start is {value!r}; expected a number in SI")
        if kind and (fault := kind.fault(float(value))):
            raise NetworkError(f"{name}: start of {path!r}: {fault}")


def _check_pressure(name: str, what: str, *pressures: float) -> None:
    for pressure in pressures:
        if fault := PRESSURE_LEVEL.fault(pressure):
            raise NetworkError(f"{name}: {what} {fault}")
        if pressure < NEARLY_VACUUM:
            raise NetworkError(
                f"{name}: {what} {pressure:g} Pa absolute is nearly a vacuum; pressures are in Pa, not in bar"
            )
