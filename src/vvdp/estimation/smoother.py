"""Angle and speed of a logged record, from all its edges: those before an instant and those after it.

The model is that of the event filter, a speed that is a random walk. `filter_edges` goes forward over the edges,
`smooth_edges` goes forward and back, `smoothed_at` fills in any instant. The two passes are steps over rows, so
a caller may hand in a compiled `run`. Derived in docs/models/smoother.md.

Source  ours, docs/models/smoother.md, where a function names no other.
"""

from collections.abc import Callable, Iterable, Iterator
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.conservation import NOTHING, Nothing
from vvdp.base.errors import ParameterError
from vvdp.base.kinds import ANGULAR_VARIANCE, AccelerationDensity
from vvdp.base.params import Params
from vvdp.base.rules import require_positive, require_positive_value
from vvdp.numerics.kalman import AngleSpeed, predict, update

Step = Callable[[Any, Any, Any], tuple[Any, Any]]
Run = Callable[[Step, Any, Any, Any, Array], tuple[Any, Array]]
"""Takes a step, its memory, a row as an example, settings and rows (n, m); returns the memory and what was shown."""


class SpeedWalk(Params):
    """The model: an acceleration that is white noise."""

    acceleration_density: AccelerationDensity

    def check(self) -> None:
        """Refuse a speed that cannot change: the portions could not be smoothed independently."""
        require_positive(self, "acceleration_density")


class EdgePassed(NamedTuple):
    """An edge: when [s], its unwrapped angle [rad] and the variance of that [rad^2]."""

    time: float
    angle: float
    variance: float


class Reached(NamedTuple):
    """A belief and the time it holds at."""

    time: float
    belief: AngleSpeed


class Forward(NamedTuple):
    """Belief of the forward pass just after the edge at `time`."""

    time: float
    angle: float
    speed: float
    angle_variance: float
    covariance: float
    speed_variance: float


class Drawn(NamedTuple):
    """A smoothed belief and its covariances with the smoothed state at the edge after it, the later state second."""

    angle: float
    speed: float
    angle_variance: float
    covariance: float
    speed_variance: float
    angle_angle: float
    angle_speed: float
    speed_angle: float
    speed_speed: float


class Between(NamedTuple):
    """An instant between two edges: `since` the first [s], `interval` between both [s], the smoothed beliefs at both
    with their covariances as in `Drawn`; `turned` is how much further on the second angle lies [rad]."""

    since: float
    interval: float
    angle: float
    speed: float
    angle_variance: float
    covariance: float
    speed_variance: float
    turned: float
    later_speed: float
    later_angle_variance: float
    later_covariance: float
    later_speed_variance: float
    angle_angle: float
    angle_speed: float
    speed_angle: float
    speed_speed: float


class Beliefs(NamedTuple):
    """Beliefs over time, each an array (n,): angle [rad] and speed [rad/s], their variances and covariance."""

    angle: Array
    speed: Array
    angle_variance: Array
    covariance: Array
    speed_variance: Array


class Smoothed(NamedTuple):
    """The motion at the edges given all of them, and `lagged` (n - 1, 2, 2): Cov(state, state at the next edge)."""

    times: Array
    beliefs: Beliefs
    lagged: Array
    acceleration_density: float


def filtered_step(memory: Reached, edge: EdgePassed, walk: SpeedWalk) -> tuple[Reached, AngleSpeed]:
    """The belief after an edge, from that after the edge before.

    Source  wang2017, eqs. 3.5 to 3.9, corrected: docs/errata.md
    """
    prior = predict(memory.belief, edge.time - memory.time, walk.acceleration_density)
    belief = update(prior, edge.angle - prior.angle, edge.variance)
    return Reached(edge.time, belief), belief


