"""Doubt about the speed: what edges cannot distinguish.

Derived in docs/logs.md, "What edges cannot show".

Source  ours, docs/logs.md
"""

from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.offline.edges import Chosen
from vvdp.offline.noise_fit import Explained
from vvdp.offline.turn_pattern import Candidate, SpeedRipple

NOTHING_TOLD = SpeedRipple(0, 0.0, 0.0, 0.0)
"""What a filter without a ripple receives."""

EVEN, POSSIBLE = 0.5, 0.05
"""Ripples that together have a probability above the second count with the first at least: there is no better reason
than one to one [1]."""


class Doubt(NamedTuple):
    """Variances that are added to those of the rows: of the speed over its square [1], and of the angle [rad^2]; and
    the number by which edges may be counted wrongly, root mean square [1], part of that of the angle."""

    speed_ratio: float
    angle: float
    miscounted: float = 0.0

    def speed_deviation(self, speed: Any) -> Any:
        """Standard deviation at a speed [rad/s]."""
        return np.sqrt(self.speed_ratio) * np.abs(speed)

    def add_to(self, variances: dict[str, Array], speed: Array, standing: Chosen) -> dict[str, Array]:
        """The variances of rows with this one, `speed_deviation` [rad^2/s^2] and `angle_deviation` [rad^2]; a speed
        that is zero has none of it."""
        turned = np.where(standing, 0.0, speed)
        return {
            "speed_deviation": variances["speed_deviation"] + self.speed_ratio * turned * turned,
            "angle_deviation": variances["angle_deviation"] + self.angle,
        }

    def with_count(self, miscounted: float, pitch: float) -> "Doubt":
        """The same where so many edges may be counted wrongly, `pitch` [rad] apart."""
        return self._replace(angle=self.angle + (miscounted * pitch) ** 2, miscounted=miscounted)


NO_DOUBT = Doubt(0.0, 0.0)


def doubt_of(told: Explained | None, ripple_order: float) -> Doubt:
    """The doubt of a record about the estimate of a filter that has a ripple of this order, 0 for none.

    Ripples that fit the edges alike, and the wheel's own share of the pattern, count by their probabilities.
    """
    if told is None:
        return NO_DOUBT
    known = NOTHING_TOLD
    if ripple_order > 0.0:
        same = told.ripple is not None and told.ripple.order == ripple_order
        known = told.ripple if same and told.ripple is not None else SpeedRipple(int(ripple_order), 0.0, 0.0, 0.0)
    ratio, angle = ripple_doubt(told.candidates, known)
    return Doubt(ratio, angle)


def ripple_doubt(candidates: tuple[Candidate, ...], known: SpeedRipple) -> tuple[float, float]:
    """Variance of the speed over its square [1], and of the angle [rad^2], of a filter that estimates the ripple
    `known` while the true one is any of the `candidates`.

    Waves of different orders are orthogonal over a turn, so their mean squares add up: (a_0^2 + E a_N^2)/2 for each
    order but the one that is estimated. Probabilities of orders are assumed: the others together, if possible at all,
    count with `EVEN` at least.
    """
    ratio, angle = 0.0, 0.0
    others = [each for each in candidates if each.ripple.order != known.order]
    total = sum(each.chance for each in others)
    more = max(EVEN / total, 1.0) if total > POSSIBLE else 1.0
    for each in others:
        square, order, chance = each.ripple.expected_square, each.ripple.order, more * each.chance
        ratio += 0.5 * chance * (known.amplitude**2 + square)
        estimated = (known.amplitude / known.order) ** 2 if known.order else 0.0
        angle += 0.5 * chance * (estimated + square / order**2)
    return ratio, angle
