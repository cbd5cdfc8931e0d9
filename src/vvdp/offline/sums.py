"""Results of a record: what is counted while it goes by, and what its rows and edges add up to on disk."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.offline.alignment import Alignment
from vvdp.offline.edges import Chosen, CountEdges, StampEdges, WaveEdges
from vvdp.offline.estimate_result import portions
from vvdp.offline.hypotheses import Verdict
from vvdp.offline.lost_sensor import Silence
from vvdp.offline.noise_fit import Explained
from vvdp.offline.record_check import Finding as Fault
from vvdp.offline.speed_doubt import NO_DOUBT, Doubt
from vvdp.sensing.wheel import TURN

PATTERN = 4096
"""Edges whose innovations are searched for a period."""
HISTOGRAM_END = 8.0
BINS = np.linspace(0.0, HISTOGRAM_END, 41)
"""Bounds of the histogram of squared normalised innovations."""
NAMED_TIMES = 5
"""So many of the edges that were left out are named."""
STANDING = 0.5
"""Probability from which on the wheel is stated to stand still."""
ANGLES = 360
"""Bins of a turn in which the pressure is collected."""


@dataclass
class Moments:
    """Count, mean, deviation and extremes of values that come in portions."""

    count: int = 0
    mean: float = np.nan
    squares: float = 0.0
    low: float = np.inf
    high: float = -np.inf

    def add(self, values: Array) -> None:
        """Takes in `values`; those that are not finite are left out."""
        values = values[np.isfinite(values)]
        if not values.size:
            return
        n, mean = values.size, float(np.mean(values))
        squares = float(np.sum((values - mean) ** 2))
        if not self.count:
            self.mean = mean
        shift, total = mean - self.mean, self.count + n
        self.squares += squares + shift * shift * self.count * n / total
        self.mean += shift * n / total
        self.count = total
        self.low, self.high = min(self.low, float(np.min(values))), max(self.high, float(np.max(values)))

    @property
    def deviation(self) -> float:
        """Root mean square, NaN of nothing."""
        return float(np.sqrt(self.squares / self.count)) if self.count else np.nan

    @property
    def standard_error(self) -> float:
        """Of the mean."""
        return self.deviation / float(np.sqrt(self.count)) if self.count else np.inf


@dataclass
class Fold:
    """Values over the angle within the turn: count, total and extremes in each of its parts."""

    counts: Array = field(default_factory=lambda: np.zeros(ANGLES))
    totals: Array = field(default_factory=lambda: np.zeros(ANGLES))
    lowest: Array = field(default_factory=lambda: np.full(ANGLES, np.nan))
    highest: Array = field(default_factory=lambda: np.full(ANGLES, np.nan))

    def add(self, values: Array, angles: Array) -> None:
        """Takes in `values` and the angles within the turn [rad] they belong to, NaN where that is unknown."""
        known = np.isfinite(angles)
        place, values = np.clip((angles[known] * (ANGLES / TURN)).astype(int), 0, ANGLES - 1), values[known]
        self.totals += np.bincount(place, values, ANGLES)
        self.counts += np.bincount(place, minlength=ANGLES)
        np.fmin.at(self.lowest, place, values)
        np.fmax.at(self.highest, place, values)

    @property
    def mean(self) -> Array:
        """Mean in each part, NaN where nothing fell."""
        found: Array = np.where(self.counts > 0, self.totals / np.fmax(self.counts, 1.0), np.nan)
        return found


@dataclass
class Tally:
    """What is counted of a record while it goes by."""

    sectors: int
    samples: int = 0
    not_numbers: int = 0
    gaps: int = 0
    longest_gap: float = 0.0
    backward: int = 0
    measured: float = 0.0
    """Time that the record covers [s], summed over its clocks."""
    begin: float = np.inf
    end: float = -np.inf
    period: float = 0.0
    rate: float = 0.0
    edges: float = 0.0
    doubled: int = 0
    finder: WaveEdges | CountEdges | StampEdges | None = None
    verdict: Verdict | None = None
    """What the beginning of the record says of the wheel."""
    tick: float = 0.0
    """In which edge times are written [s], 0 where that does not matter."""
    pieces: int = 0
    missed: float = 0.0
    left_out: int = 0
    """Edges of pieces that were too short."""
    left_out_times: list[float] = field(default_factory=list)
    """When the first of them were [s]."""
    alignments: list[Alignment] = field(default_factory=list)
    slow_passages: list[float] = field(default_factory=list)
    """When the wheel nearly stood still, and did not turn back as far as is known [s]."""
    reversals: list[float] = field(default_factory=list)
    """When it turned back [s]."""
    duty_ratio: Moments = field(default_factory=Moments)
    pressure: Moments = field(default_factory=Moments)
    fold: Fold = field(default_factory=Fold)
    """Of the pressure [Pa]."""
    pressure_record: tuple[Fault, ...] = ()
    """What is wrong with the record of the pressure."""
    interruptions: list[str] = field(default_factory=list)
    """Where Ctrl-C ended a pass over the log."""

    def leave_out(self, times: Array) -> None:
        """Counts edges at these times [s], which are too few for a piece."""
        self.left_out += times.size
        self.left_out_times = (self.left_out_times + times[:NAMED_TIMES].tolist())[:NAMED_TIMES]


@dataclass
class RowSums:
    """What the rows of a result add up to; means and extremes are over those that are settled."""

    count: int = 0
    """Rows with an estimate."""
    speed: Moments = field(default_factory=Moments)
    pace: Moments = field(default_factory=Moments)
    """The speed, whichever way the wheel turns [rad/s]."""
    every_speed: Moments = field(default_factory=Moments)
    """Of all rows; empty where some are settled."""
    angle_deviation: Moments = field(default_factory=Moments)
    speed_deviation: Moments = field(default_factory=Moments)
    standing: int = 0
    """Rows in which the wheel stands still."""
    standstills: list[tuple[float, float]] = field(default_factory=list)
    """From when to when it does [s]."""

    @property
    def usual_speed(self) -> float:
        """The mean speed, whichever way the wheel turns [rad/s]; of everything where the filter never settles."""
        return self.pace.mean if self.pace.count else abs(self.every_speed.mean)


def has_rows(file: Any) -> bool:
    """Whether result.h5 has a row with an estimate."""
    return any(bool(np.any(np.isfinite(speed))) for (speed,) in portions(file, "", "speed"))


def standstills(file: Any, rate: float) -> list[tuple[float, float]]:
    """From when to when the wheel stands still by result.h5 with `rate` [Hz] of rows [s]."""
    found: list[tuple[float, float]] = []
    begin = 0
    for (standstill,) in portions(file, "", "standstill"):
        if np.any(standing := standstill > STANDING):
            _add_standstills(found, file["time"][begin : begin + standing.size], standing, rate)
        begin += standstill.size
    return found


def row_sums(file: Any, rate: float) -> RowSums:
    """What the rows of result.h5, `rate` [Hz] of them, add up to."""
    sums = RowSums()
    for speed, settled, angle_deviation, speed_deviation, standstill in portions(
        file, "", "speed", "settled", "angle_deviation", "speed_deviation", "standstill"
    ):
        sums.count += int(np.count_nonzero(np.isfinite(speed)))
        told = settled > 0.0
        sums.speed.add(speed[told])
        sums.pace.add(np.abs(speed[told]))
        sums.angle_deviation.add(angle_deviation[told])
        sums.speed_deviation.add(speed_deviation[told])
        sums.standing += int(np.count_nonzero(standstill > STANDING))
    for (speed,) in portions(file, "", "speed") if not sums.speed.count else ():
        sums.every_speed.add(speed)
    sums.standstills = standstills(file, rate) if sums.standing else []
    return sums


def _add_standstills(found: list[tuple[float, float]], times: Array, standing: Chosen, rate: float) -> None:
    first, last = np.flatnonzero(np.diff(standing, prepend=False, append=False)).reshape(-1, 2).T
    for begin, end in zip(times[first].tolist(), times[last - 1].tolist(), strict=True):
        if found and 0.0 < (begin - found[-1][1]) * rate < 1.5:
            begin, _ = found.pop()
        found.append((begin, end))


@dataclass
class EdgeSums:
    """What the edges of a result add up to, those that are settled and were used, for each edge of the wheel and in
    all."""

    counts: Array
    totals: Array
    squares: Array
    nis: Moments = field(default_factory=Moments)
    histogram: Array = field(default_factory=lambda: np.zeros(BINS.size - 1))
    measured_variance: Moments = field(default_factory=Moments)
    """Of an edge's angle, as the filter takes it [rad^2]."""
    alternating: Moments = field(default_factory=Moments)
    pattern: Array = field(default_factory=lambda: np.full(PATTERN, np.nan))
    """Innovations of the first edges [rad]."""

    @property
    def offsets(self) -> Array:
        """By how much each edge of the wheel lies further on than the wheel has it [rad], mean of all zero."""
        means = np.where(self.counts > 0, -self.totals / np.fmax(self.counts, 1.0), np.nan)
        found: Array = means - (np.nanmean(means) if np.isfinite(means).any() else 0.0)
        return found

    @property
    def offset_deviations(self) -> Array:
        """Standard errors of the offsets [rad]."""
        counts = np.fmax(self.counts, 1.0)
        spread = np.fmax(self.squares / counts - (self.totals / counts) ** 2, 0.0)
        found: Array = np.where(self.counts > 1, np.sqrt(spread / counts), np.nan)
        return found


