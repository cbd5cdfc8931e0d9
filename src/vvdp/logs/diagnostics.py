"""Statistics, summary and warnings of a record."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import with_unit
from vvdp.base.kinds import ANGLE, SPEED
from vvdp.estimation.commensurate import Commensurate, commensurate_clock, commensurate_warning, hidden_angle
from vvdp.logs.alignment import Alignment
from vvdp.logs.channel import Log
from vvdp.logs.clock import is_time_name
from vvdp.logs.config import Counts, Estimation, Stamps, Wave
from vvdp.logs.edges import GAP, Chosen, CountEdges, StampEdges, WaveEdges
from vvdp.logs.guess import channels_of_edges
from vvdp.logs.noise_fit import CLEAR, Explained, LongestPieces, Noise, fit_noise
from vvdp.logs.offline_filter import FilteredRows, OfflineFilter, bridged_time
from vvdp.results.result import Finding, Grade
from vvdp.sensing.wheel import TURN

PATTERN = 4096
"""Edges whose innovations are searched for a period."""
SURE = 4.0
"""A mean is said to differ from zero beyond so many standard errors."""
SHARE_OF_SECTOR = 0.02
"""Offsets of edges below this share of a sector are not worth a word."""
SHARE_MISSED = 0.1
SHARE_FAR = 5e-3
"""Of all edges. With more missed, and more beyond four deviations of the likeliest settings, numbers are in doubt."""
SLOWEST, FASTEST = TURN * 0.2, TURN * 200.0
"""Mean speeds outside of these [rad/s] suggest a wrong unit or number of sectors."""
LEVEL_DRIFT = 0.1
FEW_SAMPLES = 3.0
HISTOGRAM_END = 8.0
HISTOGRAM_BINS = 40
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
    speed: Moments = field(default_factory=Moments)
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
    turned: float = 0.0
    pieces: int = 0
    missed: float = 0.0
    left_out: int = 0
    longest_bridged: float = 0.0
    alignments: list[Alignment] = field(default_factory=list)
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
        self.angle_deviation.add(rows["angle_deviation"][settled])
        self.speed_deviation.add(rows["speed_deviation"][settled])
        if not self.speed.count:
            self.early_speed.add(rows["speed"])
        if tracked.edges:
            self._add_edges(tracked.edges)

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
        place = number - self._first_number
        inside = (place >= 0) & (place < PATTERN)
        self._pattern[place[inside].astype(int)] = nu[inside]
        self.turned = (float(number[-1]) - self._first_number) / self.sectors

    def taken_from(self, tracker: OfflineFilter) -> None:
        """What the tracker has counted so far."""
        self.pieces, self.missed, self.left_out = tracker.pieces, tracker.missed_edges, tracker.left_out
        self.longest_bridged, self.alignments = tracker.longest_bridged, tracker.alignments

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


def summary(sums: Sums, wanted: Estimation) -> dict[str, Any]:
    """The numbers of docs/keys.md, `vvdp estimate`, as far as the estimation has them."""
    speed = sums.speed if sums.speed.count else sums.early_speed
    low, high = nis_band(sums.nis.count)
    found: dict[str, Any] = {
        "duration_s": sums.measured,
        "samples": sums.samples,
        "sample_rate_Hz": 1.0 / sums.period if sums.period else np.nan,
        "output_rate_Hz": sums.rate,
        "sectors": sums.sectors,
        "edges": int(sums.edges),
        "missed_edges": int(sums.missed),
        "double_edges": sums.doubled,
        "gaps": sums.gaps,
        "not_numbers": sums.not_numbers,
        "backward_times": sums.backward,
        "pieces": sums.pieces,
        "spool_speed_mean_rad_s": speed.mean,
        "spool_speed_std_rad_s": speed.deviation,
        "spool_speed_min_rad_s": speed.low,
        "spool_speed_max_rad_s": speed.high,
        "settled": sums.speed.count > 0,
        "pwm_frequency_mean_Hz": speed.mean * wanted.sections / TURN,
        "angle_deviation_mean_rad": sums.angle_deviation.mean,
        "speed_deviation_mean_rad_s": sums.speed_deviation.mean,
        "nis_mean": sums.nis.mean,
        "nis_edges": sums.nis.count,
        "nis_low": low,
        "nis_high": high,
        "index_found": index_found(sums, wanted) if wanted.wheel.has_index else None,
        "commensurate": in_step(sums, wanted) is not None,
        "edge_offset_max_rad": _largest(sums.offsets),
        **_settings(sums, wanted),
    }
    if isinstance(sums.finder, WaveEdges):
        finder = sums.finder
        swing = finder.plateaus.swing if finder.plateaus is not None else np.nan
        suggested = suggested_level(sums, wanted)
        found |= {
            "threshold": float(np.mean(finder.levels)) if finder.levels else finder.level,
            "wave_swing": swing,
            "wave_noise": finder.plateaus.noise if finder.plateaus is not None else np.nan,
            "threshold_bias_rad": -sums.alternating.mean,
            "threshold_suggested": suggested,
        }
    elif isinstance(wanted.source, Stamps) and wanted.source.falling:
        found["threshold_bias_rad"] = -sums.alternating.mean
    if wanted.pressure is not None:
        found |= {
            "duty_ratio_mean": sums.duty_ratio.mean,
            "duty_ratio_std": sums.duty_ratio.deviation,
            "pressure_pulses": sums.duty_ratio.count,
            "inlet_pressure_mean_Pa": sums.pressure.mean,
            "inlet_pressure_min_Pa": sums.pressure.low if sums.pressure.count else np.nan,
            "inlet_pressure_max_Pa": sums.pressure.high if sums.pressure.count else np.nan,
        }
    return found


def _settings(sums: Sums, wanted: Estimation) -> dict[str, Any]:
    """The settings of the filter, and those that would fit better."""
    used = settings_of(wanted)
    found = {"acceleration_density_rad2_s3": used.acceleration_density, "edge_variance_rad2": used.edge_variance}
    told = sums.noise_fit(used)
    known = told is not None and not numbers_in_doubt(told, sums, wanted)
    return found | {
        "acceleration_density_fitted_rad2_s3": told.advised.acceleration_density
        if told is not None and known
        else np.nan,
        "edge_variance_fitted_rad2": told.advised.edge_variance if told is not None and known else np.nan,
        "likelihood_gain": told.settings_gain if told is not None and known else np.nan,
        "settings_fit": not told.matters if told is not None and known else None,
    }


def numbers_in_doubt(told: Explained, sums: Sums, wanted: Estimation) -> bool:
    """Whether edges have wrong numbers: the index was not found, or many were missed and others lie far off."""
    if wanted.wheel.has_index and not index_found(sums, wanted):
        return True
    return sums.missed > SHARE_MISSED * (sums.edges + sums.missed) and told.outliers > SHARE_FAR


def settings_of(wanted: Estimation) -> Noise:
    """What the filter of an estimation takes the noise to be."""
    return Noise(wanted.filter.acceleration_density, wanted.filter.edge_variance)


def index_found(sums: Sums, wanted: Estimation) -> bool:
    """Whether every piece agrees with the index of the wheel, and it explains the edges better than an even wheel."""
    if not all(a.index_found for a in sums.alignments):
        return False
    told = sums.noise_fit(settings_of(wanted))
    return told is None or told.index_gain > CLEAR


def nis_band(count: int) -> tuple[float, float]:
    """Where the mean of `count` squared normalised innovations lies with a chance of 95 % if the settings fit."""
    if not count:
        return np.nan, np.nan
    from scipy.stats import chi2

    return float(chi2.ppf(0.025, count)) / count, float(chi2.ppf(0.975, count)) / count


def _largest(values: Array) -> float:
    return float(np.nanmax(np.abs(values))) if np.isfinite(values).any() else np.nan


def in_step(sums: Sums, wanted: Estimation) -> Commensurate | None:
    """How edges that are only sampled are commensurate with the sampling, if they are."""
    sampled = isinstance(wanted.source, Counts) or (
        isinstance(wanted.source, Wave) and not wanted.source.comparator.interpolated
    )
    speed = sums.speed.mean
    if not sampled or not sums.period or not np.isfinite(speed) or speed <= 0.0:
        return None
    return commensurate_clock(speed * sums.sectors / TURN, 1.0 / sums.period)


def suggested_level(sums: Sums, wanted: Estimation) -> float:
    """The threshold at which rising and falling edges would agree, in the unit of the channel; NaN if unknown, if it is
    outside of the swing, or if edges of the wheel lie elsewhere for another reason.

    A threshold too high by e sees rising edges late and falling ones early by the angle e/(dv/dtheta), with the slope
    dv/dtheta = (dv/dt)/omega at the crossings; s nu has that mean with the opposite sign.
    """
    finder = sums.finder
    speed = sums.speed.mean
    if not isinstance(finder, WaveEdges) or not finder.found or not finder.levels or not sums.alternating.count:
        return np.nan
    slope = finder.slopes / finder.found / speed
    sign = -1.0 if finder.comparator.inverted else 1.0
    level = float(np.mean(finder.levels)) + sign * sums.alternating.mean * slope
    elsewhere = _worst(sums, _beside_alternation(sums)) is not None
    if elsewhere or (wanted.wheel.has_index and not index_found(sums, wanted)):
        return np.nan
    inside = finder.plateaus is None or finder.plateaus.low < level < finder.plateaus.high
    return level if inside else np.nan


def findings(found: dict[str, Any], sums: Sums, wanted: Estimation, log: Log) -> tuple[Finding, ...]:
    """What is wrong with the record or in doubt, gravest first."""
    best = sums.noise_fit(settings_of(wanted))
    clock = list(_of_the_clock(best, wanted, log)) if best is not None else []
    told = [
        *clock,
        *_of_the_course(found, sums, wanted),
        *_of_the_record(sums, wanted),
        *_of_the_source(sums, wanted),
    ]
    if not clock:
        wheel = list(_of_the_wheel(found, sums, wanted, best))
        settings = list(_of_the_filter(best, sums, wanted)) if best is not None else []
        wheel_first = best is not None and best.wheel_gain > best.settings_gain
        told += wheel + settings if wheel_first else settings + wheel
    told += [_warning("Taken for granted", f"{remark}.", "Nothing to do, if that is right.") for remark in log.remarks]
    return tuple(sorted(told, key=lambda finding: finding.grade is not Grade.BAD))


def _warning(title: str, text: str, remedy: str) -> Finding:
    return Finding(title=title, text=text, remedy=remedy, grade=Grade.WARNING)


def _grave(title: str, text: str, remedy: str) -> Finding:
    return Finding(title=title, text=text, remedy=remedy, grade=Grade.BAD)


def _angle(value: float) -> str:
    return with_unit(value, ANGLE, 3)


def _speed(value: float) -> str:
    return with_unit(value, SPEED, 3)


def _of_the_course(found: dict[str, Any], sums: Sums, wanted: Estimation) -> Iterator[Finding]:
    for words in sums.interruptions:
        yield _grave("Interrupted", words, "Run it again.")
    if not found["settled"]:
        yield _grave(
            "Too short",
            f"{_edges(sums.edges)} {_are(sums.edges)} less than two turns of {sums.sectors}: the filter has not "
            "settled, and means are over all that there is.",
            "Take a longer record.",
        )
    speed = found["spool_speed_mean_rad_s"]
    if not SLOWEST <= speed <= FASTEST:
        yield _grave(
            "Speed hardly possible",
            f"The mean speed is {with_unit(speed, SPEED)}.",
            f"Look at the unit of the times, the sample rate, and the number of sectors ({sums.sectors}).",
        )


def _of_the_record(sums: Sums, wanted: Estimation) -> Iterator[Finding]:
    if sums.gaps:
        yield _warning(
            "Gaps in the record",
            f"{_times(sums.gaps).capitalize()} no sample came for more than {GAP:g} usual intervals; the longest gap "
            f"is {sums.longest_gap:.4g} s.",
            "Edges inside a gap count as missed; a gap that cannot be bridged starts the filter anew.",
        )
    if sums.not_numbers:
        yield _warning(
            "Values that are no numbers",
            f"{sums.not_numbers} of {sums.samples} samples {_are(sums.not_numbers)} NaN and {_were(sums.not_numbers)} "
            "left out.",
            "Look at the logger.",
        )
    if sums.backward:
        yield _grave(
            "Time runs backwards",
            f"{_times(sums.backward).capitalize()} the clock went back; the record was cut there, and each piece has "
            "its own times.",
            "Look at the column piece of result.h5 before joining anything over time.",
        )
    if sums.pieces > 1 + sums.backward:
        bridge = bridged_time(TURN / sums.sectors / sums.speed.mean, wanted.filter) if sums.speed.mean > 0.0 else np.nan
        yield _warning(
            "Pauses without edges",
            f"The filter was started {_times(sums.pieces)}: without an edge it can go on for {bridge:.3g} s at the "
            "mean speed, until three deviations of its angle reach half a sector.",
            "Between pieces the estimate is NaN, and turns that passed there are only guessed.",
        )
    if sums.left_out:
        yield _warning(
            "Edges left out",
            f"{_edges(sums.left_out)} {_are(sums.left_out)} too isolated to give a speed.",
            "Nothing to do, if the spool was at rest.",
        )
    if sums.doubled:
        yield _warning(
            "Double edges",
            f"{_edges(sums.doubled)} came much sooner after another than edges do there; "
            f"{'it was taken as a bounce' if sums.doubled == 1 else 'they were taken as bounces'}.",
            "Widen the hysteresis, or look for noise on the line.",
        )
    if sums.missed:
        yield _warning(
            "Missed edges",
            f"{_edges(sums.missed)} did not show, {100.0 * sums.missed / (sums.edges + sums.missed):.2g} % of all.",
            "The filter passes over them. Look at the threshold, the sample rate, and the wheel for dirt.",
        )


def _of_the_source(sums: Sums, wanted: Estimation) -> Iterator[Finding]:
    finder, speed = sums.finder, sums.speed.mean
    if sums.period and speed > 0.0 and isinstance(finder, WaveEdges | CountEdges):
        per_sector = TURN / sums.sectors / speed / sums.period
        if per_sector < FEW_SAMPLES:
            yield _warning(
                "Few samples",
                f"There are {per_sector:.2g} samples for each sector at the mean speed.",
                "Sample faster; edges get lost.",
            )
    if isinstance(finder, CountEdges):
        if finder.fractions:
            yield _grave(
                "Counts that are not whole",
                f"{finder.fractions} of {sums.samples} values of the counter "
                f"{'is no whole number' if finder.fractions == 1 else 'are no whole numbers'}.",
                "Is the channel a wave? Then name it with --wave.",
            )
        if finder.resets:
            yield _grave("Counter reset", f"The counter fell {_times(finder.resets)} without rolling over.",
                          "Edges at a reset count as missed.")  # fmt: skip
        if finder.rollovers:
            yield _warning("Counter rolled over", f"The counter went over its end {_times(finder.rollovers)}.",
                          "The edges were counted on.")  # fmt: skip
        if finder.downward:
            yield _warning("Counter counts down", "Its steps were taken as forward.", "Swap the lines of the counter.")
        if finder.backward:
            yield _warning("Counter went back", f"The counter went against its way {_times(finder.backward)}.",
                          "They were taken as jitter at an edge.")  # fmt: skip
    if isinstance(finder, WaveEdges):
        if finder.lost:
            yield _warning("Edges in gaps",
                          f"{_edges(finder.lost)} fell into gaps and {_were(finder.lost)} not placed.",
                          "Such edges count as missed.")  # fmt: skip
        if finder.plateaus is not None and len(finder.levels) > 1:
            drift = max(finder.levels) - min(finder.levels)
            if drift > LEVEL_DRIFT * finder.plateaus.swing:
                yield _warning(
                    "The wave drifts",
                    f"Midway between its plateaus went from {min(finder.levels):.4g} to {max(finder.levels):.4g}, "
                    f"{100.0 * drift / finder.plateaus.swing:.2g} % of the swing.",
                    "The threshold followed it. Look at the lamp and its supply.",
                )
    if (step := in_step(sums, wanted)) is not None:
        words = commensurate_warning(step, TURN / sums.sectors)
        yield _grave(
            "Edges in step with the clock",
            words.rpartition("; ")[0] + ".",
            f"The angle may be off by up to {_angle(hidden_angle(step, TURN / sums.sectors))}, and no deviation shows "
            "it. Stamp the edges, interpolate the crossings of a wave, or sample at another rate.",
        )


def _of_the_filter(told: Explained, sums: Sums, wanted: Estimation) -> Iterator[Finding]:
    if not told.matters or numbers_in_doubt(told, sums, wanted):
        return
    used, advised, now = told.used, told.advised, told.used_errors
    constant = " (less is as likely: the speed is constant as far as they tell)" if told.fit.at_floor[0] else ""
    R_most = "at most " if told.fit.at_floor[1] else ""
    yield _warning(
        "The settings of the filter do not fit this log",
        f"The {told.fit.edges} edges looked at are likeliest with an acceleration_density of "
        f"{advised.acceleration_density:.3g} rad^2/s^3{constant} and an edge_variance of {R_most}"
        f"{advised.edge_variance:.3g} rad^2, in place of {used.acceleration_density:.3g} and "
        f"{used.edge_variance:.3g} (logarithm of the likelihood "
        f"+{told.settings_gain:.3g}). As it is, a speed error of {_speed(now.true)} is expected, where the filter "
        f"states {_speed(now.stated)}; with these {_speed(told.fitted_errors.true)}.",
        f"Use --fit, or in the config [filter] acceleration_density = "
        f'"{advised.acceleration_density:.3g} rad^2/s^3" and edge_variance = "{advised.edge_variance:.3g} rad^2".',
    )


def _of_the_clock(told: Explained, wanted: Estimation, log: Log) -> Iterator[Finding]:
    source, speed = wanted.source, told.likelihood.speed
    if not isinstance(source, Stamps) or source.falling or not told.even_clock:
        return
    if not is_time_name(source.channel.rpartition("/")[2]) and speed <= FASTEST:
        return
    others = ", ".join(repr(name) for name in channels_of_edges(log))
    yield _grave(
        "An even clock in place of edges",
        f"All times in {source.channel!r} are {told.likelihood.period:.6g} s apart: it is the clock of the log, and no "
        "edge passes then.",
        f"Name the channel that holds the edges with --wave, --counts or --edges{f': {others}' if others else ''}.",
    )


def _of_the_wheel(found: dict[str, Any], sums: Sums, wanted: Estimation, best: Explained | None) -> Iterator[Finding]:
    if found["index_found"] is False:
        agreeing = all(a.index_found for a in sums.alignments)
        words = (
            "The edges are explained better by a wheel whose sectors are all alike."
            if agreeing
            else "No first edge makes the turns agree with the sectors of the wheel; the angle is counted from an edge "
            "that was chosen."
        )
        yield _grave(
            "Index not found",
            words,
            f"Look at index_shift or widths, and at the number of sectors ({sums.sectors}).",
        )
    hidden = max(sums.measured_variance.mean - wanted.filter.edge_variance, 0.0) if sums.nis.count else 0.0
    pattern = sums.period_of_pattern(hidden)
    if pattern is not None and best is not None and best.period_gain(pattern[0]) <= best.wheel_gain + CLEAR:
        pattern = None
    if pattern is not None:
        period, there, own = pattern
        yield _grave(
            "Perhaps a wrong number of sectors",
            f"The innovations repeat after {period} edges (correlation {there:.2f}), not after {sums.sectors} "
            f"({own:.2f}), and speed variation does not explain it.",
            f"Count the sectors of the wheel; bright and dark ones together, {period} would fit.",
        )
    bias = -sums.alternating.mean if threshold_is_off(sums, wanted) else 0.0
    if bias:
        yield _bias_warning(sums, wanted, bias)
    offsets = sums.offsets if not bias else _beside_alternation(sums)
    worst = _worst(sums, offsets)
    if worst is not None and pattern is None:
        yield _unequal(sums, wanted, offsets, worst)


def threshold_is_off(sums: Sums, wanted: Estimation) -> bool:
    """Whether rising and falling edges lie apart as a threshold makes them: all of them, and no single ones more."""
    bias, error = -sums.alternating.mean, _error(sums.alternating)
    sector = TURN / sums.sectors
    if not (abs(bias) > SURE * error and abs(bias) > SHARE_OF_SECTOR * sector):
        return False
    beside = _beside_alternation(sums)
    return _worst(sums, beside) is None or float(np.nanmax(np.abs(beside))) < abs(bias)


def _beside_alternation(sums: Sums) -> Array:
    """Offsets of the wheel's edges less what rising and falling ones have in common [rad]."""
    offsets, even = sums.offsets, np.arange(sums.sectors) % 2 == 0
    if not (np.isfinite(offsets[even]).any() and np.isfinite(offsets[~even]).any()):
        return offsets
    found: Array = offsets - np.where(even, np.nanmean(offsets[even]), np.nanmean(offsets[~even]))
    return found


