"""An item of the dissertation, and what working it out gives."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from vvdp.results.chart import Chart, Line, Lines, Panel, Picture, Stroke
from vvdp.results.result import Table
from vvdp.results.verdict import Statement


class ItemKind(StrEnum):
    """Kind of an item."""

    FIGURE = "figure"
    TABLE = "table"
    EQUATION = "equation"
    SECTION = "section"


@dataclass(frozen=True, kw_only=True)
class Reproduction:
    """Reproduction of an item: its statements with their verdicts, the figure that replaces the source's, and the data
    that it draws.
    """

    statements: tuple[Statement, ...]
    tables: Mapping[str, Table] = field(default_factory=dict)
    charts: tuple[Chart, ...] = ()
    pictures: tuple[Picture, ...] = ()


def over(
    x: str, *columns: str, label: str = "", stroke: Stroke = Stroke.SOLID, width: float = 1.3, **more: Any
) -> Lines:
    """A panel of lines over one column `x`, alike but for their colours. `more` are fields of the panel."""
    lines = tuple(Line(x=x, y=column, stroke=stroke, width=width) for column in columns)
    return Lines(lines=lines, label=label, **more)


def figure_of(
    name: str,
    caption: str,
    tables: Mapping[str, Table],
    statements: tuple[Statement, ...],
    *panels: Panel,
    height: float = 2.6,
) -> Reproduction:
    """Statements with a figure of panels, one above the other, over the first of the `tables`."""
    chart = Chart(name=name, caption=caption, table=next(iter(tables)), panels=panels, height=height)
    return Reproduction(statements=statements, tables=tables, charts=(chart,))


@dataclass(frozen=True)
class Item:
    """A figure, a table, an equation, or the claimed numbers of a section: its number, its title, and the function
    that calculates it."""

    kind: ItemKind
    number: str
    title: str
    work: Callable[[], Reproduction]

    @property
    def name(self) -> str:
        """Name on the command line, such as figure-3.9."""
        return f"{self.kind}-{self.number}"

    @property
    def places(self) -> tuple[int, ...]:
        """Its number, place by place: (3, 10) for 3.10."""
        return tuple(int(part) for part in self.number.split("."))

    @property
    def chapter(self) -> int:
        """The chapter in which it stands."""
        return self.places[0]
