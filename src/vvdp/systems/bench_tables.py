"""The tables of the test rigs of the rotary valve that are not a component's."""

from typing import Annotated, TypeAlias

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
    Velocity,
)
from vvdp.base.params import Params, without_effect
from vvdp.hydraulics.orifice import Orifice
from vvdp.valve.validity import CAVITATION_PRESSURE

LARGEST_PRESSURE = 701.01325e5
"""Absolute pressure [Pa] beyond which no result is to be trusted where a system says nothing else: 700 bar, twice what
pumps and hoses of industry are rated for; assumed."""
LARGEST_SPEED = 2000.0
"""Speed of a shaft [rad/s] beyond which none is to be trusted where a system says nothing else: 19 000 rpm, twice what
small axial piston machines are rated for; assumed."""
LARGEST_VELOCITY = 30.0
"""Mean velocity of the oil in a line above which no result is to be trusted [m/s]: three times that of short ones."""


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
    """Bounds that are watched and reported; beyond one of them no result is to be trusted."""

    cavitation_pressure: Pressure = CAVITATION_PRESSURE
    largest_pressure: Pressure = LARGEST_PRESSURE
    largest_speed: Speed = LARGEST_SPEED
    largest_velocity: Velocity = LARGEST_VELOCITY


MotorSpeed: TypeAlias = Annotated[SpeedSignal, without_effect("spool_drive.coupling")]


class DutyOperation(Params):
    """What is prescribed from outside, with the spool's axial position given as a duty ratio."""

    pump_speed: SpeedSignal
    oil_temperature: TemperatureSignal
    duty_ratio: DutySignal
    spool_motor_speed: MotorSpeed
    tank_pressure: PressureSignal


class AxialOperation(Params):
    """What is prescribed from outside, with the spool's axial position."""

    pump_speed: SpeedSignal
    oil_temperature: TemperatureSignal
    axial_position: PositionSignal
    spool_motor_speed: MotorSpeed
    tank_pressure: PressureSignal


class InitialSupply(Params):
    """Where a run starts."""

    inlet_pressure: Pressure
    spool_speed: Speed
    spool_angle: Angle


class InitialBench(InitialSupply):
    """Where a run with a load line starts."""

    load_pressure: Pressure
