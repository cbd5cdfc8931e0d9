"""A figure as data: which columns of which table are drawn, and how. Nothing here draws.

A chart names columns; their label and unit come from the column, so that what is drawn is stated once. The printed
figure, the page that can be zoomed and a notebook are all made from it.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import TypeAlias


class Colour(StrEnum):
    """Colours that keep apart for the colour-blind and differ in lightness for print in grey."""

    INLET = "#d9730d"
    LOAD = "#0b3c6f"
    TANK = "#6aaed6"
    RELIEF = "#5a5a5a"
    GREEN = "#2f7d4f"
    PURPLE = "#7a4fa3"
    RED = "#a3180c"
    OLIVE = "#b9a13c"
    TEAL = "#1f9e9e"
    INK = "#1b1f24"
    FAINT = "#c9ced4"


class Stroke(StrEnum):
    """How the points of a line are joined."""

    SOLID = "-"
    DASHED = "--"
    DOTTED = ":"
    STEPS = "steps"
    POINTS = "points"
    MARKED = "marked"
    """Joined, with a mark at each point."""
    STEMS = "stems"
    """Upright from zero, as the lines of a spectrum."""
    FLAG = "flag"
    """A bar in a row of its own while the value is 1, nothing while it is 0; for panels of nothing else."""


SHADES = ("#a9cce4", "#6aaed6", "#2f6ea3", "#0b3c6f", "#061d38")


def shades(count: int) -> list[str]:
    """`count` shades of one colour, light to dark: for lines in an order."""
    if count < 2:
        return [Colour.LOAD]
    found = []
    for place in range(count):
        whole, part = divmod(place * (len(SHADES) - 1), count - 1)
        ends = (SHADES[whole], SHADES[min(whole + 1, len(SHADES) - 1)])
        low, high = ([int(end[k : k + 2], 16) for k in (1, 3, 5)] for end in ends)
        mixed = (round(a + (b - a) * part / (count - 1)) for a, b in zip(low, high, strict=True))
        found.append("#" + "".join(f"{each:02x}" for each in mixed))
    return found


@dataclass(frozen=True, kw_only=True)
class Line:
    """A line through two columns. `rows` are those of the table that it goes through, all where there are none.

    `low` and `high` name the columns of a band around it. Without a colour the next free one is taken. `table` is that
    of its columns, where it is not that of the panel.
    """

    x: str
    y: str
    label: str = ""
    rows: tuple[int, ...] = ()
    colour: str = ""
    stroke: Stroke = Stroke.SOLID
    width: float = 1.3
    low: str = ""
    high: str = ""
    table: str = ""


@dataclass(frozen=True, kw_only=True)
class Level:
    """A straight line across a panel at `value` [SI of its axis], upright where it is one of x, with its words."""

    value: float
    label: str = ""
    upright: bool = False
    colour: str = Colour.INK
    stroke: Stroke = Stroke.DASHED


@dataclass(frozen=True, kw_only=True)
class Lines:
    """A panel of lines over one axis. `label` stands at the axis of y where the columns have several labels.

    `low`, `high`, `left` and `right` are ends of the axes [SI], where the values do not decide; `height` counts
    against the other panels.
    """

    lines: tuple[Line, ...]
    label: str = ""
    title: str = ""
    x_label: str = ""
    levels: tuple[Level, ...] = ()
    low: float | None = None
    high: float | None = None
    left: float | None = None
    right: float | None = None
    table: str = ""
    """The table of this panel, where it is not that of the chart."""
    height: float = 1.0
    x_log: bool = False
    y_log: bool = False
    legend: str = ""
    """Meaning of the names of the lines; with it they are listed beside the panel."""
    equal: bool = False
    """Whether a unit of x is as long as one of y."""


def flag_panel(x: str, flags: Mapping[str, str], label: str = "", table: str = "") -> Lines:
    """A panel of flags over a column, keys with their labels: the first in the lowest row."""
    lines = tuple(Line(x=x, y=key, label=name, stroke=Stroke.FLAG) for key, name in flags.items())
    return Lines(
        lines=lines, label=label, table=table, low=0.0, high=float(len(lines)), height=0.15 + 0.12 * len(lines)
    )


@dataclass(frozen=True, kw_only=True)
class Bars:
    """A panel of lying bars: the text column `names`, and a bar for each of the columns `values`."""

    names: str
    values: tuple[str, ...]
    labels: tuple[str, ...] = ()
    texts: str = ""
    """A text column that stands behind the bars."""
    label: str = ""
    """Label of the axis if the columns have several labels."""
    colours: tuple[str, ...] = ()
    title: str = ""
    rows: tuple[int, ...] = ()
    base: float | None = None
    """Where all bars of a name begin [SI], one over the other; else they begin at zero, side by side."""
    stacked: bool = False
    """Whether the bars of a name follow one another from zero on; what is below zero counts as none."""
    table: str = ""
    """The table of this panel, where it is not that of the chart."""
    height: float = 1.0


@dataclass(frozen=True, kw_only=True)
class Dots:
    """A panel of dots on a logarithmic scale: the text column `names`, a dot for `value`, a bar from `low` to `high`.

    What is below `least` [SI] is an arrow at the edge of the scale.
    """

    names: str
    value: str
    least: float
    low: str = ""
    high: str = ""
    title: str = ""
    rows: tuple[int, ...] = ()
    table: str = ""
    """The table of this panel, where it is not that of the chart."""
    height: float = 1.0


@dataclass(frozen=True, kw_only=True)
class Field:
    """A panel of `z` over the grid of `x` and `y`, as filled contours.

    It is hatched where the column `hatch` is above 0, and has a cross at each point where the column `marks` is.
    """

    x: str
    y: str
    z: str
    rows: tuple[int, ...] = ()
    hatch: str = ""
    marks: str = ""
    title: str = ""
    steps: tuple[float, ...] = ()
    """Levels of the contours [SI]."""
    table: str = ""
    """The table of this panel, where it is not that of the chart."""
    height: float = 1.0


Panel: TypeAlias = Lines | Bars | Dots | Field


@dataclass(frozen=True, kw_only=True)
class Chart:
    """A figure: panels over the columns of one table, with the words below it.

    Panels stand one above the other with a common x, or side by side. `height` is that of the printed figure [inch].
    """

    name: str
    caption: str
    table: str
    panels: tuple[Panel, ...]
    side_by_side: bool = False
    share: bool = False
    """Whether panels have one scale."""
    columns: int = 0
    """Panels in a row, where they stand in rows of so many."""
    one_x: bool = False
    """Whether panels in rows have one scale of x, and names of lines of their own."""
    height: float = 3.0

    @property
    def tables(self) -> set[str]:
        """The tables that are drawn."""
        own = {line.table for panel in self.panels if isinstance(panel, Lines) for line in panel.lines}
        return {panel.table or self.table for panel in self.panels} | own - {""}


@dataclass(frozen=True, kw_only=True)
class Picture:
    """A figure that is ready: a drawing as SVG, such as a circuit."""

    name: str
    caption: str
    svg: str
    png: bytes = field(default=b"", repr=False)


Figure: TypeAlias = Chart | Picture
Figures: TypeAlias = Mapping[str, Figure]
