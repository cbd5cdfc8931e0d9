"""Doubt about the speed: what edges cannot distinguish, and what the settings of the filter leave out.

Derived in docs/logs.md, "What edges cannot show".

Source  ours, docs/logs.md
"""

from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.offline.estimate_result import AT_ONCE
from vvdp.offline.noise_fit import Explained
from vvdp.offline.turn_pattern import Candidate, SpeedRipple

NOTHING_TOLD = SpeedRipple(0, 0.0, 0.0, 0.0)
"""What a filter without a ripple receives."""

EVEN, POSSIBLE = 0.5, 0.05
"""Ripples that together have a probability above the second count with the first at least: there is no better reason
than one to one [1]."""


class Excess(NamedTuple):
    """What the filter states too much: taken off a variance, down to what is `left` of it [rad^2/s^2 or rad^2]."""

    stated: float
    left: float

    def taken_off(self, variance: Array) -> Array:
        """The variance without it; what is smaller than what is left stays."""
        found: Array = np.fmax(variance - (self.stated - self.left), np.fmin(variance, self.left))
        return found


NO_EXCESS = Excess(0.0, 0.0)


class Doubt(NamedTuple):
    """Variances that are added to those of the filter: of the speed a part that grows with its square [1] and one that
    does not [rad^2/s^2], of the angle [rad^2]; what both have too much; and the number by which edges may be counted
    wrongly, root mean square [1], part of that of the angle."""

    speed_ratio: float
    speed: float
    angle: float
    speed_excess: Excess = NO_EXCESS
    angle_excess: Excess = NO_EXCESS
    miscounted: float = 0.0

    def speed_deviation(self, speed: Any) -> Any:
        """Standard deviation at a speed [rad/s]."""
        return np.sqrt(self.speed_ratio * speed * speed + self.speed)

    def with_count(self, miscounted: float, pitch: float) -> "Doubt":
        """The same where so many edges may be counted wrongly, `pitch` [rad] apart."""
        return self._replace(angle=self.angle + (miscounted * pitch) ** 2, miscounted=miscounted)


NO_DOUBT = Doubt(0.0, 0.0, 0.0)


def doubt_of(told: Explained | None, ripple_order: float) -> Doubt:
    """The doubt of a record about the estimate of a filter that has a ripple of this order, 0 for none.

    Ripples that fit the edges alike, and the wheel's own share of the pattern, count by their probabilities; settings
    that clearly do not fit count by what the mean squared error exceeds the stated variance, as far as it lasts. Where
    it falls short of that variance, the rest is an excess.
    """
    if told is None:
        return NO_DOUBT
    known = NOTHING_TOLD
    if ripple_order > 0.0:
        same = told.ripple is not None and told.ripple.order == ripple_order
        known = told.ripple if same and told.ripple is not None else SpeedRipple(int(ripple_order), 0.0, 0.0, 0.0)
    ratio, angle = ripple_doubt(told.candidates, known)
    e, lasting = told.used_errors, told.lasting if told.matters else 0.0
    return Doubt(
        speed_ratio=ratio,
        speed=lasting * max(e.true * e.true - e.stated * e.stated, 0.0),
        angle=angle + lasting * max(e.angle_true * e.angle_true - e.angle_stated * e.angle_stated, 0.0),
        speed_excess=_excess(e.stated, e.true, ripple_order),
        angle_excess=_excess(e.angle_stated, e.angle_true, ripple_order),
    )


def _excess(stated: float, true: float, ripple_order: float) -> Excess:
    """None where the filter estimates a ripple: how well it knows that is not in these errors."""
    return Excess(stated**2, true**2) if stated > true and ripple_order == 0.0 else NO_EXCESS


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


def add_doubt(file: Any, doubt: Doubt, prefix: str = "") -> None:
    """Adds a doubt to the deviations of an open result.h5; `prefix` names the columns, "smoothed_" those of the
    smoother."""
    if doubt == NO_DOUBT:
        return
    speeds, angles = file[f"{prefix}speed_deviation"], file[f"{prefix}angle_deviation"]
    for begin in range(0, speeds.shape[0], AT_ONCE):
        rows = slice(begin, begin + AT_ONCE)
        speed = _standing_as_zero(file["standstill"][rows], file[f"{prefix}speed"][rows])
        own = np.sqrt(doubt.speed_excess.taken_off(speeds[rows] ** 2))
        speeds[rows] = np.hypot(own, np.where(speed == 0.0, 0.0, doubt.speed_deviation(speed)))
        angles[rows] = np.sqrt(doubt.angle_excess.taken_off(angles[rows] ** 2) + doubt.angle)


def _standing_as_zero(standstill: Array, speed: Array) -> Array:
    return np.where(standstill > 0.5, 0.0, speed)
