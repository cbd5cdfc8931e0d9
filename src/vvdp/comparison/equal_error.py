"""A circuit brought to a given tracking error by one value: the delay of its loop's reference.

The four poles of the filter before a loop delay the reference by L = 4/w. Errors are those against one common
reference, so a circuit that receives it later follows worse, and one that receives it earlier follows better where it
lags. At the rms speed V of a cycle a delay of D adds about V D to an error that it does not correlate with:
e^2 = e_0^2 + (V D)^2. Between two delays on either side of the wanted error, e^2 is taken to be linear in L.

Source  ours, docs/circuits-compared.md
"""

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.kinds import MEAN_POWER, RATE, Length
from vvdp.control.duty_cycle import DutyCycle, cycle_speeds

POLES = 4.0
"""Of the filter before a loop."""
TOLERANCE = 0.02
"""By how much of the wanted error a circuit may miss it: two circuits then differ by 4.1 % at most."""
EQUAL = 0.024
"""Beyond this share of the wanted error a circuit is named: all others differ by 5 % at most."""
MOST_TRIES = 8
"""Runs for one circuit on one cycle, beside the first."""
FASTEST, SLOWEST = 100.0, 5.0
"""Between which the poles are tried [1/s]: a delay of 40 to 800 ms."""
DIGITS = 3
"""Of a common error: what a page prints is then what was wanted, with all digits."""
INNER = 0.1
"""A try lies at least this share of their distance away from the two delays that enclose it."""


class Attempt(NamedTuple):
    """A run of a circuit on a cycle: poles of the filter before its loop, rms error, input minus recovered power."""

    filter_rate: Annotated[float, RATE]
    error: Length
    power: Annotated[float, MEAN_POWER]


def common_error(errors: Sequence[float]) -> float:
    """The error to which circuits with these rms errors [m] are brought: the largest, rounded up to three digits [m].

    >>> common_error([1e-3, 3.0301e-3])
    0.00304
    """
    largest = max(errors)
    if largest == 0.0:
        return 0.0
    step = 10.0 ** (math.floor(math.log10(largest)) + 1 - DIGITS)
    return round(step * math.ceil(largest / step - 1e-6), 12)


def is_reached(error: float, wanted: float, share: float = TOLERANCE) -> bool:
    """Whether an rms error is the `wanted` one [m], within a share of that."""
    return abs(error - wanted) <= share * wanted


def rms_speed(cycle: DutyCycle) -> float:
    """The rms speed that a cycle asks for [m/s]."""
    return float(np.sqrt(np.average(np.square(cycle_speeds(cycle)), weights=np.diff(cycle.times))))


def next_rate(tried: Sequence[Attempt], wanted: float, speed: float) -> float:
    """The poles to be tried next [1/s].

    tried   what was tried before, one at least
    wanted  rms error [m]
    speed   rms speed of the cycle [m/s]

    >>> next_rate([Attempt(25.0, 3e-3, 100.0)], 5e-3, 0.1)
    20.0
    >>> next_rate([Attempt(40.0, 1e-3, 100.0), Attempt(10.0, 7e-3, 100.0)], 5e-3, 0.1)
    16.0

    The error may jump between two delays, so the closest pair of delays on either side counts, not of errors.
    """
    points = sorted((POLES / each.filter_rate, each.error) for each in tried)
    around = [(a, b) for a, b in pairwise(points) if a[1] < wanted <= b[1]]
    if around:
        (late, little), (later, much) = min(around, key=lambda pair: pair[1][0] - pair[0][0])
        share = (wanted**2 - little**2) / (much**2 - little**2)
        delay = late + min(max(share, INNER), 1.0 - INNER) * (later - late)
    else:
        below = points[-1][1] < wanted
        delay, error = points[-1] if below else points[0]
        delay += (1.0 if below else -1.0) * abs(wanted**2 - error**2) ** 0.5 / speed
    return round(min(max(POLES / max(delay, 1e-9), SLOWEST), FASTEST), 9)


def attempts(run: Callable[[float], Attempt | None], first: Attempt, wanted: float, speed: float) -> list[Attempt]:
    """Attempts until the wanted error was reached, or cannot be; the first one is that with the common poles.

    run     attempt with poles of a rate [1/s]; None where its run breaks off
    wanted  rms error [m]
    speed   rms speed of the cycle [m/s]
    """
    tried = [first]
    while not is_reached(tried[-1].error, wanted) and len(tried) <= MOST_TRIES:
        rate = next_rate(tried, wanted, speed)
        if rate in {each.filter_rate for each in tried}:
            break
        found = run(rate)
        if found is None:
            break
        tried.append(found)
    return tried


def closest(tried: Sequence[Attempt], wanted: float) -> int:
    """The place of the attempt whose error is closest to the wanted one."""
    return int(np.argmin([abs(each.error - wanted) for each in tried]))
