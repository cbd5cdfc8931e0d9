"""A tracking loop of second order (PLL) that follows the count.

The edges are only counted: see `counting`. Derived in docs/models/simple-estimators.md.

Source  ours, docs/models/simple-estimators.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.kinds import Angle, Kind, Speed, Time
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.estimation.association import sector
from vvdp.estimation.baselines.counting import LastEdge, count_start, plain_estimate, update_count
from vvdp.estimation.estimator import Estimate, Estimator
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import CodeWheel, edge_angle, edge_below

Bandwidth = Annotated[float, Kind("bandwidth", "rad/s", 0.0, 1e5, "50 rad/s")]


class TrackingLoop(Params):
    """Critically damped tracking loop whose double pole is at -`bandwidth`."""

    wheel: CodeWheel
    bandwidth: Bandwidth

    def check(self) -> None:
        require_positive(self, "bandwidth")


def tracking_loop(wheel: CodeWheel, bandwidth: float = 50.0) -> TrackingLoop:
    """Settings with a bandwidth of 50 rad/s, above the spool's own (1 / 28 ms), far below the edges' (2 pi 200/s)."""
    return TrackingLoop(wheel=wheel, bandwidth=bandwidth)


class Tracked(NamedTuple):
    """Angle and speed that the loop has reached."""

    angle: Angle
    speed: Speed


class TrackingLoopMemory(NamedTuple):
    """The count, and the state of the loop at `time`."""

    last: LastEdge
    time: Time
    reached: Tracked


def correct(predicted: Tracked, error: float, duration: float, bandwidth: float) -> Tracked:
    """State of the loop after a correction: the angle is measured `error` [rad] above the one predicted over `duration`
    [s].

    theta = theta' + (1 - z^2) e, omega = omega' + (1 - z)^2 e / h, z = exp(-b h): both poles are at z, where those of
    theta^ = omega^ + 2 b e, omega^ = b^2 e lie after h, so that it is stable and critically damped whatever b h.

    bandwidth  b [rad/s]
    """
    z = np.exp(-bandwidth * duration)
    return Tracked(predicted.angle + (1.0 - z * z) * error, predicted.speed + (1.0 - z) * (1.0 - z) * error / duration)


def tracking_loop_start(settings: TrackingLoop, time: float, angle: float, speed: float) -> TrackingLoopMemory:
    """The memory before the first sample, of a shaft that is believed to be at `angle` [rad] with `speed` [rad/s]."""
    return TrackingLoopMemory(count_start(time, angle, settings.wheel), time, Tracked(angle, speed))


def tracking_loop_step(
    memory: TrackingLoopMemory, reading: Reading, settings: TrackingLoop
) -> tuple[TrackingLoopMemory, Estimate]:
    """The estimate at a sample. The error is counted too: edges passed less edges that the loop believes passed.

    So there is none as long as the loop is in the right sector. Below half of what one sector's error does to the speed
    in a step the speed is taken as 0, so that a shaft at rest is shown at rest. Times of edges are not used.

    Source  ours, docs/models/simple-estimators.md, after the firmware of ODrive Robotics (encoder.cpp)
    """
    wheel = settings.wheel
    last = update_count(memory.last, reading, wheel)
    h = reading.time - memory.time
    if h <= 0.0:
        reached = memory.reached
        return TrackingLoopMemory(last, memory.time, reached), plain_estimate(reached.angle, reached.speed)
    predicted = Tracked(memory.reached.angle + h * memory.reached.speed, memory.reached.speed)
    error = edge_angle(last.number, wheel) - edge_angle(edge_below(predicted.angle, wheel), wheel)
    reached = correct(predicted, error, h, settings.bandwidth)
    smallest = correct(Tracked(0.0, 0.0), 0.5 * sector(wheel), h, settings.bandwidth).speed
    if abs(reached.speed) < smallest:
        reached = Tracked(reached.angle, 0.0)
    return TrackingLoopMemory(last, reading.time, reached), plain_estimate(reached.angle, reached.speed)


def tracking_loop_estimator(
    settings: TrackingLoop, time: float = 0.0, angle: float = 0.0, speed: float = 0.0
) -> Estimator:
    """The estimator, ready to run from `time` [s], `angle` [rad] and `speed` [rad/s]."""
    title = f"tracking loop, {settings.bandwidth:g} rad/s"
    return Estimator(title, tracking_loop_step, tracking_loop_start(settings, time, angle, speed), settings)
