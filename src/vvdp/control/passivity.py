"""Passivity-based control of the chamber: the energy of the oil against its desired pressure is used, not cancelled.

With W = W_V(P, P_d) the energy per volume and p = P - P_d, the flow Q_d + q makes the storage V W obey
d(V W)/dt = (p + W) q - p A e_v exactly, whatever the bulk modulus; q = -lambda_3 p takes energy out.

Source  ours, docs/models/passivity-control.md, where a function names no other.
"""

import numpy as np

from vvdp.base.kinds import Conductance, Time
from vvdp.base.rules import refuse_together
from vvdp.base.select import select
from vvdp.control.chamber import (
    ChamberDrive,
    ChamberFlow,
    ChamberReading,
    DesiredPressure,
    PositionGains,
    chamber_volume,
    desired_pressure,
    volume_compliance,
)
from vvdp.control.reference import Rate, Reference, reference_ahead
from vvdp.fluid.mixture import bulk_modulus, compression_energy_per_volume, density_rise


class PassivityGains(PositionGains):
    """Gains of the passivity law; lambda_3 = `flow_gain` + `pressure_rate` V/beta(P_d), of which one is usually zero.

    With a `pressure_rate` alone, the pressure error fades at that rate whatever the air in the oil. A flow is held for
    `flow_hold`, over which the law takes its mean; 0: the law in continuous time.
    Raises `ParameterError` where both are zero.
    """

    flow_gain: Conductance = 0.0
    pressure_rate: Rate = 0.0
    flow_hold: Time = 0.0

    def check(self) -> None:
        if not self.flow_gain + self.pressure_rate > 0.0:
            refuse_together(self, "flow_gain or pressure_rate must be greater than 0, or the pressure would drift")


def pressure_error_gain(position: float, pressure: float, gains: PassivityGains, drive: ChamberDrive) -> float:
    """lambda_3 [m^3/(s Pa)].  position: [m]; pressure: the desired one, absolute [Pa]."""
    return gains.flow_gain + gains.pressure_rate * volume_compliance(position, pressure, drive)


def exact_feedforward(desired: DesiredPressure, reading: ChamberReading, drive: ChamberDrive) -> float:
    """Q_d = (A r + V/B P_d')/(1 + W/p) [m^3/s], p = P - P_d, 1/B = (e^g(P, P_d) - 1)/p, at p = 0 1/beta.

    Both W and e^g - 1 are closed forms without differences that cancel, so that p may be as small as it likes.

    Source  wang2017, eqs. 5.25, 5.33; the form is ours, docs/models/passivity-control.md
    """
    P, Pd = reading.pressure, desired.pressure
    p = P - Pd
    is_met = p == 0.0
    unit = select(is_met, 1.0, p)
    softness = select(is_met, 1.0 / bulk_modulus(Pd, drive.oil), density_rise(P, Pd, drive.oil) / unit)
    storage = select(is_met, 0.0, compression_energy_per_volume(P, Pd, drive.oil) / unit)
    volume = chamber_volume(reading.position, drive)
    return (drive.area * desired.reference_velocity + volume * softness * desired.rate) / (1.0 + storage)


def printed_feedforward(desired: DesiredPressure, reading: ChamberReading, drive: ChamberDrive) -> float:
    """Q_d = A r + V/beta(P_d) P_d1' [m^3/s], with the part of the rate that the reference gives; for comparison.

    Source  wang2017, eq. 5.34
    """
    compliance = volume_compliance(reading.position, desired.pressure, drive)
    return drive.area * desired.reference_velocity + compliance * desired.known_rate


def held_desired(
    desired: DesiredPressure, reference: Reference, gains: PassivityGains, drive: ChamberDrive
) -> DesiredPressure:
    """The desired pressure with the reference of a held flow, taken in the middle of the hold time.

    This is its mean over the hold time except for terms of the square of that time.
    """
    middle = reference_ahead(reference, 0.5 * gains.flow_hold)
    M, A, K, b = drive.moving_mass, drive.area, drive.stiffness, gains.friction
    known = M * (middle.jerk - reference.jerk) + K * (middle.velocity - reference.velocity)
    known = (known + b * (middle.acceleration - reference.acceleration)) / A
    is_free = (desired.pressure > drive.valve.tank_pressure) & (desired.pressure < drive.valve.supply_pressure)
    added = select(is_free, known, 0.0)
    return desired._replace(
        reference_velocity=desired.reference_velocity + (middle.velocity - reference.velocity),
        rate=desired.rate + added,
        known_rate=desired.known_rate + added,
    )


def held_gain(gain: float, compliance: float, flow_hold: float) -> float:
    """(V/beta) (1 - e^-wT)/T [m^3/(s Pa)], w = lambda_3 beta/V: mean of lambda_3 p over the hold T, p fading at w.

    gain        lambda_3 [m^3/(s Pa)]
    compliance  V/beta [m^3/Pa]
    flow_hold   T; with 0 it is lambda_3 [s]
    """
    faded = gain * flow_hold / compliance
    is_held = faded > 0.0
    return gain * select(is_held, -np.expm1(-faded) / select(is_held, faded, 1.0), 1.0)


def passivity_law(
    reference: Reference,
    reading: ChamberReading,
    gains: PassivityGains,
    drive: ChamberDrive,
    volume_beside: float = 0.0,
) -> ChamberFlow:
    """The flow Q = Q_d - lambda_3 (P - P_d) with the exact feedforward; `orifice.valve_command` makes it a command.

    volume_beside  of the chamber, beside that of the drive; either sign [m^3]

    Source  wang2017, eq. 5.37; feedforward and hold ours, docs/models/passivity-control.md
    """
    desired = desired_pressure(reference, reading, gains, drive)
    filled = reading._replace(position=reading.position + volume_beside / drive.area)
    feedforward = exact_feedforward(held_desired(desired, reference, gains, drive), filled, drive)
    return _with_gain(feedforward, desired, filled, gains, drive)


def printed_passivity_law(
    reference: Reference, reading: ChamberReading, gains: PassivityGains, drive: ChamberDrive
) -> ChamberFlow:
    """The same as `passivity_law` with the published, approximate feedforward.

    Source  wang2017, eq. 5.37
    """
    desired = desired_pressure(reference, reading, gains, drive)
    feedforward = printed_feedforward(held_desired(desired, reference, gains, drive), reading, drive)
    return _with_gain(feedforward, desired, reading, gains, drive)


def _with_gain(
    feedforward: float, desired: DesiredPressure, reading: ChamberReading, gains: PassivityGains, drive: ChamberDrive
) -> ChamberFlow:
    """The flow of a law: its feedforward minus the gain times the pressure error."""
    compliance = volume_compliance(reading.position, desired.pressure, drive)
    gain = pressure_error_gain(reading.position, desired.pressure, gains, drive)
    held = held_gain(gain, compliance, gains.flow_hold)
    return ChamberFlow(feedforward - held * (reading.pressure - desired.pressure), feedforward, desired)
