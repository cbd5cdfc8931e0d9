"""The event-based Kalman filter at the first edges after a silence: the wheel starts again, or the sensor was silent.

Source  ours, docs/models/event-filter.md, where a function names no other.
"""

import numpy as np

from vvdp.base.select import maximum, minimum
from vvdp.estimation.association import counted_edge, irregular_share, missed_in_a_row, sector
from vvdp.estimation.between_edges import silence_until
from vvdp.estimation.doubt import Doubt, NumberedEdge, carry_on, is_settled, no_doubt
from vvdp.estimation.event_memory import EventFilterMemory, LastEdge, Manoeuvre, Tally
from vvdp.estimation.event_settings import EventFilter
from vvdp.estimation.expected_edge import Expected, knows_edges, mean_angle_at
from vvdp.estimation.index import index_again
from vvdp.estimation.ripple import without_covariance
from vvdp.estimation.silence import Heard, start_speed, turned_back
from vvdp.numerics.kalman import AngleSpeed, predict, update
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import TURN, edge_angle, nearest_edge

BURST = 4.0
"""Edges missed in a row that count as irregular; a longer gap is one dropout [1]."""


def start_again(
    memory: EventFilterMemory, reading: Reading, expected: Expected, believed: Heard, settings: EventFilter
) -> tuple[EventFilterMemory, float, float]:
    """The memory after the first edge of a wheel that seems to have stood: the next by count, at a speed to be found.

    The belief from before is kept in doubt: perhaps the sensor was silent. Innovation and deviation as `after_edge`.

    believed  expectation just before the edge
    """
    m, tally, wheel, R, q_m = memory, memory.tally, settings.wheel, expected.variance, settings.manoeuvre_density
    silence = silence_until(memory, reading.edge_time, memory.tally.ignored + reading.edges, settings)
    edge = counted_edge(m.last.number, tally.ignored + reading.edges, reading.polarity)
    speed, variance = start_speed(silence, believed.standstill / believed.halt)
    course = expected.course
    nearest = maximum(nearest_edge(expected.instant.angle, reading.polarity, wheel), edge)
    off, S = mean_angle_at(nearest, m.ripple, settings) - course.angle, course.angle_variance + R
    odds = believed.missing_odds + np.log(sector(wheel) / np.sqrt(TURN * S)) - 0.5 * off * off / S
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
    return after, edge_angle(edge, wheel) - believed.angle, np.sqrt(believed.angle_variance + R)


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
    surprise  nu^2/S + ln S of the edge to the filter that began again
    """
    wheel, q, polarity = settings.wheel, settings.acceleration_density, reading.polarity
    prior = predict(before.doubt.belief, reading.edge_time - before.time, q)
    counted = counted_edge(before.doubt.number, before.tally.ignored + reading.edges, polarity)
    number = maximum(nearest_edge(prior.angle, polarity, wheel), counted)
    cost = 2.0 * np.log(missed_in_a_row(before.tally.irregular, before.tally.watched, number - counted))
    seen = NumberedEdge(number, mean_angle_at(number, before.ripple, settings))
    doubt = carry_on(before.doubt, prior, seen, variance, surprise + cost)
    m, belief, edge, tally, slip = after, after.belief, after.last.number, after.tally, after.slip
    settled = is_settled(doubt)
    if settled:
        lead = doubt.belief.angle - belief.angle
        slip += lead * lead / (1.0 + np.exp(abs(doubt.odds)))
    if settled and doubt.odds > 0.0:
        missed = doubt.number - edge
        belief, edge, slip = doubt.belief, doubt.number, slip - m.slip + doubt.slip
        tally = miss(tally, missed, 1.0 if knows_edges(belief, settings) else 0.0)
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


def miss(tally: Tally, edges: float, associating: float) -> Tally:
    """The tally once it turns out that so many `edges` were missed; `associating` where the belief shows them now."""
    return Tally(
        started=1.0,
        associating=associating,
        ignored=0.0,
        missed_edges=tally.missed_edges + edges,
        irregular=irregular_share(tally.irregular, minimum(edges, BURST), 0.0),
        watched=tally.watched,
    )
