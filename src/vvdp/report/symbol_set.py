"""The symbol of a component, and the terminal at which each of its ports ends."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from types import MappingProxyType

from vvdp.network.graph import GraphComponent, NodeKind
from vvdp.report import machine_symbols as machine
from vvdp.report import valve_symbols as valve
from vvdp.report.drawing import INK
from vvdp.report.lettering import width
from vvdp.report.symbol import Letter, Side, Symbol, Terminal

AROUND = 6.0
"""Margin around a symbol that stands by itself [px]."""


@dataclass(frozen=True)
class Entry:
    """A symbol of the catalogue: the letter of its designation, and how firmly it says which way is up.

    `order` is lowest for what drives the flow; where a circuit closes, what has a high order is turned around.
    """

    draw: Callable[[], Symbol]
    letter: str
    order: int = 2


_PUMP, _FLOW = Entry(machine.pump, "P", 0), Entry(machine.flow_source, "P", 0)
_VARIABLE = Entry(machine.variable_pump, "P", 0)
_OVERCENTRE = Entry(machine.overcentre_pump, "P", 0)
_MOTOR, _RELIEF = Entry(machine.hydraulic_motor, "M", 6), Entry(valve.relief_valve, "V", 5)
_ADJUSTABLE = Entry(partial(valve.throttle, adjustable=True), "R", 4)
_UNLOADING, _CHECK = Entry(valve.unloading_valve, "V", 5), Entry(valve.check_valve, "V", 3)
_SWITCH_2, _SWITCH_3 = Entry(valve.valve_2_2, "V", 1), Entry(valve.valve_3_2, "V", 1)
_PROPORTIONAL, _DIRECTIONAL = Entry(valve.proportional_2_2, "V", 1), Entry(valve.valve_4_3, "V", 1)
_PUMP_MOTOR = Entry(machine.overcentre_motor, "M", 6)
_CYLINDER, _DAMPER = Entry(machine.cylinder, "A"), Entry(machine.damper, "D")

CATALOGUE: Mapping[str, Entry] = MappingProxyType(
    {
        "pump": _PUMP,
        "fixed_pump": _PUMP,
        "variable_pump": _VARIABLE,
        "overcentre_pump": _OVERCENTRE,
        "flow_source": _FLOW,
        "motor": _MOTOR,
        "hydraulic_motor": _MOTOR,
        "variable_motor": _PUMP_MOTOR,
        "overcentre_motor": _PUMP_MOTOR,
        "orifice": Entry(valve.orifice, "R", 4),
        "throttle": Entry(valve.throttle, "R", 4),
        "adjustable_orifice": _ADJUSTABLE,
        "adjustable_throttle": _ADJUSTABLE,
        "two_orifices": Entry(valve.two_orifices, "R", 4),
        "relief_valve": _RELIEF,
        "load_relief_valve": Entry(partial(valve.compensator, False), "V", 5),
        "unloading_valve": _UNLOADING,
        "pilot_operated_valve": _UNLOADING,
        "sequence_valve": Entry(valve.sequence_valve, "V", 3),
        "counterbalance_valve": Entry(valve.counterbalance_valve, "V", 3),
        "brake_valve": Entry(valve.brake_valve, "V", 3),
        "upstream_compensator": Entry(partial(valve.compensator, True), "V"),
        "downstream_compensator": Entry(partial(valve.compensator, False), "V"),
        "priority_valve": Entry(valve.priority_valve, "V", 3),
        "cartridge_valve": Entry(valve.cartridge_valve, "V", 3),
        "pilot_closed_check_valve": Entry(valve.pilot_closed_check_valve, "V", 3),
        "shuttle_valve": Entry(valve.shuttle_valve, "V", 3),
        "reducing_valve": Entry(valve.reducing_valve, "V"),
        "pressure_reducing_valve": Entry(valve.reducing_valve, "V"),
        "flow_control": Entry(valve.flow_control, "V"),
        "flow_control_valve": Entry(valve.flow_control, "V"),
        "check_valve": _CHECK,
        "pilot_check_valve": Entry(valve.pilot_check_valve, "V", 3),
        "pilot_operated_check_valve": Entry(valve.pilot_check_valve, "V", 3),
        "valve_2_2": _SWITCH_2,
        "switching_valve_2_2": _SWITCH_2,
        "valve_3_2": _SWITCH_3,
        "switching_valve_3_2": _SWITCH_3,
        "proportional_valve_2_2": _PROPORTIONAL,
        "proportional_valve": _PROPORTIONAL,
        "valve_4_3": _DIRECTIONAL,
        "directional_valve": _DIRECTIONAL,
        "proportional_valve_4_3": _DIRECTIONAL,
        "proportional_valve_6_3": Entry(valve.valve_6_3, "V", 1),
        "load_sensing_valve": Entry(valve.load_sensing_valve, "V", 1),
        "poppet_valve": Entry(valve.poppet_valve, "V", 3),
        "rotary_valve": Entry(valve.rotary_valve, "V", 1),
        "line": Entry(valve.line, "W"),
        "hose": Entry(valve.hose, "W"),
        "accumulator": Entry(machine.accumulator, "Z"),
        "piston_accumulator": Entry(machine.piston_accumulator, "Z"),
        "spring_accumulator": Entry(machine.spring_accumulator, "Z"),
        "pressure_source": Entry(machine.pressure_source, "P"),
        "tank": Entry(machine.tank, "T"),
        "gear": Entry(machine.gear, "K"),
        "lever": Entry(machine.lever, "K"),
        "arm": Entry(machine.arm, "K"),
        "drum": Entry(machine.drum, "K"),
        "wheel": Entry(machine.wheel, "K"),
        "vehicle": Entry(machine.vehicle, "G"),
        "telescope": Entry(machine.telescope, "A"),
        "one_way_throttle": Entry(valve.one_way_throttle, "R", 4),
        "level_tank": Entry(machine.level_tank, "T"),
        "filter": Entry(valve.filter_symbol, "F", 4),
        "cooler": Entry(valve.cooler, "E", 4),
        "sensor": Entry(machine.sensor, "S"),
        "cylinder": _CYLINDER,
        "spring_cylinder": Entry(machine.spring_cylinder, "A"),
        "spring_chamber": Entry(machine.spring_cylinder, "A"),
        "plunger": Entry(machine.plunger, "A"),
        "weight": Entry(machine.weight, "G"),
        "rotor": Entry(machine.inertia, "J"),
        "rotary_drive": Entry(machine.coupling, "K"),
        "electric_motor": Entry(machine.electric_motor, "M"),
        "combustion_engine": Entry(machine.combustion_engine, "M"),
        "compensator": Entry(valve.pump_compensator, "V"),
        "mass": Entry(machine.mass, "G"),
        "inertia": Entry(machine.inertia, "J"),
        "spring": Entry(machine.spring, "K"),
        "damper": _DAMPER,
        "friction": _DAMPER,
        "end_stop": Entry(machine.end_stop, "E"),
        "force": Entry(machine.force, "F"),
        "torque": Entry(machine.torque, "F"),
        "coupling": Entry(machine.coupling, "K"),
    }
)
SELECTOR: Mapping[str, str] = MappingProxyType({"pressure": "A", "first": "P", "second": "T"})
DIVERTER: Mapping[str, str] = MappingProxyType({"pressure": "P", "first": "A", "second": "T"})
"""Terminals of a 3/2 valve that joins `pressure` to `first` or `second`, where these feed it or it feeds them."""
UNKNOWN_LETTER = "U"
HELD_BETWEEN: Mapping[Callable[[], Symbol], Callable[[], Symbol]] = MappingProxyType(
    {machine.spring: partial(machine.spring, grounded=False), machine.damper: partial(machine.damper, grounded=False)}
)
"""How a spring and a damper look between two rods or shafts."""

MEANT: Mapping[str, str] = MappingProxyType(
    {
        "inlet": "a p in supply pump from upstream source port_a first high valve",
        "outlet": "b t out tank load to downstream sink port_b second low return pressure",
        "suction": "inlet a in tank low t",
        "P": "supply inlet pump pressure source in high",
        "T": "tank return drain low",
        "A": "load outlet out load_line a_port",
        "B": "load_b b_port",
        "cap": "head a bore piston chamber port inlet cap_side chamber_a",
        "rod": "ring annulus b rod_side chamber_b",
        "pilot": "x control sense pilot_port",
        "LS": "sensing",
    }
)
"""Names of ports that mean a terminal, beside its own name."""


@dataclass(frozen=True)
class Fitted:
    """A symbol with the terminal of each hydraulic port, and the ports that are shafts and rods."""

    symbol: Symbol
    terminals: Mapping[str, str]
    links: tuple[str, ...]

    def terminal(self, port: str) -> Terminal:
        """Where a hydraulic port ends."""
        return self.symbol.terminals[self.terminals[port]]


def entry(symbol: str) -> Entry | None:
    """Entry of the catalogue under that name; None if it is unknown."""
    return CATALOGUE.get(re.sub(r"[^a-z0-9]+", "_", symbol.lower()).strip("_"))


def is_source(symbol: str) -> bool:
    """Whether it delivers flow."""
    return entry(symbol) in (_PUMP, _VARIABLE, _OVERCENTRE, _FLOW)


def fit_symbol(component: GraphComponent, kinds: Mapping[str, NodeKind], fed: frozenset[str] = frozenset()) -> Fitted:
    """The symbol of a component, with a terminal for every port; `kinds` are those of the nodes, `fed` have a source.

    A few ports that a symbol does not know join at its left side; with more, or without a symbol, it is a box.
    """
    links = tuple(port for port, node in component.ports.items() if kinds[node].is_mechanical)
    lines = {port: kinds[node] for port, node in component.ports.items() if port not in links}
    found = entry(component.symbol)
    if found is None:
        symbol = generic(component.symbol, lines)
        return Fitted(symbol, {port: port for port in lines}, links)
    symbol = HELD_BETWEEN[found.draw]() if len(links) > 1 and found.draw in HELD_BETWEEN else found.draw()
    names: Mapping[str, str] = _assign_terminals(lines, symbol)
    if found is _SWITCH_3 and {*lines} == {*SELECTOR}:
        diverts = component.ports["pressure"] in fed or component.ports["first"] not in fed
        symbol, names = (valve.diverter_3_2(), DIVERTER) if diverts else (symbol, SELECTOR)
    extra = [port for port in lines if port not in names]
    x0, _, x1, y1 = symbol.box
    if extra and (not symbol.terminals or 10.0 * len(extra) > y1 - 5.0):
        return Fitted(generic(component.symbol, lines), {port: port for port in lines}, links)
    more = {f"port {port}": Terminal(x0, 10.0 * (i + 1), Side.LEFT) for i, port in enumerate(extra)}
    names = {**names} | {port: f"port {port}" for port in extra}
    axis = (x0, x1) if links and symbol.axis == (None, None) else symbol.axis
    return Fitted(replace(symbol, terminals={**symbol.terminals, **more}, axis=axis), names, links)


def _assign_terminals(lines: Mapping[str, NodeKind], symbol: Symbol) -> dict[str, str]:
    """Port -> terminal: by name, then tanks to the tank's terminals, then in order as long as terminals last."""
    free, names = list(symbol.terminals), dict[str, str]()
    single = [port for port, kind in lines.items() if kind is not NodeKind.TANK]
    if "suction" in free and len(single) == len(lines) == 1:
        names[single[0]] = "outlet"
        free.remove("outlet")

    def assign(choose: Callable[[str], list[str]]) -> None:
        for port in lines:
            if port not in names and (options := choose(port)):
                names[port] = options[0]
                free.remove(options[0])

    assign(lambda port: [t for t in free if t.lower() == port.lower()])
    assign(lambda port: [t for t in free if port.lower() in MEANT.get(t, "").split()])
    assign(lambda port: [t for t in ("T", "suction") if t in free and lines[port] is NodeKind.TANK])
    assign(lambda port: free[:1])
    return names


