"""Straight lines through points: what a calibration says between its rows."""

from collections.abc import Sequence

from vvdp.base.errors import ParameterError
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


def check_rising(name: str, values: Sequence[float], *, strictly: bool = True) -> None:
    """Refuse, with a ParameterError that names the row, a column that does not rise from row to row."""
    for row in range(1, len(values)):
        before, after = values[row - 1], values[row]
        if after < before or (strictly and after == before):
            expected = "a value above" if strictly else "a value not below"
            raise ParameterError(
                f"{name}: row {row + 1} has {after:g}; expected {expected} that of row {row}, {before:g}"
            )
