from dataclasses import replace

import numpy as np
import pytest

from vvdp.base.errors import ParameterError
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


def test_all_films_of_a_spool_off_its_centre_leak_more(prototype):
    # mean of (1 + eps cos)^3 over the circumference = 1 + 1.5 eps^2; 0.9: 2.215
    angle = 2.0 * np.pi * np.arange(64) / 64
    for eps in (0.3, 0.9):
        mean = np.mean((1.0 + eps * np.cos(angle)) ** 3.0)
        found = leakage_conductance(0.0387, replace(prototype, eccentricity=eps))
        assert found == pytest.approx(leakage_conductance(0.0387, prototype) * mean, rel=1e-12)
    assert found == pytest.approx(2.6287e-13 * 2.215, rel=1e-4)


def test_a_spool_that_touches_is_refused(prototype):
    with pytest.raises(ParameterError, match="the spool touches the sleeve"):
        replace(prototype, eccentricity=1.0)
