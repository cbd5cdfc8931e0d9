"""The diagram of a circuit, laid out from its graph: pumps below, loads above, nodes as lines between them."""

from collections.abc import Callable, Iterator, Mapping
from html import escape
from types import MappingProxyType

from vvdp.network.graph import Graph, GraphComponent, NodeKind
from vvdp.report import symbols as draw
from vvdp.report.blocks import Label
from vvdp.report.captions import NARROW, USUAL, Lines, captions
from vvdp.report.chains import Setting, blocks, setting
from vvdp.report.leads import Point
from vvdp.report.lettering import LEADING, SIZE
from vvdp.report.machine_symbols import tank
from vvdp.report.placing import place_blocks
from vvdp.report.routing import Plan, Rail, Wire, plan
from vvdp.report.signals import signal_lines
from vvdp.report.symbol import Side
from vvdp.report.symbol_set import UNKNOWN_LETTER, entry

NO_VALUES: Mapping[str, Lines] = MappingProxyType({})
LEAST_WIDTH = 900.0
"""A narrower drawing has empty margins, so that its text is not blown up on a page [px]."""
MOST_WIDTH = 1150.0
"""Wider drawings get narrow texts [px]."""
COLUMN = 60.0
"""Components within so much count as one above the other when they are numbered [px]."""
FONTS = "Helvetica Neue, Arial, Liberation Sans, DejaVu Sans, sans-serif"


def diagram(graph: Graph, values: Mapping[str, Lines] = NO_VALUES, *, named: bool = False) -> str:
    """The circuit diagram of a graph as one SVG element; `values` are further lines of text by name of the part.

    If `named`, scripts find what belongs to a part: a group around each symbol and label has `data-part`, around each
    line `data-node`, and around the line of a port `data-owner` and `data-port` as well.
    """
    made = laid_out(graph, values)
    width = max(LEAST_WIDTH, made.width)
    left = -0.5 * (width - made.width)
    title = escape(graph.title)
    parts = _parts(made, _anchors(graph), _in_group if named else _plain)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{left:.1f} 0 {width:.1f} {made.height:.1f}" role="img" '
        f'aria-label="{escape(graph.title, quote=True)}" font-family="{FONTS}" font-size="{SIZE:g}">\n'
        f"<title>{title}</title>\n"
        f'<g fill="none" stroke="{draw.INK}" stroke-width="1.7" stroke-linecap="round" stroke-linejoin="round">\n'
        + "\n".join([*parts, *(_signal(*line) for line in signal_lines(graph, made))])
        + "\n</g>\n</svg>\n"
    )


def laid_out(graph: Graph, values: Mapping[str, Lines] = NO_VALUES) -> Plan:
    """The place of every symbol, line and label of a graph's diagram."""
    return _plan(graph, values, designations(graph))


def designations(graph: Graph) -> dict[str, str]:
    """The designation of each component: its own, else a letter for its symbol and a number in order of the layout."""
    draft = _plan(graph, NO_VALUES, {c.name: c.designation or f"{_letter(c)}0" for c in graph.components})
    places = {piece.name: piece.at for piece in draft.pieces}
    marks = {c.name: c.designation for c in graph.components if c.designation}
    rest = [c for c in graph.components if not c.designation]
    for component in sorted(rest, key=lambda c: (round(places[c.name][0] / COLUMN), -places[c.name][1], c.name)):
        letter, number, taken = _letter(component), 1, set(marks.values())
        while f"{letter}{number}" in taken:
            number += 1
        marks[component.name] = f"{letter}{number}"
    return {component.name: marks[component.name] for component in graph.components}


def _letter(component: GraphComponent) -> str:
    found = entry(component.symbol)
    return found.letter if found else UNKNOWN_LETTER


def _plan(graph: Graph, values: Mapping[str, Lines], marks: Mapping[str, str]) -> Plan:
    """The layout with texts as usual or, where that is too wide for a page, with narrow ones."""
    usual = _arrange(graph, captions(graph, values, marks, USUAL))
    return usual if usual.width <= MOST_WIDTH else _arrange(graph, captions(graph, values, marks, NARROW))