def _worst(sums: Sums, offsets: Array) -> int | None:
    """The edge of the wheel that lies furthest from its place, if that is sure and worth a word."""
    if not np.isfinite(offsets).any():
        return None
    worst = int(np.nanargmax(np.abs(offsets)))
    far, error = abs(offsets[worst]), sums.offset_deviations[worst]
    told = far > SURE * error and far > SHARE_OF_SECTOR * TURN / sums.sectors and sums.wheel_counts[worst] >= 8
    return worst if told else None


def _edges(count: float) -> str:
    return "1 edge" if count == 1 else f"{count:.9g} edges"


def _are(count: float) -> str:
    return "is" if count == 1 else "are"


def _were(count: float) -> str:
    return "was" if count == 1 else "were"


def _times(count: int) -> str:
    return {1: "once", 2: "twice"}.get(count, f"{count} times")


def _error(moments: Moments) -> float:
    return moments.deviation / np.sqrt(moments.count) if moments.count else np.inf


def _bias_warning(sums: Sums, wanted: Estimation, bias: float) -> Finding:
    late, early = ("late", "early") if bias > 0.0 else ("early", "late")
    level = suggested_level(sums, wanted)
    remedy = (
        f"Set threshold.level to about {level:.4g}"
        if np.isfinite(level) and isinstance(sums.finder, WaveEdges)
        else "Move the threshold"
    )
    other = "; bright sectors that are really wider or narrower than dark ones look the same."
    return _warning(
        "The threshold is off",
        f"Rising edges come {late} and falling ones {early} by {_angle(abs(bias))}, "
        f"{100.0 * abs(bias) * sums.sectors / TURN:.2g} % of a sector.",
        remedy + other,
    )


def _unequal(sums: Sums, wanted: Estimation, offsets: Array, worst: int) -> Finding:
    n, sector = sums.sectors, TURN / sums.sectors
    places = np.array(wanted.wheel.edges)
    wave = 2.0 * abs(np.nanmean(offsets * np.exp(-1j * places)))
    others, far = np.delete(offsets, worst), float(abs(offsets[worst]))
    way = "beyond" if offsets[worst] > 0.0 else "before"
    if wave > 0.7 * float(np.sqrt(2.0 * np.nanmean(offsets**2))) and n > 4:
        cause = f"They go up and down once in a turn by {_angle(float(wave))}: the wheel or the spot is eccentric."
    elif far > 4.0 * float(np.nanmax(np.abs(others - np.nanmean(others)))):
        cause = (
            "It stands alone: dirt, a damaged sector, or an index sector missing from the configuration (index_shift)."
        )
    else:
        cause = "The sectors are not as wide as the wheel has them."
    return _warning(
        "Edges lie elsewhere on the wheel",
        f"Edge {worst} lies {_angle(far)} {way} its place, {100.0 * far / sector:.2g} % of a sector. {cause}",
        "Give the measured widths in [sensor] widths; the offsets of all edges stand in the report.",
    )
