"""How honest an estimate is: coverage of two deviations, normalised errors, speeds wrong by a factor."""

from typing import NamedTuple

import numpy as np
from scipy.stats import chi2

CHANCE = 1e-3
"""That an honest estimate lies outside of the band of its normalised errors."""
WRONG = (0.8, 1.25)
OVER = 0.5
"""Outside of these ratios to the truth over so many seconds a mean speed is wrong by a factor."""


class Errors(NamedTuple):
    """Errors over stated deviations at the samples that count, and how many of them are independent."""

    speed: np.ndarray
    angle: np.ndarray
    independent: float


class Honesty(NamedTuple):
    """Shares of errors within two deviations, means of the squares of errors over deviations, and their band."""

    speed_coverage: float
    angle_coverage: float
    speed_nees: float
    angle_nees: float
    low: float
    high: float


def errors(estimated: np.ndarray, true: np.ndarray, deviations: np.ndarray, pitch: float, independent: float) -> Errors:
    """Columns (angle, speed) of each; the angle turned through, whole multiples of `pitch` by which the wheel may
    have stood elsewhere at the start taken off."""
    off = estimated - true
    begin = off[: max(1, off.shape[0] // 10), 0]
    known = begin[np.isfinite(begin)]
    off[:, 0] -= pitch * np.round(np.median(known) / pitch) if known.size else 0.0
    sure = np.isfinite(off).all(axis=1) & np.isfinite(deviations).all(axis=1)
    z = off[sure] / np.clip(deviations[sure], 1e-12, None)
    return Errors(z[:, 1], z[:, 0], independent)


def independent_edges(times: np.ndarray, density: float, variance: float) -> float:
    """Of the edges that passed at `times`, the number whose errors are independent.

    A filter with acceleration of `density` and edges of `variance` every T remembers for (variance T/density)^(1/4):
    its errors decay so, and the squares of two of them correlate with exp(-2 t/memory), one value for each memory.
    """
    if times.size < 2:
        return 1.0
    apart = float(np.median(np.diff(times)))
    memory = max((variance * apart / density) ** 0.25, apart)
    return max(1.0, float(np.sum(np.clip(np.diff(times), 0.0, memory))) / memory)


def pool(all_errors: list[Errors]) -> Honesty:
    """What the records of one class come to together."""
    speed = np.concatenate([each.speed for each in all_errors])
    angle = np.concatenate([each.angle for each in all_errors])
    low, high = band(sum(each.independent for each in all_errors))
    return Honesty(
        speed_coverage=coverage(speed),
        angle_coverage=coverage(angle),
        speed_nees=float(np.mean(speed**2)),
        angle_nees=float(np.mean(angle**2)),
        low=low,
        high=high,
    )


def coverage(normalised: np.ndarray) -> float:
    """Share of errors within two deviations."""
    return float(np.mean(np.abs(normalised) <= 2.0))


def band(independent: float) -> tuple[float, float]:
    """Between which values the mean of so many independent squared normal errors lies, but by `CHANCE`."""
    low, high = chi2.ppf([0.5 * CHANCE, 1.0 - 0.5 * CHANCE], independent) / independent
    return float(low), float(high)


def wrong_by_a_factor(time: np.ndarray, estimated: np.ndarray, true: np.ndarray, usual: float) -> bool:
    """Whether the mean of the estimated speed over some half a second is no such speed at all; less than a twentieth
    of the `usual` one is as good as none."""
    dt = float(np.median(np.diff(time)))
    n = min(time.size, max(1, round(OVER / dt)))
    weights = np.ones(n) / n
    said, was = (np.convolve(each, weights, mode="valid") for each in (estimated, true))
    low, high = WRONG
    return bool(np.any(((said < low * was) | (said > high * was)) & (np.abs(said - was) > 0.05 * usual)))
