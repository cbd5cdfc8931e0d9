"""The event-based Kalman filter of section 3.4, with its gain corrected, over many random runs at once.

Source  wang2017, eqs. 3.5 to 3.10; docs/errata.md
"""

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.numerics.kalman import AngleSpeed, predict, update
from vvdp.sensing.wheel import TURN

SECTOR, SAMPLE, TURNS = TURN / 8.0, 1e-3, 25.0
START_VARIANCE, DENSITY, NOISE, START_SPEED = 1000.0, 0.25, 5.53e-3, 50.0
"""p, q [rad^2/s^3], R [rad^2] and the speed that is believed at first [rad/s], of section 3.5."""
LIGHT_TIME = 1.5e-3
"""The longest transition of the light [s]: section 3.5."""
RUNS, UNTIL = 4000, 0.5


@dataclass(frozen=True)
class Truth:
    """How the wheel turns and how its edges are seen.

    The clock is fixed, with a random phase, or the delay of every edge is independent and even within a sample. With
    `threshold_error` each edge is off by a triangle of half the light's transition.
    """

    turns: float = TURNS
    fixed_clock: bool = False
    threshold_error: bool = False

    @property
    def speed(self) -> float:
        """Of the wheel [rad/s]."""
        return TURN * self.turns


EVEN = Truth()
WITH_THRESHOLD = Truth(threshold_error=True)
IN_STEP = Truth(fixed_clock=True)
OUT_OF_STEP = Truth(turns=24.7, fixed_clock=True)


@dataclass(frozen=True)
class Filtered:
    """Estimates of the filter after each edge, in arrays (edges, runs): `seen` is when the edge is reported."""

    seen: Array
    belief: Any  # AngleSpeed of arrays

    def errors_at(self, time: float, speed: float) -> tuple[Array, Array]:
        """Errors of angle [rad] and speed [rad/s] at a time [s], of every run."""
        last = np.sum(self.seen <= time, axis=0) - 1
        runs = np.arange(self.seen.shape[1])
        begun = last >= 0
        told_angle, told_speed, *_ = self.belief
        angle = np.where(begun, told_angle[last, runs], START_SPEED * time)
        rate = np.where(begun, told_speed[last, runs], START_SPEED)
        at = np.where(begun, self.seen[last, runs] - 0.5 * SAMPLE, time)
        return angle + rate * (time - at) - speed * time, rate - speed


@cache
def filtered_runs(truth: Truth, runs: int = RUNS) -> Filtered:
    """The filter of section 3.5 over random `runs`; the wheel starts on an edge, as the source's does."""
    rng = np.random.default_rng(25)
    count = int(UNTIL * truth.speed / SECTOR)
    number = np.arange(1.0, count + 1.0)[:, None]
    error = np.zeros((count, runs))
    if truth.threshold_error:
        half = 0.5 * truth.speed * LIGHT_TIME
        error = half * (rng.random((count, runs)) + rng.random((count, runs)) - 1.0)
    passed = (number * SECTOR + error) / truth.speed
    phase = rng.random(runs)
    clocked = (np.ceil(passed / SAMPLE - phase) + phase) * SAMPLE
    seen = clocked if truth.fixed_clock else passed + SAMPLE * rng.random((count, runs))
    start: Any = np.zeros(runs)
    belief = AngleSpeed(start, start + START_SPEED, start + START_VARIANCE, start, start + START_VARIANCE)
    time, found = start, []
    for place in range(count):
        now = seen[place] - 0.5 * SAMPLE
        belief = predict(belief, now - time, DENSITY)
        belief = update(belief, (place + 1.0) * SECTOR - belief.angle, NOISE)
        time = now
        found.append(belief)
    columns: Any = (np.array(each) for each in zip(*found, strict=True))
    return Filtered(seen, AngleSpeed(*columns))
