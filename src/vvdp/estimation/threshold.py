"""A comparator threshold that is off shifts rising edges one way and falling edges the other: two ways to find by how
much from the innovations of the event filter.

`threshold_step` corrects the threshold edge by edge while the encoder runs; `edge_offset_step` carries the offset as a
third state and leaves the threshold alone, so that it works on a log. Derived in docs/models/threshold-adaptation.md.

Source  ours, docs/models/threshold-adaptation.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import NUMBER, AngularVariance, Count, Fraction, Kind, Ratio
from vvdp.base.params import Params
from vvdp.base.rules import refuse, require_less, require_positive
from vvdp.base.select import clip, maximum, minimum
from vvdp.estimation.association import sector
from vvdp.estimation.estimator import Estimate, Estimator
from vvdp.estimation.event_filter import event_filter_step
from vvdp.estimation.event_memory import EventFilterMemory, event_filter_start
from vvdp.estimation.event_settings import EventFilter
from vvdp.estimation.expected_edge import edge_angle_variance
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import edge_angle, edge_polarity

SIGNAL_LEVEL = Kind("signal level", "1", -1e6, 1e6, "0.5")
RAMP_SLOPE = Kind("angle of a light ramp over its signal swing", "rad", 0.0, 1e3, "0.49 rad")
ANGLE_DRIFT = Kind("spectral density of the rate of an angle", "rad^2/s", 0.0, 1e6, "1e-5 rad^2/s")

SignalLevel = Annotated[float, SIGNAL_LEVEL]
RampSlope = Annotated[float, RAMP_SLOPE]
AngleDrift = Annotated[float, ANGLE_DRIFT]

PHASES = 32
"""Edges over which the spread of their places between samples is watched: four turns of eight sectors."""
GOLDEN = 0.6180339887498949
"""Multiples of it, less their whole part, fill the interval from 0 to 1 as evenly as a sequence can."""


class ThresholdAdaptation(Params):
    """Settings of the adaptation with feedback.

    `threshold_adaptation` has the usual ones. `gain` is gamma; `ramp_slope` w, the angle over which the light changes
    divided by the swing of the signal. The threshold stays between `lowest` and `highest`. `dither` is the full width
    of a known up and down of the threshold from edge to edge; 0 is none, `dither_width` is the one for a sampled clock.
    """

    filter: EventFilter
    gain: Ratio
    ramp_slope: RampSlope
    lowest: SignalLevel
    highest: SignalLevel
    dither: Ratio

    def check(self) -> None:
        if not self.gain < 2.0:
            refuse(self, "gain", "must be less than 2, or the adaptation is unstable")
        require_positive(self, "ramp_slope", why="at 0 the threshold has no influence")
        require_less(self, "lowest", "highest")


def threshold_adaptation(
    settings: EventFilter, ramp_slope: float, sampling_period: float, highest_speed: float
) -> ThresholdAdaptation:
    """The usual settings for a signal with a swing of 1, with the dither that edges known to the sample alone need.

    ramp_slope       w [rad per unit of the signal]
    sampling_period  dT [s]; 0 where edges are time-stamped or interpolated, which need no dither
    highest_speed    at which the threshold shall be found [rad/s]
    """
    dither = dither_width(highest_speed, sampling_period, ramp_slope)
    return ThresholdAdaptation(
        filter=settings, gain=0.02, ramp_slope=ramp_slope, lowest=0.1, highest=0.9, dither=dither
    )


class ThresholdMemory(NamedTuple):
    """The event filter, the threshold as adapted and as the comparator has it, the edges used, whether the comparator
    still has to get a new one, where the last edges lay between samples, and the blind band that follows."""

    filter: EventFilterMemory
    threshold: SignalLevel
    comparator_threshold: SignalLevel
    edges: Count
    due: Fraction
    phases: Annotated[Array, NUMBER]
    blind_band: SignalLevel


class AdaptedThreshold(NamedTuple):
    """Estimate at a sample, the threshold as adapted, the threshold to give to the comparator from the next sample on
    (with dither), and the range within which thresholds cannot be distinguished [unit of the signal]."""

    estimate: Estimate
    threshold: float
    comparator_threshold: float
    blind_band: float


def adapted_threshold(threshold: float, innovation: float, polarity: float, gain: float, ramp_slope: float) -> float:
    """The threshold after one edge [unit of the signal]: c + gamma s nu / w.

    innovation  nu, angle of the edge less the expected angle [rad]
    polarity    s, +1 rising, -1 falling
    gain        gamma [1]
    ramp_slope  w [rad per unit of the signal]

    Source  wang2017, section 7.3, for the idea; the law is ours, docs/models/threshold-adaptation.md
    """
    return threshold + gain * polarity * innovation / ramp_slope


def effective_gain(gain: float, angle_gain: float, speed_gain: float) -> float:
    """Share of an offset that one edge takes away with the filter in the loop [1]: gamma / (1 - k1/2 - k2 T/4).

    The filter takes part of an alternating offset for motion of alternating sign, which enlarges it in the innovations.

    angle_gain  k1, the filter's [1]
    speed_gain  k2 T, the filter's, times the time between edges [1]
    """
    return gain / (1.0 - 0.5 * angle_gain - 0.25 * speed_gain)


def greatest_gain(angle_gain: float, speed_gain: float) -> float:
    """The gain at which adaptation and filter together become unstable [1]: 4 k1/(2 k1 + k2 T) - k1, below 2.

    angle_gain  k1, the filter's [1]
    speed_gain  k2 T, the filter's, times the time between edges [1]
    """
    return 4.0 * angle_gain / (2.0 * angle_gain + speed_gain) - angle_gain


def residual_deviation(gain: float, noise_variance: float) -> float:
    """Standard deviation that the noise of single edges leaves in the offset [rad]: sqrt(gamma R/(2 - gamma)).

    gain            gamma, the effective one [1]
    noise_variance  R, of an edge, the true one and not that of the filter [rad^2]
    """
    deviation: float = np.sqrt(gain * noise_variance / (2.0 - gain))
    return deviation


def dither_width(speed: float, sampling_period: float, ramp_slope: float) -> float:
    """Full width of the dither that hides no offset from a sampled clock [unit of the signal]: omega dT / w.

    Over one whole sampling period of edge times, the mean of the rounded times follows the true time exactly.

    speed            highest speed at which adaptation shall work [rad/s]
    sampling_period  dT [s]
    ramp_slope       w [rad per unit of the signal]

    Source  widrow1961, quantisation with a uniform input; docs/models/threshold-adaptation.md
    """
    return speed * sampling_period / ramp_slope


def largest_gap(phases: Array) -> float:
    """The longest arc of a circle of circumference 1 on which none of the `phases`, shape (n,), lies [1].

    1/n where they are spread evenly, 1 where they coincide.
    """
    n = phases.size
    lowest, highest = np.full(n, 2.0), np.full(n, -1.0)
    for phase in phases:
        placed = phase - np.floor(phase)
        arc = min(int(placed * n), n - 1)
        lowest[arc], highest[arc] = minimum(lowest[arc], placed), maximum(highest[arc], placed)
    # A gap of 1/n or more never lies within one of n arcs: from the last phase of one to the first of the next.
    gap, last = 0.0, highest.max() - 1.0
    for arc in range(n):
        if highest[arc] >= 0.0:
            gap, last = maximum(gap, lowest[arc] - last), highest[arc]
    return gap


def threshold_start(
    settings: ThresholdAdaptation, threshold: float, time: float, angle: float, speed: float
) -> ThresholdMemory:
    """Memory before the first sample.

    threshold  of the comparator [unit of the signal]
    time       [s]
    angle      where the wheel stands, as far as is known [rad]
    speed      expected [rad/s]
    """
    start = event_filter_start(settings.filter, time, angle, speed)
    return ThresholdMemory(
        filter=start,
        threshold=threshold,
        comparator_threshold=threshold,
        edges=0.0,
        due=0.0,
        phases=np.zeros(PHASES),
        blind_band=np.nan,
    )


def threshold_step(
    memory: ThresholdMemory, reading: Reading, settings: ThresholdAdaptation
) -> tuple[ThresholdMemory, AdaptedThreshold]:
    """Memory, estimate and threshold after a sample.

    Adapts at edges that the filter has used, once it is associated and while it detects no manoeuvre. The comparator
    gets a new threshold half a sector later, where the signal is far from it: a threshold that jumps on the ramp would
    make an edge of its own. The known dither is taken out of the edge's time before the filter sees it.
    """
    before, event, w = memory.filter, settings.filter, settings.ramp_slope
    shift = 0.0
    if before.tally.associating > 0.0:
        offset = memory.comparator_threshold - memory.threshold
        shift = reading.polarity * offset * w / maximum(before.belief.speed, event.lowest_speed)
    seen = Reading(reading.time, reading.edges, reading.edge_time - shift, reading.edge_interval, reading.polarity)
    after, estimate = event_filter_step(before, seen, event)

    threshold, comparator, edges, due = memory.threshold, memory.comparator_threshold, memory.edges, memory.due
    phases, blind = memory.phases, memory.blind_band
    used = before.tally.associating > 0.0 and estimate.innovation_deviation > 0.0
    if used:
        s = edge_polarity(after.last.number)
        if after.manoeuvre.density <= event.acceleration_density:  # not in a manoeuvre
            adapted = adapted_threshold(threshold, estimate.innovation, s, settings.gain, w)
            threshold = clip(adapted, settings.lowest, settings.highest)
        speed = maximum(estimate.speed, event.lowest_speed)
        expected = reading.time - (estimate.angle - edge_angle(after.last.number, event.wheel)) / speed + shift
        phases = _remember(phases, s * _place(expected, reading))
        blind = largest_gap(phases) * speed * reading.edge_interval / w
        edges, due = edges + 1.0, 1.0
    on_plateau = estimate.angle - edge_angle(after.last.number, event.wheel) > 0.5 * sector(event.wheel)
    if (due > 0.0 and on_plateau) or (memory.due > 0.0 and used):
        comparator = threshold + settings.dither * ((GOLDEN * edges) % 1.0 - 0.5)
        due = 0.0
    shown = AdaptedThreshold(estimate, threshold, comparator, blind)
    return ThresholdMemory(
        filter=after,
        threshold=threshold,
        comparator_threshold=comparator,
        edges=edges,
        due=due,
        phases=phases,
        blind_band=blind,
    ), shown


def _place(expected: float, reading: Reading) -> float:
    """Place of the expected edge in the interval of the reading's edge [1]."""
    begin = reading.edge_time - 0.5 * reading.edge_interval
    return (expected - begin) / reading.edge_interval if reading.edge_interval > 0.0 else 0.0


