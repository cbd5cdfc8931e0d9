"""Stages of the control of an axial drive, and inputs of its observer, sample by sample.

Source  ours, docs/models/axial-control.md, where a function names no other.
"""

from typing import NamedTuple, Protocol

import numpy as np

from vvdp.base.kinds import (
    Count,
    Fraction,
    Length,
    Time,
    Velocity,
)
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.base.select import maximum
from vvdp.estimation.axial_filter import KNOWN_ANGLE, NO_DUTY, AxialSeen, Phase, PollutionModel
from vvdp.estimation.noise_basis import fourier_basis
from vvdp.sensing.axial_sensor import AxialReading

HOME, LEARN, RUN, STOP = 0.0, 1.0, 2.0, 3.0
"""Stages: to the stop; there, with the periodic sensor error being learned; controlled; de-energised for good."""

SETTLED = 1.0
"""From so long after the start of control on errors count [s]."""

SLOWEST = 20.0
"""Spool speed from which on its angle may be known [rad/s]; assumed."""


class Watched(Protocol):
    """Estimate of the angle and speed of a spool, with standard deviations; 0: known."""

    @property
    def angle(self) -> float: ...
    @property
    def speed(self) -> float: ...
    @property
    def angle_deviation(self) -> float: ...
    @property
    def speed_deviation(self) -> float: ...


class AxialSequence(Params):
    """The [axial_sequence] table: how long the drive homes, and learns the periodic sensor error at its stop; and
    from when on it is de-energised for good. Without learning it is controlled from the first sample after homing."""

    home_time: Time
    learn_time: Time
    stop_time: Time = 1e6


class AxialObserverTable(Params):
    """The [axial_observer] table: how often it samples, how many harmonics the periodic sensor error has, and what
    is noise.

    Drifts are deviations of a sample; `coefficient_deviation` is that of a harmonic's part before it is learned.
    """

    sample_period: Time
    harmonics: Count
    sensor_deviation: Length
    position_drift: Length
    coefficient_drift: Length
    coefficient_deviation: Length
    velocity_drift: Velocity = 0.0

    def check(self) -> None:
        require_positive(self, "sample_period")
        pollution_model(self, 1.0)  # here, where the line of the table is known


class Stage(NamedTuple):
    """In which stage a drive is, and since when; `held` is 1 while the spool rests at its stop."""

    number: Count
    since: Time
    held: Fraction


def pollution_model(table: AxialObserverTable, helix_length: float) -> PollutionModel:
    """The periodic sensor error as the observer of a table models it; no duty ratio is measured. `helix_length` [m]."""
    return PollutionModel(
        basis=fourier_basis(int(table.harmonics)),
        sensor_deviation=table.sensor_deviation,
        coefficient_drift=table.coefficient_drift,
        coefficient_deviation=table.coefficient_deviation,
        helix_length=helix_length,
        duty_deviation=0.1,
    )


def known_phase(estimate: Watched, slip: float, before: float) -> Phase:
    """The phase of the periodic sensor error as an estimate of an angle has it; unknown while its angle is, or the
    spool stands.

    slip    part of the angle's variance that no later edge can show: jumps by sectors, each of which turns the
            periodic sensor error by a constant angle, once [rad^2]
    before  the same at the last sample [rad^2]
    """
    deviation = np.sqrt(maximum(estimate.angle_deviation * estimate.angle_deviation - slip, 0.0))
    turns = estimate.speed > SLOWEST and deviation < KNOWN_ANGLE
    seen = deviation if turns or estimate.speed_deviation == 0.0 else np.nan
    return Phase(estimate.angle, estimate.speed, seen, maximum(slip - before, 0.0))


def is_known(phase: Phase) -> bool:
    """Whether the spool's angle is known."""
    return phase.angle_deviation == phase.angle_deviation


def sight_of(
    signal: AxialReading, phase: Phase, stage: Stage, flow: float, pressure: float, margin: float
) -> AxialSeen:
    """Inputs of an observer at a sample. A sensor that is dark, or of a drive not homed yet, shows nothing.

    flow      into the drive, as it is known [m^3/s]
    pressure  of its chamber, 0 where it has none [Pa, absolute]
    margin    of observability [1]
    """
    is_blind = signal.light <= 0.0 or stage.number == HOME
    return AxialSeen(
        time=signal.time,
        optical=np.nan if is_blind else signal.position,
        phase=phase,
        pressure=pressure,
        flow=flow,
        held=stage.held,
        margin=margin,
        duty=NO_DUTY,
    )


def next_stage(stage: Stage, time: float, held: float, known: bool, period: float, sequence: AxialSequence) -> Stage:
    """The stage at a sample.

    It homes until it has rested at the stop for the home time, then learns until the angle was known for the learn
    time in all.

    time    of the sample [s]
    held    1 while the spool is pressed against its stop
    known   whether the spool's angle is known
    period  of the samples [s]
    """
    number, since = stage.number, stage.since
    if number == HOME:
        since = since if held > 0.0 else time
        if time - since >= sequence.home_time:
            number, since = LEARN, time
    if number == LEARN:
        waits = stage.number == LEARN and not known and sequence.learn_time > 0.0
        since = since + period if waits else since
        if time - since >= sequence.learn_time:
            number, since = RUN, time
    if time >= sequence.stop_time and number != STOP:
        number, since = STOP, time
    return Stage(number, since, held)


def energised_stage(stage: Stage, energised: float, time: float) -> Stage:
    """The stage of a drive, which ends for good once it is not `energised` any more.

    energised  1, or 0 without energy
    time       of the sample [s]
    """
    return stage if energised > 0.0 or stage.number == STOP else Stage(STOP, time, stage.held)
