"""Gaussian beliefs and the two things that happen to them: time passes, and something is measured.

`AngleSpeed` is the belief about an angle and its rate, in scalars, because a filter meets it at every sample; the
functions on arrays serve filters with more states.

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


def predict_n(mean: Array, covariance: Array, transition: Array, noise: Array) -> tuple[Array, Array]:
    """Mean (n,) and covariance (n, n) after a linear step: F x, F P F' + Q."""
    return np.dot(transition, mean), np.dot(np.dot(transition, covariance), transition.T.copy()) + noise


def update_n(
    mean: Array, covariance: Array, observation: Array, innovation: float, measurement_variance: float
) -> tuple[Array, Array]:
    """Mean (n,) and covariance (n, n) after one scalar measurement with row `observation` (n,), Joseph form."""
    g = np.dot(covariance, observation)
    S = np.dot(observation, g) + measurement_variance
    k = g / S
    left = np.eye(mean.size) - np.outer(k, observation)
    P = np.dot(np.dot(left, covariance), left.T.copy()) + measurement_variance * np.outer(k, k)
    return mean + innovation * k, 0.5 * (P + P.T)


def chance_band(count: int) -> tuple[float, float]:
    """Where the mean of `count` squared normalised errors lies with a chance of 95 % if their deviations are true [1].

    NaN of none.
    """
    if not count:
        return np.nan, np.nan
    from scipy.special import chdtri

    return float(chdtri(count, 0.975)) / count, float(chdtri(count, 0.025)) / count
