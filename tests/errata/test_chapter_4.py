"""Misprints of chapter 4 and section 5.5 of wang2017, noise models and observers: each number worked out anew."""

import numpy as np
import pytest
from scipy.linalg import expm, solve_continuous_lyapunov

from vvdp.estimation.chamber_observer import SpringDrive, oscillator_step
from vvdp.estimation.signal_generator import samples_in_period, signal_generator

T, H = 0.1, 1e-3
OMEGA = 2.0 * np.pi / T


def fourier_row(time, harmonics):
    """(1, cos w t, sin w t, ...): position and basis as the sensor sees them."""
    h = np.arange(1, harmonics + 1)
    return np.concatenate([[1.0], np.ravel(np.column_stack([np.cos(h * OMEGA * time), np.sin(h * OMEGA * time)]))])


def test_states_of_the_signal_generator(told):
    """10 Hz and 2 ms: a matrix of 49 states; the 50 that are printed are those of the augmented system."""
    A, _ = signal_generator(samples_in_period(0.1, 2e-3))
    assert f"{A.shape[0]} states" in told
    assert f"{A.shape[0] + 1} with the position" in told


def test_last_row_of_the_observability_matrix(told):
    """C A^N is C again, since all states come back after a period: with it in the place of the last row the matrix is
    singular."""
    N = 20
    A, C = np.eye(N), np.ones(N)
    A[1:, 1:], C[1:] = signal_generator(N)
    rows = [C @ np.linalg.matrix_power(A, k) for k in range(N)]
    np.testing.assert_array_equal(C @ np.linalg.matrix_power(A, N), C)
    np.testing.assert_array_equal(rows[-1], [1.0] + [-1.0] * (N - 1))
    assert f"{np.linalg.det(rows):.0f} for N = {N}" in told
    assert abs(np.linalg.det([*rows[:-1], C @ np.linalg.matrix_power(A, N)])) < 1e-9


def test_sizes_of_the_augmented_system():
    """A is (n + 1)^2: B has n + 1 entries, and so has the row C; n functions are n/2 harmonics."""
    n = 10
    row = fourier_row(0.3, n // 2)
    assert row.size == n + 1
    A, B = np.zeros((n + 1, n + 1)), np.zeros(n + 1)
    assert (A @ row + B).size == n + 1


def test_grammian_of_the_integrator(told):
    """diag(T, T/2, ...), by the rectangle rule, exact for harmonics; k = 5, T = 0.1 s: det = T (T/2)^10 = 9.766e-15."""
    times = np.arange(1000) / 1000 * T
    rows = np.array([fourier_row(t, 5) for t in times])
    M = rows.T @ rows * T / 1000
    np.testing.assert_allclose(M, np.diag([T] + [0.5 * T] * 10), atol=1e-15)
    det = np.prod(np.diag(M))
    assert f"{det:.3e}".replace("e-0", "e-") in told
    assert f"{(0.5 * T) ** 10:.3e}".replace("e-0", "e-") in told
    assert rows.shape[1] == 11


def test_period_of_the_pollution(told):
    """w_n = 62.83 rad/s for 10 Hz: 1/(2 pi w_n) = 2.53 ms."""
    assert f"{1e3 * 2.0 * np.pi / OMEGA:.0f} ms" in told
    assert f"{1e3 / (2.0 * np.pi * OMEGA):.1f} ms" in told


def settled(drift, samples):
    """Deviation of the coefficients after so many samples of the filter of the integrator drive, 2 functions, R = 1."""
    P = np.eye(3)
    for k in range(samples):
        C = fourier_row(k * H, 1)
        P = P + np.diag([0.01, drift, drift])
        K = P @ C / (C @ P @ C + 1.0)
        P = (np.eye(3) - np.outer(K, C)) @ P @ (np.eye(3) - np.outer(K, C)).T + np.outer(K, K)
    return P[1, 1], abs(K[1]) + abs(K[2])


def test_gains_die_without_drift():
    """Without process noise on the coefficients variance and gains fall as 1/k: a tenth after ten times as long."""
    variances, gains = zip(*(settled(0.0, n) for n in (2000, 20_000)), strict=True)
    assert variances[1] / variances[0] == pytest.approx(0.1, rel=0.02)
    assert gains[1] / gains[0] == pytest.approx(0.1, rel=0.1)
    variances, _ = zip(*(settled(1e-4, n) for n in (2000, 20_000)), strict=True)
    assert variances[1] == pytest.approx(variances[0], rel=1e-6)


def test_error_dynamics_are_stable_never_negative_definite():
    """(A + A')/2 has a zero on its diagonal, so det = -((1 - K_i/A_s)/2)^2 <= 0 for any gains; K_i, K_p > 0 put both
    eigenvalues to the left. Only the input (0, -1/A_s) leads to the printed A_dyn."""
    rng = np.random.default_rng(3)
    for Ki, Kp in 10.0 ** rng.uniform(-2.0, 3.0, (50, 2)):
        A = np.array([[0.0, 1.0], [-Ki, -Kp]])
        assert np.max(np.linalg.eigvalsh(0.5 * (A + A.T))) >= 0.0
        assert np.linalg.det(0.5 * (A + A.T)) == pytest.approx(-((0.5 * (1.0 - Ki)) ** 2))
        assert np.max(np.linalg.eigvals(A).real) < 0.0
        plain, gain = np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[Ki, Kp]])
        np.testing.assert_array_equal(plain + np.array([[0.0], [-1.0]]) @ gain, A)
        assert np.any(plain + np.array([[1.0], [-1.0]]) @ gain != A)


