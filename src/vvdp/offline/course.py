"""The course of the spool as the whole record has it, and how far rows are from it.

Derived in docs/logs.md, "Hindsight".

Source  ours, docs/logs.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.estimation.smoother import Beliefs, Run, Smoothed, smooth_edges, smoothed_at
from vvdp.numerics.kalman import AngleSpeed
from vvdp.offline.edges import Chosen
from vvdp.offline.likelihood import SELDOM, SILENT
from vvdp.offline.passage import Noise, Passage, passage_start, restarting_step
from vvdp.offline.sums import STANDING
from vvdp.offline.turn_pattern import SpeedRipple

AROUND = 8
"""The mean square of the errors of a row is that of the rows between so many edges before and after it."""
SUDDEN = 3.0
"""A row that is off by so many times the root of that mean square counts by itself."""
VAGUE = 100.0
"""Before the first two edges of a course so many times their variance is taken for that of its start."""


class Explanation(NamedTuple):
    """What a record is smoothed with: the likeliest settings, the variance of an edge that the filter was given
    [rad^2], by how much each edge of the wheel lies further on [rad], and the ripple that the filter estimates."""

    noise: Noise
    told_variance: float
    offsets: Array
    ripple: SpeedRipple | None


class Course(NamedTuple):
    """The smoothed course of a piece, and the ripple on it; `known` says between which edges, each and the next one,
    it holds: not where the speed changed suddenly, nor one edge before or after that, where the change may have begun
    and gone on."""

    smoothed: Smoothed
    known: Chosen
    ripple: SpeedRipple | None

    def before_stop(self) -> "Course":
        """The same of a piece after whose last edge the spool stands."""
        return self._replace(known=np.append(self.known[:-1], False))


def course_of(edges: Array, sectors: Array, why: Explanation, run: Run) -> Course | None:
    """The course of a piece; None where the speed changes suddenly too often: then noise is more than is thought.

    edges    shape (3, n): times, rising [s], angles [rad] and their variances as the filter has them [rad^2]
    sectors  of the edges on the wheel
    """
    times, angles = edges[0], edges[1] + why.offsets[sectors]
    sampled = np.fmax(edges[2] - why.told_variance, 0.0)
    steps = np.diff(times, prepend=times[0])
    silent = steps > SILENT * np.median(steps[1:])
    silent[0] = True
    passages = np.column_stack([steps, np.diff(angles, prepend=angles[0]), sampled, silent])
    shown = run(restarting_step, passage_start(), Passage(0.0, 0.0, 0.0, 1.0), why.noise, passages)[1]
    begins = shown[:, 0] > 0.0
    if np.mean(begins & ~silent) > SELDOM:
        return None
    seen = np.array([times, angles, sampled + why.noise.edge_variance])
    parts = [_smooth(part, why.noise, run) for part in np.split(seen, np.flatnonzero(begins)[1:], axis=1)]
    beliefs = Beliefs(*(np.concatenate(column) for column in zip(*(each.beliefs for each in parts), strict=True)))
    gap = np.zeros((1, 2, 2))
    lagged = np.concatenate([lag for each in parts for lag in (each.lagged, gap)])[:-1]
    known = ~(begins[1:] | begins[:-1] | np.append(begins[2:], False))
    return Course(Smoothed(times, beliefs, lagged, why.noise.acceleration_density), known, why.ripple)


def _smooth(edges: Array, noise: Noise, run: Run) -> Smoothed:
    """Edges without a sudden change of the speed; of one alone nothing is used."""
    times, angles, variances = edges
    q = noise.acceleration_density
    if times.size < 2:
        return Smoothed(times, Beliefs(angles, *np.zeros((4, 1))), np.empty((0, 2, 2)), q)
    step = float(times[1] - times[0])
    vague = VAGUE * float(variances[0])
    start = AngleSpeed(float(angles[0]), float(angles[1] - angles[0]) / step, vague, 0.0, vague / (step * step))
    return smooth_edges(times, angles, variances, q, start, run)


def squared_errors(rows: dict[str, Array], course: Course, run: Run) -> tuple[Chosen, dict[str, Array]]:
    """Which of the `rows` (columns time, angle, speed, standstill) move where the course is known, and of these the
    mean squared errors of the angle [rad^2] and of the speed [rad^2/s^2]; NaN of the others.

    An estimate x made of the same edges has E (x_true - x)^2 = P + (x_s - x)^2, x_s the smoothed value and P its
    variance: the error of x_s is independent of all that the edges say. Its mean is that of the rows around.
    """
    times = course.smoothed.times
    place = np.searchsorted(times, rows["time"], side="right") - 1
    chosen = (place >= 0) & (place < times.size - 1) & np.isfinite(rows["speed"]) & (rows["standstill"] < STANDING)
    chosen[chosen] = course.known[place[chosen]]
    found = {name: np.full(chosen.size, np.nan) for name in ("angle", "speed")}
    if not np.any(chosen):
        return chosen, found
    place = place[chosen]
    first, last = int(place[0]), int(place[-1]) + 2
    motion = smoothed_at(rows["time"][chosen], _part(course.smoothed, first, last), run)
    motion = motion if course.ripple is None else course.ripple.motion(motion)
    seen = {"angle": (motion.angle, motion.angle_variance), "speed": (motion.speed, motion.speed_variance)}
    for name, (true, variance) in seen.items():
        found[name][chosen] = _around(place - first, (rows[name][chosen] - true) ** 2 + variance)
    return chosen, found


def _part(whole: Smoothed, first: int, last: int) -> Smoothed:
    beliefs = Beliefs(*(column[first:last] for column in whole.beliefs))
    return Smoothed(whole.times[first:last], beliefs, whole.lagged[first : last - 1], whole.acceleration_density)


def _around(place: "np.ndarray[tuple[int], np.dtype[np.int64]]", own: Array) -> Array:
    """Means over the rows between `AROUND` edges before and after each; what is far above that stays."""
    count, total = (np.append(0.0, np.cumsum(np.bincount(place, weights))) for weights in (None, own))
    low, high = np.clip(place - AROUND, 0, None), np.clip(place + AROUND + 1, None, count.size - 1)
    usual = (total[high] - total[low]) / (count[high] - count[low])
    found: Array = np.where(own > SUDDEN * SUDDEN * usual, own, usual)
    return found
