"""How likely a log is under settings of the filter, and under which it is likeliest.

The innovations of a constant-speed Kalman filter are independent and Gaussian where its settings are right, so the
likelihood of a log is a product over its edges. Derived in docs/logs.md.
"""

from collections.abc import Callable
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.numerics.kalman import AngleSpeed, predict, update
from vvdp.offline.edges import Chosen
from vvdp.offline.passage import Noise, Passage, passage_start, passage_step, restarting_step
from vvdp.offline.passed_edges import Passed
from vvdp.sensing.wheel import TURN
from vvdp.simulation.link import quiet
from vvdp.simulation.replay import Replay
from vvdp.simulation.values import flat

FASTEST_CHANGE = 1e4
"""Largest q T^3/R that is tried [1]: the speed is another with each edge."""
SILENT = 16.0
"""After a time between edges of so many usual ones nothing is known any more; missed edges make no such time."""
SELDOM = 0.02
"""Largest share of the edges at which the speed may change suddenly [1]; assumed."""


def time_resolution(times: Array, share: float = 1.0) -> float:
    """The step in which times are written [s]: a power of ten where at least this `share` of them are whole multiples
    of it, else the distance of neighbouring double numbers."""
    largest = float(np.quantile(np.abs(times), share)) if times.size else 0.0
    spacing = float(np.spacing(max(largest, 1e-300)))
    for digits in range(10):
        step = 10.0**-digits
        if spacing > 1e-3 * step:
            break
        parts = times / step
        if np.mean(np.abs(parts - np.round(parts)) < 1e-6 + 2.0 * spacing / step) >= share:
            return step
    return spacing


class Fit(NamedTuple):
    """The likeliest settings, and what they are worth; where a value lies at its floor all below explain the log as
    well."""

    noise: Noise
    log_likelihood: float
    at_floor: tuple[bool, bool]
    edges: int


def first_edges(passed: Passed) -> Chosen:
    """Whether nothing before an edge shows where it should be: a stop or a lost sensor is no noise, nor are edges that
    are numbered from the start after one."""
    steps = np.diff(passed.times)
    silent = (steps > SILENT * np.median(steps)) | (np.abs(np.diff(passed.numbers)) > SILENT)
    return np.concatenate([[True], (np.diff(passed.pieces) != 0.0) | silent])


