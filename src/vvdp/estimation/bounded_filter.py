"""The event-based Kalman filter with numbers that stay small however long it runs, so that single precision is enough.

Nothing in the filter depends on when time begins, nor on whole revolutions: it gives the same estimate if all times
move by one amount, or all angles by whole revolutions. So at each sample with edges all times are made relative to it,
and whole revolutions are taken out of all angles. Derived in docs/models/event-filter.md, "Single precision".

Source  ours, docs/models/event-filter.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import Angle, AngularVariance, Count, Fraction, Number, Speed, Time
from vvdp.estimation.doubt import Doubt
from vvdp.estimation.estimator import Estimate
from vvdp.estimation.event_filter import event_filter_step, shift_angle
from vvdp.estimation.event_memory import EventFilterMemory, LastEdge, event_filter_start
from vvdp.estimation.event_settings import EventFilter
from vvdp.estimation.index import IndexMemory
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import TURN, CodeWheel


class PassedEdges(NamedTuple):
    """One sample of an edge sensor as a counter and a timer of a microcontroller give it, without the time of day.

    `elapsed` is the time since the sample before, `edge_age` that since the last edge; the other fields are those of
    `Reading`.
    """

    elapsed: Time
    edges: Count
    edge_age: Time
    edge_interval: Time
    polarity: Number


class BoundedMemory(NamedTuple):
    """Memory of the filter with times relative to the last sample with edges, and angles without whole `revolutions`.

    `since` is the time since that sample, and `lost` what rounding has added to it (compensated sum).
    """

    filter: EventFilterMemory
    since: Time
    lost: Time
    revolutions: Number


class WatchedAngle(NamedTuple):
    """Estimate of a shaft's motion by an event filter, as in `Estimate`; `slip` is the part of the angle's variance
    that no later edge can show: jumps by whole sectors.

    The angle is also given as whole `revolutions` and the `remainder`, which single precision resolves at any time.
    """

    angle: Angle
    speed: Speed
    angle_deviation: Angle
    speed_deviation: Speed
    innovation: Angle
    innovation_deviation: Angle
    missed_edges: Count
    standstill: Fraction
    slip: AngularVariance
    revolutions: Number
    remainder: Angle


def bounded_start(settings: EventFilter) -> BoundedMemory:
    """Memory before the first sample: nothing is known but the wheel."""
    return BoundedMemory(filter=event_filter_start(settings, 0.0, 0.0, 0.0), since=0.0, lost=0.0, revolutions=0.0)


def bounded_step(
    memory: BoundedMemory, reading: PassedEdges, settings: EventFilter
) -> tuple[BoundedMemory, WatchedAngle]:
    """Memory and estimate after a sample.

    The time since an edge is a sum of thousands of intervals in single precision, hence compensated.

    Source  kahan1965
    """
    r, added = reading, reading.elapsed - memory.lost
    since = memory.since + added
    lost = (since - memory.since) - added
    passed, turns = 0.0, 0.0
    if r.edges > 0.0:
        passed, turns = since, np.floor(memory.filter.last.number / len(settings.wheel.edges))
    before = relative(memory.filter, passed, turns, settings.wheel)
    now, revolutions = since - passed, memory.revolutions + turns
    seen = Reading(now, r.edges, now - r.edge_age, r.edge_interval, r.polarity)
    after, estimate = event_filter_step(before, seen, settings)
    kept = BoundedMemory(filter=after, since=now, lost=lost, revolutions=revolutions)
    return kept, watched_angle(estimate, revolutions, after.slip)


def watched_angle(estimate: Estimate, revolutions: float, slip: float) -> WatchedAngle:
    """Output for an estimate without whole `revolutions` [1], with the variance of jumps [rad^2]."""
    return WatchedAngle(
        angle=TURN * revolutions + estimate.angle,
        speed=estimate.speed,
        angle_deviation=estimate.angle_deviation,
        speed_deviation=estimate.speed_deviation,
        innovation=estimate.innovation,
        innovation_deviation=estimate.innovation_deviation,
        missed_edges=estimate.missed_edges,
        standstill=estimate.standstill,
        slip=slip,
        revolutions=revolutions,
        remainder=estimate.angle,
    )


def relative(memory: EventFilterMemory, elapsed: float, turns: float, wheel: CodeWheel) -> EventFilterMemory:
    """The same memory with all times `elapsed` [s] earlier and all angles `turns` revolutions smaller.

    A belief in doubt that is none, and edges that were never seen, only fill their places and stay.
    """
    m, angle, edges = memory, -TURN * turns, turns * len(wheel.edges)
    doubt, search = m.doubt, m.search
    if doubt.odds > -np.inf:
        doubt = Doubt(
            shift_angle(doubt.belief, angle),
            number=doubt.number - edges,
            odds=doubt.odds,
            slip=doubt.slip,
            edges=doubt.edges,
        )
    return EventFilterMemory(
        time=m.time - elapsed,
        belief=shift_angle(m.belief, angle),
        ripple=m.ripple,
        last=LastEdge(m.last.number - edges, m.last.time - elapsed),
        tally=m.tally,
        manoeuvre=m.manoeuvre,
        search=IndexMemory(
            numbers=search.numbers - edges,
            times=search.times - elapsed,
            evidence=search.evidence,
            turn_start=search.turn_start - edges,
            verdict=search.verdict,
            turns=search.turns,
            found=search.found,
        ),
        doubt=doubt,
        slip=m.slip,
    )
