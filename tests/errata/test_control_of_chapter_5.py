"""Misprints of the control of chapter 5 of wang2017: each number of a row worked out anew."""

import numpy as np
import pytest

from vvdp.fluid.modulus import (
    YuAir,
    compression_energy_per_volume,
    mean_modulus,
    specific_volume_exponent,
    yu_bulk_modulus,
)

BAR = 1e5


def yu(air):
    return YuAir(
        liquid_bulk_modulus=1.7e9,
        reference_pressure=1e5,
        air_fraction=air,
        polytropic_exponent=1.4,
        dissolving_rate=0.0,
    )


OIL = yu(0.1)


def test_range_of_the_published_figure_is_wide(told):
    """W_V/(P - P_d) with 30 % of air, between 1 and 350 bar: -0.257 at 1 from 350, 0.062 at 4.2 from 1."""
    fluid = yu(0.3)

    def share(P, Pd):
        return compression_energy_per_volume(P, Pd, yu_bulk_modulus, fluid) / (P - Pd)

    low = share(1e5, 350e5)
    high = max(share(P, 1e5) for P in np.geomspace(1.1e5, 350e5, 100))
    assert f"{low:.3f}" in told
    assert f"{high:.3f}" in told
    rng = np.random.default_rng(5)
    for one, other in 10.0 ** rng.uniform(0.0, np.log10(350.0), (40, 2)):
        assert low <= share(one * BAR, other * BAR) <= high


def test_softness_lies_between_those_of_both_ends(told):
    """1/B = (e^g - 1)/p at 14 bar against 10 bar: 91.6 MPa, between beta(10) and beta(14)."""
    g = specific_volume_exponent(14 * BAR, 10 * BAR, yu_bulk_modulus, OIL)
    B = 4 * BAR / np.expm1(g)
    ends = [yu_bulk_modulus(p * BAR, OIL) for p in (10, 14)]
    assert ends[0] < B < ends[1]
    for value in (*ends, B):
        assert f"{value / 1e6:.1f}" in told


def test_density_rise_takes_the_pressure_error(told):
    """e^g - 1 is a number, 1/beta is none: 4.37e-3 against 1.4e-8 1/Pa."""
    rise = np.expm1(specific_volume_exponent(14 * BAR, 10 * BAR, yu_bulk_modulus, OIL))
    assert f"{rise:.2e}".replace("e-0", "e-") in told
    assert f"{1.0 / yu_bulk_modulus(10 * BAR, OIL):.1e}".replace("e-0", "e-") in told
    assert 4 * BAR / yu_bulk_modulus(10 * BAR, OIL) == pytest.approx(rise, rel=0.35)


def test_bound_of_the_storage_has_one_square(told):
    """W_V/p^2 = 1/(2 mean modulus) is epsilon itself; another p^2 would leave 3.1e-20 of 4.96e-9."""
    W = compression_energy_per_volume(14 * BAR, 10 * BAR, yu_bulk_modulus, OIL)
    epsilon = W / (4 * BAR) ** 2
    assert epsilon == pytest.approx(0.5 / mean_modulus(14 * BAR, 10 * BAR, yu_bulk_modulus, OIL), rel=1e-9)
    assert f"{epsilon:.2e}".replace("e-0", "e-") in told
    assert f"{epsilon / (4 * BAR) ** 2:.1e}" in told


MASS, STIFFNESS, OMEGA = 0.5, 2594.0, 2.0 * np.pi * 22.5


def observer(t, harmonics=2):
    """A and C of (5.44), and the gain of a Kalman filter that has believed the same covariance all along."""
    n = 2 + 2 * harmonics
    A = np.zeros((n, n))
    A[0, 1], A[1, 0] = 1.0, -STIFFNESS / MASS
    waves = [f(g * OMEGA * t) for g in range(1, harmonics + 1) for f in (np.cos, np.sin)]
    C = np.array([1.0, 0.0, *waves])
    covariance = np.diag([1e-8, 1e-4, *([1e-8] * 2 * harmonics)])
    return A, C, covariance @ C / 1e-10, covariance


def test_velocity_of_the_estimate_is_not_the_estimated_velocity():
    """d xhat_1/dt = xhat_2 + L_1 (y - C xhat); and e_vn is e_n' + l e_n, of which e_n + l e_n has not even the unit."""
    A, C, L, _ = observer(0.003)
    estimate, truth = np.array([1e-3, 0.02, 1e-4, 0.0, 0.0, 0.0]), np.array([1.1e-3, 0.03, 0.0, 2e-4, 0.0, 0.0])
    innovation = C @ (truth - estimate)
    rate = A @ estimate + L * innovation
    assert rate[0] - estimate[1] == pytest.approx(L[0] * innovation)
    assert abs(rate[0] - estimate[1]) > 1e-3


def test_rate_of_the_velocity_error_has_all_errors():
    """The second row of A - L C: -gamma^2 - L_2, -L_2 times each of the noise's basis."""
    for t in (0.001, 0.0123):
        A, C, L, covariance = observer(t)
        covariance[1, 0] = covariance[0, 1] = 5e-7
        L = covariance @ C / 1e-10
        row = (A - np.outer(L, C))[1]
        assert row[0] == pytest.approx(-STIFFNESS / MASS - L[1])
        assert row[2:] == pytest.approx(-L[1] * C[2:])
        assert np.min(np.abs(row[2:])) > 1.0


def whole_matrix(weight, flow_gain):
    """Lambda_total of (5.69) with the coupling of e_vn to e_1 and e_2', the latter's part in e_1, and c for 1."""
    tracking = np.diag([50.0 * (STIFFNESS + 55.0), 4.0, flow_gain])
    estimation = weight * np.diag([1.0, 1e-4])
    coupling = np.zeros((3, 2))
    coupling[1] = 0.5 * STIFFNESS, 0.5 * MASS
    return np.block([[tracking, coupling], [coupling.T, estimation]])


def test_weight_of_the_estimate_and_no_gain_makes_the_matrix_positive():
    """As printed it has a negative eigenvalue for any lambda_3; with c = 1e7 none."""
    for flow_gain in 10.0 ** np.arange(-10.0, 20.0, 5.0):
        assert np.min(np.linalg.eigvalsh(whole_matrix(1.0, flow_gain))) < -1.0
    assert np.min(np.linalg.eigvalsh(whole_matrix(1e7, 1e-3))) > 0.0


def test_desired_flow_has_the_known_rate_alone():
    """What is left of p (Q_d - A r - V/beta P_d') is -p V/beta f with P_d1', as (5.66) has it; with P_dn' nothing."""
    area_r, compliance, known, f, p = 2e-6, 5e-13, 4e5, 3e6, 1e4
    full = known + f

    def left(rate):
        return p * (area_r + compliance * rate - area_r - compliance * full)

    assert left(known) == pytest.approx(-p * compliance * f)
    assert left(full) == pytest.approx(0.0, abs=1e-12 * p * area_r)