def smoothed_step(memory: Reached, row: Forward, walk: SpeedWalk) -> tuple[Reached, Drawn]:
    """The belief at an edge given all edges, from that at the edge after it and the one of the forward pass.

    G = P F' M^-1 with M = F P F' + Q;  x_s = x + G (x_s' - F x);  P_s = L P L' + G (Q + P_s') G' with L = I - G F,
    which is P + G (P_s' - M) G' as a sum of positive terms;  Cov(x_s, x_s') = G P_s'.

    Source  rauch1965; docs/models/smoother.md
    """
    h, q = memory.time - row.time, walk.acceleration_density
    a, b, c = row.angle_variance, row.covariance, row.speed_variance
    later = memory.belief
    prior = predict(AngleSpeed(row.angle, row.speed, a, b, c), h, q)
    m11, m12, m22 = prior.angle_variance, prior.covariance, prior.speed_variance
    determinant = m11 * m22 - m12 * m12
    g11, g12 = ((a + h * b) * m22 - b * m12) / determinant, (b * m11 - (a + h * b) * m12) / determinant
    g21, g22 = ((b + h * c) * m22 - c * m12) / determinant, (c * m11 - (b + h * c) * m12) / determinant
    q11, q12, q22 = h * h * h / 3.0 * q, h * h / 2.0 * q, h * q
    # L as F^-1 Q M^-1 F: no difference of nearly equal numbers while the prior is vague.
    w11, w12 = (q11 * m22 - q12 * m12) / determinant, (q12 * m11 - q11 * m12) / determinant
    l21, w22 = (q12 * m22 - q22 * m12) / determinant, (q22 * m11 - q12 * m12) / determinant
    l22 = w22 + h * l21
    l11, l12 = w11 - h * l21, w12 + h * (w11 - l22)
    n11, n12, n22 = q11 + later.angle_variance, q12 + later.covariance, q22 + later.speed_variance
    angle, speed = later.angle - prior.angle, later.speed - prior.speed
    belief = AngleSpeed(
        row.angle + g11 * angle + g12 * speed,
        row.speed + g21 * angle + g22 * speed,
        l11 * l11 * a + 2.0 * l11 * l12 * b + l12 * l12 * c + g11 * g11 * n11 + 2.0 * g11 * g12 * n12 + g12 * g12 * n22,
        l11 * l21 * a
        + (l11 * l22 + l12 * l21) * b
        + l12 * l22 * c
        + g11 * g21 * n11
        + (g11 * g22 + g12 * g21) * n12
        + g12 * g22 * n22,
        l21 * l21 * a + 2.0 * l21 * l22 * b + l22 * l22 * c + g21 * g21 * n11 + 2.0 * g21 * g22 * n12 + g22 * g22 * n22,
    )
    drawn = Drawn(
        angle=belief.angle,
        speed=belief.speed,
        angle_variance=belief.angle_variance,
        covariance=belief.covariance,
        speed_variance=belief.speed_variance,
        angle_angle=g11 * later.angle_variance + g12 * later.covariance,
        angle_speed=g11 * later.covariance + g12 * later.speed_variance,
        speed_angle=g21 * later.angle_variance + g22 * later.covariance,
        speed_speed=g21 * later.covariance + g22 * later.speed_variance,
    )
    return Reached(row.time, belief), drawn


def bridged_step(memory: Nothing, row: Between, walk: SpeedWalk) -> tuple[Nothing, AngleSpeed]:
    """The belief at an instant between two edges; it takes floats or arrays.

    With s = since/h and r = 1 - s the mean is the cubic through both angles with both speeds as slopes; what
    neither edge shows has the covariance q [[h^3 s^3 r^3/3, h^2 s^2 r^2 (r - s)/2], [., h s r (1 - 3 s r)]].

    Source  ours, docs/models/smoother.md
    """
    h, q = row.interval, walk.acceleration_density
    s = row.since / h
    r = 1.0 - s
    sr = s * r
    # What the angle at the instant takes of angle and speed at the edge before and at the one after; then the speed.
    a1, a2, a3, a4 = r * r * (1.0 + 2.0 * s), h * r * sr, s * s * (1.0 + 2.0 * r), -h * s * sr
    w1, w2, w3, w4 = -6.0 * sr / h, r * (r - 2.0 * s), 6.0 * sr / h, s * (s - 2.0 * r)
    P11, P12, P22 = row.angle_variance, row.covariance, row.speed_variance
    N11, N12, N22 = row.later_angle_variance, row.later_covariance, row.later_speed_variance
    C11, C12, C21, C22 = row.angle_angle, row.angle_speed, row.speed_angle, row.speed_speed
    # Covariances of the speed at the instant with the four.
    v1, v2 = P11 * w1 + P12 * w2 + C11 * w3 + C12 * w4, P12 * w1 + P22 * w2 + C21 * w3 + C22 * w4
    v3, v4 = C11 * w1 + C21 * w2 + N11 * w3 + N12 * w4, C12 * w1 + C22 * w2 + N12 * w3 + N22 * w4
    before = a1 * (P11 * a1 + 2.0 * P12 * a2) + a2 * a2 * P22
    after = a3 * (N11 * a3 + 2.0 * N12 * a4) + a4 * a4 * N22
    across = a1 * (C11 * a3 + C12 * a4) + a2 * (C21 * a3 + C22 * a4)
    return memory, AngleSpeed(
        # The angle is counted from that of the edge before: it may be large, and the weights of both angles sum to 1.
        row.angle + (a2 * row.speed + a3 * row.turned + a4 * row.later_speed),
        w2 * row.speed + w3 * row.turned + w4 * row.later_speed,
        before + after + 2.0 * across + q * (h * sr) * (h * sr) * (h * sr) / 3.0,
        a1 * v1 + a2 * v2 + a3 * v3 + a4 * v4 + q * (h * sr) * (h * sr) * (r - s) / 2.0,
        w1 * v1 + w2 * v2 + w3 * v3 + w4 * v4 + q * h * sr * (1.0 - 3.0 * sr),
    )


