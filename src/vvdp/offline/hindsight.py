"""What later edges say of rows that were given before them: a stop or a manoeuvre shows once its edges have come.

Derived in docs/logs.md, "Hindsight".

Source  ours, docs/logs.md
"""

from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.offline.alignment import usual_steps
from vvdp.offline.estimate_result import AT_ONCE, piece_rows
from vvdp.offline.hypotheses import FAR_NEIGHBOURS
from vvdp.offline.noise_fit import SILENT
from vvdp.offline.sums import STANDING

AHEAD = (1, 2, 4)
"""A row is held against the mean speeds from the edge before it to edges so far after that."""
CONTRADICTED = 3.0
"""... and is contradicted by a difference of so many standard deviations of it."""


def look_back(file: Any, ripple: float, scatter: float, pitch: float) -> None:
    """Where the edges around a row contradict its speed, its deviations have the whole difference: writes them into an
    open result.h5. A row at a standstill is not judged.

    ripple   variance of the speed within a turn that the filter knows of, over its square [1]
    scatter  by which the variance of an edge's angle is larger than the filter takes it to be [rad^2]
    pitch    of the edges; a wheel that stands at the end of a piece does so within one [rad]
    """
    rows = piece_rows(file, "")
    for piece, (first, end) in piece_rows(file, "edges/").items():
        time, angle, variance = (file[f"edges/{name}"][first:end] for name in ("time", "angle", "variance"))
        used = np.isfinite(angle) & (np.diff(time, prepend=-np.inf) > 0.0)
        if piece not in rows or np.count_nonzero(used) < 2:
            continue
        edges = np.array([time[used], angle[used], np.fmax(variance[used] + scatter, 0.0)])
        last = rows[piece][1] - 1
        if file["standstill"][last] > STANDING:
            stands = [[file["time"][last]], [edges[1, -1] + 0.5 * pitch], [pitch * pitch / 12.0]]
            edges = np.append(edges, stands, axis=1)
        for begin in range(rows[piece][0], rows[piece][1], AT_ONCE):
            part = slice(begin, min(begin + AT_ONCE, rows[piece][1]))
            shown = {name: file[name][part] for name in ("time", "speed", "standstill", *_CHANGED)}
            for name, more in contradictions(shown, edges, ripple).items():
                if np.any(more):
                    file[name][part] = np.sqrt(shown[name] ** 2 + more)


def count_deviation(file: Any) -> float:
    """Standard deviation of the number by which edges of an open result.h5 may be counted wrongly [1]: of what the
    filter counted, less what the times between edges say, about the mean of each piece."""
    squares, count = 0.0, 0
    for first, end in piece_rows(file, "edges/").values():
        time, number = (file[f"edges/{name}"][first:end] for name in ("time", "number"))
        used = np.isfinite(number) & (np.diff(time, prepend=-np.inf) > 0.0)
        steps, counted = np.diff(time[used]), np.diff(number[used])
        if not steps.size:
            continue
        counted *= np.sign(np.sum(counted))  # backwards numbers fall
        passed = np.fmax(np.round(steps / usual_steps(steps, FAR_NEIGHBOURS)), 1.0)
        off = np.cumsum(np.where(passed < SILENT, passed - counted, 0.0))
        squares, count = squares + off.size * float(np.var(off)), count + off.size
    return float(np.sqrt(squares / count)) if count else 0.0


_CHANGED = ("speed_deviation", "angle_deviation")


def contradictions(rows: dict[str, Array], edges: Array, ripple: float) -> dict[str, Array]:
    """Variances to add to the deviations of `rows` [rad^2/s^2, rad^2], 0 where nothing contradicts the speed.

    edges   of the piece, shape (3, n): times, rising [s], angles [rad] and their variances [rad^2]
    ripple  as of `look_back`
    """
    times, angles, variances = edges
    after = np.searchsorted(times, rows["time"], side="right")
    known = (after > 0) & (after < times.size) & (rows["standstill"] < STANDING) & np.isfinite(rows["speed"])
    low, worst = np.clip(after - 1, 0, None), np.zeros(after.size)
    for ahead in AHEAD:
        high = np.clip(after - 1 + ahead, None, times.size - 1)
        lasts = np.where(known & (high > low), times[high] - times[low], np.inf)
        noise = (variances[high] + variances[low]) / lasts**2 + ripple * rows["speed"] ** 2
        square = np.where(np.isfinite(lasts), (rows["speed"] - (angles[high] - angles[low]) / lasts) ** 2, 0.0)
        told = square > CONTRADICTED**2 * (rows["speed_deviation"] ** 2 + noise)
        worst = np.fmax(worst, np.where(told, square - noise, 0.0))
    return {"speed_deviation": worst, "angle_deviation": worst * (rows["time"] - times[low]) ** 2}
