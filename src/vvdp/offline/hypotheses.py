"""Whether the edges at the beginning of a record are those of the wheel as it was described.

They may be those of half or twice as many sectors, or of one kind only; the wave may be inverted, the wheel may turn
backwards, its index may not be there. Each hypothesis says at which angles the edges passed. A constant-speed Kalman
filter makes the angles' errors white, and the hypothesis that leaves least of them is the likeliest. Derived in
docs/logs.md.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.offline.alignment import CLEARLY, gap_in_sectors, sectors_passed, usual_steps
from vvdp.offline.edges import Edges, part
from vvdp.offline.likelihood import Likelihood, fit
from vvdp.offline.passage import Noise
from vvdp.offline.passed_edges import Passed
from vvdp.offline.pattern_fit import CLEAR, MOST_PLACES
from vvdp.sensing.wheel import TURN, CodeWheel, equal_wheel

TURNS = 16
"""Turns of the wheel that are looked at, at most ..."""
FEWEST_TURNS = 3
"""... and at least, of the wheel of each hypothesis."""
LOOKED_AT = 2048
"""Edges that are looked at, at most."""
WINDOWS = 4
"""The steadiest of so many stretches at the beginning is taken."""
FAR_NEIGHBOURS = 48
"""So many times between edges say what is usual, so that half of them may be missing."""
PAUSE = 8.0
"""Times between edges of so many usual ones end a stretch."""


class Sectors(Enum):
    """How many edges pass in a turn: as described, or one of these."""

    AS_TOLD = "as given"
    HALF = "half"
    ONE_KIND = "one kind only"
    DOUBLE = "double"


class Hypothesis(NamedTuple):
    """What the edges of a log may be: angles of those that pass in a turn forward [rad], the first 0, and what is
    exchanged; an even wheel has no index."""

    sectors: Sectors
    edges: tuple[float, ...]
    has_index: bool
    polarity: float
    direction: float

    @property
    def departures(self) -> int:
        """In how many ways it differs from what was described."""
        return (self.sectors is not Sectors.AS_TOLD) + (self.polarity < 0.0) + (self.direction < 0.0)


class Verdict(NamedTuple):
    """What the beginning of a record says of the wheel.

    `likeliest` is what is to be assumed in place of the wheel that was `described`, likelier by `gain` (logarithm of
    the ratio); `index_shows` whether its index does, None where it has none or nothing is clear. `polarity` (1 as
    logged, -1 inverted) and `direction` (1, -1) are NaN where they cannot be determined.
    """

    described: CodeWheel
    likeliest: Hypothesis
    index_shows: bool | None = None
    polarity: float = np.nan
    direction: float = np.nan
    gain: float = 0.0

    @property
    def wheel(self) -> CodeWheel:
        """The wheel to go by: the likeliest, but where edges of one kind are odd in number, which no wheel can have."""
        edges = self.likeliest.edges
        return self.described if len(edges) % 2 else CodeWheel(edges)


class _Scored(NamedTuple):
    """A hypothesis with the squares that it leaves of the whitened angles, the best first edge taken."""

    hypothesis: Hypothesis
    offsets: Array
    squares: float
    cost: float


def judge(edges: Edges, wheel: CodeWheel) -> Verdict:
    """What the edges at the beginning of a record say of a wheel; nothing of one without an index.

    Source  ours, docs/logs.md
    """
    told = Hypothesis(Sectors.AS_TOLD, wheel.edges, True, 1.0, 1.0)
    if not wheel.has_index or len(wheel.edges) == 2:
        return Verdict(wheel, told._replace(has_index=wheel.has_index))
    record = _Record.of(steadiest(edges, len(wheel.edges)), wheel)
    if record is None:
        return Verdict(wheel, told)
    return record.verdict(tuple(hypotheses(wheel, polarity_known=record.parity != 0.0)), wheel)


def hypotheses(wheel: CodeWheel, *, polarity_known: bool) -> Iterator[Hypothesis]:
    """What is tried: the wheel as given, first; numbers of sectors, wave upright or inverted (where the log has
    polarities), both directions; the index not there."""
    for sectors, described in _wheels(wheel, polarity_known=polarity_known):
        for direction in (1.0, -1.0):
            for polarity in (1.0, -1.0) if polarity_known else (1.0,):
                yield Hypothesis(sectors, described, True, polarity, direction)
    yield Hypothesis(Sectors.AS_TOLD, equal_wheel(len(wheel.edges)).edges, False, 1.0, 1.0)


def _wheels(wheel: CodeWheel, *, polarity_known: bool) -> Iterator[tuple[Sectors, tuple[float, ...]]]:
    n = len(wheel.edges)
    yield Sectors.AS_TOLD, wheel.edges
    shift = float(np.clip(wheel.edges[1] * n / TURN - 1.0, -0.9, 0.9))
    if np.allclose(equal_wheel(n, shift).edges, wheel.edges):
        if n % 4 == 0:
            yield Sectors.HALF, equal_wheel(n // 2, shift).edges
        yield Sectors.DOUBLE, equal_wheel(2 * n, shift).edges
    for first in (0, 1) if not polarity_known and n > 2 else ():
        kind = np.array(wheel.edges)[first::2]
        if not np.allclose(np.diff(kind), TURN / kind.size):
            yield Sectors.ONE_KIND, tuple((kind - kind[0]).tolist())


def steadiest(edges: Edges, sectors: int) -> Edges:
    """A stretch of up to `TURNS` turns of a wheel twice as fine, without pauses: the first, unless the speed is much
    steadier further on."""
    size = min(2 * TURNS * sectors, LOOKED_AT)
    if edges.times.size < 3:
        return edges
    usual = usual_steps(np.diff(edges.times) / edges.counts[1:])
    pauses = np.flatnonzero(np.diff(edges.times) > PAUSE * usual * edges.counts[1:]) + 1
    ends = [0, *pauses.tolist(), edges.times.size]
    longest = max(end - begin for begin, end in pairwise(ends))
    first, last = next(each for each in pairwise(ends) if each[1] - each[0] >= min(size, 0.5 * longest))
    begins = sorted({*np.linspace(first, max(last - size, first), WINDOWS).astype(int).tolist()})
    spreads = [float(np.std(np.log(np.fmax(usual[i : min(i + size, last) - 1], 1e-300)))) for i in begins]
    chosen = begins[0] if spreads[0] < 2.0 * min(spreads) + 0.02 else begins[int(np.argmin(spreads))]
    return part(edges, slice(chosen, min(chosen + size, last)))


@dataclass(frozen=True)
class _Record:
    """A stretch of edges that are numbered by how many sectors passed, on a wheel of `sectors`."""

    times: Array
    numbers: Array
    intervals: Array
    parity: float
    """Polarity of the edge numbered 0; 0: unknown."""
    sectors: int

    @classmethod
    def of(cls, edges: Edges, wheel: CodeWheel) -> "_Record | None":
        """The stretch; None where it is too short."""
        sectors, gap = len(wheel.edges), gap_in_sectors(wheel)
        ahead = np.concatenate([[True], np.diff(edges.times) > 0.0])
        if edges.times.size < 3:
            return None
        numbers = np.concatenate([[0.0], np.cumsum(sectors_passed(edges, gap, FAR_NEIGHBOURS))])[ahead]
        if numbers.size < 2 * sectors or sectors > MOST_PLACES or numbers[-1] < FEWEST_TURNS * sectors:
            return None
        known = edges.polarities != 0.0
        parity = float(edges.polarities[0]) if known.all() else 0.0
        return cls(edges.times[ahead], numbers, edges.intervals[ahead], parity, sectors)

    def likelihood(self, period: int) -> Likelihood:
        """That of the edges on an even wheel with `period` of them in a turn."""
        pitch = TURN / period
        rate = pitch * self.numbers[-1] / (self.times[-1] - self.times[0])
        sampled = (rate * self.intervals) ** 2 / 12.0
        still = np.zeros(self.times.size)
        return Likelihood(Passed(self.times, self.numbers, self.numbers * pitch, sampled, still), period)

    def verdict(self, tried: tuple[Hypothesis, ...], described: CodeWheel) -> Verdict:
        """The likeliest of the hypotheses, unless it is not clearly likelier than the first, the given one."""
        scored, _ = self.score(tried, fit(self.likelihood(self.sectors)).noise)
        best = min(scored, key=lambda each: each.squares)
        period = len(best.offsets)
        refined = fit(self.likelihood(period).without(best.offsets)).noise
        scored, floor = self.score(tried, _rescale(refined, period, self.sectors))

        def clearly(one: _Scored, other: _Scored) -> bool:
            squares = one.squares - floor < CLEARLY * (other.squares - floor)
            return squares and other.cost - one.cost > CLEAR

        told = scored[0]
        even = scored[-1]
        likely = [each for each in sorted(scored, key=lambda each: each.cost)
                  if each is told or (clearly(each, told) and (each is even or clearly(each, even)))]  # fmt: skip
        chosen = likely[0]
        shows = chosen is not even and clearly(chosen, even)

        def as_told_by(name: str) -> float:
            own = getattr(chosen.hypothesis, name)
            others = [each for each in scored[:-1] if getattr(each.hypothesis, name) != own]
            return own if shows and others and all(clearly(chosen, each) for each in others) else np.nan

        return Verdict(
            described=described,
            likeliest=chosen.hypothesis,
            index_shows=True if shows else (False if chosen is even else None),
            polarity=as_told_by("polarity"),
            direction=as_told_by("direction"),
            gain=told.cost - chosen.cost,
        )

    def score(self, tried: tuple[Hypothesis, ...], noise: Noise) -> tuple[list[_Scored], float]:
        """The squares that each hypothesis leaves, with a noise stated for the wheel of `sectors`, and those that are
        left where each edge may lie anywhere."""
        found: dict[Hypothesis, _Scored] = {}
        floor = np.inf
        for period in sorted({len(each.edges) for each in tried}):
            beyond = period > MOST_PLACES or self.numbers[-1] < FEWEST_TURNS * period or self.times.size < 2 * period
            if beyond and period != self.sectors:
                continue
            nu, responses = self.likelihood(period).white(_rescale(noise, self.sectors, period), period)
            free = responses[:, 1:]
            anywhere = np.linalg.lstsq(free.T @ free, -free.T @ nu, rcond=1e-10)[0]
            floor = min(floor, float(np.sum((nu + free @ anywhere) ** 2)))
            for each in tried:
                if len(each.edges) == period:
                    offsets = np.column_stack(list(self.offsets(each)))
                    squares = np.sum((nu[:, None] + responses @ offsets) ** 2, axis=0)
                    best = int(np.argmin(squares))
                    left = float(squares[best])
                    found[each] = _Scored(each, offsets[:, best], left, _cost(each, left, self.times.size))
        return [found[each] for each in tried if each in found], floor

    def offsets(self, hypothesis: Hypothesis) -> Iterator[Array]:
        """How much further on than on an even wheel the edges numbered 0, 1, ... of the record lie, for each first
        edge that is possible [rad]."""
        edges = np.array(hypothesis.edges)
        if hypothesis.direction < 0.0:
            edges = np.concatenate([[0.0], TURN - edges[:0:-1]])
        own = edges - np.arange(edges.size) * TURN / edges.size
        # Met backwards, rising edges fall.
        sign = self.parity * hypothesis.polarity * hypothesis.direction
        begin, step = (0, 1) if sign == 0.0 else ((0, 2) if sign > 0.0 else (1, 2))
        for first in range(begin, edges.size, step) if hypothesis.has_index else (0,):
            yield np.roll(own, -first)


def _rescale(noise: Noise, period: int, sectors: int) -> Noise:
    """The noise of a wheel with `period` edges, stated for one with `sectors`."""
    scale = (period / sectors) ** 2
    return Noise(scale * noise.acceleration_density, scale * noise.edge_variance)


def _cost(hypothesis: Hypothesis, squares: float, edges: int) -> float:
    """Minus the logarithm of the likelihood, the scale of the noise the likeliest, and Schwarz's price, ln(n)/2, of the
    first edge and of each departure."""
    chosen = hypothesis.has_index + hypothesis.departures
    return 0.5 * edges * float(np.log(max(squares, 1e-300))) + 0.5 * chosen * float(np.log(edges))
