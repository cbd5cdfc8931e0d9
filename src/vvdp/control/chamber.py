"""Controller model of the spring-return chamber, and the pressure that would give the desired motion.

Source  ours, docs/models/passivity-control.md, where a function names no other.
"""

from typing import NamedTuple

from vvdp.base.kinds import Area, Flow, Force, Mass, Position, Pressure, Stiffness, Velocity, ViscousFriction, Volume
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.base.select import clip, select
from vvdp.control.orifice import ChamberValve
from vvdp.control.reference import Rate, Reference
from vvdp.fluid.mixture import bulk_modulus
from vvdp.fluid.oil import Oil


class ChamberDrive(Params):
    """A plunger of `area` against a spring: M x'' = A (P - P_0) - K x - F_0, P' = beta/V (Q - A x'), V = V_0 + A x.

    `preload` F_0 is the force of the spring and `oil_volume` V_0 the volume of the chamber at position 0. The other
    side of the plunger is at the oil's reference pressure P_0.
    """

    area: Area
    moving_mass: Mass
    stiffness: Stiffness
    preload: Force
    oil_volume: Volume
    oil: Oil
    valve: ChamberValve

    def check(self) -> None:
        require_positive(self, "area", "moving_mass", "oil_volume")


class PositionGains(Params):
    """lambda_p, K_p and K_v: the errors of position and velocity then fade as M s^2 + (M lambda_p + K_v) s + ... does.

    `friction` b is the viscous friction that the law compensates; 0: none is known. Raises `ParameterError` for an
    `error_rate` or a `velocity_gain` of zero: nothing would be damped.
    """

    error_rate: Rate
    position_gain: Stiffness
    velocity_gain: ViscousFriction
    friction: ViscousFriction = 0.0

    def check(self) -> None:
        require_positive(self, "error_rate", "velocity_gain")


class ChamberReading(NamedTuple):
    """Inputs of a law of the chamber: position and velocity as estimated, the pressure as measured, absolute."""

    position: Position
    velocity: Velocity
    pressure: Pressure


class DesiredPressure(NamedTuple):
    """The `pressure` [Pa, absolute] that makes the errors fade, its `rate` [Pa/s], and the errors.

    `known_rate` is the part of the rate that follows from the reference alone. `velocity_error` is that against
    `reference_velocity`, the reference's velocity less lambda_p times the position error.
    """

    position_error: Position
    velocity_error: Velocity
    reference_velocity: Velocity
    pressure: Pressure
    rate: float
    known_rate: float


class ChamberFlow(NamedTuple):
    """The flow that a law commands, the part of it that is feedforward, and the desired pressure."""

    flow: Flow
    feedforward: Flow
    desired: DesiredPressure


def chamber_volume(position: float, drive: ChamberDrive) -> float:
    """Volume of the chamber [m^3].  position: [m]."""
    return drive.oil_volume + drive.area * position


def volume_compliance(position: float, pressure: float, drive: ChamberDrive) -> float:
    """Volume of oil that raises the pressure of the chamber by one pascal, V/beta [m^3/Pa].

    position  [m]
    pressure  absolute [Pa]
    """
    return chamber_volume(position, drive) / bulk_modulus(pressure, drive.oil)


def desired_pressure(
    reference: Reference, reading: ChamberReading, gains: PositionGains, drive: ChamberDrive
) -> DesiredPressure:
    """The pressure that the drive should have, held between those of tank and supply, and its rate.

    P_d - P_0 = (M (x_d'' - l e') + b x_d' + K x_d + F_0 - K_p e - K_v e_v)/A, l = lambda_p. The rate is its exact
    derivative, with the acceleration that the measured pressure gives; an unknown load, and its rate, are left out.
    Where P_d is held, it stands still.

    Source  wang2017, eqs. 5.28, 5.29, 5.31; friction b ours, docs/models/passivity-control.md
    """
    M, A, K, P0 = drive.moving_mass, drive.area, drive.stiffness, drive.oil.reference_pressure
    l, Kp, Kv, b = gains.error_rate, gains.position_gain, gains.velocity_gain, gains.friction
    acceleration = (A * (reading.pressure - P0) - K * reading.position - drive.preload - b * reading.velocity) / M
    e, de = reading.position - reference.position, reading.velocity - reference.velocity
    dde = acceleration - reference.acceleration
    ev, dev = de + l * e, dde + l * de
    forces = M * (reference.acceleration - l * de) + K * reference.position + drive.preload + b * reference.velocity
    wanted = P0 + (forces - Kp * e - Kv * ev) / A
    known = (M * reference.jerk + K * reference.velocity + b * reference.acceleration) / A
    low, high = drive.valve.tank_pressure, drive.valve.supply_pressure
    is_free = (wanted > low) & (wanted < high)
    return DesiredPressure(
        position_error=e,
        velocity_error=ev,
        reference_velocity=reference.velocity - l * e,
        pressure=clip(wanted, low, high),
        rate=select(is_free, known - (M * l * dde + Kp * de + Kv * dev) / A, 0.0),
        known_rate=select(is_free, known, 0.0),
    )


class Sensitivities(NamedTuple):
    """Sensitivities of the rate of the desired pressure to the errors: f = alpha_e e + alpha_ev e_v + alpha_P (P -
    P_d)."""

    position: float
    velocity: float
    pressure: float


def desired_rate_sensitivities(gains: PositionGains, drive: ChamberDrive) -> Sensitivities:
    """alpha_e [Pa/(m s)], alpha_ev [Pa/m], alpha_P [1/s], the last one below zero.

    Source  wang2017, eq. 5.31, of which the factors are ours, docs/models/passivity-control.md
    """
    M, A, K = drive.moving_mass, drive.area, drive.stiffness
    l, Kp, Kv, b = gains.error_rate, gains.position_gain, gains.velocity_gain, gains.friction
    damping, rest = M * l + Kv, M * l * l - Kp
    return Sensitivities(
        position=(damping * (K + Kp - b * l) / M - l * rest) / A,
        velocity=(damping * (Kv + b) / M + rest) / A,
        pressure=-(l + Kv / M),
    )
