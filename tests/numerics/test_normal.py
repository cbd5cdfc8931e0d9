"""The normal distribution and beliefs cut off at bounds: against scipy, on a grid, by hand; two halves make a whole."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import norm, truncnorm

from vvdp.numerics.kalman import AngleSpeed
from vvdp.numerics.normal import normal_density, normal_share, truncate


@st.composite
def beliefs(draw):
    """Deviations from 0.01 to 10 and a correlation up to 0.95."""
    a, b = (10.0 ** draw(st.floats(-2.0, 1.0)) for _ in range(2))
    r = draw(st.floats(-0.95, 0.95))
    return AngleSpeed(draw(st.floats(-5.0, 5.0)), draw(st.floats(-200.0, 200.0)), a * a, r * a * b, b * b)


def second_moments(belief, about):
    """Of angle and speed, and their product, about the means of another belief."""
    a, v = belief.angle - about.angle, belief.speed - about.speed
    return np.array([belief.angle_variance + a * a, belief.covariance + a * v, belief.speed_variance + v * v])


@pytest.mark.parametrize("z", [-37.0, -8.0, -1.0, 0.0, 0.3, 2.0, 9.0])
def test_density_and_share_are_those_of_scipy(z):
    assert normal_density(z) == pytest.approx(norm.pdf(z), rel=1e-12)
    assert normal_share(z) == pytest.approx(norm.cdf(z), rel=1e-12)


def test_half_of_a_belief_by_hand():
    """Angle 2 +- 3, correlation 1/2 with a speed of 5 +- 4: the upper half has its mean 3 sqrt(2/pi) higher and the
    variance 9 (1 - 2/pi); the speed goes up by 1/2 x 4 sqrt(2/pi) and loses 1/4 x 16 x 2/pi.
    """
    after = truncate(AngleSpeed(2.0, 5.0, 9.0, 6.0, 16.0), 0.0, np.inf, 3.0)
    m, lost = np.sqrt(2.0 / np.pi), 2.0 / np.pi
    assert after == pytest.approx((2.0 + 3.0 * m, 5.0 + 2.0 * m, 9.0 - 9.0 * lost, 6.0 - 6.0 * lost, 16.0 - 4.0 * lost))


@pytest.mark.parametrize(
    ("low", "high"),
    [(-1.0, 2.0), (0.5, np.inf), (-np.inf, -2.0), (-3.0, -2.5), (4.0, 4.5), (6.0, np.inf), (-np.inf, -6.0), (6.9, 7.2)],
)
def test_an_angle_between_exact_bounds_is_a_truncated_normal(low, high):
    after = truncate(AngleSpeed(1.0, 0.0, 0.25, 0.0, 1.0), low, high, 0.5)
    exact = truncnorm(low, high)
    assert (after.angle - 1.0) / 0.5 == pytest.approx(exact.mean(), rel=1e-9)
    assert after.angle_variance / 0.25 == pytest.approx(exact.var(), rel=1e-8)


@given(beliefs(), st.floats(-3.0, 3.0), st.floats(1.0, 4.0))
def test_two_halves_of_a_belief_make_it_whole(belief, cut, noise):
    """Law of total expectation and variance: what lies below a bound and what lies above it, by their shares."""
    deviation = noise * np.sqrt(belief.angle_variance)
    below, above = (truncate(belief, *bounds, deviation) for bounds in ((-np.inf, cut), (cut, np.inf)))
    w = norm.cdf(cut)
    scale = np.sqrt(belief.angle_variance), np.sqrt(belief.speed_variance)
    for i in range(2):
        assert abs(w * below[i] + (1.0 - w) * above[i] - belief[i]) < 1e-10 * (scale[i] + abs(belief[i]))
    whole = w * second_moments(below, belief) + (1.0 - w) * second_moments(above, belief)
    units = np.array([scale[0] ** 2, scale[0] * scale[1], scale[1] ** 2])
    assert np.max(np.abs(whole - np.array(belief[2:])) / units) < 1e-9


def test_bounds_with_noise_against_a_grid():
    """A bound of deviation r is kept by an angle x with the chance Phi((b - x)/r): the posterior on a grid of angle and
    speed."""
    belief, r, low, high = AngleSpeed(0.2, 3.0, 0.09, 0.12, 0.25), 0.4, -0.3, 0.35
    x, v = np.meshgrid(0.2 + np.linspace(-2.4, 2.4, 801), 3.0 + np.linspace(-4.0, 4.0, 801), indexing="ij")
    P = np.array([[0.09, 0.12], [0.12, 0.25]])
    off = np.stack([x - 0.2, v - 3.0], axis=-1)
    weight = np.exp(-0.5 * np.einsum("...i,ij,...j", off, np.linalg.inv(P), off))
    weight *= norm.cdf((high - x) / r) - norm.cdf((low - x) / r)
    weight /= weight.sum()
    mean = [np.sum(weight * x), np.sum(weight * v)]
    square = [np.sum(weight * a * b) for a, b in ((x - mean[0],) * 2, (x - mean[0], v - mean[1]), (v - mean[1],) * 2)]
    s = np.sqrt(0.09 + r * r)
    assert truncate(belief, (low - 0.2) / s, (high - 0.2) / s, s) == pytest.approx((*mean, *square), rel=1e-6)


def test_no_bounds_change_nothing():
    belief = AngleSpeed(1.0, 2.0, 3.0, 1.0, 4.0)
    assert truncate(belief, -np.inf, np.inf, 2.0) == belief
