"""Where the parts of a network stand in the written circuit: parameters, start values, order, what meets at a node."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any

from vvdp.base.errors import NetworkError
from vvdp.base.kinds import (
    ANGLE,
    FLOW,
    FORCE,
    NUMBER,
    POSITION,
    PRESSURE_LEVEL,
    SPEED,
    TEMPERATURE,
    TORQUE,
    VELOCITY,
    Kind,
)
from vvdp.base.params import Params, field_kinds
from vvdp.base.signal import Signal
from vvdp.base.tables import nearest
from vvdp.fluid.mixture import FluidState
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.ports import RodState, ShaftState
from vvdp.network.component import Role
from vvdp.network.network import Network, Part
from vvdp.network.nodes import (
    Connection,
    DrivenShaft,
    HydraulicNode,
    Junction,
    Node,
    OilVolume,
    PressureSource,
    Rod,
    Shaft,
    Source,
    Start,
    Tank,
)
from vvdp.simulation.values import leaves, names


@dataclass(frozen=True)
class StartValue:
    """One start value: its name, number, kind, and where it stands among the parameters."""

    name: str
    value: float
    kind: Kind
    path: str


@dataclass(frozen=True)
class Attachment:
    """A port of a part at a node."""

    part: Part
    port: str


class Places:
    """Lookup of nodes, parts and paths of a network for the writer of its circuit."""

    def __init__(self, network: Network) -> None:
        self.network = network

    @cached_property
    def early(self) -> tuple[str, ...]:
        """The nodes that need no result of a part, each behind those that it needs."""
        late = set(self.late)
        return tuple(name for name in self._sequence if name in self.network.nodes and name not in late)

    @cached_property
    def late(self) -> tuple[str, ...]:
        """The parts, and the nodes that follow results of theirs, each behind what it needs."""
        found: list[str] = []
        for name in self._sequence:
            is_sought = isinstance(self.network.nodes.get(name), Junction)
            if name in self.network.parts or is_sought or any(needed in found for needed in self._needs(name)):
                found.append(name)
        return tuple(found)

    @cached_property
    def order(self) -> tuple[Part, ...]:
        """The parts in an order in which each finds what it needs. Raises NetworkError where there is none."""
        return tuple(self.network.parts[name] for name in self.late if name in self.network.parts)

    @cached_property
    def _sequence(self) -> tuple[str, ...]:
        done: dict[str, None] = {}
        for name in (*self.network.nodes, *self.network.parts):
            self._place(name, done, [])
        return tuple(done)

    def _place(self, name: str, done: dict[str, None], above: list[str]) -> None:
        if name in done:
            return
        if name in above:
            loop = " -> ".join([*above[above.index(name) :], name])
            raise NetworkError(
                f"each of these needs the other's result at the same instant: {loop}; put a state between"
            )
        for needed in self._needs(name):
            self._place(needed, done, [*above, name])
        done[name] = None

    def _needs(self, name: str) -> Iterator[str]:
        """The nodes and parts that have to be calculated before one."""
        part, nodes = self.network.parts.get(name), self.network.nodes
        yield from self._read_by(name, sources_of(nodes[name]) if part is None else part.inputs.values())
        if part is None:
            if isinstance(nodes[name], Junction):
                for met in self.ports_at(name):
                    yield from (node for node in met.part.nodes.values() if not isinstance(nodes[node], Junction))
                    yield from self._read_by(met.part.name, met.part.inputs.values())
            return
        yield from part.nodes.values()
        if takes_surplus(part) and not self.at_junction(part):
            parts = list(self.network.parts)
            node = part.nodes[part.component.hydraulic_ports[0]]
            for met in self.ports_at(node):
                later = met.part.name in parts[parts.index(part.name) :]
                if met.part is not part and not (later and self._takes_surplus_of(met.part, node)):
                    yield met.part.name

    def _read_by(self, where: str, sources: Iterable[Source]) -> Iterator[str]:
        """Names that have to be calculated before a reader of `sources`."""
        found = (self.quantity(path, where).needs for source in sources for path in paths_of(source))
        yield from filter(None, found)

    @staticmethod
    def _takes_surplus_of(part: Part, node: str) -> bool:
        return takes_surplus(part) and part.nodes[part.component.hydraulic_ports[0]] == node

    def at_junction(self, part: Part) -> bool:
        """Whether a part joins a junction, where nothing is left over."""
        return any(isinstance(self.network.nodes[node], Junction) for node in part.nodes.values())

    def ports_at(self, node: str) -> tuple[Attachment, ...]:
        """The ports that meet at a node, in the order of the parts."""
        return tuple(
            Attachment(part, port)
            for part in self.network.parts.values()
            for port, where in part.nodes.items()
            if where == node
        )

    @cached_property
    def turning(self) -> frozenset[str]:
        """Names of the driven shafts whose angle is needed."""
        ports = {
            part.nodes[port]
            for part in self.network.parts.values()
            for port, role in part.component.ports.items()
            if role is Role.SHAFT
        }
        given = [source for part in self.network.parts.values() for source in part.inputs.values()]
        given += [source for node in self.network.nodes.values() for source in sources_of(node)]
        given += [source for program in self.network.programs.values() for source in program.reads.values()]
        sources = [path for source in given for path in paths_of(source)]
        asked = {path.partition(".")[0] for path in sources if path.endswith(".angle")}
        return frozenset(name for name, node in self.network.nodes.items() if isinstance(node, DrivenShaft)) & (
            ports | asked
        )

    @cached_property
    def fields(self) -> Mapping[str, tuple[Any, Any]]:
        """Type and value of each field of the parameters but `start`, by name. Raises NetworkError at a clash."""
        found: dict[str, tuple[Any, Any]] = {name: (type(value), value) for name, value in self.network.values.items()}
        known = {id(value) for value in self.network.values.values()}
        known |= {id(signal) for value in self.network.values.values() for _, signal in signals_of(value)}
        for name, (kind, value) in self._own_values():
            if id(value) in known:
                continue
            if name in found:
                raise NetworkError(f"two different values would be called {name!r}; rename one of them")
            found[name], known = (kind, value), known | {id(value)}
        return found

    def _own_values(self) -> Iterator[tuple[str, tuple[Any, Any]]]:
        net = self.network
        yield "temperature", (Annotated[Signal, TEMPERATURE], net.temperature)
        for name, node in net.nodes.items():
            values = getattr(node, "values", None)
            if values is not None:
                yield name, (type(values), values)
            if isinstance(node, HydraulicNode) and node.oil is not net.oil:
                yield f"{name}_oil", (type(node.oil), node.oil)
            for key, kind in (("pressure", PRESSURE_LEVEL), ("speed", SPEED)):
                yield from self._signals(f"{name}_{key}", kind, getattr(node, key, None))
        for name, part in net.parts.items():
            roles = [a.name for a in part.component.arguments if a.role is Role.PARAMS]
            for i, (key, value) in enumerate(zip(roles, part.values, strict=True)):
                yield (name if i == 0 else f"{name}_{key}"), (type(value), value)
            for argument in part.component.inputs:
                yield from self._signals(f"{name}_{argument.name}", argument.kind, part.inputs[argument.name])
        for name, program in net.programs.items():
            for field, of in field_kinds(program.type.reading).items():
                yield from self._signals(f"{name}_{field}", of, program.reads.get(field))

    @staticmethod
    def _signals(name: str, kind: Kind | None, source: Source | None) -> Iterator[tuple[str, tuple[Any, Any]]]:
        if isinstance(source, Signal):
            yield name, (Annotated[Signal, kind], source)
        elif isinstance(source, Connection):
            for number, inner in enumerate(source.sources):
                if isinstance(inner, Signal | Params):
                    hint = Annotated[Signal, NUMBER] if isinstance(inner, Signal) else type(inner)
                    yield (name if number == 0 else f"{name}_{number}"), (hint, inner)

    @cached_property
    def _by_identity(self) -> Mapping[int, str]:
        found = {}
        for name, (_, value) in self.fields.items():
            found[id(value)] = f"p.{name}"
            if isinstance(value, Params):
                found |= {id(signal): f"p.{name}.{key}" for key, signal in signals_of(value)}
        return found

    def path(self, value: Params | Signal) -> str:
        """Where a value stands among the parameters, such as `p.operation.pump_speed`."""
        return self._by_identity[id(value)]

    @cached_property
    def oils(self) -> tuple[str, ...]:
        """Names of the oils that nodes hold."""
        return tuple(dict.fromkeys(n for n in map(self.oil_name, self.network.nodes) if n))

    def oil_name(self, node: str) -> str:
        """The name of the oil in a node; empty where there is none."""
        held = self.network.nodes[node]
        return self.oil_name_of(held.oil) if isinstance(held, HydraulicNode) else ""

    def oil_name_of(self, oil: Oil) -> str:
        """Where an oil stands among the parameters."""
        return self.path(oil).removeprefix("p.")

    @cached_property
    def starts(self) -> Mapping[str, tuple[StartValue, ...]]:
        """The start values of each node and part that has any."""
        found: dict[str, tuple[StartValue, ...]] = {}
        for name, node in self.network.nodes.items():
            match node:
                case OilVolume():
                    found[name] = (self._start_value(name, node.start, PRESSURE_LEVEL),)
                case Shaft():
                    places = {"angle": (node.angle, ANGLE), "speed": (node.speed, SPEED)}
                    found[name] = tuple(self._start_value(f"{name}_{k}", v, kind) for k, (v, kind) in places.items())
                case Rod():
                    places = {"position": (node.position, POSITION), "velocity": (node.velocity, VELOCITY)}
                    found[name] = tuple(self._start_value(f"{name}_{k}", v, kind) for k, (v, kind) in places.items())
        for name, part in self.network.parts.items():
            if part.start is not None:
                found[name] = tuple(
                    self._start_value(f"{name}_{path.replace('.', '_')}", float(value), kind)
                    for path, value, kind in leaves(part.start)
                    if kind
                )
        return found

    def _start_value(self, name: str, start: Start, kind: Kind) -> StartValue:
        path = f"p.{start}" if isinstance(start, str) else f"p.start.{name}"
        return StartValue(name, self.network.start_value(start), kind, path)

    def quantity(self, path: str, where: str) -> "Quantity":
        """The quantity that a path leads to. Raises NetworkError, which names `where` it is read, if there is none."""
        name, _, what = path.partition(".")
        net = self.network
        found: dict[str, Quantity] = {}
        if node := net.nodes.get(name):
            found = self._node_quantities(name, node)
        elif part := net.parts.get(name):
            found = _part_quantities(part)
        elif program := net.programs.get(name):
            recorded = {key: f"outputs.{name}_{key}" for key in names(program.type.command)}
            kinds = field_kinds(type(program.type.command))
            now = {key: f"u.{name}.{key}" for key in recorded}
            now |= {key: f"({now[key]} + {now[key]}_rate * (t - u.{name}.time))" for key in program.type.ramps}
            found = {key: Quantity(now[key], kinds[key] or NUMBER, "", text) for key, text in recorded.items()}
        if what in found:
            return found[what]
        if found and not what:
            expected = ", ".join(repr(f"{name}.{key}") for key in found)
            raise NetworkError(f"{where}: {path!r} is the name of a part, not of a quantity; expected {expected}")
        if found:
            raise NetworkError(f"{where}: {name!r} has no {what!r}{nearest(what, list(found))}")
        known = [*net.nodes, *net.parts, *net.programs]
        text = "" if "." in path else " (a text is the path of a quantity, such as 'inlet.pressure')"
        raise NetworkError(f"{where}: {path!r} leads nowhere{text}{nearest(name, known)}")

    def _node_quantities(self, name: str, node: Node) -> "dict[str, Quantity]":
        match node:
            case Shaft():
                recorded = {key: f"s.{name}.{key}" for key in names(ShaftState)}
            case Rod():
                recorded = {key: f"s.{name}.{key}" for key in names(RodState)}
            case DrivenShaft():
                recorded = {"angle": f"s.{name}", "speed": f"outputs.{name}_speed"}
            case OilVolume():
                recorded = {"pressure": f"s.{name}"}
            case _:
                recorded = {"pressure": f"outputs.{name}_pressure"}
        cls: type = RodState if isinstance(node, Rod) else ShaftState
        if isinstance(node, HydraulicNode):
            cls = FluidState
        kinds = field_kinds(cls)
        return {key: Quantity(f"{name}.{key}", kinds[key] or NUMBER, name, recorded.get(key, "")) for key in kinds}


def moving_parts(network: Network) -> tuple[str, ...]:
    """The components without ports that move something along a line themselves."""
    parts = network.parts.values()
    return tuple(p.name for p in parts if not p.component.ports and "position" in names(p.component.state))


def flows_of(part: Part) -> dict[str, str]:
    """Names and texts of the flows of a part: one through it, into its second port, or one into each port."""
    component = part.component
    ports = component.hydraulic_ports
    if component.is_passage:
        return {"flow": f"{part.name}.flow"}
    given = [port for port in ports if port in names(component.result)]
    if len(ports) == 2:
        return {"flow": f"{part.name}.{ports[1]}"} if ports[1] in given else {}
    return {f"{port}_flow": f"{part.name}.{port}" for port in given}


def tank_exchanges(places: Places, oil: str = "") -> dict[str, str]:
    """Names and texts of the flows into tanks and pressure sources, of all or of those of one oil, each through one
    port.
    """
    found = {}
    for node, held in places.network.nodes.items():
        if not isinstance(held, Tank | PressureSource) or oil not in ("", places.oil_name(node)):
            continue
        for met in places.ports_at(node):
            component, name = met.part.component, f"{met.part.name}_{met.port}_flow"
            if met.port in component.ends:
                found[name] = f"{'-' if met.port == component.ends[0] else ''}{met.part.name}.flow"
            elif met.port in names(component.result):
                found[name] = f"{met.part.name}.{met.port}"
    return found


def averaged_flows(part: Part) -> dict[str, str]:
    """Those flows whose means are kept: what goes into the first of several ports is what comes out of the others."""
    found = flows_of(part)
    return dict(list(found.items())[1:]) if len(found) > 1 else found


def actual_flows(part: Part) -> dict[str, str]:
    """Names and texts of the flows of a part at the pressure of the port that they enter, whose means are kept."""
    entered = part.component.ends[1:] or part.component.hydraulic_ports[-1:]
    return {
        f"{name}_actual": f"{text} * {part.nodes[port]}.volume_ratio"
        for name, text in flows_of(part).items()
        for port in ([name.removesuffix("_flow")] if name != "flow" else entered)
    }


def part_outputs(part: Part) -> dict[str, tuple[str, Kind]]:
    """Names, texts and kinds of what a part shows: flows, outputs, torques and forces."""
    found = {name: (text, FLOW) for name, text in flows_of(part).items()}
    found |= {name: (f"{part.name}.{name}", kind) for name, kind in part.component.outputs.items()}
    for port, role in part.component.ports.items():
        if role is not Role.PORT and port in names(part.component.result):
            found[port] = (f"{part.name}.{port}", FORCE if role is Role.ROD else TORQUE)
    return found


def _part_quantities(part: Part) -> "dict[str, Quantity]":
    state = part.component.state
    kinds = {} if state is None else field_kinds(state)
    found = {
        key: Quantity(f"s.{part.name}.{key}", kind, "", f"s.{part.name}.{key}") for key, kind in kinds.items() if kind
    }
    recorded = {key: f"outputs.{part.name}_{key}" for key in part_outputs(part)}
    return found | {
        key: Quantity(text, kind, part.name, recorded[key]) for key, (text, kind) in part_outputs(part).items()
    }


@dataclass(frozen=True)
class Quantity:
    """What a path leads to: its text in the circuit, its kind, what has to be calculated before, and where a program
    finds it; empty where that is nothing and nowhere.
    """

    text: str
    kind: Kind
    needs: str
    recorded: str


def check_unit(where: str, wanted: Kind | None, path: str, found: Kind) -> None:
    """Refuse, with a NetworkError, what is joined to another unit than its own."""
    if wanted is None or ANY_UNIT & {wanted.name, found.name} or wanted.unit == found.unit:
        return
    raise NetworkError(
        f"{where} is {wanted.with_article} [{wanted.unit}], {path!r} is {found.with_article} [{found.unit}]; "
        f"the units must agree: a program commands {wanted.with_article} if its values have such units"
    )


ANY_UNIT = {"number", "measured value"}
"""Kinds that stand for whatever a program counts with."""


def takes_surplus(part: Part) -> bool:
    """Whether a part needs to know what all others give to the volume at its first port."""
    return any(a.role is Role.SURPLUS for a in part.component.arguments)


def sources_of(node: Node) -> tuple[Source, ...]:
    """The sources that prescribe a node."""
    match node:
        case Tank() | PressureSource():
            return (node.pressure,)
        case DrivenShaft():
            return (node.speed,)
    return ()


def signals_of(value: Params) -> Iterator[tuple[str, Signal]]:
    """The signals among the fields of a parameter class, by name."""
    for name in field_kinds(type(value)):
        if isinstance(signal := getattr(value, name), Signal):
            yield name, signal


def paths_of(source: Source) -> Iterator[str]:
    """The paths that a source reads."""
    if isinstance(source, str):
        yield source
    elif isinstance(source, Connection):
        yield from (inner for inner in source.sources if isinstance(inner, str))
