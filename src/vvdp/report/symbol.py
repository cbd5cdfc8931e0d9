"""A symbol with the places where lines end on it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from types import MappingProxyType

from vvdp.report.symbols import letter

Box = tuple[float, float, float, float]
"""Left, top, right and bottom edge; y counts downward."""
Letter = tuple[float, float, str, float]
"""Centre, text and size of a letter."""


class Side(Enum):
    """Where a line leaves a symbol."""

    TOP = "top"
    BOTTOM = "bottom"
    LEFT = "left"
    RIGHT = "right"


UPSIDE_DOWN = {Side.TOP: Side.BOTTOM, Side.BOTTOM: Side.TOP}
MIRRORED = {Side.LEFT: Side.RIGHT, Side.RIGHT: Side.LEFT}


@dataclass(frozen=True)
class Terminal:
    """The end of a line at a symbol, from the symbol's centre."""

    x: float
    y: float
    side: Side


@dataclass(frozen=True)
class Symbol:
    """A drawing about its centre (0, 0).

    `terminals` take hydraulic lines; `axis` says at which x a shaft or rod joins on the left and on the right, at the
    height of the centre, None where it cannot. `letters` stay upright when the symbol is turned.
    """

    box: Box
    svg: str
    terminals: Mapping[str, Terminal] = field(default_factory=lambda: MappingProxyType({}))
    axis: tuple[float | None, float | None] = (None, None)
    letters: tuple[Letter, ...] = ()

    def upside_down(self) -> "Symbol":
        """The symbol with top and bottom exchanged."""
        x0, y0, x1, y1 = self.box
        turned = {n: Terminal(t.x, -t.y, UPSIDE_DOWN.get(t.side, t.side)) for n, t in self.terminals.items()}
        letters = tuple((x, -y, text, size) for x, y, text, size in self.letters)
        return Symbol((x0, -y1, x1, -y0), f'<g transform="scale(1 -1)">{self.svg}</g>', turned, self.axis, letters)

    def mirror(self) -> "Symbol":
        """The symbol with left and right exchanged."""
        x0, y0, x1, y1 = self.box
        turned = {n: Terminal(-t.x, t.y, MIRRORED.get(t.side, t.side)) for n, t in self.terminals.items()}
        letters = tuple((-x, y, text, size) for x, y, text, size in self.letters)
        left, right = (None if x is None else -x for x in self.axis)
        return Symbol((-x1, y0, -x0, y1), f'<g transform="scale(-1 1)">{self.svg}</g>', turned, (right, left), letters)

    def draw_at(self, x: float, y: float, tooltip: str = "") -> str:
        """The symbol with its centre at (x, y) and `tooltip`, ready text, shown on hover."""
        title = f"<title>{tooltip}</title>" if tooltip else ""
        letters = "".join(letter(*each) for each in self.letters)
        return f'<g transform="translate({x:.1f} {y:.1f})">{title}{self.svg}{letters}</g>'
