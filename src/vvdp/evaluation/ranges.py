"""How far numbers move where a value lies elsewhere in its range: one value at a time, all others as they are."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import with_unit
from vvdp.base.errors import ConfigError, ParameterError
from vvdp.base.kinds import Kind
from vvdp.base.tables import Sourced, Table, copy_tables
from vvdp.systems.system import System

Quantities = Mapping[str, tuple[Kind, str]]
LEAST = 0.01
"""A number rests on a value whose range moves it by more than this share of itself."""


@dataclass(frozen=True)
class Ranges:
    """Numbers [SI] at both ends of each value that has a range, all others as they are; nan where there is none.

    Of shape (values, 2) each: at the lower end, at the upper end. `left_out` says of a value why it was not varied.
    """

    rows: tuple[Sourced, ...]
    nominal: Mapping[str, float]
    ends: Mapping[str, Array]
    left_out: Mapping[str, str]
    together: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    """Lowest and highest with all values at once, where that was asked for; see `spans_together`."""

    def span(self, key: str) -> tuple[float, float]:
        """The lowest and the highest that a number comes to, with the one of the system as it is."""
        values = np.append(self.ends[key], self.nominal[key])
        return float(np.nanmin(values)), float(np.nanmax(values))

    def moves(self, key: str) -> bool:
        """Whether a number rests on a value that has a range."""
        low, high = self.span(key)
        return high - low > LEAST * abs(self.nominal[key])

    def widths(self, key: str) -> Array:
        """How far each value moves a number, from the lowest to the highest."""
        with_nominal = np.column_stack([self.ends[key], np.full(len(self.rows), self.nominal[key])])
        widths: Array = np.nanmax(with_nominal, axis=1) - np.nanmin(with_nominal, axis=1)
        return widths

    @property
    def flat(self) -> dict[str, dict[str, Any]]:
        """As JSON has it, under the key of each number: `low`, `high`, `by` with both ends by setting, and where it is
        known `together` with the lowest and the highest of all values at once."""
        found: dict[str, dict[str, Any]] = {}
        for key in self.nominal:
            low, high = self.span(key)
            by = {row.setting: pair.tolist() for row, pair in zip(self.rows, self.ends[key], strict=True)}
            found[key] = {"low": low, "high": high, "by": by}
            if key in self.together:
                found[key]["together"] = list(self.together[key])
        return found


def read_ranges(
    system: System, nominal: Mapping[str, float | bool], flat: Mapping[str, Any], left_out: Mapping[str, str]
) -> Ranges:
    """The ranges that `Ranges.flat` has written for a run of `system`, whose numbers are `nominal`."""
    settings = list(dict.fromkeys(setting for each in flat.values() for setting in each["by"]))
    known = {row.setting: row for row in system.uncertainties}
    rows = tuple(known[setting] for setting in settings if setting in known)
    ends = {
        key: np.array([[np.nan if x is None else x for x in each["by"][row.setting]] for row in rows]).reshape(-1, 2)
        for key, each in flat.items()
    }
    return Ranges(rows=rows, nominal={key: float(nominal[key]) for key in flat}, ends=ends, left_out=left_out)


def at_ends(system: System) -> Iterator[tuple[System | None, str]]:
    """The system with each value of `uncertainties` at the lower end of its range, then at the upper one.

    None, and why, where an end contradicts other values.
    """
    for row in system.uncertainties:
        for place in (0, 1):
            try:
                yield at_end(system, row, place), ""
            except ConfigError as problem:
                yield None, problem.faults[0].message


def at_end(system: System, row: Sourced, place: int) -> System:
    """The system with one value at the lower end of its range (`place` 0) or the upper one (1).

    Raises ConfigError where that contradicts other values.
    """
    return with_ends(system, {row: place})


def with_ends(system: System, places: Mapping[Sourced, int]) -> System:
    """The system with several values at the lower (0) or the upper end (1) of their ranges, in one.

    Raises ConfigError where these contradict each other.
    """
    content = copy_tables(system.content)
    for row, place in places.items():
        inner: dict[str, Any] = content
        for name in row.table.split("."):
            inner = inner[name]
        inner[row.key] = {"value": inner[row.key]["range"][place], "status": row.status}
    return system.read_from(Table(system.name, content, {}))


def corners(ranges: Ranges, key: str) -> tuple[tuple[int | None, ...], tuple[int | None, ...]]:
    """For each value the end that makes a number lowest, and the one that makes it highest, by the ends alone; None
    where that is the value as it is."""
    whole = np.column_stack([ranges.ends[key], np.full(len(ranges.rows), ranges.nominal[key])])
    ends: tuple[int | None, ...] = (0, 1, None)
    least, most = np.nanargmin(whole, axis=1), np.nanargmax(whole, axis=1)
    return tuple(ends[place] for place in least), tuple(ends[place] for place in most)


def spans_together(
    system: System, ranges: Ranges, work: Callable[[System], Mapping[str, float | bool]]
) -> dict[str, tuple[float, float]]:
    """The lowest and highest of each number with all values at the ends that move it that way, `work` giving numbers.

    Where a number rises or falls with each value, whatever the others are, it lies nowhere outside. nan where these
    ends contradict each other.
    """
    known: dict[tuple[int | None, ...], Mapping[str, float | bool]] = {}
    found = {}
    for key in ranges.nominal:
        values = []
        for corner in corners(ranges, key):
            if corner not in known:
                places = {row: place for row, place in zip(ranges.rows, corner, strict=True) if place is not None}
                try:
                    known[corner] = work(with_ends(system, places))
                except (ConfigError, ParameterError):
                    known[corner] = {}
            values.append(float(known[corner].get(key, np.nan)))
        found[key] = (values[0], values[1])
    return found


def ranges_of(
    system: System,
    keys: Sequence[str],
    nominal: Mapping[str, float | bool],
    found: Sequence[Mapping[str, float | bool] | str],
) -> Ranges:
    """The ranges of the numbers `keys` from what was `found` for each of `at_ends`: its numbers, or why there are none.

    Numbers of which the system itself has none are left out.
    """
    rows = system.uncertainties
    known = [key for key in keys if key in nominal and np.isfinite(float(nominal[key]))]
    none: dict[str, float] = {}
    values = [none if isinstance(each, str) else each for each in found]
    left_out = {rows[place // 2].setting: each for place, each in enumerate(found) if isinstance(each, str)}
    return Ranges(
        rows=rows,
        nominal={key: float(nominal[key]) for key in known},
        ends={key: np.array([float(each.get(key, np.nan)) for each in values]).reshape(-1, 2) for key in known},
        left_out=left_out,
    )


def range_text(row: Sourced) -> str:
    """The range of a value in words."""
    assert row.range is not None
    low, high = (with_unit(end, row.kind) for end in row.range)
    return f"{'0' if row.range[0] == 0.0 else low} to {high}"
