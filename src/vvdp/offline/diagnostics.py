"""The numbers of a record, from what was added up."""

from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.units import ATMOSPHERE
from vvdp.estimation.commensurate import Commensurate, commensurate_clock
from vvdp.numerics.kalman import chance_band
from vvdp.offline.config import Counts, Estimation, Stamps, Wave
from vvdp.offline.edges import WaveEdges
from vvdp.offline.noise_fit import Explained
from vvdp.offline.passage import Noise
from vvdp.offline.pattern_fit import CLEAR
from vvdp.offline.sums import Sums, Tally
from vvdp.sensing.wheel import TURN, equal_wheel

SURE = 4.0
"""A mean is stated to differ from zero beyond so many standard errors."""
SHARE_OF_SECTOR = 0.02
"""Offsets of edges below this share of a sector are not worth a word."""
FEW = 8
"""Edges seen at a place of the wheel below which nothing is stated of it."""
SHARE_MISSED = 0.1
MISCOUNTED = 0.5
"""Edges; below, the count of most is right."""
SHARE_FAR = 5e-3
"""Of all edges. With more missed, and more beyond four deviations of the likeliest settings, numbers are in doubt."""


def summary(sums: Sums, wanted: Estimation) -> dict[str, Any]:
    """The numbers of docs/keys.md, `vvdp estimate`, as far as the estimation has them."""
    found = _of_record(sums, wanted) | _of_motion(sums, wanted) | _of_edges(sums, wanted) | _settings(sums, wanted)
    if isinstance(sums.tally.finder, WaveEdges):
        found |= _of_wave(sums.tally.finder) | {
            "threshold_bias_rad": -sums.edges.alternating.mean,
            "threshold_suggested": suggested_level(sums, wanted),
        }
    elif isinstance(wanted.source, Stamps) and wanted.source.falling:
        found["threshold_bias_rad"] = -sums.edges.alternating.mean
    return found | _of_pressure(sums.tally) if wanted.pressure is not None else found


def _of_record(sums: Sums, wanted: Estimation) -> dict[str, Any]:
    """How much was recorded, and what of it was found or left out."""
    tally, verdict = sums.tally, sums.tally.verdict
    return {
        "duration_s": tally.measured,
        "samples": tally.samples,
        "sample_rate_Hz": 1.0 / tally.period if tally.period else np.nan,
        "output_rate_Hz": tally.rate,
        "sectors": tally.sectors,
        "sectors_assumed": wanted.sectors_assumed,
        "polarity": verdict.polarity if verdict is not None else np.nan,
        "direction": verdict.direction if verdict is not None and not tally.reversals else np.nan,
        "edges": int(tally.edges),
        "missed_edges": int(tally.missed),
        "double_edges": tally.doubled,
        "gaps": tally.gaps,
        "not_numbers": tally.not_numbers,
        "backward_times": tally.backward,
        "pieces": tally.pieces,
    }


def _of_motion(sums: Sums, wanted: Estimation) -> dict[str, Any]:
    """Speeds, and how well they and the angle are known."""
    rows, rate = sums.rows, sums.tally.rate
    speed = rows.speed if rows.speed.count else rows.every_speed
    return {
        "spool_speed_mean_rad_s": speed.mean,
        "spool_speed_std_rad_s": speed.deviation,
        "spool_speed_min_rad_s": speed.low,
        "spool_speed_max_rad_s": speed.high,
        "settled": rows.speed.count > 0,
        "pwm_frequency_mean_Hz": rows.usual_speed * wanted.sections / TURN,
        "standstill_time_s": rows.standing / rate if rate else 0.0,
        "lost_sensor_s": float(sum(each.end - each.begin for each in sums.lost_sensors)),
        "angle_deviation_mean_rad": rows.angle_deviation.mean,
        "speed_deviation_mean_rad_s": rows.speed_deviation.mean,
        "speed_deviation_rms_rad_s": float(np.hypot(rows.speed_deviation.mean, rows.speed_deviation.deviation)),
        "speed_doubt_rad_s": float(sums.doubt.speed_deviation(rows.usual_speed)),
    }


