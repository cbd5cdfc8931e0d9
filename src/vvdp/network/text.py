"""Writes a network as the plain functions that a person would have written: `circuit`, `conditions`, `stored`, ..."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

from vvdp.base.books import Books, Stored
from vvdp.base.errors import NetworkError
from vvdp.base.params import Params, field_kinds
from vvdp.base.select import maximum, minimum
from vvdp.base.signal import Signal, signal_stop, signal_value
from vvdp.fluid.mixture import FluidState, fluid_state
from vvdp.fluid.oil import density, dynamic_viscosity
from vvdp.hydraulics.pipe import LinePipe, piece_rate, piece_stored
from vvdp.hydraulics.ports import Medium, RodState, ShaftSpeed, ShaftState
from vvdp.hydraulics.volume import closed_volume_rate, closed_volume_stored, pressure_rate, stored
from vvdp.network.classes import Classes
from vvdp.network.component import Argument, Role
from vvdp.network.network import Network, Part
from vvdp.network.nodes import (
    Chamber,
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

WIDTH = 116
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
            if component.state is not None and what in component.state._fields:  # type: ignore[attr-defined]
                return f"s.{path}"
        if name in net.programs and what in type(net.programs[name].type.command)._fields:
            return f"u.{path}"
        raise self.places.unknown(where, path)

    def arguments(self, part: Part, function: Callable[..., Any]) -> str:
        """The arguments with which a function of a part is called."""
        values = iter(part.values)
        found = [self._argument(part, argument, values) for argument in part.component.arguments_of(function)]
        return ", ".join(found)

    def _argument(self, part: Part, argument: Argument, values: Iterator[Params]) -> str:
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
        return next(value for value in part.values if isinstance(value, argument.type))

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
            elif met.port in component.result._fields:  # type: ignore[attr-defined]
                terms.append(("+", f"{met.part.name}.{met.port}"))
        return added(terms)

    def node_lines(self, names: Iterable[str]) -> Iterator[str]:
        """Lines that say what is at nodes."""
        for name in names:
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
                    parts = f"{self.use(ShaftState)}(s.{name}, {speed})" if turning else f"{self.use(ShaftSpeed)}({speed})"
                    yield f"{name} = {parts}"
                case _:
                    yield f"{name} = s.{name}"

    def circuit(self) -> list[str]:
        """The function `circuit`."""
        lines = ["h = u.held", *self.node_lines(self.network.nodes)]
        lines += [f"{p.name}_walls = {self.call(p, p.component.walls)}" for p in self.places.order if p.component.walls]
        surplus: set[str] = set()
        for part in self.places.order:
            if any(a.role is Role.SURPLUS for a in part.component.arguments):
                node = part.nodes[part.component.hydraulic_ports[0]]
                if node not in surplus:
                    lines.append(f"surplus_{node} = {self.given(node, without=part)}")
                    surplus.add(node)
            lines.append(f"{part.name} = {self.call(part, part.component.law)}")
        lines += ["rates = State("]
        lines += [f"    {name}={rate}," for name, rate in self._rates()]
        lines += ["    books=Books(", *(f"        {line}" for line in self._books()), "    ),", ")"]
        lines += ["outputs = Outputs(", *(f"    {name}={text}," for name, text in self._outputs()), ")"]
        return ["def circuit(t, s, u, p):", *indented(lines), "    return rates, outputs"]

    def call(self, part: Part, function: Callable[..., Any] | None) -> str:
        """A call of one of a part's functions."""
        assert function is not None
        return f"{self.use(function)}({self.arguments(part, function)})"

    def _rates(self) -> Iterator[tuple[str, str]]:
        for name, node in self.network.nodes.items():
            if rate := self._node_rate(name, node):
                yield name, rate
        for part in self.network.parts.values():
            if part.component.state is not None:
                yield part.name, f"{part.name}.rates"

    def _node_rate(self, name: str, node: Node) -> str:
        swept, rate = self.walls(name, "volume"), self.walls(name, "rate") or "0.0"
        match node:
            case OilVolume(values=Chamber()):
                volume = f"{self.places.path(node.values)}.volume" + (f" + {swept}" if swept else "")
                return f"{self.use(closed_volume_rate)}({self.given(name)}, {rate}, {volume}, {name})"
            case OilVolume(values=LinePipe()):
                ends = f"{self.places.path(node.values)}, {self.places.path(node.oil)}.reference_pressure"
                return f"{self.use(piece_rate)}({self.given(name)}, {name}, {ends})"
            case OilVolume():
                reference = f"{self.places.path(node.oil)}.reference_pressure"
                values = self.places.path(node.values)
                ends = f"{values}, {reference}" + (f", {swept}" if swept else "")
                return f"{self.use(pressure_rate)}({self.given(name)}, {rate}, {name}.pressure, {name}, {ends})"
            case DrivenShaft() if name in self.places.turning:
                return f"{name}.speed"
            case Shaft():
                return f"{self.use(ShaftState)}({name}.speed, ({self.given(name)}) / h.{name}_inertia)"
            case Rod():
                return f"{self.use(RodState)}({name}.velocity, ({self.given(name)}) / h.{name}_inertia)"
        return ""

    def _books(self) -> Iterator[str]:
        yield from bracketed("supplied=Supplied", self.classes.supplied, self._supplied())
        yield from bracketed("spent=Spent", self.classes.spent, self._spent())
        flows = [self._port_flow(name) for name, node in self.network.nodes.items() if isinstance(node, PRESCRIBED)]
        every = [flow for flows_here in flows for flow in flows_here]
        for word, sign in (("taken_in", "-"), ("given_out", "")):
            terms = [f"{self.use(maximum)}({flow if not sign else negative(flow)}, 0.0)" for flow in every]
            yield f"{word}={' + '.join(terms) or '0.0'},"
        yield from bracketed("totals=Totals", self.classes.totals, self._totals())

    def _port_flow(self, node: str) -> list[str]:
        text = []
        for met in self.places.attached(node):
            component = met.part.component
            if component.is_passage and met.port in component.hydraulic_ports:
                text.append(f"{'-' if met.port == component.hydraulic_ports[0] else ''}{met.part.name}.flow")
            elif met.port in component.result._fields:  # type: ignore[attr-defined]
                text.append(f"{met.part.name}.{met.port}")
        return text

    def _supplied(self) -> dict[str, str]:
        found = {}
        for name, node in self.network.nodes.items():
            if isinstance(node, PRESCRIBED):
                found[name] = f"-{name}.enthalpy * ({self.given(name)})"
            elif isinstance(node, DrivenShaft):
                found[name] = f"-{name}.speed * ({self.given(name)})"
        parts = (part for part in self.network.parts.values() if "supplied" in part.component.result._fields)  # type: ignore[attr-defined]
        return found | {part.name: f"{part.name}.supplied" for part in parts}

    def _spent(self) -> dict[str, str]:
        found = {}
        for part in self.network.parts.values():
            losses = part.component.losses
            if "" in losses:
                found[part.name] = f"{part.name}.loss"
            elif losses:
                cls = self.use(self.classes.spent_parts[part.name])
                inner = ", ".join(f"{part.name}.losses.{loss}" for loss in losses)
                found[part.name] = f"{cls}({inner})"
        return found

    def _totals(self) -> dict[str, str]:
        found = {f"{n}_pressure": f"{n}.pressure" for n, node in self.network.nodes.items() if isinstance(node, HydraulicNode)}
        for part in self.network.parts.values():
            found |= dict(self._flows(part))
            found |= {f"{part.name}_{name}": f"{part.name}.{name}" for name in part.component.averages}
        return found

    @staticmethod
    def _flows(part: Part) -> Iterator[tuple[str, str]]:
        ports = part.component.hydraulic_ports
        if len(ports) == 2:
            yield f"{part.name}_flow", f"{part.name}.{'flow' if part.component.is_passage else ports[1]}"
            return
        for port in ports:
            if port in part.component.result._fields:  # type: ignore[attr-defined]
                yield f"{part.name}_{port}_flow", f"{part.name}.{port}"

    def _outputs(self) -> Iterator[tuple[str, str]]:
        texts = {f"{n}_pressure": f"{n}.pressure" for n, node in self.network.nodes.items() if isinstance(node, PRESCRIBED)}
        for part in self.network.parts.values():
            texts |= dict(self._flows(part))
            texts |= {f"{part.name}_{name}": f"{part.name}.{name}" for name in part.component.outputs}
            for port, role in part.component.ports.items():
                if role is not Role.PORT and port in part.component.result._fields:  # type: ignore[attr-defined]
                    texts[f"{part.name}_{port}"] = f"{part.name}.{port}"
        texts |= {read.replace(".", "_"): f"u.{read}" for read in self.classes.program_reads}
        yield from texts.items()

    def conditions(self) -> list[str]:
        """The function `conditions`."""
        lines = [f"celsius = {self.use(signal_value)}(t, {self.places.path(self.network.temperature)})".replace("celsius", "temperature")]
        fields = {}
        for name, oil in self.oils().items():
            path = self.places.path(oil)
            lines.append(
                f"{name} = {self.use(Medium)}({self.use(density)}(temperature, {path}), "
                f"{self.use(dynamic_viscosity)}(temperature, {path}))"
            )
            fields[name] = name
        lines.append(f"h = {self.use(self.classes.medium)}({', '.join(fields)})")
        for name, node in self.network.nodes.items():
            if isinstance(node, Tank):
                fields[name] = f"{self.use(fluid_state)}({self.source(node.pressure, name)}, {self.places.path(node.oil)})"
            elif isinstance(node, Shaft | Rod):
                fields[f"{name}_inertia"] = self._inertia(name, node)
        for part in self.network.parts.values():
            if part.component.held:
                fields[part.name] = self.call(part, part.component.held)
        lines += ["return Held(", *(f"    {name}={text}," for name, text in fields.items()), ")"]
        return ["def conditions(t, p):", *indented(lines)]

    def oils(self) -> dict[str, Any]:
        """The oils of the network, by the name of their medium."""
        found = {"medium": self.network.oil}
        for node in self.network.nodes.values():
            if isinstance(node, HydraulicNode) and node.oil is not self.network.oil:
                found[f"medium_{self.places.path(node.oil).removeprefix('p.')}"] = node.oil
        return found

    def _inertia(self, name: str, node: Shaft | Rod) -> str:
        own = "inertia" if isinstance(node, Shaft) else "mass"
        terms = [f"{self.places.path(node.values)}.{own}"] if node.values else []
        terms += [self.call(m.part, m.part.component.inertia) for m in self.places.attached(name) if m.part.component.inertia]
        if not terms:
            raise NetworkError(f"{name} has no {own}; give it one, or join a component that has")
        return " + ".join(terms)

    def stored(self) -> list[str]:
        """The function `stored`."""
        lines, energies, volumes = [], [], []
        used = [p for p in self.network.parts.values() if p.component.walls or p.component.stored]
        joined = {p.nodes[a.name] for p in used for f in (p.component.walls, p.component.stored) if f
                  for a in p.component.arguments_of(f) if a.name in p.nodes}
        if any(a.role is Role.MEDIUM for p in used if p.component.stored for a in p.component.arguments_of(p.component.stored)):
            lines.append("h = conditions(0.0, p)")
        lines += list(self.node_lines(n for n in self.network.nodes if n in joined))
        lines += [f"{p.name}_walls = {self.call(p, p.component.walls)}" for p in used if p.component.walls]
        for name, node in self.network.nodes.items():
            if isinstance(node, OilVolume):
                lines.append(f"in_{name} = {self._content(name, node)}")
            elif isinstance(node, Shaft | Rod):
                speed = "speed" if isinstance(node, Shaft) else "velocity"
                energies.append(f"0.5 * ({self._inertia(name, node)}) * s.{name}.{speed} ** 2")
        lines += [f"in_{p.name} = {self.call(p, p.component.stored)}" for p in used if p.component.stored]
        held = [line.partition(" = ")[0] for line in lines if line.startswith("in_")]
        energies, volumes = [f"{name}.energy" for name in held] + energies, [f"{name}.volume" for name in held]
        lines.append(f"energy = {' + '.join(energies) or '0.0'}")
        lines.append(f"return Stored(energy, {' + '.join(volumes) or '0.0'})")
        return ["def stored(s, p):", *indented(lines)]

    def _content(self, name: str, node: OilVolume) -> str:
        oil, values, swept = self.places.path(node.oil), self.places.path(node.values), self.walls(name, "volume")
        if isinstance(node.values, Chamber):
            volume = f"{values}.volume" + (f" + {swept}" if swept else "")
            return f"{self.use(closed_volume_stored)}(s.{name}, {volume}, {oil})"
        if isinstance(node.values, LinePipe):
            return f"{self.use(piece_stored)}(s.{name}, {oil}, {values})"
        return f"{self.use(stored, 'vessel_stored')}(s.{name}, {oil}, {values}{f', {swept}' if swept else ''})"

    def start(self) -> list[str]:
        """The function `start`."""
        lines = []
        for name, cls in field_kinds(self.classes.state).items():
            if name == "books":
                continue
            lines.append(f"    {name}={self._start(name)},")
        return ["def start(p):", "    return State(", *indented(lines), "        books=EMPTY_BOOKS,", "    )"]

    def _start(self, name: str) -> str:
        values = self.places.starts.get(name)
        part = self.network.parts.get(name)
        if part is None:
            if values is None:
                return "0.0"
            places = [value.path for value in values]
            if isinstance(self.network.nodes[name], OilVolume):
                return places[0]
            return f"{self.use(ShaftState if isinstance(self.network.nodes[name], Shaft) else RodState)}({', '.join(places)})"
        state = part.component.state
        assert state is not None
        if values is not None:
            return nested(part.start, iter(value.path for value in values), self.use)
        if part.component.start is not None:
            return self.call(part, part.component.start)
        return nested(zero(state), iter(lambda: "0.0", None), self.use)

    def stop(self) -> list[str]:
        """The function `stop`: the next corner of a signal, or jump of a part."""
        calls = [f"{self.use(signal_stop)}(t, {path})" for path in self._signal_paths()]
        for part in self.network.parts.values():
            if part.component.stop:
                calls.append(self.call(part, part.component.stop))
        lines = ["next_stop = np.inf", *(f"next_stop = {self.use(minimum)}(next_stop, {call})" for call in calls)]
        return ["def stop(t, u, p):", *indented(lines), "    return next_stop"]

    def _signal_paths(self) -> list[str]:
        net = self.network
        sources: list[Any] = [net.temperature]
        for node in net.nodes.values():
            sources += [getattr(node, key) for key in ("pressure", "speed") if isinstance(node, Tank | PressureSource | DrivenShaft) and hasattr(node, key)]
        sources += [source for part in net.parts.values() for source in part.inputs.values()]
        inner = [x for source in sources for x in (source.sources if isinstance(source, Connection) else (source,))]
        return list(dict.fromkeys(self.places.path(x) for x in inner if isinstance(x, Signal)))

    def mark(self) -> list[str]:
        """The function `mark`, of the first part that has one; nothing without any."""
        for part in self.network.parts.values():
            if part.component.mark:
                nodes = [part.nodes[a.name] for a in part.component.arguments_of(part.component.mark) if a.name in part.nodes]
                return ["def mark(t, s, u, p):", *indented(list(self.node_lines(nodes))), f"    return {self.call(part, part.component.mark)}"]
        return []


