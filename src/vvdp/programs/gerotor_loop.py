"""The control of the gerotor drive: sensor, observer, reference, feedforward and PI, in a row at every sample.

`gerotor_view` takes a sample in, an observer says where the spool is, `position_command` makes it the pump's command.

Source  ours, docs/models/gerotor-control.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import Angle, Flow, Fraction, Position, PositionSignal, Speed, Time
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.control.feedforward_pi import FeedforwardPI, PIMemory, pi_start, pi_step
from vvdp.control.reference import Reference, ReferenceFilter, reference_at_rest
from vvdp.estimation.axial_filter import AxialEstimate, AxialMemory, AxialSeen, Phase
from vvdp.estimation.gerotor_observer import GerotorObserver, gerotor_observer_start, gerotor_observer_step
from vvdp.hydraulics.gerotor_drive import GerotorBelief, gerotor_command, gerotor_flow
from vvdp.programs.axial_loop import (
    HOME,
    LEARN,
    RUN,
    AxialCommand,
    AxialSequence,
    Demand,
    Observed,
    Stage,
    Target,
    is_known,
    next_reference,
    next_stage,
    show,
    sight_of,
)
from vvdp.programs.spool_encoder import WatchMemory, WatchSettings, watch_start
from vvdp.sensing.axial_sensor import AxialSensor, SpoolPlace, axial_sensor_start, axial_sensor_step
from vvdp.sensing.instrument import InstrumentMemory

ALWAYS_SEEN = 2.0
"""Observability margin of a position that a known flow moves: no periodic sensor error of mean zero looks like it
[1].
"""


class GerotorPlace(NamedTuple):
    """What stands before the sensors of a gerotor drive: the spool's angle, speed and position."""

    time: Time
    angle: Angle
    speed: Speed
    position: Position


class GerotorSequence(AxialSequence):
    """The [axial_sequence] table of a drive that no pressure shows its stop: for the home time `homing_command` drives
    it backward."""

    homing_command: Fraction


class DriveBelief(GerotorBelief):
    """The [calibration] table: the drive's map, and the `lag` with which its flow follows a command, as believed."""

    lag: Time

    def check(self) -> None:
        require_positive(self, "lag", why="no motor follows at once")


class GerotorLoop(Params):
    """Settings of the control of a gerotor drive; `wanted` is the position [m]."""

    sensor: AxialSensor
    law: FeedforwardPI
    calibration: DriveBelief
    reference: ReferenceFilter
    sequence: GerotorSequence
    sample_period: Time
    stop_position: Position
    wanted: PositionSignal
    observer: GerotorObserver


class WatchedGerotor(Params):
    """The same with the spool's angle given by an encoder."""

    watch: WatchSettings
    loop: GerotorLoop


class DriveMemory(NamedTuple):
    """What the loop carries from sample to sample, but for its observer: `settled` is the flow that the command should
    lead to, `flow` what it is taken to have come to."""

    sensor: InstrumentMemory
    reference: Reference
    stage: Stage
    integral: PIMemory
    settled: Flow
    flow: Flow


class GerotorMemory(NamedTuple):
    """Memory of loop and observer from sample to sample."""

    drive: DriveMemory
    observer: AxialMemory


class WatchedGerotorMemory(NamedTuple):
    """The same with the encoder."""

    watch: WatchMemory
    loop: GerotorMemory


class GerotorView(NamedTuple):
    """What is known at a sample, before an observer is asked."""

    sensor: InstrumentMemory
    reference: Reference
    stage: Stage
    integral: PIMemory
    seen: AxialSeen
    measured: Position


def drive_start(settings: GerotorLoop) -> DriveMemory:
    """The memory before the first sample: homing."""
    return DriveMemory(
        sensor=axial_sensor_start(settings.sensor),
        reference=reference_at_rest(settings.stop_position),
        stage=Stage(HOME, 0.0, 1.0),
        integral=pi_start(),
        settled=0.0,
        flow=0.0,
    )