def _of_edges(sums: Sums, wanted: Estimation) -> dict[str, Any]:
    """How well the edges fit the wheel and the filter."""
    nis = sums.edges.nis
    low, high = chance_band(nis.count)
    return {
        "nis_mean": nis.mean,
        "nis_edges": nis.count,
        "nis_low": low,
        "nis_high": high,
        "index_found": index_found(sums, wanted) if has_index(sums, wanted) else None,
        "commensurate": in_step(sums, wanted) is not None,
        "edge_offset_max_rad": _largest(sums.edges.offsets),
    }


def _of_wave(finder: WaveEdges) -> dict[str, Any]:
    levels = finder.plateaus
    return {
        "threshold": float(np.mean(finder.levels)) if finder.levels else finder.level,
        "wave_swing": levels.swing if levels is not None else np.nan,
        "wave_noise": levels.noise if levels is not None else np.nan,
    }


def _of_pressure(tally: Tally) -> dict[str, Any]:
    pressure = tally.pressure
    return {
        "duty_ratio_mean": tally.duty_ratio.mean,
        "duty_ratio_std": tally.duty_ratio.deviation,
        "pressure_pulses": tally.duty_ratio.count,
        "pressure_mean_inlet_Pa": pressure.mean - ATMOSPHERE,
        "pressure_min_inlet_Pa": pressure.low - ATMOSPHERE if pressure.count else np.nan,
        "pressure_max_inlet_Pa": pressure.high - ATMOSPHERE if pressure.count else np.nan,
    }


def _settings(sums: Sums, wanted: Estimation) -> dict[str, Any]:
    """The settings of the filter, and those that would fit better."""
    used = settings_of(wanted)
    found = {"acceleration_density_rad2_s3": used.acceleration_density, "edge_variance_rad2": used.edge_variance}
    told = sums.explained
    if told is None or numbers_in_doubt(told, sums, wanted):
        return found | dict.fromkeys(_FITTED, np.nan) | {"settings_fit": None}
    fitted = (told.advised.acceleration_density, told.advised.edge_variance, told.settings_gain)
    ripple = (0.0, np.nan, np.nan)  # none
    if told.ripple is not None:
        ripple = (float(told.ripple.order), told.ripple.amplitude, told.ripple.error)
    values = (*fitted, *ripple)
    return found | dict(zip(_FITTED, values, strict=True)) | {"settings_fit": not told.matters}


_FITTED = (
    "acceleration_density_fitted_rad2_s3",
    "edge_variance_fitted_rad2",
    "likelihood_gain",
    "ripple_order_fitted",
    "ripple_amplitude_fitted",
    "ripple_amplitude_fitted_error",
)


def numbers_in_doubt(told: Explained, sums: Sums, wanted: Estimation) -> bool:
    """Whether edges have wrong numbers: the index was not found, or many were missed and others lie far off or are
    counted wrongly by the times."""
    if (has_index(sums, wanted) and not index_found(sums, wanted)) or sums.doubt.miscounted > MISCOUNTED:
        return True
    return sums.tally.missed > SHARE_MISSED * (sums.tally.edges + sums.tally.missed) and told.outliers > SHARE_FAR


def settings_of(wanted: Estimation) -> Noise:
    """What the filter of an estimation takes the noise to be."""
    return Noise(wanted.filter.acceleration_density, wanted.filter.edge_variance)


def index_found(sums: Sums, wanted: Estimation) -> bool:
    """Whether every piece of several begins with the index of the wheel (in a single one the filter finds it later), it
    explains the edges better than an even wheel, and no edge lies elsewhere by more than half of what makes the wheel
    uneven."""
    if not wanted.wheel.has_index:
        return False
    aligned = all(each.index_found for each in sums.tally.alignments)
    told = sums.explained
    if sums.tally.sectors == 2 or told is None:  # of two sectors the polarity shows which
        return aligned
    if not (told.index_gain > CLEAR and (aligned or len(sums.tally.alignments) == 1)):
        return False
    uneven = np.array(wanted.wheel.edges) - np.arange(sums.tally.sectors) * TURN / sums.tally.sectors
    offsets = np.nan_to_num(sums.edges.offsets[sums.edges.counts >= FEW])
    return not np.any(np.abs(offsets) > 0.5 * _largest(uneven - np.mean(uneven)))


