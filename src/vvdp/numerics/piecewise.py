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
