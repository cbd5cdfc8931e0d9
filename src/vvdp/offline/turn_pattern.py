"""What repeats with every turn, distinguished: a ripple of the speed, and the places of a wheel's edges.

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
ECCENTRIC = 8
"""From so many edges on, one wave over the turn is distinguished from a ripple."""
ALIKE = 6.0
"""Ripples fit alike where their squares, over those of an offset's own error, differ by no more: chi square at 5 %."""


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

    @property
    def share(self) -> float:
        """The part of the pattern that is expected to be the motion's [1]; the rest is the wheel's.

        Both parts have the variance t^2 = EXPECTED^2/2 before and are seen with the error e: t^2/(t^2 + e^2).
        """
        prior = 0.5 * EXPECTED**2
        return prior / (prior + self.error**2)

    @property
    def expected_square(self) -> float:
        """Mean square of the amplitude that the motion has by that [1]: its mean squared, and the variances left."""
        return (self.share * self.amplitude) ** 2 + 2.0 * self.share * self.error**2

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


class Candidate(NamedTuple):
    """A ripple that the edges may show, and the probability that it is the one [1]."""

    ripple: SpeedRipple
    chance: float


def is_whole(order: int, edges: int) -> bool:
    """Whether a turn has edges enough to see cosine and sine of a ripple, more than two in each wave (Nyquist)."""
    return edges > max(2 * order, 3)


def chance_of(ripple: SpeedRipple, before: float = 1.0) -> float:
    """Probability of this ripple against none of a log whose wheel is as described [1]; 0 where it is above `LARGEST`.

    Of Gaussian parts of the variance t^2, known to e, the odds are those `before` times (1 + t^2/e^2)^-1
    exp(a^2/(2 e^2) t^2/(t^2 + e^2)).

    Source  ours, docs/logs.md
    """
    prior, error = 0.5 * EXPECTED**2, ripple.error**2
    gain = 0.5 * ripple.amplitude**2 / error * prior / (prior + error) - np.log1p(prior / error)
    odds = gain + np.log(before)
    return float(1.0 / (1.0 + np.exp(-min(odds, 700.0)))) if ripple.amplitude < LARGEST else 0.0


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


def candidates(offsets: Array, angles: Array, first: int, scatter: float) -> tuple[Candidate, ...]:
    """All ripples that explain the offsets [rad] of edges at `angles` [rad] as well as any, if one of the order `first`
    does; the likeliest first.

    Of n even edges the orders k n + first and k n - first make the same pattern. The probability of an order falls with
    its square and with the amplitude that it takes, exp(-a^2/(2 EXPECTED^2)); none above `LARGEST` is possible.

    scatter  variance of an offset by the noise of the edges [rad^2]
    """
    beside = ripple_patterns(angles, 1) if offsets.size >= ECCENTRIC else np.empty((offsets.size, 0))
    fits = {order: _fit_ripple(offsets, angles, order, beside)
            for order in (first, *range(2, 2 * offsets.size)) if _is_told(angles, order, beside)}  # fmt: skip
    possible = {order: fit for order, fit in fits.items() if fit[0].share * fit[0].amplitude <= LARGEST}
    if first not in possible:
        return ()
    least = min(left for _, left in possible.values())
    error = max(least / (offsets.size - 3 - beside.shape[1]), scatter, 1e-12 * float(np.mean(offsets**2)), 1e-300)
    weights = {
        order: float(np.exp(-0.5 * ((ripple.share * ripple.amplitude / EXPECTED) ** 2 + (left - least) / error)))
        / order**2
        for order, (ripple, left) in possible.items()
        if left - least <= ALIKE * error
    }
    total = sum(weights.values())
    found = [Candidate(possible[order][0], weight / total) for order, weight in weights.items()]
    return tuple(sorted(found, key=lambda each: -each.chance))


def _is_told(angles: Array, order: int, beside: Array) -> bool:
    """Whether edges at these angles show both parts of a ripple, beside the mean that all of them share, and beside
    other patterns."""
    waves = np.column_stack([order * ripple_patterns(angles, order), beside, np.ones(angles.size)])
    return bool(np.linalg.matrix_rank(waves, tol=0.05 * np.sqrt(angles.size)) == waves.shape[1])


def _fit_ripple(offsets: Array, angles: Array, order: int, beside: Array | None = None) -> tuple[SpeedRipple, float]:
    """The likeliest ripple of an order beside other patterns, and the sum of the squares of what is left [rad^2]."""
    own = ripple_patterns(angles, order)
    waves = np.column_stack([own, np.ones(angles.size)] if beside is None else [own, beside, np.ones(angles.size)])
    inverse = np.linalg.inv(waves.T @ waves)
    found = inverse @ waves.T @ offsets
    left = float(np.sum((offsets - waves @ found) ** 2))
    error = float(np.sqrt(left / (offsets.size - waves.shape[1]) * np.mean(np.diag(inverse)[:2])))
    return SpeedRipple(order, float(found[0]), float(found[1]), error), left
