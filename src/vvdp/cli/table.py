"""Tables as text for a terminal of any width: a number is never broken, and decimal points stand in line."""

import itertools
import re
import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from rich.console import Console, ConsoleOptions
    from rich.text import Text

GAP, INDENT, MARGIN = 3, 2, 1
"""Characters between two columns, to the left of a table and to the right of it."""
NARROW, NARROWEST = 16, 8
"""Characters below which a text is not wrapped for the sake of another column, and never."""
_NUMBER = re.compile(r"([+\-\u2212]?\d+|[-–])((?:\.\d+)?.*)")


class Column(NamedTuple):
    """A head and a cell for each row; a cell of text may have several lines, one of numbers is never wrapped."""

    head: str
    cells: tuple[str, ...]
    is_numeric: bool

    @property
    def natural(self) -> int:
        """The width at which nothing is wrapped."""
        return max(map(len, (self.head, *self.lines)), default=0)

    @property
    def least(self) -> int:
        """The width at which no word is broken and no text becomes a tower."""
        if self.is_numeric:
            return max(map(len, (*self.head.split(), *self.cells)), default=0)
        longest = max((len(word) for text in (self.head, *self.cells) for word in text.split()), default=0)
        return max(longest, min(self.natural, NARROW))

    @property
    def lines(self) -> list[str]:
        """The lines of all cells."""
        return [line for cell in self.cells for line in cell.split("\n")]


class Block(NamedTuple):
    """The lines of a table, or of a part of one that is too wide."""

    head: list[str]
    rule: str
    body: list[str]


def table_blocks(
    columns: Sequence[Column], width: int, *, keys: int = 1, ends: int = 0, transpose: bool = False
) -> list[Block]:
    """The text of a table that is at most `width` characters wide.

    Where it would be wider, texts are wrapped at words; then, with `transpose`, rows become columns; then the columns
    go into several blocks, each of which begins with the first `keys` columns and ends with the last `ends`.
    """
    columns = [_in_line(column) for column in columns]
    room = width - INDENT - MARGIN
    if widths := _widths(columns, room):
        return [_block(columns, widths)]
    if transpose and (widths := _widths(turned := _transpose(columns), room)):
        return [_block(turned, widths)]
    keys = min(keys, len(columns) - 1 - ends)
    last = len(columns) - ends
    leading, rest, closing = columns[:keys], columns[keys:last], columns[last:]
    blocks = []
    while rest:
        counts = range(len(rest), 0, -1)
        count = next((n for n in counts if _widths([*leading, *rest[:n], *closing], room)), 1)
        part = [*leading, *rest[:count], *closing]
        blocks.append(_block(part, _widths(part, room) or _widths(part, room, broken=True) or [c.least for c in part]))
        rest = rest[count:]
    return blocks


def _in_line(column: Column) -> Column:
    """A column of numbers with its decimal points under each other."""
    if not column.is_numeric:
        return column
    parts = [_NUMBER.fullmatch(cell) for cell in column.cells]
    before = max((len(part[1]) for part in parts if part), default=0)
    after = max((len(part[2]) for part in parts if part), default=0)
    aligned = [
        f"{part[1]:>{before}}{part[2]:<{after}}" if part else cell
        for cell, part in zip(column.cells, parts, strict=True)
    ]
    return column._replace(cells=tuple(aligned))


def _transpose(columns: Sequence[Column]) -> list[Column]:
    """Each row as a column, headed by its first cell."""
    first, *others = columns
    heads = Column(first.head, tuple(column.head for column in others), is_numeric=False)
    rows = zip(*(column.cells for column in others), strict=True)
    return [heads] + [
        _in_line(Column(head.strip(), tuple(cell.strip() for cell in row), is_numeric=True))
        for head, row in zip(first.cells, rows, strict=True)
    ]


def _widths(columns: Sequence[Column], room: int, *, broken: bool = False) -> list[int] | None:
    """The width of each column so that all have `room`; none where they cannot. `broken`: words may be broken."""
    widths = [column.natural for column in columns]
    excess = sum(widths) + GAP * (len(columns) - 1) - room
    if excess <= 0:
        return widths
    least = [NARROWEST if broken and not column.is_numeric else column.least for column in columns]
    for place, column in enumerate(columns):
        if column.is_numeric:  # heads are wrapped before texts are
            saved = min(excess, widths[place] - least[place])
            widths[place], excess = widths[place] - saved, excess - saved
    while excess > 0:
        widest = max(range(len(columns)), key=lambda place: widths[place] - least[place])
        if widths[widest] <= least[widest]:
            return None
        widths[widest], excess = widths[widest] - 1, excess - 1
    return widths


def _block(columns: Sequence[Column], widths: Sequence[int]) -> Block:
    heads = [_wrap(column.head, width) for column, width in zip(columns, widths, strict=True)]
    height = max(map(len, heads))
    body: list[str] = []
    for cells in zip(*(column.cells for column in columns), strict=True):
        body += _lines(columns, widths, [_cell(*each) for each in zip(columns, cells, widths, strict=True)])
    return Block(
        head=_lines(columns, widths, [[""] * (height - len(head)) + head for head in heads]),
        rule=" " * (INDENT - 1) + "─" * (sum(widths) + GAP * (len(widths) - 1) + 2),
        body=body,
    )


def _cell(column: Column, cell: str, width: int) -> list[str]:
    return [cell] if column.is_numeric else [part for line in cell.split("\n") for part in _wrap(line, width)]


def _wrap(text: str, width: int) -> list[str]:
    """The lines of a text, without a word broken that has room."""
    if len(text) <= width:
        return [text]
    return textwrap.wrap(text, width, break_on_hyphens=False) or [""]


def _lines(columns: Sequence[Column], widths: Sequence[int], cells: Sequence[Sequence[str]]) -> list[str]:
    """The lines of a row whose cells may have several each."""
    rows = []
    for parts in itertools.zip_longest(*cells, fillvalue=""):
        each = zip(columns, widths, parts, strict=True)
        texts = (part.rjust(width) if column.is_numeric else part.ljust(width) for column, width, part in each)
        rows.append((" " * INDENT + (" " * GAP).join(texts)).rstrip())
    return rows


@dataclass(kw_only=True)
class Grid:
    """A table that is filled row by row and printed by a console of rich, at the width which that has."""

    def __init__(
        self,
        heads: Sequence[str],
        *,
        title: str = "",
        right: Sequence[str] = (),
        keys: int = 1,
        ends: int = 0,
        transpose: bool = False,
    ) -> None:
        self.heads, self.title, self.right = heads, title, right
        self.keys, self.ends, self.transpose = keys, ends, transpose
        self.rows: list[tuple[str, ...]] = []

    def add_row(self, *cells: str) -> None:
        """Adds a row, a cell for each column."""
        self.rows.append(cells)

    def __rich_console__(self, console: "Console", options: "ConsoleOptions") -> "Iterator[Text]":
        from rich.text import Text

        cells = zip(*self.rows, strict=True) if self.rows else ((),) * len(self.heads)
        columns = [Column(head, tuple(cell), head in self.right) for head, cell in zip(self.heads, cells, strict=True)]
        if self.title:
            yield Text(self.title, style="bold")
        blocks = table_blocks(columns, options.max_width, keys=self.keys, ends=self.ends, transpose=self.transpose)
        for block in blocks:
            yield Text("\n".join(["", *block.head]), style="bold", no_wrap=True, overflow="ignore")
            yield Text("\n".join([block.rule, *block.body]), no_wrap=True, overflow="ignore")
        yield Text("")
