"""The pressure of a place that holds no oil, at which as much flows in as out.

It is searched for in rounds; each evaluates the laws of the components there for the net inflow at one pressure,
`guess`. That inflow must not grow with the pressure. The interval that holds the pressure is first the one between the
pressures around, then, where a pump pushes or draws, all up to `HIGHEST` or down to `LOWEST`.
"""

from typing import NamedTuple

from vvdp.base.kinds import Count, Flow, Pressure
from vvdp.base.select import clip, maximum, minimum, select

LOWEST, HIGHEST = 0.0, 1e9
"""Pressures between which every search stays, absolute [Pa]."""
TOLERANCE = 1e-6
"""Width of the interval at which a search ends [Pa]."""
ROUNDS = 54.0
"""Rounds after which every search has ended: both ends, one to spare, and 50 halvings of `HIGHEST`."""
TRUNCATION = 0.2
"""Distance from the secant towards the middle by which a guess is moved, times interval over first interval [1]."""
LEAST_FLOW = 1e-300
"""Least flow, which keeps the secant of two inflows of zero finite [m^3/s]."""


class PressureSearch(NamedTuple):
    """State of a search: the pressure lies from `low` to `high`, with these net inflows there.

    width  of the interval once both ends were evaluated [Pa]
    reach  width that halving alone would have left, doubled [Pa]
    rounds that are over
    """

    guess: Pressure
    low: Pressure
    high: Pressure
    inflow_low: Flow
    inflow_high: Flow
    width: Pressure
    reach: Pressure
    rounds: Count


def begin_search(low: float, high: float) -> PressureSearch:
    """The search for a pressure near those around: from `low` to `high`, absolute [Pa].

    Source  ours, docs/models/components.md
    """
    return PressureSearch(
        guess=low, low=low, high=high, inflow_low=0.0, inflow_high=0.0, width=high - low, reach=high - low, rounds=0.0
    )


def next_search(search: PressureSearch, inflow: float) -> PressureSearch:
    """The search after the round that found a net `inflow` [m^3/s] at its guess.

    The first two rounds ask at both ends; all others by interpolation, truncation and projection, which needs at most
    one round more than halving.

    Source  oliveira2020, algorithm 1 with kappa_2 = 2 and n_0 = 1
    """
    asked, too_low, is_first = search.guess, inflow >= 0.0, search.rounds == 0.0
    at_end, is_above = search.rounds <= 1.0, select(search.rounds == 1.0, inflow > 0.0, False)
    low = select(too_low, asked, select(is_first, LOWEST, search.low))
    high = select(too_low, select(is_above, HIGHEST, search.high), asked)
    width = select(at_end, high - low, search.width)
    found = PressureSearch(
        guess=asked,
        low=low,
        high=high,
        inflow_low=select(too_low, inflow, select(is_first, -inflow, search.inflow_low)),
        inflow_high=select(too_low, select(is_above, -inflow, search.inflow_high), inflow),
        width=width,
        reach=select(at_end, width, 0.5 * search.reach),
        rounds=search.rounds + 1.0,
    )
    return found._replace(guess=_next_guess(found))


def _next_guess(search: PressureSearch) -> float:
    """Guess of the next round [Pa]: at the upper end, then inside; that of the last round once the pressure is
    found."""
    low, high = search.low, search.high
    middle, interval = 0.5 * (low + high), high - low
    share = search.inflow_low / maximum(search.inflow_low - search.inflow_high, LEAST_FLOW)
    secant = low + share * interval
    moved = maximum(TRUNCATION * interval * interval / maximum(search.width, TOLERANCE), 0.4 * TOLERANCE)
    truncated = select(secant < middle, minimum(secant + moved, middle), maximum(secant - moved, middle))
    room = search.reach - 0.5 * interval
    inside = select(interval <= TOLERANCE, search.guess, clip(truncated, middle - room, middle + room))
    return select(search.rounds <= 1.0, high, inside)
