"""How honest an estimate is: coverage of two deviations, normalised errors, speeds wrong by a factor."""

from typing import NamedTuple

import numpy as np
from scipy.stats import chi2

CHANCE = 1e-3
"""That an honest estimate lies outside of the band of its normalised errors."""
WRONG = (0.8, 1.25)
OVER = 0.5
"""Outside of these ratios to the truth over so many seconds a mean speed is wrong by a factor."""


REST = 0.1
"""After so many seconds at rest a wheel stands still."""


class Errors(NamedTuple):
    """Errors over stated deviations at the samples that count, and how many of them are independent.

    What is said of a wheel that has stood for a while is `still`, and apart: there every deviation covers. Just after a
    sudden change no edge has told of it: there an error is many deviations large whatever one does, and not `knowable`.
    """

    speed: np.ndarray
    angle: np.ndarray
    independent: float
    still: np.ndarray
    knowable: np.ndarray


class Honesty(NamedTuple):
    """Shares of errors within two deviations, means of the squares of errors over deviations, and their band; and the
    lesser share of speed and angle while the wheel stands, NaN where it never does."""

    speed_coverage: float
    angle_coverage: float
    speed_nees: float
    angle_nees: float
    low: float
    high: float
    still_coverage: float


class Traces(NamedTuple):
    """Columns (angle turned through, speed) of what was estimated, of the truth, and of the stated deviations, at the
    samples of `time`."""

    time: np.ndarray
    estimated: np.ndarray
    true: np.ndarray
    deviations: np.ndarray


def errors(traces: Traces, pitch: float, independent: float, sudden: tuple[tuple[float, float], ...] = ()) -> Errors:
    """The errors of the traces, whole multiples of `pitch` by which the wheel may have stood elsewhere at the start
    taken off the angle."""
    _, estimated, true, deviations = traces
    off = estimated - true
    begin = off[: max(1, off.shape[0] // 10), 0]
    known = begin[np.isfinite(begin)]
    off[:, 0] -= pitch * np.round(np.median(known) / pitch) if known.size else 0.0
    sure = np.isfinite(off).all(axis=1) & np.isfinite(deviations).all(axis=1)
    z = off[sure] / np.clip(deviations[sure], 1e-12, None)
    still = stands(traces)[sure]
    time = traces.time[sure][~still]
    return Errors(z[~still, 1], z[~still, 0], independent, z[still], is_knowable(time, sudden))


def is_knowable(time: np.ndarray, sudden: tuple[tuple[float, float], ...]) -> np.ndarray:
    """Whether edges have told, at each `time`, of all `sudden` changes before it, each given from when to when [s]."""
    found: np.ndarray = ~np.any([(time >= begin) & (time <= end) for begin, end in ((np.inf, np.inf), *sudden)], axis=0)
    return found


def stands(traces: Traces) -> np.ndarray:
    """Where the wheel has stood for `REST`."""
    moving = np.flatnonzero(traces.true[:, 1] != 0.0)
    last = np.searchsorted(moving, np.arange(traces.time.size), side="right") - 1
    since = traces.time - np.where(last >= 0, traces.time[moving[last]], -np.inf)
    found: np.ndarray = since > REST
    return found


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
    knowable = np.concatenate([each.knowable for each in all_errors])
    still = np.concatenate([each.still for each in all_errors])
    low, high = band(sum(each.independent for each in all_errors))
    return Honesty(
        speed_coverage=coverage(speed),
        angle_coverage=coverage(angle),
        speed_nees=float(np.mean(speed[knowable] ** 2)),
        angle_nees=float(np.mean(angle[knowable] ** 2)),
        low=low,
        high=high,
        still_coverage=min(coverage(column) for column in still.T) if still.size else np.nan,
    )


def coverage(normalised: np.ndarray) -> float:
    """Share of errors within two deviations."""
    return float(np.mean(np.abs(normalised) <= 2.0))


def band(independent: float) -> tuple[float, float]:
    """Between which values the mean of so many independent squared normal errors lies, but by `CHANCE`."""
    low, high = chi2.ppf([0.5 * CHANCE, 1.0 - 0.5 * CHANCE], independent) / independent
    return float(low), float(high)


def wrong_by_a_factor(traces: Traces, usual: float, sudden: tuple[tuple[float, float], ...] = ()) -> bool:
    """Whether the mean of the estimated speed over some half a second is no such speed at all, and two of the stated
    deviations do not say so; less than a twentieth of the `usual` speed is as good as none.

    Just after a `sudden` change, from when to when [s], no edge has told of it: that is left out.
    """
    known = np.isfinite(traces.estimated[:, 1]) & is_knowable(traces.time, sudden)
    n = min(np.count_nonzero(known), max(1, round(OVER / float(np.median(np.diff(traces.time))))))
    weights = np.ones(n) / n
    said, was, deviation = (np.convolve(each[known, 1], weights, mode="valid") for each in traces[1:])
    low, high = WRONG
    off = np.abs(said - was)
    return bool(np.any(((said < low * was) | (said > high * was)) & (off > 0.05 * usual) & (off > 2.0 * deviation)))
