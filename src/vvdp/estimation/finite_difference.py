"""Speed as the angle counted in a window of fixed length; and the counting that every simple estimator rests on.

The simple estimators have no model of the shaft. They count edges forward from where they believe to start, so an edge
that was missed is not detected and leaves them a sector behind for good; deviations are unknown (NaN), `missed_edges`
stays 0. Derived and compared in docs/models/simple-estimators.md.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ParameterError
from vvdp.base.kinds import Angle, Count, Speed, Time
from vvdp.base.params import Params
from vvdp.base.select import clip
from vvdp.estimation.association import first_edge
from vvdp.estimation.estimator import Estimate, Estimator
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import CodeWheel, edge_angle, edge_below, edge_polarity


class LastEdge(NamedTuple):
    """The last edge passed, as far as counting tells; before the first one, the place and time of the start."""

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


def counted(last: LastEdge, reading: Reading, wheel: CodeWheel) -> LastEdge:
    """The count after a sample; edges are only counted, from where the start has put them.

    Where the first edge has not the polarity that the start foretold, it is the `first_edge` that has.

    Source  ours, docs/models/simple-estimators.md
    """
    if reading.edges == 0.0:
        return last
    number = last.number + reading.edges
    if last.found == 0.0 and reading.polarity * edge_polarity(number) < 0.0:
        number = first_edge(last.angle, reading.polarity, wheel)
    return LastEdge(number, edge_angle(number, wheel), reading.edge_time, reading.edge_interval, 1.0)


def overdue_speed(speed: float, last: LastEdge, time: float, wheel: CodeWheel) -> float:
    """`speed`, or what it can be at most since the next edge has not come yet [rad/s]: sector / time since the last.

    The time that has passed for certain counts, from the end of the interval in which the last edge happened.

    time  now [s]

    Source  ours, docs/models/simple-estimators.md
    """
    passed = time - last.time - 0.5 * last.interval
    sector = edge_angle(last.number + 1.0, wheel) - edge_angle(last.number, wheel)
    if speed * passed > sector:
        return sector / passed
    return speed


def carried_angle(speed: float, last: LastEdge, time: float, wheel: CodeWheel) -> float:
    """The angle [rad] at `time`, from that of the last edge at `speed` [rad/s], within the sector that is counted.

    Source  ours, docs/models/simple-estimators.md
    """
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
    )


class FiniteDifference(Params):
    """Finite difference over the last `window` samples."""

    wheel: CodeWheel
    window: Count

    def check(self) -> None:
        if self.window < 1.0 or self.window % 1.0:
            raise ParameterError(f"a window of {self.window:g} samples; expected a whole number from 1")


def finite_difference(wheel: CodeWheel, window: float = 20.0) -> FiniteDifference:
    """Settings with the usual window, 20 samples: 20 ms at 1 kHz.

    Source  ours, docs/models/simple-estimators.md
    """
    return FiniteDifference(wheel=wheel, window=window)


class FiniteDifferenceMemory(NamedTuple):
    """The count now and at the last samples since the first edge, in a ring; the speed to show until it is full."""

    last: LastEdge
    samples: Count
    times: Array
    angles: Array
    speed: Speed


def finite_difference_start(
    settings: FiniteDifference, time: float, angle: float, speed: float
) -> FiniteDifferenceMemory:
    """The memory before the first sample, of a shaft that is believed to be at `angle` [rad] with `speed` [rad/s]."""
    n = int(settings.window)
    return FiniteDifferenceMemory(count_start(time, angle, settings.wheel), 0.0, np.zeros(n), np.zeros(n), speed)


def finite_difference_step(
    memory: FiniteDifferenceMemory, reading: Reading, settings: FiniteDifference
) -> tuple[FiniteDifferenceMemory, Estimate]:
    """The estimate at a sample: omega = (count now - count a window ago) / window, theta = last edge + omega (t - tau).

    Counts are taken as angles of their edges, so that unequal sectors have their true widths. Until a window has passed
    since the first edge, the speed of the start is shown, bounded by `overdue_speed`.

    Source  wang2017, section 3.1; ours, docs/models/simple-estimators.md
    """
    last = counted(memory.last, reading, settings.wheel)
    n = memory.times.size
    place = int(memory.samples % n)
    speed = memory.speed
    if memory.samples >= n:
        speed = (last.angle - memory.angles[place]) / (reading.time - memory.times[place])
    else:
        speed = overdue_speed(speed, last, reading.time, settings.wheel)
    samples, times, angles = memory.samples, memory.times, memory.angles
    if last.found > 0.0:
        samples, times, angles = samples + 1.0, times.copy(), angles.copy()
        times[place], angles[place] = reading.time, last.angle
    angle = carried_angle(speed, last, reading.time, settings.wheel)
    return FiniteDifferenceMemory(last, samples, times, angles, memory.speed), plain_estimate(angle, speed)


def finite_difference_estimator(
    settings: FiniteDifference, time: float = 0.0, angle: float = 0.0, speed: float = 0.0
) -> Estimator:
    """The estimator, ready to run from `time` [s], `angle` [rad] and `speed` [rad/s]."""
    memory = finite_difference_start(settings, time, angle, speed)
    title = f"finite difference, {settings.window:g} samples"
    return Estimator(title, finite_difference_step, memory, settings)
