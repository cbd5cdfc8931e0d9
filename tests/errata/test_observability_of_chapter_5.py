"""Misprints of section 5.5 and appendix A of wang2017: each number of a row worked out anew."""

import numpy as np
import pytest
from scipy.integrate import quad

from vvdp.estimation.observability import (
    Grammian,
    Plant,
    analytic_grammian,
    natural_frequency,
    observability_margin,
    rank,
    unobservable_speeds,
    without_noise,
)

TURN = 2.0 * np.pi
GAMMA = natural_frequency(Plant(mass=0.5, stiffness=2594.0))
OMEGA = TURN * 22.5
PERIOD = TURN / OMEGA


def integral(function, end=PERIOD):
    return quad(function, 0.0, end, epsabs=1e-14, epsrel=1e-12, limit=200)[0]


def test_grammian_of_the_velocity(told):
    """Psi_22 is the integral of phi_12^2 = sin^2(gamma t)/gamma^2; of cos^2/gamma^2, with the plus, as printed."""
    swing = np.sin(2.0 * GAMMA * PERIOD) / (4.0 * GAMMA)
    built, printed = (0.5 * PERIOD - swing) / GAMMA**2, (0.5 * PERIOD + swing) / GAMMA**2
    assert built == pytest.approx(integral(lambda t: (np.sin(GAMMA * t) / GAMMA) ** 2), rel=1e-10)
    assert analytic_grammian(GAMMA, OMEGA, 5).plant[1, 1] == pytest.approx(built, rel=1e-14)
    assert f"{1e6 * built:.4f}e-6" in told
    assert f"{1e6 * printed:.4f}e-6" in told


def test_the_other_entries_of_the_plant_hold():
    plant = analytic_grammian(GAMMA, OMEGA, 5).plant
    assert plant[0, 0] == pytest.approx(PERIOD / 2.0 + np.sin(2.0 * GAMMA * PERIOD) / (4.0 * GAMMA), rel=1e-12)
    assert plant[0, 1] == pytest.approx((1.0 - np.cos(2.0 * GAMMA * PERIOD)) / (4.0 * GAMMA**2), rel=1e-12)
    assert plant[0, 1] == pytest.approx(integral(lambda t: np.cos(GAMMA * t) * np.sin(GAMMA * t) / GAMMA), rel=1e-10)


def test_entries_of_the_grammian_are_products():
    """m = C'C, so the entry (cos, sin 2) is their product: at omega t = pi/4 it is 0.7071, and sin sin 2 as well;
    at 0.5 they are 0.738 and 0.403."""
    basis = np.array([np.cos(0.5), np.sin(0.5), np.cos(1.0), np.sin(1.0)])
    m = np.outer(basis, basis)
    assert m[0, 3] == pytest.approx(0.738, abs=5e-4)
    assert m[1, 3] == pytest.approx(0.403, abs=5e-4)
    assert np.linalg.matrix_rank(m) == 1


def test_antiderivative_has_the_speed(told):
    """sin((h + g) w t)/(2 (h + g)) has a derivative w times cos cos: 141.4 times at 22.5 Hz."""
    h, g, t, step = 2, 3, 0.0123, 1e-7

    def printed(t):
        return np.sin((h + g) * OMEGA * t) / (2 * (h + g)) + np.sin((h - g) * OMEGA * t) / (2 * (h - g))

    slope = (printed(t + step) - printed(t - step)) / (2.0 * step)
    share = slope / (np.cos(h * OMEGA * t) * np.cos(g * OMEGA * t))
    assert share == pytest.approx(OMEGA, rel=1e-6)
    assert f"{share:.1f}" in told


def test_cosine_and_sine_of_one_harmonic():
    """The integral of cos(g w t) sin(g w t) over a turn is 0; of any two as well."""
    for h in range(1, 4):
        for g in range(1, 4):
            assert integral(lambda t, h=h, g=g: np.cos(h * OMEGA * t) * np.sin(g * OMEGA * t)) == pytest.approx(
                0.0, abs=1e-14
            )


@pytest.mark.parametrize("g", [1, 2, 5])
def test_coupling_of_plant_and_noise(g):
    """(A.9) to (A.12) as printed against quadrature."""
    below = (GAMMA + g * OMEGA) * (GAMMA - g * OMEGA)
    gT, w = GAMMA * PERIOD, g * OMEGA
    printed = [
        [GAMMA * np.sin(gT) / below, w * (np.cos(gT) - 1.0) / below],
        [(1.0 - np.cos(gT)) / below, w * np.sin(gT) / (GAMMA * below)],
    ]
    found = [
        [integral(lambda t, a=a, b=b: a(t) * b(w * t)) for b in (np.cos, np.sin)]
        for a in (lambda t: np.cos(GAMMA * t), lambda t: np.sin(GAMMA * t) / GAMMA)
    ]
    built = analytic_grammian(GAMMA, OMEGA, 5).coupling[:, 2 * g - 2 : 2 * g]
    assert found == pytest.approx(np.array(printed), abs=1e-13)
    assert built == pytest.approx(np.array(printed), abs=1e-15)


def test_noise_block_takes_a_whole_turn(told):
    """Over a quarter of a turn the integral of cos sin is 1/(2 w), no zero: 0.159 T/2."""
    quarter = integral(lambda t: np.cos(OMEGA * t) * np.sin(OMEGA * t), 0.25 * PERIOD)
    assert quarter == pytest.approx(0.5 / OMEGA, rel=1e-10)
    assert f"{quarter / (0.5 * PERIOD):.3f} T/2" in told


def test_rank_drops_by_two(told):
    speeds = unobservable_speeds(GAMMA, 5)
    assert ", ".join(f"{f:.3f}" for f in speeds / TURN) in told
    for omega in speeds:
        found = analytic_grammian(GAMMA, omega, 5)
        scale = np.diag([1.0, GAMMA])
        grammian = Grammian(scale @ found.plant @ scale, scale @ found.coupling, found.period)
        assert without_noise(grammian) == pytest.approx(np.zeros((2, 2)), abs=1e-14)
        assert rank(grammian) == 2 + 10 - 2
    low, high = (observability_margin(GAMMA, TURN * f, 5) for f in (10.25, 13.01))
    assert max(low, high) < 0.01 < min(observability_margin(GAMMA, TURN * f, 5) for f in (10.24, 13.02))
    assert "10.25 to 13.01 Hz" in told


def test_more_functions_see_less(told):
    margins = [observability_margin(GAMMA, OMEGA, k) for k in (1, 5, 10, 40)]
    assert f"{margins[0]:.2f}, {margins[1]:.3f}, {margins[2]:.3f} and {margins[3]:.3f}" in told
