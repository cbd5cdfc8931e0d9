"""One step of the Kalman filter: by hand, by the information form, by the differential equation, by Riccati."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.dense_filter import predict_n, update_n

from vvdp.numerics.kalman import AngleSpeed, predict, update


def matrix(belief):
    return np.array([[belief.angle_variance, belief.covariance], [belief.covariance, belief.speed_variance]])


def belief_of(mean, P):
    return AngleSpeed(mean[0], mean[1], P[0, 0], P[0, 1], P[1, 1])


@st.composite
def beliefs(draw):
    """Deviations from 1e-3 to 10 and a correlation up to 0.99."""
    a, b = (10.0 ** draw(st.floats(-3.0, 1.0)) for _ in range(2))
    r = draw(st.floats(-0.99, 0.99))
    return AngleSpeed(draw(st.floats(-5.0, 5.0)), draw(st.floats(-200.0, 200.0)), a * a, r * a * b, b * b)


def test_prediction_by_hand():
    """h = 2, q = 3: angle 1 + 2 x 4 = 9; P11 = 1 + 2 (2 x 0.5 + 2 (2 + 2 x 3/3)) = 19; P12 = 0.5 + 2 (2 + 3) = 10.5;
    P22 = 2 + 6 = 8.
    """
    assert predict(AngleSpeed(1.0, 4.0, 1.0, 0.5, 2.0), 2.0, 3.0) == pytest.approx((9.0, 4.0, 19.0, 10.5, 8.0))


def test_correction_by_hand():
    """P11 = 3, R = 1: S = 4, K = (3/4, 2/4); P11+ = 3/4, P12+ = 2/4, P22+ = 5 - 4/4 = 4; by an innovation of 8."""
    after = update(AngleSpeed(1.0, 4.0, 3.0, 2.0, 5.0), 8.0, 1.0)
    assert after == pytest.approx((7.0, 8.0, 0.75, 0.5, 4.0))


@given(beliefs(), st.floats(-4.0, 1.0))
def test_correction_is_the_information_form(belief, exponent):
    """P+ = (P^-1 + H R^-1 H')^-1 and K = P+ H R^-1, H a column: equations 3.8 and 3.9 with their units put right."""
    P, R, H = matrix(belief), 10.0**exponent, np.array([[1.0], [0.0]])
    expected = np.linalg.inv(np.linalg.inv(P) + H @ H.T / R)
    after = update(belief, 0.3, R)
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    assert np.max(np.abs(matrix(after) - expected) / scale) < 1e-9
    gain = (expected @ H / R)[:, 0]
    np.testing.assert_allclose(
        [after.angle - belief.angle, after.speed - belief.speed], 0.3 * gain, rtol=1e-9, atol=1e-12 * 200.0
    )


@given(beliefs(), st.floats(-4.0, 1.0), st.floats(-1.0, 1.0))
def test_array_form_is_the_scalar_one(belief, exponent, innovation):
    mean, P = np.array([belief.angle, belief.speed]), matrix(belief)
    after = update(belief, innovation, 10.0**exponent)
    found, found_P = update_n(mean, P, np.array([1.0, 0.0]), innovation, 10.0**exponent)
    np.testing.assert_allclose(found, after[:2], rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(found_P, matrix(after), rtol=1e-9, atol=1e-12)
    h, q = 0.02, 7.0
    F = np.array([[1.0, h], [0.0, 1.0]])
    Q = q * np.array([[h**3 / 3.0, h**2 / 2.0], [h**2 / 2.0, h]])
    later = predict(belief, h, q)
    found, found_P = predict_n(mean, P, F, Q)
    np.testing.assert_allclose(found, later[:2], rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(found_P, matrix(later), rtol=1e-9, atol=1e-12)


def test_array_form_with_three_states_is_the_information_form():
    rng = np.random.default_rng(2)
    for _ in range(200):
        root, H, R = rng.normal(size=(3, 3)), rng.normal(size=3), rng.uniform(0.01, 2.0)
        P = root @ root.T + 0.1 * np.eye(3)
        _, found = update_n(np.zeros(3), P, H, 1.0, R)
        np.testing.assert_allclose(found, np.linalg.inv(np.linalg.inv(P) + np.outer(H, H) / R), atol=1e-9)
        np.testing.assert_array_equal(found, found.T)


@given(beliefs(), st.floats(0.0, 0.5), st.floats(0.0, 100.0))
def test_there_and_back_changes_nothing(belief, duration, density):
    back = predict(predict(belief, duration, density), -duration, density)
    assert back == pytest.approx(belief, rel=1e-9, abs=1e-9 * (1.0 + density + belief.speed_variance))


@given(beliefs(), st.floats(0.0, 0.2), st.floats(0.0, 0.2), st.floats(0.0, 100.0))
def test_two_predictions_are_one(belief, first, second, density):
    twice = predict(predict(belief, first, density), second, density)
    assert twice == pytest.approx(predict(belief, first + second, density), rel=1e-9, abs=1e-12)


@given(beliefs(), st.floats(0.0, 0.1), st.floats(0.0, 1e4))
def test_prediction_solves_the_lyapunov_equation(belief, time, density):
    """dP/dt = F P + P F' + Q, equation 3.6. P is a cubic in time, so a central difference of step d is off by q d^2/3
    in P11 and by nothing elsewhere.
    """
    d, F = 1e-3, np.array([[0.0, 1.0], [0.0, 0.0]])
    P = matrix(predict(belief, time, density))
    later, before = (matrix(predict(belief, time + s, density)) for s in (d, -d))
    slope = (later - before) / (2.0 * d)
    expected = F @ P + P @ F.T + np.diag([0.0, density]) + np.array([[density * d * d / 3.0, 0.0], [0.0, 0.0]])
    np.testing.assert_allclose(slope, expected, rtol=1e-7, atol=1e-9 * max(1.0, np.max(P)) / d)


def test_steady_state_is_that_of_riccati():
    """25 Hz, 8 sectors: an edge every 5 ms, R = 5.53e-3 rad^2, q = 0.25 rad^2/s^3.

    The published deviations, 0.0192 rad and 0.189 rad/s after an edge.
    """
    from scipy.linalg import solve_discrete_are

    h, q, R = 5e-3, 0.25, 5.53e-3
    belief = AngleSpeed(0.0, 0.0, 1000.0, 0.0, 1000.0)
    for _ in range(4000):
        belief = update(predict(belief, h, q), 0.0, R)
    F, H = np.array([[1.0, h], [0.0, 1.0]]), np.array([[1.0], [0.0]])
    Q = q * np.array([[h**3 / 3.0, h**2 / 2.0], [h**2 / 2.0, h]])
    before = solve_discrete_are(F.T, H, Q, np.array([[R]]))
    after = before - before @ H @ H.T @ before / (before[0, 0] + R)
    np.testing.assert_allclose(matrix(belief), after, rtol=1e-7)
    assert np.sqrt(belief.angle_variance) == pytest.approx(0.0192, abs=5e-5)
    assert np.sqrt(belief.speed_variance) == pytest.approx(0.189, abs=5e-4)


def test_steady_state_approaches_the_continuous_one():
    """For edges close together: P22 = sqrt(2) q^(3/4) (R h)^(1/4). At 5 ms the bandwidth is 9.75 rad/s and each
    interval takes 5 % of a radian of it, so that the closed form is right to a few per cent, and the better the denser.
    """
    q, errors = 0.25, []
    for h in (5e-3, 5e-4, 5e-5):
        R = 5.53e-3 * 5e-3 / h
        belief = AngleSpeed(0.0, 0.0, 1.0, 0.0, 1.0)
        for _ in range(round(10.0 / h)):
            belief = update(predict(belief, h, q), 0.0, R)
        errors.append(belief.speed_variance / (np.sqrt(2.0) * q**0.75 * (R * h) ** 0.25) - 1.0)
    assert abs(errors[0]) < 0.04
    assert abs(errors[2]) < 5e-4
    assert abs(errors[1]) < 0.15 * abs(errors[0])


def test_joseph_form_stays_positive_where_the_short_one_does_not():
    """P11 = P22 = 1e8, fully correlated but for 1e-8, and an exact measurement: P - K H' P loses all its digits."""
    belief = AngleSpeed(0.0, 0.0, 1e8, 1e8 - 1.0, 1e8)
    after = update(belief, 1.0, 1e-10)
    P = matrix(after)
    assert 1e8 - 1e8 / (1e8 + 1e-10) * 1e8 == 0.0
    assert after.angle_variance > 0.0
    assert np.linalg.det(P) > 0.0
