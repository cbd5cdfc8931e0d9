"""The event-based Kalman filter: angle and speed of the spool from the times at which edges passed.

The belief is kept at the time of the last edge. A sample without an edge costs a prediction and nothing else.
Derived in docs/models/event-filter.md.

Source  ours, docs/models/event-filter.md, where a function names no other.
"""

from typing import NamedTuple, Protocol

import numpy as np

from vvdp.base.errors import ParameterError
from vvdp.base.kinds import (
    AccelerationDensity,
    AngularVariance,
    Count,
    Fraction,
    Number,
    Ratio,
    Speed,
    SpeedVariance,
    Time,
)
from vvdp.base.params import Params
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
from vvdp.estimation.estimator import Estimate, Estimator, to_estimate
from vvdp.estimation.index import IndexMemory, index_after_edge, index_start
from vvdp.numerics.kalman import AngleSpeed, predict, update
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import CodeWheel, edge_angle, edge_below

SLACK = 1.0
"""Normalised innovation that counts as none when innovations of one sign are summed up [1]."""

RELIABLE = 0.01
"""Share of irregular edges that is assumed at first [1]."""

UNBELIEVABLE = 0.4
"""Share of irregular edges that shows that the believed speed is a multiple or a fraction of the true one [1]."""

BURST = 4.0
"""Edges missed in a row that count as irregular; a longer gap is one dropout [1]."""


class EventFilterValues(Params):
    """The numbers of the event-based Kalman filter, for any wheel; `event_filter` has the usual ones.

    `edge_variance` is the part of the noise that is an angle, the other follows from the interval in which an edge
    passed, taken at no less than `lowest_speed`. Edges are counted until the speed is known to
    `association_speed_deviation`. A manoeuvre is declared when the sum of innovations exceeds `manoeuvre_gate`; the
    acceleration then has `manoeuvre_density`, which fades over `manoeuvre_edges` edges.
    """

    acceleration_density: AccelerationDensity
    edge_variance: AngularVariance
    lowest_speed: Speed
    angle_variance: AngularVariance
    speed_variance: SpeedVariance
    association_speed_deviation: Speed
    manoeuvre_density: AccelerationDensity
    manoeuvre_gate: Ratio
    manoeuvre_edges: Count

    def check(self) -> None:
        if not self.edge_variance > 0.0:
            raise ParameterError("EventFilter.edge_variance: 0 rad^2; no edge is known exactly, expected above 0")
        if not self.manoeuvre_edges >= 1.0:
            raise ParameterError(f"EventFilter.manoeuvre_edges: {self.manoeuvre_edges:g}; expected at least 1")
        if self.manoeuvre_density < self.acceleration_density:
            raise ParameterError(
                f"EventFilter.manoeuvre_density: {self.manoeuvre_density:g} rad^2/s^3 is below the "
                f"acceleration_density of {self.acceleration_density:g} rad^2/s^3"
            )


class EventFilter(EventFilterValues):
    """Settings of the event-based Kalman filter.

    The index of the `wheel` has been found when `index_turns` turns agree about it; 0 where it has none.
    """

    wheel: CodeWheel
    index_turns: Count = 0.0

    def check(self) -> None:
        super().check()
        if self.index_turns > 0.0 and not self.wheel.has_index:
            raise ParameterError(
                f"EventFilter.index_turns: {self.index_turns:g}, but the wheel with edges at {self.wheel.edges} rad "
                "looks the same after less than a turn; expected 0"
            )


class LastEdge(NamedTuple):
    """Number and time of the last edge that was used."""

    number: Number
    time: Time


class Tally(NamedTuple):
    """How edges are told: `started` is 1 after the first, `associating` once the belief tells them and none counts.

    `ignored` edges have come since the last used one; `irregular` is the share of edges that were missed or ignored.
    """

    started: Fraction
    associating: Fraction
    ignored: Count
    missed_edges: Count
    irregular: Fraction


class Manoeuvre(NamedTuple):
    """Density of the acceleration, and the sums of innovations that tell when the speed changes."""

    density: AccelerationDensity
    rise: Number
    fall: Number


class EventFilterMemory(NamedTuple):
    """What the filter carries from sample to sample: its belief at `time`, and what it knows of edges and index.

    `time` differs from that of the last edge where another sensor tells the angle between edges.
    """

    time: Time
    belief: AngleSpeed
    last: LastEdge
    tally: Tally
    manoeuvre: Manoeuvre
    search: IndexMemory


