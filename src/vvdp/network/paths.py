"""Where the parts of a network stand in the written circuit: parameters, start values, order, what meets at a node."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any

from vvdp.base.errors import NetworkError
from vvdp.base.kinds import ANGLE, POSITION, PRESSURE_LEVEL, SPEED, TEMPERATURE, VELOCITY, Kind
from vvdp.base.params import Params, field_kinds
from vvdp.base.signal import Signal
from vvdp.base.tables import nearest
from vvdp.network.component import Role
from vvdp.network.network import Network, Part
from vvdp.network.nodes import Connection, DrivenShaft, HydraulicNode, OilVolume, Rod, Shaft, Source, Start
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
    """What the writer asks of a network again and again."""

    def __init__(self, network: Network) -> None:
        self.network = network

    @cached_property
    def order(self) -> tuple[Part, ...]:
        """The parts in an order in which each finds what it needs. Raises NetworkError where there is none."""
        done: dict[str, Part] = {}
        for name in self.network.parts:
            self._place(name, done, [])
        return tuple(done.values())

    def _place(self, name: str, done: dict[str, Part], above: list[str]) -> None:
        if name in done:
            return
        if name in above:
            loop = " -> ".join([*above[above.index(name) :], name])
            raise NetworkError(
                f"each of these needs the other's result at the same instant: {loop}; put a state between"
            )
        for needed in self._needs(self.network.parts[name]):
            self._place(needed, done, [*above, name])
        done[name] = self.network.parts[name]

    def _needs(self, part: Part) -> Iterator[str]:
        parts = list(self.network.parts)
        for source in part.inputs.values():
            for path in paths_of(source):
                other, _, what = path.partition(".")
                if other in parts and not self._is_state(self.network.parts[other], what):
                    yield other
        if any(a.role is Role.SURPLUS for a in part.component.arguments):
            node = part.nodes[part.component.hydraulic_ports[0]]
            for met in self.attached(node):
                later = met.part.name in parts[parts.index(part.name) :]
                if met.part is not part and not (later and self._takes_surplus_of(met.part, node)):
                    yield met.part.name

    @staticmethod
    def _is_state(part: Part, name: str) -> bool:
        state = part.component.state
        return state is not None and name in names(state) and name not in part.component.outputs

    @staticmethod
    def _takes_surplus_of(part: Part, node: str) -> bool:
        takes = any(a.role is Role.SURPLUS for a in part.component.arguments)
        return takes and part.nodes[part.component.hydraulic_ports[0]] == node

    def attached(self, node: str) -> tuple[Attachment, ...]:
        """The ports that meet at a node, in the order of the parts."""
        return tuple(
            Attachment(part, port)
            for part in self.network.parts.values()
            for port, where in part.nodes.items()
            if where == node
        )

    @cached_property
    def turning(self) -> frozenset[str]:
        """Names of the driven shafts whose angle somebody needs."""
        ports = {
            part.nodes[port]
            for part in self.network.parts.values()
            for port, role in part.component.ports.items()
            if role is Role.SHAFT
        }
        sources = [path for part in self.network.parts.values() for s in part.inputs.values() for path in paths_of(s)]
        reads = [path for program in self.network.programs.values() for path in program.reads.values()]
        asked = {path.partition(".")[0] for path in (*sources, *reads) if path.endswith(".angle")}
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

    @staticmethod
    def _signals(name: str, kind: Kind | None, source: Source | None) -> Iterator[tuple[str, tuple[Any, Any]]]:
        if isinstance(source, Signal):
            yield name, (Annotated[Signal, kind], source)
        elif isinstance(source, Connection):
            for number, inner in enumerate(source.sources):
                if isinstance(inner, Signal | Params):
                    hint = Annotated[Signal, kind] if isinstance(inner, Signal) else type(inner)
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

    def unknown(self, where: str, path: str) -> NetworkError:
        """The error about a path that leads nowhere."""
        known = [*self.network.nodes, *self.network.parts, *self.network.programs]
        return NetworkError(f"{where}: {path!r} leads nowhere{nearest(path.partition('.')[0], known)}")


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
