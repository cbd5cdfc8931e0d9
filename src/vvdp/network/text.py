"""The expressions of a written network: what its parts are called with, what meets at its nodes."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

from vvdp.base.params import Params
from vvdp.base.signal import Signal, signal_value
from vvdp.fluid.mixture import FluidState, fluid_state
from vvdp.hydraulics.ports import RodState, ShaftSpeed, ShaftState
from vvdp.network.classes import Classes
from vvdp.network.component import Argument, Role
from vvdp.network.folding import added
from vvdp.network.network import Network, Part
from vvdp.network.nodes import (
    Connection,
    DrivenShaft,
    HydraulicNode,
    Node,
    OilVolume,
    PressureSource,
    Rod,
    Shaft,
    Source,
    Tank,
)
from vvdp.network.paths import Places
from vvdp.simulation.values import names

PRESCRIBED = (Tank, PressureSource)


@dataclass
class Text:
    """The text of a network and the names that it uses."""

    places: Places
    classes: Classes
    names: dict[str, Any] = field(default_factory=dict)

    @property
    def network(self) -> Network:
        return self.places.network

    def use(self, value: Any, name: str | None = None) -> str:
        """The name under which the text knows a function or class."""
        wanted = name or value.__name__
        net = self.network
        taken = {*net.nodes, *net.parts, *net.programs}
        taken |= {*(f"{part}_walls" for part in net.parts), *(f"surplus_{node}" for node in net.nodes)}
        while wanted in taken or self.names.get(wanted, value) is not value:
            wanted += "_law" if callable(value) and not isinstance(value, type) else "_"
        self.names[wanted] = value
        return wanted

    def source(self, source: Source, where: str) -> str:
        """The expression of a source in the circuit."""
        if isinstance(source, str):
            return self.read(source, where)
        if isinstance(source, Connection):
            inner = ", ".join(
                self.places.path(x) if isinstance(x, Params) else self.source(x, where) for x in source.sources
            )
            return f"{self.use(source.function)}({inner})"
        assert isinstance(source, Signal)
        return f"{self.use(signal_value)}(t, {self.places.path(source)})"

    def read(self, path: str, where: str) -> str:
        """The expression of a path in the circuit: a node's quantity, an output, a state, a command."""
        name, _, what = path.partition(".")
        net = self.network
        if name in net.nodes and what in _quantities(net.nodes[name]):
            return path
        if name in net.parts:
            component = net.parts[name].component
            if what in component.outputs or (what == "flow" and component.is_passage):
                return path
            if component.state is not None and what in names(component.state):
                return f"s.{path}"
        if name in net.programs and what in type(net.programs[name].type.command)._fields:
            return f"u.{path}"
        raise self.places.unknown(where, path)

    def arguments(self, part: Part, function: Callable[..., Any]) -> str:
        """The arguments with which a function of a part is called."""
        return ", ".join(self._argument(part, argument) for argument in part.component.arguments_of(function))

    def _argument(self, part: Part, argument: Argument) -> str:
        match argument.role:
            case Role.PORT | Role.SHAFT | Role.ROD:
                return part.nodes[argument.name]
            case Role.SHAFT_SPEED:
                return f"{self.use(ShaftSpeed)}({part.nodes[argument.name]}.speed)"
            case Role.MEDIUM:
                return f"h.{self.medium(part)}"
            case Role.OIL:
                return self.places.path(self.oil(part))
            case Role.PARAMS:
                return self.places.path(self._value(part, argument))
            case Role.STATE:
                return f"s.{part.name}"
            case Role.HELD:
                return f"h.{part.name}"
            case Role.SURPLUS:
                node = part.nodes[part.component.hydraulic_ports[0]]
                walls = self.walls(node, "rate")
                return f"{node}.volume_ratio * surplus_{node}" + (f" - ({walls})" if walls else "")
            case Role.INPUT:
                return self.source(part.inputs[argument.name], f"{part.name}.{argument.name}")
        return "t"

    @staticmethod
    def _value(part: Part, argument: Argument) -> Params:
        found: Params = next(value for value in part.values if isinstance(value, argument.type))
        return found

    def oil(self, part: Part) -> Any:
        """The oil of a part: that of its first hydraulic port."""
        for port in part.component.hydraulic_ports:
            node = self.network.nodes[part.nodes[port]]
            assert isinstance(node, HydraulicNode)
            return node.oil
        return self.network.oil

    def medium(self, part: Part) -> str:
        """The field of what is held that has a part's oil at its temperature."""
        oil = self.oil(part)
        return "medium" if oil is self.network.oil else f"medium_{self.places.path(oil).removeprefix('p.')}"

    def walls(self, node: str, what: str) -> str:
        """The sum of volumes or rates of the walls that move in a node; empty without any."""
        found = [
            f"{m.part.name}_walls.{m.port}.{what}"
            for m in self.places.attached(node)
            if m.part.component.walls and m.port in m.part.component.hydraulic_ports
        ]
        return " + ".join(found)

    def given(self, node: str, *, without: Part | None = None) -> str:
        """The sum of what the parts at a node give to it: flows, torques or forces."""
        terms = []
        for met in self.places.attached(node):
            component = met.part.component
            if met.part is without:
                continue
            if component.is_passage and met.port in component.hydraulic_ports:
                sign = "-" if met.port == component.hydraulic_ports[0] else "+"
                terms.append((sign, f"{met.part.name}.flow"))
            elif met.port in names(component.result):
                terms.append(("+", f"{met.part.name}.{met.port}"))
        return added(terms)

    def node_lines(self, nodes: Iterable[str]) -> Iterator[str]:
        """Lines that say what is at nodes."""
        for name in nodes:
            node = self.network.nodes[name]
            match node:
                case OilVolume():
                    yield f"{name} = {self.use(fluid_state)}(s.{name}, {self.places.path(node.oil)})"
                case Tank():
                    yield f"{name} = h.{name}"
                case PressureSource():
                    pressure = self.source(node.pressure, name)
                    yield f"{name} = {self.use(fluid_state)}({pressure}, {self.places.path(node.oil)})"
                case DrivenShaft():
                    speed = self.source(node.speed, name)
                    turning = name in self.places.turning
                    parts = (
                        f"{self.use(ShaftState)}(s.{name}, {speed})" if turning else f"{self.use(ShaftSpeed)}({speed})"
                    )
                    yield f"{name} = {parts}"
                case _:
                    yield f"{name} = s.{name}"

    def call(self, part: Part, function: Callable[..., Any] | None) -> str:
        """A call of one of a part's functions."""
        assert function is not None
        return f"{self.use(function)}({self.arguments(part, function)})"


def _quantities(node: Node) -> tuple[str, ...]:
    match node:
        case Shaft() | DrivenShaft():
            return ShaftState._fields
        case Rod():
            return RodState._fields
    return FluidState._fields