def event_filter(wheel: CodeWheel) -> EventFilter:
    """The published settings, completed; change one with `dataclasses.replace`.

    Source  wang2017, section 3.5; manoeuvre, association and index are ours, docs/models/event-filter.md
    """
    return EventFilter(
        wheel=wheel,
        acceleration_density=0.25,
        edge_variance=3.47e-3,  # with the sampling part, 2.06e-3 at 157 rad/s and 1 ms, the published 5.53e-3
        lowest_speed=2.0 * np.pi,
        angle_variance=1000.0,
        speed_variance=1000.0,
        association_speed_deviation=10.0,
        manoeuvre_density=2e4,
        manoeuvre_gate=6.0,
        manoeuvre_edges=4.0,
        index_turns=2.0 if wheel.has_index else 0.0,
    )


def event_filter_start(settings: EventFilter, time: float, angle: float, speed: float) -> EventFilterMemory:
    """Memory before the first sample.

    time   [s]
    angle  where the wheel stands, as far as is known [rad]
    speed  expected [rad/s]
    """
    belief = AngleSpeed(angle, speed, settings.angle_variance, 0.0, settings.speed_variance)
    q, wheel = settings.acceleration_density, settings.wheel
    edge = edge_below(angle, wheel)
    return EventFilterMemory(
        time=time,
        belief=belief,
        last=LastEdge(edge, time),
        tally=Tally(started=0.0, associating=0.0, ignored=0.0, missed_edges=0.0, irregular=RELIABLE),
        manoeuvre=Manoeuvre(density=q, rise=0.0, fall=0.0),
        search=index_start(wheel),
    )


def event_filter_step(
    memory: EventFilterMemory, reading: Reading, settings: EventFilter
) -> tuple[EventFilterMemory, Estimate]:
    """Memory and estimate after a sample.

    An edge corrects the belief at the time of the edge; the estimate is predicted from there to the sample.

    Source  wang2017, eqs. 3.5 to 3.10, corrected: docs/errata.md
    """
    innovation, deviation = 0.0, 0.0
    if reading.edges > 0.0:
        memory, innovation, deviation = after_edge(memory, reading, settings)
    belief = predict(memory.belief, reading.time - memory.time, memory.manoeuvre.density)
    estimate = to_estimate(belief, innovation, deviation, memory.tally.missed_edges)
    return memory, estimate


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
    return passed * passed / 12.0 + settings.edge_variance


def after_edge(
    memory: EventFilterMemory, reading: Reading, settings: EventFilter
) -> tuple[EventFilterMemory, float, float]:
    """Memory after a sample with edges, the innovation and its deviation [rad], both 0 if the edge was not used.

    Source  wang2017, eqs. 3.8 and 3.9, corrected: docs/errata.md
    """
    wheel, q, q_m = settings.wheel, settings.acceleration_density, settings.manoeuvre_density
    h = reading.edge_time - memory.time
    prior = predict(memory.belief, h, memory.manoeuvre.density)
    wide = inflate(predict(memory.belief, h, 0.0), reading.edge_time - memory.last.time, q_m)
    R = edge_angle_variance(prior.speed, reading.edge_interval, settings)
    seen = associate(memory, reading, prior, wide, R, settings)
    edges = memory.tally.ignored + reading.edges
    if seen.used == 0.0:
        return skip_edges(memory, edges), 0.0, 0.0

    associating = memory.tally.associating
    if associating > 0.0 and memory.manoeuvre.density <= q and vague(prior, wheel) > 0.0:
        prior, associating = wide, 0.0  # after a long time without edges anything may have happened
    innovation = edge_angle(seen.edge, wheel) - prior.angle
    z = associating * innovation / np.sqrt(prior.angle_variance + R)
    rise = associating * maximum(memory.manoeuvre.rise + z - SLACK, 0.0)
    fall = associating * maximum(memory.manoeuvre.fall - z - SLACK, 0.0)
    density = maximum(memory.manoeuvre.density * (1.0 - 1.0 / settings.manoeuvre_edges), q)
    if maximum(maximum(rise, fall), 0.25 * z * z / SLACK) > settings.manoeuvre_gate:
        prior, density, rise, fall = wide, q_m, 0.0, 0.0

    skipped = memory.tally.started * maximum(seen.edge - memory.last.number - edges, 0.0)
    irregular = irregular_share(memory.tally.irregular, associating * minimum(skipped, BURST), 1.0)
    if irregular > UNBELIEVABLE:
        prior, associating, irregular = reset_speed(prior, settings), 0.0, RELIABLE

    belief = update(prior, innovation, R)
    speed_limit = settings.association_speed_deviation * settings.association_speed_deviation
    if vague(belief, wheel) == 0.0 and belief.speed_variance < speed_limit:
        associating = 1.0
    number, search = seen.edge, memory.search
    if settings.index_turns > 0.0 and associating > 0.0:
        found = index_after_edge(search, number, reading.edge_time, reading.polarity, R, settings.index_turns, wheel)
        number, search = number + found.edges, found.memory
        belief = shift_angle(belief, found.edges * sector(wheel))
    missed = memory.tally.missed_edges + skipped
    after = EventFilterMemory(
        time=reading.edge_time,
        belief=belief,
        last=LastEdge(number, reading.edge_time),
        tally=Tally(started=1.0, associating=associating, ignored=0.0, missed_edges=missed, irregular=irregular),
        manoeuvre=Manoeuvre(density=density, rise=rise, fall=fall),
        search=search,
    )
    return after, innovation, np.sqrt(prior.angle_variance + R)


