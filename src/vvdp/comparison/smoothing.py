"""The smoother among the estimators: the event filter shows which edges passed, all of them count for every instant.

It sees the future, so it is no rival but the mark: what the best use of the same edges would give.
"""

from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import Angle, AngularVariance, Time
from vvdp.base.params import Params
from vvdp.comparison.scores import Traces
from vvdp.estimation.event_filter import after_edge
from vvdp.estimation.event_memory import EventFilterMemory
from vvdp.estimation.event_settings import EventFilter
from vvdp.estimation.expected_edge import edge_angle_variance
from vvdp.estimation.smoother import Step, smooth_edges, smoothed_at
from vvdp.numerics.kalman import AngleSpeed
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import edge_angle
from vvdp.simulation.replay import Replay


class UsedEdge(NamedTuple):
    """The edge that the event filter used last: when, its unwrapped angle, the variance of that; `used` 1 if now."""

    time: Time
    angle: Angle
    variance: AngularVariance
    used: float


def used_edge_step(
    memory: EventFilterMemory, reading: Reading, settings: EventFilter
) -> tuple[EventFilterMemory, UsedEdge]:
    """A sample of the event filter, and the edge that it used; what is believed between edges is left out.

    Source  ours, docs/models/smoother.md
    """
    used = 0.0
    if reading.edges > 0.0:
        memory, _, deviation = after_edge(memory, reading, settings)
        used = 1.0 if deviation > 0.0 else 0.0
    variance = edge_angle_variance(memory.belief.speed, reading.edge_interval, settings)
    return memory, UsedEdge(memory.time, edge_angle(memory.last.number, settings.wheel), variance, used)


def smoothed_traces(time: Array, shown: Array, settings: EventFilter) -> Traces:
    """Smoothed angle and speed at `time` [s], from what `used_edge_step` has shown, shape (samples, 4).

    All NaN with fewer than two edges. There are no innovations: nothing is predicted.
    """
    times, angles, variances, _ = shown[shown[:, 3] > 0.0].T
    unknown = np.full(time.size, np.nan)
    if times.size < 2:
        return Traces(**dict.fromkeys(Traces._fields, unknown))
    mean_speed = float((angles[-1] - angles[0]) / (times[-1] - times[0]))
    prior = AngleSpeed(float(angles[0]), mean_speed, settings.angle_variance, 0.0, settings.speed_variance)
    motion = smooth_edges(times, angles, variances, settings.acceleration_density, prior, run_compiled)
    there = smoothed_at(time, motion, run_compiled)
    return Traces(
        angle=there.angle,
        speed=there.speed,
        innovation=unknown,
        innovation_deviation=unknown,
        angle_deviation=np.sqrt(there.angle_variance),
        speed_deviation=np.sqrt(there.speed_variance),
    )


def run_compiled(step: Step, memory: Any, row: Any, settings: Params, rows: Array) -> tuple[Any, Array]:
    """A step of the smoother taken over rows, compiled once in each process: the memory reached, and what was shown."""
    if step not in _compiled:
        _compiled[step] = Replay(step, memory, row, settings)
    replayed = _compiled[step](memory, rows, settings)
    return replayed.memory, replayed.shown


_compiled: dict[Step, Replay] = {}
