"""Certificates of gains: of both pressure laws, and limits of the sample period.

Source  ours, docs/models/passivity-control.md, where a function names no other.
"""

import math
from typing import NamedTuple

import numpy as np

from vvdp.control.backstepping import BacksteppingGains
from vvdp.control.chamber import ChamberDrive, PositionGains, desired_rate_sensitivities
from vvdp.control.passivity import PassivityGains, held_gain


class Certificate(NamedTuple):
    """A sufficient condition for exponential stability: `margin` = `offered` - `needed` has to be above 0."""

    offered: float
    needed: float

    @property
    def margin(self) -> float:
        """Margin of the condition."""
        return self.offered - self.needed

    @property
    def holds(self) -> bool:
        """Whether the gains are certified. Gains that are not may be stable all the same."""
        return self.margin > 0.0


def passivity_certificate(
    compliance: float, flow_gain: float, gains: PositionGains, drive: ChamberDrive, disturbance: float = 0.0
) -> Certificate:
    """Whether the matrix of the published passivity law is positive definite: both sides in m^3/(s Pa).

    lambda_3 + alpha_P V/beta - kappa > (V/2 beta)^2 (alpha_e^2/(l (K + K_p)) + alpha_ev^2/K_v), without friction;
    `_coupling` has it with. With the exact feedforward any lambda_3 above 0 will do.

    compliance   V/beta [m^3/Pa]
    flow_gain    lambda_3, times the least 1 + W_V/(P - P_d) that occurs [m^3/(s Pa)]
    disturbance  kappa, from the approximations of the feedforward [m^3/(s Pa)]

    Source  wang2017, eq. 5.38
    """
    pressure = desired_rate_sensitivities(gains, drive).pressure
    return Certificate(flow_gain + pressure * compliance - disturbance, _coupling(compliance, gains, drive))


def backstepping_certificate(compliance: float, gains: BacksteppingGains, drive: ChamberDrive) -> Certificate:
    """Whether the matrix of the backstepping law is positive definite: both sides in m^3/(s Pa).

    lambda_3 lambda_2/(V/beta) + alpha_P lambda_2 > (lambda_2/2)^2 (alpha_e^2/(l (K + K_p)) + alpha_ev^2/K_v).

    compliance  V/beta [m^3/Pa]

    Source  wang2017, eq. 5.41
    """
    weight, pressure = gains.pressure_weight, desired_rate_sensitivities(gains, drive).pressure
    offered = gains.flow_gain * weight / compliance + pressure * weight
    return Certificate(offered, _coupling(weight, gains, drive))


def _coupling(weight: float, gains: PositionGains, drive: ChamberDrive) -> float:
    """Damping of the pressure that its coupling to the errors of position and velocity takes up [m^3/(s Pa)].

    a' N^-1 a (weight/2)^2, a = (alpha_e, alpha_ev), N = [[l (K + K_p), -b l/2], [-b l/2, K_v + b]] the damping of the
    errors; infinite where N is not positive definite.
    """
    alpha = desired_rate_sensitivities(gains, drive)
    of_position = gains.error_rate * (drive.stiffness + gains.position_gain)
    of_velocity, mixed = gains.velocity_gain + gains.friction, 0.5 * gains.friction * gains.error_rate
    area = of_position * of_velocity - mixed**2
    if not area > 0.0:
        return math.inf
    taken = of_velocity * alpha.position**2 + of_position * alpha.velocity**2
    return (0.5 * weight) ** 2 * (taken + 2.0 * mixed * alpha.position * alpha.velocity) / area


class SamplingLimits(NamedTuple):
    """The pole of the pressure loop [1/s], the sample period [s] at which it limit-cycles, and half of that."""

    pole: float
    limit: float
    recommended: float


def sampling_limits(flow_gain: float, compliance: float) -> SamplingLimits:
    """Limits of the sample period, over which the flow is held, for lambda_3: the pressure's pole is lambda_3 beta/V.

    flow_gain   lambda_3, with the exact feedforward lambda_3 - alpha_P V/beta [m^3/(s Pa)]
    compliance  V/beta, the least that occurs [m^3/Pa]
    """
    pole = flow_gain / compliance
    return SamplingLimits(pole, 2.0 / pole, 1.0 / pole)


def held_sampling_limits(compliance: float, gains: PassivityGains, drive: ChamberDrive) -> SamplingLimits:
    """The same for a law with a hold time, always that of the samples: the limit is where `sampled_radius` passes 1.

    compliance  V/beta, the least that occurs [m^3/Pa]
    """
    from scipy.optimize import brentq

    gain = gains.flow_gain + gains.pressure_rate * compliance

    def growth(period: float) -> float:
        return sampled_radius(period, held_gain(gain, compliance, period), compliance, gains, drive) - 1.0

    longest = 0.1 * compliance / gain
    while growth(longest) < 0.0:
        longest *= 1.1
    limit = float(brentq(growth, longest / 1.1, longest))
    return SamplingLimits(gain / compliance, limit, 0.5 * limit)


def sampled_radius(
    period: float, flow_gain: float, compliance: float, gains: PositionGains, drive: ChamberDrive
) -> float:
    """Spectral radius of the loop with the exact feedforward and a flow that is held [1]; below 1 errors fade.

    M x'' = A P - K x - b x', (V/beta) P' = Q - A x' about a reference at rest, exact over a `period` [s], with
    Q = (V/beta) P_d' - A l x - lambda_3 (P - P_d), P_d as `chamber.desired_pressure` has it.

    flow_gain   lambda_3 as it acts on the held flow [m^3/(s Pa)]
    compliance  V/beta [m^3/Pa]
    """
    from scipy.linalg import expm

    M, A, K, C = drive.moving_mass, drive.area, drive.stiffness, compliance
    l, Kp, Kv, b = gains.error_rate, gains.position_gain, gains.velocity_gain, gains.friction
    motion = np.array([[0.0, 1.0, 0.0], [-K / M, -b / M, A / M], [0.0, -A / C, 0.0]])
    wanted = -np.array([Kp + Kv * l, M * l + Kv, 0.0]) / A
    wanted_rate = wanted[:2] @ motion[:2]
    flow = np.array([-A * l, 0.0, -flow_gain]) + C * wanted_rate + flow_gain * wanted
    held = np.zeros((4, 4))
    held[:3, :3], held[2, 3] = motion, 1.0 / C
    over = expm(held * period)
    return float(np.max(np.abs(np.linalg.eigvals(over[:3, :3] + np.outer(over[:3, 3], flow)))))


def sampling_warning(limits: SamplingLimits, period: float) -> str:
    """The warning about a sample period [s]; empty where it is short enough."""
    if period <= limits.recommended:
        return ""
    loop = f"the pressure loop has a pole of {limits.pole:.0f} 1/s"
    if period <= limits.limit:
        return (
            f"{loop}; a sample period of {1e3 * period:.3g} ms is above the {1e3 * limits.recommended:.3g} ms advised"
        )
    return (
        f"{loop}; sampled every {1e3 * period:.3g} ms it will limit-cycle: "
        f"its limit is {1e3 * limits.limit:.3g} ms, {1e3 * limits.recommended:.3g} ms is advised"
    )
