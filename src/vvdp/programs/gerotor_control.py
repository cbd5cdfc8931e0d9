"""Observer and law of the gerotor drive as programs.

Source  ours, docs/models/gerotor-control.md, where a function names no other.
"""

from dataclasses import fields
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.kinds import (
    Angle,
    AngularVariance,
    Area,
    Count,
    Flow,
    Fraction,
    Length,
    Position,
    SignedFraction,
    Speed,
    Time,
    Velocity,
)
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.control.feedforward_pi import FeedforwardPI, PIMemory, SquareRate, pi_start, pi_step
from vvdp.control.reference import Rate, Reference
from vvdp.estimation.axial_filter import AxialEstimate, AxialMemory, AxialSeen
from vvdp.estimation.gerotor_observer import GerotorObserver, gerotor_observer_start, gerotor_observer_step
from vvdp.hydraulics.gerotor_drive import GerotorBelief, gerotor_command, gerotor_flow
from vvdp.network.program import ProgramType
from vvdp.programs.axial_stages import (
    HOME,
    LEARN,
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
from vvdp.programs.chamber_observer import NOTHING_SEEN, SeenSpool
from vvdp.programs.generic import GenericProgram
from vvdp.programs.spool_report import SpoolReport
from vvdp.sensing.axial_sensor import AxialReading

ALWAYS_SEEN = 2.0
"""Observability margin of a position that a known flow moves: no periodic sensor error of mean zero looks like it
[1].
"""


class DriveBelief(GerotorBelief):
    """The drive's map, and the `lag` with which its flow follows a command, as believed."""

    lag: Time

    def check(self) -> None:
        require_positive(self, "lag", why="no motor follows at once")


class BelievedDrive(DriveBelief, AxialSequence):
    """The drive's map as it is believed, and how long it homes and learns; the stop is at `stop_position`. The flow
    moves `area`; the duty ratio is the position over the `helix_length`."""

    area: Area
    stop_position: Position
    helix_length: Length

    def check(self) -> None:
        require_positive(self, "area", "helix_length")


class GerotorObserverTable(BelievedDrive, AxialObserverTable):
    """The drive as it is believed, and what is noise."""


class DriveWatch(Params):
    """What the program of an observer works with beside the observer itself."""

    sequence: AxialSequence
    belief: DriveBelief
    helix_length: Length
    sample_period: Time


class GerotorObserverSettings(DriveWatch):
    """What the program of the periodic Kalman filter works with."""

    observer: GerotorObserver


def drive_watch(table: BelievedDrive, sample_period: float) -> dict[str, Any]:
    """The fields of `DriveWatch` of a table; `sample_period` [s]."""
    return {
        "sequence": AxialSequence(**{each.name: getattr(table, each.name) for each in fields(AxialSequence)}),
        "belief": DriveBelief(**{each.name: getattr(table, each.name) for each in fields(DriveBelief)}),
        "helix_length": table.helix_length,
        "sample_period": sample_period,
    }


def gerotor_observer_settings(table: GerotorObserverTable) -> GerotorObserverSettings:
    """The settings of the observer as its step takes them. Raises ParameterError."""
    observer = gerotor_observer_of(table, table.area, table.stop_position, table.helix_length)
    return GerotorObserverSettings(observer=observer, **drive_watch(table, table.sample_period))


def gerotor_observer_of(table: AxialObserverTable, area: float, stop: float, helix_length: float) -> GerotorObserver:
    """The periodic Kalman filter of a table: `area` [m^2], position of the stop and length of the helix [m]."""
    return GerotorObserver(
        area=area,
        pollution=pollution_model(table, helix_length),
        sample_period=table.sample_period,
        position_drift=table.position_drift,
        position_deviation=1e-4,
        stop_position=stop,
    )


class WatchedDrive(NamedTuple):
    """What sensors show of a spool, and the command of its pump, which has been in force until now. Deviations and
    `slip` are those of an event filter; 0: the angle is known. Once `energised` is 0 the control has ended."""

    time: Time
    measured: Position
    light: Fraction
    angle: Angle
    speed: Speed
    command: SignedFraction
    angle_deviation: Angle = 0.0
    speed_deviation: Speed = 0.0
    slip: AngularVariance = 0.0
    energised: Fraction = 1.0


class DriveStage(NamedTuple):
    """Stage of a drive, what the pump's flow is taken to have come to, and how far the angle may have slipped."""

    stage: Stage
    flow: Flow
    slip: AngularVariance


class DriveBeliefMemory(NamedTuple):
    """What the observer carries from sample to sample."""

    filter: AxialMemory
    drive: DriveStage


class DriveSight(NamedTuple):
    """What is known at a sample, before an observer is asked."""

    drive: DriveStage
    seen: AxialSeen


HOMING = DriveStage(Stage(HOME, 0.0, 1.0), 0.0, 0.0)
"""Before the first sample."""


def gerotor_observer_program_start(settings: GerotorObserverSettings) -> DriveBeliefMemory:
    """Before the first sample: homing."""
    return DriveBeliefMemory(gerotor_observer_start(settings.observer, settings.observer.stop_position), HOMING)


def stage_at_stop(stage: Stage, time: float, known: bool, period: float, sequence: AxialSequence) -> Stage:
    """The stage at a sample [s] of a drive that is taken to be at its stop until it is controlled; `period` [s]."""
    after = next_stage(stage, time, 1.0, known, period, sequence)
    return Stage(after.number, after.since, 1.0 if after.number == HOME or after.number == LEARN else 0.0)


def flow_after(settled: float, flow: float, period: float, lag: float) -> float:
    """What a flow [m^3/s] has come to a `period` [s] later on its way to a settled one."""
    after: float = settled + (flow - settled) * np.exp(-period / lag)
    return after


def drive_sight(before: DriveStage, reading: WatchedDrive, watch: DriveWatch) -> DriveSight:
    """Stage, flow, and what an observer sees at a sample."""
    phase = known_phase(reading, reading.slip, before.slip)
    settled = 0.0
    if before.stage.number == RUN:
        settled = gerotor_flow(reading.command, watch.belief)
    flow = flow_after(settled, before.flow, watch.sample_period, watch.belief.lag)
    last = energised_stage(before.stage, reading.energised, reading.time)
    stage = stage_at_stop(last, reading.time, is_known(phase), watch.sample_period, watch.sequence)
    signal = AxialReading(reading.time, reading.measured, reading.light)
    return DriveSight(DriveStage(stage, flow, reading.slip), sight_of(signal, phase, stage, flow, 0.0, ALWAYS_SEEN))


def seen_spool(sight: DriveSight, estimate: AxialEstimate) -> SeenSpool:
    """What is believed of a spool that a pump moves, after a sample."""
    stage = sight.drive.stage.number
    return SeenSpool(
        position=estimate.position,
        velocity=estimate.velocity,
        position_deviation=estimate.position_deviation,
        velocity_deviation=estimate.velocity_deviation,
        pollution=estimate.pollution,
        margin=ALWAYS_SEEN,
        stage=stage,
        released=1.0 if stage == RUN else 0.0,
        known=1.0 if is_known(sight.seen.phase) else 0.0,
        frozen=estimate.frozen,
    )


def gerotor_observer_program_step(
    t: float, memory: DriveBeliefMemory, reading: WatchedDrive, settings: GerotorObserverSettings
) -> tuple[DriveBeliefMemory, SeenSpool]:
    """Position of a spool that a gerotor pump moves, by the periodic Kalman filter, and its stages."""
    sight = drive_sight(memory.drive, reading, settings)
    after, estimate = gerotor_observer_step(memory.filter, sight.seen, settings.observer)
    return DriveBeliefMemory(after, sight.drive), seen_spool(sight, estimate)


class FeedforwardTable(GerotorBelief):
    """Gains over the `area` that the flow moves, K_p/A_s and K_i/A_s; the pump's map as it is believed; and the command
    with which it homes, backward."""

    area: Area
    proportional_rate: Rate
    integral_rate: SquareRate
    sample_period: Time
    homing_command: Fraction = 0.0

    def check(self) -> None:
        require_positive(self, "sample_period")
        feedforward_of(self)


class FeedforwardSettings(Params):
    """What the program of the law works with."""

    law: FeedforwardPI
    belief: GerotorBelief
    sample_period: Time
    homing_command: Fraction


def feedforward_of(table: FeedforwardTable) -> FeedforwardPI:
    """The law of a table. Raises ParameterError."""
    return FeedforwardPI(
        area=table.area,
        proportional_rate=table.proportional_rate,
        integral_rate=table.integral_rate,
        lowest_flow=-table.backward_gain * table.largest_flow,
        highest_flow=table.largest_flow,
    )


def feedforward_settings(table: FeedforwardTable) -> FeedforwardSettings:
    """The settings of the law as its step takes them."""
    belief = GerotorBelief(**{each.name: getattr(table, each.name) for each in fields(GerotorBelief)})
    return FeedforwardSettings(
        law=feedforward_of(table),
        belief=belief,
        sample_period=table.sample_period,
        homing_command=table.homing_command,
    )


class DriveTask(NamedTuple):
    """The reference with its velocity, and what is believed of the spool. In stage 0 the pump drives it backward to its
    stop, in stage 2 it is controlled, and else left where it is."""

    reference: Position
    reference_velocity: Velocity
    position: Position
    stage: Count = RUN


class DriveCommand(NamedTuple):
    """The command of the pump, and the flow that it is to give."""

    command: SignedFraction
    flow: Flow


def feedforward_start(settings: FeedforwardSettings) -> PIMemory:
    """Before the first sample."""
    return pi_start()


def feedforward_step(
    t: float, memory: PIMemory, reading: DriveTask, settings: FeedforwardSettings
) -> tuple[PIMemory, DriveCommand]:
    """Feedforward of the velocity and PI control of a spool that a gerotor pump moves."""
    integral, flow, command = pi_start(), 0.0, 0.0
    if reading.stage == HOME:
        command = -settings.homing_command
    if reading.stage == RUN:
        reference = Reference(reading.reference, reading.reference_velocity, 0.0, 0.0)
        integral, flow = pi_step(memory, reference, reading.position, settings.sample_period, settings.law)
        command = gerotor_command(flow, settings.belief)
    return integral, DriveCommand(command, flow)


GEROTOR_OBSERVER = GenericProgram(
    ProgramType(
        gerotor_observer_program_step,
        WatchedDrive,
        NOTHING_SEEN,
        GerotorObserverTable,
        gerotor_observer_program_start,
    ),
    made=gerotor_observer_settings,
)
FEEDFORWARD_PI = GenericProgram(
    ProgramType(
        feedforward_step, DriveTask, DriveCommand(0.0, 0.0), FeedforwardTable, feedforward_start, report=SpoolReport
    ),
    made=feedforward_settings,
)
