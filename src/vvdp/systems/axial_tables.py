"""The tables of the axial drives that are not a component's."""

from vvdp.base.kinds import (
    DutySignal,
    Length,
    Position,
    Pressure,
    PressureSignal,
    SignedFractionSignal,
    SpeedSignal,
)
from vvdp.base.params import Params


class AxialStroke(Params):
    """Length of the helix, duty ratio 0 to 1, and between which positions the spool is to move."""

    helix_length: Length
    lowest_position: Position
    highest_position: Position


class PilotSupply(Params):
    """What feeds the chamber of an axial drive."""

    supply_pressure: PressureSignal
    tank_pressure: PressureSignal


class GerotorOperation(Params):
    """What is prescribed from outside: the pump's command, and how fast the spool is turned."""

    command: SignedFractionSignal
    spool_speed: SpeedSignal


class ControlledGerotor(Params):
    """What is prescribed from outside: the duty ratio that is wanted, and how fast the spool is turned."""

    duty_ratio: DutySignal
    spool_speed: SpeedSignal


class InitialPosition(Params):
    """Where a run starts."""

    axial_position: Position


class InitialChamber(InitialPosition):
    """Where a run with a pressure chamber starts."""

    chamber_pressure: Pressure
