"""What repeats with every turn, told apart: a ripple of the speed, and the places of a wheel's edges.

A ripple that is locked to the spool's angle looks at the edges exactly like a wheel whose edges lie on a sine over the
turn. Derived in docs/logs.md.

Source  ours, docs/logs.md
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.estimation.smoother import Beliefs

ORDERS = range(2, 9)
"""Ripples per turn that are looked for besides those of the spool; one wave over the turn is an eccentric wheel."""
ALONE = 0.9
"""Share of the squared offsets that such a ripple explains, at least."""
LARGEST = 0.1
"""Amplitude beyond which a pattern is the wheel's: a spool does not swing by so much, and a linear ripple ends [1]."""
EXPECTED = 0.035
"""Amplitude of the ripple that a spool is expected to have at its sections [1]."""
CHANCE = 0.05
"""A ripple stands out where the wheel's other offsets would make as much of it with less than this chance."""


class SpeedRipple(NamedTuple):
    """A speed of mean (1 + cosine cos(order angle) + sine sin(order angle)), both parts with a standard `error` [1].

    The error is by how much the offsets that are no ripple differ among themselves: the wheel may have as much of it.
    """

    order: int
    cosine: float
    sine: float
    error: float

    @property
    def amplitude(self) -> float:
        """Of the speed, over its mean [1]."""
        return float(np.hypot(self.cosine, self.sine))

    def offsets(self, angles: Array) -> Array:
        """How much further on [rad] edges at these `angles` [rad] seem to lie.

        theta = phi + (a sin N theta - b cos N theta)/N, where phi is the mean course, has the speed
        phi' (1 + a cos N theta + b sin N theta) to the first order; an edge at theta is met at phi.
        """
        seeming: Array = ripple_patterns(angles, self.order) @ np.array([self.cosine, self.sine])
        return seeming

    @property
    def variance(self) -> float:
        """By how much each part differs from that of the motion [1]: the error, and a^2/2 of twice the order, which a
        linear ripple leaves out."""
        return self.error**2 + self.amplitude**4 / 4.0

    def motion(self, course: Beliefs) -> Beliefs:
        """Beliefs about the spool from those about its mean course: theta = phi - d(theta), omega = phi'/(1 + d')."""
        angle = course.angle - self.offsets(course.angle - self.offsets(course.angle))
        at = self.order * angle
        stretch = 1.0 / (1.0 - self.cosine * np.cos(at) - self.sine * np.sin(at))
        speed = stretch * course.speed
        return Beliefs(
            angle=angle,
            speed=speed,
            angle_variance=stretch**2 * course.angle_variance + self.variance / self.order**2,
            covariance=stretch**2 * course.covariance,
            speed_variance=stretch**2 * course.speed_variance + self.variance * speed**2,
        )


def is_whole(order: int, edges: int) -> bool:
    """Whether a turn has edges enough to see cosine and sine of a ripple, more than two in each wave (Nyquist)."""
    return edges > max(2 * order, 3)


def is_likely(ripple: SpeedRipple) -> bool:
    """Whether a log whose wheel is as described speaks rather for this ripple of the spool's sections than for none.

    Of Gaussian parts of the variance t^2, known to e, the odds are (1 + t^2/e^2)^-1 exp(a^2/(2 e^2) t^2/(t^2 + e^2)).

    Source  ours, docs/logs.md
    """
    prior, error = 0.5 * EXPECTED**2, ripple.error**2
    odds = 0.5 * ripple.amplitude**2 / error * prior / (prior + error) - np.log1p(prior / error)
    return bool(odds > 0.0 and ripple.amplitude < LARGEST)


def ripple_patterns(angles: Array, order: int) -> Array:
    """How much further on [rad] edges at these `angles` [rad] seem to lie by a unit of cosine, and of sine, (n, 2)."""
    at = order * angles
    found: Array = np.column_stack([-np.sin(at), np.cos(at)]) / order
    return found


def ripple_in(offsets: Array, angles: Array, sections: int) -> SpeedRipple | None:
    """The ripple in the offsets [rad] of edges at `angles` [rad]; None where there is none that stands out.

    It is that of the spool's `sections`, or another that explains the offsets nearly alone.
    """
    from scipy.stats import f

    whole = [order for order in dict.fromkeys((sections, *ORDERS)) if is_whole(order, offsets.size)]
    freedom = offsets.size - 3
    for order in whole:
        found, left = _fit_ripple(offsets, angles, order)
        made = float(np.sum((offsets - np.mean(offsets)) ** 2)) - left
        by_chance = made * freedom <= 2.0 * left * float(f.isf(CHANCE, 2, freedom))
        if by_chance or found.amplitude > LARGEST:
            continue
        if order == sections or made > ALONE * (made + left):
            return found
    return None


def _fit_ripple(offsets: Array, angles: Array, order: int) -> tuple[SpeedRipple, float]:
    """The likeliest ripple of an order, and the sum of the squares of what it leaves [rad^2]."""
    waves = np.column_stack([ripple_patterns(angles, order), np.ones(angles.size)])
    inverse = np.linalg.inv(waves.T @ waves)
    found = inverse @ waves.T @ offsets
    left = float(np.sum((offsets - waves @ found) ** 2))
    error = float(np.sqrt(left / (offsets.size - 3) * np.mean(np.diag(inverse)[:2])))
    return SpeedRipple(order, float(found[0]), float(found[1]), error), left
