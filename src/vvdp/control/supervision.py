"""Supervision: residuals at every sample over their limits, and the alarm once one exceeds its limit for too long.

Source  ours, docs/models/faults.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import COUNT, NUMBER, TIME, Count, Time


class AlarmMemory(NamedTuple):
    """Time for which each residual has exceeded its limit [s]; number of the first one that reported, 0 before, and the
    time of its report. An alarm stays."""

    beyond: Annotated[Array, TIME]
    alarm: Count
    time: Time


def alarm_start(count: int) -> AlarmMemory:
    """The memory before the first sample of a number of residuals."""
    return AlarmMemory(np.zeros(count), 0.0, 0.0)


def alarm_step(
    memory: AlarmMemory, time: float, residuals: Array, patience: tuple[float, ...], period: float
) -> AlarmMemory:
    """The memory after a sample. What is not a number is beyond any limit.

    time       of the sample [s]
    residuals  each over its limit: above 1 it is beyond
    patience   for how long each may be beyond [s]
    period     of the samples [s]
    """
    beyond, alarm, told = np.zeros(len(residuals)), memory.alarm, memory.time
    for i in range(len(residuals)):
        if not residuals[i] <= 1.0:
            beyond[i] = memory.beyond[i] + period
        if alarm == 0.0 and beyond[i] > patience[i]:
            alarm, told = i + 1.0, time
    return AlarmMemory(beyond, alarm, told)


class RepeatMemory(NamedTuple):
    """The last readings, and how often each has come again since it changed [1]."""

    last: Annotated[Array, NUMBER]
    repeats: Annotated[Array, COUNT]


def repeat_start(count: int) -> RepeatMemory:
    """The memory before the first sample of a number of readings."""
    return RepeatMemory(np.full(count, -1e300), np.zeros(count))


def repeat_step(memory: RepeatMemory, readings: Array) -> RepeatMemory:
    """The memory after a sample: a sensor with noise that shows the same number again and again is frozen."""
    repeats = np.zeros(len(readings))
    for i in range(len(readings)):
        if readings[i] == memory.last[i]:
            repeats[i] = memory.repeats[i] + 1.0
    return RepeatMemory(readings.copy(), repeats)
