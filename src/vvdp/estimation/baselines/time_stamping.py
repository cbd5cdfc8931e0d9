"""A polynomial through the last time-stamped edges, carried on to the sample.

The edges are only counted: see `counting`. Derived in docs/models/simple-estimators.md.

Source  ours, docs/models/simple-estimators.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import Count
from vvdp.base.params import Params
from vvdp.base.rules import refuse
from vvdp.base.select import clip, maximum, minimum
from vvdp.estimation.baselines.counting import LastEdge, count_start, overdue_speed, plain_estimate, update_count
from vvdp.estimation.estimator import Estimate, Estimator
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import CodeWheel, edge_angle


class TimeStamping(Params):
    """A polynomial of degree `order` fitted to the last `edges` edges."""

    wheel: CodeWheel
    edges: Count
    order: Count

    def check(self) -> None:
        if not 1.0 <= self.order <= 5.0 or self.order % 1.0:
            refuse(self, "order", "must be a whole number from 1 to 5")
        if self.edges < self.order + 1.0 or self.edges % 1.0:
            refuse(self, "edges", f"must be a whole number of at least {self.order + 1.0:g}, order + 1")


def time_stamping(wheel: CodeWheel, edges: float | None = None, order: float = 1.0) -> TimeStamping:
    """Settings with a straight line through the edges of one turn."""
    return TimeStamping(wheel=wheel, edges=float(len(wheel.edges)) if edges is None else edges, order=order)


class TimeStampingMemory(NamedTuple):
    """The count, the last stamped edges (newest first), how many of them there are, and the polynomial through them.

    The polynomial is angle = sum of coefficients[k] (time - time of the count)^k.
    """

    last: LastEdge
    times: Array
    angles: Array
    known: Count
    coefficients: Array


def time_stamping_start(settings: TimeStamping, time: float, angle: float, speed: float) -> TimeStampingMemory:
    """The memory before the first sample, of a shaft that is believed to be at `angle` [rad] with `speed` [rad/s]."""
    n = int(settings.edges)
    coefficients = np.zeros(int(settings.order) + 1)
    coefficients[0], coefficients[1] = angle, speed
    return TimeStampingMemory(count_start(time, angle, settings.wheel), np.zeros(n), np.zeros(n), 0.0, coefficients)


def fitted_polynomial(times: Array, values: Array, size: int) -> Array:
    """Coefficients c_k, shape (size,), of the least-squares polynomial sum c_k (t - times[0])^k, c_k in 1/s^k.

    Its degree is size - 1, or less where there are not enough points; `times` are different ones. By polynomials that
    are orthogonal over the points, from their recurrence, so that no ill-conditioned equations are solved.

    Source  forsythe1957
    """
    n, span = times.size, times.max() - times.min()
    here, here_before = np.ones(n), np.zeros(n)  # the orthogonal polynomial of degree k at the points, and the last one
    p, p_before = np.zeros(size + 1), np.zeros(size + 1)  # and their coefficients
    fitted = np.zeros(size)
    p[0], norm_before = 1.0, 0.0
    for k in range(min(size, n)):
        norm, a, share = 0.0, 0.0, 0.0
        for i in range(n):
            square = here[i] * here[i]
            norm += square
            a += square * (times[i] - times[0]) / span
            share += here[i] * (values[i] - values[0])
        a, share = a / norm, share / norm
        b = norm / norm_before if k > 0 else 0.0
        for i in range(n):
            here[i], here_before[i] = ((times[i] - times[0]) / span - a) * here[i] - b * here_before[i], here[i]
        below, norm_before = 0.0, norm
        for i in range(k + 1):
            fitted[i] += share * p[i]
        for i in range(k + 2):
            same = p[i]
            p[i], p_before[i] = below - a * same - b * p_before[i], same
            below = same
    scale = 1.0
    for i in range(size):
        fitted[i] *= scale
        scale /= span
    fitted[0] += values[0]
    return fitted


def polynomial(coefficients: Array, x: float) -> tuple[float, float]:
    """Value and derivative of sum c_k x^k."""
    value, slope = 0.0, 0.0
    for k in range(coefficients.size - 1, -1, -1):
        slope = slope * x + value
        value = value * x + coefficients[k]
    return value, slope


def time_stamping_step(
    memory: TimeStampingMemory, reading: Reading, settings: TimeStamping
) -> tuple[TimeStampingMemory, Estimate]:
    """The estimate at a sample: the polynomial and its derivative there.

    It is fitted again at each edge, with the degree m that the edges known so far allow. The angle stays within the
    sector that is counted, the speed between 0 and m sector / (time since the last edge), which a steady acceleration
    from any speed keeps: nothing runs away without edges.

    Source  merry2010; the bound of the speed is ours, docs/models/simple-estimators.md
    """
    wheel, before = settings.wheel, memory.last
    last = update_count(before, reading, wheel)
    times, angles, known, coefficients = memory.times, memory.angles, memory.known, memory.coefficients
    if reading.edges > 0.0 and (known == 0.0 or last.time > before.time):
        times, angles = times.copy(), angles.copy()
        for i in range(times.size - 1, 0, -1):
            times[i], angles[i] = times[i - 1], angles[i - 1]
        times[0], angles[0] = last.time, last.angle
        known = minimum(known + 1.0, 1.0 * times.size)
        if known > 1.0:
            coefficients = fitted_polynomial(times[: int(known)], angles[: int(known)], coefficients.size)
        else:
            coefficients = coefficients.copy()
            coefficients[0] = last.angle
    angle, speed = polynomial(coefficients, reading.time - last.time)
    low, high = edge_angle(last.number, wheel), edge_angle(last.number + 1.0, wheel)
    m = settings.order
    shown = m * overdue_speed(maximum(speed, 0.0) / m, last, reading.time, wheel)
    memory = TimeStampingMemory(last, times, angles, known, coefficients)
    return memory, plain_estimate(clip(angle, low, high), shown)


def time_stamping_estimator(
    settings: TimeStamping, time: float = 0.0, angle: float = 0.0, speed: float = 0.0
) -> Estimator:
    """The estimator, ready to run from `time` [s], `angle` [rad] and `speed` [rad/s]."""
    title = f"time stamping, order {settings.order:g} through {settings.edges:g} edges"
    return Estimator(title, time_stamping_step, time_stamping_start(settings, time, angle, speed), settings)
