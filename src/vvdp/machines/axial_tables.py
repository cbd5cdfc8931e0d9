"""The tables of the axial drives that are not a component's."""

from vvdp.base.kinds import (
    Position,
    Pressure,
    PressureSignal,
)
from vvdp.base.params import Params


class PilotSupply(Params):
    """What feeds the chamber of an axial drive."""

    supply_pressure: PressureSignal
    tank_pressure: PressureSignal


class InitialChamber(Params):
    """Where a run with a pressure chamber starts."""

    axial_position: Position
    chamber_pressure: Pressure
