"""The coarse encoder: from the shaft's motion between two samples to the report of the acquisition.

The comparator works all the time and a counter counts its edges; only the counter is read at samples. When each edge
passes is found on the cubic through both ends of the interval. Derived in docs/models/encoder.md.

Source  ours, docs/models/encoder.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ParameterError
from vvdp.base.kinds import Angle, Count, Drift, Fraction, FractionSignal, Number, Speed, Time
from vvdp.base.params import Params
from vvdp.base.select import maximum, minimum
from vvdp.base.signal import signal_value
from vvdp.numerics.random import Random, normal, random_start, uniform
from vvdp.sensing.photodiode import LightSpot, photodiode_signal, ramp_width, swept_distance
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import CodeWheel, edge_angle, edge_below, edge_polarity, sector_widths

MOST_EDGES = 1000
"""Edges that one interval between samples can hold; a shaft faster than that is not followed."""

BISECTIONS = 48

FOR_GOOD = 1e6
"""The end of what does not end [s]."""


class Shaft(NamedTuple):
    """True motion of the shaft at a sample."""

    time: Time
    angle: Angle
    speed: Speed


class Acquisition(Params):
    """Time stamp of an edge: `SAMPLED`, `INTERPOLATED`, or by a unit made with `capture_unit`."""

    interpolated: Fraction
    captured: Fraction
    resolution: Time


SAMPLED = Acquisition(interpolated=0.0, captured=0.0, resolution=0.0)
"""Only the counter at the samples shows: the edge lies somewhere in the interval."""

INTERPOLATED = Acquisition(interpolated=1.0, captured=0.0, resolution=0.0)
"""The photodiode's wave is sampled, and a line through the samples on both sides of the threshold gives the time."""


def capture_unit(resolution: float) -> Acquisition:
    """A capture unit stamps every edge to within `resolution` [s]."""
    return Acquisition(interpolated=0.0, captured=1.0, resolution=resolution)


class Faults(Params):
    """Faults of an encoder; 0 switches each off.

    An edge is missed, from `missed_begin` to `missed_end`, or bounces and counts three times, with these
    probabilities. Nothing is reported from `dropout_begin` to `dropout_end`. An eccentric wheel shows
    theta + e sin(theta - direction). Dirt takes the share `dirt_depth` of the light over `dirt_width` from
    `dirt_angle` on. The encoder's clock gains `clock_drift` on the true one; a sample shows the shaft up to
    `clock_jitter` before the time it bears.
    """

    missed_edges: Fraction
    missed_begin: Time = 0.0
    missed_end: Time = FOR_GOOD
    double_edges: Fraction
    dropout_begin: Time
    dropout_end: Time
    eccentricity: Angle
    eccentric_direction: Angle
    dirt_angle: Angle
    dirt_width: Angle
    dirt_depth: Fraction
    clock_drift: Drift
    clock_jitter: Time


NO_FAULTS = Faults(
    missed_edges=0.0,
    double_edges=0.0,
    dropout_begin=0.0,
    dropout_end=0.0,
    eccentricity=0.0,
    eccentric_direction=0.0,
    dirt_angle=0.0,
    dirt_width=0.0,
    dirt_depth=0.0,
    clock_drift=0.0,
    clock_jitter=0.0,
)


class Encoder(Params):
    """Code wheel, light spot, comparator with `threshold` and `hysteresis` (shares of the light), counter, faults.

    `noise` is the standard deviation of the light at the comparator, drawn again for each edge.
    """

    wheel: CodeWheel
    spot: LightSpot
    threshold: FractionSignal
    hysteresis: Fraction
    noise: Fraction
    counter_bits: Count
    acquisition: Acquisition
    faults: Faults

    def check(self) -> None:
        narrow, w = min(sector_widths(self.wheel)), ramp_width(self.spot)
        if not w < narrow:
            raise ParameterError(
                f"spot.width: {1e3 * self.spot.width:g} mm covers {np.degrees(w):.4g} deg of the wheel; it must be "
                f"narrower than the narrowest sector, {np.degrees(narrow):.4g} deg"
            )
        if not 1.0 <= self.counter_bits <= 48.0 or self.counter_bits % 1.0:
            raise ParameterError(f"counter_bits = {self.counter_bits:g}; expected a whole number from 1 to 48")
        if not abs(self.faults.eccentricity) < 1.0:
            angle = np.degrees(self.faults.eccentricity)
            raise ParameterError(f"faults.eccentricity: {angle:.4g} deg must be less than 57.3 deg (1 rad)")


class EncoderMemory(NamedTuple):
    """The shaft at the last sample, the last edge passed, and the count.

    `disturbance` is the noise of the light [1] at the next edge ahead, `last_disturbance` at the one behind.
    """

    started: Fraction
    time: Time
    angle: Angle
    speed: Speed
    edge: Number
    disturbance: Number
    last_disturbance: Number
    counter: Number
    polarity: Number
    random: Random


