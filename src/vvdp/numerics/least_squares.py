"""Laws that are sums of columns, fitted by least squares, with the confidence of their coefficients."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ParameterError

CONFIDENCE = 0.95


class Fit(NamedTuple):
    """Coefficients of a law, their covariance, what the law leaves over, and Student's quantile of the confidence."""

    coefficients: Array
    covariance: Array
    residuals: Array
    quantile: float

    @property
    def half_widths(self) -> Array:
        """Half the width of the interval that holds each coefficient with 95 %."""
        widths: Array = self.quantile * np.sqrt(self.covariance.diagonal())
        return widths

    def half_band(self, columns: Sequence[Array]) -> Array:
        """Half the width of the band that holds the law with 95 % at each row of `columns`."""
        matrix = np.column_stack(columns)
        widths: Array = self.quantile * np.sqrt(np.einsum("ij,jk,ik->i", matrix, self.covariance, matrix))
        return widths

    def in_series(self) -> "Fit":
        """The same fit, of values in a row whose residuals r hang together, with wider intervals.

        So many values say no more than (1 - c)/(1 + c) of them would, c = sum r_i r_i+1 / sum r_i^2 where above 0.

        Source  bartlett1946
        """
        square = float(self.residuals @ self.residuals)
        together = float(self.residuals[1:] @ self.residuals[:-1]) / square if square else 0.0
        return self._replace(covariance=self.covariance * (1.0 + max(together, 0.0)) / (1.0 - max(together, 0.0)))

    def scale(self, factors: Array) -> "Fit":
        """The fit of columns that are smaller by `factors`: its coefficients are larger by them."""
        return self._replace(
            coefficients=self.coefficients * factors, covariance=self.covariance * np.outer(factors, factors)
        )


def fit(columns: Sequence[Array], seen: Array) -> Fit:
    """The sum of `columns`, each times a coefficient, that comes closest to what was `seen`.

    The scatter about the law stands for the error of each value, so its square sum over the degrees of freedom, and
    Student's t, give the intervals. Raises ParameterError where there are not more values than coefficients, or the
    columns cannot be distinguished.
    """
    from scipy.stats import t

    matrix = np.column_stack(columns)
    free = len(seen) - matrix.shape[1]
    if free < 1:
        raise ParameterError(f"{len(seen)} values; a law with {matrix.shape[1]} coefficients needs more")
    coefficients, _, rank, _ = np.linalg.lstsq(matrix, seen, rcond=None)
    if rank < matrix.shape[1]:
        raise ParameterError(f"{len(seen)} values do not separate the {matrix.shape[1]} coefficients of a law")
    residuals = seen - matrix @ coefficients
    covariance = np.linalg.inv(matrix.T @ matrix) * float(residuals @ residuals) / free
    quantile = float(t.ppf(0.5 + 0.5 * CONFIDENCE, free))
    return Fit(np.asarray(coefficients, np.float64), covariance, residuals, quantile)
