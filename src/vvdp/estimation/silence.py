"""Information in the absence of edges: the belief between two edges, and whether the wheel stands still.

The wheel turns forward only, so that the silence up to now carries the same information as the angle now: it lies
before the next edge, unless edges were missed. Derived in docs/models/event-filter.md, "Silence".

Source  ours, docs/models/event-filter.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import Angle, AngularVariance, Count, Fraction, Frequency, Number, Speed, SpeedVariance, Time
from vvdp.base.select import maximum, minimum
from vvdp.estimation.association import missed_in_a_row
from vvdp.numerics.kalman import AngleSpeed
from vvdp.numerics.normal import normal_share, truncate

SURE = 0.9
"""Probability from which a wheel is taken to have halted [1]; assumed."""

LATE = 2.0
"""Deviations after which an edge that was due is late, and its absence counts [1]; assumed."""

LEAST = 1e-12
"""Share of a belief below which a hypothesis is left out [1]."""

DROPOUTS = 0.01
"""Losses of the sensor, for however long, for each stop of the wheel [1]; assumed."""

REGULAR = 0.02
"""Share of missed or ignored edges up to which a late edge hides no other [1]: a single one of late makes 1/64 of it,
two make 2/64 (`REMEMBERED`), and any value between has the same effect; derived."""

FAINTEST = 1e-30
"""Least weight of which a logarithm is taken [1]: single precision has smaller ones with fewer digits only."""

UNLIKELY = 0.05
"""Probability below which the wheel is not taken to have turned back [1]; assumed."""

STARTS = 30.0
"""Rate at which edges come of a wheel that turned back [1/s]; assumed."""

STARTED = 0.02
"""Time from rest to the first edge [s], in which a start is not seen; assumed, about that of a spool of 28 ms."""


class Silence(NamedTuple):
    """A time without an edge: its `duration` since the last one, where that lay and where the next one lies.

    `edge_variance` is the part of an edge's noise that is an angle; `irregular`, the share of edges that were missed or
    ignored of late, rests on `watched` ones. Stops, slow passages, and manoeuvres not yet known of begin at
    `stop_rate`; a wheel that starts again does so with `start_variance`. `reversal` is the chance that a manoeuvre from
    the speed at the last edge ends below 0 by now, as that of a wheel that turned back has to.
    """

    duration: Time
    last_edge: Angle
    next_edge: Angle
    edge_variance: AngularVariance
    irregular: Fraction
    watched: Count
    stop_rate: Frequency
    start_variance: SpeedVariance
    reversal: Fraction = 1.0


class Heard(NamedTuple):
    """Belief during a silence: mean and variances of angle and speed, the probability that the wheel stands, that it
    stands or turns slowly, and that it slowed down until it would turn back; and the logarithm of the odds of missed
    edges against a wheel that stands or turns slowly."""

    angle: Angle
    speed: Speed
    angle_variance: AngularVariance
    speed_variance: SpeedVariance
    standstill: Fraction
    halt: Fraction
    backward: Fraction
    missing_odds: Number


class Mixture(NamedTuple):
    """Sums over hypotheses: their weights, and these times the first and second moments about a reference."""

    weight: float
    angle: float
    speed: float
    angle_square: float
    speed_square: float


NOTHING = Mixture(0.0, 0.0, 0.0, 0.0, 0.0)


def is_late(belief: AngleSpeed, silence: Silence) -> bool:
    """Whether the next edge should clearly have come by now, or the angle is not known to half a sector any more."""
    over, half = belief.angle - silence.next_edge, 0.5 * (silence.next_edge - silence.last_edge)
    S = belief.angle_variance + silence.edge_variance
    return half * half < S or (over > 0.0 and (over > half or over * over > LATE * LATE * S))


def add(sums: Mixture, weight: float, belief: AngleSpeed, about: AngleSpeed) -> Mixture:
    """The sums with one more hypothesis of a `weight` [1], moments taken about the means of `about`."""
    w, a, v = weight, belief.angle - about.angle, belief.speed - about.speed
    return Mixture(
        sums.weight + w,
        sums.angle + w * a,
        sums.speed + w * v,
        sums.angle_square + w * (belief.angle_variance + a * a),
        sums.speed_square + w * (belief.speed_variance + v * v),
    )


def add_within(sums: Mixture, weight: float, belief: AngleSpeed, silence: Silence, about: AngleSpeed) -> Mixture:
    """The sums with one more hypothesis of a `weight` [1] that is true only between the last edge and the next."""
    deviation = np.sqrt(belief.angle_variance + silence.edge_variance)
    low, high = (silence.last_edge - belief.angle) / deviation, (silence.next_edge - belief.angle) / deviation
    inside = normal_share(high) - normal_share(low)
    if inside > LEAST:
        sums = add(sums, weight * inside, truncate(belief, low, high, deviation), about)
    return sums


def reversed_share(belief: AngleSpeed) -> float:
    """Share of a belief in which the speed is below 0 [1]: a wheel that turns forward only stands there."""
    return normal_share(-belief.speed / np.sqrt(belief.speed_variance))


def after_silence(cruise: AngleSpeed, manoeuvre: AngleSpeed, silence: Silence) -> Heard:
    """The belief once a silence is taken in: the mean of one of two groups, and the scatter of both about it.

    The wheel goes on: its next edge is still to come, weight Phi(high) - Phi(low), was missed with k - 1 more,
    p_k (1 - Phi(high)), or a manoeuvre began at the last edge. Or it halts: it stopped since, or turns on slowly, at
    any speed up to that which the silence allows.

    cruise     belief at this time had nothing happened since the last edge
    manoeuvre  the same had a manoeuvre begun there
    """
    s = silence
    width, ahead = s.next_edge - s.last_edge, s.next_edge - cruise.angle
    usual = maximum(cruise.speed, 0.0) + 2.0 * np.sqrt(cruise.speed_variance)
    fastest = minimum(width / s.duration, usual)
    due = minimum(1.0, fastest / maximum(cruise.speed, 1e-9))  # share of the silence in which an edge was not yet due
    changed = s.stop_rate * s.duration
    backward = reversed_share(cruise) + changed * reversed_share(manoeuvre)
    stopped = changed * due + backward

    deviation = np.sqrt(cruise.angle_variance + s.edge_variance)
    beyond = normal_share(-ahead / deviation)
    passed = maximum(1.0, np.ceil(-ahead / width))
    missing = maximum(missed_in_a_row(s.irregular, s.watched, passed), DROPOUTS * stopped) * beyond
    sums = add_within(NOTHING, 1.0, cruise, s, cruise)
    sums = add_within(sums, changed, manoeuvre, s, cruise)
    if beyond > LEAST:
        sums = add(sums, missing, truncate(cruise, ahead / deviation, np.inf, deviation), cruise)

    middle, spread = 0.5 * (s.last_edge + s.next_edge), width * width / 12.0
    still = AngleSpeed(middle, 0.0, spread, 0.0, minimum(s.stop_rate * STARTED, 1.0) * s.start_variance)
    slow = AngleSpeed(middle, 0.5 * fastest, spread, 0.0, fastest * fastest / 12.0)
    halted = add(add(NOTHING, stopped, still, cruise), stopped * due, slow, cruise)
    whole = sums.weight + halted.weight
    shown = sums if halted.weight < SURE * whole else halted
    angle, speed = shown.angle / shown.weight, maximum(shown.speed / shown.weight, -cruise.speed)
    return Heard(
        angle=cruise.angle + angle,
        speed=cruise.speed + speed,
        angle_variance=(
            (sums.angle_square + halted.angle_square - 2.0 * angle * (sums.angle + halted.angle)) / whole
            + angle * angle
        ),
        speed_variance=(
            (sums.speed_square + halted.speed_square - 2.0 * speed * (sums.speed + halted.speed)) / whole
            + speed * speed
        ),
        standstill=stopped / whole,
        halt=halted.weight / whole,
        backward=backward / whole,
        missing_odds=np.log(maximum(missing, FAINTEST) / maximum(halted.weight, FAINTEST)),
    )


def start_speed(silence: Silence, standstill: float) -> tuple[float, float]:
    """Mean [rad/s] and variance of the speed at the first edge after a silence.

    A wheel that stood starts with the deviation of `start_variance`, and forward. One that crept came from edge to edge
    in the duration: evenly accelerated, it has from none to twice the mean speed of that.

    standstill  probability that the wheel stood [1]
    """
    usual, v = (silence.next_edge - silence.last_edge) / silence.duration, silence.start_variance
    mean = standstill * np.sqrt(v) + (1.0 - standstill) * usual
    square = standstill * 2.0 * v + (1.0 - standstill) * 4.0 / 3.0 * usual * usual
    return mean, square - mean * mean


def turned_back(stood: float, arrival: float, silence: Silence) -> float:
    """Variance of the angle turned through that a wheel leaves which may have turned back meanwhile [rad^2]: w^2/3.

    Forward, a sector w passes; back, up to two of them or none. Where that is unlikely, once the edge has come, or no
    deceleration that a manoeuvre has can have done it in the time, nothing is calculated with. If edges are missed, a
    late edge may also hide some, and the same variance covers their effect.

    stood    probability that the wheel stood, or slowed down until it would turn back, just before the edge [1]
    arrival  density in time with which the edge was expected of a wheel that goes on [1/s]
    """
    if silence.reversal < LEAST and silence.irregular < REGULAR:
        return 0.0
    width = silence.next_edge - silence.last_edge
    turned = stood * STARTS / (stood * STARTS + (1.0 - stood) * arrival)
    return width * width / 3.0 if turned > UNLIKELY else 0.0
