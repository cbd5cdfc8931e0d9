"""The observer of the chamber drive as a program: where the spool is, and in which stage its control.

Source  ours, docs/models/axial-control.md, where a function names no other.
"""

from dataclasses import fields
from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import (
    Angle,
    AngularVariance,
    Count,
    Fraction,
    Length,
    Position,
    Pressure,
    Ratio,
    Speed,
    Time,
    Velocity,
)
from vvdp.base.params import Params
from vvdp.estimation.axial_filter import AxialMemory
from vvdp.estimation.chamber_observer import (
    ChamberObserver,
    SpringDrive,
    chamber_observer_start,
    chamber_observer_step,
)
from vvdp.estimation.observability import observability_margin
from vvdp.network.program import ProgramType
from vvdp.programs.axial_stages import (
    HOME,
    RUN,
    AxialObserverTable,
    AxialSequence,
    Stage,
    energised_stage,
    is_known,
    known_phase,
    next_stage,
    pollution_model,
    sight_of,
)
from vvdp.programs.generic import GenericProgram
from vvdp.sensing.axial_sensor import AxialReading

AT_STOP = 0.2e-3
"""So near the stop a spool that the spring presses there is taken to rest at it [m]."""


class SpoolBelief(NamedTuple):
    """What the observer carries from sample to sample; `slip` is that of the angle at the last one."""

    filter: AxialMemory
    stage: Stage
    slip: AngularVariance


def rests(belief: SpoolBelief, stage: Stage, pressure: float, observer: ChamberObserver) -> bool:
    """Whether a spool at its stop, or about there, is pressed to it; `pressure` of its chamber, absolute [Pa]."""
    near = stage.held > 0.0 or stage.number == HOME
    near = near or belief.filter.mean[0] < observer.stop_position + AT_STOP
    return near and is_pressed(pressure, observer)


def is_pressed(pressure: float, observer: ChamberObserver) -> bool:
    """Whether spring and preload press a spool at its stop there, whatever the chamber's `pressure` [Pa, absolute]."""
    drive = observer.drive
    holding = drive.preload + drive.stiffness * observer.stop_position
    return drive.area * (pressure - drive.reference_pressure) < holding


class ChamberObserverTable(SpringDrive, AxialObserverTable, AxialSequence):
    """The drive as it is believed, what is noise, and how long it homes and learns; the stop is at `stop_position`.

    The duty ratio is the position over the `helix_length`.
    """

    stop_position: Position
    helix_length: Length


class ChamberObserverSettings(Params):
    """What the program of the observer works with."""

    observer: ChamberObserver
    sequence: AxialSequence

    @property
    def sample_period(self) -> float:
        """How often it is called [s]."""
        return self.observer.sample_period

    @property
    def helix_length(self) -> float:
        """Length over which the duty ratio goes from 0 to 1 [m]."""
        return self.observer.pollution.helix_length


def chamber_observer_settings(table: ChamberObserverTable) -> ChamberObserverSettings:
    """The settings of the observer as its step takes them. Raises ParameterError."""
    drive = SpringDrive(**{each.name: getattr(table, each.name) for each in fields(SpringDrive)})
    sequence = AxialSequence(**{each.name: getattr(table, each.name) for each in fields(AxialSequence)})
    observer = ChamberObserver(
        drive=drive,
        pollution=pollution_model(table, table.helix_length),
        sample_period=table.sample_period,
        position_drift=table.position_drift,
        velocity_drift=table.velocity_drift,
        position_deviation=1e-4,
        velocity_deviation=1e-3,
        stop_position=table.stop_position,
    )
    return ChamberObserverSettings(observer=observer, sequence=sequence)


class WatchedSpool(NamedTuple):
    """What sensors show of a spool and its chamber. Deviations and `slip` are those of an event filter; 0: the angle is
    known. Once `energised` is 0 the control has ended."""

    time: Time
    measured: Position
    light: Fraction
    angle: Angle
    speed: Speed
    pressure: Pressure
    angle_deviation: Angle = 0.0
    speed_deviation: Speed = 0.0
    slip: AngularVariance = 0.0
    energised: Fraction = 1.0


class SeenSpool(NamedTuple):
    """What is believed of a spool. `released` is 1 while it is controlled, `pollution` what the sensor is believed to
    be off by, `known` 1 while the spool's angle is known, `frozen` 1 while the periodic sensor error is kept as
    learned."""

    position: Position
    velocity: Velocity
    position_deviation: Length
    velocity_deviation: Velocity
    pollution: Position
    margin: Ratio
    stage: Count
    released: Fraction
    known: Fraction
    frozen: Fraction


def chamber_observer_program_start(settings: ChamberObserverSettings) -> SpoolBelief:
    """Before the first sample: homing, the spool about at its stop."""
    observer = settings.observer
    return SpoolBelief(chamber_observer_start(observer, observer.stop_position), Stage(HOME, 0.0, 0.0), 0.0)


def chamber_observer_program_step(
    t: float, memory: SpoolBelief, reading: WatchedSpool, settings: ChamberObserverSettings
) -> tuple[SpoolBelief, SeenSpool]:
    """Position of a spool that a chamber moves against a spring, by the periodic Kalman filter, and its stages."""
    observer, period = settings.observer, settings.observer.sample_period
    phase = known_phase(reading, reading.slip, memory.slip)
    known = is_known(phase)
    before = energised_stage(memory.stage, reading.energised, reading.time)
    held = 1.0 if rests(memory, before, reading.pressure, observer) else 0.0
    stage = next_stage(before, reading.time, held, known, period, settings.sequence)
    margin = 1.0
    if known:
        frequency = np.sqrt(observer.drive.stiffness / observer.drive.moving_mass)
        margin = observability_margin(frequency, phase.speed, int(observer.pollution.basis.harmonics))
    signal = AxialReading(reading.time, reading.measured, reading.light)
    seen = sight_of(signal, phase, stage, 0.0, reading.pressure, margin)
    after, estimate = chamber_observer_step(memory.filter, seen, observer)
    return SpoolBelief(after, stage, reading.slip), SeenSpool(
        position=estimate.position,
        velocity=estimate.velocity,
        position_deviation=estimate.position_deviation,
        velocity_deviation=estimate.velocity_deviation,
        pollution=estimate.pollution,
        margin=margin,
        stage=stage.number,
        released=1.0 if stage.number == RUN else 0.0,
        known=1.0 if known else 0.0,
        frozen=estimate.frozen,
    )


NOTHING_SEEN = SeenSpool(**dict.fromkeys(SeenSpool._fields, 0.0))
CHAMBER_OBSERVER = GenericProgram(
    ProgramType(
        chamber_observer_program_step,
        WatchedSpool,
        NOTHING_SEEN,
        ChamberObserverTable,
        chamber_observer_program_start,
    ),
    made=chamber_observer_settings,
)
