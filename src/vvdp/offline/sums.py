"""What is added up while a record goes by."""

from dataclasses import dataclass, field

import numpy as np

from vvdp.base.arrays import Array
from vvdp.offline.alignment import Alignment
from vvdp.offline.edges import Chosen, CountEdges, StampEdges, WaveEdges
from vvdp.offline.hypotheses import Verdict
from vvdp.offline.noise_fit import Explained, LongestPieces, Noise, fit_noise
from vvdp.offline.offline_filter import FilteredRows, OfflineFilter
from vvdp.offline.record_check import Finding as Fault
from vvdp.sensing.wheel import TURN

PATTERN = 4096
"""Edges whose innovations are searched for a period."""
HISTOGRAM_END = 8.0
HISTOGRAM_BINS = 40
STANDING = 0.5
"""Probability from which on the wheel is said to stand still."""
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


@dataclass
class Sums:
    """Everything that is added up while a record goes by."""

    sectors: int
    sections: int
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
    rows: int = 0
    finder: WaveEdges | CountEdges | StampEdges | None = None
    verdict: Verdict | None = None
    """What the beginning of the record says of the wheel."""
    tick: float = 0.0
    """In which edge times are written [s], 0 where that does not matter."""
    speed: Moments = field(default_factory=Moments)
    pace: Moments = field(default_factory=Moments)
    """The speed, whichever way the wheel turns [rad/s]."""
    early_speed: Moments = field(default_factory=Moments)
    angle_deviation: Moments = field(default_factory=Moments)
    speed_deviation: Moments = field(default_factory=Moments)
    nis: Moments = field(default_factory=Moments)
    squared_innovation: Moments = field(default_factory=Moments)
    expected_square: Moments = field(default_factory=Moments)
    measured_variance: Moments = field(default_factory=Moments)
    """Of an edge's angle, as the filter takes it [rad^2]."""
    alternating: Moments = field(default_factory=Moments)
    duty_ratio: Moments = field(default_factory=Moments)
    pressure: Moments = field(default_factory=Moments)
    pressure_record: tuple[Fault, ...] = ()
    """What is wrong with the record of the pressure."""
    turned: float = 0.0
    pieces: int = 0
    missed: float = 0.0
    left_out: int = 0
    longest_bridged: float = 0.0
    alignments: list[Alignment] = field(default_factory=list)
    slow_passages: list[float] = field(default_factory=list)
    """When the wheel nearly stood still, and did not turn back as far as is known [s]."""
    reversals: list[float] = field(default_factory=list)
    """When it turned back [s]."""
    standing_rows: int = 0
    standstills: list[tuple[float, float]] = field(default_factory=list)
    """From when to when the wheel stood still [s]."""
    interruptions: list[str] = field(default_factory=list)
    """Where Ctrl-C ended a pass over the log."""

    def __post_init__(self) -> None:
        n = self.sectors
        self.bins = np.linspace(0.0, HISTOGRAM_END, HISTOGRAM_BINS + 1)
        self.histogram = np.zeros(HISTOGRAM_BINS)
        self._counts, self._totals, self._squares = np.zeros(n), np.zeros(n), np.zeros(n)
        self._pattern = np.full(PATTERN, np.nan)
        self._first_number: float | None = None
        self._longest = LongestPieces()
        self._explained: Explained | None = None
        self._fold_total, self._fold_count = np.zeros(ANGLES), np.zeros(ANGLES)
        self._fold_low, self._fold_high = np.full(ANGLES, np.inf), np.full(ANGLES, -np.inf)

    def add(self, tracked: FilteredRows) -> None:
        """Takes in rows and edges as they come from the filter."""
        rows, settled = tracked.rows, tracked.settled
        self.rows += int(np.count_nonzero(np.isfinite(rows["angle"])))
        self.speed.add(rows["speed"][settled])
        self.pace.add(np.abs(rows["speed"][settled]))
        self._add_standing(rows["time"], rows["standstill"] > STANDING)
        self.angle_deviation.add(rows["angle_deviation"][settled])
        self.speed_deviation.add(rows["speed_deviation"][settled])
        if not self.speed.count:
            self.early_speed.add(rows["speed"])
        if tracked.edges:
            self._add_edges(tracked.edges)

    def _add_standing(self, times: Array, standing: Chosen) -> None:
        self.standing_rows += int(np.count_nonzero(standing))
        bounds = np.flatnonzero(np.diff(np.concatenate([[0], standing.astype(int), [0]])))
        for first, end in zip(bounds[::2].tolist(), bounds[1::2].tolist(), strict=True):
            begin = float(times[first])
            if self.standstills and 0.0 < (begin - self.standstills[-1][1]) * self.rate < 1.5:
                begin, _ = self.standstills.pop()
            self.standstills.append((begin, float(times[end - 1])))

    @property
    def usual_speed(self) -> float:
        """The mean speed, whichever way the wheel turns [rad/s]; of everything where the filter never settles."""
        return self.pace.mean if self.pace.count else abs(self.early_speed.mean)

    def _add_edges(self, edges: dict[str, Array]) -> None:
        chosen = (edges["settled"] > 0.0) & np.isfinite(edges["innovation"])
        nu, number = edges["innovation"][chosen], edges["number"][chosen]
        normalised = edges["normalised_innovation"][chosen] ** 2
        if not nu.size:
            return
        self._longest.add(edges)
        self.nis.add(normalised)
        self.squared_innovation.add(nu**2)
        self.expected_square.add(edges["innovation_deviation"][chosen] ** 2)
        self.measured_variance.add(edges["variance"][chosen])
        self.histogram += np.histogram(np.clip(normalised, 0.0, HISTOGRAM_END * (1.0 - 1e-9)), self.bins)[0]
        polarity = edges["polarity"][chosen]
        self.alternating.add((polarity * nu)[polarity != 0.0])
        sector = edges["sector"][chosen].astype(int)
        self._counts += np.bincount(sector, minlength=self.sectors)
        self._totals += np.bincount(sector, nu, self.sectors)
        self._squares += np.bincount(sector, nu * nu, self.sectors)
        if self._first_number is None:
            self._first_number = float(number[0])
        place = np.abs(number - self._first_number)
        inside = (place >= 0) & (place < PATTERN)
        self._pattern[place[inside].astype(int)] = nu[inside]
        self.turned = abs(float(number[-1]) - self._first_number) / self.sectors

    def taken_from(self, tracker: OfflineFilter) -> None:
        """What the tracker has counted so far."""
        self.pieces, self.missed, self.left_out = tracker.pieces, tracker.missed_edges, tracker.left_out
        self.longest_bridged, self.alignments = tracker.longest_bridged, tracker.alignments
        self.slow_passages, self.reversals = tracker.slow_passages, tracker.reversals

    def duties(self, shares: Array) -> None:
        """Takes in the duty ratios of pulses of the pressure."""
        self.duty_ratio.add(shares)

    def pressures(self, values: Array, angles: Array) -> None:
        """Takes in samples of the pressure [Pa] and the angles within the turn [rad] they belong to."""
        self.pressure.add(values)
        known = np.isfinite(angles)
        place = np.clip((angles[known] * (ANGLES / TURN)).astype(int), 0, ANGLES - 1)
        self._fold_total += np.bincount(place, values[known], ANGLES)
        self._fold_count += np.bincount(place, minlength=ANGLES)
        np.minimum.at(self._fold_low, place, values[known])  # noqa: TID251 - in place
        np.maximum.at(self._fold_high, place, values[known])  # noqa: TID251

    @property
    def folded_mean(self) -> Array:
        """Mean in each part of the period, NaN where nothing fell."""
        found: Array = np.where(self._fold_count > 0, self._fold_total / np.fmax(self._fold_count, 1.0), np.nan)
        return found

    @property
    def folded_low(self) -> Array:
        """The lowest value in each part of the period, NaN where nothing fell."""
        found: Array = np.where(self._fold_count > 0, self._fold_low, np.nan)
        return found

    @property
    def folded_high(self) -> Array:
        """The highest value in each part of the period, NaN where nothing fell."""
        found: Array = np.where(self._fold_count > 0, self._fold_high, np.nan)
        return found

    @property
    def wheel_counts(self) -> Array:
        """Edges seen at each edge of the wheel."""
        return self._counts

    @property
    def offsets(self) -> Array:
        """By how much each edge of the wheel lies further on than the wheel has it [rad], mean of all zero."""
        means = np.where(self._counts > 0, -self._totals / np.fmax(self._counts, 1.0), np.nan)
        found: Array = means - (np.nanmean(means) if np.isfinite(means).any() else 0.0)
        return found

    @property
    def offset_deviations(self) -> Array:
        """Standard errors of the offsets [rad]."""
        counts = np.fmax(self._counts, 1.0)
        spread = np.fmax(self._squares / counts - (self._totals / counts) ** 2, 0.0)
        found: Array = np.where(self._counts > 1, np.sqrt(spread / counts), np.nan)
        return found

    def noise_fit(self, used: Noise) -> Explained | None:
        """What the longest pieces are best explained by, with the settings in use; None where they are too short. To be
        asked when all has gone by: it is worked out once."""
        if self._explained is None and (passed := self._longest.pick(used.edge_variance)) is not None:
            self._explained = fit_noise(passed, self.sectors, used, self.sections)
        return self._explained

    def period_of_pattern(self, hidden_variance: float) -> tuple[int, float, float] | None:
        """The number of edges after which the innovations repeat, where that is not the wheel's: with the correlation
        there, and that after as many edges as the wheel has. None where nothing speaks against the wheel, or the
        pattern is no larger than what sampling makes of itself, which repeats too (`hidden_variance` [rad^2])."""
        x = self._pattern - (np.nanmean(self._pattern) if np.isfinite(self._pattern).any() else 0.0)
        whole = float(np.nanmean(x * x)) if np.isfinite(x).any() else 0.0
        if not whole > 0.0:
            return None
        lags = range(2, min(4 * self.sectors, 256) + 1)
        found = {lag: correlated for lag in lags if (correlated := _correlation(x, lag, whole)) is not None}
        if self.sectors not in found:
            return None
        most = max(found.values())
        own = found[self.sectors]
        plain = (0.01 * TURN / self.sectors) ** 2 + 2.0 * hidden_variance
        if most < 0.3 or own > most - 0.2 or most * whole < plain:
            return None
        first = min(lag for lag, correlated in found.items() if correlated > most - 0.1)
        return first, found[first], own


def _correlation(x: Array, lag: int, whole: float) -> float | None:
    products = x[lag:] * x[:-lag]
    known: Chosen = np.isfinite(products)
    return float(np.mean(products[known])) / whole if np.count_nonzero(known) >= 8 * lag else None
