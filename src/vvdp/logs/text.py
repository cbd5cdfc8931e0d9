"""Tables in text: CSV, TSV, semicolons, blanks; decimal point or comma; units in the headings or in a line below.

How a file is written is found from its first lines. The bulk is then read by pandas in blocks of whole lines. A block
that is not plain (quotes, comments, a wrong number of fields, something that is no number) is read again line by line,
which is slow but either understands it or says what is wrong in which line.
"""

import csv
import dataclasses
import io
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ConfigError, Fault, unusable
from vvdp.logs.channel import Log, unique
from vvdp.logs.clock import ClockChoice, heading, is_written_unit, seconds_between
from vvdp.logs.table import Column, TableLog

HEAD = 1 << 18
LONGEST_LINE = 1 << 22
_EXAMINED = 20
FIRST_LINES = 300
_DELIMITERS = ("\t", ";", "|", ",", "")
"""In the order of trust; the empty one stands for blanks."""

_NUMBER = re.compile(r"[-+]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eEdD][-+]?\d+)?|[-+]?inf(?:inity)?", re.IGNORECASE)
_NO_NUMBER = re.compile(
    r"[-+]?nan(?:\(.*\))?|#?n/?a|null|none|-?1[.,]#(?:qnan|ind|snan)0*|-{2,}|over(?:load|flow|range)?|err(?:or)?|invalid",
    re.IGNORECASE,
)
_NO_NUMBERS = ("", "nan", "NaN", "NAN", "n/a", "N/A", "NA", "#N/A", "null", "NULL", "--", "---", "over", "OVER")
"""Those of them that are common, which pandas is told of."""
_COMMENT = re.compile(r"(?:^\ufeff?| )#")
_INSTANT = re.compile(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d(?::\d\d(?:[.,]\d{1,9})?)?(Z|[-+]\d\d:?\d\d)?")


@dataclass(frozen=True)
class Dialect:
    """How a table is written, and where its rows begin."""

    delimiter: str
    columns: tuple[Column, ...]
    begin: int  # byte of the first row
    line: int  # number of its line
    row_length: float  # bytes
    remarks: tuple[str, ...]


def text_log(path: Path, choice: ClockChoice) -> Log:
    """The log in a text file."""
    with path.open("rb") as file:
        head = file.read(HEAD)
        whole = not file.read(1)
    return TextLog(path, _dialect(path, head, whole), choice)


class TextLog(TableLog):
    """A table in text, one block of lines at a time."""

    def __init__(self, path: Path, dialect: Dialect, choice: ClockChoice) -> None:
        super().__init__(path, dialect.columns, choice, None)
        self._dialect = dialect
        self.remarks += dialect.remarks

    def _rows(self, columns: Sequence[int], samples: int) -> Iterator[tuple[Mapping[int, Array], float]]:
        size = self.path.stat().st_size
        table = _Table(self.path, self._dialect, columns)
        with self.path.open("rb") as file:
            file.seek(self._dialect.begin)
            for block, complete in _blocks(self.path, file, max(4096, int(samples * self._dialect.row_length))):
                arrays = table.parse_block(block, complete)
                yield arrays, file.tell() / size
        for remark in table.remarks:
            self.remark(remark)


def _blocks(path: Path, file: Any, length: int) -> Iterator[tuple[bytes, bool]]:
    """Blocks of whole lines, and whether the last line of each is complete."""
    rest = b""
    while piece := file.read(length):
        cut = piece.rfind(b"\n") + 1
        if cut:
            yield rest + piece[:cut], True
            rest = piece[cut:]
        else:
            rest += piece
            if len(rest) > LONGEST_LINE:
                raise unusable(path, f"has a line of more than {LONGEST_LINE} bytes; expected a table")
    if rest.strip():
        yield rest, False


class _Table:
    """The parser of one reading; it knows the line it has reached and the decimal sign once one was seen."""

    def __init__(self, path: Path, dialect: Dialect, columns: Sequence[int]) -> None:
        self.remarks: list[str] = []
        self._path, self._dialect, self._columns = path, dialect, columns
        self._line = dialect.line
        self._decimal = "." if dialect.delimiter == "," else ""
        self._origins: dict[int, Any] = {}

    def parse_block(self, block: bytes, complete: bool) -> dict[int, Array]:
        """The columns of a block of lines."""
        found = self._plain(block) if complete else None
        if found is None:
            found = self._careful(block, complete)
        self._line += block.count(b"\n")
        return found

    def _plain(self, block: bytes) -> dict[int, Array] | None:
        """The columns by pandas; None where the block is not plain."""
        delimiter = self._dialect.delimiter.encode()
        if b'"' in block or b"#" in block:
            return None
        numbers = [k for k in self._columns if self._dialect.columns[k].holds == "number"]
        found: dict[int, Array] = {}
        for k in self._columns:
            if k not in numbers:
                instants = _column_of_instants(block, delimiter, k)
                if instants is None:
                    return None
                found[k] = self._elapsed_seconds(k, instants)
        decimal = self._decimal_sign(block)
        table = None if decimal is None else _numbers(block, delimiter, decimal, len(self._dialect.columns), numbers)
        return None if table is None else found | table

    def _decimal_sign(self, block: bytes) -> str | None:
        """The decimal sign of a block; None where points and commas are mixed."""
        if self._dialect.delimiter == ",":
            return "."
        comma, point = b"," in block, b"." in block
        if comma and point:
            return None
        if comma or point:
            sign = "," if comma else "."
            if self._decimal not in ("", sign):
                return None
            self._decimal = sign
        return "," if comma else "."

    def _careful(self, block: bytes, complete: bool) -> dict[int, Array]:
        texts: dict[int, list[str]] = {k: [] for k in self._columns if self._dialect.columns[k].holds != "number"}
        values: dict[int, list[float]] = {k: [] for k in self._columns if k not in texts}
        lines = block.decode("utf-8", "replace").split("\n")
        width = len(self._dialect.columns)
        for number, line in enumerate(lines, self._line):
            row = _fields(line, self._dialect.delimiter)
            if not row:
                continue
            if len(row) != width:
                if not complete and number == self._line + len(lines) - 1 and len(row) < width:
                    self.remarks.append(f"line {number}, the last one, breaks off; it is left out")
                    break
                raise self._fault(number, "", f"{len(row)} fields; expected {width}")
            for k in values:
                values[k].append(self._value(row[k], number, k))
            for k in texts:
                if _instants([row[k]]) is None:
                    raise self._fault(number, self._dialect.columns[k].name, f"{row[k]!r} is not a date-time")
                texts[k].append(row[k])
        found = {k: np.array(column, float) for k, column in values.items()}
        for k, column in texts.items():
            instants = _instants(column)
            assert instants is not None
            found[k] = self._elapsed_seconds(k, instants)
        return {k: found[k] for k in self._columns}

    def _value(self, text: str, line: int, k: int) -> float:
        if not text or _NO_NUMBER.fullmatch(text):
            return np.nan
        name = self._dialect.columns[k].name
        if not _NUMBER.fullmatch(text):
            raise self._fault(line, name, f"{text!r} is not a number")
        for sign in ",.":
            if sign in text:
                if self._decimal not in ("", sign):
                    raise self._fault(
                        line, name, f"{text!r} has the decimal sign {sign!r}; expected {self._decimal!r} as before"
                    )
                self._decimal = sign
        return float(text.replace(",", ".").replace("d", "e").replace("D", "e"))

    def _elapsed_seconds(self, k: int, instants: Any) -> Array:
        if instants.size:
            self._origins.setdefault(k, instants[0])
        return seconds_between(instants, self._origins.get(k, np.datetime64(0, "ns")))

    def _fault(self, line: int, column: str, message: str) -> ConfigError:
        return ConfigError([Fault(str(self._path), line, column, message)])


def _fields(line: str, delimiter: str) -> list[str]:
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


def _instants(texts: Sequence[str]) -> Any:
    """Date-times after ISO 8601 as NumPy's, those with an offset in UTC; None where one is something else."""
    matches = [_INSTANT.fullmatch(text.strip()) for text in texts]
    offsets = {match[1] if match else "?" for match in matches}
    if "?" in offsets or (None in offsets and len(offsets) > 1):
        return None
    try:
        local = np.array(
            [m[0][: len(m[0]) - len(m[1] or "")].replace(",", ".").replace(" ", "T") for m in matches if m],
            "datetime64[ns]",
        )
    except ValueError:
        return None
    if offsets <= {None, "Z"}:
        return local
    return local - np.array([_offset(match[1]) for match in matches if match], "timedelta64[m]")


def _numbers(
    block: bytes, delimiter: bytes, decimal: str, width: int, columns: Sequence[int]
) -> dict[int, Array] | None:
    """The numbers in some columns of lines that have `width` fields each, to the last bit as `float` reads them; None
    where that is not so, or where a field is no number."""
    import pandas

    if b"\0" in block or not _is_regular(block, delimiter, width):
        return None
    last = [] if delimiter else [width - 1]  # between blanks, a line that is too short shows by what it lacks
    try:
        table = pandas.read_csv(
            io.BytesIO(block), sep=delimiter.decode("latin-1") or r"\s+", decimal=decimal, header=None,
            names=range(width), index_col=False, usecols=sorted({*columns, *last}), dtype=float, skipinitialspace=True,
            keep_default_na=False, na_values=_NO_NUMBERS, quoting=csv.QUOTE_NONE, encoding_errors="replace",
            low_memory=False,
        )  # fmt: skip
    except ValueError:
        return None
    found = {k: table[k].to_numpy() for k in {*columns, *last}}
    if len(table) != block.count(b"\n") or (last and np.isnan(found[width - 1]).any()):
        return None
    return {k: found[k] for k in columns}


def _is_regular(block: bytes, delimiter: bytes, width: int) -> bool:
    """Whether each line has `width` fields; between blanks, whether that is so on average."""
    if not delimiter:
        return len(block.split()) == width * block.count(b"\n")
    others = bytes(set(range(256)) - {delimiter[0], ord("\n")})
    return block.translate(None, others) == (delimiter * (width - 1) + b"\n") * block.count(b"\n")


def _column_of_instants(block: bytes, delimiter: bytes, k: int) -> Any:
    """Field `k` of all lines as date-times; None where one is something else."""
    rows = [line.split(delimiter or None, k + 1) for line in block.splitlines()]
    if any(len(row) <= k for row in rows):
        return None
    fields = [row[k] for row in rows]
    found = _written_alike(np.array(fields))
    return _instants([field.decode("latin-1") for field in fields]) if found is None else found


def _written_alike(texts: Any) -> Any:
    """Date-times of one length, `2024-01-31T12:00:00.000`, all at once; None where they are written otherwise."""
    letters = texts.view(np.uint8).reshape(texts.size, -1)
    if (letters[:, -1] == ord("Z")).all():
        letters = letters[:, :-1]
    length = letters.shape[1]
    marks = {4: b"-", 7: b"-", 10: b"T ", 13: b":", 16: b":", 19: b"."}
    if not 19 <= length <= 29 or length == 20:
        return None
    if not all(np.isin(letters[:, at], list(allowed)).all() for at, allowed in marks.items() if at < length):
        return None
    digits = letters[:, [at for at in range(length) if at not in marks]] - np.uint8(ord("0"))
    if (digits > 9).any():
        return None
    hour, minute, second = (digits[:, at] * 10 + digits[:, at + 1] for at in (8, 10, 12))
    if (hour > 23).any() or (minute > 59).any() or (second > 59).any():
        return None
    try:
        dates, which = np.unique(texts.astype("S10"), return_inverse=True)
        days = dates.astype("U10").astype("datetime64[D]").astype("datetime64[ns]")[which]
    except ValueError:
        return None
    ns = (hour.astype(np.int64) * 60 + minute) * 60 + second
    for at in range(9):
        ns = ns * 10 + (digits[:, 14 + at] if 14 + at < digits.shape[1] else 0)
    return days + ns.astype("timedelta64[ns]")


def _offset(text: str) -> int:
    """Minutes that a clock is ahead of UTC."""
    if text == "Z":
        return 0
    digits = text[1:].replace(":", "")
    return (-1 if text[0] == "-" else 1) * (60 * int(digits[:2]) + int(digits[2:]))


@dataclass(frozen=True)
class _Line:
    """A line that is not empty: its number, the byte it begins at, and its fields."""

    number: int
    begin: int
    fields: list[str]


def _dialect(path: Path, head: bytes, whole: bool) -> Dialect:
    """How the table is written that begins with `head`. Raises ConfigError where it is none."""
    if b"\n" not in head and b"\r" in head:
        raise unusable(path, "has lines that end in CR alone; expected LF or CR LF")
    raw = head.split(b"\n")
    raw = (raw if whole else raw[:-1])[:FIRST_LINES]
    if not raw:
        raise unusable(path, f"has a line of more than {HEAD} bytes; expected a table")
    forced = re.fullmatch(rb"(?:\xef\xbb\xbf)?sep=(.)\r?", raw[0])
    delimiters: Sequence[str] = (forced[1].decode("latin-1"),) if forced else _DELIMITERS
    texts = [_decode(line) for line in raw]
    if forced:
        texts[0] = ""
    fitting: list[tuple[int, int, Dialect]] = []
    faults: list[ConfigError] = []
    for order, delimiter in enumerate(delimiters):
        try:
            dialect = _try_dialect(path, raw, texts, delimiter)
        except ConfigError as problem:
            faults.append(problem)
            continue
        if dialect is not None and (len(dialect.columns) > 1 or forced):
            fitting.append((sum(column.holds == "text" for column in dialect.columns), order, dialect))
    if fitting:
        return min(fitting, key=lambda found: found[:2])[2]
    if faults:
        raise faults[0]
    single = _try_dialect(path, raw, texts, ";")
    if single is None:
        raise unusable(path, "holds no row of numbers; expected a table with one column a channel")
    if b"," in raw[single.line - 1]:
        return dataclasses.replace(single, remarks=(*single.remarks, "read as one column with decimal commas"))
    return single


def _decode(line: bytes) -> str:
    try:
        return line.decode("utf-8-sig")
    except UnicodeDecodeError:
        return line.decode("latin-1")


def _try_dialect(path: Path, raw: Sequence[bytes], texts: Sequence[str], delimiter: str) -> Dialect | None:
    """The dialect with this delimiter; None where there are no rows. Raises ConfigError where a row is odd."""
    lines, place = [], 0
    for number, (line, text) in enumerate(zip(raw, texts, strict=True), 1):
        if fields := _fields(text, delimiter):
            lines.append(_Line(number, place, fields))
        place += len(line) + 1
    comma = delimiter != ","
    kinds = [[_kind(field, comma) for field in line.fields] for line in lines]
    first = next((d for d in range(len(lines)) if _is_row(kinds, d)), None)
    if first is None:
        return None
    if first and 1 in (len(kinds[first]), len(kinds[first - 1])) and len(kinds[first]) != len(kinds[first - 1]):
        return None  # heading and rows are not parted by this: `edge [s]` over times, `p` over decimal commas
    names, units, remarks, above = _headings(path, lines, kinds, first)
    held = _column_contents(kinds[first : first + _EXAMINED], names)
    if above:
        remarks.append(f"lines {lines[0].number} to {above} are not part of the table; they are left out")
    named = unique([name or f"column {k + 1}" for k, name in enumerate(names)])
    columns = tuple(Column(n, u, h) for n, u, h in zip(named, units, held, strict=True))
    rows = lines[first:]
    length = (sum(len(raw[line.number - 1]) + 1 for line in rows)) / len(rows)
    return Dialect(
        delimiter=delimiter,
        columns=columns,
        begin=lines[first].begin,
        line=lines[first].number,
        row_length=length,
        remarks=tuple(remarks),
    )


def _kind(field: str, comma: bool) -> str:
    """What a field is: `n`umber, `i`nstant, `e`mpty, or `t`ext."""
    if not field or _NO_NUMBER.fullmatch(field):
        return "e"
    if _NUMBER.fullmatch(field) and (comma or "," not in field):
        return "n"
    return "i" if _INSTANT.fullmatch(field) else "t"


def _is_row(kinds: Sequence[Sequence[str]], d: int) -> bool:
    """Whether line `d` holds a number and the line after it, if any, the same kinds of things."""
    if "n" not in kinds[d]:
        return False
    if d + 1 == len(kinds):
        return True
    return len(kinds[d]) == len(kinds[d + 1]) and all(
        a == b or "e" in (a, b) for a, b in zip(kinds[d], kinds[d + 1], strict=True)
    )


def _headings(
    path: Path, lines: Sequence[_Line], kinds: Sequence[Sequence[str]], first: int
) -> tuple[list[str], list[str], list[str], int]:
    """Names, units, remarks, and the last line before the table."""
    width = len(kinds[first])
    if first == 0:
        return [f"column {k + 1}" for k in range(width)], [""] * width, ["the columns have no names"], 0
    above = lines[first - 1]
    if "n" in kinds[first - 1]:
        problem = f"{', '.join(above.fields)!r} is neither a heading nor a row like those after it"
        raise ConfigError([Fault(str(path), above.number, "", problem)])
    if len(above.fields) != width:
        problem = f"{len(above.fields)} names; expected {width}, as many as the rows have fields"
        raise ConfigError([Fault(str(path), above.number, "", problem)])
    top = first - 1
    if (
        first >= 2
        and _is_units(lines[first - 1].fields)
        and _is_names(lines[first - 2].fields, kinds[first - 2], width)
    ):
        top = first - 2
    parted = [heading(name) for name in lines[top].fields]
    names = [name for name, _ in parted]
    units = [unit for _, unit in parted]
    if top == first - 2:
        units = [field.strip("[]()").strip() or unit for field, unit in zip(above.fields, units, strict=True)]
    return names, units, [], lines[top - 1].number if top else 0


def _is_units(fields: Sequence[str]) -> bool:
    return any(fields) and all(is_written_unit(field) for field in fields)


def _is_names(fields: Sequence[str], kinds: Sequence[str], width: int) -> bool:
    return len(fields) == width and "n" not in kinds and any(fields)


def _column_contents(rows: Sequence[Sequence[str]], names: Sequence[str]) -> list[str]:
    """What each column holds, by the first thing in it that says so."""
    words = {"n": "number", "i": "instant", "t": "text"}
    empty = ["number" if name else "nothing" for name in names]
    return [
        next((words[row[k]] for row in rows if len(row) > k and row[k] in words), empty[k]) for k in range(len(names))
    ]
