"""The M/T method: angle over time in a window that begins and ends on edges.

The edges are only counted: see `counting`. Derived in docs/models/simple-estimators.md.
"""

from typing import NamedTuple

from vvdp.base.kinds import Speed, Time
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
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


class MOverT(Params):
    """M/T method with windows that last `window` and then until the next edge."""

    wheel: CodeWheel
    window: Time

    def check(self) -> None:
        require_positive(self, "window")


def m_over_t(wheel: CodeWheel, window: float = 0.02) -> MOverT:
    """Settings with a window of 20 ms, about half a turn at 25 Hz.

    Source  ours, docs/models/simple-estimators.md
    """
    return MOverT(wheel=wheel, window=window)


class MOverTMemory(NamedTuple):
    """The count now and where the window began, and the speed over the last window (that of the start before)."""

    last: LastEdge
    opened: LastEdge
    speed: Speed


def m_over_t_start(settings: MOverT, time: float, angle: float, speed: float) -> MOverTMemory:
    """The memory before the first sample, of a shaft that is believed to be at `angle` [rad] with `speed` [rad/s]."""
    last = count_start(time, angle, settings.wheel)
    return MOverTMemory(last, last, speed)


def m_over_t_step(memory: MOverTMemory, reading: Reading, settings: MOverT) -> tuple[MOverTMemory, Estimate]:
    """The estimate at a sample: omega = pulses / time of the last window as an angle, theta from the last edge.

    A window begins at the edge that ended the one before, and ends at the first edge after its length. When the next
    edge is overdue the speed shown falls as sector / (time since the last edge).

    Source  ohmae1982, where the window begins on an edge too; ours, docs/models/simple-estimators.md
    """
    last = update_count(memory.last, reading, settings.wheel)
    opened, speed = memory.opened, memory.speed
    if reading.edges > 0.0:
        if opened.found == 0.0:
            opened = last
        elif last.time - opened.time >= settings.window:
            speed = (last.angle - opened.angle) / (last.time - opened.time)
            opened = last
    shown = overdue_speed(speed, last, reading.time, settings.wheel)
    angle = carried_angle(shown, last, reading.time, settings.wheel)
    return MOverTMemory(last, opened, speed), plain_estimate(angle, shown)


def m_over_t_estimator(settings: MOverT, time: float = 0.0, angle: float = 0.0, speed: float = 0.0) -> Estimator:
    """The estimator, ready to run from `time` [s], `angle` [rad] and `speed` [rad/s]."""
    title = f"M/T, {1e3 * settings.window:g} ms"
    return Estimator(title, m_over_t_step, m_over_t_start(settings, time, angle, speed), settings)