def gerotor_loop_start(settings: GerotorLoop) -> GerotorMemory:
    """The memory before the first sample, with the observer's."""
    return GerotorMemory(drive_start(settings), gerotor_observer_start(settings.observer, settings.stop_position))


def stage_at_stop(stage: Stage, time: float, known: bool, period: float, sequence: AxialSequence) -> Stage:
    """The stage at a sample [s] of a drive that is taken to be at its stop until it is controlled; `period` [s]."""
    after = next_stage(stage, time, 1.0, known, period, sequence)
    return Stage(after.number, after.since, 1.0 if after.number == HOME or after.number == LEARN else 0.0)


def flow_after(settled: float, flow: float, period: float, lag: float) -> float:
    """Value of a flow [m^3/s] a `period` [s] later on its way to a settled one."""
    after: float = settled + (flow - settled) * np.exp(-period / lag)
    return after


def gerotor_view(
    memory: DriveMemory, place: GerotorPlace, phase: Phase, wanted: float, settings: GerotorLoop
) -> GerotorView:
    """What is known after a sample: stage, reference, and what an observer sees.

    Until it is controlled the drive is taken to be at its stop, and its flow to move nothing.

    phase   of the periodic sensor error, as the spool's angle is known
    wanted  position [m]
    """
    sensor, signal = axial_sensor_step(
        memory.sensor, SpoolPlace(place.time, place.position, place.angle), settings.sensor
    )
    period = settings.sample_period
    stage = stage_at_stop(memory.stage, place.time, is_known(phase), period, settings.sequence)
    flow = flow_after(memory.settled, memory.flow, period, settings.calibration.lag)
    target = Target(wanted, settings.stop_position)
    return GerotorView(
        sensor=sensor,
        reference=next_reference(memory.reference, stage, target, period, settings.reference),
        stage=stage,
        integral=memory.integral,
        seen=sight_of(signal, phase, stage, flow, 0.0, ALWAYS_SEEN),
        measured=signal.position,
    )


def position_command(
    view: GerotorView, estimate: AxialEstimate, settings: GerotorLoop
) -> tuple[DriveMemory, AxialCommand]:
    """Memory and command: backward while it homes; controlled; else none, which leaves the spool where it is.

    The flow that the observer will know is that of the command as the map is believed: none in the dead band.
    """
    integral, flow, command, settled = pi_start(), 0.0, 0.0, 0.0
    if view.stage.number == HOME:
        command = -settings.sequence.homing_command
    if view.stage.number == RUN:
        integral, flow = pi_step(view.integral, view.reference, estimate.position, settings.sample_period, settings.law)
        command = gerotor_command(flow, settings.calibration)
        settled = gerotor_flow(command, settings.calibration)
    memory = DriveMemory(
        sensor=view.sensor,
        reference=view.reference,
        stage=view.stage,
        integral=integral,
        settled=settled,
        flow=view.seen.flow,
    )
    observed, demand = Observed(view.seen.phase, view.measured, view.seen.margin), Demand(flow, 101325.0, 0.0)
    return memory, show(command, view.stage, view.reference, observed, estimate, demand)


def gerotor_axial_step(
    memory: GerotorMemory, place: GerotorPlace, phase: Phase, wanted: float, settings: GerotorLoop
) -> tuple[GerotorMemory, AxialCommand]:
    """One sample of the loop with the periodic Kalman filter."""
    view = gerotor_view(memory.drive, place, phase, wanted, settings)
    observer, estimate = gerotor_observer_step(memory.observer, view.seen, settings.observer)
    drive, command = position_command(view, estimate, settings)
    return GerotorMemory(drive, observer), command


def watched_gerotor_start(settings: WatchedGerotor) -> WatchedGerotorMemory:
    """The memory before the first sample."""
    return WatchedGerotorMemory(watch_start(settings.watch), gerotor_loop_start(settings.loop))
