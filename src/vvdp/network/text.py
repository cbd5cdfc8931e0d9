"""The expressions of a written network: what its parts are called with, what meets at its nodes."""

import keyword
import re
from collections.abc import Callable, Container, Iterable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from inspect import signature
from typing import Any

from vvdp.base.errors import NetworkError
from vvdp.base.kinds import PRESSURE_LEVEL, SPEED, Kind
from vvdp.base.params import Params, argument_kinds
from vvdp.base.signal import Signal, signal_value
from vvdp.fluid.mixture import aerated_state, fluid_state, is_plain, plain_state, state_at
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.heat import warm_medium
from vvdp.hydraulics.ports import ShaftSpeed, ShaftState
from vvdp.network.classes import Classes
from vvdp.network.component import Argument, Role
from vvdp.network.folding import signed_sum
from vvdp.network.heat import warm_volumes
from vvdp.network.network import Network, Part
from vvdp.network.nodes import (
    Connection,
    DrivenShaft,
    HydraulicNode,
    OilVolume,
    PressureSource,
    Source,
    Tank,
    free_air_name,
    has_free_air,
    is_held,
)
from vvdp.network.paths import Places, check_unit
from vvdp.simulation.values import names

PRESCRIBED = (Tank, PressureSource)
WRITTEN = frozenset(
    (
        *("circuit", "conditions", "stored", "start", "stop", "mark", "t", "s", "u", "p", "h", "m", "r", "z", "np"),
        *("rates", "outputs", "energy", "next_stop", "taken_in", "temperature", "medium", "program", "command"),
        *("Books", "Stored", "NOTHING", "EMPTY_BOOKS", "modes"),
        *("State", "Outputs", "Supplied", "Spent", "Totals", "Held", "Modes"),
    )
)
"""What the text calls its own functions, arguments, classes and values."""
OWN = {Role.TIME: "t", Role.STATE: "s.{}", Role.HELD: "h.{}", Role.MODE: "u.modes.{}_{}"}
"""Expressions of what stands under the name of a part, and under that of an argument of its law."""


