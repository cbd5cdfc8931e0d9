"""The tables of the test benches of the rotary valve that are not a component's."""

from vvdp.base.kinds import (
    Angle,
    AreaSignal,
    DutySignal,
    PositionSignal,
    Power,
    Pressure,
    PressureSignal,
    Speed,
    SpeedSignal,
    TemperatureSignal,
)
from vvdp.base.params import Params
from vvdp.hydraulics.orifice import Orifice


class OrificeLoad(Orifice):
    """The load: an orifice to the tank whose area may be prescribed over time."""

    area: AreaSignal


class PressureLoad(Params):
    """The load: a source that holds its pressure whatever flows."""

    pressure: PressureSignal


class DriveMotor(Params):
    """The motor that turns the pump."""

    rated_power: Power


class Limits(Params):
    """Bounds that are watched and reported."""

    cavitation_pressure: Pressure


class DutyOperation(Params):
    """What is prescribed from outside, with the spool's axial position given as a duty ratio."""

    pump_speed: SpeedSignal
    oil_temperature: TemperatureSignal
    duty_ratio: DutySignal
    spool_motor_speed: SpeedSignal
    tank_pressure: PressureSignal


class AxialOperation(Params):
    """What is prescribed from outside, with the spool's axial position."""

    pump_speed: SpeedSignal
    oil_temperature: TemperatureSignal
    axial_position: PositionSignal
    spool_motor_speed: SpeedSignal
    tank_pressure: PressureSignal


class InitialSupply(Params):
    """Where a run starts."""

    inlet_pressure: Pressure
    spool_speed: Speed
    spool_angle: Angle


class InitialBench(InitialSupply):
    """Where a run with a load line starts."""

    load_pressure: Pressure
