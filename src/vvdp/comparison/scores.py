"""How far an estimate is from the truth, run by run, and what many runs come to."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.comparison.figures import Measured, mean, quantile, root_mean
from vvdp.comparison.motion import Lag, Motion
from vvdp.sensing.wheel import TURN

ALIGNED_OVER = 0.1
"""Time [s] at the begin and at the end of what is scored over which whole sectors are counted."""

BAND = 0.05
"""Share of a step within which a speed counts as settled."""

LONGEST_DELAY = 0.2
"""The longest equivalent delay that is looked for [s]."""
MOST_SAMPLES = 4000
"""Roughly as many samples, evenly picked, are looked at for it."""


class Score(NamedTuple):
    """Score of one run of one estimator. NaN where there is nothing to measure.

    Errors are estimate minus truth. The angle's is taken modulo a turn, after the whole number of pairs of sectors has
    been taken off that fits best at the begin: a wheel without an index does not show it. `tail` is what is exceeded in
    5 % of the time; `settling` is infinite where the speed does not stay within 5 % of the step; `delay` is by how much
    the true speed has to be shifted to come closest to the estimate; `lost_sectors` were gained or lost on the way.
    Coverage is the share of errors within two of the stated standard deviations.
    """

    angle_mean_square: float  # [rad^2]
    angle_tail: float  # [rad]
    angle_worst: float  # [rad]
    angle_bias: float  # [rad]
    speed_mean_square: float  # [rad^2/s^2]
    speed_tail: float  # [rad/s]
    speed_worst: float  # [rad/s]
    speed_bias: float  # [rad/s]
    settling: float  # [s]
    delay: float  # [s]
    lost_sectors: float
    nis: float
    angle_coverage: float
    speed_coverage: float


class Traces(NamedTuple):
    """Output of an estimator, sample by sample, each (samples,)."""

    angle: Array
    speed: Array
    innovation: Array
    innovation_deviation: Array
    angle_deviation: Array
    speed_deviation: Array


class Truth(NamedTuple):
    """True values at the samples, each (samples,)."""

    time: Array
    angle: Array
    speed: Array


def without_direction(truth: Truth, motion: Motion) -> Truth:
    """The angle turned through and the speed, whichever way: an encoder with one track does not show it."""
    angle = truth.angle - motion.angle(truth.time) + motion.travel(truth.time)
    return Truth(truth.time, angle, np.abs(truth.speed))


def score(traces: Traces, truth: Truth, motion: Motion, scored_from: float, sector: float) -> Score:
    """The score of one run from `scored_from` [s] on, on a wheel with sectors `sector` [rad] wide.

    The truth has no direction, see `without_direction`.
    """
    part = truth.time >= scored_from
    time = truth.time[part]
    apart = traces.angle[part] - truth.angle[part]
    at_begin = float(np.median(apart[time < time[0] + ALIGNED_OVER]))
    at_end = float(np.median(apart[time > time[-1] - ALIGNED_OVER]))
    unknown = 2.0 * sector * np.round(0.5 * at_begin / sector)
    angle = np.mod(apart - unknown + 0.5 * TURN, TURN) - 0.5 * TURN
    speed = traces.speed[part] - truth.speed[part]
    angle_off, speed_off = _sizes(angle), _sizes(speed)
    return Score(
        angle_mean_square=angle_off.mean_square,
        angle_tail=angle_off.tail,
        angle_worst=angle_off.worst,
        angle_bias=angle_off.bias,
        speed_mean_square=speed_off.mean_square,
        speed_tail=speed_off.tail,
        speed_worst=speed_off.worst,
        speed_bias=speed_off.bias,
        settling=settling_time(truth.time, traces.speed, motion.step) if motion.step else np.nan,
        delay=equivalent_delay(time, traces.speed[part], motion.step) if motion.step else np.nan,
        lost_sectors=abs(float(np.round((at_end - at_begin) / sector))),
        nis=_mean_nis(traces.innovation[part], traces.innovation_deviation[part]),
        angle_coverage=coverage(angle, traces.angle_deviation[part]),
        speed_coverage=coverage(speed, traces.speed_deviation[part]),
    )


def coverage(error: Array, deviation: Array) -> float:
    """Share of errors within two stated standard deviations, NaN where none are stated."""
    return float(np.mean(np.abs(error) <= 2.0 * deviation)) if np.isfinite(deviation).any() else np.nan


class _Size(NamedTuple):
    """Mean square, what is exceeded in 5 % of the time, the worst, and the mean of an error."""

    mean_square: float
    tail: float
    worst: float
    bias: float


def _sizes(error: Array) -> _Size:
    size = np.abs(error)
    tail = np.partition(size, int(0.95 * size.size))[int(0.95 * size.size)]
    return _Size(
        mean_square=float(np.mean(error * error)),
        tail=float(tail),
        worst=float(np.max(size)),
        bias=float(np.mean(error)),
    )


def _mean_nis(innovation: Array, deviation: Array) -> float:
    used = deviation > 0.0  # NaN is not
    return float(np.mean((innovation[used] / deviation[used]) ** 2)) if np.any(used) else np.nan


def settling_time(time: Array, speed: Array, motion: Lag) -> float:
    """Time after the step from which on `speed` stays within 5 % of the step of its final value [s].

    Infinite where the last sample lies outside still.
    """
    outside = ~(np.abs(speed - motion.after) <= BAND * abs(motion.after - motion.before))  # NaN is
    late = np.flatnonzero(outside & (time >= motion.change_at))
    if not late.size:
        return 0.0
    if late[-1] == time.size - 1:
        return np.inf
    return float(time[late[-1] + 1] - motion.change_at)


def equivalent_delay(time: Array, speed: Array, motion: Lag) -> float:
    """The lag L >= 0 for which the true speed at t - L comes closest to `speed` at t in the mean square [s].

    Sought on the grid of the samples, then between them by a parabola; infinite where it is longer than
    `LONGEST_DELAY`.
    """
    thin = max(1, time.size // MOST_SAMPLES)
    time, speed = time[::thin], speed[::thin]
    period = float(time[-1] - time[0]) / (time.size - 1)
    lags = int(np.ceil(LONGEST_DELAY / period))
    every = time[0] + period * np.arange(-lags, time.size)
    true = motion.speed(every)
    squares = np.concatenate([[0.0], np.cumsum(true * true)])
    energy = squares[time.size :] - squares[: -time.size]
    misfit = (energy - 2.0 * np.correlate(true, speed, "valid"))[::-1]  # place k: k periods ago
    best = int(np.argmin(misfit))
    if best == lags:
        return np.inf
    if best == 0:
        return 0.0
    left, middle, right = misfit[best - 1 : best + 2]
    return float(period * (best + 0.5 * (left - right) / (left - 2.0 * middle + right)))


def summary(scores: Array) -> dict[str, Measured]:
    """Summary of the rows of `scores`, shape (seeds, fields of Score); keys end in the unit.

    Standard errors: of means sd/sqrt(n), of root mean squares the same by the delta method, of quantiles half the
    distance of the ordered values one binomial standard deviation to either side.
    """
    column: Mapping[str, Array] = dict(zip(Score._fields, scores.T, strict=True))
    found: dict[str, Measured] = {}
    for name, unit in (("angle", "rad"), ("speed", "rad_s")):
        runs = np.sort(np.sqrt(column[f"{name}_mean_square"]))
        found[f"{name}_error_rms_{unit}"] = root_mean(column[f"{name}_mean_square"])
        found[f"{name}_error_rms_low_{unit}"] = quantile(runs, 0.05)
        found[f"{name}_error_rms_high_{unit}"] = quantile(runs, 0.95)
        found[f"{name}_error_95_{unit}"] = mean(column[f"{name}_tail"])
        found[f"{name}_error_worst_{unit}"] = Measured(float(np.max(column[f"{name}_worst"])))
        found[f"{name}_error_mean_{unit}"] = mean(column[f"{name}_bias"])
        found[f"{name}_coverage"] = mean(column[f"{name}_coverage"])
    found["settling_median_s"] = quantile(column["settling"], 0.5)
    found["settling_90_s"] = quantile(column["settling"], 0.9)
    found["settled"] = mean(np.where(np.isnan(column["settling"]), np.nan, np.isfinite(column["settling"])))
    found["delay_s"] = mean(column["delay"])
    found["lost_sectors"] = mean(column["lost_sectors"])
    found["nis"] = mean(column["nis"])
    return found
