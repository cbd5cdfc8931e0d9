"""What repeats with every turn of a log: where the edges of the wheel lie, and a ripple of the speed.

The filter is linear in the angles, so patterns are found by least squares of its innovations. Derived in docs/logs.md.

Source  ours, docs/logs.md
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.offline.likelihood import Fit, Likelihood, fit
from vvdp.offline.passage import Noise
from vvdp.offline.turn_pattern import (
    ORDERS,
    Candidate,
    SpeedRipple,
    candidates,
    chance_of,
    is_whole,
    ripple_in,
    ripple_patterns,
)

TURNS_OF_A_WHEEL = 8
"""A wheel's edges are placed from so many turns, at least."""
MOST_PLACES = 256
CLEAR = 10.0
"""By so much the logarithm of the likelihood has to be higher before one explanation is preferred to another."""
FORETOLD_PARTS = 64
"""Where there is no ripple, one fitted to the parts before foretells the next with a chance of 0.57 over this."""


def likeliest_offsets(likelihood: Likelihood, noise: Noise, period: int) -> Array:
    """How much further on [rad] the edges lie that follow one another after `period`, mean of all zero.

    The filter is linear in the angles, so the innovations are those of the angles less the sum of the offsets times
    those of each edge's indicator: linear least squares of what the filter has made white.

    Source  ours, docs/logs.md
    """
    nu, responses = likelihood.white(noise, period)
    found = np.linalg.lstsq(responses[:, :-1], -nu, rcond=1e-10)[0]
    every = np.append(found, 0.0)
    shifted: Array = every - np.mean(every)
    return shifted


def likeliest_ripple(likelihood: Likelihood, noise: Noise, order: int) -> SpeedRipple:
    """The likeliest ripple of this order on the wheel as it is, by the same least squares."""
    nu, responses = likelihood.white_patterns(noise, ripple_patterns(likelihood.passed.angles, order))
    covariance = np.linalg.inv(responses.T @ responses)
    cosine, sine = (-covariance @ responses.T @ nu).tolist()
    return SpeedRipple(order, cosine, sine, float(np.sqrt(np.mean(np.diag(covariance)))))


def foretold_gain(likelihood: Likelihood, noise: Noise, order: int) -> float:
    """By which ln L of the edges of each part of the log is higher with the ripple of this order that the parts
    before it have, summed up: whether it foretells edges it was not fitted to.

    Source  dawid1984; docs/logs.md
    """
    z, patterns = likelihood.white_patterns(noise, ripple_patterns(likelihood.passed.angles, order))
    information, score, gain = np.zeros((2, 2)), np.zeros(2), 0.0
    for part in np.array_split(np.arange(z.size), FORETOLD_PARTS):
        told = z[part] - patterns[part] @ np.linalg.pinv(information, hermitian=True) @ score
        gain += 0.5 * float(np.sum(z[part] ** 2 - told**2))
        information, score = information + patterns[part].T @ patterns[part], score + patterns[part].T @ z[part]
    return gain


class Pattern(NamedTuple):
    """What repeats with every turn: the fit without it, if it is real, where the edges seem to lie, of that the ripple
    and the offsets [rad] that are the wheel's own; `learnt` numbers say all that. The `candidates` are ripples that fit
    alike."""

    wheel: Fit | None
    offsets: Array
    ripple: SpeedRipple | None
    own_offsets: Array
    learnt: int
    candidates: tuple[Candidate, ...] = ()


def find_pattern(likelihood: Likelihood, plain: Fit, sections: int) -> Pattern:
    """Offsets of all edges, less a ripple, where they are worth their price; else the spool's ripple if likely."""
    sectors, nothing = likelihood.sectors, np.zeros(likelihood.sectors)
    if not has_turns(likelihood, sectors):
        return Pattern(None, nothing, None, nothing, 0)
    angles = likelihood.wheel_angles(sectors)
    placed, offsets = fit_by_turns(likelihood, plain, lambda noise: likeliest_offsets(likelihood, noise, sectors))
    if placed.log_likelihood - plain.log_likelihood - price(likelihood, sectors - 1) > CLEAR:
        ripple = ripple_in(offsets, angles, sections)
        alike = _candidates(likelihood, placed, offsets, sections if ripple is None else ripple.order)
        if ripple is not None and ripple.order not in [each.ripple.order for each in alike]:
            ripple = alike[0].ripple if alike else ripple  # it explains the edges clearly better
        left = offsets if ripple is None else offsets - ripple.offsets(angles)
        return Pattern(
            wheel=placed,
            offsets=offsets,
            ripple=ripple,
            own_offsets=left - np.mean(left),
            learnt=sectors - 1,
            candidates=alike,
        )
    alone = _ripple_alone(likelihood, plain.noise, sections)
    if alone is None:
        return Pattern(None, nothing, None, nothing, 0)
    order = alone.ripple.order
    if foretold_gain(likelihood, plain.noise, order) > 0.0:
        placed, offsets = fit_by_turns(
            likelihood, plain, lambda noise: likeliest_ripple(likelihood, noise, order).offsets(angles)
        )
        return Pattern(
            wheel=placed,
            offsets=offsets,
            ripple=likeliest_ripple(likelihood, placed.noise, order),
            own_offsets=nothing,
            learnt=2,
            candidates=_candidates(likelihood, placed, offsets, order),
        )
    return Pattern(None, nothing, None, nothing, 0, candidates=(alone,))


def _ripple_alone(likelihood: Likelihood, noise: Noise, sections: int) -> Candidate | None:
    """The likeliest ripple of a wheel whose edges lie as described, if it is likelier than none: a spool is expected to
    have one at its sections, and once in as many spools one of another order."""
    orders = [order for order in dict.fromkeys((sections, *ORDERS)) if is_whole(order, likelihood.sectors)]
    seen = [likeliest_ripple(likelihood, noise, order) for order in orders]
    others = 1.0 / max(len(orders) - 1, 1)
    found = [Candidate(each, chance_of(each, 1.0 if each.order == sections else others)) for each in seen]
    likeliest = max(found, key=lambda each: each.chance, default=None)
    return likeliest if likeliest is not None and likeliest.chance > 0.5 else None


def _candidates(likelihood: Likelihood, placed: Fit, offsets: Array, first: int) -> tuple[Candidate, ...]:
    """The ripples that may have made these offsets [rad]: those that fit as well as that of the order `first`."""
    seen = placed.noise.edge_variance + likelihood.sampling_variance
    scatter = seen * offsets.size / likelihood.passed.times.size
    return candidates(offsets, likelihood.wheel_angles(offsets.size), first, scatter)


def has_turns(likelihood: Likelihood, period: int) -> bool:
    """Whether a log has turns enough to place the edges of a wheel with so many."""
    return 2 <= period <= MOST_PLACES and likelihood.passed.times.size >= TURNS_OF_A_WHEEL * period


def price(likelihood: Likelihood, numbers: int) -> float:
    """What so many numbers that were fitted cost in ln L: half of them times ln n, after Schwarz."""
    return 0.5 * numbers * float(np.log(likelihood.passed.times.size))


def fit_by_turns(likelihood: Likelihood, plain: Fit, pattern: Callable[[Noise], Array]) -> tuple[Fit, Array]:
    """The likeliest settings where the edges lie as the log has them, and the offsets that the `pattern` makes of the
    noise [rad]; settings and offsets by turns."""
    found, offsets = plain, np.zeros(1)
    for _ in range(3):
        offsets = pattern(found.noise)
        before, found = found, fit(likelihood.without(offsets))
        if found.log_likelihood < before.log_likelihood + 0.5:
            break
    return found, offsets