def _quantities(node: Node) -> tuple[str, ...]:
    match node:
        case Shaft() | DrivenShaft():
            return ShaftState._fields
        case Rod():
            return RodState._fields
    return FluidState._fields


def added(terms: list[tuple[str, str]]) -> str:
    """A sum of signed terms as text."""
    text = " ".join(f"{sign} {term}" for sign, term in terms) or "0.0"
    return f"-{text[2:]}" if text.startswith("- ") else text.removeprefix("+ ")


def negative(term: str) -> str:
    """The negative of a term as text."""
    return term.removeprefix("-") if term.startswith("-") else f"-{term}"


def indented(lines: Iterable[str]) -> list[str]:
    """Lines, four spaces further in, and folded where they are too long."""
    return [part for line in lines for part in folded(f"    {line}")]


def bracketed(head: str, cls: type, fields: dict[str, str]) -> Iterator[str]:
    """A call with a keyword on each line."""
    if not fields:
        yield f"{head.partition('=')[0]}=NOTHING,"
        return
    yield f"{head}("
    yield from (f"    {name}={text}," for name, text in fields.items())
    yield "),"


def folded(line: str) -> list[str]:
    """A line of text, on several where it is too long: one for each part of its last bracket, or term of its sum."""
    space = line[: len(line) - len(line.lstrip())]
    if len(line) <= WIDTH or line.endswith("("):
        return [line]
    begin, end = line.find("("), line.rfind(")")
    parts = divided(line[begin + 1 : end], ", ") if begin >= 0 else [line]
    if len(parts) > 1:
        inner = [f"{space}    {part}," for part in parts]
        return [line[: begin + 1], *(text for part in inner for text in folded(part)), space + line[end:]]
    head, equals, value = line.partition(" = ")
    terms = divided(value, " + ")
    if not equals or len(terms) == 1:
        return [line]
    return [f"{head} = (", *(f"{space}    {'+ ' if i else ''}{term}" for i, term in enumerate(terms)), f"{space})"]


def divided(text: str, mark: str) -> list[str]:
    """The parts of a text between the marks that stand in no bracket."""
    parts, depth, begin = [], 0, 0
    for place, letter in enumerate(text):
        depth += (letter in "([") - (letter in ")]")
        if depth == 0 and text.startswith(mark, place):
            parts.append(text[begin:place])
            begin = place + len(mark)
    return [*parts, text[begin:]]


def zero(cls: type) -> Any:
    """A NamedTuple of zeros."""
    from typing import get_type_hints

    hints = get_type_hints(cls)
    return cls(*(zero(hints[name]) if hasattr(hints[name], "_fields") else 0.0 for name in cls._fields))  # type: ignore[attr-defined]


def nested(value: Any, leaves: Iterator[str], use: Callable[[Any], str]) -> str:
    """A NamedTuple as the text that makes it, with `leaves` for its numbers."""
    fields = getattr(type(value), "_fields", None)
    if fields is None:
        return next(leaves)
    return f"{use(type(value))}({', '.join(nested(getattr(value, name), leaves, use) for name in fields)})"
