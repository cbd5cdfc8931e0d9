"""Where a record of edges is cut into pieces within which the filter goes on.

It is cut where nothing could be said across a silence: where the prediction would be uncertain by half a sector, and
not within three of the times that edges usually take there. What is usual is judged from the edges before the silence,
at the beginning of a piece also from those after it. It is cut as well where a wheel with an index turns back.
"""

from collections.abc import Generator, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple, TypeAlias

import numpy as np

from vvdp.base.arrays import Array
from vvdp.estimation.event_settings import EventFilter
from vvdp.offline.alignment import Start, edges_needed, start
from vvdp.offline.bridging import RECENT, longest_bridged, usual_before
from vvdp.offline.edges import Chosen, Edges, join, known_times, no_edges, part
from vvdp.offline.passages import SEEN_AFTER, SEEN_BEFORE, slow_passages
from vvdp.offline.sums import Tally

FEWEST_EDGES = 3
"""A piece of fewer edges is left out."""
EDGES_AT_ONCE = 20_000
MOST_ROWS = 2.0**52
"""The times of later rows could not be distinguished."""
SLOWED = 1.4
"""Where the last time between edges is so many usual ones, the wheel slowed down to a stop; assumed."""


class Begin(NamedTuple):
    """A piece begins with these edges."""

    first: Edges
    start: Start


class Follow(NamedTuple):
    """Edges of the piece, none where nothing but time passes, and until when [s] it is followed then."""

    edges: Edges
    until: float


class End(NamedTuple):
    """The piece ends."""


Cut: TypeAlias = Begin | Follow | End


@dataclass
class Course:
    """The last edges of a piece [s] and the last times between them [s]; without any as long as it has not begun."""

    times: Array = field(default_factory=lambda: np.empty(0))
    steps: Array = field(default_factory=lambda: np.empty(0))

    @property
    def has_begun(self) -> bool:
        """Whether the piece has edges."""
        return self.times.size > 0

    @property
    def has_slowed(self) -> bool:
        """Whether the wheel turned slower at last, as towards a stop."""
        return self.steps.size > 1 and bool(self.steps[-1] > SLOWED * float(np.median(self.steps)))

    def add(self, times: Array) -> None:
        """Goes on with edges at these times [s]."""
        steps = np.diff(np.concatenate([self.times[-1:], times]))
        self.steps = np.concatenate([self.steps, steps])[-RECENT:]
        self.times = np.concatenate([self.times, times])[-SEEN_BEFORE - 1 :]

    def lasts(self, waves: Array, settings: EventFilter) -> float:
        """Until when rows can be given without another edge, with edges of the pressure's `waves` [s]."""
        end = float(self.times[-1])
        if not self.steps.size:
            return end
        reach = float(longest_bridged(usual_before(self.steps)[-1:], np.array([np.inf]), settings)[0])
        heard = np.concatenate([[end], waves[waves > end]])
        silences = np.flatnonzero(np.diff(heard) > reach)
        return float(heard[silences[0] if silences.size else -1]) + reach


