"""The clock of a record: which times are asked for, how far apart samples usually are, where it has gaps or goes back.

First of the stages of an estimation; the next one is given stretches in which time runs forward.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import unusable
from vvdp.logs.channel import Portion
from vvdp.offline.config import Estimation, Stamps
from vvdp.offline.edges import GAP, Chosen, Edges, part
from vvdp.offline.sums import Tally

USUAL_RATE = 1000.0
"""Rows a second of the time base, unless the log has fewer samples or another rate is asked for."""
LARGEST = 1e100
"""No instrument gives such a value; it is damage, and its square would be infinite."""
MOST_BACKWARD = 1000
"""A clock that goes back more often is none."""


class RecordClock:
    """The clock of the channel that holds the edges; what it finds is counted."""

    def __init__(self, path: Path, wanted: Estimation, tally: Tally) -> None:
        self._path, self._wanted, self._tally = path, wanted, tally
        self._reached = -np.inf
        self.gaps: list[tuple[float, float]] = []
        """Gaps of the record, from when to when [s], that the filter is not yet informed of."""

    def inside(self, times: Array) -> Chosen:
        """Which times are in the range that was asked for."""
        begin, end = self._wanted.begin, self._wanted.end
        found: Chosen = np.isfinite(times)
        if begin is not None:
            found &= times >= begin
        if end is not None:
            found &= times <= end
        return found

    def stretches(self, portion: Portion) -> Iterator[Portion | None]:
        """The sound samples of a portion; None where the time goes back."""
        times, values = portion
        self._tally.samples += times.size
        sound = (np.abs(values) < LARGEST) & np.isfinite(times)
        self._tally.not_numbers += int(times.size - np.count_nonzero(sound))
        inside = self.inside(times)
        self._watch(times[inside])
        sound &= inside
        times, values = (times, values) if sound.all() else (times[sound], values[sound])
        for where in self._forward(times):
            yield None if where is None else Portion(times[where], values[where])

    def edges(self, found: Edges) -> Iterator[Edges | None]:
        """Edges that are a clock themselves, in order; None where their times go back: a column of several records, one
        below the other."""
        for where in self._forward(found.times):
            yield None if where is None else part(found, where)

    def _forward(self, times: Array) -> Iterator[slice | None]:
        """Stretches in which times run forward; None where they go back. Raises ConfigError where that is too often."""
        if not times.size:
            return
        tally = self._tally
        before = tally.end if np.isfinite(tally.end) else times[0]
        back = np.flatnonzero(np.diff(times, prepend=before) < 0.0).tolist()
        if tally.backward + len(back) > MOST_BACKWARD:
            channel = self._wanted.source.channel
            which = f"edge times {channel!r} do" if isinstance(self._wanted.source, Stamps) else "clock does"
            problem = f"the {which} not run forward, more than {MOST_BACKWARD} times; is it the right column?"
            raise unusable(self._path, problem)
        for i, (first, last) in enumerate(zip([0, *back], [*back, times.size], strict=True)):
            if i:
                tally.backward += 1
                yield None
            if last > first:
                tally.begin, tally.end = min(tally.begin, float(times[first])), float(times[last - 1])
                yield slice(first, last)

    def _watch(self, times: Array) -> None:
        """Gaps between samples, whatever their values."""
        if not self._tally.period and times.size > 1:
            ahead = np.diff(times)
            ahead = ahead[ahead > 0.0]
            self._tally.period = float(np.median(ahead)) if ahead.size else 1.0 / USUAL_RATE
        if not times.size:
            return
        steps = np.diff(times, prepend=self._reached if np.isfinite(self._reached) else times[0])
        self._reached = float(times[-1])
        after = np.flatnonzero(steps > GAP * self._tally.period) if self._tally.period else np.empty(0, int)
        self._tally.gaps += after.size
        self.gaps += [(float(times[i] - steps[i]), float(times[i])) for i in after.tolist()]
        self._tally.longest_gap = max(self._tally.longest_gap, float(np.max(steps, initial=0.0)))
        self._tally.measured += float(np.sum(steps[steps > 0.0]))
