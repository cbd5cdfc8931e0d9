"""The graph of a network for its diagram: what is joined to what, with the values that a user looks for."""

from collections.abc import Iterator

from vvdp.base.display import signal_with_unit, with_unit
from vvdp.base.kinds import AREA, DISPLACEMENT, FRACTION, PRESSURE_LEVEL, SPEED, TIME, VOLUME, Kind
from vvdp.base.params import Params, default_values, field_kinds
from vvdp.base.signal import Signal
from vvdp.evaluation.overview import inside
from vvdp.hydraulics.volume import Vessel
from vvdp.network.assembly import Group, InnerCircuit
from vvdp.network.graph import Graph, GraphComponent, GraphNode, GraphProgram, NodeKind
from vvdp.network.network import Network, Part
from vvdp.network.nodes import (
    Connection,
    DrivenShaft,
    Junction,
    Node,
    OilVolume,
    PressureSource,
    Rod,
    Shaft,
    Source,
    Tank,
)
from vvdp.network.paths import paths_of

Lines = tuple[str, ...]
MOST_LABELS = 2
LEAST_INERTIA = 1e-8
"""A shaft with less has its inertia from what it joins [kg m^2]."""
FIRST = (DISPLACEMENT, PRESSURE_LEVEL, AREA)
"""Kinds that say most about a component."""
UNSAID = (TIME, FRACTION)
"""Kinds that say little."""
SIZES = ("m", "m^2")
"""Units of which a component may well show two values, such as length and diameter."""


def graph_of(network: Network, title: str, part: str = "") -> Graph:
    """The graph of a network, or of a `part` of it that is a circuit, labelled with the main values.

    Circuits in it are one component each; at the ports of a part stand the nodes that it joins.
    """
    shown = _names_in(network, part)
    return Graph(
        title=title,
        nodes=tuple(_node(network, node) for name, node in network.nodes.items() if name in shown),
        components=(
            *(_component(network, each) for name, each in network.parts.items() if name in shown),
            *(_group(network, name, group) for name, group in network.groups.items() if name in shown),
            *(_circuit(network, name, each) for name, each in network.circuits.items() if name in shown),
        ),
        programs=tuple(each for each in _programs(network) if each.name in shown),
    )


def figure_of(part: str) -> str:
    """The name of the figure of what is in a part."""
    return f"circuit-{part}"


def _names_in(network: Network, part: str) -> frozenset[str]:
    """The names in the drawing of a network or of a part of it, without what is inside of others there."""
    everything = (*network.nodes, *network.parts, *network.groups, *network.programs, *network.circuits)
    own = _members(network, part) if part else frozenset(everything)
    deeper = [_members(network, name) for name in network.circuits if name in own]
    ports = network.circuits[part].ports.values() if part else ()
    return frozenset((own - inside(network)).difference(*deeper) | {*ports})


def _members(network: Network, part: str) -> frozenset[str]:
    """The names in a part, with what a fault joins to a node in it."""
    names = network.circuits[part].names
    return names | {each.name for each in network.parts.values() if not names.isdisjoint(each.nodes.values())}


def _circuit(network: Network, name: str, circuit: InnerCircuit) -> GraphComponent:
    """A circuit in a network as one component."""
    return GraphComponent(
        name=name,
        symbol=circuit.source.removesuffix(".toml"),
        ports=dict(circuit.ports),
        position=network.positions.get(name),
        opens=f"figure-{figure_of(name)}",
    )


def _node(network: Network, node: Node) -> GraphNode:
    kind, labels = _kind_and_labels(node)
    return GraphNode(node.name, kind, labels, network.positions.get(node.name))