def run_on_columns(step: Step, memory: Any, row: Any, settings: Any, rows: Array) -> tuple[Any, Array]:
    """A step without memory taken over all rows at once, its row made of columns; else as `run_plainly`."""
    _, shown = step(memory, type(row)._make(rows.T), settings)
    return memory, np.column_stack(shown)


def run_plainly(step: Step, memory: Any, row: Any, settings: Any, rows: Array) -> tuple[Any, Array]:
    """A step taken over rows in plain Python: the memory reached, and what was shown, shape (rows, numbers shown)."""
    make, shown = type(row)._make, []
    for numbers in rows.tolist():
        memory, out = step(memory, make(numbers), settings)
        shown.append(out)
    return memory, np.array(shown)


def filter_edges(
    times: Array,
    angles: Array,
    variances: Array,
    acceleration_density: float,
    prior: AngleSpeed,
    run: Run = run_plainly,
) -> Beliefs:
    """The motion at the edges, each given the edges up to it: the event filter without association, shape (n,).

    times                 of the edges, increasing [s]
    angles                of the edges, unwrapped [rad]
    variances             of the angles [rad^2]
    acceleration_density  q [rad^2/s^3]
    prior                 belief at times[0] without the edge there
    run                   what takes a step over rows; `run_plainly`, or a compiled one

    Raises ParameterError for arrays that do not fit, times that do not increase or variances that are not positive.
    """
    rows = _rows(times, angles, variances)
    walk = SpeedWalk(acceleration_density=acceleration_density)
    start = Reached(float(rows[0, 0]), prior)
    return Beliefs(*run(filtered_step, start, EdgePassed(0.0, 0.0, 1.0), walk, rows)[1].T)


def smooth_edges(
    times: Array,
    angles: Array,
    variances: Array,
    acceleration_density: float,
    prior: AngleSpeed,
    run: Run = run_plainly,
) -> Smoothed:
    """The motion at the edges, each given all edges; arguments and errors are those of `filter_edges`.

    Source  rauch1965; docs/models/smoother.md
    """
    forward = filter_edges(times, angles, variances, acceleration_density, prior, run)
    return _drawn_back(np.array(times, float), forward, acceleration_density, run)


def _drawn_back(times: Array, forward: Beliefs, acceleration_density: float, run: Run) -> Smoothed:
    rows = np.column_stack([times, *forward])
    if times.size == 1:
        return Smoothed(times, forward, np.empty((0, 2, 2)), acceleration_density)
    walk = SpeedWalk(acceleration_density=acceleration_density)
    row = Forward(*rows[-1].tolist())
    back = run(smoothed_step, Reached(row.time, AngleSpeed(*row[1:])), row, walk, rows[-2::-1])[1][::-1]
    motion = np.vstack([back[:, :5], rows[-1, 1:]]).T
    return Smoothed(times, Beliefs(*motion), back[:, 5:].reshape(-1, 2, 2), acceleration_density)


def _rows(times: Array, angles: Array, variances: Array) -> Array:
    sizes = [np.shape(values) for values in (times, angles, variances)]
    if len(set(sizes)) > 1 or len(sizes[0]) != 1 or sizes[0][0] == 0:
        raise ParameterError(f"times, angles and variances of shapes {sizes}; expected three times (n,), n at least 1")
    rows = np.column_stack([times, angles, variances]).astype(float)
    if not np.isfinite(rows).all():
        raise ParameterError(f"{np.count_nonzero(~np.isfinite(rows))} numbers of the edges are not finite")
    steps = np.diff(rows[:, 0])
    if not (steps > 0.0).all():
        i = int(np.argmin(steps))
        raise ParameterError(
            f"edge {i + 1} at {rows[i + 1, 0]:.9g} s follows one at {rows[i, 0]:.9g} s; expected increasing times"
        )
    require_positive_value("smallest variance of an edge", float(rows[:, 2].min()), ANGULAR_VARIANCE)
    return rows


