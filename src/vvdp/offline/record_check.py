"""Is the record sound? What is wrong with a channel, found while it streams by, and the pieces that are still good.

The rule by which a record is cut: a sample whose time is no number, or is that of the sample before, is left out; where
time goes backwards, or the next sample comes later than `GAP` usual intervals, a new piece begins. So within a piece
time rises and has no hole. The usual interval is the median of the portion at hand. Values are never changed, filled
in or left out: NaN stays in its place, for the reader of the piece to see.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.logs.channel import Log, Portion
from vvdp.offline.edges import Chosen

GAP = 1.5
"""A sampling interval above this multiple of the usual one is a gap."""
LOOKED_AT = 10_000
"""The usual interval is the median of about so many of a portion, evenly spread over it."""
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


@dataclass(frozen=True)
class Extreme:
    """The largest value so far (of the values or of their negatives), how often it occurs and how long in a row, last
    and at most; the largest below it. It occurs first at time `begin` [s] in `row`, and last at `end` [s]."""

    value: float = -np.inf
    count: int = 0
    longest: int = 0
    trailing: int = 0
    next_value: float = -np.inf
    next_count: int = 0
    begin: float = np.nan
    end: float = np.nan
    row: int = 0


NOTHING_SEEN = Extreme()


@dataclass
class Inspection:
    """One channel under inspection: give it the portions in order, take the good pieces, ask for the findings."""

    channel: str
    _listed: dict[str, list[Finding]] = field(default_factory=dict)
    _open: dict[str, bool] = field(default_factory=dict)  # whether the last sample was one of this sort
    _rows: int = 0
    _piece: int = 0
    _last: float = np.nan  # latest time that is a number
    _usual: float = np.nan
    _levels: set[float] = field(default_factory=set)
    _high: Extreme = NOTHING_SEEN
    _low: Extreme = NOTHING_SEEN

    def pieces(self, portion: Portion) -> list[Piece]:
        """The good pieces of the next portion; a piece may go on under its number in the portion after."""
        times, values = portion
        if not times.size:
            return []
        rows = np.arange(self._rows, self._rows + times.size)
        self._rows += times.size
        missing, timeless = np.isnan(values), ~np.isfinite(times)
        self._list_runs(NAN, missing, times, rows)
        self._follow(*_leave_out(missing, times, values, rows))
        self._list_runs(NO_TIME, timeless, _latest(times, ~timeless, self._last) if timeless.any() else times, rows)
        return self._cut(*_leave_out(timeless, times, values, rows))

    def findings(self) -> tuple[Finding, ...]:
        """What was found so far; of the whole channel, once all portions have been given."""
        found = [*(finding for listed in self._listed.values() for finding in listed), *self._extremes()]
        return tuple(sorted(found, key=lambda finding: (finding.row, finding.what)))

    def _cut(self, times: Array, values: Array, rows: Chosen) -> list[Piece]:
        if not times.size:
            return []
        before = np.concatenate(([self._last], times[:-1]))
        intervals = times - before
        self._last = float(times[-1])
        self._usual = _usual_interval(intervals, self._usual)
        still, back, gap = intervals == 0.0, intervals < 0.0, intervals > GAP * self._usual
        self._list_runs(STANDS, still, times, rows)
        if not (still.any() or back.any() or gap.any()):
            return [Piece(self._piece, times, values)]
        lost = np.fmax(np.round(intervals[gap] / self._usual) - 1.0, 1.0)
        self._list(BACKWARDS, before[back], times[back], np.ones(rows[back].size), rows[back])
        self._list(GAP_FOUND, before[gap], times[gap], lost, rows[gap])
        numbers = self._piece + np.cumsum(back | gap)
        self._piece = int(numbers[-1])
        kept = _leave_out(still, numbers, times, values)
        cuts = np.flatnonzero(np.diff(kept[0])) + 1
        parts = zip(*(np.split(column, cuts) for column in kept), strict=True)
        return [Piece(int(number[0]), t, v) for number, t, v in parts if number.size]

    def _list_runs(self, what: str, odd: Chosen, times: Array, rows: Chosen) -> None:
        """Lists runs of odd samples; one at the beginning goes on from the portion before."""
        if not odd.any():
            self._open[what] = False
            return
        first, last = np.flatnonzero(np.diff(odd, prepend=False, append=False)).reshape(-1, 2).T
        joined = bool(odd[0]) and self._open.get(what, False)
        self._open[what] = bool(odd[-1])
        self._list(what, times[first], times[last - 1], last - first, rows[first], joined=joined)

    def _list(self, what: str, *columns: Chosen, joined: bool = False) -> None:
        """Lists what was found: columns of begins, ends, counts and rows, the first `joined` with the one before."""
        begins, ends, counts, rows = columns
        if rows.size > MOST + 2:  # the rest is counted together whatever was listed before
            ends, counts = np.append(ends[: MOST + 1], ends[-1]), np.append(counts[: MOST + 1], sum(counts[MOST + 1 :]))
        listed = self._listed.setdefault(what, [])
        for begin, end, count, row in zip(begins.tolist(), ends.tolist(), counts.tolist(), rows.tolist(), strict=False):
            if joined or len(listed) > MOST:
                listed[-1] = replace(listed[-1], end=end, count=listed[-1].count + int(count))
            else:
                listed.append(self._finding(what if len(listed) < MOST else what + FURTHER, begin, end, count, row))
            joined = False

    def _follow(self, times: Array, values: Array, rows: Chosen) -> None:
        if values.size and len(self._levels) <= FEW_LEVELS:
            self._levels.update(np.unique(values[:: max(1, values.size // 4096)])[: FEW_LEVELS + 1].tolist())
        if values.size:
            self._high, self._low = (_after(self._high, times, values, rows), _after(self._low, times, -values, rows))

    def _extremes(self) -> Iterator[Finding]:
        high, low = self._high, self._low
        told = {CONSTANT: high} if high.count > 1 and high.value == -low.value else {}
        if len(self._levels) > FEW_LEVELS:
            told = {what: side for what, side in ((HIGH, high), (LOW, low)) if _is_saturated(side)}
        for what, side in told.items():
            yield self._finding(what, side.begin, side.end, side.count, side.row)

    def _finding(self, what: str, begin: float, end: float, count: float, row: int) -> Finding:
        return Finding(channel=self.channel, what=what, begin=begin, end=end, count=int(count), row=row)


def _usual_interval(intervals: Array, known: float) -> float:
    """The usual one of the intervals [s]; what is `known` of it where they are too few to show."""
    some = intervals[:: 1 + intervals.size // LOOKED_AT]
    rising = some[some > 0.0]
    return float(np.median(rising)) if rising.size >= 3 or (rising.size and np.isnan(known)) else known


def _latest(times: Array, known: Chosen, before: float) -> Array:
    """For each sample the latest time that is a number; that `before` them where there was none yet."""
    where = np.concatenate(([-1], np.flatnonzero(known)))
    latest = where[np.searchsorted(where, np.arange(times.size), side="right") - 1]
    return np.where(latest >= 0, times[latest], before)


def _is_saturated(side: Extreme) -> bool:
    return side.longest >= CLIPPED_RUN and side.count >= CLIPPED_RATIO * max(side.next_count, 1)


def _leave_out(odd: Chosen, *columns: Chosen) -> tuple[Chosen, ...]:
    return tuple(column[~odd] for column in columns) if odd.any() else columns


def _after(seen: Extreme, times: Array, values: Array, rows: Chosen) -> Extreme:
    """The extreme with the next values taken into account."""
    largest = float(values.max())
    if largest < seen.next_value:
        return replace(seen, trailing=0)
    top = values == largest
    second = float(np.max(values, where=~top, initial=-np.inf))
    counts = Counter({largest: int(np.count_nonzero(top)), second: int(np.count_nonzero(values == second))})
    counts.update({seen.value: seen.count})
    counts.update({seen.next_value: seen.next_count})
    (value, count), (next_value, next_count) = sorted(counts.items(), reverse=True)[:2]
    if largest < seen.value:
        return replace(seen, trailing=0, next_value=next_value, next_count=next_count)
    first, last = np.flatnonzero(np.diff(top, prepend=False, append=False)).reshape(-1, 2).T
    lengths, same = last - first, largest == seen.value
    lengths[0] += seen.trailing if same and top[0] else 0
    return Extreme(
        value=value,
        count=count,
        longest=max(int(lengths.max()), seen.longest if same else 0),
        trailing=int(lengths[-1]) if top[-1] else 0,
        next_value=next_value,
        next_count=next_count,
        begin=seen.begin if same else float(times[first[0]]),
        end=float(times[last[-1] - 1]),
        row=seen.row if same else int(rows[first[0]]),
    )


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