def _kind_and_labels(node: Node) -> tuple[NodeKind, Lines]:
    match node:
        case OilVolume():
            if not isinstance(node.values, Vessel):
                return NodeKind.VOLUME, main_values(node.values)
            oil, gas = (with_unit(volume, VOLUME) for volume in (node.values.oil_volume, node.values.gas_volume))
            if node.values.gas_volume == 0.0:
                return NodeKind.VOLUME, (oil,)
            charge = with_unit(node.values.precharge_pressure, PRESSURE_LEVEL)
            return NodeKind.ACCUMULATOR, (oil, f"gas {gas} at {charge}")
        case Junction():
            return NodeKind.VOLUME, ()
        case Tank():
            pressure = node.pressure
            is_usual = pressure.is_constant and pressure.base == node.oil.reference_pressure
            return NodeKind.TANK, (() if is_usual else (signal_with_unit(pressure, PRESSURE_LEVEL),))
        case PressureSource():
            return NodeKind.PRESSURE, (source_words(node.pressure, PRESSURE_LEVEL),)
        case DrivenShaft():
            return NodeKind.DRIVEN_SHAFT, (source_words(node.speed, SPEED),)
        case Shaft():
            is_light = node.values is None or node.values.inertia <= LEAST_INERTIA
            return NodeKind.SHAFT, (() if is_light else main_values(node.values))
        case Rod():
            return NodeKind.ROD, main_values(node.values)


def _component(network: Network, part: Part) -> GraphComponent:
    kinds = {argument.name: argument.kind for argument in part.component.inputs}
    defaults = {argument.name: argument.default for argument in part.component.inputs}
    return GraphComponent(
        name=part.name,
        symbol=part.component.symbol,
        ports=dict(part.nodes),
        connections={
            name.replace("_", " "): source_words(source, kinds[name])
            for name, source in part.inputs.items()
            if not _is_settled(source, defaults[name])
        },
        labels=tuple(value for values in part.values for value in main_values(values))[:MOST_LABELS],
        position=network.positions.get(part.name),
    )


def _is_settled(source: Source, default: float | None) -> bool:
    """Whether an input follows nothing that a drawing could name: it has its default, or comes of parameters alone."""
    if isinstance(source, Connection):
        return all(isinstance(each, Params) for each in source.sources)
    return isinstance(source, Signal) and source.is_constant and source.base == default


def _group(network: Network, name: str, group: Group) -> GraphComponent:
    """A pipe or the like as one component."""
    return GraphComponent(
        name=name,
        symbol=group.assembly.symbol,
        ports=dict(group.ports),
        labels=main_values(group.values),
        position=network.positions.get(name),
    )


def _programs(network: Network) -> Iterator[GraphProgram]:
    for program in network.programs.values():
        commands = [
            f"{part.name}.{key}"
            for part in network.parts.values()
            for key, source in part.inputs.items()
            if any(path.partition(".")[0] == program.name for path in paths_of(source))
        ]
        reads = dict.fromkeys(path for source in program.reads.values() for path in paths_of(source))
        yield GraphProgram(program.name, tuple(reads), tuple(commands))


def source_words(source: Source, kind: Kind | None) -> str:
    """Where an input comes from: a path, a value, or a function of several."""
    if isinstance(source, str):
        return source
    if isinstance(source, Connection):
        inner = (s if isinstance(s, str) else f"{s.base:.4g}" for s in source.sources if not isinstance(s, Params))
        return f"{source.function.__name__.replace('_', ' ')} of {', '.join(inner)}"
    if isinstance(source, Signal):
        return signal_with_unit(source, kind) if kind else f"{source.base:.4g}"
    return f"{source:.4g}"


def main_values(values: Params | None) -> Lines:
    """The values of a parameter class that say most about it, at most two, each with its unit.

    Left out are zeros, shares, times, what stands at its usual value, what has an unwieldy unit, and a second value in
    a unit that is not one of size.
    """
    if values is None:
        return ()
    usual = default_values(type(values))
    found: list[tuple[Kind, str]] = []
    units: set[str] = set()
    for name, kind in field_kinds(type(values)).items():
        value = getattr(values, name)
        plain = kind is not None and isinstance(value, float) and value != 0.0 and usual.get(name) != value
        if kind is None or not plain or kind.unit in ("1", "SI") or kind in UNSAID or "transition" in name:
            continue
        if "(" in kind.display_unit or (kind.unit in units and kind.unit not in SIZES):
            continue
        units.add(kind.unit)
        found.append((kind, with_unit(value, kind)))
    found.sort(key=lambda entry: entry[0] not in FIRST)
    return tuple(text for _, text in found[:MOST_LABELS])
