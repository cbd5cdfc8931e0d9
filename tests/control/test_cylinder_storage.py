"""What the cylinder stores: h, x_F, W_F against quadrature, and the rate of W against a simulated motion."""

import numpy as np
import pytest
from scipy.integrate import quad
from tests.displacement_case import settings_of_chapter_6

from vvdp.control.capacities import capacities
from vvdp.control.cylinder_force import Motion, desired_force, total_effort
from vvdp.control.cylinder_storage import (
    cylinder_balance,
    displaced_measure,
    force_distance,
    force_measure,
    force_storage,
)
from vvdp.control.reference import Reference

SETTINGS = settings_of_chapter_6()
GAINS, CYLINDER = SETTINGS.gains, SETTINGS.cylinder
BETA = CYLINDER.bulk_modulus


def test_measure_by_hand():
    """x = 0: 20.26e-4 ln 1e-3 - 10.77e-4 ln 1.2e-3 = -1.3995e-2 + 7.2431e-3 = -6.7520e-3 m^2."""
    assert force_measure(0.0, CYLINDER) == pytest.approx(-6.7520e-3, rel=1e-4)


def test_slope_of_the_measure_is_the_stiffness_over_the_bulk_modulus():
    """h' = L, so that h rises everywhere; central difference, exact to 1e-9."""
    for x in np.linspace(0.01, 0.34, 12).tolist():
        slope = (force_measure(x + 1e-5, CYLINDER) - force_measure(x - 1e-5, CYLINDER)) / 2e-5
        assert slope * BETA == pytest.approx(capacities(1.0, x, 1e5, CYLINDER).stiffness, rel=1e-7)
        assert displaced_measure(0.01, x, CYLINDER) == pytest.approx(
            force_measure(x + 0.01, CYLINDER) - force_measure(x, CYLINDER), rel=1e-11
        )


@pytest.mark.parametrize("error", [0.0, 1e-6, 100.0, -3e3, 5e4, -1e6, 1e7])
def test_piston_would_give_the_force_at_the_distance_found(error):
    """Whatever the error: h reaches every value."""
    d = force_distance(error, 0.15, CYLINDER)
    assert displaced_measure(d, 0.15, CYLINDER) == pytest.approx(error / BETA, rel=1e-9, abs=1e-20)


@pytest.mark.parametrize("error", [50.0, -3e3, 5e4, -1e6])
def test_storage_is_the_integral(error):
    x = 0.15
    d = force_distance(error, x, CYLINDER)
    at = force_measure(x + d, CYLINDER)
    integral = BETA * quad(lambda s: force_measure(s, CYLINDER) - at, x + d, x, epsabs=0.0, epsrel=1e-10)[0]
    assert force_storage(d, x, CYLINDER) == pytest.approx(integral, rel=1e-6)
    stiffness = capacities(1.0, x, 1e5, CYLINDER).stiffness
    if abs(error) < 5e3:
        assert force_storage(d, x, CYLINDER) == pytest.approx(error * error / (2.0 * stiffness), rel=1e-2)


def motion_under(effort_of, until, h):
    """Time, storage and its rate along the motion of cylinder and force, F_H' = U - S x' (RK4)."""
    load, m = -1000.0, 100.0
    y, rows = np.array([0.104, 0.02, 900.0]), []

    def reference(t):
        return Reference(
            0.1 + 0.02 * np.sin(3.0 * t), 0.06 * np.cos(3.0 * t), -0.18 * np.sin(3.0 * t), -0.54 * np.cos(3.0 * t)
        )

    def look(t, y):
        motion = Motion(y[0], y[1], load, m)
        desired = desired_force(reference(t), motion, y[2], GAINS, CYLINDER)
        stiffness = capacities(1.0, y[0], 1e5, CYLINDER).stiffness
        return motion, desired, stiffness, effort_of(t, total_effort(stiffness, desired, y[2], 1.0, GAINS))

    def rates(t, y):
        _, _, stiffness, effort = look(t, y)
        return np.array([y[1], (y[2] - CYLINDER.viscous_friction * y[1] + load) / m, effort - stiffness * y[1]])

    for n in range(round(until / h)):
        t = n * h
        motion, desired, _, effort = look(t, y)
        rows.append((t, *cylinder_balance(effort, desired, motion, y[2], GAINS, CYLINDER)))
        k1 = rates(t, y)
        k2 = rates(t + h / 2, y + h / 2 * k1)
        k3 = rates(t + h / 2, y + h / 2 * k2)
        y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + rates(t + h, y + h * k3))
    return np.array(rows).T


def test_storage_falls_all_the_time_under_the_law():
    """And is gone: the slowest of its rates, lambda and those of the motion, leaves less than 1e-4 after 1 s."""
    _, storage, rate = motion_under(lambda t, effort: effort, 1.0, 1e-3)
    assert np.all(np.diff(storage) < 0.0)
    assert np.all(rate < 0.0)
    assert storage[-1] < 1e-4 * storage[0]


def test_rate_of_the_storage_is_its_difference_quotient():
    """With an effort that is off by some; central differences over 1 ms, quadratic, so 1e-3 of the largest."""
    t, storage, rate = motion_under(lambda t, effort: effort + 2e3 * np.cos(20.0 * t), 0.5, 2.5e-4)
    quotient = (storage[2:] - storage[:-2]) / (t[2:] - t[:-2])
    assert np.max(np.abs(quotient - rate[1:-1])) < 1e-3 * np.max(np.abs(rate))


@pytest.mark.parametrize("error", [50.0, -3e3, 5e4])
def test_rate_of_the_force_storage(error):
    """(6.14), (6.16): W_F' = -e_F x' - (U - F_v')(x - x_F), x - x_F = -e_F/(beta L(alpha)), alpha between both.

    F_v stands still here, so e_F' = U - beta L x'; by central difference. 50 N on 3.1325e6 N/m are 15.96 um.
    """
    x, speed, effort, h = 0.1, 0.04, 2e5, 1e-7

    def storage(time):
        place = x + speed * time
        force = error + effort * time - BETA * (force_measure(place, CYLINDER) - force_measure(x, CYLINDER))
        return force_storage(force_distance(force, place, CYLINDER), place, CYLINDER)

    d = force_distance(error, x, CYLINDER)
    rate = (storage(h) - storage(-h)) / (2.0 * h)
    assert rate == pytest.approx(-error * speed + d * effort, rel=1e-5)
    between = np.linspace(x, x + d, 101).tolist()
    stiffness = [capacities(1.0, place, 1e5, CYLINDER).stiffness for place in between]
    assert min(stiffness) <= error / d <= max(stiffness)
    if error == 50.0:
        assert d == pytest.approx(15.96e-6, rel=1e-3)
