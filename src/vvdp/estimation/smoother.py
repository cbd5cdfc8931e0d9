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
from vvdp.base.errors import ParameterError
from vvdp.base.kinds import AccelerationDensity
from vvdp.base.params import Params
from vvdp.numerics.kalman import AngleSpeed, predict, update

Step = Callable[[Any, Any, Any], tuple[Any, Any]]
Run = Callable[[Step, Any, Any, Params, Array], tuple[Any, Array]]
"""Takes a step, its memory, a row as an example, settings and rows (n, m); returns the memory and what was shown."""


class SpeedWalk(Params):
    """The model: an acceleration that is white noise."""

    acceleration_density: AccelerationDensity

    def check(self) -> None:
        """Refuse a speed that cannot change: the portions could not be smoothed independently."""
        if not self.acceleration_density > 0.0:
            raise ParameterError("SpeedWalk.acceleration_density is 0 rad^2/s^3; expected above 0")


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
    """What the forward pass believed right after the edge at `time`."""

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


def run_plainly(step: Step, memory: Any, row: Any, settings: Params, rows: Array) -> tuple[Any, Array]:
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
    if not (rows[:, 2] > 0.0).all():
        raise ParameterError(f"an edge with a variance of {rows[:, 2].min():g} rad^2; expected above 0")
    return rows


def smoothed_at(times: Array, smoothed: Smoothed) -> Beliefs:
    """The motion at any `times` [s], shape (m,), given all edges.

    Between two edges, h apart, with s = (t - t_k)/h and r = 1 - s, the mean is the cubic through both angles with both
    speeds as slopes, A x_k + B x_k+1, and what neither edge tells has the covariance
    q [[h^3 s^3 r^3/3, h^2 s^2 r^2 (r - s)/2], [., h s r (1 - 3 s r)]]. Outside of the edges the nearest state is
    carried on, with noise that grows both ways.
    """
    t, n = np.asarray(times, float), smoothed.times.size
    left = np.clip(np.searchsorted(smoothed.times, t, side="right") - 1, 0, n - 1)
    states = np.column_stack(smoothed.beliefs)[left]
    outside = _predict_either_way(states, t - smoothed.times[left], smoothed.acceleration_density)
    inside = (t >= smoothed.times[0]) & (t < smoothed.times[-1])
    motion = np.array(outside)
    if inside.any():
        motion[:, inside] = _bridge(t[inside], left[inside], smoothed)
    return Beliefs(*motion)


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


def _bridge(t: Array, left: Array, smoothed: Smoothed) -> Beliefs:
    q, right = smoothed.acceleration_density, left + 1
    h = smoothed.times[right] - smoothed.times[left]
    s = (t - smoothed.times[left]) / h
    r = 1.0 - s
    # Rows: what angle and speed at t take of (angle, speed) at the edge before and of (angle, speed) at the one after.
    weights = np.array(
        [
            [r * r * (1.0 + 2.0 * s), h * s * r * r, s * s * (1.0 + 2.0 * r), -h * s * s * r],
            [-6.0 * s * r / h, r * (r - 2.0 * s), 6.0 * s * r / h, s * (s - 2.0 * r)],
        ]
    )
    ends = np.column_stack(smoothed.beliefs)
    before, after = ends[left], ends[right]
    joint = np.empty((left.size, 4, 4))
    for block, covariances in (((0, 1), before), ((2, 3), after)):
        i, j = block
        joint[:, i, i], joint[:, i, j], joint[:, j, i], joint[:, j, j] = covariances[:, [2, 3, 3, 4]].T
    joint[:, :2, 2:] = smoothed.lagged[left]
    joint[:, 2:, :2] = smoothed.lagged[left].transpose(0, 2, 1)
    # The angle is counted from that of the edge before: it may be large, and the weights of both angles sum to 1.
    turned = after[:, 0] - before[:, 0]
    states = np.stack([np.zeros_like(turned), before[:, 1], turned, after[:, 1]])
    angle, speed = np.einsum("ikn,kn->in", weights, states)
    P = np.einsum("ikn,nkl,jln->ijn", weights, joint, weights)
    return Beliefs(
        before[:, 0] + angle,
        speed,
        P[0, 0] + q * (h * s * r) ** 3 / 3.0,
        P[0, 1] + q * (h * s * r) ** 2 * (r - s) / 2.0,
        P[1, 1] + q * h * s * r * (1.0 - 3.0 * s * r),
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
        raise ParameterError(f"a share of {share:g}; expected above 0 and below 1")
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