def _remember(phases: Array, phase: float) -> Array:
    kept = np.empty(phases.size)
    kept[1:] = phases[:-1]
    kept[0] = phase
    return kept


class EdgeOffset(Params):
    """Settings of the filter with the offset as third state: variance at the start, and how fast it may drift.

    `threshold` is the one that the comparator had, `ramp_slope` as in `ThresholdAdaptation`.
    """

    filter: EventFilter
    offset_variance: AngularVariance
    offset_drift: AngleDrift
    threshold: SignalLevel
    ramp_slope: RampSlope

    def check(self) -> None:
        require_positive(self, "ramp_slope", why="at 0 no threshold follows from an offset")


class EdgeOffsetMemory(NamedTuple):
    """The event filter as if there were no offset, the offset and its variance, and by how much the angle and the speed
    of that filter fall short per unit of offset, at its last edge."""

    filter: EventFilterMemory
    offset: float
    offset_variance: float
    angle_share: float
    speed_share: float


class OffsetEstimate(NamedTuple):
    """Estimate at a sample with the offset taken out, the offset by which rising edges are late and falling edges
    early, its standard deviation, and the threshold at which it would vanish [unit of the signal]."""

    estimate: Estimate
    offset: float
    offset_deviation: float
    threshold: float


def edge_offset_start(settings: EdgeOffset, time: float, angle: float, speed: float) -> EdgeOffsetMemory:
    """Memory before the first sample.

    time   [s]
    angle  where the wheel stands, as far as is known [rad]
    speed  expected [rad/s]
    """
    start = event_filter_start(settings.filter, time, angle, speed)
    return EdgeOffsetMemory(start, 0.0, settings.offset_variance, 0.0, 0.0)


