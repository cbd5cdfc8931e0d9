"""Number of an observed edge on the wheel. The wheel is taken to turn forward only: numbers never fall.

Source  ours, docs/models/event-filter.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import Angle, AngularVariance, Count
from vvdp.base.select import maximum, minimum
from vvdp.sensing.wheel import TURN, CodeWheel, edge_angle, edge_below, edge_polarity, nearest_edge

FARTHEST = 7.0
"""Deviations, those after a manoeuvre, that an early edge may lie from where it was expected [1]."""

REMEMBERED = 64.0
"""Edges over which the share of irregular ones is averaged [1]."""

RAREST = 1e-3
"""Least share of missed edges that is calculated with [1]."""

BURSTY = 32.0
"""Edges that the share of missed ones is worth at most: sensors miss several in a row [1]."""

UNWATCHED = 5.0
"""Weight of the prior of the sensor, in edges [1]."""

MOST_MISSED = 32.0
"""Edges beyond which it makes no difference how many are missed in a row [1]."""

DROPOUT = 1e-6
"""Chance at an edge that the sensor falls silent, for however long [1]."""


class Sighting(NamedTuple):
    """An observed edge: the expected angle of the spool, and the edges since the last one that was used.

    `variance` is that of the expected edge, `manoeuvre_variance` the one that it would have had the wheel begun to slow
    down at the last edge used, `manoeuvre_odds` the logarithm of the odds against that. `advance` is how far the
    spool should have come since then, `ignored` how many edges were taken for bounce since, `fresh` how many came since
    the last sample. `irregular` is the share of edges that were missed or ignored of late.
    """

    angle: Angle
    advance: Angle
    variance: AngularVariance
    manoeuvre_variance: AngularVariance
    manoeuvre_odds: float
    ignored: Count
    fresh: Count
    polarity: float
    irregular: float


class Association(NamedTuple):
    """Number of the observed edge, 1 if it is to be used, 0 if it was none, and the growth of the angle's variance
    since it may have been another edge [rad^2]."""

    edge: float
    used: float
    slip: AngularVariance


def sector(wheel: CodeWheel) -> float:
    """Mean width of a sector [rad]."""
    return TURN / len(wheel.edges)


def counted_edge(last: float, edges: float, polarity: float) -> float:
    """Number of the edge seen, `edges` after the edge numbered `last`; one more where its polarity states this.

    polarity  +1 rising, -1 falling, 0 unknown

    Source  wang2017, eq. 3.2; the polarity is ours, docs/models/event-filter.md
    """
    number = last + edges
    return number + 1.0 if polarity * edge_polarity(number) < 0.0 else number


def first_edge(angle: float, polarity: float, wheel: CodeWheel) -> float:
    """Number of the first edge that passes after the wheel stood at `angle` [rad], known to half a sector."""
    if polarity == 0.0:
        return edge_below(angle, wheel) + 1.0
    return nearest_edge(angle + 0.5 * sector(wheel), polarity, wheel)


def associated_edge(last: float, sighting: Sighting, wheel: CodeWheel) -> Association:
    """Association of an observed edge with its number, by a filter that knows the angle.

    The likelier of two: the nearest of the observed polarity, with edges missed in between or the sensor silent, or
    the next by count, where it was expected or after a manoeuvre. Edges for which too little of a sector has passed
    are the bounce of the last one: pairs of them are left out, a single one is none.

    last  number of the last edge used
    """
    next_sector = edge_angle(last + 1.0, wheel) - edge_angle(last, wheel)
    fresh, reach = sighting.fresh, sighting.advance + np.sqrt(sighting.variance)
    while fresh > 1.0 and reach < (fresh - 0.5) * next_sector:
        fresh -= 2.0
    counted = counted_edge(last, sighting.ignored + fresh, sighting.polarity)
    nearest = nearest_edge(sighting.angle, sighting.polarity, wheel)
    away = edge_angle(counted, wheel) - sighting.angle
    early = sighting.advance < 0.5 * next_sector
    far = away * away > FARTHEST * FARTHEST * sighting.manoeuvre_variance
    if fresh < 0.5 or (early and far):
        return Association(counted, 0.0, 0.0)
    if nearest <= last or nearest == counted:
        return Association(counted, 1.0, 0.0)

    S, S_m = sighting.variance, sighting.manoeuvre_variance
    manoeuvre = sighting.manoeuvre_odds + 0.5 * away * away / S_m + 0.5 * np.log(S_m / S)
    count_cost = minimum(0.5 * away * away / S, manoeuvre)
    off = edge_angle(nearest, wheel) - sighting.angle
    odd = abs(nearest - counted)  # edges missed, or too many
    nearest_cost = 0.5 * off * off / S - np.log(maximum(missed_share(sighting.irregular) ** odd, DROPOUT))
    between = edge_angle(nearest, wheel) - edge_angle(counted, wheel)
    odds = np.exp(-abs(nearest_cost - count_cost))
    slip = between * between * odds / (1.0 + odds)
    return Association(nearest if nearest_cost < count_cost else counted, 1.0, slip)


def missed_share(irregular: float) -> float:
    """Chance that an edge is missed [1], where a share `irregular` of them was missed or ignored of late."""
    return maximum(irregular, RAREST)


def missed_in_a_row(irregular: float, watched: float, edges: float) -> float:
    """Chance that so many `edges` are missed one after another [1], where their share is known from few.

    A share p with the beta distribution of a = p n, b = (1 - p) n, n = `watched` + 5, makes each miss the next one
    likelier: a/n (a + 1)/(n + 1) (a + 2)/(n + 2) ...

    irregular  share of edges that were missed or ignored of late [1]
    watched    edges that this share rests on [1]

    Source  johnson2005, beta-binomial distribution, section 6.2.2; the 5 is ours, docs/models/event-filter.md
    """
    n = minimum(watched, BURSTY) + UNWATCHED
    a = missed_share(irregular) * n
    chance = 1.0
    for i in range(int(minimum(edges, MOST_MISSED))):
        chance *= (a + i) / (n + i)
    return chance


def irregular_share(share: float, irregular: float, regular: float) -> float:
    """Share of edges that were missed or ignored [1], after `irregular` more of them and `regular` others."""
    kept = 1.0 - 1.0 / REMEMBERED
    grown: float = (1.0 - (1.0 - share) * kept**irregular) * kept**regular
    return grown
