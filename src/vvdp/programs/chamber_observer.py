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
from vvdp.estimation.axial_filter import AxialEstimate, AxialMemory, Phase
from vvdp.estimation.chamber_observer import (
    ChamberObserver,
    SpringDrive,
    chamber_observer_start,
    chamber_observer_step,
)
from vvdp.estimation.observability import observability_margin
from vvdp.network.program import ProgramType
from vvdp.programs.axial_loop import (
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


class ChamberSight(NamedTuple):
    """What is seen of a chamber drive at a sample: sensor, phase of the periodic sensor error, absolute pressure."""

    signal: AxialReading
    phase: Phase
    pressure: Pressure


class ChamberBelief(NamedTuple):
    """What the observer carries from sample to sample."""

    filter: AxialMemory
    stage: Stage


class ChamberLook(NamedTuple):
    """What is known after a sample; `margin` is the observability margin at the spool's speed."""

    belief: ChamberBelief
    estimate: AxialEstimate
    margin: Ratio


def look(belief: ChamberBelief, sight: ChamberSight, observer: ChamberObserver, sequence: AxialSequence) -> ChamberLook:
    """Stage and estimate after a sample; at the stop the position is known."""
    near = belief.stage.held > 0.0 or belief.stage.number == HOME
    near = near or belief.filter.mean[0] < observer.stop_position + AT_STOP
    held = 1.0 if near and is_pressed(sight.pressure, observer) else 0.0
    stage = next_stage(belief.stage, sight.signal.time, held, is_known(sight.phase), observer.sample_period, sequence)
    margin = 1.0
    if is_known(sight.phase):
        frequency = np.sqrt(observer.drive.stiffness / observer.drive.moving_mass)
        margin = observability_margin(frequency, sight.phase.speed, int(observer.pollution.basis.harmonics))
    seen = sight_of(sight.signal, sight.phase, stage, 0.0, sight.pressure, margin)
    after, estimate = chamber_observer_step(belief.filter, seen, observer)
    return ChamberLook(ChamberBelief(after, stage), estimate, margin)


def is_pressed(pressure: float, observer: ChamberObserver) -> bool:
    """Whether spring and preload press a spool at its stop there, whatever the chamber's `pressure` [Pa, absolute]."""
    drive = observer.drive
    holding = drive.preload + drive.stiffness * observer.stop_position
    return drive.area * (pressure - drive.reference_pressure) < holding


def first_belief(observer: ChamberObserver) -> ChamberBelief:
    """Before the first sample: homing, the spool about at its stop."""
    return ChamberBelief(chamber_observer_start(observer, observer.stop_position), Stage(HOME, 0.0, 0.0))


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
    return ChamberObserverSettings(
        observer=observer_of(table, drive, table.stop_position, table.helix_length), sequence=sequence
    )


def observer_of(table: AxialObserverTable, drive: SpringDrive, stop: float, helix_length: float) -> ChamberObserver:
    """The observer of a table for a drive whose stop lies at a position [m]; `helix_length` [m]."""
    return ChamberObserver(
        drive=drive,
        pollution=pollution_model(table, helix_length),
        sample_period=table.sample_period,
        position_drift=table.position_drift,
        velocity_drift=table.velocity_drift,
        position_deviation=1e-4,
        velocity_deviation=1e-3,
        stop_position=stop,
    )


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


class WatchedBelief(NamedTuple):
    """What the program carries from sample to sample."""

    chamber: ChamberBelief
    slip: AngularVariance


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


def chamber_observer_program_start(settings: ChamberObserverSettings) -> WatchedBelief:
    """Before the first sample."""
    return WatchedBelief(first_belief(settings.observer), 0.0)


def chamber_observer_program_step(
    t: float, memory: WatchedBelief, reading: WatchedSpool, settings: ChamberObserverSettings
) -> tuple[WatchedBelief, SeenSpool]:
    """Position of a spool that a chamber moves against a spring, by the periodic Kalman filter, and its stages."""
    phase = known_phase(reading, reading.slip, memory.slip)
    sight = ChamberSight(AxialReading(reading.time, reading.measured, reading.light), phase, reading.pressure)
    before = memory.chamber
    chamber = ChamberBelief(before.filter, energised_stage(before.stage, reading.energised, reading.time))
    found = look(chamber, sight, settings.observer, settings.sequence)
    estimate, stage = found.estimate, found.belief.stage.number
    return WatchedBelief(found.belief, reading.slip), SeenSpool(
        position=estimate.position,
        velocity=estimate.velocity,
        position_deviation=estimate.position_deviation,
        velocity_deviation=estimate.velocity_deviation,
        pollution=estimate.pollution,
        margin=found.margin,
        stage=stage,
        released=1.0 if stage == RUN else 0.0,
        known=1.0 if is_known(phase) else 0.0,
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
