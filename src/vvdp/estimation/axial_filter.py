"""Common parts of the observers of the spool's axial position: inputs, belief, outputs, correction.

The leading states are those of the drive, position first; then come the coefficients of the periodic sensor error.
Derived in docs/models/axial-observer.md.

Source  ours, docs/models/axial-observer.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import (
    NUMBER,
    Angle,
    AngularVariance,
    Count,
    Duration,
    Flow,
    Fraction,
    Frequency,
    Length,
    Number,
    Position,
    Pressure,
    Ratio,
    Speed,
    Time,
    Velocity,
)
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.base.select import maximum
from vvdp.estimation.duty import DutyEstimate
from vvdp.estimation.noise_basis import TURN, NoiseBasis, basis_slope, function_count, turned_variance, write_basis
from vvdp.estimation.observability import FREEZE_BELOW, WARN_BELOW
from vvdp.estimation.pressure_edges import PressureReading
from vvdp.numerics.kalman import add_variance, consider, factors_of, know_leading, observe, variance_of

KNOWN_ANGLE = 0.5
"""Deviation of the spool angle above which the periodic sensor error counts as noise without a pattern [rad];
assumed.
"""


SLOWEST_TURN = 1.0
"""Speed below which a turn counts as lasting no longer [rad/s]; assumed."""


class Phase(NamedTuple):
    """Phase of the periodic sensor error, and its rate: the spool's estimate, or a clock's.

    A deviation above `KNOWN_ANGLE`, or NaN: the angle is not known. `slip` is the variance of a jump that the angle may
    have made since the last sample, and that no later edge shows.
    """

    angle: Angle
    speed: Speed
    angle_deviation: Angle
    slip: AngularVariance = 0.0


class DutySight(NamedTuple):
    """A duty ratio as the pressure wave shows it, how long ago that was, and its deviation; NaN: nothing new."""

    duty_ratio: Number
    age: Time
    deviation: Ratio


NO_DUTY = DutySight(duty_ratio=np.nan, age=0.0, deviation=0.0)
"""Without a pressure wave."""


class AxialSeen(NamedTuple):
    """Inputs of an observer at a sample.

    `optical` is the sensor's reading, NaN where it is lost; `pressure` that of the chamber, absolute; `flow` goes into
    the axial chamber. `held` is 1 while the spool rests at its stop. `margin` is the observability margin.
    """

    time: Time
    optical: Position
    phase: Phase
    pressure: Pressure
    flow: Flow
    held: Fraction
    margin: Ratio
    duty: DutySight


class AxialEstimate(NamedTuple):
    """Estimate at a sample. Deviations are NaN where an observer does not know them.

    `pollution` is the estimated periodic error of the reading. `innovation` and its deviation are 0 at samples without
    a reading. `lost`, `frozen` and `warned` are 1 where the sensor is silent, where the periodic sensor error is kept
    as learned, and where the margin is low.
    """

    position: Position
    velocity: Velocity
    position_deviation: Length
    velocity_deviation: Velocity
    pollution: Position
    innovation: Position
    innovation_deviation: Length
    lost: Fraction
    frozen: Fraction
    warned: Fraction


class OpticalSight(NamedTuple):
    """The periodic sensor error as estimated before an optical reading was used, and the innovation of the reading."""

    pollution: Position
    innovation: Position
    innovation_deviation: Length


class AxialMemory(NamedTuple):
    """Mean (n,) and factors (n, n) of the belief, the drive's input at the last sample, and the coefficient whose turn
    it is to drift."""

    mean: Annotated[Array, NUMBER]
    factors: Annotated[Array, NUMBER]
    drive_input: Number
    turn: Count


class PollutionModel(Params):
    """The periodic sensor error of the axial sensor as an observer models it.

    `sensor_deviation` is that of the white noise of a sample. A coefficient drifts by `coefficient_drift` a sample and
    is known to `coefficient_deviation` at first. The optical signal is `optical_delay` older than the angle that comes
    with it, negative: younger. The duty ratio is the position over `helix_length`, and known no better than
    `duty_deviation`.
    """

    basis: NoiseBasis
    sensor_deviation: Length
    coefficient_drift: Length
    coefficient_deviation: Length
    helix_length: Length
    duty_deviation: Ratio
    optical_delay: Duration = 0.0

    def check(self) -> None:
        require_positive(
            self,
            "sensor_deviation",
            "coefficient_drift",
            "duty_deviation",
            why="at 0 the covariance is no longer positive definite",
        )


def axial_start(plant_mean: Array, plant_deviations: Array, pollution: PollutionModel) -> AxialMemory:
    """The memory before the first sample: states of the drive and their deviations as given, no periodic sensor
    error.
    """
    n = function_count(pollution.basis)
    mean = np.concatenate([plant_mean, np.zeros(n)])
    deviations = np.concatenate([plant_deviations, np.full(n, pollution.coefficient_deviation)])
    return AxialMemory(mean=mean, factors=factors_of(np.diag(deviations**2.0)), drive_input=0.0, turn=0.0)


class Draft(NamedTuple):
    """The belief that a step works on, in place: a copy of the memory's, and room for a row of observation and a
    gain. the `leading` states are the drive's."""

    mean: Array
    factors: Array
    row: Array
    gain: Array
    leading: int


