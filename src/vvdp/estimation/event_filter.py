"""The event-based Kalman filter: angle and speed of the spool from the times at which edges passed.

The belief is kept at the time of the last edge. A sample without an edge costs a prediction and nothing else.
Derived in docs/models/event-filter.md.

Source  ours, docs/models/event-filter.md, where a function names no other.
"""

from typing import NamedTuple, Protocol

import numpy as np

from vvdp.base.kinds import AngularVariance
from vvdp.base.select import maximum, minimum
from vvdp.estimation.association import (
    Association,
    Sighting,
    associated_edge,
    counted_edge,
    first_edge,
    irregular_share,
    missed_in_a_row,
    sector,
)
from vvdp.estimation.between_edges import SLACK, believed_at, heard_estimate, inflate, silence_until
from vvdp.estimation.doubt import Doubt, carry_on, is_settled, no_doubt
from vvdp.estimation.estimator import Estimate, Estimator
from vvdp.estimation.event_memory import RELIABLE, EventFilterMemory, LastEdge, Manoeuvre, Tally, event_filter_start
from vvdp.estimation.event_settings import EventFilter
from vvdp.estimation.index import index_after_edge, index_again
from vvdp.estimation.ripple import (
    Place,
    Ripple,
    displacement,
    of_the_instant,
    place_of,
    predict_ripple,
    ripple_start,
    seen_variance,
    update_with_ripple,
    without_covariance,
)
from vvdp.estimation.silence import (
    SURE,
    UNLIKELY,
    Heard,
    Silence,
    after_silence,
    is_late,
    reversed_share,
    start_speed,
    turned_back,
)
from vvdp.numerics.kalman import AngleSpeed, predict, update
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import TURN, CodeWheel, edge_angle, nearest_edge

UNBELIEVABLE = 0.4
"""Share of irregular edges that shows that the believed speed is a multiple or a fraction of the true one [1]."""

UNREST = 24.0
"""Edges over which what a manoeuvre leaves behind fades [1]."""

TELLABLE = (0.25 * TURN) ** 2.0
"""Variance of the angle below which a turn that agrees with the index confirms it [rad^2]."""

BURST = 4.0
"""Edges missed in a row that count as irregular; a longer gap is one dropout [1]."""


class Expected(NamedTuple):
    """Beliefs brought to the time of an edge: of the mean course, the same had a manoeuvre begun at the last edge, of
    the ripple, and of the instant, which has both; and the variance R of the edge [rad^2]."""

    course: AngleSpeed
    manoeuvre: AngleSpeed
    ripple: Ripple
    instant: AngleSpeed
    variance: AngularVariance


def event_filter_step(
    memory: EventFilterMemory, reading: Reading, settings: EventFilter
) -> tuple[EventFilterMemory, Estimate]:
    """Memory and estimate after a sample.

    An edge corrects the belief at the time of the edge; the estimate is predicted from there to the sample, and takes
    in that no edge has come since.

    Source  wang2017, eqs. 3.5 to 3.10, corrected: docs/errata.md
    """
    innovation, deviation = 0.0, 0.0
    if reading.edges > 0.0:
        memory, innovation, deviation = after_edge(memory, reading, settings)
    heard = believed_at(memory, reading.time, settings)
    return memory, heard_estimate(heard, innovation, deviation, memory.tally.missed_edges)


class EdgeNoise(Protocol):
    """How well edges are seen: settings that have these of the event filter."""

    @property
    def edge_variance(self) -> float: ...
    @property
    def lowest_speed(self) -> float: ...


def edge_angle_variance(speed: float, edge_interval: float, settings: EdgeNoise) -> float:
    """Variance of the angle at which an edge was seen, R = (omega T)^2 / 12 + R_2 [rad^2].

    speed          believed [rad/s]
    edge_interval  T, in which the edge passed, 0 where it was time-stamped [s]

    Source  wang2017, eq. 3.4, with the threshold's part an angle: docs/errata.md
    """
    passed = maximum(speed, settings.lowest_speed) * edge_interval
    variance: float = passed * passed / 12.0 + settings.edge_variance
    return variance