def smoothed_at(times: Array, smoothed: Smoothed, run: Run = run_on_columns) -> Beliefs:
    """The motion at any `times` [s], shape (m,), given all edges.

    Outside of the edges the nearest state is carried on, with noise that grows both ways.

    run  what takes `bridged_step` over rows: `run_on_columns`, or a compiled one
    """
    t, n = np.asarray(times, float), smoothed.times.size
    left = np.searchsorted(smoothed.times, t, side="right") - 1
    outside = (left < 0) | (left >= n - 1)
    motion = np.empty((t.size, 5))
    if not outside.all():
        rows = np.take(_bridges(smoothed), np.clip(left, 0, n - 2), axis=0)
        rows[:, 0] = t - rows[:, 0]
        walk = SpeedWalk(acceleration_density=smoothed.acceleration_density)
        motion = run(bridged_step, NOTHING, Between(*rows[0].tolist()), walk, rows)[1]
    if outside.any():
        nearest = np.clip(left[outside], 0, n - 1)
        states, since = np.column_stack(smoothed.beliefs)[nearest], t[outside] - smoothed.times[nearest]
        motion[outside] = np.column_stack(_predict_either_way(states, since, smoothed.acceleration_density))
    return Beliefs(*motion.T)


def _bridges(smoothed: Smoothed) -> Array:
    """The columns of `Between` for each interval, with the time of the edge before for `since`, shape (n - 1, 16)."""
    ends, times = np.column_stack(smoothed.beliefs), smoothed.times
    turned = np.diff(smoothed.beliefs.angle)
    return np.column_stack(
        [times[:-1], np.diff(times), ends[:-1], turned, ends[1:, 1:], smoothed.lagged.reshape(-1, 4)]
    )


def _predict_either_way(states: Array, duration: Array, q: float) -> Beliefs:
    """As `predict`, but going back adds noise too: what lies before the first edge is as unknown as the future."""
    angle, speed, P11, P12, P22 = states.T
    h, away = duration, abs(duration)
    return Beliefs(
        angle + h * speed,
        speed,
        P11 + h * (2.0 * P12 + h * P22) + q * away**3 / 3.0,
        P12 + h * P22 + q * h * away / 2.0,
        P22 + q * away,
    )


def smoothing_overlap(acceleration_density: float, variance: float, interval: float, share: float) -> float:
    """Time [s] after which an edge is felt at an earlier one by less than `share`: sqrt(2) ln(1/share) / omega_n.

    omega_n = (q / (R T))^(1/4) is the bandwidth of the filter; its errors die out with omega_n / sqrt(2).

    acceleration_density  q [rad^2/s^3]
    variance              of an edge, R [rad^2]
    interval              between edges, T [s]
    share                 of the deviation, between 0 and 1 [1]

    Raises ParameterError for a share outside of 0 to 1.
    """
    if not 0.0 < share < 1.0:
        raise ParameterError(f"share: {share:g} must lie between 0 and 1")
    bandwidth = (acceleration_density / (variance * interval)) ** 0.25
    overlap: float = np.sqrt(2.0) * np.log(1.0 / share) / bandwidth
    return overlap


def smoothed_portions(
    portions: Iterable[tuple[Array, Array, Array]],
    acceleration_density: float,
    prior: AngleSpeed,
    overlap: float,
    run: Run = run_plainly,
) -> Iterator[Smoothed]:
    """A record of any length, smoothed piece by piece; memory holds a portion and an overlap.

    Each piece begins with the edge that the one before ended with, so that `smoothed_at` finds every instant in one of
    them. Edges more than `overlap` [s] after a piece (`smoothing_overlap`) do not count for it; those before all do.

    portions  times, angles and variances of consecutive edges, as for `filter_edges`

    Raises ParameterError as `filter_edges` does, also between portions.
    """
    waiting, start = np.empty((0, 3)), prior
    for portion in portions:
        times, angles, variances = portion
        waiting = np.vstack([waiting, _rows(times, angles, variances)])
        ready = int(np.searchsorted(waiting[:, 0], waiting[-1, 0] - overlap, side="right"))
        if ready < 2:
            continue
        times, angles, variances = waiting.T
        forward = filter_edges(times, angles, variances, acceleration_density, start, run)
        yield _cut(_drawn_back(times, forward, acceleration_density, run), ready)
        # The last edge of this piece is the first of the next, whose prior is the belief just before it.
        kept = ready - 1
        belief = AngleSpeed(*(float(column[kept - 1]) for column in forward))
        start = predict(belief, float(times[kept] - times[kept - 1]), acceleration_density)
        waiting = waiting[kept:]
    if waiting.size:
        times, angles, variances = waiting.T
        yield smooth_edges(times, angles, variances, acceleration_density, start, run)


def _cut(whole: Smoothed, size: int) -> Smoothed:
    motion = Beliefs(*(column[:size] for column in whole.beliefs))
    return Smoothed(whole.times[:size], motion, whole.lagged[: size - 1], whole.acceleration_density)