def associate(
    memory: EventFilterMemory,
    reading: Reading,
    prior: AngleSpeed,
    wide: AngleSpeed,
    variance: float,
    settings: EventFilter,
) -> Association:
    """Which edge the last of a reading was: the first, the next by count, or that which the belief tells.

    prior     belief at the time of the edge
    wide      the same had a manoeuvre begun at the last edge
    variance  of the angle at which the edge was seen [rad^2]
    """
    m, wheel, polarity = memory, settings.wheel, reading.polarity
    if m.tally.started == 0.0:
        return Association(first_edge(m.belief.angle, polarity, wheel), 1.0)
    if m.tally.associating == 0.0:
        return Association(counted_edge(m.last.number, m.tally.ignored + reading.edges, polarity), 1.0)
    advance = (reading.edge_time - m.last.time) * prior.speed
    odds = (
        2.0 * SLACK * (settings.manoeuvre_gate - m.manoeuvre.fall)
    )  # in doubt the next edge by count is behind: slower
    S, S_m = prior.angle_variance + variance, wide.angle_variance + variance
    sighting = Sighting(
        angle=prior.angle,
        advance=advance,
        variance=S,
        manoeuvre_variance=S_m,
        manoeuvre_odds=odds,
        ignored=m.tally.ignored,
        fresh=reading.edges,
        polarity=polarity,
        irregular=m.tally.irregular,
    )
    return associated_edge(m.last.number, sighting, wheel)


def inflate(belief: AngleSpeed, duration: float, acceleration_density: float) -> AngleSpeed:
    """The belief when the acceleration has had an `acceleration_density` [rad^2/s^3] more for the last `duration` [s].

    P + q [[h^3/3, h^2/2], [h^2/2, h]].
    """
    b, h, q = belief, duration, acceleration_density
    P11, P12 = b.angle_variance + q * h * h * h / 3.0, b.covariance + 0.5 * q * h * h
    return AngleSpeed(b.angle, b.speed, P11, P12, b.speed_variance + q * h)


def vague(belief: AngleSpeed, wheel: CodeWheel) -> float:
    """1 where three deviations of the angle are half a sector or more, else 0."""
    return 1.0 if 6.0 * np.sqrt(belief.angle_variance) >= sector(wheel) else 0.0


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
    )
    return EventFilterMemory(
        time=m.time, belief=m.belief, last=m.last, tally=told, manoeuvre=m.manoeuvre, search=m.search
    )


def event_filter_estimator(
    settings: EventFilter, time: float = 0.0, angle: float = 0.0, speed: float = 0.0
) -> Estimator:
    """The event-based Kalman filter, ready to run; `angle` [rad] and `speed` [rad/s] as far as they are known."""
    memory = event_filter_start(settings, time, angle, speed)
    return Estimator("event-based Kalman filter", event_filter_step, memory, settings)