def edge_deviation(encoder: Encoder) -> float:
    """Standard deviation of the angle at which an edge is seen, from the noise of the light [rad]: sigma w (strip)."""
    return encoder.noise * ramp_width(encoder.spot)


def counter_difference(count: float, before: float, bits: float) -> float:
    """Edges between two readings of a counter that starts again at 2^bits [1].

    Source  wang2017, eq. 3.2, with more than one edge and overflow
    """
    edges: float = (count - before) % 2.0**bits
    return edges


def sample_times(rate: float, phase: float, until: float, drift: float = 0.0) -> Array:
    """Times [s] of the samples of a clock of `rate` [Hz], from `phase` (a share of the period) to `until` [s].

    A clock that gains `drift` on the true time ticks that much faster.
    """
    period = 1.0 / (rate * (1.0 + drift))
    ticks: Array = np.arange(np.floor(until / period - phase + 1e-9) + 1.0)
    return (ticks + phase) * period


def apparent_angle(angle: float, faults: Faults) -> float:
    """Angle that an eccentric wheel shows, theta + e sin(theta - direction) [rad]."""
    shown: float = angle + faults.eccentricity * np.sin(angle - faults.eccentric_direction)
    return shown


def crossing_angle(number: float, direction: float, threshold: float, disturbance: float, encoder: Encoder) -> float:
    """Apparent angle at which the comparator switches for edge `number` [rad]; infinite where the light never suffices.

    The light reaches c + h/2 on the way up and c - h/2 on the way down; the share of the spot that must be bright is
    that over 1 - dirt. A rising edge then switches s = w x(share) beyond the edge, a falling one as much before it.

    direction    +1 forward, -1 backward
    threshold    c, share of the light [1]
    disturbance  added to the light [1]

    Source  ours, docs/models/encoder.md, after wang2017, figs. 3.5 and 7.1
    """
    s, faults = edge_polarity(number), encoder.faults
    angle = edge_angle(number, encoder.wheel)
    into = (angle - faults.dirt_angle) % (2.0 * np.pi)
    dimmed = faults.dirt_depth if into < faults.dirt_width else 0.0
    share = (threshold + 0.5 * direction * s * encoder.hysteresis - disturbance) / maximum(1.0 - dimmed, 1e-9)
    if share >= 1.0 or share <= 0.0:
        return direction * np.inf
    return angle + s * ramp_width(encoder.spot) * swept_distance(share, encoder.spot.roundness)


def crossing_time(goal: float, before: Shaft, after: Shaft) -> float:
    """When the cubic through both ends of an interval passes the angle `goal` [s], by bisection."""
    h = after.time - before.time
    low, high = 0.0, 1.0
    rising = after.angle >= before.angle
    for _ in range(BISECTIONS):
        s = 0.5 * (low + high)
        r = 1.0 - s
        a = before.angle * (1.0 + 2.0 * s) * r * r + after.angle * s * s * (3.0 - 2.0 * s)
        a += h * s * r * (before.speed * r - after.speed * s)
        if (a < goal) == rising:
            low = s
        else:
            high = s
    return before.time + 0.5 * (low + high) * h


def encoder_start(encoder: Encoder, time: float, angle: float, seed: float) -> EncoderMemory:
    """Memory before the first sample; equal seeds give equal noise and faults.

    time   [s]
    angle  true angle of the shaft [rad]
    """
    shown = apparent_angle(angle, encoder.faults)
    c = signal_value(time, encoder.threshold)
    edge = edge_below(shown, encoder.wheel)
    if shown < crossing_angle(edge, 1.0, c, 0.0, encoder):
        edge -= 1.0
    elif shown >= crossing_angle(edge + 1.0, 1.0, c, 0.0, encoder):
        edge += 1.0
    random, z = normal(random_start(seed))
    return EncoderMemory(
        started=0.0,
        time=time,
        angle=shown,
        speed=0.0,
        edge=edge,
        disturbance=encoder.noise * z,
        last_disturbance=0.0,
        counter=0.0,
        polarity=edge_polarity(edge),
        random=random,
    )


def encoder_step(memory: EncoderMemory, shaft: Shaft, encoder: Encoder) -> tuple[EncoderMemory, Reading]:
    """Memory and reading after a sample, with the encoder's own threshold.

    Source  wang2017, sections 3.2 and 3.3
    """
    return encoder_reading(memory, shaft, signal_value(shaft.time, encoder.threshold), encoder)


