"""Laws of the chamber drive as programs: from a reference and the estimated motion of the spool to the valve's command.

Source  ours, docs/models/passivity-control.md, where a function names no other.
"""

from dataclasses import fields
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.kinds import (
    AirFraction,
    Area,
    BulkModulus,
    Density,
    DischargeCoefficient,
    Energy,
    Flow,
    Force,
    Fraction,
    Mass,
    Polytropic,
    Position,
    Pressure,
    SignedFraction,
    Stiffness,
    Velocity,
    Volume,
)
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.base.units import ATMOSPHERE
from vvdp.control.backstepping import BacksteppingGains, backstepping_law, refuse_flow_gain
from vvdp.control.chamber import ChamberDrive, ChamberFlow, ChamberReading, PositionGains
from vvdp.control.dead_volume import LearnedVolume, VolumeLearning, volume_step
from vvdp.control.orifice import ChamberValve, valve_command
from vvdp.control.passivity import PassivityGains, passivity_law, printed_passivity_law
from vvdp.control.reference import Jerk, Reference, SignedAcceleration
from vvdp.control.storage import loop_balance
from vvdp.fluid.oil import Oil
from vvdp.network.program import ProgramType
from vvdp.programs.chamber_report import ChamberLawReport
from vvdp.programs.generic import GenericProgram


class KnownChamber(Params):
    """Model of the drive in its control law: plunger, spring, oil and valve. Pressures are absolute.

    `preload` is the force of the spring, `oil_volume` the volume of the chamber at position 0.
    """

    area: Area
    moving_mass: Mass
    stiffness: Stiffness
    preload: Force
    oil_volume: Volume
    discharge_coefficient: DischargeCoefficient
    full_area: Area
    supply_pressure: Pressure
    tank_pressure: Pressure = ATMOSPHERE
    density: Density
    liquid_bulk_modulus: BulkModulus
    air_fraction: AirFraction
    polytropic_exponent: Polytropic = 1.4
    reference_pressure: Pressure = ATMOSPHERE


class PrintedPassivityTable(PassivityGains, KnownChamber):
    """Gains of a passivity law, and its model of the drive."""

    def check(self) -> None:
        known_drive(self)

    @property
    def sample_period(self) -> float | None:
        """Period of the calls if the law has a hold time [s]; None leaves it open."""
        return self.flow_hold or None


class PassivityTable(VolumeLearning, PrintedPassivityTable):
    """The same, and how the volume of the chamber is learned."""


class BacksteppingTable(BacksteppingGains, KnownChamber):
    """Gains of backstepping, and its model of the drive."""

    def check(self) -> None:
        refuse_flow_gain(self, known_drive(self))


class ChamberLaw(Params):
    """Parameters of the program of a law, without its gains."""

    drive: ChamberDrive


class PassivityLaw(ChamberLaw):
    """A passivity law."""

    gains: PassivityGains
    learning: VolumeLearning


class BacksteppingLaw(ChamberLaw):
    """Backstepping."""

    gains: BacksteppingGains


def known_drive(table: KnownChamber) -> ChamberDrive:
    """The drive of a table. Raises ParameterError."""
    require_positive(table, "full_area")
    oil = Oil(
        density=table.density,
        thermal_expansion=0.0,
        viscosity_40=46e-6,  # in no law of the chamber
        viscosity_100=6.8e-6,
        liquid_bulk_modulus=table.liquid_bulk_modulus,
        air_fraction=table.air_fraction,
        polytropic_exponent=table.polytropic_exponent,
        reference_pressure=table.reference_pressure,
    )
    valve = ChamberValve(
        conductance=table.discharge_coefficient * table.full_area * np.sqrt(2.0 / table.density),
        supply_pressure=table.supply_pressure,
        tank_pressure=table.tank_pressure,
    )
    return ChamberDrive(
        area=table.area,
        moving_mass=table.moving_mass,
        stiffness=table.stiffness,
        preload=table.preload,
        oil_volume=table.oil_volume,
        oil=oil,
        valve=valve,
    )


def _gains_of(cls: type[Any], table: Params) -> Any:
    return cls(**{each.name: getattr(table, each.name) for each in fields(cls)})


def passivity_settings(table: PrintedPassivityTable) -> PassivityLaw:
    """The settings of a passivity law as its step takes them; the printed one learns nothing."""
    learning = _gains_of(VolumeLearning, table) if isinstance(table, PassivityTable) else VolumeLearning()
    return PassivityLaw(drive=known_drive(table), gains=_gains_of(PassivityGains, table), learning=learning)


