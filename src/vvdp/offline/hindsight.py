"""What later edges say of rows that were given before them: a stop or a manoeuvre shows once its edges have come.

Derived in docs/logs.md, "Hindsight".

Source  ours, docs/logs.md
"""

from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.estimation.smoother import Run
from vvdp.offline.alignment import usual_steps
from vvdp.offline.course import Course, Explanation, course_of, squared_errors
from vvdp.offline.estimate_result import ROWS_IN_CHUNK, piece_rows
from vvdp.offline.hypotheses import FAR_NEIGHBOURS
from vvdp.offline.likelihood import SILENT
from vvdp.offline.speed_doubt import Doubt
from vvdp.offline.sums import STANDING
from vvdp.simulation.replay import Compiled

ROWS = 4 * ROWS_IN_CHUNK
"""Rows that are judged at once ..."""
MARGIN = 5000
"""... with so many edges before and after them; a filter remembers fewer."""
AHEAD = (1, 2, 4)
"""A row is held against the mean speeds from the edge before it to edges so far after that."""
CONTRADICTED = 3.0
"""... and is contradicted by a difference of so many standard deviations of it."""


class View(NamedTuple):
    """What is known of a record once it is at hand as a whole."""

    why: Explanation | None
    """What it is best explained by; None: rows change only where edges contradict them."""
    doubt: Doubt
    ripple: float
    """Variance of the speed within a turn that the filter knows of, over its square [1]."""
    pitch: float
    """Of the edges [rad]; a wheel that stands at the end of a piece does so within one."""


def look_back(file: Any, view: View, prefix: str = "") -> None:
    """Gives the rows of an open result.h5 the standard deviations that they have as the whole record shows, with the
    doubt. At a standstill only the doubt counts.

    prefix  of the columns, "smoothed_" those of the smoother
    """
    rows, run = piece_rows(file, ""), Compiled()
    for piece, (first, end) in piece_rows(file, "edges/").items():
        if piece not in rows:
            continue
        begin, after = rows[piece]
        met, stands = file["edges/time"][first:end], file["standstill"][after - 1] > STANDING
        for start in range(begin, after, ROWS):
            part = slice(start, min(start + ROWS, after))
            shown = {name: file[name][part] for name in ("time", "standstill")}
            shown |= {name: file[f"{prefix}{name}"][part] for name in ("angle", "speed", *_CHANGED)}
            low, high = np.searchsorted(met, shown["time"][[0, -1]]).tolist()
            around = slice(first + max(low - MARGIN, 0), first + min(high + MARGIN, met.size))
            edges, course = _edges(file, around, view, run)
            if stands and around.stop == end and edges.shape[1] > 1:
                stop = [[file["time"][after - 1]], [edges[1, -1] + 0.5 * view.pitch], [view.pitch**2 / 12.0]]
                edges, course = np.append(edges, stop, axis=1), None if course is None else course.before_stop()
            found = seen_afterwards(shown, edges, course, view.ripple, run)
            for name, column in view.doubt.add_to(found, shown["speed"], shown["standstill"] > STANDING).items():
                file[f"{prefix}{name}"][part] = np.sqrt(column)


def _edges(file: Any, around: slice, view: View, run: Run) -> tuple[Array, Course | None]:
    """Times [s], angles [rad] and variances [rad^2] of those edges of a piece that were used, and its course there."""
    columns = (file[f"edges/{name}"][around] for name in ("time", "angle", "variance", "sector"))
    time, angle, variance, sector = columns
    used = np.isfinite(angle) & (np.diff(time, prepend=-np.inf) > 0.0)
    edges = np.array([time[used], angle[used], variance[used]])
    if view.why is None or edges.shape[1] < 2:
        return edges, None
    course = course_of(edges, sector[used].astype(int), view.why, run)
    edges[2] = np.fmax(edges[2] - view.why.told_variance, 0.0) + view.why.noise.edge_variance
    return edges, course