def expected_at(memory: EventFilterMemory, reading: Reading, settings: EventFilter) -> Expected:
    """The beliefs at the time of a reading's edge, before it is taken in."""
    h = reading.edge_time - memory.time
    course = predict(memory.belief, h, memory.manoeuvre.density)
    wide = inflate(predict(memory.belief, h, 0.0), reading.edge_time - memory.last.time, settings.manoeuvre_density)
    R = edge_angle_variance(course.speed, reading.edge_interval, settings)
    if settings.ripple_order == 0.0:
        return Expected(course, wide, memory.ripple, course, R)
    ripple = predict_ripple(memory.ripple, h, settings.ripple_drift)
    return Expected(course, wide, ripple, of_the_instant(course, ripple, settings.ripple_order), R)


def after_edge(
    memory: EventFilterMemory, reading: Reading, settings: EventFilter
) -> tuple[EventFilterMemory, float, float]:
    """Memory after a sample with edges, the innovation and its deviation [rad], both 0 if the edge was not used.

    Source  wang2017, eqs. 3.8 and 3.9, corrected: docs/errata.md
    """
    expected = expected_at(memory, reading, settings)
    slip = 0.0
    if settings.stop_rate > 0.0 and memory.tally.started > 0.0:
        silence = silence_until(memory, reading.edge_time, memory.tally.ignored + reading.edges, settings)
        if is_late(expected.instant, silence) or reversed_share(expected.instant) > UNLIKELY:
            wide = inflate(expected.instant, silence.duration, settings.manoeuvre_density)
            heard = after_silence(expected.instant, wide, silence)
            if heard.halt > SURE and memory.tally.associating > 0.0:
                return start_again(memory, reading, expected, heard, settings)
            clearly = expected.instant.angle - silence.next_edge > 0.5 * sector(settings.wheel)
            stood = heard.halt if clearly else heard.backward
            slip = memory.tally.associating * turned_back(stood, arrival_density(expected, silence), silence)
    return after_expected_edge(memory, reading, expected, slip, settings)


def after_expected_edge(
    memory: EventFilterMemory, reading: Reading, expected: Expected, slip: float, settings: EventFilter
) -> tuple[EventFilterMemory, float, float]:
    """The same of a wheel that has not halted.

    slip  variance of the angle that the silence before the edge leaves [rad^2]
    """
    seen = associate(memory, reading, expected, settings)
    if seen.used == 0.0:
        return skip_edges(memory, memory.tally.ignored + reading.edges), 0.0, 0.0
    seen = Association(seen.edge, seen.used, seen.slip + slip)
    return take_in(memory, reading, seen, expected, settings)


def arrival_density(expected: Expected, silence: Silence) -> float:
    """Density in time with which the next edge comes now if the wheel goes on as believed [1/s]: omega N(nu; S)."""
    instant, S = expected.instant, expected.instant.angle_variance + expected.variance
    off = silence.next_edge - instant.angle
    density: float = maximum(instant.speed, 0.0) * np.exp(-0.5 * off * off / S) / np.sqrt(TURN * S)
    return density


