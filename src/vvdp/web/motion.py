"""Moving parts of a circuit diagram: lines with their node and flow, ports, shafts and rods."""

from collections.abc import Iterator
from typing import Any

from vvdp.base.arrays import Array
from vvdp.network.graph import Graph
from vvdp.network.nodes import DrivenShaft, HydraulicNode, OilVolume, Rod, Shaft
from vvdp.report.blocks import Piece
from vvdp.report.circuit import graph_of
from vvdp.report.diagram import laid_out
from vvdp.report.report import diagram_values, lines_of
from vvdp.report.routing import Plan, Wire
from vvdp.runs.run import RecordedRun
from vvdp.web.followed import diagrams
from vvdp.web.series import Recorded, recorded_columns

OPENING = "opening"
WIDE = 2.0
"""A symbol so many times as wide as high turns at its left end, as a rotary valve does."""


def motion(run: RecordedRun) -> tuple[dict[str, Recorded], dict[str, Any]]:
    """The recorded numbers that move a diagram, by name, and by figure what of it they move."""
    known = recorded_columns(run, _courses)
    return known, {figure: _figure(run, part, known) for figure, part in diagrams(run)}


def _courses(run: RecordedRun) -> dict[str, Array]:
    """Recorded values that can move a diagram [SI], by quantity and the part's name; each over the rows."""
    states, outputs = run.record.states, run.record.outputs
    found = {f"flow {name} {port}".strip(): values for name, port, values in run.flows()}
    for name, node in run.network.nodes.items():
        if isinstance(node, HydraulicNode) and (isinstance(node, OilVolume) or f"{name}_pressure" in outputs):
            found[f"pressure {name}"] = run.pressure(name)
        turns = {Shaft: f"{name}.angle", DrivenShaft: name, Rod: f"{name}.position"}.get(type(node), "")
        if turns in states:
            found[f"{'position' if isinstance(node, Rod) else 'angle'} {name}"] = states[turns].values
    for name, part in run.network.parts.items():
        if f"{name}.{OPENING}" in states:
            found[f"{OPENING} {name}"] = states[f"{name}.{OPENING}"].values
        ports = ((port, f"{name}_{port}_{OPENING}") for port in part.nodes)
        found |= {f"{OPENING} {name} {port}": outputs[key].values for port, key in ports if key in outputs}
    return found


def _figure(run: RecordedRun, part: str, known: dict[str, Recorded]) -> dict[str, Any]:
    """Of one diagram: lines, junctions, what turns and what slides, each with the names of its numbers."""
    graph = graph_of(run.network, "", part)
    made = laid_out(graph, lines_of(diagram_values(run)))
    return {
        "wires": [_wire(run, wire, known) for wire in made.wires if not wire.pilot],
        "rails": [_rail(made, place) for place in range(len(made.rails))],
        "turning": [
            [*_hub(piece), f"angle {node}"] for piece, node in _moved_symbols(graph, made) if f"angle {node}" in known
        ],
        "sliding": [
            [*piece.body, f"position {node}"]
            for piece, node in _moved_symbols(graph, made)
            if f"position {node}" in known
        ],
    }


def _wire(run: RecordedRun, wire: Wire, known: dict[str, Recorded]) -> dict[str, Any]:
    """A line from a component to its node: its flow, the sign of that along the line, and what opens it."""
    flow, sign = _flow(run, wire)
    ports = (f"{OPENING} {wire.owner} {wire.port}", f"{OPENING} {wire.owner}")
    return {
        "points": [round(x, 1) for point in wire.points for x in point],
        "pressure": f"pressure {wire.node}",
        "flow": flow if flow in known else None,
        "sign": sign,
        "opening": next((name for name in ports if name in known), None),
    }


def _flow(run: RecordedRun, wire: Wire) -> tuple[str, int]:
    """The name of a line's flow and its sign away from the component. What walls sweep is no recorded flow."""
    part = run.network.parts.get(wire.owner)
    if part is not None and part.component.moves_walls:
        return "", 0
    joined = run.network.groups[wire.owner].ports if wire.owner in run.network.groups else {}
    ports = [p for p, node in (joined or (part.nodes if part else {})).items() if _holds_oil(run, node)]
    own = f"flow {wire.owner} {wire.port}"
    if own in _flow_names(run):
        return own, -1
    return f"flow {wire.owner}", -1 if ports[:1] == [wire.port] else 1


def _flow_names(run: RecordedRun) -> set[str]:
    return {f"flow {name} {port}".strip() for name, port, _ in run.flows()}


def _holds_oil(run: RecordedRun, node: str) -> bool:
    return isinstance(run.network.nodes[node], HydraulicNode)


def _rail(made: Plan, place: int) -> dict[str, Any]:
    """The junction line of a node: its ends, and where which of the lines meet it."""
    rail = made.rails[place]
    wires = [wire for wire in made.wires if not wire.pilot]
    meeting = [(wire.points[-1][0], at) for at, wire in enumerate(wires) if wire.node == rail.node and not wire.tank]
    begin, end = rail.ends
    return {
        "y": round(rail.y, 1), "ends": [round(begin, 1), round(end, 1)], "pressure": f"pressure {rail.node}",
        "joints": [[round(x, 1), at] for x, at in sorted(meeting)],
    }  # fmt: skip


def _moved_symbols(graph: Graph, made: Plan) -> Iterator[tuple[Piece, str]]:
    """The symbols that are a shaft or rod, or are joined to one, with its name."""
    pieces = {piece.name: piece for piece in made.pieces}
    kinds = {node.name: node.kind for node in graph.nodes}
    for node in graph.nodes:
        if node.name in pieces:
            yield pieces[node.name], node.name
    for component in graph.components:
        for node_name in component.ports.values():
            if component.name in pieces and kinds[node_name].is_mechanical:
                yield pieces[component.name], node_name


def _hub(piece: Piece) -> tuple[float, float, float]:
    """Where a symbol shows that it turns: a centre and a radius."""
    x0, y0, x1, y1 = piece.body
    half = 0.5 * (y1 - y0)
    x = x0 + 0.5 * half if x1 - x0 > WIDE * (y1 - y0) else 0.5 * (x0 + x1)
    return round(x, 1), round(0.5 * (y0 + y1), 1), round(min(half - 6.0, 20.0), 1)