def _arrange(graph: Graph, texts: Mapping[str, Lines]) -> Plan:
    given = setting(graph, lambda name: texts[name])
    made = blocks(given)
    lines = {node.name: texts[node.name] for node in graph.nodes if node.kind is NodeKind.VOLUME}
    return plan(made, given.level, place_blocks(made, given.level, _sends(given)), lines)


def _sends(given: Setting) -> frozenset[tuple[str, str]]:
    """The components and ports through which flow leaves into the circuit; a source of pressure is its node's."""
    sides = (Side.TOP, Side.RIGHT)
    found = {
        (name, port) for name, fit in given.fits.items() for port in fit.terminals if fit.terminal(port).side in sides
    }
    entered = {given.graph.component(name).ports[port] for name, port in found}
    return frozenset(found | {(n.name, "port") for n in given.graph.nodes if n.name not in entered})


def _anchors(graph: Graph) -> dict[str, str]:
    """Where the drawing of what is in a component stands on a page, by its name."""
    return {component.name: component.opens for component in graph.components if component.opens}


def _plain(svg: str, **names: str) -> str:
    return svg


def _in_group(svg: str, **names: str) -> str:
    """A drawing in a group that has names as attributes; nothing where nothing is drawn."""
    attributes = "".join(f' data-{key}="{escape(name, quote=True)}"' for key, name in names.items())
    return f"<g{attributes}>{svg}</g>" if svg else ""


def _parts(made: Plan, anchors: Mapping[str, str], mark: Callable[..., str]) -> Iterator[str]:
    for link in made.links:
        yield _double(link)
    for wire in made.wires:
        yield mark("\n".join(_wire(wire)), node=wire.node, owner=wire.owner, port=wire.port)
    for rail in made.rails:
        yield mark(_rail(rail), node=rail.node)
    for piece in made.pieces:
        symbol = piece.symbol.draw_at(*piece.at, escape(piece.label.lines[0]))
        opens = anchors.get(piece.name)
        yield mark(f'<a href="#{escape(opens, quote=True)}">{symbol}</a>' if opens else symbol, part=piece.name)
        yield mark(_label(piece.label), part=piece.name)
    for node, label in made.names.items():
        yield mark(_label(label), part=node)


def _wire(wire: Wire) -> Iterator[str]:
    yield draw.pipe(*wire.points, pilot=wire.pilot)
    if wire.tank:
        x, y = wire.points[-1]
        yield tank().draw_at(x, y + 2, escape(wire.node))


def _signal(x0: float, x1: float, y: float, name: str) -> str:
    """A thin dashed line to the right with the name of what it carries on hover."""
    line = f'<path d="M {x0:.1f} {y:.1f} H {x1 - 5:.1f}" stroke-dasharray="3 3" stroke-width="1"/>'
    return f"<g><title>{escape(name)}</title>{line}{draw.arrow_head(x1, y, (1, 0), 6)}</g>"


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
    if y0 == y1:
        return draw.pipe((x0, y0 - 2.6), (x1, y0 - 2.6)) + draw.pipe((x0, y0 + 2.6), (x1, y0 + 2.6))
    return f'<rect x="{x0 - 2.6:.1f}" y="{y0 - 2.6:.1f}" width="5.2" height="{y1 - y0 + 5.2:.1f}" fill="#fff"/>'


def _label(label: Label) -> str:
    """The lines of a label, the first in bold."""
    if not label.lines:
        return ""
    x = label.box[0] if label.anchor == "start" else 0.5 * (label.box[0] + label.box[2])
    first, *rest = label.lines
    spans = f'<tspan x="{x:.1f}" font-weight="600" fill="{draw.INK}">{escape(first)}</tspan>'
    spans += "".join(f'<tspan x="{x:.1f}" dy="{LEADING:g}">{escape(line)}</tspan>' for line in rest)
    y = label.box[1] + 12.0
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{label.anchor}" fill="{draw.QUIET}" stroke="none">{spans}</text>'
    )
