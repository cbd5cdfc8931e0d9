"""The diagram of a circuit, laid out from its graph: pumps below, loads above, nodes as lines between them."""

from collections.abc import Iterator, Mapping
from html import escape
from types import MappingProxyType

from vvdp.network.graph import Graph, GraphComponent, NodeKind
from vvdp.report import symbols as draw
from vvdp.report.bench_diagram import circuit_diagram as circuit_diagram  # until reports draw graphs
from vvdp.report.blocks import Label, Point
from vvdp.report.chains import blocks, setting
from vvdp.report.lettering import LEADING, SIZE, wrapped
from vvdp.report.machine_symbols import tank
from vvdp.report.placing import Placing
from vvdp.report.routing import Plan, Rail, Wire, plan
from vvdp.report.symbol_set import UNKNOWN_LETTER, entry

NO_VALUES: Mapping[str, tuple[str, ...]] = MappingProxyType({})
LEAST_WIDTH = 900.0
"""A narrower drawing has empty margins, so that its text is not blown up on a page [px]."""
FONTS = "Helvetica Neue, Arial, Liberation Sans, DejaVu Sans, sans-serif"


def diagram(graph: Graph, values: Mapping[str, tuple[str, ...]] = NO_VALUES) -> str:
    """The circuit diagram of a graph as one SVG element; `values` are further lines of text by name of the part."""
    made = laid_out(graph, values)
    width = max(LEAST_WIDTH, made.width)
    left = -0.5 * (width - made.width)
    title = escape(graph.title)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{left:.1f} 0 {width:.1f} {made.height:.1f}" role="img" '
        f'aria-label="{escape(graph.title, quote=True)}" font-family="{FONTS}" font-size="{SIZE:g}">\n'
        f"<title>{title}</title>\n"
        f'<g fill="none" stroke="{draw.INK}" stroke-width="1.7" stroke-linecap="round" stroke-linejoin="round">\n'
        + "\n".join(_parts(made))
        + "\n</g>\n</svg>\n"
    )


def laid_out(graph: Graph, values: Mapping[str, tuple[str, ...]] = NO_VALUES) -> Plan:
    """The place of every symbol, line and label of a graph's diagram."""
    marks = _marks(graph, values)
    return _plan(graph, values, marks)


def designations(graph: Graph) -> dict[str, str]:
    """The designation of each component: its own, else a letter for its symbol and a number in order of the layout."""
    return _marks(graph, NO_VALUES)


def _marks(graph: Graph, values: Mapping[str, tuple[str, ...]]) -> dict[str, str]:
    """Numbers by columns of the layout made with marks of the same width."""
    draft = _plan(graph, values, {c.name: c.designation or f"{_letter(c)}0" for c in graph.components})
    places = {piece.name: piece.at for piece in draft.pieces}
    marks = {c.name: c.designation for c in graph.components if c.designation}
    rest = [c for c in graph.components if not c.designation]
    for component in sorted(rest, key=lambda c: (round(places[c.name][0] / 60.0), -places[c.name][1], c.name)):
        letter, number, taken = _letter(component), 1, set(marks.values())
        while f"{letter}{number}" in taken:
            number += 1
        marks[component.name] = f"{letter}{number}"
    return marks


def _letter(component: GraphComponent) -> str:
    found = entry(component.symbol)
    return found.letter if found else UNKNOWN_LETTER


def _plan(graph: Graph, values: Mapping[str, tuple[str, ...]], marks: Mapping[str, str]) -> Plan:
    texts = _texts(graph, values, marks)
    given = setting(graph, lambda name: texts[name])
    made = blocks(given)
    lines = {n.name: texts[n.name] for n in graph.nodes if n.kind in (NodeKind.VOLUME,)}
    return plan(made, given.level, Placing(made, given.level, _flows(graph, given.level)), lines)


def _flows(graph: Graph, level: Mapping[str, int]) -> list[tuple[str, str]]:
    """Pairs of nodes between which a component lets flow pass, the first below the second or on its level."""
    pairs = []
    for component in graph.components:
        met = [node for node in component.ports.values() if node in level]
        pairs += [(a, b) for a in met for b in met if level[a] < level[b]]
        if len(met) == 2 and level[met[0]] == level[met[1]]:
            pairs.append((met[0], met[1]))
    return pairs


def _texts(
    graph: Graph, values: Mapping[str, tuple[str, ...]], marks: Mapping[str, str]
) -> dict[str, tuple[str, ...]]:
    """The label of every part: its mark and name, its own lines, what it follows and the given values."""
    texts = {}
    for component in graph.components:
        follows = [f"{put}: {source}" for put, source in component.connections.items()]
        lines = wrapped((*component.labels, *values.get(component.name, ()), *follows), 24)
        texts[component.name] = (f"{marks[component.name]} {component.name}", *lines)
    for node in graph.nodes:
        limit = 34 if node.kind is NodeKind.VOLUME else 20
        texts[node.name] = (node.name, *wrapped((*node.labels, *values.get(node.name, ())), limit))
    return texts


def _parts(made: Plan) -> Iterator[str]:
    for link in made.links:
        yield _double(link)
    for wire in made.wires:
        yield from _wire(wire)
    for rail in made.rails:
        yield _rail(rail)
    for piece in made.pieces:
        yield piece.symbol.drawn(*piece.at, escape(piece.label.lines[0]))
        yield _label(piece.label)
    for label in made.names.values():
        yield _label(label)


def _wire(wire: Wire) -> Iterator[str]:
    yield draw.pipe(*wire.points)
    if wire.tank:
        x, y = wire.points[-1]
        yield tank().drawn(x, y + 2, escape(wire.node))


def _rail(rail: Rail) -> str:
    """A node's line with a dot wherever lines are joined."""
    begin, end = rail.ends
    line = f"<g><title>{escape(rail.node)}</title>"
    if end > begin:
        line += draw.pipe((begin, rail.y), (end, rail.y))
    for x in sorted({*rail.tops, *rail.bottoms}):
        branches = rail.tops.count(x) + rail.bottoms.count(x) + (x > begin) + (x < end)
        line += draw.junction(x, rail.y) if branches > 2 or begin == end else ""
    return line + "</g>"


def _double(points: tuple[Point, ...]) -> str:
    """A shaft or rod along a straight line."""
    (x0, y0), (x1, y1) = points
    dx, dy = (0.0, 2.6) if y0 == y1 else (2.6, 0.0)
    return draw.pipe((x0 - dx, y0 - dy), (x1 - dx, y1 - dy)) + draw.pipe((x0 + dx, y0 + dy), (x1 + dx, y1 + dy))


def _label(label: Label) -> str:
    """The lines of a label, the first in bold."""
    if not label.lines:
        return ""
    x = label.box[0] if label.anchor == "start" else 0.5 * (label.box[0] + label.box[2])
    first, *rest = label.lines
    spans = f'<tspan x="{x:.1f}" font-weight="600" fill="{draw.INK}">{escape(first)}</tspan>'
    spans += "".join(f'<tspan x="{x:.1f}" dy="{LEADING:g}">{escape(line)}</tspan>' for line in rest)
    y = label.box[1] + 12.0
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{label.anchor}" fill="{draw.QUIET}" stroke="none">{spans}</text>'
