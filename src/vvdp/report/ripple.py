"""Cycles of a line that are too close to be drawn: the mean of each, between its lowest and its highest value.

Two strokes of a line that follow each other within two of its widths leave no gap, so that a ripple becomes a solid
block in which no mean can be read. Lines with noise do the same. `assets/ripple.js` finds the same in the browser.
"""

from collections.abc import Iterator
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from vvdp.base.arrays import Array, Rows

Flags: TypeAlias = np.ndarray[Any, np.dtype[np.bool_]]

STRETCH = 8
"""Cycles as close as may be drawn in a stretch of x: with more, and beside it, a line is drawn by their means."""
BESIDE = 4
"""Cycles that a stretch needs for that beside another one, so that a steady ripple at the limit is drawn in one way."""
HELD = 0.1
"""Share of half the range of a stretch by which a line has to pass its middle to have crossed it."""


class Ripple(NamedTuple):
    """Mean, lowest and highest of whole cycles around places of x, and the rest of the line (nan where they are).

    Between stretches of close cycles there is a place without values (nan).
    """

    x: Array
    low: Array
    high: Array
    mean: Array
    rest: Array


def ripple(x: Array, y: Array, closest: float) -> Ripple | None:
    """The cycles of a line that follow one another more closely than `closest`, in the unit of x; None without any.

    Cycles begin where the line rises through the middle of its range within a stretch of `STRETCH` times `closest`; as
    many as begin within `closest` are taken together, and what is left of one at an end of the line is counted with its
    neighbour. None are found where x runs back or a value is missing.
    """
    if not (y.size > STRETCH and closest > 0.0 and np.all(np.diff(x) >= 0.0) and np.all(np.isfinite(y))):
        return None
    count = int((x[-1] - x[0]) / (STRETCH * closest))
    if count == 0:
        return None
    stretch = ((x - x[0]) / (x[-1] - x[0]) * count).astype(int).clip(max=count - 1)
    ups = _rises(y, stretch)
    is_close = _close(np.bincount(stretch[ups], minlength=count))
    knots = ups[np.unique(((x[ups] - x[0]) / closest).astype(int), return_index=True)[1]]
    integral = np.concatenate([[0.0], np.cumsum(0.5 * (y[1:] + y[:-1]) * np.diff(x))])
    rest, parts = y.copy(), []
    for begin, end in _runs(is_close[stretch[knots[:-1]]] & is_close[stretch[knots[1:]]]):
        whole = knots[begin : end + 1]
        mean = np.diff(integral[whole]) / np.diff(x[whole])
        shown = whole.copy()
        if begin == 0 and is_close[0]:
            shown[0] = 0
        if end == knots.size - 1 and is_close[-1]:
            shown[-1] = y.size - 1
        parts.append(_part(x, y, mean, shown))
        rest[shown[0] + 1 : shown[-1]] = np.nan
    if not parts:
        return None
    places, low, high, mean = (np.concatenate(each) for each in zip(*parts, strict=True))
    return Ripple(places, low, high, mean, rest)


def _rises(y: Array, stretch: Rows) -> Rows:
    """The rows at which a line has risen through the middle of its range within a stretch."""
    begins = np.flatnonzero(np.diff(stretch, prepend=-1))
    sizes = np.diff(np.append(begins, y.size))
    low, high = (np.repeat(of.reduceat(y, begins), sizes) for of in (np.fmin, np.fmax))
    away = (y - 0.5 * (low + high)) / np.where(high > low, 0.5 * HELD * (high - low), 1.0)
    side = np.where(away > 1.0, 1, np.where(away < -1.0, -1, 0))
    held = side[np.fmax.accumulate(np.where(side != 0, np.arange(y.size), 0))]
    rises: Rows = np.flatnonzero((held[1:] == 1) & (held[:-1] == -1)) + 1
    return rises


def _close(counts: Rows) -> Flags:
    """Flags of the stretches with many cycles: at least `STRETCH`, or `BESIDE` in a row with such a stretch."""
    is_close: Flags = counts >= BESIDE
    for begin, end in _runs(is_close):
        is_close[begin:end] = np.any(counts[begin:end] >= STRETCH)
    return is_close


def _runs(flags: Flags) -> Iterator[tuple[int, int]]:
    """First place and the place after the last of each run of flags."""
    edges = np.flatnonzero(np.diff(flags.astype(int), prepend=0, append=0))
    return zip(edges[::2], edges[1::2], strict=True)


def _part(x: Array, y: Array, mean: Array, shown: Rows) -> list[Array]:
    """Places, lowest, highest and mean from the first to the last of the rows `shown`, and a place without values."""
    parts = y[shown[0] : shown[-1] + 1]
    low, high = (of.reduceat(parts, shown[:-1] - shown[0]) for of in (np.fmin, np.fmax))
    middle = 0.5 * (x[shown[1:]] + x[shown[:-1]])
    places = np.concatenate([[x[shown[0]]], middle, [x[shown[-1]]] * 2])
    return [places, *(np.concatenate([each[:1], each, each[-1:], [np.nan]]) for each in (low, high, mean))]