def backstepping_settings(table: BacksteppingTable) -> BacksteppingLaw:
    """The settings of backstepping as its step takes them."""
    return BacksteppingLaw(drive=known_drive(table), gains=_gains_of(BacksteppingGains, table))


class ChamberTask(NamedTuple):
    """The reference with its derivatives, the estimated position and velocity of the spool, and the measured pressure
    of its chamber, absolute. While `released` is 0 the valve is wide open to the tank."""

    reference: Position
    reference_velocity: Velocity
    reference_acceleration: SignedAcceleration
    reference_jerk: Jerk
    position: Position
    velocity: Velocity
    pressure: Pressure
    released: Fraction = 1.0


class ChamberCommand(NamedTuple):
    """The command of the valve, the flow that it is to pass, the desired pressure, absolute, the estimated storage of
    the closed loop, and the learned volume of the chamber at position 0."""

    command: SignedFraction
    flow: Flow
    desired_pressure: Pressure
    storage: Energy
    oil_volume: Volume = 0.0


def wanted_motion(task: ChamberTask) -> Reference:
    """The reference of a law."""
    return Reference(task.reference, task.reference_velocity, task.reference_acceleration, task.reference_jerk)


def believed_motion(task: ChamberTask) -> ChamberReading:
    """Motion and pressure of the drive, as a law receives them."""
    return ChamberReading(task.position, task.velocity, task.pressure)


def chamber_command(
    task: ChamberTask, wanted: ChamberFlow, gains: PositionGains, drive: ChamberDrive
) -> ChamberCommand:
    """The command of the valve for the flow that a law commands, once the spool is released; before, the chamber is
    emptied."""
    command, storage = -1.0, 0.0
    if task.released > 0.5:
        command = valve_command(wanted.flow, task.pressure, drive.valve)
        storage = loop_balance(wanted.flow, wanted_motion(task), believed_motion(task), gains, drive).storage
    return ChamberCommand(command, wanted.flow, wanted.desired.pressure, storage, drive.oil_volume)


def passivity_start(settings: PassivityLaw) -> LearnedVolume:
    """Before the first sample: the volume as the drive has it."""
    return LearnedVolume(settings.drive.oil_volume, 0.0, 0.0)


def passivity_step(
    t: float, memory: LearnedVolume, reading: ChamberTask, settings: PassivityLaw
) -> tuple[LearnedVolume, ChamberCommand]:
    """Passivity-based control of a chamber against a spring, with the exact feedforward."""
    gains, drive = settings.gains, settings.drive
    beside = memory.oil_volume - drive.oil_volume
    wanted = passivity_law(wanted_motion(reading), believed_motion(reading), gains, drive, beside)
    command = chamber_command(reading, wanted, gains, drive)
    learned = LearnedVolume(memory.oil_volume, t, t)
    if abs(command.command) < 1.0:
        learned = volume_step(memory, t, wanted.desired, reading.pressure, settings.learning, drive)
    return learned, command._replace(oil_volume=memory.oil_volume)


def printed_passivity_step(
    t: float, memory: NamedTuple, reading: ChamberTask, settings: PassivityLaw
) -> tuple[NamedTuple, ChamberCommand]:
    """Passivity-based control of a chamber against a spring, with the published, approximate feedforward."""
    wanted = printed_passivity_law(wanted_motion(reading), believed_motion(reading), settings.gains, settings.drive)
    return memory, chamber_command(reading, wanted, settings.gains, settings.drive)


def backstepping_step(
    t: float, memory: NamedTuple, reading: ChamberTask, settings: BacksteppingLaw
) -> tuple[NamedTuple, ChamberCommand]:
    """Traditional backstepping of a chamber against a spring."""
    wanted = backstepping_law(wanted_motion(reading), believed_motion(reading), settings.gains, settings.drive)
    return memory, chamber_command(reading, wanted, settings.gains, settings.drive)


EMPTIED = ChamberCommand(command=0.0, flow=0.0, desired_pressure=ATMOSPHERE, storage=0.0, oil_volume=0.0)
PASSIVITY = GenericProgram(
    ProgramType(passivity_step, ChamberTask, EMPTIED, PassivityTable, passivity_start, report=ChamberLawReport),
    made=passivity_settings,
)
PRINTED_PASSIVITY = GenericProgram(
    ProgramType(printed_passivity_step, ChamberTask, EMPTIED, PrintedPassivityTable, report=ChamberLawReport),
    made=passivity_settings,
)
BACKSTEPPING = GenericProgram(
    ProgramType(backstepping_step, ChamberTask, EMPTIED, BacksteppingTable, report=ChamberLawReport),
    made=backstepping_settings,
)