def edge_offset_step(
    memory: EdgeOffsetMemory, reading: Reading, settings: EdgeOffset
) -> tuple[EdgeOffsetMemory, OffsetEstimate]:
    """Memory and estimate after a sample, with the offset delta as third state, H = [1, 0, -s].

    In two stages: the event filter runs as if delta were 0, and delta is estimated from its innovations, which it
    enters with the factor u1 - s, where u is the part of it already in the filter's state. For a constant delta this is
    the filter with three states exactly; association and manoeuvres stay the event filter's.

    Source  friedland1969; docs/models/threshold-adaptation.md
    """
    before, event = memory.filter, settings.filter
    after, estimate = event_filter_step(before, reading, event)
    b, M, v1, v2 = memory.offset, memory.offset_variance, memory.angle_share, memory.speed_share
    innovation, deviation = estimate.innovation, estimate.innovation_deviation
    if deviation > 0.0:
        h = after.time - before.time
        M += settings.offset_drift * h if before.tally.started > 0.0 else 0.0
        R = edge_angle_variance(before.belief.speed, reading.edge_interval, event)
        u1 = v1 + h * v2
        share = u1 - edge_polarity(after.last.number)
        S = deviation * deviation
        total = S + share * share * M
        gain = share * M / total
        innovation -= share * b
        b += gain * innovation
        M *= S / total
        v1 = u1 - after.belief.angle_variance / R * share
        v2 -= after.belief.covariance / R * share
        deviation = np.sqrt(total)
    angle_share = v1 + (reading.time - after.time) * v2
    shown = OffsetEstimate(
        Estimate(
            angle=estimate.angle + angle_share * b,
            speed=estimate.speed + v2 * b,
            angle_deviation=np.sqrt(estimate.angle_deviation**2.0 + angle_share * angle_share * M),
            speed_deviation=np.sqrt(estimate.speed_deviation**2.0 + v2 * v2 * M),
            innovation=innovation,
            innovation_deviation=deviation,
            missed_edges=estimate.missed_edges,
            standstill=estimate.standstill,
        ),
        b,
        np.sqrt(M),
        settings.threshold - b / settings.ramp_slope,
    )
    return EdgeOffsetMemory(after, b, M, v1, v2), shown


def edge_offset_estimate(
    memory: EdgeOffsetMemory, reading: Reading, settings: EdgeOffset
) -> tuple[EdgeOffsetMemory, Estimate]:
    """As `edge_offset_step`, showing angle and speed alone."""
    memory, shown = edge_offset_step(memory, reading, settings)
    return memory, shown.estimate


def edge_offset_estimator(settings: EdgeOffset, time: float = 0.0, angle: float = 0.0, speed: float = 0.0) -> Estimator:
    """The event filter with an offset of the edges, ready to run; `angle` [rad] and `speed` [rad/s] as far as known."""
    memory = edge_offset_start(settings, time, angle, speed)
    return Estimator("event-based Kalman filter with edge offset", edge_offset_estimate, memory, settings)
