"""Side force, journal bearing, cavitation number and heat in the clearance."""

import dataclasses

import numpy as np
import pytest

from vvdp.systems.system import load_system
from vvdp.valve.bearing import bearing_eccentricity, bearing_force, radial_jet_force
from vvdp.valve.gap_flow import (
    carried_temperature_rise,
    cavitation_number,
    gap_reynolds_number,
    sheared_temperature_rise,
    taylor_number,
)

Q, RHO, MU, OMEGA = 4e-2 / 60.0, 876.0, 0.0387, 150.8


@pytest.fixture(scope="module")
def spool():
    return load_system("prototype").case.params.valve


def test_jet_force_of_one_stronger_nozzle(spool):
    """876 * 4.4444e-7/(3 * 36.5e-6) = 3.5556 N; (1.158^2 - 0.921^2) = 0.49272 of it: 1.752 N."""
    assert radial_jet_force(Q, 0.158, RHO, spool) == pytest.approx(1.752, abs=2e-3)


def test_jet_force_is_the_sum_of_the_jets_as_vectors(spool):
    for nozzles, e in ((2, 0.1), (3, 0.3), (5, 0.2)):
        valve = dataclasses.replace(spool, sections=float(nozzles))
        shares = np.full(nozzles, (1.0 - e / (nozzles - 1)) / nozzles)
        shares[0] = (1.0 + e) / nozzles
        jets = RHO * (shares * Q) ** 2 / (valve.nozzle_area / nozzles)
        angles = 2.0 * np.pi * np.arange(nozzles) / nozzles
        force = np.hypot(jets @ np.cos(angles), jets @ np.sin(angles))
        assert radial_jet_force(Q, e, RHO, valve) == pytest.approx(force, rel=1e-12)
    assert radial_jet_force(Q, 0.0, RHO, spool) == 0.0
    assert radial_jet_force(Q, 0.3, RHO, dataclasses.replace(spool, sections=1.0)) == 0.0


def test_bearing_by_hand(spool):
    """mu omega R l^3/c^2 = 0.0387 * 150.8 * 0.0127 * 1e-6/1.6129e-10 = 459.5 N a land; at eps = 0.5 the factor is
    0.5/(4 * 0.5625) * sqrt(0.75 pi^2 + 4) = 0.22222 * 3.3768 = 0.75041: 2 * 344.8 N."""
    assert bearing_force(0.5, OMEGA, MU, spool) == pytest.approx(689.6, rel=1e-3)


def test_bearing_against_the_reynolds_equation(spool):
    """Short bearing: (h^3 p_z)_z = 6 mu omega h_theta with p = 0 at both ends gives p = 3 mu omega h'/h^3 (z^2 - l^2/4)
    where that is positive; its integral over the land is the force."""
    eps, c, R, l = 0.6, spool.radial_clearance, spool.spool_radius, spool.land_length
    theta = (np.arange(20000) + 0.5) * np.pi / 20000  # the half with pressure: film narrowing
    h, slope = c * (1.0 + eps * np.cos(theta)), -c * eps * np.sin(theta)
    along = -(l**3) / 6.0  # integral of z^2 - l^2/4 over the land
    line = 3.0 * MU * OMEGA * slope / h**3 * along  # force per arc
    step = np.pi / 20000 * R
    force = np.hypot(np.sum(line * np.cos(theta)) * step, np.sum(line * np.sin(theta)) * step)
    assert bearing_force(eps, OMEGA, MU, spool) == pytest.approx(2.0 * force, rel=1e-6)


def test_eccentricity_is_the_inverse(spool):
    for eps in (1e-3, 0.1, 0.5, 0.95):
        force = bearing_force(eps, OMEGA, MU, spool)
        assert bearing_eccentricity(force, OMEGA, MU, spool) == pytest.approx(eps, rel=1e-9)
    assert bearing_eccentricity(1.0, 0.0, MU, spool) == pytest.approx(1.0)


def test_cavitation_number():
    """(5 - 1)/(13 - 5) = 0.5."""
    assert cavitation_number(13e5, 5e5, 1e5) == pytest.approx(0.5)


def test_gap_numbers(spool):
    """876 * 150.8 * 0.0127 * 12.7e-6/0.0387 = 0.5506; times sqrt(1e-3) = 0.01741."""
    assert gap_reynolds_number(OMEGA, RHO, MU, spool) == pytest.approx(0.5506, rel=1e-3)
    assert taylor_number(OMEGA, RHO, MU, spool) == pytest.approx(0.01741, rel=1e-3)


def test_sheared_rise_solves_the_heat_equation(spool):
    """lambda T'' = -mu (u/c)^2 between walls at 0, by finite differences: exact for a parabola."""
    n, c, k = 101, spool.radial_clearance, 0.13
    y = np.linspace(0.0, c, n)
    u = OMEGA * spool.spool_radius
    matrix = np.diag(np.full(n, -2.0)) + np.diag(np.ones(n - 1), 1) + np.diag(np.ones(n - 1), -1)
    matrix[[0, -1]] = 0.0
    matrix[0, 0] = matrix[-1, -1] = 1.0
    source = np.full(n, -MU * (u / c) ** 2 / k * (y[1] - y[0]) ** 2)
    source[[0, -1]] = 0.0
    found = np.linalg.solve(matrix, source)
    assert sheared_temperature_rise(OMEGA, MU, k, spool) == pytest.approx(found.max(), rel=1e-9)


def test_carried_rise_closes_the_energy_balance():
    """30.35 W and 100 bar * 2.63e-6 m3/s = 26.3 W into 876 * 1900 * 2.63e-6 = 4.377 W/K: 12.94 K."""
    assert carried_temperature_rise(30.35, 1e7, 2.63e-6, 876.0, 1900.0) == pytest.approx(12.94, abs=0.01)
