"""Two observers of chapter 4 for the gerotor drive as programs: the lumped filter, and the signal generator.

Source  ours, docs/models/gerotor-control.md, where a function names no other.
"""

from typing import NamedTuple

from vvdp.base.kinds import Length, Speed, Time
from vvdp.estimation.signal_generator import (
    GeneratorDesign,
    GeneratorMemory,
    GeneratorObserver,
    LumpedMemory,
    LumpedObserver,
    generator_observer,
    generator_observer_step,
    generator_start,
    lumped_observer_step,
    samples_in_period,
)
from vvdp.network.program import ProgramType
from vvdp.programs.chamber_observer import NOTHING_SEEN, SeenSpool
from vvdp.programs.generic import GenericProgram
from vvdp.programs.gerotor_control import (
    HOMING,
    BelievedDrive,
    DriveStage,
    DriveWatch,
    WatchedDrive,
    drive_sight,
    drive_watch,
    seen_spool,
)


class LumpedTable(BelievedDrive):
    """Controller model of the drive; the periodic sensor error is treated as noise, behind a `bandwidth`."""

    sample_period: Time
    bandwidth: Speed


class LumpedSettings(DriveWatch):
    """Settings of the program of the lumped filter."""

    observer: LumpedObserver


class LumpedBelief(NamedTuple):
    """Memory of the lumped filter from sample to sample."""

    filter: LumpedMemory
    drive: DriveStage


def lumped_settings(table: LumpedTable) -> LumpedSettings:
    """The settings of the lumped filter as its step takes them."""
    observer = LumpedObserver(
        area=table.area,
        sample_period=table.sample_period,
        bandwidth=table.bandwidth,
        stop_position=table.stop_position,
    )
    return LumpedSettings(observer=observer, **drive_watch(table, table.sample_period))


def lumped_start(settings: LumpedSettings) -> LumpedBelief:
    """Before the first sample: homing."""
    return LumpedBelief(LumpedMemory(settings.observer.stop_position, 0.0), HOMING)


def lumped_step(
    t: float, memory: LumpedBelief, reading: WatchedDrive, settings: LumpedSettings
) -> tuple[LumpedBelief, SeenSpool]:
    """Position of a spool that a gerotor pump moves, by a filter of first order, and its stages."""
    sight = drive_sight(memory.drive, reading, settings)
    after, estimate = lumped_observer_step(memory.filter, sight.seen, settings.observer)
    return LumpedBelief(after, sight.drive), seen_spool(sight, estimate)


class GeneratorTable(BelievedDrive):
    """Controller model of the drive, the period of the sensor error, and standard deviations per sample."""

    sample_period: Time
    noise_period: Time
    sensor_deviation: Length
    position_drift: Length
    generator_drift: Length

    def check(self) -> None:
        samples_in_period(self.noise_period, self.sample_period)  # here, where the line of the table is known


class GeneratorSettings(DriveWatch):
    """Settings of the program of the signal generator."""

    observer: GeneratorObserver


class GeneratorBelief(NamedTuple):
    """Memory of the signal generator from sample to sample."""

    filter: GeneratorMemory
    drive: DriveStage


def generator_settings(table: GeneratorTable) -> GeneratorSettings:
    """The settings of the signal generator as its step takes them, with their gains. Raises ParameterError."""
    design = GeneratorDesign(
        area=table.area,
        sample_period=table.sample_period,
        noise_period=table.noise_period,
        sensor_deviation=table.sensor_deviation,
        position_drift=table.position_drift,
        generator_drift=table.generator_drift,
        stop_position=table.stop_position,
    )
    return GeneratorSettings(observer=generator_observer(design), **drive_watch(table, table.sample_period))


def generator_program_start(settings: GeneratorSettings) -> GeneratorBelief:
    """Before the first sample: homing."""
    return GeneratorBelief(generator_start(settings.observer, settings.observer.stop_position), HOMING)


def generator_step(
    t: float, memory: GeneratorBelief, reading: WatchedDrive, settings: GeneratorSettings
) -> tuple[GeneratorBelief, SeenSpool]:
    """Position of a spool that a gerotor pump moves, by a generator of the periodic sensor error, and its stages."""
    sight = drive_sight(memory.drive, reading, settings)
    after, estimate = generator_observer_step(memory.filter, sight.seen, settings.observer)
    return GeneratorBelief(after, sight.drive), seen_spool(sight, estimate)


LUMPED_OBSERVER = GenericProgram(
    ProgramType(lumped_step, WatchedDrive, NOTHING_SEEN, LumpedTable, lumped_start), made=lumped_settings
)
GENERATOR_OBSERVER = GenericProgram(
    ProgramType(generator_step, WatchedDrive, NOTHING_SEEN, GeneratorTable, generator_program_start),
    made=generator_settings,
)
