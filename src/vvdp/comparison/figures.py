"""Figures over many runs, each with its standard error."""

from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array

UNITS = ("_rad_s", "_rad", "_s", "_m")
"""With which the keys of figures end."""


class Measured(NamedTuple):
    """A figure over all seeds and its standard error, NaN where there is none."""

    value: float
    error: float = np.nan


def error_key(key: str) -> str:
    """The key of the standard error of a figure: `speed_error_rms_se_rad_s`."""
    unit = next((unit for unit in UNITS if key.endswith(unit)), "")
    return f"{key.removesuffix(unit)}_se{unit}"


def mean(values: Array) -> Measured:
    """The mean and its standard error sd/sqrt(n)."""
    n = values.size
    if not np.isfinite(values).all():
        return Measured(float(np.mean(values)))
    return Measured(float(np.mean(values)), float(np.std(values, ddof=1) / np.sqrt(n)) if n > 1 else np.nan)


def root_mean(squares: Array) -> Measured:
    """The root of the mean of squares, its standard error by the delta method."""
    square, error = mean(squares)
    root = float(np.sqrt(square))
    return Measured(root, error / (2.0 * root) if root > 0.0 else 0.0)


def quantile(values: Array, share: float) -> Measured:
    """The value that `share` of the `values` do not exceed, with its standard error; infinite values are large ones.

    NaN where a value is not known. The number of values below the quantile is binomial, with deviation
    sqrt(n share (1 - share)).
    """
    if np.isnan(values).any():
        return Measured(np.nan)
    ordered, n = np.sort(values), values.size
    place, spread = share * (n - 1), np.sqrt(n * share * (1.0 - share))
    low, middle, high = (ordered[int(np.clip(round(place + d), 0, n - 1))] for d in (-spread, 0.0, spread))
    error = 0.5 * (high - low) if np.isfinite(high) else np.nan
    return Measured(float(middle), float(error) if n > 1 else np.nan)