class Likelihood:
    """The likelihood of the edges of a log under any settings."""

    def __init__(self, passed: Passed, sectors: int, say: Callable[[str], None] = quiet) -> None:
        self.passed, self.sectors = passed, sectors
        self._first = first_edges(passed)
        self._durations = np.where(self._first, 0.0, np.diff(passed.times, prepend=passed.times[0]))
        self._replay = Replay(passage_step, passage_start(), Passage(0.0, 0.0, 0.0, 1.0), Noise(1.0, 1.0), say=say)
        self._rows = self._rows_of(passed.angles)
        self._learnt = 0.0
        self.period = float(np.median(self.steps))
        turned = np.diff(passed.angles, prepend=passed.angles[0])[~self._first]
        self.speed = abs(float(np.sum(turned) / np.sum(self.steps)))

    def _rows_of(self, angles: Array) -> Array:
        steps = np.where(self._first, 0.0, np.diff(angles, prepend=angles[0]))
        return np.column_stack([self._durations, steps, self.passed.sampling_variances, self._first])

    def without_events(self, noise: Noise) -> "Likelihood | None":
        """The same where nothing before a sudden change of the speed counts after it; None if there is none, or if
        changes are not `SELDOM`: they are noise then."""
        run = Replay(restarting_step, passage_start(), Passage(0.0, 0.0, 0.0, 1.0), noise)
        first: Chosen = run(passage_start(), self._rows, noise).shown[:, 0] > 0.0
        if not 0.0 < np.mean(first & ~self._first) < SELDOM:
            return None
        return self._with(_first=first, _durations=np.where(first, 0.0, self._durations))

    def surprises(self, noise: Noise, angles: Array | None = None) -> tuple[Array, Array]:
        """Innovations [rad] and their variances, of the edges that have them."""
        rows = self._rows if angles is None else self._rows_of(angles)
        shown = self._replay.outputs(flat(passage_start()), rows, noise)
        known = shown[shown[:, 1] > 0.0]
        return known[:, 0], known[:, 1]

    def logarithm(self, noise: Noise) -> float:
        """ln L = -1/2 sum(ln(2 pi S) + nu^2/S)."""
        nu, S = self.surprises(noise)
        return -0.5 * float(np.sum(np.log(TURN * S) + nu * nu / S))

    @property
    def pieces(self) -> int:
        """Edges at which nothing before shows where they should be."""
        return int(np.count_nonzero(self._first))

    @property
    def steps(self) -> Array:
        """Times between edges [s]."""
        found: Array = self._durations[~self._first]
        return found

    @property
    def steps_sampled(self) -> Array:
        """Of the edge at the end of each, the variance that is from sampling [rad^2]."""
        found: Array = self.passed.sampling_variances[~self._first]
        return found

    @cached_property
    def sampling_variance(self) -> float:
        """The part of an edge's variance that is from sampling [rad^2]."""
        return float(np.median(self.passed.sampling_variances))

    @property
    def variance_floor(self) -> float:
        """The edge variance below which nothing can be known [rad^2]: (omega dt)^2/12 from the step in which the times
        are written, what the rounding of angles makes, the standard error sqrt(2/n) of the part from sampling, and what
        one edge shows that is as far off as those of a pattern that was taken off."""
        n = self.passed.times.size
        rounding = max(float(np.spacing(np.max(np.abs(self.passed.angles)))) ** 2, self._learnt)
        if self.sampling_variance > 0.0:
            return max(self.sampling_variance * float(np.sqrt(2.0 / n)), rounding)
        return max((self.speed * time_resolution(self.passed.times)) ** 2 / 12.0, rounding)

    def without(self, offsets: Array) -> "Likelihood":
        """The same edges on a wheel whose edges lie `offsets` [rad] further on; their count is the period."""
        moved = self.passed._replace(angles=self.passed.angles + offsets[self._places(offsets.size)])
        learnt = float(np.mean(offsets**2)) / (moved.times.size - offsets.size + 1)
        return self._with(passed=moved, _learnt=learnt)

    def _with(self, **values: Any) -> "Likelihood":
        changed = object.__new__(Likelihood)
        changed.__dict__ |= self.__dict__ | values
        changed._rows = changed._rows_of(changed.passed.angles)
        return changed

    def wheel_angles(self, period: int) -> Array:
        """Where on the wheel the edges lie that follow one another after `period` [rad]; evenly where none passed."""
        found: Array = np.array(np.arange(period) * (TURN / period), float)
        found[self._places(period)] = self.passed.angles
        return found

    def _places(self, period: int) -> "np.ndarray[tuple[int], np.dtype[np.int64]]":
        found: np.ndarray[tuple[int], np.dtype[np.int64]] = np.mod(self.passed.numbers, period).astype(np.int64)
        return found

    def white(self, noise: Noise, period: int) -> tuple[Array, Array]:
        """Innovations over their deviations [1], and by how much each of them grows with the place of each edge, after
        `period` the first again [1/rad]; one row for each edge that has an innovation."""
        return self.white_patterns(noise, (self._places(period)[:, None] == np.arange(period)).astype(float))

    def white_patterns(self, noise: Noise, patterns: Array) -> tuple[Array, Array]:
        """The same of any patterns of the angles, shape (edges, m)."""
        nu, S = self.surprises(noise)
        root = np.sqrt(S)
        return nu / root, np.column_stack([self.surprises(noise, pattern)[0] / root for pattern in patterns.T])


