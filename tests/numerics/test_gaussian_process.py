"""Curves through results: a law known beforehand, its gradient by differences, and what it says of its own error."""

import numpy as np
import pytest

from vvdp.numerics import gaussian_process
from vvdp.numerics.gaussian_process import fit_surrogate

POINTS = np.random.default_rng(7).random((64, 3))
NEW = np.random.default_rng(8).random((500, 3))


def law(x):
    """Depends on two of three inputs, with a bend."""
    return 2.0 + np.sin(3.0 * x[:, 0]) + x[:, 0] * x[:, 1] ** 2


def test_the_curve_passes_through_results_and_between_them():
    found = fit_surrogate(POINTS, law(POINTS))
    assert found(POINTS) == pytest.approx(law(POINTS), abs=1e-3)
    missed = np.mean((found(NEW) - law(NEW)) ** 2) / np.var(law(NEW))
    assert missed < 1e-3
    assert found.unexplained < 1e-3


def test_an_input_without_effect_is_found():
    lengths = fit_surrogate(POINTS, law(POINTS)).lengths
    assert lengths[2] > 5.0 * max(lengths[0], lengths[1])


def test_what_is_missed_is_told_beforehand():
    """Noise of a variance of 1/4 of that of the law: no curve can tell it, and a fifth of the variance is missed."""
    results = law(POINTS) + 0.5 * np.std(law(POINTS)) * np.random.default_rng(9).standard_normal(64)
    assert fit_surrogate(POINTS, results).unexplained == pytest.approx(0.2, abs=0.1)


def test_the_gradient_is_that_of_the_likelihood():
    y = (law(POINTS) - np.mean(law(POINTS))) / np.std(law(POINTS))
    at, small = np.array([0.1, -0.4, 0.8, -2.0]), 1e-5
    value = gaussian_process._unlikeliness
    differences = [
        (value(at + small * e, POINTS, y)[0] - value(at - small * e, POINTS, y)[0]) / (2.0 * small) for e in np.eye(4)
    ]
    assert value(at, POINTS, y)[1] == pytest.approx(differences, rel=1e-5)


def test_units_do_not_count():
    small, large = (fit_surrogate(POINTS, scale * law(POINTS) + 1.0) for scale in (1e-6, 1e6))
    assert small.unexplained == pytest.approx(large.unexplained, rel=1e-6)
    assert (large(NEW) - 1.0) / 1e12 == pytest.approx(small(NEW) - 1.0, rel=1e-6)


def test_results_without_scatter_are_refused():
    with pytest.raises(ValueError, match="all the same"):
        fit_surrogate(POINTS, np.ones(64))
