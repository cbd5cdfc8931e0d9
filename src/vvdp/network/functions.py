"""Writes a network as the plain functions that a user would have written: `circuit`, `conditions`, `stored`, ..."""

from collections.abc import Callable, Iterator
from typing import Any

from vvdp.base.conservation import Nothing
from vvdp.base.errors import NetworkError
from vvdp.base.params import field_kinds
from vvdp.base.select import maximum, minimum
from vvdp.base.signal import Signal, signal_stop, signal_value
from vvdp.fluid.oil import density, dynamic_viscosity
from vvdp.hydraulics.flow import flow_side
from vvdp.hydraulics.pipe import LinePipe, piece_rate, piece_stored
from vvdp.hydraulics.ports import Medium, RodState, ShaftState
from vvdp.hydraulics.volume import closed_volume_contents, closed_volume_rate, pressure_rate, vessel_contents
from vvdp.network.component import Role
from vvdp.network.folding import indent, keyword_call, negative
from vvdp.network.heat import heat_balance
from vvdp.network.heat_text import HeatText
from vvdp.network.junction_text import junction_lines
from vvdp.network.network import Part
from vvdp.network.nodes import (
    Chamber,
    Connection,
    DrivenShaft,
    HydraulicNode,
    Junction,
    Node,
    OilVolume,
    PressureSource,
    Rod,
    Shaft,
    Tank,
    free_air_name,
    has_free_air,
    is_held,
)
from vvdp.network.oil_options import aerated_volumes, air_lines, boiling_modes, boiling_outputs
from vvdp.network.paths import (
    actual_flows,
    averaged_flows,
    part_outputs,
    paths_of,
    signals_of,
    sources_of,
    takes_surplus,
    tank_exchanges,
)
from vvdp.network.text import PRESCRIBED, Text
from vvdp.simulation.values import blank, names


