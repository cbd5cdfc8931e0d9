"""The second pass over a record: every row again, given the edges before and after it (Rauch, Tung, Striebel)."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.estimation.smoother import Smoothed, smoothed_at, smoothed_portions, smoothing_overlap
from vvdp.numerics.kalman import AngleSpeed
from vvdp.offline.config import Estimation
from vvdp.offline.estimate_result import SMOOTHED, piece_rows
from vvdp.offline.interrupt import Stopped
from vvdp.offline.turn_pattern import SpeedRipple
from vvdp.simulation.replay import Compiled

SMOOTHED_EDGES = 50_000
FORGOTTEN = 1e-4
"""Edges count for a smoothed instant until their share has fallen to this."""


class SecondPass:
    """Smooths the rows and edges of an open result.h5, whose smoothed columns are there and NaN.

    ripple  what the log has of the ripple that the filter models; None without one
    """

    def __init__(self, file: Any, wanted: Estimation, ripple: SpeedRipple | None, say: Callable[[str], None]) -> None:
        self._file, self._ripple, self._run = file, ripple, Compiled(say)
        self._filter, self._sectors = wanted.filter, len(wanted.wheel.edges)
        self._rows = 0

    def through(self, progress: Callable[[float], None], check: Callable[[], None]) -> str:
        """Smooths piece by piece; where it was stopped, by `check` or by a KeyboardInterrupt in `progress`, in words,
        empty if nowhere."""
        rows, total = piece_rows(self._file, ""), self._file["piece"].shape[0]
        try:
            for piece, (first, last) in piece_rows(self._file, "edges/").items():
                check()
                for smoothed in self._smooth(first, last):
                    self._write(smoothed, *rows.get(piece, (0, 0)), check)
                    try:
                        progress(self._rows / total)
                    except KeyboardInterrupt:
                        raise Stopped from None
        except Stopped:
            if self._rows < total:
                time, piece = (self._file[name][self._rows] for name in ("time", "piece"))
                where = f"from {time:.6g} s of piece {piece:g} on"
                return f"The second pass was stopped; {where} the smoothed columns are NaN."
        return ""

    def _columns(self, begin: int, last: int) -> tuple[Array, Array, Array]:
        """Times [s], angles [rad] and their variances [rad^2] of the edges in a portion of a piece."""
        edges, end = self._file["edges"], min(begin + SMOOTHED_EDGES, last)
        t, angle, variance = (edges[name][begin:end] for name in ("time", "angle", "variance"))
        used = np.isfinite(angle)
        used[1:] &= np.diff(t) > 0.0
        met = angle if self._ripple is None else angle + self._ripple.offsets(angle)
        return t[used], met[used], variance[used]

    def _smooth(self, first: int, last: int) -> Iterator[Smoothed]:
        q, settings = self._filter.acceleration_density, self._filter
        t, angle, variance = self._columns(first, last)
        if t.size < 2 or not q > 0.0:
            return
        turns = min(t.size - 1, 2 * self._sectors)
        speed = float((angle[turns] - angle[0]) / (t[turns] - t[0]))
        start = AngleSpeed(float(angle[0]), speed, settings.angle_variance, 0.0, settings.speed_variance)
        overlap = smoothing_overlap(q, float(np.median(variance)), float(np.median(np.diff(t))), FORGOTTEN)
        portions = (self._columns(begin, last) for begin in range(first, last, SMOOTHED_EDGES))
        yield from smoothed_portions(portions, q, start, overlap, self._run)

    def _write(self, smoothed: Smoothed, begin: int, end: int, check: Callable[[], None]) -> None:
        """Writes the rows from `begin` to `end` that lie within what was smoothed, the last one of a piece as well."""
        for start in range(max(begin, self._rows), end, SMOOTHED_EDGES):
            times = self._file["time"][start : min(start + SMOOTHED_EDGES, end)]
            first, last = np.searchsorted(times, smoothed.times[[0, -1]]).tolist()
            last += start + last == end - 1
            if first < last:
                motion = smoothed_at(times[first:last], smoothed, self._run)
                motion = motion if self._ripple is None else self._ripple.motion(motion)
                values = (motion.angle, motion.speed, np.sqrt(motion.angle_variance), np.sqrt(motion.speed_variance))
                for name, column in zip(SMOOTHED, values, strict=True):
                    self._file[name][start + first : start + last] = column
            self._rows = start + last
            check()
            if last < times.size:
                return
