"""Counting of edges, the basis of every simple estimator.

The simple estimators have no model of the shaft. They count edges forward from their assumed start, so an edge
that was missed is not detected and leaves them a sector behind for good; deviations are unknown (NaN), `missed_edges`
stays 0. Derived and compared in docs/models/simple-estimators.md.

Source  ours, docs/models/simple-estimators.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import Angle, Count, Time
from vvdp.base.select import clip
from vvdp.estimation.association import first_edge
from vvdp.estimation.estimator import Estimate
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import CodeWheel, edge_angle, edge_below, edge_polarity


class LastEdge(NamedTuple):
    """The last edge passed, as far as counting shows; before the first one, the place and time of the start."""

    number: Count
    angle: Angle
    time: Time
    interval: Time
    """Length of the interval, with `time` in the middle, in which it happened."""
    found: float
    """1 once an edge has come, 0 before."""


def count_start(time: float, angle: float, wheel: CodeWheel) -> LastEdge:
    """The count of a shaft that is believed to be at `angle` [rad] at `time` [s]."""
    return LastEdge(edge_below(angle, wheel), angle, time, 0.0, 0.0)


def update_count(last: LastEdge, reading: Reading, wheel: CodeWheel) -> LastEdge:
    """The count after a sample; edges are only counted, from where the start has put them.

    Where the first edge has not the polarity that the start foretold, it is the `first_edge` that has.
    """
    if reading.edges == 0.0:
        return last
    number = last.number + reading.edges
    if last.found == 0.0 and reading.polarity * edge_polarity(number) < 0.0:
        number = first_edge(last.angle, reading.polarity, wheel)
    return LastEdge(number, edge_angle(number, wheel), reading.edge_time, reading.edge_interval, 1.0)


def overdue_speed(speed: float, last: LastEdge, time: float, wheel: CodeWheel) -> float:
    """`speed`, or its highest possible value since the next edge has not come yet [rad/s]: sector / time since the
    last.

    The time that has passed for certain counts, from the end of the interval in which the last edge happened.

    time  now [s]
    """
    passed = time - last.time - 0.5 * last.interval
    sector = edge_angle(last.number + 1.0, wheel) - edge_angle(last.number, wheel)
    if speed * passed > sector:
        return sector / passed
    return speed


def carried_angle(speed: float, last: LastEdge, time: float, wheel: CodeWheel) -> float:
    """The angle [rad] at `time`, from that of the last edge at `speed` [rad/s], within the sector that is counted."""
    low, high = edge_angle(last.number, wheel), edge_angle(last.number + 1.0, wheel)
    return clip(last.angle + speed * (time - last.time), low, high)


def plain_estimate(angle: float, speed: float) -> Estimate:
    """An estimate without deviations and without innovation."""
    return Estimate(
        angle=angle,
        speed=speed,
        angle_deviation=np.nan,
        speed_deviation=np.nan,
        innovation=0.0,
        innovation_deviation=0.0,
        missed_edges=0.0,
        standstill=np.nan,
    )
