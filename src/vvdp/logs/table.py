"""Logs that are tables: rows of columns on one clock, read from the first row on."""

from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import unusable
from vvdp.logs.budget import Budget
from vvdp.logs.channel import ChannelInfo, Log, Portion, checked_size, list_names, no_such
from vvdp.logs.clock import ClockChoice, is_time_name, no_clock, seconds


@dataclass(frozen=True)
class Column:
    """A column: its heading, and what it holds: `number`, `instant` (a date-time), `text` or `nothing`."""

    name: str
    unit: str
    holds: str


_WHY = {"text": "holds text", "instant": "holds date-times", "nothing": "is empty"}


class TableLog(Log):
    """A table of columns, one of which may be the clock of all others."""

    def __init__(
        self, path: Path, columns: Sequence[Column], choice: ClockChoice, rows: int | None, held: Any = None
    ) -> None:
        super().__init__(path, held)
        budget = Budget(path)
        budget.count(len(columns))
        budget.check_content(8.0 * (rows or 0))
        self._columns = tuple(columns)
        self._choice = choice
        self._count = rows
        self.unreadable = {c.name: _WHY[c.holds] for c in columns if c.holds != "number"}
        self._clock = self._chosen_clock()

    def channels(self) -> tuple[ChannelInfo, ...]:
        """See `Log`."""
        return tuple(ChannelInfo(c.name, c.unit, self._count, "") for c in self._columns if c.holds == "number")

    def portions(self, names: Sequence[str], samples: int) -> Iterator[Mapping[str, Portion]]:
        """See `Log`. Raises ConfigError where the table has no clock."""
        checked_size(samples)
        own = [column.name for column in self._columns]
        wanted = {name: own.index(self.channel(name).name) for name in names}
        clock = self._clock
        if clock is None and self._choice.rate is None:
            raise no_clock(self.path, "the file", list_names([info.name for info in self.channels()]))
        if clock is None:
            return self._at_rate(wanted, samples, self._choice.rate or 0.0)
        self._choice.refuse_rate(self.path, f"column {own[clock]!r}")
        column = self._columns[clock]
        if column.holds == "text":
            raise unusable(
                self.path, f"time column {column.name!r} holds text; expected numbers or date-times after ISO 8601"
            )
        unit = "s"
        if column.holds == "number":
            unit, remark = self._choice.unit_of(self.path, column.name, column.unit)
            if remark:
                self.remark(remark)
        return self._with_clock(wanted, samples, clock, unit)

    def _chosen_clock(self) -> int | None:
        """The column that is the clock: the one chosen, or named as a time, or the only one of date-times."""
        if self._choice.time is not None:
            for k, column in enumerate(self._columns):
                if column.name == self._choice.time:
                    return k
            raise no_such(self.path, "time column", self._choice.time, [column.name for column in self._columns])
        named = [k for k, column in enumerate(self._columns) if is_time_name(column.name)]
        instants = [k for k, column in enumerate(self._columns) if column.holds == "instant"]
        found = [k for k in named if self._columns[k].holds != "text"] or instants or named
        if len(found) > 1 and self._choice.rate is None:
            names = list_names([self._columns[k].name for k in found])
            self.remark(f"several columns may be the time ({names}); the first is taken")
        return found[0] if found else None

    def _at_rate(self, wanted: Mapping[str, int], samples: int, rate: float) -> Iterator[Mapping[str, Portion]]:
        row = 0
        for arrays in self._without_clock(sorted(set(wanted.values())), samples):
            count = next(iter(arrays.values())).size if arrays else 0
            times = np.arange(row, row + count) / rate
            row += count
            yield {name: Portion(times, arrays[k]) for name, k in wanted.items()}

    def _with_clock(
        self, wanted: Mapping[str, int], samples: int, clock: int, unit: str
    ) -> Iterator[Mapping[str, Portion]]:
        for arrays in self._without_clock(sorted({clock, *wanted.values()}), samples):
            times = seconds(arrays[clock], unit)
            yield {name: Portion(times, arrays[k]) for name, k in wanted.items()}

    def _without_clock(self, columns: Sequence[int], samples: int) -> Iterator[Mapping[int, Array]]:
        self.done = 0.0
        for arrays, done in self._rows(columns, samples):
            self.done = done
            yield arrays
        self.done = 1.0

    @abstractmethod
    def _rows(self, columns: Sequence[int], samples: int) -> Iterator[tuple[Mapping[int, Array], float]]:
        """The columns of given numbers in blocks of about `samples` rows, and the fraction read so far.

        A column of date-times comes as seconds from its first one.
        """