def draft_of(memory: AxialMemory, leading: int) -> Draft:
    """A copy of the belief in the memory, to be changed in place."""
    n = memory.mean.size
    room = np.empty((2, n))
    return Draft(mean=memory.mean.copy(), factors=memory.factors.copy(), row=room[0], gain=room[1], leading=leading)


def hold_position(draft: Draft, stop_position: float) -> None:
    """At the stop position and velocity are known, in place."""
    known = min(draft.leading, 2)
    know_leading(draft.factors, known)
    draft.mean[:known] = 0.0
    draft.mean[0] = stop_position


def is_frozen(seen: AxialSeen) -> bool:
    """Whether the periodic sensor error is kept as learned. At the stop it is not, for the position is known there."""
    return seen.margin < FREEZE_BELOW and seen.held == 0.0


def drift_in_turn(draft: Draft, turn: float, pollution: PollutionModel) -> float:
    """Let one coefficient drift for all of them, in place, and return whose turn is next.

    Each takes its turn every n samples with the drift of n samples, so that a sample costs n^2 and not n^3.
    """
    n, j = draft.mean.size - draft.leading, draft.leading + int(turn)
    draft.gain[:] = 0.0
    draft.gain[j] = 1.0
    add_variance(draft.factors, draft.gain, n * pollution.coefficient_drift * pollution.coefficient_drift, j)
    return (turn + 1.0) % n


def doubt_pollution(draft: Draft, slip: float, pollution: PollutionModel) -> None:
    """Let the coefficients be those of another angle, in place.  slip: variance of that difference [rad^2]."""
    first = draft.leading
    squares = np.empty(draft.mean.size - first)
    for i in range(squares.size):
        squares[i] = draft.mean[first + i] * draft.mean[first + i] + variance_of(draft.factors, first + i)
    for i in range(squares.size):
        draft.gain[:] = 0.0
        draft.gain[first + i] = 1.0
        add_variance(draft.factors, draft.gain, turned_variance(i, squares, slip, pollution.basis), first + i)


def take_in(draft: Draft, innovation: float, variance: float, frozen: bool) -> float:
    """Take in a measurement with the draft's row, in place, and return the variance of its innovation.

    frozen  the coefficients stay, which the covariance takes into account
    """
    S = observe(draft.factors, draft.row, variance, draft.gain)
    for i in range(draft.leading if frozen else draft.mean.size):
        draft.mean[i] += draft.gain[i] * innovation
    if frozen:
        consider(draft.factors, draft.gain, S, draft.leading)
    return S