def fit(likelihood: Likelihood) -> Fit:
    """The settings under which the log is likeliest: a grid of decades, then a simplex.

    The search runs over ln R_2, above its floor, and ln(q T^3/R), with R the whole variance of an edge. That is n^-4 at
    least: the filter's time constant (R T/q)^(1/4) is then as long as n edges, and the speed constant as far as they
    show.

    Source  ours, docs/logs.md
    """
    from scipy.optimize import minimize

    n, pitch = likelihood.passed.times.size, TURN / likelihood.sectors
    low = np.log([n**-4.0, likelihood.variance_floor])
    high = np.log([FASTEST_CHANGE, max(pitch**2, 2.0 * likelihood.variance_floor)])

    def noise(place: Array) -> Noise:
        change, variance = np.exp(np.clip(place, low, high))
        return Noise(float(change * (variance + likelihood.sampling_variance) / likelihood.period**3), float(variance))

    def unlikely(place: Array) -> float:
        return -likelihood.logarithm(noise(place)) + float(np.sum((place - np.clip(place, low, high)) ** 2))

    decades = np.ceil((high - low) / np.log(10.0)).astype(int) + 1
    grid = [np.array([a, b]) for a in np.linspace(low[0], high[0], decades[0])
            for b in np.linspace(low[1], high[1], decades[1])]  # fmt: skip
    best = min(grid, key=unlikely)
    simplex = best + np.array([[0.0, 0.0], [1.2, 0.0], [0.0, 1.2]]) * np.where(best < 0.5 * (low + high), 1.0, -1.0)
    done = minimize(
        unlikely, best, method="Nelder-Mead", options={"initial_simplex": simplex, "xatol": 1e-3, "fatol": 1e-4}
    )
    place = np.clip(done.x, low, high)
    # Where the floor is as likely, it is a bound and no estimate.
    at_floor = tuple(
        bool(likelihood.logarithm(noise(np.where(np.arange(2) == i, low, place))) > -done.fun - 0.5) for i in range(2)
    )
    place = np.where(at_floor, low, place)
    found = noise(place)
    return Fit(found, likelihood.logarithm(found), at_floor, n)  # type: ignore[arg-type]


class Errors(NamedTuple):
    """Just after an edge, the deviation that the filter states, and the one that it has: of the speed [rad/s] and of
    the angle [rad]."""

    stated: float
    true: float
    angle_stated: float
    angle_true: float


def speed_errors(likelihood: Likelihood, taken: Noise, true: Noise) -> Errors:
    """How well a filter with settings `taken` knows the speed of a log whose noise is `true`, mean square over it.

    With the gain K of its own covariance: P = (I - K H')(F P F' + Q)(I - K H')' + K R K', Q and R the true ones.

    Source  ours, docs/logs.md
    """
    steps, sampled = likelihood.steps.tolist(), likelihood.steps_sampled.tolist()
    stated, real = (_after_two(steps[0], sampled[0] + n.edge_variance, n.acceleration_density) for n in (taken, true))
    sums, late = np.zeros(4), len(steps) // 4
    for k, (h, R) in enumerate(zip(steps, sampled, strict=True)):
        stated = predict(stated, h, taken.acceleration_density)
        b = predict(real, h, true.acceleration_density)
        R_taken, R_true = R + taken.edge_variance, R + true.edge_variance
        S = stated.angle_variance + R_taken
        k1, k2, left = stated.angle_variance / S, stated.covariance / S, R_taken / S
        P11, P12 = b.angle_variance, b.covariance
        real = AngleSpeed(
            0.0,
            0.0,
            left * left * P11 + k1 * k1 * R_true,
            left * (P12 - k2 * P11) + k1 * k2 * R_true,
            b.speed_variance + k2 * (k2 * P11 - 2.0 * P12) + k2 * k2 * R_true,
        )
        stated = update(stated, 0.0, R_taken)
        if k >= late:
            sums += (stated.speed_variance, real.speed_variance, stated.angle_variance, real.angle_variance)
    return Errors(*np.sqrt(sums / (len(steps) - late)).tolist())


def _after_two(h: float, R: float, q: float) -> AngleSpeed:
    """What two edges show."""
    return AngleSpeed(0.0, 0.0, R, R / h, 2.0 * R / (h * h) + q * h / 3.0)
