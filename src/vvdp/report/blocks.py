"""Blocks of a diagram: one symbol or a chain of them on a shaft, with labels and the lines that leave them.

All places are from the block's axis, which is the height of its shaft or rod; y counts downward.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum

from vvdp.report.lettering import extent
from vvdp.report.symbol import Box, Side, Symbol
from vvdp.report.symbol_set import Fitted

Point = tuple[float, float]
GAP, LANE = 8.0, 11.0
"""Space between a symbol and its label, and between lines beside it [px]."""
LEAD = 12.0
"""How far a line leaves a symbol straight [px]."""


class Beside(Enum):
    """Where a label stands."""

    RIGHT = "right"
    BELOW = "below"
    ABOVE = "above"
    ABOVE_RIGHT = "above right"


@dataclass(frozen=True)
class Label:
    """Lines of text in a box; the first is the name."""

    lines: tuple[str, ...]
    box: Box
    anchor: str = "start"


@dataclass(frozen=True)
class Lead:
    """The line of a port from its terminal to where it goes up or down to its node, or to a tank of its own."""

    owner: str
    port: str
    node: str
    points: tuple[Point, ...]
    up: bool
    tank: bool = False
    pilot: bool = False

    @property
    def x(self) -> float:
        """Where it goes up or down."""
        return self.points[-1][0]


@dataclass(frozen=True)
class Piece:
    """A symbol with its centre, its label and its lines; `box` holds them all."""

    name: str
    symbol: Symbol
    at: Point
    label: Label
    leads: tuple[Lead, ...]
    box: Box

    def moved(self, dx: float, dy: float) -> "Piece":
        """The piece somewhere else."""
        leads = tuple(replace(lead, points=tuple((x + dx, y + dy) for x, y in lead.points)) for lead in self.leads)
        label = replace(self.label, box=shifted(self.label.box, dx, dy))
        at = (self.at[0] + dx, self.at[1] + dy)
        return replace(self, at=at, label=label, leads=leads, box=shifted(self.box, dx, dy))

    @property
    def body(self) -> Box:
        """The box of the symbol alone."""
        return shifted(self.symbol.box, *self.at)


@dataclass(frozen=True)
class Block:
    """Pieces that are placed as one, in a band, with the double lines between them."""

    pieces: tuple[Piece, ...]
    links: tuple[tuple[Point, ...], ...]
    band: int
    column: float | None = None

    @property
    def name(self) -> str:
        """The name of its first piece."""
        return self.pieces[0].name

    @property
    def leads(self) -> tuple[Lead, ...]:
        """The lines of all pieces."""
        return tuple(lead for piece in self.pieces for lead in piece.leads)

    @property
    def box(self) -> Box:
        """What holds all pieces."""
        return around([piece.box for piece in self.pieces])


def shifted(box: Box, dx: float, dy: float) -> Box:
    """A box somewhere else."""
    return box[0] + dx, box[1] + dy, box[2] + dx, box[3] + dy


def around(boxes: Sequence[Box]) -> Box:
    """The box around boxes."""
    lefts, tops, rights, bottoms = zip(*boxes, strict=True)
    return min(lefts), min(tops), max(rights), max(bottoms)


def placed_label(lines: Sequence[str], symbol: Symbol, beside: Beside) -> Label:
    """The label of a symbol with its centre at (0, 0)."""
    wide, high = extent(lines)
    x0, y0, x1, y1 = symbol.box
    middle = 0.5 * (x0 + x1)
    if beside is Beside.RIGHT:
        return Label(tuple(lines), (x1 + GAP, -0.5 * high, x1 + GAP + wide, 0.5 * high))
    if beside is Beside.ABOVE_RIGHT:
        tops = [t.x for t in symbol.terminals.values() if t.side is Side.TOP]
        x = max(tops, default=middle) + GAP
        return Label(tuple(lines), (x, y0 - 2 - high, x + wide, y0 - 2))
    if beside is Beside.ABOVE:
        return Label(tuple(lines), (middle - 0.5 * wide, y0 - 6 - high, middle + 0.5 * wide, y0 - 6), "middle")
    return Label(tuple(lines), (middle - 0.5 * wide, y1 + 4, middle + 0.5 * wide, y1 + 4 + high), "middle")


def piece(
    name: str,
    fit: Fitted,
    nodes: Mapping[str, str],
    lines: Sequence[str],
    beside: Beside,
    levels: tuple[Mapping[str, int], int],
) -> Piece:
    """A piece with its centre at (0, 0). `nodes` are those of its ports, `levels` those of the nodes and its band."""
    label = placed_label(lines, fit.symbol, beside)
    inner = around([fit.symbol.box, label.box]) if lines else fit.symbol.box
    lanes, leads, outer = {Side.LEFT: inner[0], Side.RIGHT: inner[2]}, list[Lead](), [inner]
    middle, ends_shaft = 0.5 * (inner[0] + inner[2]), bool(fit.links) and beside is Beside.RIGHT
    level, band = levels
    for port, terminal in fit.terminals.items():
        node, t = nodes[port], fit.symbol.terminals[terminal]
        tank, up = node not in level, node in level and level[node] >= band
        if t.side in (Side.TOP, Side.BOTTOM) and (t.side is Side.TOP) == up:
            points: tuple[Point, ...] = ((t.x, t.y),)
        else:
            side = t.side if t.side in lanes else Side.RIGHT if t.x > middle or ends_shaft else Side.LEFT
            aside, outward = (LANE + 6.0 if tank else LANE), (1.0 if side is Side.RIGHT else -1.0)
            lanes[side] += outward * aside
            points = _around_corner((t.x, t.y), t.side, lanes[side], inner)
            lanes[side] += outward * (6.0 if tank else 0.0)
        down = points[-1][1] + LEAD
        if tank and len(points) > 1:
            down = max(down, inner[3] - LEAD)
        lead = Lead(
            name, port, node, (*points, (points[-1][0], down)) if tank else points, up, tank, terminal == "pilot"
        )
        leads.append(lead)
        outer.append(_reach(lead))
    return Piece(name, fit.symbol, (0.0, 0.0), label, tuple(leads), around(outer))


def _around_corner(begin: Point, side: Side, lane: float, inner: Box) -> tuple[Point, ...]:
    """The way from a terminal to a lane beside the symbol."""
    if side in (Side.LEFT, Side.RIGHT):
        return begin, (lane, begin[1])
    y = inner[1] - LEAD if side is Side.TOP else inner[3] + LEAD
    return begin, (begin[0], y), (lane, y)


def _reach(lead: Lead) -> Box:
    xs, ys = [x for x, _ in lead.points], [y for _, y in lead.points]
    if lead.tank:
        return min(*xs, lead.x - 15), min(ys), max(*xs, lead.x + 15), max(ys) + 16
    return min(xs) - 3, min(ys), max(xs) + 3, max(ys)
