"""How long a silence may last for the filter to go on over it."""

from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.estimation.event_settings import EventFilter
from vvdp.numerics.kalman import AngleSpeed, predict
from vvdp.offline.edges import rank_filter
from vvdp.sensing.wheel import TURN

BRIDGED_EDGES = 3.0
LONGEST_BRIDGED = 60.0
"""A silence of more seconds [s] is never bridged, whatever is usual: that is not turning."""
RECENT = 16
"""So many times between edges say what is usual."""


def bridged_time(period: float, settings: EventFilter) -> float:
    """How long without an edge three deviations of the predicted angle stay below half a sector [s].

    From the filter's steady state at an edge every `period` [s], with R_c = R T: P22 = sqrt(2) q^(3/4) R_c^(1/4),
    P12 = sqrt(q R_c), P11 = sqrt(2) q^(1/4) R_c^(3/4).

    Source  ours, docs/logs.md
    """
    return float(_bridged_times(np.array([period]), settings)[0])


def _bridged_times(periods: Array, settings: EventFilter) -> Array:
    half, q = 0.5 * TURN / len(settings.wheel.edges), max(settings.acceleration_density, 1e-12)
    root = np.sqrt(2.0)
    R: Any = settings.edge_variance * periods
    steady = AngleSpeed(0.0, 0.0, root * q**0.25 * R**0.75, np.sqrt(q * R), root * q**0.75 * R**0.25)
    low, high = np.zeros(periods.size), np.full(periods.size, 1e6)
    for _ in range(60):
        middle: Any = 0.5 * (low + high)
        short = 3.0 * np.sqrt(predict(steady, middle, q).angle_variance) < half
        low, high = np.where(short, middle, low), np.where(short, high, middle)
    return low


def longest_bridged(usual: Array, steps: Array, settings: EventFilter) -> Array:
    """How long silences may last to be bridged [s], where edges usually take `usual` [s] and these take `steps` [s];
    where they take no more than a few edges do, that is all that is asked."""
    found = BRIDGED_EDGES * usual
    doubtful = np.flatnonzero(steps > found)
    found[doubtful] = np.fmax(found[doubtful], _bridged_times(usual[doubtful], settings))
    limited: Array = np.fmin(found, LONGEST_BRIDGED)
    return limited


def usual_before(steps: Array) -> Array:
    """The usual time between edges at each [s]: the second longest of those before it, or of the first ones of the
    piece. Where edges are missed now and then a silence is as long as several sectors take."""
    if not steps.size:
        return steps
    size = min(RECENT, steps.size)
    long = rank_filter(steps, size, max(size - 2, 0))
    found: Array = long[np.fmax(np.arange(steps.size) - size, 0)]
    return found