def seen_afterwards(
    rows: dict[str, Array], edges: Array, course: Course | None, ripple: float, run: Run
) -> dict[str, Array]:
    """Variances of `rows` [rad^2/s^2, rad^2]: mean squares of their errors where the course is known, the largest that
    there may be where the speed changed suddenly; without a course their own and what the edges contradict."""
    if course is None:
        return {name: rows[name] ** 2 + more for name, more in contradictions(rows, edges, ripple).items()}
    chosen, squares = squared_errors(rows, course, run)
    found = {f"{name}_deviation": column for name, column in squares.items()}
    rest = np.flatnonzero(~chosen)
    others = {name: column[rest] for name, column in rows.items()}
    for name, most in sudden(others, edges).items():
        found[name][rest] = np.fmax(others[name] ** 2, most)
    return found


def sudden(rows: dict[str, Array], edges: Array) -> dict[str, Array]:
    """Squares of the largest errors that `rows` may have if the speed changes between the edges around them
    [rad^2/s^2, rad^2]; 0 beyond the edges, and at a standstill.

    The speed goes from that of the interval before to that of the one after, evenly down and up or up and down: with
    the mean m between these edges it turns round at 2 m - (before + after)/2, or at 0.

    edges  as of `contradictions`
    """
    times, angles, _ = edges
    means = np.diff(angles) / np.diff(times)
    place = np.searchsorted(times, rows["time"], side="right") - 1
    inside = (place >= 0) & (place < means.size) & (rows["standstill"] < STANDING) & np.isfinite(rows["speed"])
    here = np.clip(place, 0, means.size - 1)
    before, after = means[np.fmax(here - 1, 0)], means[np.fmin(here + 1, means.size - 1)]
    turning = 2.0 * means[here] - 0.5 * (before + after)
    turning = np.where(turning * means[here] > 0.0, turning, 0.0)
    worst = np.max([(rows["speed"] - speed) ** 2 for speed in (before, after, turning)], axis=0)
    speed = np.where(inside, worst, 0.0)
    return {"speed_deviation": speed, "angle_deviation": speed * (rows["time"] - times[here]) ** 2}


def count_deviation(file: Any, *, many: bool) -> float:
    """Standard deviation of the number by which edges of an open result.h5 may be counted wrongly [1]: of what the
    filter counted, less what the times between edges say, about the mean of each piece.

    many  edges are missed; else only those that the filter takes to be missed count
    """
    squares, count = 0.0, 0
    for first, end in piece_rows(file, "edges/").values():
        time, number = (file[f"edges/{name}"][first:end] for name in ("time", "number"))
        used = np.isfinite(number) & (np.diff(time, prepend=-np.inf) > 0.0)
        steps, counted = np.diff(time[used]), np.diff(number[used])
        if not steps.size:
            continue
        counted *= np.sign(np.sum(counted))  # backwards numbers fall
        passed = np.fmax(np.round(steps / usual_steps(steps, FAR_NEIGHBOURS)), 1.0)
        judged = (passed < SILENT) & (many | (counted != 1.0))
        off = np.cumsum(np.where(judged, passed - counted, 0.0))
        squares, count = squares + off.size * float(np.var(off)), count + off.size
    return float(np.sqrt(squares / count)) if count else 0.0


_CHANGED = ("speed_deviation", "angle_deviation")


def contradictions(rows: dict[str, Array], edges: Array, ripple: float) -> dict[str, Array]:
    """Variances to add to the deviations of `rows` [rad^2/s^2, rad^2], 0 where nothing contradicts the speed.

    edges   of the piece, shape (3, n): times, rising [s], angles [rad] and their variances [rad^2]
    ripple  as of `View`
    """
    times, angles, variances = edges
    if times.size < 2:
        return dict.fromkeys(_CHANGED, np.zeros(rows["time"].size))
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
