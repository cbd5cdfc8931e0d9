"""The second pass over a record: every row again, given the edges before and after it (Rauch, Tung, Striebel)."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.estimation.smoother import Smoothed, smoothed_at, smoothed_portions, smoothing_overlap
from vvdp.numerics.kalman import AngleSpeed
from vvdp.offline.config import Estimation
from vvdp.offline.estimate_result import SMOOTHED
from vvdp.offline.interrupt import Stopped
from vvdp.offline.turn_pattern import SpeedRipple
from vvdp.simulation.replay import Replay

SMOOTHED_EDGES = 50_000
FORGOTTEN = 1e-4
"""Edges count for a smoothed instant until their share has fallen to this."""


class SecondPass:
    """Smooths the rows and edges of an open result.h5, whose smoothed columns are there and NaN.

    ripple  what the log has of the ripple that the filter is told of; None where it is told of none
    """

    def __init__(self, file: Any, wanted: Estimation, ripple: SpeedRipple | None, say: Callable[[str], None]) -> None:
        self._file, self._ripple, self._say = file, ripple, say
        self._filter, self._sectors = wanted.filter, len(wanted.wheel.edges)
        self._runs: dict[Any, Replay] = {}
        self._rows = 0

    def through(self, progress: Callable[[float], None], check: Callable[[], None]) -> str:
        """Smooths piece by piece; where it was stopped, by `check` or by a KeyboardInterrupt in `progress`, in words,
        empty if nowhere."""
        pieces, numbers = self._file["piece"][:], self._file["edges/piece"][:]
        try:
            for piece in np.unique(numbers):
                check()
                first, last = np.searchsorted(numbers, [piece, piece + 0.5])
                begin, end = np.searchsorted(pieces, [piece, piece + 0.5])
                for smoothed in self._smooth(int(first), int(last)):
                    self._write(smoothed, int(begin), int(end), check)
                    try:
                        progress(self._rows / pieces.size)
                    except KeyboardInterrupt:
                        raise Stopped from None
        except Stopped:
            if self._rows < pieces.size:
                time, piece = (self._file[name][self._rows] for name in ("time", "piece"))
                where = f"from {time:.6g} s of piece {piece:g} on"
                return f"The second pass was stopped; {where} the smoothed columns are NaN."
        return ""

    def _run(self, step: Any, memory: Any, row: Any, settings: Any, rows: Array) -> tuple[Any, Array]:
        if step not in self._runs:
            self._runs[step] = Replay(step, memory, row, settings, say=self._say)
        done = self._runs[step](memory, rows, settings)
        return done.memory, done.shown

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
        file = self._file
        times = file["time"][begin:end]
        a, b = np.searchsorted(times, smoothed.times[[0, -1]])
        if begin + b < end and b == times.size - 1:
            b = times.size
        for start in range(int(a), int(b), SMOOTHED_EDGES):
            stop = min(start + SMOOTHED_EDGES, int(b))
            motion = smoothed_at(times[start:stop], smoothed, self._run)
            motion = motion if self._ripple is None else self._ripple.motion(motion)
            values = (motion.angle, motion.speed, np.sqrt(motion.angle_variance), np.sqrt(motion.speed_variance))
            for name, column in zip(SMOOTHED, values, strict=True):
                file[name][begin + start : begin + stop] = column
            self._rows = begin + stop
            check()