def with_integral(harmonics):
    """Dynamics of (x_i, x, coefficients), and its row of observation."""
    A = np.zeros((2 * harmonics + 2, 2 * harmonics + 2))
    A[0, 1] = 1.0
    return A, lambda t: np.concatenate([[0.0], fourier_row(t, harmonics)])


@pytest.mark.thorough
def test_integral_of_the_position_is_seen_by_nothing(told):
    """C exp(A t) e_1 = 0 for all t: the first row of the Grammian is zero, its rank 5 of 6 for two harmonics, and the
    first variance grows for ever."""
    A, row = with_integral(2)
    seen = np.array([row(t) @ expm(A * t) for t in np.arange(1000) * T / 1000])
    assert np.all(seen[:, 0] == 0.0)
    rank = np.linalg.matrix_rank(seen.T @ seen)
    assert f"rank {rank} of {A.shape[0]}" in told
    P, F, last = np.eye(6), expm(A * H), 0.0
    for k in range(3000):
        P = F @ P @ F.T + 1e-4 * np.eye(6)
        C = row(k * H)
        K = P @ C / (C @ P @ C + 1.0)
        P -= np.outer(K, C @ P)
        if k % 1000 == 999:
            assert P[0, 0] > last
            last = P[0, 0]


def test_noise_through_the_input_alone_lets_the_gains_die(told):
    """B' Q B is a number, B Q B' a matrix of rank 1. With it the coefficients' variance falls as 1/t, to a fifth from 1
    to 5 s; the sum P^-1 B Q B' P^-1 + C' R^-1 C has rank 2 of 11. With noise on all states the variance settles."""
    n, R = 11, (30e-6) ** 2
    B = np.zeros(n)
    B[0] = 1.0
    assert np.shape(B @ (9e-12 * B)) == ()
    found = {}
    for name, Q in (("input", 9e-12 * np.outer(B, B)), ("all", np.diag([9e-12] + [3.6e-13] * 10))):
        P = 1e-6 * np.eye(n)
        for k in range(10_000):
            P = P + Q
            C = fourier_row(k * H, 5)
            K = P @ C / (C @ P @ C + R)
            left = np.eye(n) - np.outer(K, C)
            P = left @ P @ left.T + R * np.outer(K, K)
            found[name, k + 1] = P[1, 1]
    assert found["input", 1000] / found["input", 5000] == pytest.approx(5.0, rel=0.05)
    assert found["all", 5000] == pytest.approx(found["all", 10_000], rel=0.01)
    told_by, seen = np.linalg.solve(P, B), fourier_row(0.3, 5)
    both = np.outer(told_by, told_by) / (told_by @ told_by) + np.outer(seen, seen) / (seen @ seen)
    assert f"rank {np.linalg.matrix_rank(both)} at most" in told


def test_cross_terms_of_the_storage():
    """V = e' P e with the estimate fed back: by difference quotient, the term of the estimation errors is
    -(2/A_s) (B' P e) (K_i et_i + K_p et), not 2 (B' P e) et."""
    A_s, Ki, Kp = 5.067e-4, 0.0456, 0.0152
    A = np.array([[0.0, 1.0], [-Ki / A_s, -Kp / A_s]])
    P = solve_continuous_lyapunov(A.T, -np.eye(2))
    rng = np.random.default_rng(5)
    for _ in range(20):
        e, off = rng.normal(size=2), rng.normal(size=2)
        slope = np.array([e[1], -(Ki * (e[0] + off[0]) + Kp * (e[1] + off[1])) / A_s])
        quotient = ((e + 1e-7 * slope) @ P @ (e + 1e-7 * slope) - (e - 1e-7 * slope) @ P @ (e - 1e-7 * slope)) / 2e-7
        cross = -2.0 / A_s * (P[1] @ e) * (Ki * off[0] + Kp * off[1])
        assert quotient == pytest.approx(-e @ e + cross, rel=1e-6)
        assert quotient != pytest.approx(-e @ e + 2.0 * (P[1] @ e) * off[1], rel=1e-2)


