from dataclasses import replace

import numpy as np
import pytest

from vvdp.valve.leakage import leakage_conductance


def test_leakage_of_the_prototype(prototype):
    # sin(alpha) = 1.52789 / sqrt(1 + 2.33444) = 0.83673; l_b = 6 * 20.32 / 0.83673 = 145.71 mm;
    # w_b = 3.99076 * 0.83673 = 3.33919 mm; l_b / w_b = 43.637; ends 2 * 79.796 / 10 = 15.959; sum 59.596
    # c^3 / (12 mu) = 2.048383e-15 / 0.4644 = 4.41081e-15; product 2.6287e-13
    assert leakage_conductance(0.0387, prototype) == pytest.approx(2.6287e-13, rel=1e-4)


def test_laws_of_the_slot(prototype):
    G = leakage_conductance(0.0387, prototype)
    assert leakage_conductance(0.0774, prototype) == pytest.approx(G / 2.0, rel=1e-14)
    assert leakage_conductance(0.0387, replace(prototype, radial_clearance=25.4e-6)) == pytest.approx(
        8.0 * G, rel=1e-14
    )


def test_a_spool_against_the_wall_leaks_two_and_a_half_times_at_its_ends(prototype):
    # mean of (1 + eps cos)^3 over the circumference = 1 + 1.5 eps^2
    angle = 2.0 * np.pi * np.arange(64) / 64
    for eps in (0.3, 1.0):
        mean = np.mean((1.0 + eps * np.cos(angle)) ** 3.0)
        extra = leakage_conductance(0.0387, replace(prototype, eccentricity=eps)) - leakage_conductance(
            0.0387, prototype
        )
        ends = 12.7e-6**3 / (12 * 0.0387) * 2.0 * 2.0 * np.pi * 12.7e-3 / 10e-3
        assert extra == pytest.approx(ends * (mean - 1.0), rel=1e-9)
