"""Straight lines through points: what a calibration says between its rows."""

from collections.abc import Sequence

from vvdp.base.select import clip


def piecewise_linear(place: float, places: Sequence[float], values: Sequence[float]) -> float:
    """Value on straight lines through points, held before the first and after the last, in the unit of `values`.

    place   where it is asked for, in the unit of `places`
    places  of the points, strictly increasing
    values  at them
    """
    value = values[0]
    for i in range(len(places) - 1):
        share = clip((place - places[i]) / (places[i + 1] - places[i]), 0.0, 1.0)
        value = value + (values[i + 1] - values[i]) * share
    return value


def line_through(place: float, places: Sequence[float], values: Sequence[float], repeats: float) -> float:
    """Value on straight lines through points that begin at place 0, found by bisection, in the unit of `values`.

    place    0 or greater, in the unit of `places`
    places   of the points, strictly increasing from 0 on
    values   at them
    repeats  above 0: the points come again after the last one; 0: the last value is held
    """
    last = len(places) - 1
    within = place % places[last] if repeats > 0.0 else place
    if within >= places[last]:
        return values[last]
    low, high = 0, last
    while high - low > 1:
        middle = (low + high) // 2
        if places[middle] <= within:
            low = middle
        else:
            high = middle
    share = (within - places[low]) / (places[high] - places[low])
    return values[low] + share * (values[high] - values[low])