def has_index(sums: Sums, wanted: Estimation) -> bool:
    """Whether the wheel was described with an index; two like sectors are one where polarities are logged."""
    wheel = sums.tally.verdict.described if sums.tally.verdict is not None else wanted.wheel
    polarity = isinstance(wanted.source, Wave) or (isinstance(wanted.source, Stamps) and bool(wanted.source.falling))
    return wheel.has_index and (polarity or wheel != equal_wheel(len(wheel.edges)))


def _largest(values: Array) -> float:
    return float(np.nanmax(np.abs(values))) if np.isfinite(values).any() else np.nan


def in_step(sums: Sums, wanted: Estimation) -> Commensurate | None:
    """How edges that are only sampled are commensurate with the sampling, if they are."""
    sampled = isinstance(wanted.source, Counts) or (
        isinstance(wanted.source, Wave) and not wanted.source.comparator.interpolated
    )
    period = sums.tally.period if sampled else sums.tally.tick
    speed = sums.rows.pace.mean
    if not period or not np.isfinite(speed) or speed <= 0.0:
        return None
    return commensurate_clock(speed * sums.tally.sectors / TURN, 1.0 / period)


def suggested_level(sums: Sums, wanted: Estimation) -> float:
    """The threshold at which rising and falling edges would agree, in the unit of the channel; NaN if unknown, if it is
    outside of the swing, or if edges of the wheel lie elsewhere for another reason.

    A threshold too high by e sees rising edges late and falling ones early by the angle e/(dv/dtheta), with the slope
    dv/dtheta = (dv/dt)/omega at the crossings; s nu has that mean with the opposite sign.
    """
    finder = sums.tally.finder
    speed = sums.rows.pace.mean
    if not isinstance(finder, WaveEdges) or not finder.found or not finder.levels or not sums.edges.alternating.count:
        return np.nan
    slope = finder.slopes / finder.found / speed
    sign = -1.0 if finder.comparator.inverted else 1.0
    level = float(np.mean(finder.levels)) + sign * sums.edges.alternating.mean * slope
    elsewhere = worst_edge(sums, beside_alternation(sums)) is not None
    if elsewhere or (has_index(sums, wanted) and not index_found(sums, wanted)):
        return np.nan
    inside = finder.plateaus is None or finder.plateaus.low < level < finder.plateaus.high
    return level if inside else np.nan


def threshold_is_off(sums: Sums, wanted: Estimation) -> bool:
    """Whether rising and falling edges lie apart as a threshold makes them: all of them, and no single ones more."""
    bias, error = -sums.edges.alternating.mean, sums.edges.alternating.standard_error
    sector = TURN / sums.tally.sectors
    if not (abs(bias) > SURE * error and abs(bias) > SHARE_OF_SECTOR * sector):
        return False
    beside = beside_alternation(sums)
    return worst_edge(sums, beside) is None or float(np.nanmax(np.abs(beside))) < abs(bias)


def beside_alternation(sums: Sums) -> Array:
    """Offsets of the wheel's edges less what rising and falling ones have in common [rad]."""
    offsets, even = sums.edges.offsets, np.arange(sums.tally.sectors) % 2 == 0
    if not (np.isfinite(offsets[even]).any() and np.isfinite(offsets[~even]).any()):
        return offsets
    found: Array = offsets - np.where(even, np.nanmean(offsets[even]), np.nanmean(offsets[~even]))
    return found


def worst_edge(sums: Sums, offsets: Array) -> int | None:
    """The edge of the wheel that lies furthest from its place, if that is sure and worth a word."""
    if not np.isfinite(offsets).any():
        return None
    worst = int(np.nanargmax(np.abs(offsets)))
    far, error = abs(offsets[worst]), sums.edges.offset_deviations[worst]
    told = far > SURE * error and far > SHARE_OF_SECTOR * TURN / sums.tally.sectors and sums.edges.counts[worst] >= FEW
    return worst if told else None
