"""The event-based Kalman filter with numbers that stay small however long it runs, so that single precision is enough.

Nothing in the filter depends on when time begins, nor on whole revolutions: it gives the same estimate if all times
move by one amount, or all angles by whole revolutions. So at each sample with edges all times are made relative to it,
and whole revolutions are taken out of all angles. Derived in docs/models/event-filter.md, "Single precision".

Source  ours, docs/models/event-filter.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import Count, Number, Time
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


def bounded_start(settings: EventFilter) -> BoundedMemory:
    """Memory before the first sample: nothing is known but the wheel."""
    return BoundedMemory(filter=event_filter_start(settings, 0.0, 0.0, 0.0), since=0.0, lost=0.0, revolutions=0.0)


def bounded_step(memory: BoundedMemory, reading: PassedEdges, settings: EventFilter) -> tuple[BoundedMemory, Estimate]:
    """Memory and estimate after a sample; the estimate is without the whole revolutions of the memory.

    The time since an edge is a sum of thousands of intervals in single precision, hence compensated.

    Source  kahan1965
    """
    before, revolutions, r, wheel = memory.filter, memory.revolutions, reading, settings.wheel
    added = r.elapsed - memory.lost
    since = memory.since + added
    lost = (since - memory.since) - added
    if r.edges > 0.0:
        turns = np.floor(before.last.number / len(wheel.edges))
        before = relative(before, since, turns, wheel)
        since, revolutions = 0.0, revolutions + turns
    seen = Reading(since, r.edges, since - r.edge_age, r.edge_interval, r.polarity)
    after, estimate = event_filter_step(before, seen, settings)
    return BoundedMemory(filter=after, since=since, lost=lost, revolutions=revolutions), estimate


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
