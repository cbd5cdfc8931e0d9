"""The test benches of the rotary valve: a pump unit against a load line with an orifice, or against a pressure source.

The two functions that return a `Network` are what a system file names as its circuit; their arguments are its tables.
"""

from typing import Any

from vvdp.base.errors import ParameterError
from vvdp.base.params import Params
from vvdp.components.pump_unit import PumpUnit, UnitJoints, add_pump_unit
from vvdp.components.resistances import ORIFICE
from vvdp.components.rotary_valve import duty_position
from vvdp.estimation.event_settings import EventFilterValues
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.check_valve import CheckPoppet, CheckValve
from vvdp.hydraulics.pump import Pump
from vvdp.hydraulics.relief_valve import ReliefValve
from vvdp.hydraulics.soft_switching import SwitchChamber
from vvdp.hydraulics.spool_drive import SpoolDrive
from vvdp.hydraulics.volume import Vessel
from vvdp.network.network import Network
from vvdp.network.nodes import Chamber, Connection, Source
from vvdp.programs.spool_encoder import EncoderTable, add_encoder, watch_settings
from vvdp.systems.bench import RotaryBench
from vvdp.systems.bench_tables import (
    AxialOperation,
    DriveMotor,
    DutyOperation,
    InitialBench,
    InitialSupply,
    Limits,
    OrificeLoad,
    PressureLoad,
)
from vvdp.valve.rotary import RotaryValve


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
    bypass: CheckValve | None = None,
    chamber: SwitchChamber | None = None,
) -> Network:
    """A pump unit that feeds a line with or without accumulator and, from it, an orifice to the tank."""
    unit = pump_unit(
        pump=pump,
        inlet=inlet,
        relief_valve=relief_valve,
        valve=valve,
        spool_drive=spool_drive,
        check_valve=check_valve,
        bypass=bypass,
        chamber=chamber,
    )
    net = new_bench(oil, unit, operation, load, initial, limits)
    join_load(net, unit, joints(operation, valve, limits), load_line, load)
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
    bypass: CheckValve | None = None,
    chamber: SwitchChamber | None = None,
) -> Network:
    """A pump unit that works against a pressure source, which also feeds the valve's leakage."""
    unit = pump_unit(
        pump=pump,
        inlet=inlet,
        relief_valve=relief_valve,
        valve=valve,
        spool_drive=spool_drive,
        check_valve=check_valve,
        bypass=bypass,
        chamber=chamber,
    )
    net = new_bench(oil, unit, operation, load, initial, limits)
    net.pressure_source("load_line", load.pressure)
    add_pump_unit(net, unit, joints(operation, valve, limits))
    _watch(net, encoder, spool_filter, initial)
    return net


def pump_unit(**parts: Any) -> PumpUnit:
    """A pump unit that starts where the table [initial] says."""
    return PumpUnit(
        **parts,
        inlet_pressure="initial.inlet_pressure",
        spool_angle="initial.spool_angle",
        spool_speed="initial.spool_speed",
    )


def new_bench(
    oil: Oil,
    unit: PumpUnit,
    operation: DutyOperation | AxialOperation,
    load: Params,
    initial: InitialSupply,
    limits: Limits,
) -> Network:
    """The network of a bench with its tank, before anything else is drawn."""
    net = Network(
        oil,
        temperature=operation.oil_temperature,
        operation=operation,
        load=load,
        initial=initial,
        spool_drive=unit.spool_drive,
        check_valve=unit.check_valve,
        limits=limits,
    )
    net.extras = RotaryBench
    net.tank("tank", operation.tank_pressure)
    return net


def joints(operation: DutyOperation | AxialOperation, valve: RotaryValve, limits: Limits) -> UnitJoints:
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
        cavitation_pressure=Connection(cavitation_limit, (limits,)),
    )


def join_load(net: Network, unit: PumpUnit, joined: UnitJoints, load_line: Vessel, load: OrificeLoad) -> None:
    """Add the pump unit, the line it delivers into, and the orifice from there to the tank."""
    net.volume("load_line", load_line, start="initial.load_pressure")
    add_pump_unit(net, unit, joined)
    net.add("load", ORIFICE, load, a="load_line", b="tank", area=load.area)


def cavitation_limit(limits: Limits) -> float:
    """Pressure below which oil is held to evaporate, absolute [Pa]."""
    return limits.cavitation_pressure


def _watch(
    net: Network, encoder: EncoderTable | None, spool_filter: EventFilterValues | None, initial: InitialSupply
) -> None:
    if (encoder is None) != (spool_filter is None):
        missing = "encoder" if encoder is None else "spool_filter"
        raise ParameterError(f"table {missing!r} is missing; a watched spool needs both an encoder and a spool_filter")
    if encoder is not None and spool_filter is not None:
        add_encoder(net, "spool", watch_settings(encoder, spool_filter, initial.spool_angle))
