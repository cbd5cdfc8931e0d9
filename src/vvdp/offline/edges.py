"""Edges out of what was recorded: a photodiode's wave, a counter, or a column of times.

Each kind of record has a finder that takes portions one after another and keeps what it needs between them. All work on
whole arrays. Edges that come too soon after another are bounces, and `Debounce` takes them out.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from vvdp.base.arrays import Array
from vvdp.offline.config import Comparator

GAP = 3.5
"""A sampling interval of so many usual ones is a gap: an edge in it is not placed."""
LEAST_SWING = 3.2
"""Swing over noise below which there is no wave: the two halves of plain Gaussian noise lie 2.6 deviations apart."""
TWO_LEVELS = 0.8
"""Share of the samples near either level from which on it is a wave however few samples a sector has: a comparator's
output. Of Gaussian noise 0.36 are, of evenly spread noise 0.44."""
SHORTEST = 0.15
"""Edges closer than this share of the usual time between edges are one edge that bounced, or a glitch."""
NEIGHBOURS = 16
"""So many times between edges before, and after, say what is usual there."""
JUMPING = 0.15
"""A channel that goes through this share of its range from sample to sample is a wave sampled too slowly, or noise: a
wave of ten samples a sector goes through a tenth, Gaussian noise through 0.18."""
LARGEST_COUNT = 2.0**53
"""Beyond, one count more is lost in a float."""
MOST_AT_ONCE = 1e6
"""Edges between two samples; nothing turns so far unseen."""
WHOLE = 1e-3
"""How far a count may lie from a whole number."""
LONGEST_BAND = 100_000
"""Samples that are remembered while a wave stays within the hysteresis."""


Chosen: TypeAlias = NDArray[Any]
"""Which elements: their indices, or true and false for each."""


class Edges(NamedTuple):
    """Edges in the order of time, arrays of one length; the fields are those of a `Reading`."""

    times: Array  # [s]
    intervals: Array  # within which each lies [s]
    polarities: Array  # +1, -1, 0 unknown
    counts: Array  # edges since the one before, this one included


def no_edges() -> Edges:
    """An empty record."""
    return Edges(*(np.empty(0) for _ in range(4)))


def join(parts: Sequence[Edges]) -> Edges:
    """Records one after another."""
    return Edges(*(np.concatenate(columns) for columns in zip(*parts, strict=True))) if parts else no_edges()


def part(edges: Edges, chosen: slice | Chosen) -> Edges:
    """Some of the edges."""
    return Edges(*(column[chosen] for column in edges))


def known_times(edges: Edges) -> Array:
    """When each edge is known to have passed [s], at the end of its interval, or of the last part of that of several
    edges; not after the sample itself for the rounding of times."""
    ends = edges.times + 0.5 * edges.intervals / edges.counts
    found: Array = np.fmax(ends - 1e-6 * edges.intervals, edges.times)
    return found


class Plateaus(NamedTuple):
    """The two levels of a wave and the noise on them (standard deviation), in the unit of the channel."""

    low: float
    high: float
    noise: float

    @property
    def middle(self) -> float:
        """Half way between both levels."""
        return 0.5 * (self.low + self.high)

    @property
    def swing(self) -> float:
        """How far the levels lie apart."""
        return self.high - self.low


def plateaus(values: Array) -> Plateaus | None:
    """The levels between which `values` go up and down, or None where they do not.

    The range without its outermost thousandths is halved; a plateau is the outer fifth's boundary of its half, so that
    it does not matter how long the wave stays on either, nor how much of it is ramp.
    """
    if values.size < 8:
        return None
    bottom, top = np.quantile(values, [1e-3, 1.0 - 1e-3], method="nearest")
    middle = 0.5 * (bottom + top)
    above = values > middle
    if not top > bottom or above.all() or not above.any():
        return None
    low = float(np.quantile(values[~above], 0.2))
    high = float(np.quantile(values[above], 0.8))
    steps = np.diff(values)
    outer = np.abs(values - 0.5 * (low + high)) > 0.35 * (high - low)
    two_levels = float(np.mean(outer)) > TWO_LEVELS
    if not two_levels and not high - low > LEAST_SWING * float(np.std(steps)) / np.sqrt(2.0):
        return None
    still = steps[outer[1:] & outer[:-1] & (above[1:] == above[:-1])]
    noise = 1.4826 * float(np.median(np.abs(still))) / np.sqrt(2.0) if still.size >= 20 else 0.0
    return Plateaus(low, high, noise)


@dataclass
class WaveEdges:
    """Edges of a photodiode's wave: crossings of a threshold that are confirmed by leaving the hysteresis around it.

    Without a fixed threshold the plateaus of each portion set it, so that it follows a lamp that fades.
    """

    comparator: Comparator
    plateaus: Plateaus | None = None
    levels: list[float] = field(default_factory=list)
    """The threshold of each portion."""
    lost: int = 0
    """Edges that fell into a gap of the record."""
    jumps: float = 0.0
    """Where no two levels were seen so far: the share of its range that the wave goes through from sample to sample."""
    slopes: float = 0.0
    """Sum of the slopes at the crossings [unit of the channel/s]."""
    found: int = 0
    _high: bool | None = None
    _times: Array = field(default_factory=lambda: np.empty(0))
    _values: Array = field(default_factory=lambda: np.empty(0))

    @property
    def level(self) -> float:
        """The threshold now; NaN as long as none is known."""
        if self.comparator.level is not None:
            return self.comparator.level
        return self.plateaus.middle if self.plateaus is not None else np.nan

    @property
    def band(self) -> float:
        """Half of the hysteresis, in the unit of the channel."""
        return 0.5 * self.comparator.hysteresis * self.plateaus.swing if self.plateaus is not None else 0.0

    def restart(self) -> None:
        """Forget what came before: the record is broken here."""
        self._high, self._times, self._values = None, np.empty(0), np.empty(0)

    def push(self, times: Array, values: Array, period: float) -> Edges:
        """The edges that the next samples confirm; `period` is the usual time between samples [s]."""
        seen = plateaus(values)
        if seen is not None and (self.plateaus is None or seen.swing > 0.3 * self.plateaus.swing):
            self.plateaus = seen
        level, band = self.level, self.band
        if not np.isfinite(level):
            self.jumps = float(np.mean(np.abs(np.diff(values))) / np.ptp(values)) if np.ptp(values) > 0.0 else 0.0
            return no_edges()
        self.levels.append(level)
        kept = self._times.size
        t, v = np.concatenate([self._times, times]), np.concatenate([self._values, values])
        certain = np.flatnonzero(np.abs(v - level) > band)
        certain = certain[certain >= kept]
        if not certain.size:
            self._times, self._values = t[-LONGEST_BAND:], v[-LONGEST_BAND:]
            return no_edges()
        high = v[certain] > level
        if self._high is not None:  # the last certain sample of the portion before is the first one kept
            certain, high = np.concatenate([[0], certain]), np.concatenate([[self._high], high])
        changed = np.flatnonzero(high[1:] != high[:-1]) + 1
        edges = self._place(t, v, certain[changed - 1], certain[changed], high[changed], period)
        self._high = bool(high[-1])
        self._times, self._values = t[certain[-1] :], v[certain[-1] :]
        return edges

    def _place(self, t: Array, v: Array, before: Chosen, after: Chosen, high: Chosen, period: float) -> Edges:
        """Edges between certain samples `before` and `after`: where the level was crossed in that direction, on average
        where noise crossed it several times."""
        level = self.level
        up = v > level
        crossings = np.flatnonzero(up[1:] != up[:-1])
        first, last = np.searchsorted(crossings, before), np.searchsorted(crossings, after) - 1
        inside = last >= first  # always, but where the threshold moved between two portions
        first, last, high = first[inside], last[inside], high[inside]
        if not first.size:
            return no_edges()
        a, b = crossings[first], crossings[last]
        widths, jumps = t[b + 1] - t[a], np.abs(v[b + 1] - v[a])
        if self.comparator.interpolated:
            times = 0.5 * (_crossing(t, v, a, level) + _crossing(t, v, b, level))
            swing = self.plateaus.swing if self.plateaus is not None else np.inf
            noise = self.plateaus.noise if self.plateaus is not None else 0.0
            slopes = np.fmax(jumps, 1e-300) / np.fmax(widths, 1e-100)
            hidden = widths * np.clip(jumps / swing, 0.0, 1.0) ** 2
            intervals = np.clip(np.hypot(hidden, np.sqrt(12.0) * noise / slopes), 0.0, widths)
        else:
            times, intervals = 0.5 * (t[a] + t[b + 1]), widths
        sound = widths <= np.fmax(GAP * period, (b + 1 - a) * 1.5 * period)
        self.lost += int(np.count_nonzero(~sound))
        self.found += int(np.count_nonzero(sound))
        rises = jumps / np.where(widths > 0.0, widths, np.inf)
        self.slopes += float(np.sum(rises[sound]))
        polarities = np.where(high != self.comparator.inverted, 1.0, -1.0)
        return part(Edges(times, intervals, polarities, np.ones(times.size)), sound)


def _crossing(t: Array, v: Array, index: Chosen, level: float) -> Array:
    """When the straight line from sample `index` to the next is at `level`."""
    t0, v0 = t[index], v[index]
    found: Array = t0 + (t[index + 1] - t0) * (level - v0) / (v[index + 1] - v0)
    return found


@dataclass
class CountEdges:
    """Edges of a counter. A counter that rolls over at a power of two goes on; one that falls otherwise was reset."""

    rollovers: int = 0
    resets: int = 0
    backward: int = 0
    """Steps against the way the counter goes, which a jitter at an edge makes; they are waited out."""
    fractions: int = 0
    """Values that are no whole numbers; a counter has none."""
    downward: bool | None = None
    """Whether the counter counts down; seen from its first steps."""
    _last: tuple[float, float] | None = None
    _reached: float = 0.0
    _most: float = 0.0
    _usual: float = 1.0
    """The largest step that needs no explanation."""

    def restart(self) -> None:
        """Forget what came before: the record is broken here."""
        self._last, self._reached, self._most = None, 0.0, 0.0

    def push(self, times: Array, counts: Array) -> Edges:
        """The edges in the sampling intervals of the next samples."""
        countable = np.abs(counts) < LARGEST_COUNT
        self.fractions += int(np.count_nonzero((np.abs(counts - np.round(counts)) > WHOLE) | ~countable))
        times, counts = times[countable], counts[countable]
        if self._last is not None:
            times, counts = np.concatenate([[self._last[0]], times]), np.concatenate([[self._last[1]], counts])
        if times.size < 2:
            if times.size:
                self._last = float(times[-1]), float(counts[-1])
            return no_edges()
        steps = np.diff(np.round(counts))
        large = np.abs(steps) > 0.25 * np.abs(counts[:-1]) + 2.0
        self._usual = max(self._usual, float(np.max(np.abs(steps[~large]), initial=1.0)))
        for i in np.flatnonzero(large):
            steps[i] = self._over_the_end(float(counts[i]), float(steps[i]))
        moved = steps[steps != 0.0]
        if self.downward is None and moved.size:
            self.downward = bool(np.count_nonzero(moved < 0.0) > np.count_nonzero(moved > 0.0))
        if self.downward:
            steps = -steps
        self.backward += int(np.count_nonzero(steps < 0.0))
        stood = self._reached + np.cumsum(steps)
        top = np.fmax.accumulate(np.concatenate([[self._most], stood]))
        forward = np.diff(top)
        self._last, self._reached, self._most = (
            (float(times[-1]), float(counts[-1])), float(stood[-1]), float(top[-1])
        )  # fmt: skip
        at = np.flatnonzero(forward > 0.0)
        widths = times[at + 1] - times[at]
        # Of several edges in an interval the last one, evenly spaced, lies in the last part of it.
        return Edges(times[at + 1] - 0.5 * widths / forward[at], widths, np.zeros(at.size), forward[at])

    def _over_the_end(self, count: float, step: float) -> float:
        """What a large step was: a rollover, a reset or nonsense (then nothing is known to have passed), or a real
        jump."""
        after = count + step
        for top in (count, after):
            modulus = 2.0 ** np.ceil(np.log2(top + 1.0)) if top >= 7.0 else 0.0
            short = step - np.sign(step) * modulus
            if modulus and abs(short) <= 2.0 * self._usual + 1.0 and abs(short) < 0.5 * abs(step):
                self.rollovers += 1
                return float(short)
        if step < 0.0 or step > MOST_AT_ONCE:
            self.resets += 1
            return 0.0
        return step


@dataclass
class StampEdges:
    """Edges from one column of times, or from two, of the rising and the falling ones, which are merged."""

    apart: bool
    tick: float = 0.0
    """In which the times are written [s], where that matters."""
    backward: int = 0
    """Times that lie before the one above them; they are put in order where that is possible."""
    not_numbers: int = 0
    """Times that are NaN or infinite; fields that are empty from some row to the end of a column hold no time."""
    _empty: list[int] = field(default_factory=lambda: [0, 0])
    """Of each column, NaN after its last time so far."""
    _waiting: tuple[Array, Array] = field(default_factory=lambda: (np.empty(0), np.empty(0)))
    _ended: tuple[float, float] = (-np.inf, -np.inf)

    def push(self, rising: Array, falling: Array, *, last: bool) -> Edges:
        """The edges up to the time that both columns have reached; all where this is the `last` portion."""
        self._count_no_numbers(rising, falling)
        rising, falling = rising[np.isfinite(rising)], falling[np.isfinite(falling)]
        self.backward += int(np.count_nonzero(np.diff(rising) < 0.0) + np.count_nonzero(np.diff(falling) < 0.0))
        if not self.apart:
            return Edges(rising, np.full(rising.size, self.tick), np.zeros(rising.size), np.ones(rising.size))
        both = [np.concatenate([kept, new]) for kept, new in zip(self._waiting, (rising, falling), strict=True)]
        self._ended = tuple(  # type: ignore[assignment]
            float(new[-1]) if new.size else end for new, end in zip((rising, falling), self._ended, strict=True)
        )
        until = np.inf if last else min(self._ended)
        times = np.concatenate(both)
        polarities = np.concatenate([np.ones(both[0].size), -np.ones(both[1].size)])
        ready = times <= until
        self._waiting = both[0][both[0] > until], both[1][both[1] > until]
        order = np.argsort(times[ready], kind="stable")
        times, polarities = times[ready][order], polarities[ready][order]
        return Edges(times, np.full(times.size, self.tick), polarities, np.ones(times.size))

    def _count_no_numbers(self, rising: Array, falling: Array) -> None:
        """Takes in what is no time. In a list of events, with one column filled in each row, only empty rows count."""
        no_rise, no_fall = np.isnan(rising), np.isnan(falling)
        missing = [no_rise, no_fall]
        if rising.size == falling.size and np.all(no_rise | no_fall):
            missing = [no_rise & no_fall, np.zeros(falling.size, bool)]
        for k, (column, lacks) in enumerate(zip((rising, falling), missing, strict=True)):
            self.not_numbers += int(np.count_nonzero(np.isinf(column)))
            known = np.flatnonzero(~np.isnan(column))
            if known.size:
                self.not_numbers += self._empty[k] + int(np.count_nonzero(lacks[: known[-1]]))
                self._empty[k], lacks = 0, lacks[known[-1] :]
            self._empty[k] += int(np.count_nonzero(lacks))


@dataclass
class Debounce:
    """Takes out edges that follow another much sooner than the usual time between edges.

    Edges that close together are a cluster. Where polarities are known, an odd cluster is one edge that bounced (its
    mean time is taken) and an even one a glitch that left nothing behind; else a cluster is one edge.
    """

    shortest: float = SHORTEST
    doubled: int = 0
    _kept: Edges = field(default_factory=no_edges)
    _earlier: Array = field(default_factory=lambda: np.empty(0))
    """The last times between edges before those that are kept."""

    CONTEXT = 24

    @property
    def waiting_from(self) -> float:
        """The time of the first edge that waits; infinite where none does."""
        return float(self._kept.times[0] - 0.5 * self._kept.intervals[0]) if self._kept.times.size else np.inf

    def push(self, edges: Edges, *, last: bool = False) -> Edges:
        """The edges that are settled now; those near the end wait for the next portion, unless this is the `last`."""
        edges = join([self._kept, edges])
        n = edges.times.size
        if n < 3:
            self._kept = no_edges() if last else edges
            self._earlier = np.empty(0) if last else self._earlier
            return edges if last else no_edges()
        steps = np.diff(edges.times)
        known = np.concatenate([self._earlier, steps / edges.counts[1:]])
        usual = _usual(known)[self._earlier.size :]
        clusters = np.concatenate([[0], np.cumsum(steps >= self.shortest * usual)])
        end = n if last else int(np.searchsorted(clusters, clusters[max(n - self.CONTEXT, 0)]))
        self._kept = part(edges, slice(end, n))
        self._earlier = np.empty(0) if last else known[: known.size - (n - 1) + end][-NEIGHBOURS:]
        return self._merge(part(edges, slice(0, end)), clusters[:end])

    def _merge(self, edges: Edges, clusters: Chosen) -> Edges:
        if not edges.times.size:
            return edges
        first = np.flatnonzero(np.concatenate([[True], clusters[1:] != clusters[:-1]]))
        sizes = np.diff(np.concatenate([first, [edges.times.size]]))
        if np.all(sizes == 1):
            return edges
        known = edges.polarities[first] != 0.0
        ends = first + sizes - 1
        kept = ~known | (sizes % 2 == 1)
        bounced = known & (sizes > 1)
        times = np.where(bounced, 0.5 * (edges.times[first] + edges.times[ends]), edges.times[first])
        spread = np.where(bounced, edges.times[ends] - edges.times[first], 0.0)
        merged = Edges(
            times,
            np.fmax(edges.intervals[first], spread),
            edges.polarities[first],
            np.where(known, edges.counts[first], np.add.reduceat(edges.counts, first) - sizes + 1),
        )
        self.doubled += int(edges.times.size - np.count_nonzero(kept))
        return part(merged, kept)


def rank_filter(steps: Array, size: int, rank: int) -> Array:
    """Of each window of `size` neighbours the value with `rank` smaller ones: one for each window, from first to last.

    A window never reaches over the ends of the record, so that a single odd step there stays a single one.
    """
    from scipy.ndimage import rank_filter

    found: Array = rank_filter(steps, rank, size=size, mode="nearest")
    return found[size // 2 : steps.size - size + size // 2 + 1]


def _usual(steps: Array) -> Array:
    """The time between edges that is usual around each: the upper quartile of its neighbours, so that bounces at every
    edge do not pass for the rule. The lesser of those before and those after: long silences on one side, or a wheel
    that turns much slower there, are not the rule either."""
    if not steps.size:
        return steps
    size = min(NEIGHBOURS, steps.size)
    quartiles = rank_filter(steps, size, (3 * size) // 4)
    place = np.arange(steps.size)
    before, after = quartiles[np.fmax(place - size + 1, 0)], quartiles[np.fmin(place, quartiles.size - 1)]
    found: Array = np.fmin(before, after)
    return found
