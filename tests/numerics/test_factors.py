"""Factors of a covariance: against whole matrices, by hand, and over many samples in double and single precision."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.compiled import compiled
from tests.dense_filter import predict_n, update_n

from vvdp.numerics.kalman import (
    add_variance,
    consider,
    covariance_of,
    factors_of,
    know_leading,
    move_leading,
    observe,
    variance_of,
)


@st.composite
def covariances(draw, least=2, most=14):
    """Deviations over six decades, correlations as they come."""
    n = draw(st.integers(least, most))
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    scale = 10.0 ** rng.uniform(-6.0, 0.0, n)
    root = rng.normal(size=(n, n))
    return scale[:, None] * (root @ root.T + 0.05 * np.eye(n)) * scale, rng


def off(found, expected):
    """The largest difference, each entry over the deviations of its two states."""
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    return np.max(np.abs(found - expected) / np.where(scale > 0.0, scale, 1.0))


def test_factors_by_hand():
    """P = [[6, 2], [2, 4]]: D_2 = 4, U_12 = 2/4, D_1 = 6 - 4/4 = 5; an exact second state leaves D_2 = U_12 = 0."""
    np.testing.assert_array_equal(factors_of(np.array([[6.0, 2.0], [2.0, 4.0]])), [[5.0, 0.0], [0.5, 4.0]])
    np.testing.assert_array_equal(factors_of(np.diag([3.0, 0.0])), np.diag([3.0, 0.0]))


def test_measurement_by_hand():
    """P = diag(3, 1), H = (1, 1), R = 4: S = 8, K = (3, 1)/8, P+ = diag(3, 1) - (3, 1)(3, 1)'/8."""
    F, gain = factors_of(np.diag([3.0, 1.0])), np.empty(2)
    assert observe(F, np.ones(2), 4.0, gain) == 8.0
    np.testing.assert_allclose(gain, [3.0 / 8.0, 1.0 / 8.0])
    np.testing.assert_allclose(covariance_of(F), [[15.0 / 8.0, -3.0 / 8.0], [-3.0 / 8.0, 7.0 / 8.0]])


@given(covariances())
def test_factors_and_back(case):
    P, _ = case
    F = factors_of(P)
    assert off(covariance_of(F), P) < 1e-12
    assert np.all(np.diag(F) > 0.0)
    np.testing.assert_array_equal(np.triu(F, 1), 0.0)
    for i in range(P.shape[0]):
        assert variance_of(F, i) == pytest.approx(P[i, i], rel=1e-11)


@given(covariances(), st.floats(-8.0, 0.0))
def test_measurement_is_that_of_whole_matrices(case, exponent):
    P, rng = case
    n, R = P.shape[0], 10.0**exponent
    F, H, gain = factors_of(P), rng.normal(size=n), np.empty(n)
    S = observe(F, H, R, gain)
    expected_gain, expected = update_n(np.zeros(n), P, H, 1.0, R)
    assert pytest.approx(H @ P @ H + R, rel=1e-10) == S
    np.testing.assert_allclose(gain / np.sqrt(np.diag(P)), expected_gain / np.sqrt(np.diag(P)), rtol=1e-10, atol=1e-10)
    # The whole matrices lose digits where R is small against H P H'; the factors are held against P before.
    found = covariance_of(F)
    assert np.max(np.abs(found - expected) / np.sqrt(np.outer(np.diag(P), np.diag(P)))) < 1e-10
    np.testing.assert_array_equal(found, found.T)
    assert np.all(np.diag(F) > 0.0)


@given(covariances(4), st.integers(1, 3))
def test_moving_the_leading_states_is_that_of_whole_matrices(case, m):
    P, rng = case
    n = P.shape[0]
    scale = np.sqrt(np.diag(P)[:m])
    block = scale[:, None] * rng.normal(size=(m, m)) / scale
    noise, mean = scale**2 * rng.uniform(1e-6, 1.0, m), rng.normal(size=n)
    whole, Q = np.eye(n), np.zeros(n)
    whole[:m, :m], Q[:m] = block, noise
    expected_mean, expected = predict_n(mean, P, whole, np.diag(Q))
    F = factors_of(P)
    move_leading(mean, F, block, noise)
    np.testing.assert_allclose(mean, expected_mean, rtol=1e-12, atol=1e-12)
    assert off(covariance_of(F), expected) < 1e-10
    assert np.all(np.diag(F) > 0.0)