def encoder_reading(
    memory: EncoderMemory, shaft: Shaft, threshold: float, encoder: Encoder
) -> tuple[EncoderMemory, Reading]:
    """Memory and reading after a sample at which the comparator works with `threshold` [share of the light].

    Source  wang2017, sections 3.2 and 3.3
    """
    faults, random = encoder.faults, memory.random
    slope = 1.0 + faults.eccentricity * np.cos(shaft.angle - faults.eccentric_direction)
    true_angle, speed = apparent_angle(shaft.angle, faults), shaft.speed * slope
    angle = true_angle
    if faults.clock_jitter > 0.0:
        random, u = uniform(random)
        angle = angle - u * faults.clock_jitter * speed
    before = Shaft(memory.time, memory.angle, memory.speed if memory.started > 0.0 else speed)
    now = Shaft(shaft.time, angle, speed)
    edge, disturbance, last, counter = memory.edge, memory.disturbance, memory.last_disturbance, memory.counter
    polarity, edge_time, passed, crossed = memory.polarity, shaft.time, 0.0, 0.0
    forward, half = angle >= memory.angle, 0.5 * ramp_width(encoder.spot)
    for _ in range(MOST_EDGES):
        if forward:
            if angle < edge_angle(edge + 1.0, encoder.wheel) - half:
                break
            goal = crossing_angle(edge + 1.0, 1.0, threshold, disturbance, encoder)
            if goal == np.inf and angle >= edge_angle(edge + 2.0, encoder.wheel):
                edge += 2.0  # a sector too dark, or too bright, to be seen
                random, z = normal(random)
                disturbance = encoder.noise * z
                continue
            if angle < goal:
                break
            edge, sign, last = edge + 1.0, edge_polarity(edge + 1.0), disturbance
        else:
            if angle > edge_angle(edge, encoder.wheel) + half:
                break
            goal = crossing_angle(edge, -1.0, threshold, last, encoder)
            if goal == -np.inf and angle < edge_angle(edge - 1.0, encoder.wheel):
                edge -= 2.0
                random, z = normal(random)
                last = encoder.noise * z
                continue
            if angle >= goal:
                break
            edge, sign, disturbance = edge - 1.0, -edge_polarity(edge), last
        if encoder.noise > 0.0:
            random, z = normal(random)
            if forward:
                disturbance = encoder.noise * z
            else:
                last = encoder.noise * z
        lost = 0.0
        if faults.missed_edges > 0.0 and shaft.time >= faults.missed_begin and shaft.time < faults.missed_end:
            random, u = uniform(random)
            lost = 1.0 if u < faults.missed_edges else 0.0
        if shaft.time >= faults.dropout_begin and shaft.time < faults.dropout_end:
            lost = 1.0
        if lost == 0.0:
            bounces = 0.0
            if faults.double_edges > 0.0:
                random, u = uniform(random)
                bounces = 2.0 if u < faults.double_edges else 0.0
            counter += 1.0 + bounces
            passed += 1.0
            polarity = sign
            crossed = edge if forward else edge + 1.0
            edge_time = crossing_time(goal, before, now)
    counter = counter % 2.0**encoder.counter_bits
    edges = counter_difference(counter, memory.counter, encoder.counter_bits)
    interval = shaft.time - memory.time
    told, spread = shaft.time - 0.5 * interval, interval
    if encoder.acquisition.captured > 0.0 and passed > 0.0:
        resolution = encoder.acquisition.resolution
        told, spread = edge_time, resolution
        if resolution > 0.0:
            told = (np.floor(edge_time / resolution) + 0.5) * resolution
    elif encoder.acquisition.interpolated > 0.0 and passed == 1.0:
        told, spread = _interpolate(memory, now, crossed, threshold, encoder)
    clock = 1.0 + faults.clock_drift
    reading = Reading(clock * shaft.time, edges, clock * told, clock * spread, polarity)
    after = EncoderMemory(
        started=1.0,
        time=shaft.time,
        angle=angle,
        speed=speed,
        edge=edge,
        disturbance=disturbance,
        last_disturbance=last,
        counter=counter,
        polarity=polarity,
        random=random,
    )
    return after, reading


def _interpolate(
    memory: EncoderMemory, now: Shaft, crossed: float, threshold: float, encoder: Encoder
) -> tuple[float, float]:
    """Time at which edge `crossed` passed, by a line through both samples of the wave, and the width of its remaining
    uncertainty.

    Where a sample lies off its ramp, that began or ended somewhere within the interval: nothing is gained then. On
    the ramp nothing is left unknown: the noise of the light moves the edge as a whole, as a wrong threshold does.
    """
    interval = now.time - memory.time
    middle = now.time - 0.5 * interval
    half, middle_angle = 0.5 * ramp_width(encoder.spot), edge_angle(crossed, encoder.wheel)
    if maximum(abs(memory.angle - middle_angle), abs(now.angle - middle_angle)) >= half:
        return middle, interval
    before = photodiode_signal(memory.angle, encoder.wheel, encoder.spot)
    after = photodiode_signal(now.angle, encoder.wheel, encoder.spot)
    level = threshold - memory.disturbance
    if level <= minimum(before, after) or level >= maximum(before, after):
        return middle, interval
    return memory.time + (level - before) / (after - before) * interval, 0.0
