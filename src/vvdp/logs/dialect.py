"""How a table in text is written: found from its first lines, by trying what may part its fields."""

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

from vvdp.base.errors import ConfigError, Fault, unusable
from vvdp.logs.clock import heading, is_written_unit
from vvdp.logs.content import INSTANTS, Column, unique

HEAD = 1 << 18
FIRST_LINES = 300
_EXAMINED = 20
_DELIMITERS = ("\t", ";", "|", ",", "")
"""In the order of trust; the empty one stands for blanks."""

NUMBER = re.compile(r"[-+]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eEdD][-+]?\d+)?|[-+]?inf(?:inity)?", re.IGNORECASE)
NO_NUMBER = re.compile(
    r"[-+]?nan(?:\(.*\))?|#?n/?a|null|none|-?1[.,]#(?:qnan|ind|snan)0*|-{2,}|over(?:load|flow|range)?|err(?:or)?|invalid",
    re.IGNORECASE,
)
OFFSET = r"(?:Z|[-+]\d\d:?\d\d)"
_INSTANT = re.compile(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d(?::\d\d(?:[.,]\d{1,9})?)?" + f"{OFFSET}?")
_COMMENT = re.compile(r"(?:^\ufeff?| )#")


@dataclass(frozen=True)
class Dialect:
    """How a table is written, and where its rows begin."""

    delimiter: str
    columns: tuple[Column, ...]
    begin: int  # byte of the first row
    line: int  # number of its line
    row_length: float  # bytes
    remarks: tuple[str, ...]


class _Line(NamedTuple):
    """A line that is not empty: its number, the byte it begins at, its length with its end, its fields and their kinds.

    A kind is `n`umber, `i`nstant, `e`mpty, or `t`ext.
    """

    number: int
    begin: int
    length: int
    fields: list[str]
    kinds: str


def find_dialect(path: Path, head: bytes, whole: bool) -> Dialect:
    """How the table is written that begins with `head`. Raises ConfigError where it is none."""
    if b"\n" not in head and b"\r" in head:
        raise unusable(path, "has lines that end in CR alone; expected LF or CR LF")
    raw = head.split(b"\n")
    raw = (raw if whole else raw[:-1])[:FIRST_LINES]
    if not raw:
        raise unusable(path, f"has a line of more than {HEAD} bytes; expected a table")
    if forced := re.fullmatch(rb"(?:\xef\xbb\xbf)?sep=(.)\r?", raw[0]):
        raw[0] = b" " * len(raw[0])
        if dialect := _try_dialect(path, raw, forced[1].decode("latin-1")):
            return dialect
    return _best_dialect(path, raw) or _single_column(path, raw)


def _best_dialect(path: Path, raw: Sequence[bytes]) -> Dialect | None:
    """The dialect with several columns that has the fewest of text. Raises ConfigError where all have odd rows."""
    fitting: list[Dialect] = []
    faults: list[ConfigError] = []
    for delimiter in _DELIMITERS:
        try:
            dialect = _try_dialect(path, raw, delimiter)
        except ConfigError as problem:
            faults.append(problem)
        else:
            fitting += [dialect] if dialect is not None and len(dialect.columns) > 1 else []
    if faults and not fitting:
        raise faults[0]
    return min(fitting, key=_text_columns, default=None)


def _single_column(path: Path, raw: Sequence[bytes]) -> Dialect:
    single = _try_dialect(path, raw, ";")
    if single is None:
        raise unusable(path, "holds no row of numbers; expected a table with one column a channel")
    if b"," in raw[single.line - 1]:
        return replace(single, remarks=(*single.remarks, "read as one column with decimal commas"))
    return single


def _text_columns(dialect: Dialect) -> int:
    return sum(column.fault == "holds text" for column in dialect.columns)


def _try_dialect(path: Path, raw: Sequence[bytes], delimiter: str) -> Dialect | None:
    """The dialect with this delimiter; None where there are no rows. Raises ConfigError where a row is odd."""
    lines = _lines(raw, delimiter)
    first = next((d for d in range(len(lines)) if _is_row(lines, d)), None)
    if first is None:
        return None
    rows = lines[first:]
    above = len(lines[first - 1].kinds) if first else 0
    if above != len(rows[0].kinds) and 1 in (above, len(rows[0].kinds)):
        return None  # heading and rows are not parted by this: `edge [s]` over times, `p` over decimal commas
    headings, remarks, end = _headings(path, lines, first)
    if end:
        remarks.append(f"lines {lines[0].number} to {end} are not part of the table; they are left out")
    names = unique([name or f"column {k}" for k, (name, _) in enumerate(headings, 1)])
    columns = tuple(
        Column(name, unit, _column_fault(rows[:_EXAMINED], k, written))
        for k, (name, (written, unit)) in enumerate(zip(names, headings, strict=True))
    )
    return Dialect(
        delimiter=delimiter,
        columns=columns,
        begin=rows[0].begin,
        line=rows[0].number,
        row_length=sum(row.length for row in rows) / len(rows),
        remarks=tuple(remarks),
    )


def _lines(raw: Sequence[bytes], delimiter: str) -> list[_Line]:
    lines, place = [], 0
    for number, line in enumerate(raw, 1):
        try:
            text = line.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = line.decode("latin-1")
        if fields := fields_of_line(text, delimiter):
            kinds = "".join(_kind(field, delimiter != ",") for field in fields)
            lines.append(_Line(number, place, len(line) + 1, fields, kinds))
        place += len(line) + 1
    return lines


def fields_of_line(line: str, delimiter: str) -> list[str]:
    """The fields of a line, without comment; none where nothing stands in it."""
    if "#" in line and (comment := _COMMENT.search(line)) and '"' not in line[: comment.start()]:
        line = line[: comment.start()]
    line = line.strip("\r\n\ufeff")
    if not line.strip(" " if delimiter == "\t" else None):
        return []
    if not delimiter:
        return line.split()
    if '"' in line:
        try:
            return [field.strip() for field in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))]
        except csv.Error:  # a field that is too long, or a NUL
            return [line]
    return [field.strip() for field in line.split(delimiter)]


