"""Tables in text: CSV, TSV, semicolons, blanks; decimal point or comma; units in the headings or in a line below.

How a file is written is found from its first lines (`dialect`). The bulk is then read by pandas in blocks of whole
lines. A block that is not plain (quotes, comments, a wrong number of fields, something that is no number) is read again
line by line, which is slow but either understands it or says what is wrong in which line.
"""

import csv
import io
from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ConfigError, Fault, unusable
from vvdp.logs.clock import seconds_between
from vvdp.logs.content import INSTANTS, Content, Leaf, Names
from vvdp.logs.dialect import HEAD, NO_NUMBER, NUMBER, OFFSET, Dialect, fields_of_line, find_dialect

LONGEST_LINE = 1 << 22
LARGEST_BLOCK = 1 << 26
"""Bytes that are read at once, however long a row is."""
_NO_NUMBERS = ("", "nan", "NaN", "NAN", "n/a", "N/A", "NA", "#N/A", "null", "NULL", "--", "---", "over", "OVER")
"""Those words for no number that are common, which pandas is given."""


def read_text(content: Content) -> None:
    """Finds what a text file holds."""
    with content.path.open("rb") as file:
        head = file.read(HEAD)
        dialect = find_dialect(content.path, head, whole=not file.read(1))
    content.remarks += dialect.remarks
    content.add_table(dialect.columns, None, partial(_rows, content, dialect))


def _rows(
    content: Content, dialect: Dialect, leaves: Sequence[Leaf], samples: int
) -> Iterator[tuple[Mapping[Names, Array], float]]:
    size = content.path.stat().st_size
    columns = {content.columns.index(leaf.path): leaf.path for leaf in leaves}
    table = _Table(content, dialect, sorted(columns))
    with content.path.open("rb") as file:
        file.seek(dialect.begin)
        for block in _blocks(content.path, file, min(max(4096, int(samples * dialect.row_length)), LARGEST_BLOCK)):
            if block:
                arrays = table.parse_block(block)
                yield {columns[k]: values for k, values in arrays.items()}, file.tell() / size


def _blocks(path: Path, file: Any, length: int) -> Iterator[bytes]:
    """Blocks of whole lines; a last line that lacks its end comes alone."""
    while block := file.read(length):
        rest = file.readline(LONGEST_LINE)
        if len(rest) == LONGEST_LINE:
            raise unusable(path, f"has a line of more than {LONGEST_LINE} bytes; expected a table")
        block += rest
        cut = block.rfind(b"\n") + 1
        yield block[:cut]
        yield block[cut:]


