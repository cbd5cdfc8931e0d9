"""Belief of the event-based Kalman filter at any time up to which no edge has come since the last one.

Source  ours, docs/models/event-filter.md, where a function names no other.
"""

import numpy as np

from vvdp.base.select import maximum
from vvdp.estimation.association import sector
from vvdp.estimation.event_memory import EventFilterMemory
from vvdp.estimation.event_settings import EventFilter
from vvdp.estimation.ripple import Ripple, of_the_instant, predict_ripple, without_covariance
from vvdp.estimation.silence import Heard, Silence, after_silence, is_late, reversed_share
from vvdp.numerics.kalman import AngleSpeed, predict
from vvdp.sensing.wheel import edge_angle

SLACK = 1.0
"""Normalised innovation that counts as none when innovations of one sign are summed up [1]."""

HARDLY = 2.0
"""Logarithm of a likelihood ratio below which a manoeuvre is not suspected [1]."""

SHORTEST = 1e-9
"""Least time without an edge [s]: an edge may be seen twice in an instant, and a speed follows from this time."""

SUSPECTED = 6.0
"""Sectors for which a manoeuvre has gone on when it is suspected [1]; assumed."""


def believed_at(memory: EventFilterMemory, time: float, settings: EventFilter) -> Heard:
    """Belief at a `time` [s] up to which no edge has come since the last one."""
    h, density = time - memory.time, memory.manoeuvre.density
    _, _, instant = bring_forward(memory, h, settings)
    heard = heard_plainly(instant)
    if settings.stop_rate > 0.0 and memory.tally.started > 0.0:
        silence = silence_until(memory, time, memory.tally.ignored + 1.0, settings)
        if is_late(instant, silence):
            wide = inflate(instant, silence.duration, settings.manoeuvre_density)
            heard = after_silence(instant, wide, silence)
    if memory.doubt.odds > -np.inf:
        other = predict(memory.doubt.belief, h, density)
        if settings.ripple_order > 0.0:
            other = of_the_instant(other, without_covariance(memory.ripple), settings.ripple_order)
        heard = doubtful(heard, other, memory.doubt.odds)
    period = sector(settings.wheel) / maximum(instant.speed, settings.lowest_speed)
    density, lasting = suspected_density(memory, period, settings), h + SUSPECTED * period
    return blur(heard, memory.slip + density * lasting * lasting * lasting / 3.0, density * lasting)


def bring_forward(
    memory: EventFilterMemory, duration: float, settings: EventFilter
) -> tuple[AngleSpeed, Ripple, AngleSpeed]:
    """The beliefs of the mean course and of the ripple `duration` [s] after the last one, and that of the instant."""
    course = predict(memory.belief, duration, memory.manoeuvre.density)
    if settings.ripple_order == 0.0:
        return course, memory.ripple, course
    ripple = predict_ripple(memory.ripple, duration, settings.ripple_drift)
    return course, ripple, of_the_instant(course, ripple, settings.ripple_order)


def heard_plainly(belief: AngleSpeed) -> Heard:
    """The belief if a silence carries no information."""
    b = belief
    return Heard(
        angle=b.angle,
        speed=b.speed,
        angle_variance=b.angle_variance,
        speed_variance=b.speed_variance,
        standstill=0.0,
        halt=0.0,
        backward=0.0,
        missing_odds=0.0,
    )


def suspected_density(memory: EventFilterMemory, period: float, settings: EventFilter) -> float:
    """Density of the acceleration that a manoeuvre not yet declared may have [rad^2/s^3].

    The sums of innovations are the logarithm of its likelihood ratio, halved; the odds before are those of a change
    within a sector, which takes the time `period` [s].
    """
    ratio = 2.0 * SLACK * maximum(memory.manoeuvre.rise, memory.manoeuvre.fall)
    if ratio < HARDLY or settings.stop_rate == 0.0:
        return 0.0
    density: float = settings.manoeuvre_density / (1.0 + np.exp(-ratio) / (settings.stop_rate * period))
    return density


def silence_until(memory: EventFilterMemory, time: float, edges: float, settings: EventFilter) -> Silence:
    """The silence between the last edge and `time` [s], in which fewer than `edges` came; those may be bounce."""
    last, wheel = memory.last, settings.wheel
    duration = maximum(time - last.time, SHORTEST)
    return Silence(
        duration=duration,
        last_edge=edge_angle(last.number, wheel),
        next_edge=edge_angle(last.number + edges, wheel),
        edge_variance=settings.edge_variance,
        irregular=memory.tally.irregular,
        watched=memory.tally.watched,
        stop_rate=settings.stop_rate,
        start_variance=settings.speed_variance,
        reversal=reversed_share(inflate(memory.belief, duration, settings.manoeuvre_density)),
    )


def doubtful(heard: Heard, other: AngleSpeed, odds: float) -> Heard:
    """Combination with another belief that has `odds` (their logarithm): mean and variances of both together."""
    w = 1.0 / (1.0 + np.exp(-odds))
    angle, speed = other.angle - heard.angle, other.speed - heard.speed
    return Heard(
        angle=heard.angle + w * angle,
        speed=heard.speed + w * speed,
        angle_variance=(1.0 - w) * heard.angle_variance + w * other.angle_variance + w * (1.0 - w) * angle * angle,
        speed_variance=(1.0 - w) * heard.speed_variance + w * other.speed_variance + w * (1.0 - w) * speed * speed,
        standstill=(1.0 - w) * heard.standstill,
        halt=(1.0 - w) * heard.halt,
        backward=(1.0 - w) * heard.backward,
        missing_odds=heard.missing_odds,
    )


def blur(heard: Heard, angle_variance: float, speed_variance: float) -> Heard:
    """The belief with these variances of angle and speed added [rad^2, rad^2/s^2]."""
    return heard._replace(
        angle_variance=heard.angle_variance + angle_variance, speed_variance=heard.speed_variance + speed_variance
    )


def inflate(belief: AngleSpeed, duration: float, acceleration_density: float) -> AngleSpeed:
    """The belief when the acceleration has had an `acceleration_density` [rad^2/s^3] more for the last `duration` [s].

    P + q [[h^3/3, h^2/2], [h^2/2, h]].
    """
    b, h, q = belief, duration, acceleration_density
    P11, P12 = b.angle_variance + q * h * h * h / 3.0, b.covariance + 0.5 * q * h * h
    return AngleSpeed(b.angle, b.speed, P11, P12, b.speed_variance + q * h)
