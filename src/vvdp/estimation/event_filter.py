"""The event-based Kalman filter: angle and speed of the spool from the times at which edges passed.

The belief is kept at the time of the last edge. A sample without an edge needs a prediction, and the information of the
silence once an edge is late.
Derived in docs/models/event-filter.md.

Source  ours, docs/models/event-filter.md, where a function names no other.
"""

import numpy as np

from vvdp.base.select import maximum, minimum
from vvdp.estimation.association import (
    Association,
    Sighting,
    associated_edge,
    counted_edge,
    first_edge,
    irregular_share,
    sector,
)
from vvdp.estimation.between_edges import SLACK, believed_at, inflate, silence_until
from vvdp.estimation.estimator import Estimate, Estimator, to_estimate
from vvdp.estimation.event_memory import RELIABLE, EventFilterMemory, LastEdge, Manoeuvre, Tally, event_filter_start
from vvdp.estimation.event_settings import EventFilter
from vvdp.estimation.expected_edge import (
    Expected,
    arrival_density,
    expected_at,
    knows_edges,
    vague,
)
from vvdp.estimation.index import index_after_edge
from vvdp.estimation.ripple import (
    Place,
    displacement,
    place_of,
    ripple_start,
    seen_variance,
    update_with_ripple,
)
from vvdp.estimation.silence import (
    SURE,
    UNLIKELY,
    after_silence,
    is_late,
    reversed_share,
    turned_back,
)
from vvdp.estimation.starting_again import BURST, start_again, weigh_doubt
from vvdp.numerics.kalman import AngleSpeed, update
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import TURN, edge_angle

UNBELIEVABLE = 0.4
"""Share of irregular edges that shows that the believed speed is a multiple or a fraction of the true one [1]."""

UNREST = 24.0
"""Edges over which the effect of a manoeuvre fades [1]; assumed."""

TELLABLE = (0.25 * TURN) ** 2.0
"""Variance of the angle below which a turn that agrees with the index confirms it [rad^2]."""


def event_filter_step(
    memory: EventFilterMemory, reading: Reading, settings: EventFilter
) -> tuple[EventFilterMemory, Estimate]:
    """Memory and estimate after a sample.

    An edge corrects the belief at the time of the edge; the estimate is predicted from there to the sample, and takes
    in that no edge has come since.

    Source  wang2017, eqs. 3.5 to 3.10, corrected: docs/errata.md
    """
    if reading.edges > 0.0:
        after, innovation, deviation = after_edge(memory, reading, settings)
        return after, estimate_at(after, reading.time, innovation, deviation, settings)
    return memory, estimate_at(memory, reading.time, 0.0, 0.0, settings)


def estimate_at(
    memory: EventFilterMemory, time: float, innovation: float, deviation: float, settings: EventFilter
) -> Estimate:
    """The estimate at a `time` [s] up to which no edge has come since the last one; the others as in `Estimate`."""
    heard = believed_at(memory, time, settings)
    return to_estimate(heard, heard.standstill, innovation, deviation, memory.tally.missed_edges)


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
            clearly = expected.instant.angle - silence.next_edge > 0.5 * sector(settings.wheel)
            if clearly and heard.halt > SURE and memory.tally.associating > 0.0:
                return start_again(memory, reading, expected, heard, settings)
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


def take_in(
    memory: EventFilterMemory, reading: Reading, seen: Association, expected: Expected, settings: EventFilter
) -> tuple[EventFilterMemory, float, float]:
    """The same after an edge of which the number is known.

    Source  wang2017, eqs. 3.8 and 3.9, corrected: docs/errata.md
    """
    wheel, q, tally, edge = settings.wheel, settings.acceleration_density, memory.tally, seen.edge
    prior, ripple, R, associating = expected.course, expected.ripple, expected.variance, tally.associating
    # Where no silence is used, or a sample takes half a sector, anything may have happened once the angle is vague.
    unheard = settings.stop_rate == 0.0 or reading.edge_interval * prior.speed > 0.5 * sector(wheel)
    calm = associating > 0.0 and memory.manoeuvre.density <= q
    if unheard and calm and vague(expected.instant, wheel) > 0.0:
        prior, associating = expected.manoeuvre, 0.0
    place = Place(0.0, 0.0)
    if settings.ripple_order > 0.0:
        place = place_of(edge_angle(edge, wheel), settings.ripple_order)
    innovation = edge_angle(edge, wheel) - prior.angle - displacement(ripple, place)
    z = associating * innovation / np.sqrt(seen_variance(prior, ripple, place) + R)
    manoeuvre, declared = manoeuvre_after(memory.manoeuvre, z, associating, tally.watched, settings)
    if declared:
        prior = expected.manoeuvre

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
        manoeuvre=manoeuvre,
        search=memory.search,
        doubt=memory.doubt,
        slip=memory.slip + seen.slip,
    )
    if memory.doubt.odds > -np.inf:
        after = weigh_doubt(memory, after, reading, R, innovation * innovation / S + np.log(S), settings)
    if settings.index_turns > 0.0 and after.tally.associating > 0.0:
        after = look_for_index(after, reading, R, settings)
    return after, innovation, np.sqrt(S)


def manoeuvre_after(
    before: Manoeuvre, z: float, associating: float, watched: float, settings: EventFilter
) -> tuple[Manoeuvre, bool]:
    """Density and sums after an edge, and whether a manoeuvre is declared by it.

    z            innovation over its deviation [1]
    associating  1 where the belief shows the edges, else sums are 0
    watched      edges since the filter knew nothing [1]

    Source  page1954; docs/models/event-filter.md
    """
    q, q_m = settings.acceleration_density, settings.manoeuvre_density
    rise = associating * maximum(before.rise + z - SLACK, 0.0)
    fall = associating * maximum(before.fall - z - SLACK, 0.0)
    unrest = maximum(before.unrest * (1.0 - 1.0 / UNREST), q)
    if maximum(maximum(rise, fall), 0.25 * z * z / SLACK) > settings.manoeuvre_gate:
        unrest = np.sqrt(q * q_m) if watched > UNREST else unrest  # at the start nothing has calmed down yet
        return Manoeuvre(density=q_m, unrest=unrest, rise=0.0, fall=0.0), True
    density = maximum(before.density * (1.0 - 1.0 / settings.manoeuvre_edges), unrest)
    return Manoeuvre(density=density, unrest=unrest, rise=rise, fall=fall), False


def look_for_index(
    memory: EventFilterMemory, reading: Reading, variance: float, settings: EventFilter
) -> EventFilterMemory:
    """The memory after the check of the index at the edge just used; mostly the numbers stay.

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


def associate(memory: EventFilterMemory, reading: Reading, expected: Expected, settings: EventFilter) -> Association:
    """Association of the last edge of a reading: the first edge, the next by count, or the one that the belief
    suggests."""
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


def reset_speed(belief: AngleSpeed, settings: EventFilter) -> AngleSpeed:
    """The belief whose speed may have been anything, a multiple or a fraction of the true one."""
    b = belief
    anything = maximum(b.speed * b.speed, settings.speed_variance)
    return AngleSpeed(b.angle, b.speed, b.angle_variance, b.covariance, anything)


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
