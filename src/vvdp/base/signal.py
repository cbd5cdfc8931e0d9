"""A value that a user prescribes over time: constant, step, ramp, sine, table, or a sum of them.

Every form is stored as one: a base value, changes that each take some time, and sines. A constant therefore costs
nothing in the compiled loop, and the instants at which a signal has a corner are known in advance.
"""

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vvdp.base.select import clip, select


@dataclass(frozen=True)
class Signal:
    """`base + sum(change * progress) + sum(amplitude * sin(2 pi frequency t + phase))`, times in s, phases in rad."""

    base: float
    start: tuple[float, ...] = ()
    duration: tuple[float, ...] = ()
    change: tuple[float, ...] = ()
    amplitude: tuple[float, ...] = ()
    frequency: tuple[float, ...] = ()
    phase: tuple[float, ...] = ()

    @property
    def extremes(self) -> tuple[float, float]:
        """Bounds of the value: exact without sines, safe with them."""
        corners = [value for ends in self._stretches() for value in ends]
        return min(corners) - self._swing, max(corners) + self._swing

    def may_be(self, value: float) -> bool:
        """Whether the signal takes a value at some time; a jump skips the values between its ends."""
        return any(min(ends) - self._swing <= value <= max(ends) + self._swing for ends in self._stretches())

    @property
    def _swing(self) -> float:
        return math.fsum(abs(a) for a in self.amplitude)

    def _stretches(self) -> Iterator[tuple[float, float]]:
        """First and last value, without sines, of each stretch between two times at which the signal jumps or bends."""
        changes = list(zip(self.start, self.duration, self.change, strict=True))
        first = self.base
        for t in sorted({end for a, d, _ in changes for end in (a, a + d)}):
            gone = [c * (1.0 if t >= a + d else max(0.0, (t - a) / d) if d > 0.0 else 0.0) for a, d, c in changes]
            jumps = [c for a, d, c in changes if d == 0.0 and a == t]
            yield first, self.base + sum(gone) - sum(jumps)
            first = self.base + sum(gone)
        yield first, first

    @property
    def is_constant(self) -> bool:
        """Whether the value never changes."""
        return not any(self.change) and not any(self.amplitude)

    def is_constant_within(self, begin: float, end: float) -> bool:
        """Whether the value does not change between two times [s]; a jump at either is one."""
        changes = zip(self.start, self.duration, self.change, strict=True)
        return not any(self.amplitude) and not any(c and a <= end and a + d >= begin for a, d, c in changes)


def map_signal(signal: Signal, function: Callable[[float], float]) -> Signal:
    """The signal with a linear `function` of its values, which is 0 at 0."""
    s = signal
    return replace(
        s, base=function(s.base), change=tuple(map(function, s.change)), amplitude=tuple(map(function, s.amplitude))
    )


def constant(value: float) -> Signal:
    """A signal that always has `value`."""
    return Signal(float(value))


def step(before: float, after: float, at: float) -> Signal:
    """A signal that jumps from `before` to `after` at time `at` [s]."""
    return Signal(float(before), (float(at),), (0.0,), (float(after) - float(before),))


def ramp(before: float, after: float, begin: float, end: float) -> Signal:
    """A signal that goes in a straight line from `before` at time `begin` [s] to `after` at time `end` [s]."""
    return Signal(float(before), (float(begin),), (float(end) - float(begin),), (float(after) - float(before),))


def pulse(before: float, during: float, begin: float, end: float) -> Signal:
    """A signal that is `during` from `begin` to `end` [s], and `before` else."""
    rise = float(during) - float(before)
    return Signal(float(before), (float(begin), float(end)), (0.0, 0.0), (rise, -rise))


def sine(mean: float, amplitude: float, frequency: float, phase: float = 0.0) -> Signal:
    """A signal `mean + amplitude sin(2 pi frequency t + phase)`, `frequency` in Hz and `phase` in rad."""
    return Signal(float(mean), amplitude=(float(amplitude),), frequency=(float(frequency),), phase=(float(phase),))


def table(times: Sequence[float], values: Sequence[float]) -> Signal:
    """Straight lines through points (`times` [s], increasing, and `values`), held before the first and after the last.

    Two points at the same time make a jump. Raises ValueError when the times go backwards.
    """
    if len(times) != len(values) or not len(times):
        raise ValueError(f"{len(times)} times and {len(values)} values; expected the same number, at least one")
    pairs = list(itertools.pairwise(zip(map(float, times), map(float, values), strict=True)))
    if any(t1 < t0 for (t0, _), (t1, _) in pairs):
        raise ValueError("the times of a table must not go backwards")
    kept = [(t0, t1 - t0, v1 - v0) for (t0, v0), (t1, v1) in pairs if v1 != v0]
    starts, durations, changes = zip(*kept, strict=True) if kept else ((), (), ())
    return Signal(float(values[0]), start=starts, duration=durations, change=changes)


def signal_value(t: float, signal: Signal) -> float:
    """Value of `signal` at time `t` [s]; at a jump, the value after it."""
    changed = changes_value(t, signal.start, signal.duration, signal.change)
    return signal.base + changed + sines_value(t, signal.amplitude, signal.frequency, signal.phase)


def changes_value(t: float, start: tuple[float, ...], duration: tuple[float, ...], change: tuple[float, ...]) -> float:
    """Sum of what the changes of a signal have come to at time `t` [s]."""
    value = 0.0
    for i in range(len(start)):
        progress = clip((t - start[i]) / (duration[i] + select(duration[i] > 0.0, 0.0, 1.0)), 0.0, 1.0)
        value = value + change[i] * select(duration[i] > 0.0, progress, select(t >= start[i], 1.0, 0.0))
    return value


def sines_value(
    t: float, amplitude: tuple[float, ...], frequency: tuple[float, ...], phase: tuple[float, ...]
) -> float:
    """Sum of the sines of a signal at time `t` [s]."""
    value = 0.0
    for i in range(len(amplitude)):
        value = value + amplitude[i] * np.sin(2.0 * np.pi * frequency[i] * t + phase[i])
    return value


def signal_stop(t: float, signal: Signal) -> float:
    """The next time [s] after `t` at which `signal` jumps or has a corner; infinity when there is none."""
    return changes_stop(t, signal.start, signal.duration)


def changes_stop(t: float, start: tuple[float, ...], duration: tuple[float, ...]) -> float:
    """The next time [s] after `t` at which a change begins or ends; infinity when there is none."""
    stop = np.inf
    for i in range(len(start)):
        begin, end = start[i], start[i] + duration[i]
        stop = select((begin > t) & (begin < stop), begin, stop)
        stop = select((end > t) & (end < stop), end, stop)
    return stop
