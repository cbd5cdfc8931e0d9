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
NAMED_TIMES = 5
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
class Cutter:
    """Takes settled edges, gives pieces; `waves` are times [s] of edges of the pressure, which bridge silences too."""

    settings: EventFilter
    tally: Tally
    direction: float = 1.0
    waves: Array = field(default_factory=lambda: np.empty(0))
    _inside: bool = False
    _pending: Edges = field(default_factory=no_edges)
    _history: Array = field(default_factory=lambda: np.empty(0))  # the last times of edges of the piece ...
    _steps: Array = field(default_factory=lambda: np.empty(0))  # ... and between them
    _looked_past: float = -np.inf  # slow passages up to here are done with

    def push(self, edges: Edges, horizon: float, *, last: bool) -> Iterator[Cut]:
        """What becomes of `edges`, the record known up to `horizon` [s]; `last`: nothing follows on this clock."""
        self._pending = join([self._pending, edges])
        while self._pending.times.size:
            if not (yield from self._segment(last)):
                return  # a piece begins, but too little of it is known yet
        if self._inside:
            yield Follow(no_edges(), min(horizon, self._lasting()))
        if last:
            yield self.forget()

    def forget(self) -> End:
        """Nothing follows on this clock; the next piece may lie at any time."""
        self._pending, self._steps, self._inside = no_edges(), np.empty(0), False
        self._looked_past, self.waves = -np.inf, np.empty(0)
        return End()

    def _segment(self, last: bool) -> Generator[Cut, None, bool]:
        """Takes in the pending edges up to the next cut; false where more have to be known first."""
        wanted = max(edges_needed(self.settings.wheel), 2 * SEEN_AFTER)  # edges that show how a piece begins
        looked_at = self._pending.times[: max(EDGES_AT_ONCE, wanted)]
        before = float(self._history[-1]) if self._inside else None
        cuts = np.flatnonzero(~can_bridge(looked_at, before, self._steps, self.waves, self.settings))
        end = int(cuts[0]) if cuts.size else looked_at.size
        if not self._inside:
            if end < wanted and not cuts.size and not last:
                return False
            if not self._is_piece(looked_at[:end]):
                self._leave_out(end)
                return True
            yield self._begin(part(self._pending, slice(0, min(end, wanted))))
        whole = bool(cuts.size) or (last and looked_at.size == self._pending.times.size)
        known, turned = self._until_turn(end, wanted, whole=whole)
        if known:
            yield self._follow(known)
        if turned or (cuts.size and known == end):
            self._look_at_cut(turned=turned)
            yield Follow(no_edges(), min(self._lasting(), float(self._pending.times[0])))
            self._inside, self._steps = False, np.empty(0)
            yield End()
        return turned or known > 0

    def _look_at_cut(self, *, turned: bool) -> None:
        """Notes where the wheel slowed down towards a silence that ends the piece: it may have turned back there."""
        if not turned and self._steps.size > 1 and self._steps[-1] > SLOWED * float(np.median(self._steps)):
            self.tally.slow_passages.append(float(0.5 * (self._history[-1] + self._pending.times[0])))

    def _is_piece(self, times: Array) -> bool:
        return times.size >= FEWEST_EDGES and times[-1] > times[0] and abs(times[-1]) * self.tally.rate <= MOST_ROWS

    def _leave_out(self, end: int) -> None:
        named = self.tally.left_out_times + self._pending.times[:end][:NAMED_TIMES].tolist()
        self.tally.left_out, self.tally.left_out_times = self.tally.left_out + end, named[:NAMED_TIMES]
        self._pending = part(self._pending, slice(end, None))

    def _begin(self, first: Edges) -> Begin:
        found = start(first, self.settings.wheel, self.direction)
        self.tally.alignments.append(found.alignment)
        self.tally.pieces += 1
        self.direction, self._history, self._inside = found.direction, np.empty(0), True
        return Begin(first, found)

    def _follow(self, known: int) -> Follow:
        """The next `known` edges of the piece, with the rows up to the last of them."""
        taken = part(self._pending, slice(0, known))
        before = self._history[-1] if self._history.size else taken.times[0]
        steps = np.diff(taken.times, prepend=before)[0 if self._steps.size else 1 :]
        self._steps = np.concatenate([self._steps, steps])[-RECENT:]
        self._history = np.concatenate([self._history, taken.times])[-SEEN_BEFORE - 1 :]
        self._pending = part(self._pending, slice(known, None))
        self.waves = self.waves[self.waves > taken.times[-1]]
        return Follow(taken, float(known_times(taken)[-1]))

    def _until_turn(self, end: int, wanted: int, *, whole: bool) -> tuple[int, bool]:
        """How many of the pending edges, up to `end`, go on as before, as far as is known, and whether the wheel turns
        back then; `whole`: the piece has no more of them."""
        times = self._pending.times[:end]
        seen = np.concatenate([self._history, times])
        for step in slow_passages(np.diff(seen)):
            i = step + 1 - self._history.size
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

    def _lasting(self) -> float:
        """Until when rows can be given without another edge [s]."""
        end = float(self._history[-1])
        if not self._steps.size:
            return end
        reach = float(longest_bridged(usual_before(self._steps)[-1:], np.array([np.inf]), self.settings)[0])
        heard = np.concatenate([[end], self.waves[self.waves > end]])
        silences = np.flatnonzero(np.diff(heard) > reach)
        return float(heard[silences[0] if silences.size else -1]) + reach


def can_bridge(times: Array, before: float | None, earlier: Array, waves: Array, settings: EventFilter) -> Chosen:
    """Of each edge at one of `times` [s], whether the time since the one before it can be bridged, by edges of the
    pressure's `waves` [s] as well.

    before, earlier  the edge `before` these [s] and the `earlier` times between edges of the piece [s]; None and empty
                     where it begins here: then the first edge has nothing before it
    """
    steps = np.diff(times, prepend=times[0] if before is None else before)
    if before is None:
        limits = np.concatenate([[np.inf], longest_bridged(usual_before(steps[1:]), steps[1:], settings)])
    else:
        limits = longest_bridged(usual_before(np.concatenate([earlier, steps]))[earlier.size :], steps, settings)
    found: Chosen = steps <= limits
    for i in np.flatnonzero(~found) if waves.size else ():
        heard = waves[(waves < times[i]) & (waves > times[i] - steps[i])]
        silences = np.diff(np.concatenate([[times[i] - steps[i]], heard, [times[i]]]))
        found[i] = bool(np.all(silences <= limits[i]))
    return found