def picture(symbol: Symbol) -> str:
    """A symbol by itself as SVG, in the colour of the text around it."""
    x0, y0, x1, y1 = symbol.box
    box = f"{x0 - AROUND:g} {y0 - AROUND:g} {x1 - x0 + 2 * AROUND:g} {y1 - y0 + 2 * AROUND:g}"
    drawn = symbol.draw_at(0.0, 0.0).replace(f'"{INK}"', '"currentColor"')
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{box}" aria-hidden="true"><g fill="none" '
        f'stroke="currentColor" stroke-width="1.7" stroke-linecap="round" stroke-linejoin="round">{drawn}</g></svg>'
    )


def generic(name: str, lines: Mapping[str, NodeKind]) -> Symbol:
    """A box with a name, for what has no symbol; tanks join below, the other ports below and above in order."""
    tanks = [port for port, kind in lines.items() if kind is NodeKind.TANK]
    others = [port for port in lines if port not in tanks]
    half = len(others) // 2 if tanks else (len(others) + 1) // 2
    below, above = [*others[:half], *tanks], others[half:]
    step = max([34.0, *(width(port, 10.0) + 10.0 for port in lines)])
    wide = max(64.0, width(name, 13.0) + 20.0, step * max(len(below), len(above)))
    terminals: dict[str, Terminal] = {}
    letters: list[Letter] = [(0.0, 0.0, name, 13.0)]
    for ports, y, side in ((below, 28.0, Side.BOTTOM), (above, -28.0, Side.TOP)):
        for i, port in enumerate(ports):
            x = step * (i - 0.5 * (len(ports) - 1))
            terminals[port] = Terminal(x, y, side)
            letters.append((x, 0.7 * y, port, 10.0))
    edge = 0.5 * wide
    drawn = valve.box(-edge, -28, edge, 28)
    return Symbol((-edge, -28, edge, 28), drawn, terminals, (-edge, edge), tuple(letters))


NODES: Mapping[NodeKind, Callable[[], Symbol]] = MappingProxyType(
    {
        NodeKind.ACCUMULATOR: machine.accumulator,
        NodeKind.PRESSURE: machine.pressure_source,
        NodeKind.SHAFT: machine.inertia,
        NodeKind.DRIVEN_SHAFT: machine.electric_motor,
        NodeKind.ROD: machine.mass,
        NodeKind.DRIVEN_ROD: machine.driven_rod,
    }
)
"""Symbols of the nodes that have one; the others are junction lines."""
LONELY: Mapping[NodeKind, Callable[[], Symbol]] = MappingProxyType(
    {NodeKind.TANK: machine.tank, NodeKind.VOLUME: machine.dot}
)
"""Symbols of nodes that stand alone: the tank with its values, a volume that nothing leads to."""
