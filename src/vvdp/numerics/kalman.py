"""Gaussian beliefs and the two things that happen to them: time passes, and something is measured.

`AngleSpeed` is the belief about an angle and its rate, in scalars, because a filter meets it at every sample. For more
states the covariance is kept as factors that cannot lose their positivity, and every function costs the square of the
number of states at most. These functions bear no number of their own, so that they also run in single precision.

Source  ours, docs/models/event-filter.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import Angle, AngleSpeedCovariance, AngularVariance, Speed, SpeedVariance


class AngleSpeed(NamedTuple):
    """Mean and covariance of an angle [rad] and its rate [rad/s]."""

    angle: Angle
    speed: Speed
    angle_variance: AngularVariance
    covariance: AngleSpeedCovariance
    speed_variance: SpeedVariance


def predict(belief: AngleSpeed, duration: float, acceleration_density: float) -> AngleSpeed:
    """The belief after `duration` [s] without a measurement; the acceleration is white noise.

    Exact: F = [[1, h], [0, 1]], Q = q [[h^3/3, h^2/2], [h^2/2, h]]. A negative duration goes back in time along the
    mean and takes process noise out again, so that there and back is the identity.

    acceleration_density  two-sided spectral density q [rad^2/s^3]

    Source  wang2017, eqs. 3.5 to 3.7, from the covariance at the last event instead of p
    """
    h, q = duration, acceleration_density
    return AngleSpeed(
        belief.angle + h * belief.speed,
        belief.speed,
        belief.angle_variance + h * (2.0 * belief.covariance + h * (belief.speed_variance + h * q / 3.0)),
        belief.covariance + h * (belief.speed_variance + 0.5 * h * q),
        belief.speed_variance + h * q,
    )


def update(belief: AngleSpeed, innovation: float, measurement_variance: float) -> AngleSpeed:
    """The belief after an angle was measured that differs from the expected one by `innovation` [rad].

    K = P H / (H' P H + R), P+ = (I - K H') P (I - K H')' + K R K' (Joseph), positive whatever the rounding.

    measurement_variance  R [rad^2]

    Source  wang2017, eqs. 3.8 and 3.9, both corrected: docs/errata.md
    """
    P11, P12, P22, R = belief.angle_variance, belief.covariance, belief.speed_variance, measurement_variance
    S = P11 + R
    k1, k2 = P11 / S, P12 / S
    left = R / S  # 1 - k1 without cancellation
    return AngleSpeed(
        belief.angle + k1 * innovation,
        belief.speed + k2 * innovation,
        left * left * P11 + k1 * k1 * R,
        left * (P12 - k2 * P11) + k1 * k2 * R,
        P22 + k2 * (k2 * P11 - 2.0 * P12) + k2 * k2 * R,
    )


def factors_of(covariance: Array) -> Array:
    """The factors F (n, n) of a covariance: P = L' D L with L unit lower triangular, D on the diagonal of F.

    Row j of L is column j of the U in P = U D U', so that what belongs together lies together. Entries above the
    diagonal are 0. D of a direction that is known exactly is 0.
    """
    n = covariance.shape[0]
    F = np.zeros_like(covariance)
    for j in range(n - 1, -1, -1):
        for i in range(j, -1, -1):
            rest = covariance[i, j]
            for k in range(j + 1, n):
                rest -= F[k, k] * F[k, i] * F[k, j]
            if i == j:
                F[j, j] = rest
            elif F[j, j] > 0.0:
                F[j, i] = rest / F[j, j]
    return F


def covariance_of(factors: Array) -> Array:
    """The covariance (n, n) that factors stand for."""
    L = np.tril(factors, -1) + np.eye(factors.shape[0])
    P: Array = L.T @ (np.diag(factors)[:, None] * L)
    return 0.5 * (P + P.T)


def variance_of(factors: Array, state: int) -> float:
    """The variance of one state, the entry (state, state) of the covariance."""
    F = factors
    P: float = F[state, state]
    for k in range(state + 1, F.shape[0]):
        P += F[k, k] * F[k, state] * F[k, state]
    return P


def move_leading(mean: Array, factors: Array, transition: Array, noise: Array) -> None:
    """Step the first m states on, in place: x -> F x, the rest stays; `noise` (m,) is what each variance gains.

    transition  F (m, m); m is small, the cost goes with m n

    Source  ours, docs/models/axial-observer.md, from Agee and Turner's update
    """
    m = transition.shape[0]
    spare = np.empty_like(noise)
    for j in range(m, mean.size):
        _transform(factors[j], transition, spare)
    _transform(mean, transition, spare)
    # The block is built again: the noise, then each old direction where it has moved to.
    old = np.empty_like(transition)
    for j in range(m):
        for i in range(j):
            old[j, i] = factors[j, i]
            factors[j, i] = 0
        old[j, j] = factors[j, j]
        factors[j, j] = noise[j]
    for j in range(m):
        for i in range(m):
            spare[i] = transition[i, j]
            for k in range(j):
                spare[i] += transition[i, k] * old[j, k]
        add_variance(factors, spare, old[j, j], m - 1)


def _transform(row: Array, transition: Array, spare: Array) -> None:
    m = spare.size
    for i in range(m):
        spare[i] = transition[i, 0] * row[0]
        for k in range(1, m):
            spare[i] += transition[i, k] * row[k]
    for i in range(m):
        row[i] = spare[i]


def add_variance(factors: Array, direction: Array, variance: float, last: int) -> None:
    """Let in noise of `variance` along `direction`, in place: P + c a a'. `direction` is used up.

    last  the last entry of the direction that is not 0; the cost goes with its square

    Source  Agee and Turner's update, bierman1977, section III.4
    """
    F, a, c = factors, direction, variance
    for k in range(last, -1, -1):
        s, d = a[k], F[k, k]
        more = d + c * s * s
        if more > d:
            b = c * s / more
            c *= d / more
            F[k, k] = more
            for i in range(k):
                a[i] -= s * F[k, i]
                F[k, i] += b * a[i]


def observe(factors: Array, observation: Array, measurement_variance: float, gain: Array) -> float:
    """Take in one scalar measurement, in place, and return the variance of its innovation.

    The mean moves by `gain` (n,), which is written, times the innovation. Positive whatever the rounding: each D is
    multiplied by a number between 0 and 1.

    observation           row H (n,)
    measurement_variance  R, above 0

    Source  Bierman's update, bierman1977, section V.3
    """
    F, h, g, S = factors, observation, gain, measurement_variance
    n = h.size
    for j in range(n):
        f = h[j]
        for i in range(j):
            f += F[j, i] * h[i]
        v = F[j, j] * f
        before = S
        S = before + f * v
        F[j, j] *= before / S
        down = -f / before
        for i in range(j):
            u = F[j, i]
            F[j, i] = u + g[i] * down
            g[i] += u * v
        g[j] = v
    for i in range(n):
        g[i] /= S
    return S


def consider(factors: Array, gain: Array, innovation_variance: float, first: int) -> None:
    """Make good for a measurement that the states from `first` on were not allowed to follow, in place.

    Their part of `gain` is used up: P + S (K - K_used) (K - K_used)', the covariance that any other gain leaves.
    """
    for i in range(first):
        gain[i] = 0
    add_variance(factors, gain, innovation_variance, gain.size - 1)


def know_leading(factors: Array, count: int) -> None:
    """Let the first `count` states be known exactly, in place; what is believed of the others stays."""
    for j in range(factors.shape[0]):
        for i in range(min(j + 1, count)):
            factors[j, i] = 0


def chance_band(count: int) -> tuple[float, float]:
    """Where the mean of `count` squared normalised errors lies with a chance of 95 % if their deviations are true [1].

    NaN of none.
    """
    if not count:
        return np.nan, np.nan
    from scipy.special import chdtri

    return float(chdtri(count, 0.975)) / count, float(chdtri(count, 0.025)) / count
