"""An item of the dissertation, and what working it out gives."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from vvdp.results.chart import Chart, Picture
from vvdp.results.result import Table
from vvdp.results.verdict import Statement


class ItemKind(StrEnum):
    """What an item is."""

    FIGURE = "figure"
    TABLE = "table"
    EQUATION = "equation"
    SECTION = "section"


@dataclass(frozen=True, kw_only=True)
class Reproduction:
    """What an item comes to: its statements with their verdicts, the figure that takes the place of the source's, and
    the data that it draws.
    """

    statements: tuple[Statement, ...]
    tables: Mapping[str, Table] = field(default_factory=dict)
    charts: tuple[Chart, ...] = ()
    pictures: tuple[Picture, ...] = ()


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
        """What it is called on the command line, such as figure-3.9."""
        return f"{self.kind}-{self.number}"

    @property
    def places(self) -> tuple[int, ...]:
        """Its number, place by place: (3, 10) for 3.10."""
        return tuple(int(part) for part in self.number.split("."))

    @property
    def chapter(self) -> int:
        """The chapter in which it stands."""
        return self.places[0]
