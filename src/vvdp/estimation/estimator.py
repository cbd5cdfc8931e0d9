"""Common parts of all estimators.

An estimator is a pure step, `step(memory, reading, settings) -> (memory, estimate)`, taken at every sample. Between
samples angle(t) = angle + speed (t - time of the sample) holds.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

from vvdp.base.kinds import Angle, Count, Fraction, Speed


class Estimate(NamedTuple):
    """Estimate at a sample. Deviations are NaN where an estimator does not know them.

    `innovation` is by how much the edge of this sample differed from what was expected, `innovation_deviation` by how
    much it was expected to differ; both are 0 at samples without an edge that was used. `missed_edges` counts the
    edges that have been passed over since the start. `standstill` is the probability that the wheel stands still.
    """

    angle: Angle
    speed: Speed
    angle_deviation: Angle
    speed_deviation: Speed
    innovation: Angle
    innovation_deviation: Angle
    missed_edges: Count
    standstill: Fraction


class Believed(Protocol):
    """Mean and variance of angle and speed: of a Gaussian belief, or the first two moments of another."""

    @property
    def angle(self) -> float: ...
    @property
    def speed(self) -> float: ...
    @property
    def angle_variance(self) -> float: ...
    @property
    def speed_variance(self) -> float: ...


def to_estimate(
    believed: Believed, standstill: float, innovation: float, innovation_deviation: float, missed_edges: float
) -> Estimate:
    """The estimate from a belief at the time of the sample; arguments as in `Estimate`."""
    b = believed
    angle_deviation, speed_deviation = np.sqrt(b.angle_variance), np.sqrt(b.speed_variance)
    return Estimate(
        angle=b.angle,
        speed=b.speed,
        angle_deviation=angle_deviation,
        speed_deviation=speed_deviation,
        innovation=innovation,
        innovation_deviation=innovation_deviation,
        missed_edges=missed_edges,
        standstill=standstill,
    )


@dataclass(frozen=True)
class Estimator:
    """An estimator with its values, ready to be run in a simulation, over a log or in a comparison."""

    title: str
    step: Callable[[Any, Any, Any], tuple[Any, Estimate]]
    memory: Any
    settings: Any
