"""After a silence: did the wheel stand still, or was the sensor silent while it turned on?

The filter begins again as if the wheel had stood. Beside it the belief from before the silence is carried on until the
edges that follow speak clearly for one of the two. Derived in docs/models/event-filter.md, "After a silence".

Source  ours, docs/models/event-filter.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import Angle, AngularVariance, Count, Number
from vvdp.numerics.kalman import AngleSpeed, update

DECIDED = 4.0
"""Logarithm of the odds at which one of the two is taken [1]."""

LONGEST = 16.0
"""Edges after which the likelier is taken [1]."""


class NumberedEdge(NamedTuple):
    """An edge of the wheel: its number, and the angle at which it is."""

    number: Count
    angle: Angle


class Doubt(NamedTuple):
    """The belief had the sensor been silent, at the time of the last edge, and the number of that edge then.

    `odds` is the logarithm of the odds of this against a wheel that stood, -inf where there is no doubt; `slip` the
    variance of the angle that goes with this belief. `edges` have come since the silence.
    """

    belief: AngleSpeed
    number: Number
    odds: Number
    slip: AngularVariance
    edges: Count


def no_doubt(belief: AngleSpeed) -> Doubt:
    """The doubt of a filter that has none; `belief` only fills the place."""
    return Doubt(belief, number=0.0, odds=-np.inf, slip=0.0, edges=0.0)


def carry_on(doubt: Doubt, prior: AngleSpeed, edge: NumberedEdge, variance: float, surprise: float) -> Doubt:
    """The doubt after one more edge.

    prior     the belief at the time of the edge, had the wheel turned on
    variance  of an edge, R [rad^2]
    surprise  of the filter that begins again: nu^2/S + ln S, and what edges missed by this belief but not by that cost
    """
    innovation = edge.angle - prior.angle
    S = prior.angle_variance + variance
    odds = doubt.odds + 0.5 * (surprise - innovation * innovation / S - np.log(S))
    belief = update(prior, innovation, variance)
    return Doubt(belief, number=edge.number, odds=odds, slip=doubt.slip, edges=doubt.edges + 1.0)


def is_settled(doubt: Doubt) -> bool:
    """Whether the edges have spoken: clearly for one of the two, or for long."""
    return abs(doubt.odds) > DECIDED or doubt.edges >= LONGEST
