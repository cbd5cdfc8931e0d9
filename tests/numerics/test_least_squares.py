"""Straight lines by hand, intervals by chance, and the band by another library."""

import math

import numpy as np
import pytest
from scipy.optimize import curve_fit
from scipy.signal import lfilter

from vvdp.base.errors import ParameterError
from vvdp.numerics.least_squares import fit


def test_a_straight_line_by_hand():
    """Through (0, 1), (1, 3), (2, 4): 7/6 + 3/2 x; residuals -1/6, 1/3, -1/6; t(0.975, 1) = 12.706."""
    found = fit([np.ones(3), np.arange(3.0)], np.array([1.0, 3.0, 4.0]))
    assert found.coefficients == pytest.approx([7 / 6, 1.5])
    assert found.residuals == pytest.approx([-1 / 6, 1 / 3, -1 / 6])
    assert found.half_widths[1] == pytest.approx(12.7062 * math.sqrt(1 / 6 / 2), rel=1e-4)


def test_an_interval_holds_the_truth_as_often_as_it_says():
    """Of 400 noisy straight lines; a binomial of 0.95 has a deviation of 1.1 % there."""
    rng = np.random.default_rng(5)
    x = np.linspace(0.0, 1.0, 6)
    inside = 0
    for _ in range(400):
        found = fit([np.ones(6), x], 2.0 + 3.0 * x + rng.normal(0.0, 0.1, 6))
        inside += abs(found.coefficients[1] - 3.0) < found.half_widths[1]
    assert inside / 400 == pytest.approx(0.95, abs=0.035)


def test_covariance_and_band_are_those_of_another_library():
    """scipy.optimize.curve_fit; the band by hand: the variance of a + b x is Var a + 2 x Cov + x^2 Var b."""
    rng = np.random.default_rng(3)
    x = np.linspace(1.0, 4.0, 9)
    y = 2.0 - 0.7 * x + rng.normal(0.0, 0.2, 9)
    found = fit([np.ones(9), x], y)
    other, covariance = curve_fit(lambda x, a, b: a + b * x, x, y)
    assert found.coefficients == pytest.approx(other, rel=1e-6)
    assert found.covariance == pytest.approx(covariance, rel=1e-6)
    spread = math.sqrt(covariance[0, 0] + 6.0 * covariance[0, 1] + 9.0 * covariance[1, 1])
    assert found.half_band([np.ones(1), np.array([3.0])]) == pytest.approx([2.3646 * spread], rel=1e-4)


def test_columns_in_another_unit_give_the_same_law():
    x = np.linspace(1.0, 2.0, 5)
    y = 3.0 * x + np.array([0.1, -0.1, 0.05, 0.0, -0.05])
    plain, scaled = fit([x], y), fit([x / 1e3], y).scale(np.array([1e-3]))
    assert scaled.coefficients == pytest.approx(plain.coefficients)
    assert scaled.half_widths == pytest.approx(plain.half_widths)


def test_values_that_do_not_tell_the_coefficients_apart_are_refused():
    with pytest.raises(ParameterError, match="do not separate the 2 coefficients of a law"):
        fit([np.ones(4), np.full(4, 7.0)], np.arange(4.0))


def test_values_in_a_row_whose_errors_hang_together():
    """Errors e_i = 0.8 e_i-1 + n_i about a constant: its interval would hold it in half of all cases only."""
    rng = np.random.default_rng(4)
    held = np.zeros(2)
    for _ in range(300):
        errors = lfilter([1.0], [1.0, -0.8], rng.normal(size=600))[200:]
        plain = fit([np.ones(400)], 5.0 + errors)
        held += [abs(each.coefficients[0] - 5.0) < each.half_widths[0] for each in (plain, plain.in_series())]
    assert held[0] / 300 < 0.6
    assert held[1] / 300 == pytest.approx(0.95, abs=0.04)


def test_intervals_of_values_in_a_row_by_hand():
    """Residuals 2, 2, -2, -2: c = (4 - 4 + 4)/16, so the covariance is (1 + c)/(1 - c) = 5/3 times as large."""
    plain = fit([np.ones(4)], np.array([7.0, 7.0, 3.0, 3.0]))
    assert plain.in_series().covariance == pytest.approx(5.0 / 3.0 * plain.covariance)
    swinging = fit([np.ones(4)], np.array([7.0, 3.0, 7.0, 3.0]))
    assert swinging.in_series().covariance == pytest.approx(swinging.covariance)