def take_in(
    memory: EventFilterMemory, reading: Reading, seen: Association, expected: Expected, settings: EventFilter
) -> tuple[EventFilterMemory, float, float]:
    """The same after an edge of which the number is known.

    Source  wang2017, eqs. 3.8 and 3.9, corrected: docs/errata.md
    """
    wheel, q, q_m, tally = settings.wheel, settings.acceleration_density, settings.manoeuvre_density, memory.tally
    edge = seen.edge
    prior, ripple, R, associating = expected.course, expected.ripple, expected.variance, tally.associating
    if associating > 0.0 and memory.manoeuvre.density <= q and vague(expected.instant, wheel) > 0.0:
        prior, associating = expected.manoeuvre, 0.0  # after a long time without edges anything may have happened
    place = Place(0.0, 0.0)
    if settings.ripple_order > 0.0:
        place = place_of(edge_angle(edge, wheel), settings.ripple_order)
    innovation = edge_angle(edge, wheel) - prior.angle - displacement(ripple, place)
    z = associating * innovation / np.sqrt(seen_variance(prior, ripple, place) + R)
    rise = associating * maximum(memory.manoeuvre.rise + z - SLACK, 0.0)
    fall = associating * maximum(memory.manoeuvre.fall - z - SLACK, 0.0)
    unrest = maximum(memory.manoeuvre.unrest * (1.0 - 1.0 / UNREST), q)
    density = maximum(memory.manoeuvre.density * (1.0 - 1.0 / settings.manoeuvre_edges), unrest)
    if maximum(maximum(rise, fall), 0.25 * z * z / SLACK) > settings.manoeuvre_gate:
        prior, density, rise, fall = expected.manoeuvre, q_m, 0.0, 0.0
        unrest = np.sqrt(q * q_m) if tally.watched > UNREST else unrest  # at the start nothing has calmed down yet

    skipped = tally.started * maximum(edge - memory.last.number - tally.ignored - reading.edges, 0.0)
    irregular = irregular_share(tally.irregular, associating * minimum(skipped, BURST), 1.0)
    watched = tally.watched + associating
    if irregular > UNBELIEVABLE:
        prior, associating, irregular, watched = reset_speed(prior, settings), 0.0, RELIABLE, 0.0

    S = seen_variance(prior, ripple, place) + R
    belief = update(prior, innovation, R)
    if settings.ripple_order > 0.0:
        belief, ripple = update_with_ripple(prior, ripple, place, innovation, R)
    if knows_edges(belief, settings):
        associating = 1.0
    after = EventFilterMemory(
        time=reading.edge_time,
        belief=belief,
        ripple=ripple,
        last=LastEdge(edge, reading.edge_time),
        tally=Tally(
            started=1.0,
            associating=associating,
            ignored=0.0,
            missed_edges=tally.missed_edges + skipped,
            irregular=irregular,
            watched=watched,
        ),
        manoeuvre=Manoeuvre(density=density, unrest=unrest, rise=rise, fall=fall),
        search=memory.search,
        doubt=memory.doubt,
        slip=memory.slip + seen.slip,
    )
    if memory.doubt.odds > -np.inf:
        after = weigh_doubt(memory, after, reading, R, innovation * innovation / S + np.log(S), settings)
    if settings.index_turns > 0.0 and after.tally.associating > 0.0:
        after = look_for_index(after, reading, R, settings)
    return after, innovation, np.sqrt(S)


def look_for_index(
    memory: EventFilterMemory, reading: Reading, variance: float, settings: EventFilter
) -> EventFilterMemory:
    """The memory once the index has been asked about the edge just taken in; mostly the numbers stay.

    variance  of the angle at which the edge was seen [rad^2]
    """
    m, wheel = memory, settings.wheel
    found = index_after_edge(
        m.search, m.last.number, reading.edge_time, reading.polarity, variance, settings.index_turns, wheel
    )
    belief, ripple, slip = m.belief, m.ripple, m.slip
    if found.confirmed > 0.0 and slip < TELLABLE:
        slip = 0.0
    if found.edges != 0.0:
        belief = shift_angle(belief, found.edges * sector(wheel))
        ripple = ripple_start(settings.ripple_variance)  # its phase was that of other angles
    return EventFilterMemory(
        time=m.time,
        belief=belief,
        ripple=ripple,
        last=LastEdge(m.last.number + found.edges, m.last.time),
        tally=m.tally,
        manoeuvre=m.manoeuvre,
        search=found.memory,
        doubt=m.doubt,
        slip=slip,
    )


