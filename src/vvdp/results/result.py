"""Result of a study: numbers, tables, findings and figures as data, each with its kind.

A kind gives the unit, so nothing is read back from a key; a key ends with the SI unit of its kind all the same
(`base.display.key_suffix`), since files outlive their context, and a key that contradicts its kind is refused.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from vvdp.base.arrays import Array
from vvdp.base.display import key_suffix
from vvdp.base.kinds import FLAG, Kind
from vvdp.results.chart import Chart

Texts: TypeAlias = NDArray[np.str_]


@dataclass(frozen=True)
class Number:
    """A value [SI] with what it is; `label` is what a user reads."""

    value: float
    kind: Kind
    label: str


@dataclass(frozen=True)
class Column:
    """A quantity over all rows of a table [SI]; a text column has no kind."""

    values: Array | Texts
    kind: Kind | None
    label: str
    symbol: str = ""


@dataclass(frozen=True, kw_only=True)
class Table:
    """Columns of one length. `shown` are those that a page shows, all where there are none; `axes` those it goes
    through in every combination.
    """

    title: str
    columns: Mapping[str, Column]
    shown: tuple[str, ...] = ()
    axes: tuple[str, ...] = ()
    note: str = ""
    is_data: bool = False
    """Whether it is there for figures and programs only."""

    def __post_init__(self) -> None:
        for key, column in self.columns.items():
            _check_key(key, column.kind)
        if len({len(column.values) for column in self.columns.values()}) > 1:
            raise ValueError(f"columns of {self.title!r} differ in length")

    def __getitem__(self, key: str) -> Any:
        """The values of a column."""
        return self.columns[key].values

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(next(iter(self.columns.values())).values) if self.columns else 0


@dataclass(frozen=True)
class Row:
    """A line of a listing: what it is, and a value [SI] or a text under each head; None where there is none."""

    label: str
    kind: Kind | None
    values: tuple[float | str | None, ...]
    group: str = ""
    """Lines of one group stand together below its name."""
    note: str = ""
    is_part: bool = False
    """Whether it is contained in the line before."""
    is_sum: bool = False


@dataclass(frozen=True, kw_only=True)
class Listing:
    """Quantities of different kinds, a line each, under common heads such as "simulated" and "analytic"."""

    title: str
    heads: tuple[str, ...]
    rows: tuple[Row, ...]
    note: str = ""

    @property
    def numeric(self) -> tuple[int, ...]:
        """Places of the columns that are not all words."""
        places = range(len(self.heads))
        return tuple(place for place in places if not all(isinstance(row.values[place], str) for row in self.rows))

    @property
    def unit_place(self) -> int:
        """Number of columns before that of the units: they follow the last number, and words follow them."""
        return self.numeric[-1] + 1 if self.numeric else len(self.heads)


class Grade(StrEnum):
    """How grave a finding is."""

    PLAIN = ""
    GOOD = "good"
    WARNING = "warn"
    BAD = "bad"


@dataclass(frozen=True, kw_only=True)
class Finding:
    """A whole sentence that the numbers come to. A warning has a title, and says what can be done about it."""

    text: str
    grade: Grade = Grade.PLAIN
    title: str = ""
    remedy: str = ""


@dataclass(frozen=True)
class Badge:
    """The state of a result in a word or two."""

    words: str
    grade: Grade = Grade.PLAIN


@dataclass(frozen=True, kw_only=True)
class Section:
    """A part of a page: words, then the charts, listings and tables that `shows` names, in this order.

    `starts_page` is whether it begins on a new sheet of paper; `text` stands at the end as it is, such as a file.
    """

    title: str
    words: tuple[str, ...] = ()
    shows: tuple[str, ...] = ()
    starts_page: bool = False
    text: str = ""


@dataclass(frozen=True, kw_only=True)
class Result:
    """Result of a study. `references` are keys of the bibliography; `command` is what a user types to have it again.

    `verb` names what made it, as on the command line. `sections` order the page; what none of them shows is data only.
    """

    verb: str
    title: str
    system: str
    manner: str = ""
    references: tuple[str, ...] = ()
    conditions: Mapping[str, str] = field(default_factory=dict)
    left_out: tuple[str, ...] = ()
    numbers: Mapping[str, Number] = field(default_factory=dict)
    listings: Mapping[str, Listing] = field(default_factory=dict)
    tables: Mapping[str, Table] = field(default_factory=dict)
    charts: Mapping[str, Chart] = field(default_factory=dict)
    badges: tuple[Badge, ...] = ()
    findings: tuple[Finding, ...] = ()
    sections: tuple[Section, ...] = ()
    seconds: float = 0.0
    finished: bool = True

    def __post_init__(self) -> None:
        for key, number in self.numbers.items():
            _check_key(key, number.kind)
        names = [*self.listings, *self.tables, *self.charts]
        if double := {name for name in names if names.count(name) > 1}:
            raise ValueError(f"{min(double)!r} is the name of two parts of the result")
        for chart in self.charts.values():
            if missing := chart.tables - self.tables.keys():
                raise ValueError(f"chart {chart.name!r} draws the table {min(missing)!r}, which is none of the result")

    @property
    def flat(self) -> dict[str, Any]:
        """All numbers as one flat object: the figures, then every column, prefixed where there are several tables."""
        found: dict[str, Any] = {"verb": self.verb, "system": self.system, "finished": self.finished}
        found |= {key: json_value(number) for key, number in self.numbers.items()}
        for name, table in self.tables.items():
            prefix = f"{name}_" if len(self.tables) > 1 else ""
            found |= {f"{prefix}{key}": plain_values(column) for key, column in table.columns.items()}
        return found | {"warnings": [each.text for each in self.findings if each.grade in (Grade.WARNING, Grade.BAD)]}


def plain_values(column: Column) -> list[Any]:
    """The values of a column as files have them: counts and flags as whole numbers."""
    values: list[Any] = column.values.tolist()
    if column.kind is None or not (column.kind is FLAG or column.kind.name == "count"):
        return values
    return [int(value) if float(value).is_integer() else value for value in values]


def json_value(number: Number) -> float | bool | int:
    """A number as JSON has it: a flag as true or false, a count as a whole number; what is not known stays nan."""
    if number.kind is FLAG and math.isfinite(number.value):
        return bool(number.value)
    is_count = number.kind.name == "count" and float(number.value).is_integer()
    return int(number.value) if is_count else float(number.value)


def numbers_of(values: Mapping[str, float], quantities: Mapping[str, tuple[Kind, str]]) -> dict[str, Number]:
    """Numbers with the kind and label that `quantities` has under their keys."""
    return {key: Number(float(value), *quantities[key]) for key, value in values.items()}


def listing_of(values: Mapping[str, float], quantities: Mapping[str, tuple[Kind, str]]) -> Listing:
    """Values as a listing without a title, in the order of `quantities`, which has kind and label of each."""
    rows = tuple(Row(label, kind, (values[key],)) for key, (kind, label) in quantities.items())
    return Listing(title="", heads=("value",), rows=rows)


def sentences(texts: Sequence[str], grade: Grade = Grade.PLAIN) -> Iterator[Finding]:
    """Findings of one grade."""
    return (Finding(text=text, grade=grade) for text in texts)


def _check_key(key: str, kind: Kind | None) -> None:
    suffix = key_suffix(kind) if kind else ""
    if not key.endswith(suffix):
        raise ValueError(
            f"key {key!r} has to end with {suffix!r}, the unit of {kind.with_article if kind else 'a text'}"
        )