class _Table:
    """The parser of one reading; it knows the line it has reached and the decimal sign once one was seen."""

    def __init__(self, content: Content, dialect: Dialect, columns: Sequence[int]) -> None:
        self._content, self._dialect, self._columns = content, dialect, columns
        self._instants = {k for k in columns if dialect.columns[k].fault == INSTANTS}
        self._line = dialect.line
        self._decimal = "." if dialect.delimiter == "," else ""
        self._origins: dict[int, Any] = {}

    def parse_block(self, block: bytes) -> dict[int, Array]:
        """The columns of a block of lines."""
        found = self._plain(block)
        if found is None:
            found = self._careful(block)
        self._line += block.count(b"\n")
        return found

    def _plain(self, block: bytes) -> dict[int, Array] | None:
        """The columns by pandas; None where the block is not plain."""
        decimal = self._decimal_sign(block)
        if decimal is None or b'"' in block or b"#" in block:
            return None
        delimiter, width = self._dialect.delimiter.encode(), len(self._dialect.columns)
        table = _numbers(block, delimiter, decimal, width, self._columns, self._instants)
        if table is None:
            return None
        instants = {k: _instants(table[k]) for k in self._instants}
        if any(found is None for found in instants.values()):
            return None
        return table | {k: self._elapsed_seconds(k, found) for k, found in instants.items()}

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

    def _careful(self, block: bytes) -> dict[int, Array]:
        """The columns line by line."""
        rows = self._split_lines(block)
        found: dict[int, Array] = {}
        for k in self._columns:
            fields = {number: row[k] for number, row in rows.items()}
            if k not in self._instants:
                found[k] = np.array([self._value(text, number, k) for number, text in fields.items()], float)
            elif (instants := _instants(list(fields.values()))) is not None:
                found[k] = self._elapsed_seconds(k, instants)
            else:
                number, text = next(item for item in fields.items() if _instants([item[1]]) is None)
                raise self._fault(number, self._dialect.columns[k].name, f"{text!r} is not a date-time")
        return found

    def _split_lines(self, block: bytes) -> dict[int, list[str]]:
        """The fields of each line that is not empty, by its number."""
        rows = {}
        lines, width = block.decode("utf-8", "replace").split("\n"), len(self._dialect.columns)
        for number, line in enumerate(lines, self._line):
            row = fields_of_line(line, self._dialect.delimiter)
            if len(row) == width:
                rows[number] = row
            elif row and len(row) < width and number == self._line + len(lines) - 1:
                self._content.remark(f"line {number}, the last one, breaks off; it is left out")
            elif row:
                raise self._fault(number, "", f"{len(row)} fields; expected {width}")
        return rows

    def _value(self, text: str, line: int, k: int) -> float:
        if not text or NO_NUMBER.fullmatch(text):
            return np.nan
        name = self._dialect.columns[k].name
        if not NUMBER.fullmatch(text):
            raise self._fault(line, name, f"{text!r} is not a number")
        sign = next((sign for sign in ",." if sign in text), "")
        if sign and self._decimal not in ("", sign):
            problem = f"{text!r} has the decimal sign {sign!r}; expected {self._decimal!r} as before"
            raise self._fault(line, name, problem)
        self._decimal = sign or self._decimal
        return float(text.replace(",", ".").replace("d", "e").replace("D", "e"))

    def _elapsed_seconds(self, k: int, instants: Any) -> Array:
        if instants.size:
            self._origins.setdefault(k, instants[0])
        return seconds_between(instants, self._origins.get(k, np.datetime64(0, "ns")))

    def _fault(self, line: int, column: str, message: str) -> ConfigError:
        return ConfigError([Fault(str(self._content.path), line, column, message)])


def _instants(texts: Sequence[str]) -> Any:
    """Date-times after ISO 8601 as NumPy's, those with an offset in UTC; None where one is something else."""
    import pandas

    plain = pandas.Series(texts, dtype=str).str.replace(",", ".")
    has_offset = plain.str.contains(f"{OFFSET}$")
    if has_offset.any() and not has_offset.all():
        return None
    try:
        found = pandas.to_datetime(plain, format="ISO8601", utc=bool(has_offset.all()))
    except ValueError:
        return None
    return None if found.isna().any() else found.to_numpy("datetime64[ns]")


def _numbers(
    block: bytes, delimiter: bytes, decimal: str, width: int, columns: Sequence[int], texts: Collection[int] = ()
) -> dict[int, Any] | None:
    """The numbers in some columns of lines that have `width` fields each, to the last bit as `float` reads them; None
    where that is not so, or where a field is no number. Columns `texts` come as they are written."""
    import pandas

    if b"\0" in block or not _is_regular(block, delimiter, width):
        return None
    last = [] if delimiter else [width - 1]  # between blanks, a line that is too short shows by what it lacks
    wanted = {k: str if k in texts else float for k in (*columns, *last)}
    try:
        table = pandas.read_csv(
            io.BytesIO(block), sep=delimiter.decode("latin-1") or r"\s+", decimal=decimal, header=None,
            names=range(width), index_col=False, usecols=sorted(wanted), dtype=wanted, skipinitialspace=True,
            keep_default_na=False, na_values=_NO_NUMBERS, quoting=csv.QUOTE_NONE, encoding_errors="replace",
            low_memory=False, **_exact_floats(pandas.__version__),
        )  # fmt: skip
    except ValueError:
        return None
    if len(table) != block.count(b"\n") or (last and table[width - 1].isna().any()):
        return None
    return {k: table[k] if k in texts else table[k].to_numpy() for k in columns}


def _exact_floats(version: str) -> dict[str, Any]:
    """The option with which pandas 2 reads numbers to the last bit; later ones do so without."""
    return {"float_precision": "round_trip"} if version.startswith("2.") else {}


def _is_regular(block: bytes, delimiter: bytes, width: int) -> bool:
    """Whether each line has `width` fields; between blanks, whether that is so on average."""
    if not delimiter:
        return len(block.split()) == width * block.count(b"\n")
    others = bytes(set(range(256)) - {delimiter[0], ord("\n")})
    return block.translate(None, others) == (delimiter * (width - 1) + b"\n") * block.count(b"\n")
