"""Means of sampled signals over the last period of the PWM, whose length is no whole number of samples.

Between two samples a signal is taken as a line, also where the window begins, so that a ramp is reported exactly half a
window late. The samples lie in a ring of bounded length.

Source  ours, docs/models/displacement-control.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import NUMBER, Count
from vvdp.base.select import clip, maximum, minimum

LONGEST = 64
"""Longest window in samples."""
ROWS = LONGEST + 2


class AverageMemory(NamedTuple):
    """The last samples, a row each (`ROWS`, signals), where the newest lies, and how many are filled."""

    samples: Annotated[Array, NUMBER]
    newest: Count
    filled: Count


def average_start(signals: int) -> AverageMemory:
    """The memory before the first sample of a number of signals."""
    return AverageMemory(np.zeros((ROWS, signals)), 0.0, 0.0)


def pwm_window(spool_speed: float, sections: float, sample_period: float) -> float:
    """One period of the PWM in samples, 2 pi/(N w h) [1]; `LONGEST` where the spool hardly turns.

    spool_speed    w, either way [rad/s]
    sections       N of the spool [1]
    sample_period  h [s]
    """
    turned = abs(spool_speed) * sections * sample_period
    return clip(2.0 * np.pi / maximum(turned, 1e-9), 1.0, float(LONGEST))


def average_step(memory: AverageMemory, values: Array, window: float) -> tuple[AverageMemory, Array]:
    """Memory and means after a sample; before a window is full, over what there is of it.

    values  of the signals now (signals)
    window  in samples, up to `LONGEST` [1]
    """
    rows, signals = memory.samples.shape
    at = (int(memory.newest) + 1) % rows
    samples = memory.samples.copy()
    samples[at] = values
    count = min(int(memory.filled) + 1, rows)
    width = minimum(window, count - 1.0)
    means = values.copy()
    if width > 0.0:
        whole = min(int(width), count - 2)
        rest = width - whole
        for j in range(signals):
            total = 0.0
            for k in range(whole):
                total += 0.5 * (samples[(at - k) % rows, j] + samples[(at - k - 1) % rows, j])
            near, far = samples[(at - whole) % rows, j], samples[(at - whole - 1) % rows, j]
            means[j] = (total + rest * (near + 0.5 * rest * (far - near))) / width
    return AverageMemory(samples, float(at), float(count)), means
