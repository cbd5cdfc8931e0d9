"""Speed as the angle counted in a window of fixed length.

The edges are only counted: see `counting`. Derived in docs/models/simple-estimators.md.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import Count, Speed
from vvdp.base.params import Params
from vvdp.base.rules import refuse
from vvdp.estimation.baselines.counting import (
    LastEdge,
    carried_angle,
    count_start,
    overdue_speed,
    plain_estimate,
    update_count,
)
from vvdp.estimation.estimator import Estimate, Estimator
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import CodeWheel


class FiniteDifference(Params):
    """Finite difference over the last `window` samples."""

    wheel: CodeWheel
    window: Count

    def check(self) -> None:
        if self.window < 1.0 or self.window % 1.0:
            refuse(self, "window", "must be a whole number of at least 1")


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
    last = update_count(memory.last, reading, settings.wheel)
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