def take_optical(draft: Draft, seen: AxialSeen, pollution: PollutionModel, period: float) -> OpticalSight:
    """Take in the optical signal, in place.

    If the angle is not known, the periodic sensor error counts as noise; if it is uncertain, the effect of that on the
    periodic sensor error. Either noise lasts longer than the `period` of the samples [s], so that it has more weight
    than in one sample.
    """
    phase, mean, row, first = seen.phase, draft.mean, draft.row, draft.leading
    if phase.slip > 0.0:
        doubt_pollution(draft, phase.slip, pollution)
    row[:first] = 0.0
    row[0] = 1.0
    believed, noise = 0.0, 0.0
    lasting = TURN / (maximum(phase.speed, SLOWEST_TURN) * period)
    if phase.angle_deviation < KNOWN_ANGLE:
        angle = phase.angle - phase.speed * pollution.optical_delay
        write_basis(angle, pollution.basis, row, first)
        for i in range(first, mean.size):
            believed += mean[i] * row[i]
        off = basis_slope(angle, pollution.basis, mean, row, first) * phase.angle_deviation
        noise, lasting = off * off, lasting / (mean.size - first)
    else:
        row[first:] = 0.0
        for i in range(first, mean.size):
            noise += 0.5 * (mean[i] * mean[i] + variance_of(draft.factors, i))
    if seen.optical != seen.optical:
        return OpticalSight(believed, 0.0, 0.0)
    innovation, more = seen.optical - mean[0] - believed, noise * maximum(lasting - 1.0, 0.0)
    R = pollution.sensor_deviation * pollution.sensor_deviation + noise
    S = take_in(draft, innovation, R + more, is_frozen(seen))
    return OpticalSight(believed, innovation, np.sqrt(S - more))


def needs_duty(seen: AxialSeen) -> bool:
    """Whether a new duty ratio is available and needed: the optical sensor is lost, or nearly blind."""
    wanted = seen.margin < WARN_BELOW or seen.optical != seen.optical
    return wanted and seen.held == 0.0 and seen.duty.duty_ratio == seen.duty.duty_ratio


def duty_sight(found: DutyEstimate, edge: PressureReading, pwm_frequency: Frequency) -> DutySight:
    """The duty ratio of a pulse that ends with this edge, nothing new at any other sample.

    Each edge shows half of the position at its own time, so that together they show that at the middle of the pulse.

    found          by `duty_step`, with the valve's own excess taken off
    pwm_frequency  [Hz]
    """
    ended = edge.pressure_edges > 0.0 and edge.pressure_polarity < 0.0
    if not (ended and found.duty_ratio == found.duty_ratio and pwm_frequency > 0.0):
        return DutySight(duty_ratio=np.nan, age=0.0, deviation=0.0)
    half = 0.5 * found.wave_duty_ratio / pwm_frequency
    age = edge.time - edge.pressure_edge_time + half
    return DutySight(duty_ratio=found.duty_ratio, age=age, deviation=found.deviation)


def take_duty(draft: Draft, seen: AxialSeen, travelled: float, pollution: PollutionModel) -> None:
    """Take in the duty ratio of the pressure wave, in place; the draft's row shows where the spool was when it showed.

    travelled  change of the position since by the drive's input alone [m]

    Source  wang2017, section 7.3, for the idea
    """
    duty, L, expected = seen.duty, pollution.helix_length, -travelled
    for i in range(draft.leading):
        expected += draft.row[i] * draft.mean[i]
    known = duty.deviation * duty.deviation + pollution.duty_deviation * pollution.duty_deviation
    take_in(draft, L * duty.duty_ratio - expected, L * L * known, is_frozen(seen))


def estimate_of(draft: Draft, velocity: float, seen: AxialSeen, sight: OpticalSight) -> AxialEstimate:
    """Estimate once all has been taken in; `velocity` [m/s]."""
    return AxialEstimate(
        position=draft.mean[0],
        velocity=velocity,
        position_deviation=np.sqrt(variance_of(draft.factors, 0)),
        velocity_deviation=np.sqrt(variance_of(draft.factors, 1)) if draft.leading > 1 else np.nan,
        pollution=sight.pollution,
        innovation=sight.innovation,
        innovation_deviation=sight.innovation_deviation,
        lost=1.0 if seen.optical != seen.optical else 0.0,
        frozen=1.0 if is_frozen(seen) else 0.0,
        warned=1.0 if seen.margin < WARN_BELOW else 0.0,
    )