def start_again(
    memory: EventFilterMemory, reading: Reading, expected: Expected, heard: Heard, settings: EventFilter
) -> tuple[EventFilterMemory, float, float]:
    """The memory after the first edge of a wheel that seems to have stood: the next by count, at a speed to be found.

    The belief from before is kept in doubt: perhaps the sensor was silent. Innovation and deviation as `after_edge`.

    heard  what was believed just before the edge
    """
    m, tally, wheel, R, q_m = memory, memory.tally, settings.wheel, expected.variance, settings.manoeuvre_density
    silence = silence_until(memory, reading.edge_time, memory.tally.ignored + reading.edges, settings)
    edge = counted_edge(m.last.number, tally.ignored + reading.edges, reading.polarity)
    speed, variance = start_speed(silence, heard.standstill / heard.halt)
    course = expected.course
    nearest = maximum(nearest_edge(expected.instant.angle, reading.polarity, wheel), edge)
    off, S = mean_angle_at(nearest, m.ripple, settings) - course.angle, course.angle_variance + R
    odds = heard.missing_odds + np.log(sector(wheel) / np.sqrt(TURN * S)) - 0.5 * off * off / S
    after = EventFilterMemory(
        time=reading.edge_time,
        belief=AngleSpeed(mean_angle_at(edge, m.ripple, settings), speed, R, 0.0, variance),
        ripple=without_covariance(m.ripple),
        last=LastEdge(edge, reading.edge_time),
        tally=Tally(
            started=1.0,
            associating=0.0,
            ignored=0.0,
            missed_edges=tally.missed_edges + maximum(edge - m.last.number - tally.ignored - reading.edges, 0.0),
            irregular=tally.irregular,
            watched=tally.watched,
        ),
        manoeuvre=Manoeuvre(density=q_m, unrest=np.sqrt(q_m * settings.acceleration_density), rise=0.0, fall=0.0),
        search=index_again(m.search),
        doubt=Doubt(update(course, off, R), number=nearest, odds=odds, slip=memory.slip, edges=0.0),
        slip=memory.slip + turned_back(1.0, 0.0, silence),
    )
    return after, edge_angle(edge, wheel) - heard.angle, np.sqrt(heard.angle_variance + R)


def weigh_doubt(
    before: EventFilterMemory,
    after: EventFilterMemory,
    reading: Reading,
    variance: float,
    surprise: float,
    settings: EventFilter,
) -> EventFilterMemory:
    """The memory once the belief from before a silence has met the same edge: kept beside, taken up or given up.

    before    memory without the edge, `after` with it
    variance  R, of the edge [rad^2]
    surprise  nu^2/S + ln S of the edge to the filter that began anew
    """
    wheel, q, polarity = settings.wheel, settings.acceleration_density, reading.polarity
    prior = predict(before.doubt.belief, reading.edge_time - before.time, q)
    counted = counted_edge(before.doubt.number, before.tally.ignored + reading.edges, polarity)
    number = maximum(nearest_edge(prior.angle, polarity, wheel), counted)
    cost = 2.0 * np.log(missed_in_a_row(before.tally.irregular, before.tally.watched, number - counted))
    seen = (number, mean_angle_at(number, before.ripple, settings))
    doubt = carry_on(before.doubt, prior, seen, variance, surprise + cost)
    m, belief, edge, tally, slip = after, after.belief, after.last.number, after.tally, after.slip
    settled = is_settled(doubt)
    if settled:
        lead = doubt.belief.angle - belief.angle
        slip += lead * lead / (1.0 + np.exp(abs(doubt.odds)))
    if settled and doubt.odds > 0.0:
        missed = doubt.number - edge
        belief, edge, slip = doubt.belief, doubt.number, slip - m.slip + doubt.slip
        tally = Tally(
            started=1.0,
            associating=1.0 if knows_edges(belief, settings) else 0.0,
            ignored=0.0,
            missed_edges=tally.missed_edges + missed,
            irregular=irregular_share(tally.irregular, minimum(missed, BURST), 0.0),
            watched=tally.watched,
        )
    return EventFilterMemory(
        time=m.time,
        belief=belief,
        ripple=m.ripple,
        last=LastEdge(edge, m.last.time),
        tally=tally,
        manoeuvre=m.manoeuvre,
        search=m.search,
        doubt=no_doubt(belief) if settled else doubt,
        slip=slip,
    )