def edge_sums(file: Any, sectors: int) -> EdgeSums:
    """What the edges of result.h5 add up to, on a wheel with so many `sectors`."""
    sums, first = EdgeSums(counts=np.zeros(sectors), totals=np.zeros(sectors), squares=np.zeros(sectors)), np.nan
    names = ("settled", "innovation", "normalised_innovation", "variance", "polarity", "sector", "number")
    for settled, innovation, *others in portions(file, "edges/", *names):
        chosen = (settled > 0.0) & np.isfinite(innovation)
        if not chosen.any():
            continue
        nu = innovation[chosen]
        normalised, variance, polarity, sector, number = (column[chosen] for column in others)
        sums.nis.add(normalised**2)
        sums.histogram += np.histogram(np.clip(normalised**2, 0.0, HISTOGRAM_END * (1.0 - 1e-9)), BINS)[0]
        sums.measured_variance.add(variance)
        sums.alternating.add((polarity * nu)[polarity != 0.0])
        sums.counts += np.bincount(sector.astype(int), minlength=sectors)
        sums.totals += np.bincount(sector.astype(int), nu, sectors)
        sums.squares += np.bincount(sector.astype(int), nu * nu, sectors)
        first = float(number[0]) if np.isnan(first) else first
        place = np.abs(number - first).astype(int)
        sums.pattern[place[place < PATTERN]] = nu[place < PATTERN]
    return sums


