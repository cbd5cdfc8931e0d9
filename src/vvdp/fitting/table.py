"""Tables of measured or computed values as people keep them: CSV with a unit in each heading."""

import csv
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import key_suffix
from vvdp.base.errors import ConfigError, Fault, ParameterError, unusable
from vvdp.base.kinds import FLOW, PRESSURE_DIFFERENCE, Kind
from vvdp.base.rules import POSITIVE
from vvdp.base.tables import closest_word
from vvdp.base.units import parse

_HEADING = re.compile(r"\s*(.*?)\s*(?:[\[(]\s*(.*?)\s*[\])])?\s*\Z")
MOST_FAULTS = 10
"""Bad cells that are reported; a wrong unit makes all of them bad."""


@dataclass(frozen=True)
class Quantity:
    """Definition of a column: its kind, whether it can be missing, and the words that stand for numbers, if any.

    Values are above 0, or of `words` alone. `also` are further headings, in capitals or not.
    """

    kind: Kind
    is_optional: bool = False
    words: Mapping[str, float] | None = None
    also: tuple[str, ...] = ()


FLOW_COLUMN = Quantity(FLOW, also=("q", "flow_rate", "volume_flow"))
DROP_COLUMN = Quantity(PRESSURE_DIFFERENCE, also=("dp", "δp", "delta_p", "pressure_difference"))


class _Place(NamedTuple):
    """Where a column stands, as it is headed, and the unit of its numbers."""

    number: int
    heading: str
    unit: str


def read_columns(path: Path, wanted: Mapping[str, Quantity]) -> dict[str, Array]:
    """The columns of a CSV file that are `wanted`, by name [SI]; an optional one that is missing is left out.

    A heading is the name with its unit in brackets, `flow [lpm]`, or as in the tables of vvdp, `flow_m3_s`; a symbol or
    synonym does as well (`Q [l/min]`). Fields are
    parted by commas, semicolons (numbers may then have a decimal comma) or tabs; lines that begin with # are left out.
    Other columns are left out, but for one whose heading is nearly that of a column that is missing. Raises ConfigError
    with the line and heading of every fault.
    """
    lines = list(_lines(path))
    if not lines:
        raise unusable(path, f"is empty; expected a heading line with {', '.join(wanted)}")
    places = _places(path, lines[0], wanted)
    rows = [(number, fields) for number, fields in lines[1:] if any(field.strip() for field in fields)]
    if not rows:
        raise unusable(path, "has a heading and no rows")
    width = len(lines[0][1])
    faults = [
        Fault(str(path), number, "", f"{len(fields)} cells; must be at most {width}, as there are headings")
        for number, fields in rows
        if any(field.strip() for field in fields[width:])
    ]
    found = {name: np.array([_cell(path, row, place, wanted[name], faults) for row in rows])
             for name, place in places.items()}  # fmt: skip
    if faults:
        faults.sort(key=lambda fault: fault.line)
        more = len(faults) - MOST_FAULTS
        told = [Fault(str(path), 0, "", f"and {more} more cells")] if more > 0 else []
        raise ConfigError(faults[:MOST_FAULTS] + told)
    return found


def _lines(path: Path) -> Iterator[tuple[int, list[str]]]:
    try:
        text = path.read_text("utf-8-sig")
    except OSError as problem:
        raise unusable(path, f"cannot be read ({problem.strerror})") from None
    except UnicodeDecodeError:
        raise unusable(path, "is not text; expected a table as CSV") from None
    numbered = [(number, line) for number, line in enumerate(text.splitlines(), 1) if line.strip()[:1] not in ("", "#")]
    delimiter = next((mark for mark in "\t;" if numbered and mark in numbered[0][1]), ",")
    for number, line in numbered:
        try:
            fields = next(csv.reader([line], delimiter=delimiter))
        except csv.Error as problem:  # a cell that is too long, or a NUL
            raise ConfigError([Fault(str(path), number, "", f"is not a line of a table: {problem}")]) from None
        yield number, [field.replace(",", ".") for field in fields] if delimiter == ";" else fields


def _places(path: Path, head: tuple[int, Sequence[str]], wanted: Mapping[str, Quantity]) -> dict[str, _Place]:
    """Where each wanted column stands. Raises ConfigError where one is missing or there twice."""
    line, headings = head
    read = [(place, *_split(heading)) for place, heading in enumerate(headings)]
    found, faults = {}, []
    for name, quantity in wanted.items():
        suffix = key_suffix(quantity.kind)
        names = (name, *quantity.also)
        mine = [_Place(k, headings[k].strip(), unit) for k, text, unit in read if text.casefold() in names]
        if suffix:
            mine += [_Place(k, headings[k].strip(), quantity.kind.unit) for k, text, _ in read if text == name + suffix]
        if len(mine) > 1:
            faults.append(Fault(str(path), line, name, f"stands there {len(mine)} times"))
        elif mine and quantity.words and mine[0].unit:
            faults.append(Fault(str(path), line, name, f"has the unit {mine[0].unit!r}, but holds words; leave it out"))
        elif mine:
            found[name] = mine[0]
        elif not quantity.is_optional:
            unit = quantity.kind.display_unit
            example = f"{name} [{unit}]" if unit else name
            there = ", ".join(repr(heading.strip()) for heading in headings)
            faults.append(Fault(str(path), line, name, f"no such column; write for example {example!r}, not {there}"))
    faults += [
        Fault(str(path), line, headings[k].strip(), f"unknown column; did you mean {meant!r}?")
        for k, text, _ in read
        if (meant := closest_word(text, wanted.keys() - found.keys())) and meant != text
    ]
    if faults:
        raise ConfigError(faults)
    return found


def _split(heading: str) -> tuple[str, str]:
    """Name and unit of a heading."""
    match = _HEADING.match(heading)
    name, unit = (match[1], match[2] or "") if match else (heading, "")
    return re.sub(r"[\s-]+", "_", name), "" if unit == "1" else unit


def _cell(path: Path, row: tuple[int, Sequence[str]], place: _Place, quantity: Quantity, faults: list[Fault]) -> float:
    """A number [SI]; what is wrong with it goes to `faults`, and gives nan."""
    line, fields = row
    text = fields[place.number].strip() if place.number < len(fields) else ""
    message = "the cell is empty"
    if quantity.words is not None:
        if text in quantity.words:
            return quantity.words[text]
        message = f"{text!r}; expected {' or '.join(quantity.words)}"
    elif text:
        try:
            value = parse(f"{text} {place.unit}".strip(), quantity.kind)
        except ParameterError as problem:
            message = str(problem)
        else:
            if value > 0.0:
                return value
            message = f"{text!r} {POSITIVE}"
    faults.append(Fault(str(path), line, place.heading, message))
    return np.nan
