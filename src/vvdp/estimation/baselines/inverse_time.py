"""Speed as the angle of a sector over the time between its edges.

The edges are only counted: see `counting`. Derived in docs/models/simple-estimators.md.
"""

from typing import NamedTuple

from vvdp.base.kinds import Speed
from vvdp.base.params import Params
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


class InverseTime(Params):
    """Inverse time between successive edges; nothing to tune."""

    wheel: CodeWheel


def inverse_time(wheel: CodeWheel) -> InverseTime:
    """Settings for a wheel.

    Source  ours, docs/models/simple-estimators.md
    """
    return InverseTime(wheel=wheel)


class InverseTimeMemory(NamedTuple):
    """The count, and the speed between the last two edges (that of the start before there are two)."""

    last: LastEdge
    speed: Speed


def inverse_time_start(settings: InverseTime, time: float, angle: float, speed: float) -> InverseTimeMemory:
    """The memory before the first sample, of a shaft that is believed to be at `angle` [rad] with `speed` [rad/s]."""
    return InverseTimeMemory(count_start(time, angle, settings.wheel), speed)


def inverse_time_step(
    memory: InverseTimeMemory, reading: Reading, settings: InverseTime
) -> tuple[InverseTimeMemory, Estimate]:
    """The estimate at a sample: omega = angle between the last two edges / time between, theta from the last edge.

    Unequal sectors have their true widths, as far as the count has found them by the polarity of the first edge. When
    the next edge is overdue the speed shown falls as sector / (time since the last edge).

    Source  wang2017, section 3.1; ours, docs/models/simple-estimators.md
    """
    before = memory.last
    last = update_count(before, reading, settings.wheel)
    speed = memory.speed
    if reading.edges > 0.0 and before.found > 0.0 and last.time > before.time:
        speed = (last.angle - before.angle) / (last.time - before.time)
    shown = overdue_speed(speed, last, reading.time, settings.wheel)
    angle = carried_angle(shown, last, reading.time, settings.wheel)
    return InverseTimeMemory(last, speed), plain_estimate(angle, shown)


def inverse_time_estimator(
    settings: InverseTime, time: float = 0.0, angle: float = 0.0, speed: float = 0.0
) -> Estimator:
    """The estimator, ready to run from `time` [s], `angle` [rad] and `speed` [rad/s]."""
    return Estimator("inverse time", inverse_time_step, inverse_time_start(settings, time, angle, speed), settings)