@dataclass
class Cutter:
    """Takes settled edges, gives pieces; `waves` are times [s] of edges of the pressure, which bridge silences too."""

    settings: EventFilter
    tally: Tally
    direction: float = 1.0
    waves: Array = field(default_factory=lambda: np.empty(0))
    _course: Course = field(default_factory=Course)
    _pending: Edges = field(default_factory=no_edges)
    _looked_past: float = -np.inf  # slow passages up to here are done with

    def push(self, edges: Edges, horizon: float, *, last: bool) -> Iterator[Cut]:
        """What becomes of `edges`, the record known up to `horizon` [s]; `last`: nothing follows on this clock."""
        self._pending = join([self._pending, edges])
        while self._pending.times.size:
            if not (yield from self._segment(last)):
                return  # a piece begins, but too little of it is known yet
        if self._course.has_begun:
            yield Follow(no_edges(), min(horizon, self._course.lasts(self.waves, self.settings)))
        if last:
            yield self.forget()

    def forget(self) -> End:
        """Nothing follows on this clock; the next piece may lie at any time."""
        self._pending, self._course = no_edges(), Course()
        self._looked_past, self.waves = -np.inf, np.empty(0)
        return End()

    def _segment(self, last: bool) -> Generator[Cut, None, bool]:
        """Takes in the pending edges up to the next cut; false where more have to be known first."""
        wanted = max(edges_needed(self.settings.wheel), 2 * SEEN_AFTER)  # edges that show how a piece begins
        looked_at = self._pending.times[: max(EDGES_AT_ONCE, wanted)]
        cuts = np.flatnonzero(~can_bridge(looked_at, self._course, self.waves, self.settings))
        end = int(cuts[0]) if cuts.size else looked_at.size
        if not self._course.has_begun:
            if end < wanted and not cuts.size and not last:
                return False
            if not self._is_piece(looked_at[:end]):
                self.tally.leave_out(looked_at[:end])
                self._pending = part(self._pending, slice(end, None))
                return True
            yield self._begin(part(self._pending, slice(0, min(end, wanted))))
        whole = bool(cuts.size) or (last and looked_at.size == self._pending.times.size)
        known, turned = self._until_turn(end, wanted, whole=whole)
        if known:
            yield self._follow(known)
        if turned or (cuts.size and known == end):
            yield self._silence(turned=turned)
            self._course = Course()
            yield End()
        return turned or known > 0

    def _is_piece(self, times: Array) -> bool:
        return times.size >= FEWEST_EDGES and times[-1] > times[0] and abs(times[-1]) * self.tally.rate <= MOST_ROWS

    def _begin(self, first: Edges) -> Begin:
        found = start(first, self.settings.wheel, self.direction)
        self.tally.alignments.append(found.alignment)
        self.tally.pieces += 1
        self.direction = found.direction
        return Begin(first, found)

    def _follow(self, known: int) -> Follow:
        """The next `known` edges of the piece, with the rows up to the last of them."""
        taken = part(self._pending, slice(0, known))
        self._course.add(taken.times)
        self._pending = part(self._pending, slice(known, None))
        self.waves = self.waves[self.waves > taken.times[-1]]
        return Follow(taken, float(known_times(taken)[-1]))

    def _silence(self, *, turned: bool) -> Follow:
        """Rows after the last edge of a piece, as far as they are known; a wheel that slowed may have turned back."""
        after = float(self._pending.times[0])
        if not turned and self._course.has_slowed:
            self.tally.slow_passages.append(float(0.5 * (self._course.times[-1] + after)))
        return Follow(no_edges(), min(self._course.lasts(self.waves, self.settings), after))

    def _until_turn(self, end: int, wanted: int, *, whole: bool) -> tuple[int, bool]:
        """How many of the pending edges, up to `end`, go on as before, as far as is known, and whether the wheel turns
        back then; `whole`: the piece has no more of them."""
        times, history = self._pending.times[:end], self._course.times
        seen = np.concatenate([history, times])
        for step in slow_passages(np.diff(seen)):
            i = step + 1 - history.size
            if i < 0 or times[i] <= self._looked_past:
                continue
            if end - i < wanted and not whole:
                return i, False
            self._looked_past, middle = float(times[i]), float(0.5 * (seen[step] + seen[step + 1]))
            after = part(self._pending, slice(i, min(i + wanted, end)))
            if start(after, self.settings.wheel, self.direction).direction != self.direction:
                self.tally.reversals.append(middle)
                return i, True
            self.tally.slow_passages.append(middle)
        return (end if whole else max(end - SEEN_AFTER, 0)), False


def can_bridge(times: Array, course: Course, waves: Array, settings: EventFilter) -> Chosen:
    """Of each edge at one of `times` [s], whether the time since the one before it can be bridged, by edges of the
    pressure's `waves` [s] as well.

    course  of the piece before these; where it begins here, the first edge has nothing before it
    """
    steps = np.diff(times, prepend=course.times[-1:] if course.has_begun else times[:1])
    if course.has_begun:
        known = np.concatenate([course.steps, steps])
        limits = longest_bridged(usual_before(known)[course.steps.size :], steps, settings)
    else:
        limits = np.concatenate([[np.inf], longest_bridged(usual_before(steps[1:]), steps[1:], settings)])
    found: Chosen = steps <= limits
    for i in np.flatnonzero(~found) if waves.size else ():
        heard = waves[(waves < times[i]) & (waves > times[i] - steps[i])]
        silences = np.diff(np.concatenate([[times[i] - steps[i]], heard, [times[i]]]))
        found[i] = bool(np.all(silences <= limits[i]))
    return found
