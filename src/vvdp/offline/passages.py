"""Where in a record of edges the wheel nearly stood still and went on: there it may have turned back."""

import numpy as np

from vvdp.base.arrays import Array

AROUND = 16
"""So many times between edges before and after a passage say how fast the wheel was ..."""
WINDOWS = ((5, 2.2), (2, 3.5))
"""... and it is slow where so many times are so many times as long, on average, as those on either side ..."""
SCATTER = 8.0
"""... and longer by so many of their standard errors: where edges are missed, some times are long by chance."""
SEEN_BEFORE = AROUND + 3
"""Edges before a passage that are looked at, and about as many after it."""
SEEN_AFTER = AROUND + 5


def slow_passages(steps: Array) -> list[int]:
    """Of the times between edges [s] the longest one of each slow passage, in their order.

    None is seen within `SEEN_BEFORE` of the beginning and `SEEN_AFTER` of the end.
    """
    total, squares = (np.concatenate([[0.0], np.cumsum(each)]) for each in (steps, steps * steps))
    slow = np.zeros(steps.size, bool)
    for width, times in WINDOWS:
        begin = np.arange(AROUND, steps.size - AROUND - width + 1)
        if not begin.size:
            continue
        within = (total[begin + width] - total[begin]) / width
        usual = np.zeros(begin.size)
        for side in (begin - AROUND, begin + width):
            mean = (total[side + AROUND] - total[side]) / AROUND
            variance = np.fmax((squares[side + AROUND] - squares[side]) / AROUND - mean * mean, 0.0)
            usual = np.fmax(usual, np.fmax(times * mean, mean + SCATTER * np.sqrt(variance / width)))
        for first in begin[within > usual].tolist():
            slow[first : first + width] = True
    ends = np.flatnonzero(np.diff(np.concatenate([[0], slow.astype(int), [0]])))
    return [int(first + np.argmax(steps[first:end])) for first, end in zip(ends[::2], ends[1::2], strict=True)]