@given(covariances(3))
def test_noise_along_a_direction(case):
    P, rng = case
    n = P.shape[0]
    last = int(rng.integers(0, n))
    a = np.zeros(n)
    a[: last + 1] = np.sqrt(np.diag(P))[: last + 1] * rng.normal(size=last + 1)
    F = factors_of(P)
    add_variance(F, a.copy(), 0.3, last)
    assert off(covariance_of(F), P + 0.3 * np.outer(a, a)) < 1e-10


@given(covariances(3))
def test_states_that_do_not_follow_keep_an_honest_covariance(case):
    """(I - K H) P (I - K H)' + K R K' holds for any gain K, here one without its last part."""
    P, rng = case
    n, R = P.shape[0], 0.1
    first, H = int(rng.integers(1, n)), rng.normal(size=n)
    F, gain = factors_of(P), np.empty(n)
    S = observe(F, H, R, gain)
    used = gain.copy()
    used[first:] = 0.0
    left = np.eye(n) - np.outer(used, H)
    consider(F, gain, S, first)
    expected = left @ P @ left.T + R * np.outer(used, used)
    assert np.max(np.abs(covariance_of(F) - expected) / np.sqrt(np.outer(np.diag(P), np.diag(P)))) < 1e-10


@given(covariances(3))
def test_known_states_leave_the_belief_in_the_others(case):
    P, _ = case
    F = factors_of(P)
    know_leading(F, 2)
    expected = P.copy()
    expected[:2], expected[:, :2] = 0.0, 0.0
    assert off(covariance_of(F), expected) < 1e-12
    gain = np.empty(P.shape[0])
    observe(F, np.ones(P.shape[0]), 1.0, gain)
    assert gain[0] == gain[1] == 0.0


def passes(mean, factors, block, noise, numbers, count):
    """Steps a filter of the axial drive `count` samples on, and returns the smallest D that occurred."""
    n, row, gain, lowest = mean.size, np.zeros_like(mean), np.zeros_like(mean), numbers[0]
    turn = 0
    for i in range(count):
        move_leading(mean, factors, block, noise)
        gain[:] = 0
        gain[2 + turn] = 1
        add_variance(factors, gain, numbers[1], 2 + turn)
        turn = (turn + 1) % (n - 2)
        row[0] = 1
        for h in range(1, (n - 2) // 2 + 1):
            row[2 * h] = np.cos(h * numbers[2] * i)
            row[2 * h + 1] = np.sin(h * numbers[2] * i)
        observe(factors, row, numbers[0], gain)
        for j in range(n):
            mean[j] += gain[j] * (numbers[3] - mean[0])
            lowest = min(lowest, factors[j, j])
    return lowest


def axial_filter(dtype, harmonics=5):
    """Belief, block, noises and numbers of the chamber drive in SI: 30 um, 1 um, 2 mm/s, 0.6 um, 22.5 Hz, 1 ms."""
    n, g, h = 2 + 2 * harmonics, 72.03, 1e-3
    block = [[np.cos(g * h), np.sin(g * h) / g], [-g * np.sin(g * h), np.cos(g * h)]]
    factors = np.diag([1e-6, 1e-4] + [1e-6] * (n - 2))
    numbers = [9e-10, 2 * harmonics * 3.6e-13, 2.0 * np.pi * 22.5 * h, 0.01]
    return [np.array(v, dtype) for v in (np.zeros(n), factors, block, [1e-12, 4e-6], numbers)]


HOUR = pytest.param(3_600_000, marks=pytest.mark.slow, id="an hour of milliseconds")


@pytest.fixture(scope="module")
def fast():
    """`passes` in double precision, compiled."""
    return compiled(passes, *axial_filter(np.float64), 1)


@pytest.mark.parametrize("samples", [20_000, HOUR])
def test_covariance_stays_positive(fast, samples):
    case = axial_filter(np.float64)
    assert fast(*case, samples) > 0.0
    assert np.all(np.isfinite(case[1]))


@pytest.mark.parametrize("samples", [10_000, HOUR])
def test_covariance_stays_positive_in_single_precision(fast, samples):
    """A covariance of these units would be rounded by more than its smallest eigenvalue. Compiled code has doubles
    only: this is plain Python."""
    single, exact = axial_filter(np.float32), axial_filter(np.float64)
    assert passes(*single, samples) > 0.0
    fast(*exact, samples)
    assert single[1].dtype == np.float32
    assert off(covariance_of(single[1].astype(float)), covariance_of(exact[1])) < 0.02