class Functions:
    """The functions of a network as text."""

    def __init__(self, text: Text) -> None:
        self.text = text
        self.places, self.classes, self.network = text.places, text.classes, text.network
        balance = heat_balance(self.network)
        self.heat = None if balance is None else HeatText(text, balance)

    def all(self) -> list[list[str]]:
        """All functions, the lines of each."""
        return [self.circuit(), self.conditions(), self.contents(), self.start(), self.stop(), self.mark()]

    def circuit(self) -> list[str]:
        """The function `circuit`."""
        lines = ["h = u.held", *self.text.node_lines(self.places.early)]
        lines += [
            f"{p.name}_walls = {self.text.call(p, p.component.walls)}" for p in self.places.order if p.component.walls
        ]
        lines += self.heat.before() if self.heat else ()
        done: set[str] = set()
        for name in self.places.late:
            part = self.network.parts.get(name)
            if part is None:
                junction = isinstance(self.network.nodes[name], Junction)
                lines += junction_lines(self.text, name) if junction else self.text.node_lines([name])
                done |= {met.part.name for met in self.places.ports_at(name)} if junction else set()
                continue
            if name in done:
                continue
            if takes_surplus(part) and not self.places.at_junction(
                part
            ):  # what those before it give: of several such valves, the first has the first choice
                node = part.nodes[part.component.hydraulic_ports[0]]
                lines.append(f"surplus_{node} = {self.text.inflow_sum(node, only=done)}")
            lines.append(f"{name} = {self.text.call(part, part.component.law)}")
            done.add(name)
        lines += [*self._exchange(), *air_lines(self.text), *(self.heat.after() if self.heat else ())]
        lines += ["rates = State("]
        lines += [f"    {name}={rate}," for name, rate in self._rates()]
        lines += ["    books=Books(", *(f"        {line}" for line in self._books()), "    ),", ")"]
        lines += ["outputs = Outputs(", *(f"    {name}={text}," for name, text in self._outputs()), ")"]
        if self.classes.modes is not Nothing:
            lines += ["modes = Modes(", *(f"    {name}={text}," for name, text in self._modes()), ")"]
        last = "return rates, outputs" + (", modes" if self.classes.modes is not Nothing else "")
        return ["def circuit(t, s, u, p):", *indent([*lines, last])]

    def _rates(self) -> Iterator[tuple[str, str]]:
        for name, node in self.network.nodes.items():
            if rate := self._node_rate(name, node):
                yield name, rate
            if has_free_air(node):
                yield free_air_name(name), f"{free_air_name(name)}.rate"
        for part in self.network.parts.values():
            if part.component.state is not None:
                yield part.name, f"{part.name}.rates"
        yield from self.heat.rates() if self.heat else ()

    def _node_rate(self, name: str, node: Node) -> str:
        swept, rate = self.text.walls(name, "volume"), self.text.walls(name, "rate") or "0.0"
        inflow = self.text.inflow_sum(name) + (f" + {free_air_name(name)}.room" if has_free_air(node) else "")
        match node:
            case OilVolume(values=Chamber()):
                volume = f"{self.places.path(node.values)}.volume" + (f" + {swept}" if swept else "")
                return f"{self.text.use(closed_volume_rate)}({inflow}, {rate}, {volume}, {name})"
            case OilVolume(values=LinePipe()):
                ends = f"{self.places.path(node.values)}, {self.places.path(node.oil)}.reference_pressure"
                return f"{self.text.use(piece_rate)}({inflow}, {name}, {ends})"
            case OilVolume():
                reference = f"{self.places.path(node.oil)}.reference_pressure"
                values = self.places.path(node.values)
                ends = f"{values}, {reference}" + (f", {swept}" if swept else "")
                return f"{self.text.use(pressure_rate)}({inflow}, {rate}, {name}, {ends})"
            case DrivenShaft() if name in self.places.turning:
                return f"{name}.speed"
            case Shaft():
                return f"{self.text.use(ShaftState)}({name}.speed, ({self.text.inflow_sum(name)}) / h.{name}_inertia)"
            case Rod():
                return f"{self.text.use(RodState)}({name}.velocity, ({self.text.inflow_sum(name)}) / h.{name}_inertia)"
        return ""

    def _books(self) -> Iterator[str]:
        yield from keyword_call("supplied=Supplied", self.classes.supplied_class, self._supplied_powers())
        yield from keyword_call("spent=Spent", self.classes.spent_class, self._spent_powers())
        yield "taken_in=taken_in,"
        yield f"given_out={self._by_oil(self._given_out)},"
        yield from keyword_call("totals=Totals", self.classes.totals, self._totals())

    @property
    def _prescribed_pressures(self) -> list[str]:
        return [name for name, node in self.network.nodes.items() if isinstance(node, PRESCRIBED)]

    def _exchange(self) -> Iterator[str]:
        """Lines that say what oil goes into tanks and sources, and how much of it comes out of them."""
        yield from (f"into_{name} = {self.text.inflow_sum(name)}" for name in self._prescribed_pressures)
        yield f"taken_in = {self._by_oil(self._taken_in)}"

    def _by_oil(self, volumes: Callable[[str], str]) -> str:
        """What `volumes` says of the oil of that name: as it is where there is one only, else by name."""
        oils = self.places.oils
        if len(oils) <= 1:
            return volumes(next(iter(oils), "oil"))
        return f"{self.text.use(self.classes.oil_volumes)}({', '.join(f'{oil}={volumes(oil)}' for oil in oils)})"

    def _taken_in(self, oil: str) -> str:
        """The flow of an oil out of tanks and sources."""
        flows = tank_exchanges(self.places, oil).values()
        return " + ".join(f"{self.text.use(maximum)}({negative(flow)}, 0.0)" for flow in flows) or "0.0"

    def _given_out(self, oil: str) -> str:
        """The flow of an oil into tanks and sources: what was taken out of them, and what they have got since."""
        taken_in = "taken_in" if len(self.places.oils) <= 1 else f"taken_in.{oil}"
        got = (name for name in self._prescribed_pressures if self.places.oil_name(name) == oil)
        return " + ".join([taken_in, *(f"into_{name}" for name in got)])

    def _supplied_powers(self) -> dict[str, str]:
        found = {}
        for name, node in self.network.nodes.items():
            if isinstance(node, PRESCRIBED):
                found[name] = f"-{name}.enthalpy * into_{name}{self._wall_power(name, node)}"
            elif isinstance(node, DrivenShaft):
                found[name] = f"-{name}.speed * ({self.text.inflow_sum(name)})"
        parts = (part for part in self.network.parts.values() if "supplied" in names(part.component.result))
        return found | {part.name: f"{part.name}.supplied" for part in parts}

    def _wall_power(self, name: str, node: Tank | PressureSource) -> str:
        """Power that a prescribed pressure gives to the walls that move in it."""
        moving = [
            f"{m.part.name}_walls.{m.port}.rate"
            for m in self.places.ports_at(name)
            if m.part.component.moves_walls and m.port in m.part.component.wall_ports
        ]
        if not moving:
            return ""
        return f" + ({name}.pressure - {self.places.path(node.oil)}.reference_pressure) * ({' + '.join(moving)})"

    def _spent_powers(self) -> dict[str, str]:
        found = {}
        for part in self.network.parts.values():
            losses = part.component.losses
            if "" in losses:
                found[part.name] = f"{part.name}.loss"
            elif losses:
                cls = self.text.use(self.classes.spent_parts[part.name])
                inner = ", ".join(f"{part.name}.losses.{loss}" for loss in losses)
                found[part.name] = f"{cls}({inner})"
        return found | {free_air_name(name): f"{free_air_name(name)}.power" for name in aerated_volumes(self.text)}

    def _totals(self) -> dict[str, str]:
        found = {
            f"{n}_pressure": f"{n}.pressure"
            for n, node in self.network.nodes.items()
            if isinstance(node, HydraulicNode)
        }
        found |= boiling_outputs(self.text) | {
            name: f"s.{name}" for name in map(free_air_name, aerated_volumes(self.text))
        }
        for part in self.network.parts.values():
            flows = averaged_flows(part) | actual_flows(part)
            found |= {f"{part.name}_{name}": text for name, text in flows.items()}
            found |= {f"{part.name}_{name}": f"{part.name}.{name}" for name in part.component.averages}
        return found | (self.heat.totals() if self.heat else {})

    def _outputs(self) -> Iterator[tuple[str, str]]:
        texts = {}
        for name, node in self.network.nodes.items():
            if isinstance(node, (*PRESCRIBED, Junction)):
                texts[f"{name}_pressure"] = f"{name}.pressure"
            elif isinstance(node, DrivenShaft):
                texts[f"{name}_speed"] = f"{name}.speed"
        for part in self.network.parts.values():
            texts |= {f"{part.name}_{name}": text for name, (text, _) in part_outputs(part).items()}
        texts |= boiling_outputs(self.text)
        texts |= {read.replace(".", "_"): f"u.{read}" for read in self.classes.program_reads}
        texts |= dict(self.heat.outputs()) if self.heat else {}
        yield from texts.items()

    def _modes(self) -> Iterator[tuple[str, str]]:
        for part in self.network.parts.values():
            yield from ((f"{part.name}_{name}", f"{part.name}.{name}") for name in part.component.modes)
        for name, flow in tank_exchanges(self.places).items():
            yield name, f"{self.text.use(flow_side)}({flow})"
        yield from boiling_modes(self.text).items()

    def conditions(self) -> list[str]:
        """The function `conditions`."""
        lines = [f"temperature = {self.text.use(signal_value)}(t, {self.places.path(self.network.temperature)})"]
        fields = {}
        for name, oil in self.oils().items():
            path = self.places.path(oil)
            lines.append(
                f"{name} = {self.text.use(Medium)}({self.text.use(density)}(temperature, {path}), "
                f"{self.text.use(dynamic_viscosity)}(temperature, {path}))"
            )
            fields[name] = name
        if any(part.component.held for part in self.network.parts.values()):
            lines.append(f"h = {self.text.use(self.classes.medium)}({', '.join(fields)})")
        for name, node in self.network.nodes.items():
            if is_held(node):
                pressure, oil = self.text.source(node.pressure, name), self.places.path(node.oil)
                fields[name] = f"{self.text.state_of(node.oil)}({pressure}, {oil})"
            elif isinstance(node, Shaft | Rod):
                fields[f"{name}_inertia"] = self._inertia(name, node)
        for part in self.network.parts.values():
            if part.component.held:
                fields[part.name] = self.text.call(part, part.component.held)
        lines += ["return Held(", *(f"    {name}={text}," for name, text in fields.items()), ")"]
        return ["def conditions(t, p):", *indent(lines)]

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
        terms += [
            self.text.call(m.part, m.part.component.inertia)
            for m in self.places.ports_at(name)
            if m.part.component.inertia
        ]
        if not terms:
            raise NetworkError(f"{name} has no {own}; give it one, or join a component that has")
        return " + ".join(terms)

    def contents(self) -> list[str]:
        """The function `stored`."""
        lines, energies, held = list[str](), list[str](), dict[str, str]()
        used = [p for p in self.network.parts.values() if p.component.walls or p.component.stored]
        joined = {
            p.nodes[a.name]
            for p in used
            for f in (p.component.walls, p.component.stored)
            if f
            for a in p.component.arguments_of(f)
            if a.name in p.nodes
        }
        own = [p for p in used if p.component.stored]
        for part in own:
            self._check_contents(part)
        stores = [(p.component, p.component.stored) for p in own if p.component.stored]
        if any(a.role is Role.MEDIUM for component, store in stores for a in component.arguments_of(store)):
            lines.append("h = conditions(0.0, p)")
        seen = (n for n, node in self.network.nodes.items() if n in joined or isinstance(node, OilVolume))
        lines += list(self.text.node_lines(seen, at_rest=True))
        lines += [f"{p.name}_walls = {self.text.call(p, p.component.walls)}" for p in used if p.component.walls]
        for name, node in self.network.nodes.items():
            if isinstance(node, OilVolume):
                lines.append(f"in_{name} = {self._content(name, node)}")
                held[f"in_{name}"] = self.places.oil_name(name)
            elif isinstance(node, Shaft | Rod):
                speed = "speed" if isinstance(node, Shaft) else "velocity"
                energies.append(f"0.5 * ({self._inertia(name, node)}) * s.{name}.{speed} ** 2")
        lines += [f"in_{p.name} = {self.text.call(p, p.component.stored)}" for p in own]
        held |= {f"in_{p.name}": self.places.oil_name_of(self.text.oil(p)) for p in own}
        energies = [f"{name}.energy" for name in held] + energies
        lines.append(f"energy = {' + '.join(energies) or '0.0'}")

        def volume(oil: str) -> str:
            own = (f"{name}.volume" for name, of in held.items() if of == oil or len(self.places.oils) <= 1)
            return " + ".join(own) or "0.0"

        lines.append(f"return Stored(energy, {self._by_oil(volume)})")
        return ["def stored(s, p):", *indent(lines)]

    def _check_contents(self, part: Part) -> None:
        arguments = part.component.arguments_of(part.component.stored) if part.component.stored else ()
        for argument in arguments:
            held = (*PRESCRIBED, Junction)
            if argument.role is Role.PORT and isinstance(self.network.nodes[part.nodes[argument.name]], held):
                node = part.nodes[argument.name]
                raise NetworkError(
                    f"{part.name}: what it stores depends on the pressure at {node}, which is no state; "
                    "put a volume between"
                )
            if argument.role is Role.SHAFT_SPEED:
                node = part.nodes[argument.name]
                if isinstance(self.network.nodes[node], DrivenShaft):
                    raise NetworkError(
                        f"{part.name}: what it stores depends on the speed of {node}, which is prescribed"
                    )

    def _content(self, name: str, node: OilVolume) -> str:
        oil, values, swept = self.places.path(node.oil), self.places.path(node.values), self.text.walls(name, "volume")
        if isinstance(node.values, Chamber):
            volume = f"{values}.volume" + (f" + {swept}" if swept else "")
            return f"{self.text.use(closed_volume_contents)}({name}, {volume}, {oil})"
        if isinstance(node.values, LinePipe):
            return f"{self.text.use(piece_stored)}({name}, {oil}, {values})"
        call = self.text.use(vessel_contents, "vessel_stored")
        return f"{call}({name}, {oil}, {values}{f', {swept}' if swept else ''})"

    def start(self) -> list[str]:
        """The function `start`."""
        aerated, lines = {free_air_name(n): node for n, node in aerated_volumes(self.text).items()}, []
        for name in field_kinds(self.classes.state):
            if name == "books":
                continue
            if name in aerated:
                lines.append(f"    {name}={self.places.path(aerated[name].oil)}.air_fraction,")
                continue
            lines.append(f"    {name}={self._start(name)},")
        return ["def start(p):", "    return State(", *indent(lines), "        books=EMPTY_BOOKS,", "    )"]

    def _start(self, name: str) -> str:
        values = self.places.starts.get(name)
        part = self.network.parts.get(name)
        if part is None:
            if values is None:
                return "0.0"
            places = [value.path for value in values]
            if isinstance(self.network.nodes[name], OilVolume):
                return places[0]
            cls = ShaftState if isinstance(self.network.nodes[name], Shaft) else RodState
            return f"{self.text.use(cls)}({', '.join(places)})"
        state = part.component.state
        assert state is not None
        if values is not None:
            return nested_text(part.start, iter(value.path for value in values), self.text.use)
        if part.component.start is not None:
            return self.text.call(part, part.component.start)
        return nested_text(blank(state), iter(lambda: "0.0", None), self.text.use)

    def stop(self) -> list[str]:
        """The function `stop`: the next corner of a signal, or jump of a part."""
        calls = [f"{self.text.use(signal_stop)}(t, {path})" for path in self._signal_paths()]
        for part in self.network.parts.values():
            if part.component.stop:
                self._check_stop(part)
                calls.append(self.text.call(part, part.component.stop))
        lines = ["next_stop = np.inf", *(f"next_stop = {self.text.use(minimum)}(next_stop, {call})" for call in calls)]
        return ["def stop(t, u, p):", *indent(lines), "    return next_stop"]

    def _check_stop(self, part: Part) -> None:
        assert part.component.stop is not None
        for argument in part.component.arguments_of(part.component.stop):
            for path in paths_of(part.inputs[argument.name]) if argument.role is Role.INPUT else ():
                if path.partition(".")[0] not in self.network.programs:
                    raise NetworkError(
                        f"{part.name}.{argument.name}: {path!r} changes all the time, so that no one knows when the "
                        "part jumps next; expected a signal or a program's command"
                    )

    def _signal_paths(self) -> list[str]:
        net = self.network
        sources: list[Any] = [net.temperature]
        sources += [source for node in net.nodes.values() for source in sources_of(node)]
        for part in net.parts.values():
            sources += part.inputs.values()
            sources += [signal for value in part.values for _, signal in signals_of(value)]
        inner = [x for source in sources for x in (source.sources if isinstance(source, Connection) else (source,))]
        return list(dict.fromkeys(self.places.path(x) for x in inner if isinstance(x, Signal)))

    def mark(self) -> list[str]:
        """The function `mark`, of the first part that has one; nothing without any."""
        for part in self.network.parts.values():
            if part.component.mark:
                nodes = [
                    part.nodes[a.name] for a in part.component.arguments_of(part.component.mark) if a.name in part.nodes
                ]
                return [
                    "def mark(t, s, u, p):",
                    *indent(list(self.text.node_lines(nodes, at_rest=True))),
                    f"    return {self.text.call(part, part.component.mark)}",
                ]
        return []


def nested_text(value: Any, leaves: Iterator[str], use: Callable[[Any], str]) -> str:
    """A NamedTuple as the text that makes it, with `leaves` for its numbers."""
    fields = getattr(type(value), "_fields", None)
    if fields is None:
        return next(leaves)
    return f"{use(type(value))}({', '.join(nested_text(getattr(value, name), leaves, use) for name in fields)})"