def _kind(field: str, comma: bool) -> str:
    if not field or NO_NUMBER.fullmatch(field):
        return "e"
    if NUMBER.fullmatch(field) and (comma or "," not in field):
        return "n"
    return "i" if _INSTANT.fullmatch(field) else "t"


def _is_row(lines: Sequence[_Line], d: int) -> bool:
    """Whether line `d` holds a number and the line after it, if any, the same kinds of things."""
    kinds = lines[d].kinds
    after = lines[d + 1].kinds if d + 1 < len(lines) else kinds
    alike = len(kinds) == len(after) and all(a == b or "e" in (a, b) for a, b in zip(kinds, after, strict=True))
    return "n" in kinds and alike


def _headings(path: Path, lines: Sequence[_Line], first: int) -> tuple[list[tuple[str, str]], list[str], int]:
    """Name and unit of each column, notes, and the last line before the table."""
    width = len(lines[first].kinds)
    if first == 0:
        return [(f"column {k + 1}", "") for k in range(width)], ["the columns have no names"], 0
    above = lines[first - 1]
    problem = ""
    if "n" in above.kinds:
        problem = f"{', '.join(above.fields)!r} is neither a heading nor a row like those after it"
    elif len(above.fields) != width:
        problem = f"{len(above.fields)} names; expected {width}, as many as the rows have fields"
    if problem:
        raise ConfigError([Fault(str(path), above.number, "", problem)])
    over = lines[first - 2] if first >= 2 else above
    has_units = over is not above and len(over.fields) == width and "n" not in over.kinds and any(over.fields)
    if not (has_units and any(above.fields) and all(map(is_written_unit, above.fields))):
        return [heading(name) for name in above.fields], [], lines[first - 2].number if first >= 2 else 0
    headings = []
    for below, (name, unit) in zip(above.fields, map(heading, over.fields), strict=True):
        written = below.strip("[]()").strip()
        if unit and written not in ("", unit):
            raise ConfigError([Fault(str(path), over.number, name, f"has the units {unit!r} and, below, {written!r}")])
        headings.append((name, written or unit))
    return headings, [], lines[first - 3].number if first >= 3 else 0


def _column_fault(rows: Sequence[_Line], k: int, name: str) -> str:
    """Why a column is no channel of numbers, by the first thing in it that states this; empty where it is."""
    faults = {"n": "", "i": INSTANTS, "t": "holds text"}
    found = (faults[row.kinds[k]] for row in rows if len(row.kinds) > k and row.kinds[k] in faults)
    return next(found, "" if name else "is empty")
