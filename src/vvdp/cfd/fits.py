"""Laws fitted to what was computed, by least squares, with the confidence of their coefficients."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ParameterError

CONFIDENCE = 0.95


class Fit(NamedTuple):
    """Coefficients of a law, half the width of the interval that holds each with 95 %, and what the law leaves over."""

    coefficients: Array
    half_widths: Array
    residuals: Array


def fit(columns: Sequence[Array], seen: Array) -> Fit:
    """The sum of `columns`, each times a coefficient, that comes closest to what was `seen`.

    The scatter about the law stands for the error of each value, so its square sum over the degrees of freedom, and
    Student's t, give the intervals. Raises ParameterError where there are not more values than coefficients.
    """
    from scipy.stats import t

    matrix = np.column_stack(columns)
    free = len(seen) - matrix.shape[1]
    if free < 1:
        raise ParameterError(f"{len(seen)} values; a law with {matrix.shape[1]} coefficients needs more")
    coefficients = np.asarray(np.linalg.lstsq(matrix, seen, rcond=None)[0], np.float64)
    residuals = seen - matrix @ coefficients
    variances = np.linalg.inv(matrix.T @ matrix).diagonal() * float(residuals @ residuals) / free
    return Fit(coefficients, np.sqrt(variances) * float(t.ppf(0.5 + 0.5 * CONFIDENCE, free)), residuals)


class DropLaws(NamedTuple):
    """Laws of a pressure drop [Pa] over flow Q [m^3/s].

    orifice   c Q^2
    two_term  a Q + b Q^2
    power     logarithm of k Q^m: coefficients log k and m
    """

    orifice: Fit
    two_term: Fit
    power: Fit


def drop_laws(flows: Array, drops: Array) -> DropLaws:
    """All laws of a drop. Raises ParameterError where fewer than three flows are there.

    Columns are scaled to 1 at the largest flow, or their squares would differ by ten orders of magnitude.
    """
    q = flows / flows.max()
    scale = np.array([1.0, 1.0]) / flows.max() ** np.array([1.0, 2.0])
    return DropLaws(
        orifice=_scale(fit([q**2], drops), scale[1:]),
        two_term=_scale(fit([q, q**2], drops), scale),
        power=fit([np.ones_like(flows), np.log(flows)], np.log(drops)),
    )


def _scale(found: Fit, scale: Array) -> Fit:
    return Fit(found.coefficients * scale, found.half_widths * scale, found.residuals)