@dataclass(frozen=True)
class Sums:
    """All that a record comes to."""

    tally: Tally
    rows: RowSums
    edges: EdgeSums
    explained: Explained | None
    """What its longest pieces are best explained by; None where they are too short."""
    doubt: Doubt = NO_DOUBT
    """What the deviations of its rows have beside those of the filter."""
    silences: tuple[Silence, ...] = ()
    """Those in which the sensor may have been lost."""

    @property
    def lost_sensors(self) -> list[Silence]:
        """Silences in which it was, as far as can be determined."""
        return [each for each in self.silences if each.is_lost]


def repeats_after(sums: Sums, hidden_variance: float) -> tuple[int, float, float] | None:
    """The number of edges after which the innovations repeat, where that is not the wheel's: with the correlation
    there, and that after as many edges as the wheel has. None where nothing speaks against the wheel, or the pattern is
    no larger than what sampling makes of itself, which repeats too (`hidden_variance` [rad^2])."""
    pattern, sectors = sums.edges.pattern, sums.tally.sectors
    x = pattern - (np.nanmean(pattern) if np.isfinite(pattern).any() else 0.0)
    whole = float(np.nanmean(x * x)) if np.isfinite(x).any() else 0.0
    if not whole > 0.0:
        return None
    lags = range(2, min(4 * sectors, 256) + 1)
    found = {lag: correlated for lag in lags if (correlated := _correlation(x, lag, whole)) is not None}
    if sectors not in found:
        return None
    most, own = max(found.values()), found[sectors]
    plain = (0.01 * TURN / sectors) ** 2 + 2.0 * hidden_variance
    if most < 0.3 or own > most - 0.2 or most * whole < plain:
        return None
    first = min(lag for lag, correlated in found.items() if correlated > most - 0.1)
    return first, found[first], own


def _correlation(x: Array, lag: int, whole: float) -> float | None:
    products = x[lag:] * x[:-lag]
    known = np.isfinite(products)
    return float(np.mean(products[known])) / whole if np.count_nonzero(known) >= 8 * lag else None
