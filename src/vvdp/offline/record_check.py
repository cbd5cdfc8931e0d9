"""Is the record sound? What is wrong with a channel, found while it streams by, and the pieces that are still good.

The rule by which a record is cut: a sample whose time is no number, or is that of the sample before, is left out; where
time goes backwards, or the next sample comes later than `GAP` usual intervals, a new piece begins. So within a piece
time rises and has no hole. The usual interval is the median of the portion at hand. Values are never changed, filled
in or left out: NaN stays in its place, for whoever reads the piece to see.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.logs.channel import Log, Portion

GAP = 1.5
"""A sampling interval above this multiple of the usual one is a gap."""
MOST = 20
"""Findings of one sort that are listed one by one; the rest are counted together."""
FEW_LEVELS = 16
"""A channel with no more different values than this is a digital one, and rests at its largest and smallest."""
CLIPPED_RUN = 3
CLIPPED_RATIO = 5.0
"""Saturated: the extreme value stands for at least so many samples in a row, and in all occurs so many times as often
as the value next to it. A sine seen through a coarse converter has 1 / (sqrt(2) - 1) = 2.4 at its crest."""

NAN = "value is not a number"
NO_TIME = "time is not a number"
GAP_FOUND = "gap in time"
BACKWARDS = "time goes backwards"
STANDS = "time stands still"
CONSTANT = "value never changes"
HIGH = "saturated at its largest value"
LOW = "saturated at its smallest value"
FURTHER = ", further ones together"


@dataclass(frozen=True)
class Finding:
    """Something wrong with a channel, from time `begin` to `end` [s]; `count` samples, the first in row `row`.

    Rows count from 0. Where a time is no number, `begin` and `end` are the time before it, if there was one. Of a gap
    they are the samples on either side, and `count` is the number of samples that are missing.
    """

    channel: str
    what: str
    begin: float
    end: float
    count: int
    row: int

    def __str__(self) -> str:
        when = "at the beginning" if np.isnan(self.begin) else self._when()
        number = f", {self.count} samples" if self.count > 1 else ""
        return f"{self.channel}: {self.what} {when} (row {self.row}{number})"

    def _when(self) -> str:
        if self.begin == self.end:
            return f"at {self.begin:.9g} s"
        return f"from {self.begin:.9g} s to {self.end:.9g} s"


class Piece(NamedTuple):
    """A portion, or part of one, within which time rises without a hole; pieces are numbered from 0."""

    number: int
    times: Array  # [s]
    values: Array


@dataclass
class _Run:
    """A run of odd samples that may go on in the next portion."""

    begin: float
    end: float
    count: int
    row: int


@dataclass
class _Extreme:
    """The largest value so far (of the values or of their negatives), how often, how long in a row; and the next."""

    value: float = -np.inf
    count: int = 0
    longest: int = 0
    current: int = 0
    next_value: float = -np.inf
    next_count: int = 0
    begin: float = np.nan
    end: float = np.nan
    row: int = 0


@dataclass
class Inspection:
    """One channel under inspection: give it the portions in order, take the good pieces, ask for the findings."""

    channel: str
    _listed: dict[str, list[Finding]] = field(default_factory=dict)
    _open: dict[str, _Run] = field(default_factory=dict)
    _rows: int = 0
    _piece: int = 0
    _last: float = np.nan  # latest time that is a number
    _usual: float = np.nan
    _first_time: float = np.nan
    _levels: set[float] = field(default_factory=set)
    _high: _Extreme = field(default_factory=_Extreme)
    _low: _Extreme = field(default_factory=_Extreme)

    def pieces(self, portion: Portion) -> list[Piece]:
        """The good pieces of the next portion; a piece may go on under its number in the portion after."""
        times, values = portion
        if not times.size:
            return []
        rows = np.arange(self._rows, self._rows + times.size)
        self._rows += times.size
        self._inspect_values(times, values, rows)
        known = np.isfinite(times)
        if not known.all():
            self._runs(NO_TIME, ~known, self._latest(times, known), rows)
            times, values, rows = times[known], values[known], rows[known]
            if not times.size:
                return []
        else:
            self._close(NO_TIME)
        if np.isnan(self._first_time):
            self._first_time = float(times[0])
        return self._cut(times, values, rows)

    def findings(self) -> tuple[Finding, ...]:
        """What was found so far; of the whole channel, once all portions have been given."""
        found = [finding for listed in self._listed.values() for finding in listed]
        found += [self._finding(what, run) for what, run in self._open.items()]
        found += self._extremes()
        return tuple(sorted(found, key=lambda finding: (finding.row, finding.what)))

    def _cut(self, times: Array, values: Array, rows: Any) -> list[Piece]:
        before = np.concatenate(([self._last], times[:-1]))
        intervals = times - before
        self._last = float(times[-1])
        rising = intervals[intervals > 0.0]
        if rising.size >= 3 or (rising.size and np.isnan(self._usual)):
            self._usual = float(np.median(rising))
        still, back, gap = intervals == 0.0, intervals < 0.0, intervals > GAP * self._usual
        self._runs(STANDS, still, times, rows)
        if not (still.any() or back.any() or gap.any()):
            return [Piece(self._piece, times, values)]
        for k in np.flatnonzero(back):
            self._list(
                Finding(
                    channel=self.channel,
                    what=BACKWARDS,
                    begin=float(before[k]),
                    end=float(times[k]),
                    count=1,
                    row=int(rows[k]),
                )
            )
        for k in np.flatnonzero(gap):
            missing = max(1, round(float(intervals[k]) / self._usual) - 1)
            self._list(
                Finding(
                    channel=self.channel,
                    what=GAP_FOUND,
                    begin=float(before[k]),
                    end=float(times[k]),
                    count=missing,
                    row=int(rows[k]),
                )
            )
        begins = np.flatnonzero(back | gap)
        found = []
        for begin, end in zip([0, *begins], [*begins, times.size], strict=True):
            if begin in begins:
                self._piece += 1
            kept = ~still[begin:end]
            if kept.any():
                found.append(Piece(self._piece, times[begin:end][kept], values[begin:end][kept]))
        return found

    def _latest(self, times: Array, known: Any) -> Array:
        """For each sample the latest time that is a number; NaN where there was none yet."""
        where = np.concatenate(([-1], np.flatnonzero(known)))
        latest = where[np.searchsorted(where, np.arange(times.size), side="right") - 1]
        return np.where(latest >= 0, times[latest], self._last)

    def _inspect_values(self, times: Array, values: Array, rows: Any) -> None:
        nan = np.isnan(values)
        self._runs(NAN, nan, times, rows)
        if nan.any():
            times, values, rows = times[~nan], values[~nan], rows[~nan]
            if not values.size:
                return
        if len(self._levels) <= FEW_LEVELS:
            self._levels.update(np.unique(values[:: max(1, values.size // 4096)])[: FEW_LEVELS + 1].tolist())
        _follow(self._high, times, values, rows)
        _follow(self._low, times, -values, rows)

    def _extremes(self) -> Iterator[Finding]:
        high, low = self._high, self._low
        if high.count and high.value == -low.value:
            if high.count > 1:
                yield Finding(
                    channel=self.channel, what=CONSTANT, begin=high.begin, end=high.end, count=high.count, row=high.row
                )
            return
        if len(self._levels) <= FEW_LEVELS:
            return
        for what, side in ((HIGH, high), (LOW, low)):
            if side.longest >= CLIPPED_RUN and side.count >= CLIPPED_RATIO * max(side.next_count, 1):
                yield Finding(
                    channel=self.channel, what=what, begin=side.begin, end=side.end, count=side.count, row=side.row
                )

    def _runs(self, what: str, odd: Any, times: Array, rows: Any) -> None:
        """Runs of odd samples, joined with the one left open by the portion before."""
        if not odd.any():
            self._close(what)
            return
        edges = np.flatnonzero(np.diff(np.concatenate(([False], odd, [False])).astype(np.int8)))
        begins, ends = edges[::2], edges[1::2]
        for begin, end in zip(begins[: MOST + 2], ends[: MOST + 2], strict=True):
            self._run(what, times, rows, int(begin), int(end))
        if begins.size > MOST + 2:
            skipped = int((ends[MOST + 2 :] - begins[MOST + 2 :]).sum())
            self._close(what)
            row = int(rows[begins[MOST + 2]])
            self._list(
                Finding(
                    channel=self.channel,
                    what=what,
                    begin=float(times[begins[MOST + 2]]),
                    end=float(times[ends[-1] - 1]),
                    count=skipped,
                    row=row,
                )
            )
        elif ends[-1] < odd.size:
            self._close(what)

    def _run(self, what: str, times: Array, rows: Any, begin: int, end: int) -> None:
        if begin and what in self._open:
            self._close(what)
        elif what in self._open:
            run = self._open[what]
            run.end, run.count = float(times[end - 1]), run.count + end - begin
            return
        self._open[what] = _Run(float(times[begin]), float(times[end - 1]), end - begin, int(rows[begin]))

    def _close(self, what: str) -> None:
        if what in self._open:
            self._list(self._finding(what, self._open.pop(what)))

    def _finding(self, what: str, run: _Run) -> Finding:
        return Finding(channel=self.channel, what=what, begin=run.begin, end=run.end, count=run.count, row=run.row)

    def _list(self, finding: Finding) -> None:
        """Lists a finding, or adds it to the last one of its sort where there are many."""
        listed = self._listed.setdefault(finding.what, [])
        if len(listed) < MOST:
            listed.append(finding)
        elif len(listed) == MOST:
            listed.append(_together(finding, finding.begin, finding.row, finding.count))
        else:
            listed[MOST] = _together(finding, listed[MOST].begin, listed[MOST].row, listed[MOST].count + finding.count)


def _together(finding: Finding, begin: float, row: int, count: int) -> Finding:
    what = finding.what.removesuffix(FURTHER) + FURTHER
    return Finding(channel=finding.channel, what=what, begin=begin, end=finding.end, count=count, row=row)


def _follow(side: _Extreme, times: Array, values: Array, rows: Any) -> None:
    """Takes the next values into account."""
    largest = float(values.max())
    if largest < side.next_value:
        side.current = 0
        return
    top = values == largest
    count = int(np.count_nonzero(top))
    below = values[~top] if count < values.size else values[:0]
    second = float(below.max()) if below.size else -np.inf
    second_count = int(np.count_nonzero(below == second)) if below.size else 0
    if largest < side.value:
        # Below the extreme: at most the value next to it changes.
        side.current = 0
        if largest > side.next_value:
            side.next_value, side.next_count = largest, count
        elif largest == side.next_value:
            side.next_count += count
        return
    where = np.flatnonzero(top)
    first, last = int(where[0]), int(where[-1])
    longest, leading, trailing = _run_lengths(where, values.size)
    if largest > side.value:
        # The extreme so far is now the value below, unless this portion has one in between.
        if side.value > second:
            second, second_count = side.value, side.count
        elif side.value == second:
            second_count += side.count
        side.value, side.count, side.longest, side.current = largest, 0, 0, 0
        side.begin, side.row = float(times[first]), int(rows[first])
        side.next_value, side.next_count = second, second_count
    elif second > side.next_value:
        side.next_value, side.next_count = second, second_count
    elif second == side.next_value:
        side.next_count += second_count
    side.longest = max(side.longest, longest, side.current + leading)
    side.current = side.current + leading if count == values.size else trailing
    side.count += count
    side.end = float(times[last])


def _run_lengths(where: Any, size: int) -> tuple[int, int, int]:
    """The longest run of neighbouring places, the one at the beginning, and the one at the end."""
    borders = np.flatnonzero(np.diff(where) != 1)
    lengths = np.diff(np.concatenate(([-1], borders, [where.size - 1])))
    leading = int(lengths[0]) if where[0] == 0 else 0
    trailing = int(lengths[-1]) if where[-1] == size - 1 else 0
    return int(lengths.max()), leading, trailing


def pieces(portions: Iterable[Portion], inspection: Inspection) -> Iterator[Piece]:
    """The good pieces of a channel that comes in portions; what is wrong is then with `inspection`."""
    for portion in portions:
        yield from inspection.pieces(portion)


def findings(log: Log, names: Sequence[str], samples: int = 1_000_000) -> Mapping[str, tuple[Finding, ...]]:
    """What is wrong with each of the channels `names`, from one reading of the log."""
    inspections = {name: Inspection(name) for name in names}
    for parts in log.portions(names, samples):
        for name, portion in parts.items():
            inspections[name].pieces(portion)
    return {name: inspection.findings() for name, inspection in inspections.items()}
