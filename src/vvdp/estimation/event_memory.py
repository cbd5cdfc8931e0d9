"""Memory of the event-based Kalman filter from sample to sample.

Source  ours, docs/models/event-filter.md, where a function names no other.
"""

from typing import NamedTuple

from vvdp.base.kinds import AccelerationDensity, AngularVariance, Count, Fraction, Number, Time
from vvdp.estimation.doubt import Doubt, no_doubt
from vvdp.estimation.event_settings import EventFilter
from vvdp.estimation.index import IndexMemory, index_start
from vvdp.estimation.ripple import Ripple, ripple_start
from vvdp.numerics.kalman import AngleSpeed
from vvdp.sensing.wheel import edge_below

RELIABLE = 0.01
"""Share of irregular edges that is assumed at first [1]."""


class LastEdge(NamedTuple):
    """Number and time of the last edge that was used."""

    number: Number
    time: Time


class Tally(NamedTuple):
    """Counts of edges: `started` is 1 after the first, `associating` once the belief shows their numbers without
    counting.

    `ignored` edges have come since the last used one; `irregular` is the share of edges that were missed or ignored,
    and rests on `watched` edges.
    """

    started: Fraction
    associating: Fraction
    ignored: Count
    missed_edges: Count
    irregular: Fraction
    watched: Count


class Manoeuvre(NamedTuple):
    """Density of the acceleration, and the value to which it falls at first after a manoeuvre, since others follow; the
    sums of innovations that show when the speed changes."""

    density: AccelerationDensity
    unrest: AccelerationDensity
    rise: Number
    fall: Number


class EventFilterMemory(NamedTuple):
    """Memory of the filter from sample to sample: its belief at `time`, and the state of edges and index.

    The belief is about the mean course; `ripple` is the part of the ports. `time` differs from that of the last edge
    where another sensor shows the angle between edges. `slip` is the variance of the angle that no later edge can show:
    the wheel may have turned back while it stood.
    """

    time: Time
    belief: AngleSpeed
    ripple: Ripple
    last: LastEdge
    tally: Tally
    manoeuvre: Manoeuvre
    search: IndexMemory
    doubt: Doubt
    slip: AngularVariance


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
        ripple=ripple_start(settings.ripple_variance),
        last=LastEdge(edge, time),
        tally=new_tally(),
        manoeuvre=Manoeuvre(density=q, unrest=q, rise=0.0, fall=0.0),
        search=index_start(wheel),
        doubt=no_doubt(belief),
        slip=0.0,
    )


def new_tally() -> Tally:
    """The tally before the first edge."""
    return Tally(started=0.0, associating=0.0, ignored=0.0, missed_edges=0.0, irregular=RELIABLE, watched=0.0)