def associate(memory: EventFilterMemory, reading: Reading, expected: Expected, settings: EventFilter) -> Association:
    """Which edge the last of a reading was: the first, the next by count, or that which the belief tells."""
    m, wheel, polarity = memory, settings.wheel, reading.polarity
    if m.tally.started == 0.0:
        return Association(first_edge(m.belief.angle, polarity, wheel), 1.0, 0.0)
    if m.tally.associating == 0.0:
        return Association(counted_edge(m.last.number, m.tally.ignored + reading.edges, polarity), 1.0, 0.0)
    instant, R = expected.instant, expected.variance
    # in doubt the next edge by count is behind: slower
    odds = 2.0 * SLACK * (settings.manoeuvre_gate - m.manoeuvre.fall)
    more = expected.manoeuvre.angle_variance - expected.course.angle_variance
    sighting = Sighting(
        angle=instant.angle,
        advance=(reading.edge_time - m.last.time) * instant.speed,
        variance=instant.angle_variance + R,
        manoeuvre_variance=instant.angle_variance + more + R,
        manoeuvre_odds=odds,
        ignored=m.tally.ignored,
        fresh=reading.edges,
        polarity=polarity,
        irregular=m.tally.irregular,
    )
    return associated_edge(m.last.number, sighting, wheel)


def vague(belief: AngleSpeed, wheel: CodeWheel) -> float:
    """1 where three deviations of the angle are half a sector or more, else 0."""
    return 1.0 if 6.0 * np.sqrt(belief.angle_variance) >= sector(wheel) else 0.0


def knows_edges(belief: AngleSpeed, settings: EventFilter) -> bool:
    """Whether the belief tells edges better than a count does."""
    speed_limit = settings.association_speed_deviation * settings.association_speed_deviation
    return vague(belief, settings.wheel) == 0.0 and belief.speed_variance < speed_limit


def reset_speed(belief: AngleSpeed, settings: EventFilter) -> AngleSpeed:
    """The belief whose speed may have been anything, a multiple or a fraction of the true one."""
    b = belief
    anything = maximum(b.speed * b.speed, settings.speed_variance)
    return AngleSpeed(b.angle, b.speed, b.angle_variance, b.covariance, anything)


def mean_angle_at(edge: float, ripple: Ripple, settings: EventFilter) -> float:
    """Angle that the mean course has when an edge passes [rad]: that of the edge, less what the ripple is ahead."""
    angle = edge_angle(edge, settings.wheel)
    if settings.ripple_order > 0.0:
        angle -= displacement(ripple, place_of(angle, settings.ripple_order))
    return angle


def shift_angle(belief: AngleSpeed, angle: float) -> AngleSpeed:
    """The belief about a wheel whose edges turn out to be `angle` [rad] further on."""
    b = belief
    return AngleSpeed(b.angle + angle, b.speed, b.angle_variance, b.covariance, b.speed_variance)


def skip_edges(memory: EventFilterMemory, edges: float) -> EventFilterMemory:
    """The memory with `edges` ignored since the last used one."""
    m, tally = memory, memory.tally
    told = Tally(
        started=tally.started,
        associating=tally.associating,
        ignored=edges,
        missed_edges=tally.missed_edges,
        irregular=irregular_share(tally.irregular, edges - tally.ignored, 0.0),
        watched=tally.watched,
    )
    return EventFilterMemory(
        time=m.time,
        belief=m.belief,
        ripple=m.ripple,
        last=m.last,
        tally=told,
        manoeuvre=m.manoeuvre,
        search=m.search,
        doubt=m.doubt,
        slip=m.slip,
    )


def event_filter_estimator(
    settings: EventFilter, time: float = 0.0, angle: float = 0.0, speed: float = 0.0
) -> Estimator:
    """The event-based Kalman filter, ready to run; `angle` [rad] and `speed` [rad/s] as far as they are known."""
    memory = event_filter_start(settings, time, angle, speed)
    return Estimator("event-based Kalman filter", event_filter_step, memory, settings)
