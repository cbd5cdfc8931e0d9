"""Encoder and inlet pressure together: the edges of the pressure wave are a second, coarser encoder on the same spool.

The event filter keeps angle and speed; beside them go the phase of the wave, its lag and the duty ratio, which the
pressure needs and the encoder does not. Derived in docs/models/pressure-fusion.md.

Source  ours, docs/models/pressure-fusion.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ParameterError
from vvdp.base.kinds import Angle, AngularVariance, Count, DutyRatio, Kind, Ratio, RatioDrift, Time
from vvdp.base.params import Params
from vvdp.base.rules import refuse, refuse_together, require_positive
from vvdp.base.select import maximum, minimum
from vvdp.estimation.association import sector
from vvdp.estimation.between_edges import believed_at, heard_plainly, inflate
from vvdp.estimation.estimator import Estimate, to_estimate
from vvdp.estimation.event_filter import after_edge, after_expected_edge
from vvdp.estimation.event_memory import EventFilterMemory, LastEdge, event_filter_start
from vvdp.estimation.event_settings import EventFilter
from vvdp.estimation.expected_edge import edge_angle_variance, expected_at
from vvdp.estimation.silence import Heard
from vvdp.estimation.threshold import AngleDrift
from vvdp.numerics.kalman import AngleSpeed, predict
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import edge_angle, edge_below

TIME_VARIANCE = Kind("variance of a time", "s^2", 0.0, 1.0, "1e-8 s^2")
LAG = Kind("lag", "s", -1.0, 1.0, "0.2 ms")

TimeVariance = Annotated[float, TIME_VARIANCE]
Lag = Annotated[float, LAG]

PATIENT_PITCHES = 1.5
"""Periods of the pressure wave without an edge after which the pressure is taken to be silent too [1]."""

SILENT_SECTORS = 4.0
"""Sectors that pass without an edge until the encoder counts as lost."""

FAR = 2.0
"""Deviations beyond which pressure edges of one side, several in a row, show that something has changed [1]."""


class Fusion(Params):
    """Settings of the fusion; `fusion` has the usual ones.

    `pressure_variance` is sigma_p^2, of a pressure edge as an angle, besides its time resolution. The wave is that of a
    spool with `sections`, its duty ratio larger by `duty_excess`, late by the phase (mounting angle) and by `lag`;
    `lag_variance` 0 takes the lag as known. `duty_sensor_variance` is that of a measured duty ratio. A pressure edge
    further than `gate` deviations from where it is expected is refused; after `patience` of them in a row the wave has
    changed or, where the encoder is silent, after as many edges far to one side the speed or the duty ratio.
    """

    filter: EventFilter
    sections: Count
    pressure_variance: AngularVariance
    phase: Angle
    phase_variance: AngularVariance
    phase_drift: AngleDrift
    duty_ratio: DutyRatio
    duty_ratio_variance: Ratio
    duty_ratio_drift: RatioDrift
    duty_sensor_variance: Ratio
    duty_excess: DutyRatio
    lag: Lag
    lag_variance: TimeVariance
    gate: Ratio
    patience: Count

    def check(self) -> None:
        if not self.sections >= 1.0:
            refuse(self, "sections", "must be at least 1")
        require_positive(self, "pressure_variance", "duty_sensor_variance", why="no sensor is exact")
        if self.filter.ripple_order > 0.0:
            refuse_together(
                self,
                f"ripple_order of its filter: {self.filter.ripple_order:g} must be 0; with the pressure no ripple can "
                "be estimated",
            )


class Doubts(NamedTuple):
    """When the encoder and the pressure last spoke, and when an edge of either was last accepted.

    How many pressure edges in a row were refused, lay on one side of where they should while the encoder was silent
    (`speed_run`), and meant a longer or shorter pulse then (`duty_run`).
    """

    encoder_time: Time
    pressure_time: Time
    agreed_time: Time
    refused: Count
    speed_run: float
    duty_run: float


class FusionMemory(NamedTuple):
    """The event filter with its belief at the last edge of either sensor; mean (5,) and covariance (5, 5) of angle,
    speed, phase, duty ratio and lag at that time; and what speaks against them."""

    filter: EventFilterMemory
    mean: Array
    covariance: Array
    doubts: Doubts


class FusionReading(NamedTuple):
    """The encoder's reading, the pressure's edge (as in `PressureReading`), and the duty ratio that an axial sensor
    measures; NaN without one."""

    encoder: Reading
    pressure_edges: Count
    pressure_edge_time: Time
    pressure_edge_interval: Time
    pressure_polarity: float
    duty_ratio: float


class FusionEstimate(NamedTuple):
    """Estimate at a sample: angle and speed (the innovation shown is the encoder's), and the pressure wave."""

    estimate: Estimate
    phase: Angle
    phase_deviation: float
    duty_ratio: DutyRatio
    duty_deviation: float
    lag: Time
    lag_deviation: float


def fusion(settings: EventFilter) -> Fusion:
    """The usual settings for a spool of three sections whose wave is unknown; change one with `dataclasses.replace`.

    The phase is anywhere within a section, the duty ratio anywhere. 0.04 rad for a pressure edge is assumed.
    """
    return Fusion(
        filter=settings,
        sections=3.0,
        pressure_variance=0.04**2.0,
        phase=0.0,
        phase_variance=(2.0 * np.pi / 3.0) ** 2.0 / 12.0,
        phase_drift=1e-5,
        duty_ratio=0.5,
        duty_ratio_variance=0.2**2.0,
        duty_ratio_drift=1e-4,
        duty_sensor_variance=0.01**2.0,
        duty_excess=0.0,
        lag=0.0,
        lag_variance=0.0,
        gate=5.0,
        patience=4.0,
    )


def pressure_edge_angle(
    number: float, polarity: float, duty_ratio: float, phase: float, lag_angle: float, sections: float
) -> float:
    """Angle of the spool when a pressure edge is seen [rad]: (k -/+ d/2) 2 pi/N + phi + omega l.

    number      k, of the pulse
    polarity    +1 tank to load, -1 load to tank
    duty_ratio  d, of the wave [1]
    phase       phi, mounting angle [rad]
    lag_angle   omega l, by which the spool turns while the pressure lags behind the ports [rad]
    sections    N [1]

    Source  ours, docs/models/pressure-fusion.md, with the openings of docs/models/rotary-valve.md
    """
    angle: float = (number - 0.5 * polarity * duty_ratio) * 2.0 * np.pi / sections + phase + lag_angle
    return angle


def fusion_start(settings: Fusion, time: float, angle: float, speed: float) -> FusionMemory:
    """Memory before the first sample.

    time   [s]
    angle  where the wheel stands, as far as is known [rad]
    speed  expected [rad/s]
    """
    start = event_filter_start(settings.filter, time, angle, speed)
    mean, P = np.zeros(5), np.zeros((5, 5))
    _begin_wave(mean, P, settings)
    _believe(mean, P, start.belief)
    doubts = Doubts(
        encoder_time=time, pressure_time=-np.inf, agreed_time=time, refused=0.0, speed_run=0.0, duty_run=0.0
    )
    return FusionMemory(filter=start, mean=mean, covariance=P, doubts=doubts)


def fusion_step(memory: FusionMemory, reading: FusionReading, settings: Fusion) -> tuple[FusionMemory, FusionEstimate]:
    """Memory and estimate after a sample. The pressure is listened to once the encoder has given the angle.

    The Kalman filter for x = (theta, omega, phi, d, l). An encoder edge has H = [1, 0, 0, 0, 0] and concerns angle and
    speed as if they were alone: the event filter handles it, and the wave follows with the same innovation. A pressure
    edge has H = [1, -l, -1, +-pi/N, -omega].
    """
    encoder = reading.encoder
    innovation, deviation = 0.0, 0.0
    # The encoder comes first: a pressure edge may be met at a time before the last edge, an encoder edge may not.
    if encoder.edges > 0.0:
        memory, innovation, deviation = _after_encoder(memory, encoder, settings)
    if reading.pressure_edges > 0.0 and reading.pressure_polarity != 0.0 and memory.filter.tally.associating > 0.0:
        memory = _after_pressure_edge(memory, reading, settings)
    heard = _hear(memory, encoder.time, settings)
    estimate = to_estimate(heard, heard.standstill, innovation, deviation, memory.filter.tally.missed_edges)
    shown = FusionEstimate(
        estimate=estimate,
        phase=memory.mean[2],
        phase_deviation=np.sqrt(memory.covariance[2, 2]),
        duty_ratio=memory.mean[3],
        duty_deviation=np.sqrt(memory.covariance[3, 3]),
        lag=memory.mean[4],
        lag_deviation=np.sqrt(memory.covariance[4, 4]),
    )
    return memory, shown


def _turns(memory: FusionMemory, time: float, settings: Fusion) -> bool:
    """Whether the pressure shows that the spool turns; a silence of the encoder then carries no information."""
    pitch = 2.0 * np.pi / settings.sections
    since = (time - memory.doubts.pressure_time) * maximum(memory.filter.belief.speed, settings.filter.lowest_speed)
    turns: bool = memory.doubts.pressure_time > memory.filter.last.time and since < PATIENT_PITCHES * pitch
    return turns


def _hear(memory: FusionMemory, time: float, settings: Fusion) -> Heard:
    """Belief at `time` [s]."""
    last = memory.filter
    if _turns(memory, time, settings):
        return heard_plainly(predict(last.belief, time - last.time, last.manoeuvre.density))
    return believed_at(last, time, settings.filter)


def lag_of_phases(speeds: Array, phases: Array) -> tuple[float, float]:
    """Mounting angle [rad] and lag [s] that phases [rad] found at several speeds [rad/s], shape (n,), come from.

    Least squares through phi = phi_0 + omega l, for phases that were estimated with a lag of 0.
    Raises ParameterError where the speeds are all the same: then any lag fits.
    """
    spread = speeds - np.mean(speeds)
    if not np.dot(spread, spread) > 0.0:
        raise ParameterError(f"{speeds.size} phases at one speed; a lag shows only where the speed changes")
    lag = float(np.dot(spread, phases) / np.dot(spread, spread))
    return float(np.mean(phases) - lag * np.mean(speeds)), lag


def _begin_wave(mean: Array, covariance: Array, settings: Fusion) -> None:
    """Forget the wave, in place."""
    x, P = mean, covariance
    x[2], x[3], x[4] = settings.phase, settings.duty_ratio, settings.lag
    for i in range(2, 5):
        for j in range(5):
            P[i, j] = P[j, i] = 0.0
    P[2, 2], P[3, 3], P[4, 4] = settings.phase_variance, settings.duty_ratio_variance, settings.lag_variance


def _believe(mean: Array, covariance: Array, belief: AngleSpeed) -> None:
    """Take over angle and speed, in place."""
    x, P = mean, covariance
    x[0], x[1] = belief.angle, belief.speed
    P[0, 0], P[0, 1] = belief.angle_variance, belief.covariance
    P[1, 0], P[1, 1] = belief.covariance, belief.speed_variance


def _move(mean: Array, covariance: Array, h: float) -> None:
    """Prediction over h [s] or, if negative, back, in place, as if only the speed moved the angle."""
    x, P = mean, covariance
    x[0] += h * x[1]
    for i in range(5):
        P[0, i] += h * P[1, i]
    for i in range(5):
        P[i, 0] += h * P[i, 1]


def _drift(covariance: Array, h: float, acceleration_density: float, settings: Fusion) -> None:
    """Let in the noise of h [s], in place."""
    P, q = covariance, acceleration_density
    P[0, 0] += q * h * h * h / 3.0
    P[0, 1] += 0.5 * q * h * h
    P[1, 0] = P[0, 1]
    P[1, 1] += q * h
    P[2, 2] += settings.phase_drift * h
    P[3, 3] += settings.duty_ratio_drift * h


def _observe(mean: Array, covariance: Array, observation: Array, innovation: float, variance: float) -> None:
    """A Kalman filter's update with whole matrices, in place: between updates parts of it are overwritten."""
    x, P, n = mean, covariance, mean.size
    g = np.zeros(n)
    S = variance
    for i in range(n):
        for j in range(n):
            g[i] += P[i, j] * observation[j]
        S += observation[i] * g[i]
    for i in range(n):
        x[i] += g[i] / S * innovation
        for j in range(n):
            P[i, j] -= g[i] * g[j] / S


def _after_encoder(memory: FusionMemory, encoder: Reading, settings: Fusion) -> tuple[FusionMemory, float, float]:
    before = memory.filter
    if _turns(memory, encoder.edge_time, settings):
        expected = expected_at(before, encoder, settings.filter)
        after, innovation, deviation = after_expected_edge(before, encoder, expected, 0.0, settings.filter)
    else:
        after, innovation, deviation = after_edge(before, encoder, settings.filter)
    if not deviation > 0.0:
        m = memory
        still = m._replace(filter=after)
        return still, innovation, deviation
    S = deviation * deviation
    R = edge_angle_variance(before.belief.speed, encoder.edge_interval, settings.filter)
    h = after.time - before.time
    mean, P = memory.mean.copy(), memory.covariance.copy()
    _move(mean, P, h)
    _drift(P, maximum(h, 0.0), 0.0, settings)
    # The covariance before the edge follows from the one after it, whatever noise the filter has let in before it.
    P12 = after.belief.covariance * S / R
    _believe(mean, P, AngleSpeed(mean[0], mean[1], S - R, P12, after.belief.speed_variance + P12 * P12 / S))
    _observe(mean, P, np.array([1.0, 0.0, 0.0, 0.0, 0.0]), innovation, R)
    # Once the index is found, all angles are counted from another edge than before.
    mean[2] += after.belief.angle - mean[0]
    _believe(mean, P, after.belief)
    doubts = Doubts(
        encoder_time=encoder.time,
        pressure_time=memory.doubts.pressure_time,
        agreed_time=after.time,
        refused=memory.doubts.refused,
        speed_run=0.0,
        duty_run=0.0,
    )
    return FusionMemory(filter=after, mean=mean, covariance=P, doubts=doubts), innovation, deviation


def _after_pressure_edge(memory: FusionMemory, reading: FusionReading, settings: Fusion) -> FusionMemory:
    before, doubts, event = memory.filter, memory.doubts, settings.filter
    h = reading.pressure_edge_time - before.time
    mean, P = memory.mean.copy(), memory.covariance.copy()
    _move(mean, P, h)
    # An edge is confirmed late and met where it happened. What noise came in since is not taken out for it: over these
    # few samples it is small, and could leave less than nothing.
    _drift(P, maximum(h, 0.0), before.manoeuvre.density, settings)
    if reading.duty_ratio == reading.duty_ratio:
        H = np.array([0.0, 0.0, 0.0, 1.0, 0.0])
        _observe(mean, P, H, reading.duty_ratio - mean[3], settings.duty_sensor_variance)

    s, N, lag = reading.pressure_polarity, settings.sections, mean[4]
    per_duty, pitch = s * np.pi / N, 2.0 * np.pi / N
    angle = mean[0] - mean[2] - mean[1] * lag + per_duty * (mean[3] + settings.duty_excess)
    innovation = pitch * np.floor(angle / pitch + 0.5) - angle
    H = np.array([1.0, -lag, -1.0, per_duty, -mean[1]])
    passed = maximum(mean[1], event.lowest_speed) * reading.pressure_edge_interval
    R = passed * passed / 12.0 + settings.pressure_variance
    S = _innovation_variance(P, H, R)
    silent = (reading.encoder.time - doubts.encoder_time) * maximum(mean[1], event.lowest_speed) > (
        SILENT_SECTORS * sector(event.wheel)
    )
    density, speed_run, duty_run = before.manoeuvre.density, 0.0, 0.0
    if silent:
        z = innovation / np.sqrt(S)
        speed_run, duty_run = run_on(doubts.speed_run, z), run_on(doubts.duty_run, s * z)
        density = maximum(density * (1.0 - 1.0 / event.manoeuvre_edges), event.acceleration_density)
        if abs(speed_run) >= settings.patience:
            density, speed_run = event.manoeuvre_density, 0.0
            since = maximum(reading.pressure_edge_time - doubts.agreed_time, 0.0)
            _believe(mean, P, inflate(_belief(mean, P), since, density))
        if abs(duty_run) >= settings.patience:
            P[3, 3] += settings.duty_ratio_variance
            duty_run = 0.0
        S = _innovation_variance(P, H, R)
    accepted = innovation * innovation < settings.gate * settings.gate * S
    refused = 0.0 if accepted else doubts.refused + 1.0
    if not silent and refused >= settings.patience:
        _begin_wave(mean, P, settings)
        refused = 0.0
    if accepted:
        _observe(mean, P, H, innovation, R)
    time = before.time
    if h < 0.0:
        _move(mean, P, -h)
    else:
        time = reading.pressure_edge_time
    after = _believing(before, time, _belief(mean, P), density)
    if silent and accepted:
        after = _counted_on(after, event)
    agreed_time = maximum(reading.pressure_edge_time, doubts.agreed_time) if accepted else doubts.agreed_time
    doubts = Doubts(
        encoder_time=doubts.encoder_time,
        pressure_time=maximum(reading.pressure_edge_time, doubts.pressure_time),
        agreed_time=agreed_time,
        refused=refused,
        speed_run=speed_run,
        duty_run=duty_run,
    )
    return FusionMemory(filter=after, mean=mean, covariance=P, doubts=doubts)


def run_on(run: float, innovation: float) -> float:
    """Number of innovations in a row beyond `FAR` standard deviations on one side, negative below [1], with one more.

    run         before
    innovation  over its deviation [1]
    """
    if innovation > FAR:
        return maximum(run, 0.0) + 1.0
    if innovation < -FAR:
        return minimum(run, 0.0) - 1.0
    return 0.0


def _innovation_variance(covariance: Array, observation: Array, variance: float) -> float:
    P, H, S = covariance, observation, variance
    for i in range(H.size):
        for j in range(H.size):
            S += H[i] * P[i, j] * H[j]
    return S


def _counted_on(memory: EventFilterMemory, settings: EventFilter) -> EventFilterMemory:
    """The memory when the pressure has given the angle of a lost encoder: wheel edges half a sector back have passed.

    The encoder's next edge is then no counterpart of one before the loss, nor could a manoeuvre have begun there.
    """
    m, wheel = memory, settings.wheel
    edge = maximum(edge_below(m.belief.angle - 0.5 * sector(wheel), wheel), m.last.number)
    ago = (m.belief.angle - edge_angle(edge, wheel)) / maximum(m.belief.speed, settings.lowest_speed)
    tally = m.tally._replace(
        ignored=0.0, missed_edges=m.tally.missed_edges + maximum(edge - m.last.number - m.tally.ignored, 0.0)
    )
    last = LastEdge(edge, maximum(m.time - ago, m.last.time))
    return m._replace(last=last, tally=tally)


def _belief(mean: Array, covariance: Array) -> AngleSpeed:
    return AngleSpeed(mean[0], mean[1], covariance[0, 0], covariance[0, 1], covariance[1, 1])


def _believing(memory: EventFilterMemory, time: float, belief: AngleSpeed, density: float) -> EventFilterMemory:
    m = memory
    manoeuvre = m.manoeuvre._replace(density=density)
    return m._replace(time=time, belief=belief, manoeuvre=manoeuvre)
