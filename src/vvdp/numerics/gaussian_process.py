"""A smooth curve through the results of few costly runs: regression by a Gaussian process.

Each input has a length of its own over which results change, found as the most likely ones. What the curve misses is
known without further runs: each result is compared with the curve through all others.

Source  rasmussen2006, ch. 2 and 5.4
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array

LENGTHS = (-3.0, 5.0)
NOISE = (-9.0, 1.0)
"""Logarithms between which lengths, in parts of an input's range, and noise, in parts of the scatter, are sought."""
JITTER = 1e-10
ITERATIONS = 60
ROWS = 4096
"""Rows that are predicted at a time, which bounds the memory."""


class Surrogate(NamedTuple):
    """A curve through results at `points` of a unit cube.

    `unexplained` is the part of the variance of the results that the curve through all others misses at each.
    """

    points: Array  # (n, inputs)
    lengths: Array  # (inputs,)
    weights: Array  # (n,)
    mean: float
    unexplained: float

    def __call__(self, places: Array) -> Array:
        """The results expected at `places`, shape (rows, inputs)."""
        parts = np.array_split(places, max(1, -(-len(places) // ROWS)))
        return self.mean + np.concatenate(
            [_correlation(_squares(each, self.points, self.lengths))[0] @ self.weights for each in parts]
        )


def fit_surrogate(points: Array, results: Array) -> Surrogate:
    """The most likely curve through `results` at `points` of a unit cube, shape (n, inputs).

    Raises ValueError where the results do not scatter.
    """
    from scipy.optimize import minimize

    mean, scale = float(np.mean(results)), float(np.std(results))
    if not scale > 0.0:
        raise ValueError("the results are all the same")
    y = (results - mean) / scale
    inputs = points.shape[1]
    start = np.append(np.full(inputs, np.log(2.0)), np.log(0.05))
    bounds = [LENGTHS] * inputs + [NOISE]
    found = minimize(
        _unlikeliness, start, (points, y), jac=True, method="L-BFGS-B", bounds=bounds, options={"maxiter": ITERATIONS}
    )
    lengths, noise = np.exp(found.x[:-1]), float(np.exp(2.0 * found.x[-1]))
    inverse = np.linalg.inv(_covariance(_correlation(_squares(points, points, lengths))[0], noise))
    weights = inverse @ y
    missed = weights / np.diag(inverse)
    return Surrogate(
        points=points, lengths=lengths, weights=scale * weights, mean=mean, unexplained=float(np.mean(missed**2))
    )


def _unlikeliness(logs: Array, points: Array, y: Array) -> tuple[float, Array]:
    """Minus the logarithm of the likelihood of lengths and noise, but for a constant, and its gradient.

    The variance is the most likely one: n/2 log(y' K^-1 y) + log|K|/2.
    """
    lengths, noise = np.exp(logs[:-1]), np.exp(2.0 * logs[-1])
    correlation, slope = _correlation(_squares(points, points, lengths))
    covariance = _covariance(correlation, noise)
    inverse = np.linalg.inv(covariance)
    weights = inverse @ y
    fit = float(y @ weights)
    value = 0.5 * len(y) * np.log(fit) + 0.5 * np.linalg.slogdet(covariance)[1]
    by_covariance = 0.5 * (inverse - np.outer(weights, weights) * len(y) / fit)
    by_square = by_covariance * slope
    # d/dlog(l) of sum_ij W_ij (x_i - x_j)^2/l^2, without the differences of all pairs
    rows = np.sum(by_square, axis=1)
    by_length = -2.0 / lengths**2 * (2.0 * (rows @ points**2) - 2.0 * np.sum(points * (by_square @ points), axis=0))
    return float(value), np.append(by_length, 2.0 * noise * np.trace(by_covariance))


def _squares(a: Array, b: Array, lengths: Array) -> Array:
    """Squared distances between all rows of `a` and `b`, each input over its length."""
    u, v = a / lengths, b / lengths
    found: Array = np.sum(u**2, axis=1)[:, None] + np.sum(v**2, axis=1) - 2.0 * (u @ v.T)
    return np.clip(found, 0.0, None)


def _correlation(squares: Array) -> tuple[Array, Array]:
    """Matern's correlation of twice differentiable curves, (1 + r + r^2/3) e^-r with r = sqrt(5 squares), and its slope
    over the squares, -5/6 (1 + r) e^-r."""
    r = np.sqrt(5.0 * squares)
    decay = np.exp(-r)
    return (1.0 + r + r * r / 3.0) * decay, -5.0 / 6.0 * (1.0 + r) * decay


def _covariance(correlation: Array, noise: float) -> Array:
    covariance: Array = correlation + (noise + JITTER) * np.eye(len(correlation))
    return covariance
