"""Expectation of the event-based Kalman filter of an edge before it takes it in.

Source  ours, docs/models/event-filter.md, where a function names no other.
"""

from typing import NamedTuple, Protocol

import numpy as np

from vvdp.base.kinds import AngularVariance
from vvdp.base.select import maximum
from vvdp.estimation.association import missed_in_a_row, sector
from vvdp.estimation.between_edges import bring_forward, inflate
from vvdp.estimation.event_memory import EventFilterMemory
from vvdp.estimation.event_settings import EventFilter
from vvdp.estimation.ripple import Ripple, displacement, place_of
from vvdp.estimation.silence import Silence
from vvdp.numerics.kalman import AngleSpeed, predict
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import TURN, CodeWheel, edge_angle


class Expected(NamedTuple):
    """Beliefs brought to the time of an edge: of the mean course, the same had a manoeuvre begun at the last edge, of
    the ripple, and of the instant, which has both; and the variance R of the edge [rad^2]."""

    course: AngleSpeed
    manoeuvre: AngleSpeed
    ripple: Ripple
    instant: AngleSpeed
    variance: AngularVariance


class EdgeNoise(Protocol):
    """Noise of the edges: settings that include these of the event filter."""

    @property
    def edge_variance(self) -> float: ...
    @property
    def lowest_speed(self) -> float: ...


def edge_angle_variance(speed: float, edge_interval: float, settings: EdgeNoise) -> float:
    """Variance of the angle at which an edge was seen, R = (omega T)^2 / 12 + R_2 [rad^2].

    speed          as estimated [rad/s]
    edge_interval  T, in which the edge passed, 0 where it was time-stamped [s]

    Source  wang2017, eq. 3.4, with the threshold's part an angle: docs/errata.md
    """
    passed = maximum(speed, settings.lowest_speed) * edge_interval
    variance: float = passed * passed / 12.0 + settings.edge_variance
    return variance


def expected_at(memory: EventFilterMemory, reading: Reading, settings: EventFilter) -> Expected:
    """The beliefs at the time of a reading's edge, before it is taken in."""
    h = reading.edge_time - memory.time
    course, ripple, instant = bring_forward(memory, h, settings)
    wide = inflate(predict(memory.belief, h, 0.0), reading.edge_time - memory.last.time, settings.manoeuvre_density)
    R = edge_angle_variance(course.speed, reading.edge_interval, settings)
    return Expected(course, wide, ripple, instant, R)


def arrival_density(expected: Expected, silence: Silence) -> float:
    """Density in time with which an edge comes now if the wheel goes on as believed [1/s]: sum of p_k omega N(nu_k; S)
    over the next edge and over the one that is nearest now, before which k edges were missed.
    """
    instant, S = expected.instant, expected.instant.angle_variance + expected.variance
    off, width = silence.next_edge - instant.angle, silence.next_edge - silence.last_edge
    seen = np.exp(-0.5 * off * off / S)
    missed = np.floor(0.5 - off / width)
    if missed >= 1.0:
        off += missed * width
        seen += missed_in_a_row(silence.irregular, silence.watched, missed) * np.exp(-0.5 * off * off / S)
    density: float = maximum(instant.speed, 0.0) * seen / np.sqrt(TURN * S)
    return density


def vague(belief: AngleSpeed, wheel: CodeWheel) -> float:
    """1 where three deviations of the angle are half a sector or more, else 0."""
    return 1.0 if 6.0 * np.sqrt(belief.angle_variance) >= sector(wheel) else 0.0


def knows_edges(belief: AngleSpeed, settings: EventFilter) -> bool:
    """Whether the belief shows edges better than a count does."""
    speed_limit = settings.association_speed_deviation * settings.association_speed_deviation
    return vague(belief, settings.wheel) == 0.0 and belief.speed_variance < speed_limit


def mean_angle_at(edge: float, ripple: Ripple, settings: EventFilter) -> float:
    """Angle of the mean course when an edge passes [rad]: that of the edge minus the displacement by the ripple."""
    angle = edge_angle(edge, settings.wheel)
    if settings.ripple_order > 0.0:
        angle -= displacement(ripple, place_of(angle, settings.ripple_order))
    return angle
