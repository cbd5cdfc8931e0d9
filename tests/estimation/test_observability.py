"""Position against a periodic noise: closed forms, quadrature and projection agree, and say where it is lost."""

import numpy as np
import pytest
from tests.compiled import compiled

from vvdp.base.errors import ParameterError
from vvdp.estimation.observability import (
    Grammian,
    Plant,
    analytic_grammian,
    check_noise,
    is_observable,
    margin_with_pressure,
    natural_frequency,
    numeric_grammian,
    observability_margin,
    rank,
    scaled_dynamics,
    smallest_eigenvalue,
    unobservable_speeds,
    without_noise,
)

TURN = 2.0 * np.pi
SPOOL = Plant(mass=0.5, stiffness=2594.0)
GAMMA = natural_frequency(SPOOL)
OIL_STIFFNESS = 1.74e-4**2 / 4.995e-13
"""A^2 beta/V of the chamber with 10 % air at 14 bar [N/m]."""
SPEEDS = TURN * np.array([1.7, 2.2927, 6.0, 9.0, 11.4, 11.6, 13.0, 22.5, 60.0])


def in_one_unit(grammian, gamma):
    """The Grammian of position and velocity over gamma."""
    scale = np.diag([1.0, gamma])
    return Grammian(scale @ grammian.plant @ scale, scale @ grammian.coupling, grammian.period)


@pytest.mark.parametrize(
    ("turns", "harmonics", "margin"),
    [
        (22.5, 5, 0.0738), (13.0, 5, 9.8e-3), (12.0, 5, 1.5e-3), (11.6, 5, 1.0e-4), (6.0, 5, 4.5e-3),
        (22.5, 1, 0.28), (22.5, 10, 0.0386), (22.5, 40, 0.010),
    ],
)  # fmt: skip
def test_margin_of_the_spool(turns, harmonics, margin):
    digits = 0.5 * 10.0 ** (np.floor(np.log10(margin)) - (2 if turns == 22.5 and harmonics in (5, 10) else 1))
    assert observability_margin(GAMMA, TURN * turns, harmonics) == pytest.approx(margin, abs=1.01 * digits)


def test_margin_by_hand():
    """gamma = omega/2, one harmonic, times from the middle of the turn: cos(wt/2), sin(wt/2) over 2 pi.

    Over a turn (2/T) int cos^2(wt/2) = (2/T) int sin^2(wt/2) = 1. With p = wt/2 from -pi/2 to pi/2
    (2/T) int cos(wt/2) cos wt = (2/pi) int cos p cos 2p dp = 4/(3 pi), and (2/T) int sin(wt/2) sin wt =
    (2/pi) int sin p sin 2p dp = 8/(3 pi). What is left is 1 - 16/(9 pi^2) and 1 - 64/(9 pi^2).
    """
    assert observability_margin(1.0, 2.0, 1) == pytest.approx(1.0 - 64.0 / (9.0 * np.pi**2), rel=1e-14)


@pytest.mark.parametrize("harmonics", [1, 5, 12])
def test_three_ways_to_the_margin_agree(harmonics):
    for omega in SPEEDS:
        plain = observability_margin(GAMMA, omega, harmonics)
        analytic = in_one_unit(analytic_grammian(GAMMA, omega, harmonics), GAMMA)
        numeric = numeric_grammian(scaled_dynamics(SPOOL, omega), omega, harmonics)
        assert analytic.plant == pytest.approx(numeric.plant, rel=1e-12, abs=1e-14)
        assert analytic.coupling == pytest.approx(numeric.coupling, rel=1e-12, abs=1e-13)
        assert smallest_eigenvalue(analytic) == pytest.approx(plain, abs=1e-13)


def test_margin_is_what_a_projection_leaves():
    """Independent of all integrals: least squares of the plant's motion on the harmonics, over many samples."""
    omega, count = TURN * 13.0, 20_000
    t = (np.arange(count) + 0.5) * TURN / omega / count
    motion = np.stack([np.cos(GAMMA * t), np.sin(GAMMA * t)], axis=1)
    basis = np.concatenate([[np.cos(g * omega * t), np.sin(g * omega * t)] for g in range(1, 6)]).T
    left = motion - basis @ np.linalg.lstsq(basis, motion, rcond=None)[0]
    smallest = np.linalg.eigvalsh(2.0 / count * left.T @ left)[0]
    assert observability_margin(GAMMA, omega, 5) == pytest.approx(smallest, rel=1e-5)


def test_lost_speeds_are_where_rank_and_margin_fall():
    speeds = unobservable_speeds(GAMMA, 5)
    assert speeds / TURN == pytest.approx([11.464, 5.732, 3.821, 2.866, 2.293], abs=5e-4)
    for omega in speeds:
        grammian = in_one_unit(analytic_grammian(GAMMA, omega, 5), GAMMA)
        assert not is_observable(GAMMA, omega, 5)
        assert observability_margin(GAMMA, omega, 5) == pytest.approx(0.0, abs=1e-14)
        assert without_noise(grammian) == pytest.approx(np.zeros((2, 2)), abs=1e-14)
        assert rank(grammian) == 10
    for omega in SPEEDS:
        assert is_observable(GAMMA, omega, 5)
        assert rank(in_one_unit(analytic_grammian(GAMMA, omega, 5), GAMMA)) == 12


