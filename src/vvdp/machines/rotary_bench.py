"""The test rigs of the rotary valve: a pump unit against a load line with an orifice, or against a pressure source.

The two functions that return a `Network` are what a system file names as its circuit; the fields of their argument
are its tables.
"""

from dataclasses import dataclass, replace

from vvdp.base.params import Params
from vvdp.components.pump_unit import PumpUnit, UnitJoints, add_pump_unit
from vvdp.components.resistances import ORIFICE
from vvdp.components.rotary_valve import duty_position
from vvdp.evaluation.bench import RotaryBench
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.check_valve import CheckPoppet, CheckValve
from vvdp.hydraulics.pump import Pump
from vvdp.hydraulics.relief_valve import ReliefValve
from vvdp.hydraulics.soft_switching import SwitchChamber
from vvdp.hydraulics.spool_drive import SpoolDrive
from vvdp.hydraulics.volume import Vessel
from vvdp.network.network import Network
from vvdp.network.nodes import Chamber, Connection, Source
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


@dataclass(frozen=True, kw_only=True)
class PumpUnitTables:
    """A pump unit with its motor."""

    oil: Oil
    pump: Pump
    motor: Params
    inlet: Chamber
    relief_valve: ReliefValve
    valve: RotaryValve
    spool_drive: SpoolDrive
    check_valve: CheckPoppet

    @property
    def unit(self) -> PumpUnit:
        """The pump unit, which starts where the table [initial] says."""
        return PumpUnit(
            pump=self.pump,
            inlet=self.inlet,
            relief_valve=self.relief_valve,
            valve=self.valve,
            spool_drive=self.spool_drive,
            check_valve=self.check_valve,
            inlet_pressure="initial.inlet_pressure",
            spool_angle="initial.spool_angle",
            spool_speed="initial.spool_speed",
        )


@dataclass(frozen=True, kw_only=True)
class BenchTables(PumpUnitTables):
    """A pump unit on a test rig; switched softly if its tables say so."""

    motor: DriveMotor
    load: OrificeLoad | PressureLoad
    operation: DutyOperation | AxialOperation
    initial: InitialSupply
    limits: Limits
    bypass: CheckValve | None = None
    chamber: SwitchChamber | None = None

    @property
    def unit(self) -> PumpUnit:
        """The pump unit with what switches it softly."""
        return replace(super().unit, bypass=self.bypass, chamber=self.chamber)

    @property
    def joints(self) -> UnitJoints:
        """Where the pump unit is joined, and what moves it."""
        operation = self.operation
        if isinstance(operation, DutyOperation):
            position: Source = Connection(duty_position, (operation.duty_ratio, self.valve))
        else:
            position = operation.axial_position
        return UnitJoints(
            tank="tank",
            load="load_line",
            pump_speed=operation.pump_speed,
            axial_position=position,
            spool_motor_speed=operation.spool_motor_speed,
            cavitation_pressure=Connection(cavitation_limit, (self.limits,)),
        )


@dataclass(frozen=True, kw_only=True)
class OrificeBench(BenchTables):
    """A pump unit with a line and an orifice."""

    load_line: Vessel
    load: OrificeLoad
    initial: InitialBench


@dataclass(frozen=True, kw_only=True)
class PressureBench(BenchTables):
    """A pump unit against a pressure source."""

    load: PressureLoad


def orifice_load(tables: OrificeBench) -> Network:
    """A pump unit that feeds a line with or without accumulator and, from it, an orifice to the tank."""
    net = _new_bench(tables)
    net.volume("load_line", tables.load_line, start="initial.load_pressure")
    add_pump_unit(net, tables.unit, tables.joints)
    net.add("load", ORIFICE, tables.load, a="load_line", b="tank", area=tables.load.area)
    return net


def constant_load(tables: PressureBench) -> Network:
    """A pump unit that works against a pressure source, which also feeds the valve's leakage."""
    net = _new_bench(tables)
    net.pressure_source("load_line", tables.load.pressure)
    add_pump_unit(net, tables.unit, tables.joints)
    return net


def _new_bench(tables: BenchTables) -> Network:
    """The network of a bench with its tank, before anything else is drawn."""
    net = Network(
        tables.oil,
        temperature=tables.operation.oil_temperature,
        operation=tables.operation,
        load=tables.load,
        initial=tables.initial,
        spool_drive=tables.spool_drive,
        check_valve=tables.check_valve,
        limits=tables.limits,
    )
    net.extras = RotaryBench
    net.tank("tank", tables.operation.tank_pressure)
    return net


def cavitation_limit(limits: Limits) -> float:
    """Pressure below which cavitation is assumed, absolute [Pa]."""
    return limits.cavitation_pressure
