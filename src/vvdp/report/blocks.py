"""Blocks of a diagram: one symbol or a chain of them on a shaft, with labels and the lines that leave them.

All places are from the block's axis, which is the height of its shaft or rod; y counts downward.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum

from vvdp.report.leads import Exit, Lead, Point, lead_lines, reach
from vvdp.report.lettering import extent
from vvdp.report.symbol import Box, Side, Symbol
from vvdp.report.symbol_set import Fitted

GAP = 8.0
"""Space between a symbol and its label [px]."""


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
class Piece:
    """A symbol with its centre, its label and its lines; `box` holds them all."""

    name: str
    symbol: Symbol
    at: Point
    label: Label
    leads: tuple[Lead, ...]
    box: Box

    def translate(self, dx: float, dy: float) -> "Piece":
        """The piece somewhere else."""
        leads = tuple(replace(lead, points=tuple((x + dx, y + dy) for x, y in lead.points)) for lead in self.leads)
        label = replace(self.label, box=shift_box(self.label.box, dx, dy))
        at = (self.at[0] + dx, self.at[1] + dy)
        return replace(self, at=at, label=label, leads=leads, box=shift_box(self.box, dx, dy))

    @property
    def body(self) -> Box:
        """The box of the symbol alone."""
        return shift_box(self.symbol.box, *self.at)


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
        """Box around all pieces."""
        return around([piece.box for piece in self.pieces])


def shift_box(box: Box, dx: float, dy: float) -> Box:
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
    level, band = levels
    exits = [
        Exit(
            port=port,
            node=(node := nodes[port]),
            terminal=fit.symbol.terminals[terminal],
            up=node in level and level[node] >= band,
            tank=node not in level,
            pilot=terminal == "pilot",
        )
        for port, terminal in fit.terminals.items()
    ]
    leads = lead_lines(name, exits, inner, to_right=bool(fit.links) and beside is Beside.RIGHT)
    box = around([inner, *(reach(lead) for lead in leads)])
    return Piece(name=name, symbol=fit.symbol, at=(0.0, 0.0), label=label, leads=leads, box=box)