def test_separation_holds_for_a_periodic_observer(told):
    """Floquet multipliers over a turn of 100 samples: those of plant and observer together are those of the feedback
    and those of the observer. Gains at random, but for the period."""
    rng = np.random.default_rng(11)
    F, G = np.array([[1.0, H], [0.0, 1.0]]), np.array([-0.5 * H * H, -H])
    K = np.array([-90.0, -30.0])
    together, alone, feedback = np.eye(5), np.eye(3), np.eye(2)
    for k in range(100):
        C, L = fourier_row(k * H, 1), rng.uniform(0.0, 0.02, 3)
        error = np.eye(3) - np.outer(L, C)
        plant = F - np.outer(G, K)
        step = np.zeros((5, 5))
        step[:2, :2], step[:2, 2], step[2:, 2:] = plant, G * K[1], error
        together, alone, feedback = step @ together, error @ alone, plant @ feedback
    union = np.concatenate([np.linalg.eigvals(alone), np.linalg.eigvals(feedback)])
    found = np.linalg.eigvals(together)
    np.testing.assert_allclose(np.sort_complex(np.round(found, 9)), np.sort_complex(np.round(union, 9)), atol=1e-8)
    assert "union" in told


def test_noise_states_are_two_for_each_harmonic(told):
    """k harmonics have 2k coefficients and 2k + 2 states with position and velocity."""
    k = 5
    states = fourier_row(0.0, k).size - 1
    assert states == 2 * k
    assert f"{states} for k = {k}" in told


def test_process_noise_has_the_size_of_the_states(told):
    """Also that R_c is a density: 30 um in samples of 1 ms and of 0.1 ms that carry the same are 30 and 95 um."""
    assert f"${2 * 5 + 2}^2$ for k = 5" in told
    assert f"{30.0 * np.sqrt(10.0):.0f} um" in told


def test_storage_of_the_estimation_error_falls():
    """d/dt (x' P^-1 x) by difference quotients of the Riccati and the error equation: -x' (P^-1 Q P^-1 + C' C/R) x; the
    middle line of (5.57), with + P^-1 Q P^-1, differs."""
    rng = np.random.default_rng(7)
    A, R = np.zeros((4, 4)), 0.5
    A[:2, :2] = [[0.0, 1.0], [-4.0, 0.0]]
    root = rng.normal(size=(4, 4))
    P, Q, C, x = root @ root.T + np.eye(4), np.diag([3.0, 2.0, 1.0, 4.0]), rng.normal(size=4), rng.normal(size=4)
    L = P @ C / R
    dP = A @ P + P @ A.T + Q - np.outer(P @ C, C @ P) / R
    dx = (A - np.outer(L, C)) @ x
    d = 1e-6
    after, before = ((x + s * dx) @ np.linalg.solve(P + s * dP, x + s * dx) for s in (d, -d))
    inverse = np.linalg.inv(P)
    right = -x @ (inverse @ Q @ inverse + np.outer(C, C) / R) @ x
    assert (after - before) / (2.0 * d) == pytest.approx(right, rel=1e-7)
    closed = A - np.outer(L, C)
    middle = closed.T @ inverse + inverse @ closed - inverse @ A - A.T @ inverse + np.outer(C, C) / R
    assert x @ (middle - inverse @ Q @ inverse) @ x == pytest.approx(right, rel=1e-9)
    assert x @ (middle + inverse @ Q @ inverse) @ x != pytest.approx(right, rel=0.1)


def test_plant_of_the_observer_has_friction(told):
    """(5.42) leaves it out: 8.3 N s/m on 0.5 kg let a swing fade with 8.3 1/s, 0.8 % in a millisecond."""
    drive = SpringDrive(moving_mass=0.5, stiffness=2594.0, preload=211.5, viscous_friction=8.3, area=1.74e-4)
    step = oscillator_step(1e-3, drive)
    det = step.position[0] * step.velocity[1] - step.position[1] * step.velocity[0]
    assert det == pytest.approx(np.exp(-8.3 / 0.5 * 1e-3))
    assert f"{100.0 * (1.0 - np.sqrt(det)):.1f} %" in told