@dataclass
class Text:
    """The text of a network and the names that it uses."""

    places: Places
    classes: Classes
    names: dict[str, Any] = field(default_factory=dict)

    @property
    def network(self) -> Network:
        """The network whose text this is."""
        return self.places.network

    def use(self, value: Any, name: str | None = None) -> str:
        """The name under which the text knows a function or class."""
        wanted = name or re.sub(r"\W", "", value.__name__)
        wanted += "_" if keyword.iskeyword(wanted) else ""
        taken = self._own_names
        while wanted in taken or self.names.get(wanted, value) is not value:
            wanted += "_law" if callable(value) and not isinstance(value, type) else "_"
        self.names[wanted] = value
        return wanted

    @cached_property
    def _own_names(self) -> frozenset[str]:
        """Names that the text gives to what is its own. Raises NetworkError where two would be the same."""
        net = self.network
        own = {*net.nodes, *net.parts, *net.programs}
        derived = {f"{word}_{name}" for name in net.nodes for word in ("surplus", "in", "into", "search")}
        derived |= {text for name in net.parts for text in (f"{name}_walls", f"in_{name}")}
        if self._warm_volumes:
            derived |= {f"{word}_{name}" for name in net.nodes for word in ("warm", "temperature", "heat", "walls")}
            derived |= {f"{word}_{name}" for name in net.parts for word in ("carried", "entering", "cooled")}
        aerated = {name for name, node in net.nodes.items() if has_free_air(node)}
        derived |= {free_air_name(name) for name in aerated} | ({f"air_{n}" for n in net.parts} if aerated else set())
        if twice := own & derived:
            raise NetworkError(f"{min(twice)!r} is what another name becomes in the text of the circuit; rename it")
        found = {f"{name}_oil" for name in net.nodes} | {f"medium_{name}" for name in net.values}
        found |= {f"medium_{name}_oil" for name in net.nodes}
        for name, program in net.programs.items():
            found |= {f"{word}_{name}" for word in ("measure", "trigger", "step", "begin")}
            found |= {field for read in program.sensors for field in (read, f"{read}_sensor")}
            found |= {field for acts in program.actuators for field in (f"{acts}_act", f"{acts}_actuator")}
        return frozenset({*WRITTEN, *own, *derived, *found})

    def source(self, source: Source, where: str, kind: Kind | None = None) -> str:
        """The expression of a source in the circuit, for what is of a `kind`."""
        if isinstance(source, str):
            found = self.places.quantity(source, where)
            check_unit(where, kind, source, found.kind)
            return found.text
        if isinstance(source, Connection):
            kinds, owner = argument_kinds(source.function), where.partition(".")[0]
            inner = ", ".join(
                self.places.path(x) if isinstance(x, Params) else self.source(x, f"{owner}.{name}", kinds.get(name))
                for name, x in zip(signature(source.function).parameters, source.sources, strict=False)
            )
            return f"{self.use(source.function)}({inner})"
        assert isinstance(source, Signal)
        return f"{self.use(signal_value)}(t, {self.places.path(source)})"

    def arguments(self, part: Part, function: Callable[..., Any]) -> str:
        """The arguments with which a function of a part is called."""
        return ", ".join(self._argument(part, function, each) for each in part.component.arguments_of(function))

    def _argument(self, part: Part, function: Callable[..., Any], argument: Argument) -> str:
        match argument.role:
            case Role.PORT | Role.SHAFT | Role.ROD:
                return part.nodes[argument.name]
            case Role.SHAFT_SPEED:
                return f"{self.use(ShaftSpeed)}({part.nodes[argument.name]}.speed)"
            case Role.MEDIUM:
                return self._warm_medium(part) if function is part.component.law else f"h.{self.medium(part)}"
            case Role.OIL:
                return self.places.path(self.oil(part))
            case Role.PARAMS:
                return self.places.path(self._value(part, argument))
            case Role.SURPLUS:
                return self._surplus(part)
            case Role.INPUT:
                return self.source(part.inputs[argument.name], f"{part.name}.{argument.name}", argument.kind)
        return OWN[argument.role].format(part.name, argument.name)

    def _surplus(self, part: Part) -> str:
        """What else flows into the volume of a part."""
        if self.places.at_junction(part):
            return "0.0"
        node = part.nodes[part.component.hydraulic_ports[0]]
        walls = self.walls(node, "rate")
        return f"{node}.volume_ratio * surplus_{node}" + (f" - ({walls})" if walls else "")

    def _warm_medium(self, part: Part) -> str:
        """The oil of a part as warm as the first volume that it joins has it, where volumes have a temperature."""
        plain = f"h.{self.medium(part)}"
        volumes = [node for port in part.component.hydraulic_ports if (node := part.nodes[port]) in self._warm_volumes]
        if not volumes:
            return plain
        return f"{self.use(warm_medium)}({plain}, temperature_{volumes[0]}, {self.places.path(self.oil(part))})"

    @cached_property
    def _warm_volumes(self) -> tuple[str, ...]:
        return warm_volumes(self.network)

    @staticmethod
    def _value(part: Part, argument: Argument) -> Params:
        """The value of an argument: that of the same name in the law, else the only one of its class."""
        law = [a for a in part.component.arguments if a.role is Role.PARAMS]
        pairs = list(zip(law, part.values, strict=True))
        for test in (
            [value for own, value in pairs if own.name == argument.name and own.type is argument.type],
            [value for own, value in pairs if own.type is argument.type],
            [value for value in part.values if isinstance(value, argument.type)],
        ):
            if len(test) == 1:
                return test[0]
        raise NetworkError(
            f"{part.name}: which values {argument.name!r} of {part.component.name} means cannot be determined; "
            "name the argument as in its law"
        )

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
            for m in self.places.ports_at(node)
            if m.port in m.part.component.wall_ports
        ]
        return " + ".join(found)

    def inflow_sum(self, node: str, *, only: Container[str] | None = None) -> str:
        """The sum of what the parts at a node, or some of them, give to it: flows, torques or forces."""
        terms = []
        for met in self.places.ports_at(node):
            component = met.part.component
            if only is not None and met.part.name not in only:
                continue
            if met.port in component.ends:
                sign = "-" if met.port == component.ends[0] else "+"
                terms.append((sign, f"{met.part.name}.flow"))
            elif met.port in names(component.result):
                terms.append(("+", f"{met.part.name}.{met.port}"))
        return signed_sum(terms)

    def state_of(self, oil: Oil) -> str:
        """The name of the function that says in which state an oil is at a pressure."""
        return self.use(plain_state if is_plain(oil) else fluid_state)

    def node_lines(self, nodes: Iterable[str], *, at_rest: bool = False) -> Iterator[str]:
        """Lines that say what is at nodes; `at_rest` where only angle and position of what moves are asked for."""
        for name in nodes:
            node = self.network.nodes[name]
            match node:
                case OilVolume() if has_free_air(node):
                    air, oil = f"s.{free_air_name(name)}", self.places.path(node.oil)
                    yield f"{name} = {self.use(aerated_state)}(s.{name}, {air}, {oil})"
                case OilVolume():
                    yield f"{name} = {self.state_of(node.oil)}(s.{name}, {self.places.path(node.oil)})"
                case Tank() | PressureSource() if is_held(node):
                    pressure = self.source(node.pressure, name, PRESSURE_LEVEL)
                    known = f"{self.use(state_at)}({pressure}, h.{name}, " if is_plain(node.oil) else ""
                    call = known or f"{self.state_of(node.oil)}({pressure}, "
                    yield f"{name} = {call}{self.places.path(node.oil)})"
                case PressureSource():
                    pressure = self.source(node.pressure, name, PRESSURE_LEVEL)
                    yield f"{name} = {self.state_of(node.oil)}({pressure}, {self.places.path(node.oil)})"
                case DrivenShaft():
                    speed = "0.0" if at_rest else self.source(node.speed, name, SPEED)
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