def test_coupling_at_a_lost_speed_has_its_limits():
    """At gamma = g omega: T/2, 0, 0, T/(2 gamma)."""
    omega = GAMMA / 3.0
    T = TURN / omega
    at = analytic_grammian(GAMMA, omega, 5).coupling[:, 4:6]
    assert at == pytest.approx(np.array([[0.5 * T, 0.0], [0.0, 0.5 * T / GAMMA]]), abs=1e-16)
    beside = analytic_grammian(GAMMA * (1.0 + 1e-9), omega, 5).coupling[:, 4:6]
    assert beside == pytest.approx(at, abs=1e-8 * T)


def test_more_harmonics_leave_less():
    """About as 1/k, and never more than with fewer."""
    margins = [observability_margin(GAMMA, TURN * 22.5, k) for k in range(1, 41)]
    assert np.all(np.diff(margins) < 0.0)
    assert margins[39] / margins[9] == pytest.approx(10.0 / 40.0, rel=0.05)


def test_margin_depends_on_the_ratio_alone():
    assert observability_margin(3.0 * GAMMA, 3.0 * TURN * 13.0, 5) == pytest.approx(
        observability_margin(GAMMA, TURN * 13.0, 5), rel=1e-12
    )
    assert observability_margin(GAMMA, -TURN * 13.0, 5) == observability_margin(GAMMA, TURN * 13.0, 5)


def test_a_spool_at_rest_shows_nothing():
    assert observability_margin(GAMMA, 0.0, 5) == 0.0


def test_many_swings_in_a_turn_need_no_care():
    """Far above all harmonics the noise leaves everything."""
    assert observability_margin(GAMMA, GAMMA / 400.0, 5) == pytest.approx(1.0, abs=2e-3)


@pytest.mark.parametrize("harmonics", [1, 5, 20])
def test_an_integrator_is_observable_at_every_speed(harmonics):
    """Without a spring: (x + v t) over a turn, c = 2 pi^2/3 - 4 sum 1/g^2 left of the ramp, 2 of the constant."""
    mass = Plant(mass=0.5, stiffness=0.0)
    assert unobservable_speeds(0.0, harmonics).size == 0
    margins = [observability_margin(0.0, omega, harmonics) for omega in SPEEDS]
    assert margins == pytest.approx([margins[0]] * len(SPEEDS), rel=1e-15)
    assert margin_with_pressure(mass, SPEEDS[0], harmonics) == pytest.approx(margins[0], rel=1e-11)
    assert is_observable(0.0, SPEEDS[0], harmonics)


def test_measured_pressure_keeps_the_position():
    """0.76 at resonance, where the optical sensor alone has nothing; and nowhere near nothing at any other speed."""
    assert margin_with_pressure(SPOOL, GAMMA, 5, [OIL_STIFFNESS]) == pytest.approx(0.76, abs=5e-3)
    assert margin_with_pressure(SPOOL, GAMMA, 5) == pytest.approx(0.0, abs=1e-12)
    assert min(margin_with_pressure(SPOOL, omega, 5, [OIL_STIFFNESS]) for omega in SPEEDS) > 0.7


def test_pressure_alone_shows_the_position():
    """Of x, v and P by P alone: its rates are v, then A P - K x, so the Grammian has full rank."""
    rates = scaled_dynamics(SPOOL, GAMMA, [OIL_STIFFNESS])
    seen = np.array([0.0, 0.0, 1.0])
    assert np.linalg.matrix_rank([seen, seen @ rates, seen @ rates @ rates]) == 3


def test_damping_lifts_the_margin_a_little():
    """A motion that dies is no harmonic; 20 N s/m still leaves less than the warning at resonance."""
    margin = margin_with_pressure(SPOOL._replace(damping=20.0), GAMMA, 5)
    assert 1e-3 < margin < 0.01
    assert margin_with_pressure(SPOOL._replace(damping=1e-9), TURN * 13.0, 5) == pytest.approx(
        observability_margin(GAMMA, TURN * 13.0, 5), rel=1e-6
    )


@pytest.mark.parametrize(
    ("speed", "harmonics", "word"),
    [
        (-1.0, 5, "spool speed: -9.5493 rpm must be greater than 0"),
        (0.0, 5, "spool speed: 0 rpm must be greater than 0"),
        (np.inf, 5, "spool speed: inf rpm must be a finite number"),
        (1.0, 0, "harmonics: 0; expected a whole number, 1 to 200"),
        (1.0, 2.5, "harmonics: 2.5"),
        (1.0, 201, "harmonics: 201"),
        (1.0, np.nan, "harmonics: nan"),
    ],
)
def test_noise_without_a_turn_is_refused(speed, harmonics, word):
    with pytest.raises(ParameterError, match=word):
        check_noise(speed, harmonics)


def test_margin_compiles():
    fast = compiled(observability_margin, GAMMA, SPEEDS[0], 5)
    for gamma in (GAMMA, 0.0):
        for omega in (*SPEEDS, 0.0, gamma):
            plain = observability_margin(gamma, omega, 5)
            assert fast(gamma, omega, 5) == pytest.approx(plain, rel=1e-12, abs=1e-14)
