"""Laws of the jets come back from what they gave, and their intervals are those of another library."""

import math

import numpy as np
import pytest
from scipy.optimize import curve_fit
from tests.words import wording

from vvdp.base.errors import ParameterError
from vvdp.fitting.jet import jet_law

OPENINGS = np.array([1.0, 0.75, 0.75, 0.5, 0.5, 0.25, 0.25])
SIDES = np.array([0.0, 1.0, -1.0, 1.0, -1.0, 1.0, -1.0])


def log_torque(at, torque, exponent, asymmetry):
    openings, sides = at
    return np.log(torque * openings**-exponent * (1.0 + sides * asymmetry * (1.0 - openings)))


def test_exact_jets_come_back():
    found = jet_law(OPENINGS, np.exp(log_torque((OPENINGS, SIDES), 0.13, 0.65, 0.85)), SIDES)
    assert found.coefficients == pytest.approx([math.log(0.13), 0.65, 0.85], rel=1e-9)
    assert found.half_widths == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)


def test_jets_of_the_mean_have_no_asymmetry():
    found = jet_law(OPENINGS, 0.13 * OPENINGS**-0.65, np.zeros(7))
    assert found.coefficients == pytest.approx([math.log(0.13), 0.65])


def test_noisy_jets_are_as_another_library_has_them():
    """scipy.optimize.curve_fit, which differences the law where this one has its slopes."""
    rng = np.random.default_rng(11)
    seen = log_torque((OPENINGS, SIDES), 0.13, 0.65, 0.85) + rng.normal(0.0, 0.05, 7)
    found = jet_law(OPENINGS, np.exp(seen), SIDES)
    other, covariance = curve_fit(log_torque, (OPENINGS, SIDES), seen, p0=(0.1, 0.5, 0.5))
    assert found.coefficients[1:] == pytest.approx(other[1:], rel=1e-5)
    assert np.sqrt(found.covariance.diagonal()[1:]) == pytest.approx(np.sqrt(covariance.diagonal()[1:]), rel=1e-3)


def test_an_interval_of_the_asymmetry_holds_the_truth_as_often_as_it_says():
    """Of 300 noisy tables; a binomial of 0.95 has a deviation of 1.3 % there. The law bends, so somewhat wider."""
    rng = np.random.default_rng(7)
    exact = log_torque((OPENINGS, SIDES), 0.13, 0.65, 0.6)
    inside = np.zeros(3)
    for _ in range(300):
        found = jet_law(OPENINGS, np.exp(exact + rng.normal(0.0, 0.03, 7)), SIDES)
        inside += np.abs(found.coefficients - [math.log(0.13), 0.65, 0.6]) < found.half_widths
    assert inside / 300 == pytest.approx([0.95] * 3, abs=0.04)


def test_openings_that_are_all_one_tell_no_exponent():
    with pytest.raises(ParameterError, match=wording.fit.do_not_tell):
        jet_law(np.ones(5), np.linspace(0.1, 0.2, 5), np.zeros(5))
