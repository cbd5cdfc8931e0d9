"""The force of the oil that makes a cylinder follow its reference, and the effort that makes the oil give it.

Source  ours, docs/models/displacement-control.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

from vvdp.base.kinds import Force, Kind, Mass, Position, Stiffness, Velocity, ViscousFriction
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.control.capacities import CylinderModel
from vvdp.control.reference import Rate, Reference, SignedAcceleration

FORCE_RATE = Kind("rate of a force", "N/s", -1e12, 1e12, "1e4 N/s")

ForceRate = Annotated[float, FORCE_RATE]


class ForceGains(Params):
    """lambda, K_p, K_v, the rate lambda_3 beta at which the force error fades, and K_rob beta beside it.

    Raises `ParameterError` for an `error_rate`, a `velocity_gain` or a `pressure_rate` of zero.
    """

    error_rate: Rate
    position_gain: Stiffness
    velocity_gain: ViscousFriction
    pressure_rate: Rate
    robust_rate: Rate = 0.0

    def check(self) -> None:
        require_positive(self, "error_rate", "velocity_gain", "pressure_rate")


class Motion(NamedTuple):
    """Position and velocity as estimated, the load as estimated, and the moving mass."""

    position: Position
    velocity: Velocity
    load_force: Force
    moving_mass: Mass


class DesiredForce(NamedTuple):
    """The force F_v that makes the errors fade, its rate, and the errors.

    `reference_velocity` is r = x_d' - lambda e, `reference_acceleration` its rate, `velocity_error` e_v = x' - r.
    """

    force: Force
    rate: ForceRate
    position_error: Position
    velocity_error: Velocity
    reference_velocity: Velocity
    reference_acceleration: SignedAcceleration


def desired_force(
    reference: Reference, motion: Motion, force: float, gains: ForceGains, cylinder: CylinderModel
) -> DesiredForce:
    """F_v = m (x_d'' - lambda e') + b x' - F_L - K_v e_v - K_p e, and its exact rate with the load held.

    The acceleration in the rate is that which the measured force gives, (F_H - b x' + F_L)/m.

    force  of the oil now, F_H [N]

    Source  wang2017, eqs. 6.6 and 6.9
    """
    m, b = motion.moving_mass, cylinder.viscous_friction
    l, Kp, Kv = gains.error_rate, gains.position_gain, gains.velocity_gain
    acceleration = (force - b * motion.velocity + motion.load_force) / m
    e, de = motion.position - reference.position, motion.velocity - reference.velocity
    dde = acceleration - reference.acceleration
    ev, dev, dr = de + l * e, dde + l * de, reference.acceleration - l * de
    return DesiredForce(
        force=m * dr + b * motion.velocity - motion.load_force - Kv * ev - Kp * e,
        rate=m * (reference.jerk - l * dde) + b * acceleration - Kv * dev - Kp * de,
        position_error=e,
        velocity_error=ev,
        reference_velocity=reference.velocity - l * e,
        reference_acceleration=dr,
    )


def total_effort(stiffness: float, desired: DesiredForce, force: float, rate_share: float, gains: ForceGains) -> float:
    """U* = S r + F_v' - (lambda_3 + K_rob) beta (F_H - F_v) [N/s].

    stiffness   S, beta L of a bare cylinder [N/m]
    force       of the oil now, F_H [N]
    rate_share  by which the rate counts: nominal over adapted bulk modulus, 1 without adaptation [1]

    Source  wang2017, eq. 6.19, with u_rob = -K_rob (F_H - F_v): docs/errata.md
    """
    fading = (gains.pressure_rate + gains.robust_rate) * (force - desired.force)
    return stiffness * desired.reference_velocity + rate_share * desired.rate - fading
