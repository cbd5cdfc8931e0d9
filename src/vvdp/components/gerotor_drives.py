"""The gerotor drive of a spool, its characteristic as a map or as measured rows."""

from typing import NamedTuple

from vvdp.base.kinds import Mode, Power, SignedFraction, Velocity
from vvdp.hydraulics.gerotor_drive import (
    GerotorCalibration,
    GerotorDrive,
    GerotorMap,
    GerotorState,
    SignedPressure,
    calibrated_flow,
    gerotor_effort,
    gerotor_ends,
    gerotor_flow,
    gerotor_rate,
    spool_velocity,
)
from vvdp.network.component import Component


class GerotorLosses(NamedTuple):
    """Losses in the pump's passages, and by friction of the spool."""

    passages: Power
    friction: Power


class GerotorMotion(NamedTuple):
    """Motion of the spool by a gerotor drive, its effort, and whether an end stop holds the spool."""

    velocity: Velocity
    pressure_difference: SignedPressure
    supplied: Power
    losses: GerotorLosses
    rates: GerotorState
    at_lower: Mode
    at_upper: Mode


def gerotor_drive(
    command: SignedFraction,
    at_lower: Mode,
    at_upper: Mode,
    state: GerotorState,
    drive: GerotorDrive,
    characteristic: GerotorMap,
) -> GerotorMotion:
    """Gerotor pump that moves a spool by a command between -1 and 1."""
    return _motion(gerotor_flow(command, characteristic), at_lower, at_upper, state, drive)


def calibrated_gerotor_drive(
    command: SignedFraction,
    at_lower: Mode,
    at_upper: Mode,
    state: GerotorState,
    drive: GerotorDrive,
    calibration: GerotorCalibration,
) -> GerotorMotion:
    """Gerotor pump whose flow over its command was measured."""
    return _motion(calibrated_flow(command, calibration), at_lower, at_upper, state, drive)


def _motion(
    settled_flow: float, at_lower: float, at_upper: float, state: GerotorState, drive: GerotorDrive
) -> GerotorMotion:
    velocity = spool_velocity(state.flow, at_lower, at_upper, drive)
    effort, ends = gerotor_effort(state.flow, velocity, drive), gerotor_ends(state, at_lower, at_upper, drive)
    return GerotorMotion(
        velocity=velocity,
        pressure_difference=effort.pressure_difference,
        supplied=effort.passages + effort.friction,
        losses=GerotorLosses(effort.passages, effort.friction),
        rates=gerotor_rate(settled_flow, state, at_lower, at_upper, drive),
        at_lower=ends.lower,
        at_upper=ends.upper,
    )


GEROTOR_DRIVE = Component(gerotor_drive, symbol="pump")
CALIBRATED_GEROTOR_DRIVE = Component(calibrated_gerotor_drive, symbol="pump")
