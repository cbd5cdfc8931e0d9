"""The test benches of the rotary valve: a pump unit against a load line with an orifice, or against a pressure source.

The two functions that return a `Network` are what a system file names as its circuit; their arguments are its tables.
"""

from typing import TypedDict

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
from vvdp.components.pump_unit import PumpUnit, UnitJoints, add_pump_unit
from vvdp.components.resistances import ORIFICE
from vvdp.components.rotary_valve import duty_position
from vvdp.estimation.event_filter import EventFilterValues
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.check_valve import CheckPoppet
from vvdp.hydraulics.orifice import Orifice
from vvdp.hydraulics.pump import Pump
from vvdp.hydraulics.relief_valve import ReliefValve
from vvdp.hydraulics.spool_drive import SpoolDrive
from vvdp.hydraulics.volume import Vessel
from vvdp.network.network import Network
from vvdp.network.nodes import Chamber, Connection, Source
from vvdp.systems.spool_encoder import EncoderTable, add_encoder
from vvdp.valve.rotary import RotaryValve


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


def orifice_load(
    oil: Oil,
    pump: Pump,
    motor: DriveMotor,
    inlet: Chamber,
    relief_valve: ReliefValve,
    valve: RotaryValve,
    spool_drive: SpoolDrive,
    check_valve: CheckPoppet,
    load_line: Vessel,
    load: OrificeLoad,
    operation: DutyOperation | AxialOperation,
    initial: InitialBench,
    limits: Limits,
    encoder: EncoderTable | None = None,
    spool_filter: EventFilterValues | None = None,
) -> Network:
    """A pump unit that feeds a line with or without accumulator and, from it, an orifice to the tank."""
    net = Network(
        oil,
        temperature=operation.oil_temperature,
        operation=operation,
        load=load,
        initial=initial,
        spool_drive=spool_drive,
        check_valve=check_valve,
    )
    net.tank("tank", operation.tank_pressure)
    net.volume("load_line", load_line, start="initial.load_pressure")
    unit = PumpUnit(
        pump=pump,
        inlet=inlet,
        relief_valve=relief_valve,
        valve=valve,
        spool_drive=spool_drive,
        check_valve=check_valve,
        **UNIT_START,
    )
    add_pump_unit(net, unit, joints(operation, valve))
    net.add("load", ORIFICE, load, a="load_line", b="tank", area=load.area)
    _watch(net, encoder, spool_filter, initial)
    return net


def constant_load(
    oil: Oil,
    pump: Pump,
    motor: DriveMotor,
    inlet: Chamber,
    relief_valve: ReliefValve,
    valve: RotaryValve,
    spool_drive: SpoolDrive,
    check_valve: CheckPoppet,
    load: PressureLoad,
    operation: DutyOperation | AxialOperation,
    initial: InitialSupply,
    limits: Limits,
    encoder: EncoderTable | None = None,
    spool_filter: EventFilterValues | None = None,
) -> Network:
    """A pump unit that works against a pressure source, which also feeds the valve's leakage."""
    net = Network(
        oil,
        temperature=operation.oil_temperature,
        operation=operation,
        load=load,
        initial=initial,
        spool_drive=spool_drive,
        check_valve=check_valve,
    )
    net.tank("tank", operation.tank_pressure)
    net.pressure_source("load_line", load.pressure)
    unit = PumpUnit(
        pump=pump,
        inlet=inlet,
        relief_valve=relief_valve,
        valve=valve,
        spool_drive=spool_drive,
        check_valve=check_valve,
        **UNIT_START,
    )
    add_pump_unit(net, unit, joints(operation, valve))
    _watch(net, encoder, spool_filter, initial)
    return net


def joints(operation: DutyOperation | AxialOperation, valve: RotaryValve) -> UnitJoints:
    """Where the pump unit of a bench is joined, and what moves it."""
    if isinstance(operation, DutyOperation):
        position: Source = Connection(duty_position, (operation.duty_ratio, valve))
    else:
        position = operation.axial_position
    return UnitJoints(
        tank="tank",
        load="load_line",
        pump_speed=operation.pump_speed,
        axial_position=position,
        spool_motor_speed=operation.spool_motor_speed,
    )


def _watch(
    net: Network, encoder: EncoderTable | None, spool_filter: EventFilterValues | None, initial: InitialSupply
) -> None:
    net.extras = RotaryBench
    if (encoder is None) != (spool_filter is None):
        missing = "encoder" if encoder is None else "spool_filter"
        raise ParameterError(f"table {missing!r} is missing; a watched spool needs both an encoder and a spool_filter")
    if encoder is not None and spool_filter is not None:
        add_encoder(net, "spool", encoder, spool_filter, initial.spool_angle)
