"""The load observer: exact transition and gains, no bias from a load that nobody told."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from vvdp.base.errors import ParameterError
from vvdp.estimation.load_observer import (
    LoadObserver,
    cylinder_step,
    load_gains,
    load_observer_start,
    load_observer_step,
)

SETTINGS = LoadObserver(
    moving_mass=100.0, viscous_friction=2000.0, observer_rate=80.0, load_rate=15.0, sample_period=1e-3
)


def matrices(settings):
    """Transition of position, velocity and load, and what a force of the oil adds, by the matrix exponential."""
    A = np.zeros((4, 4))
    A[0, 1] = 1.0
    A[1, 1] = -settings.viscous_friction / settings.moving_mass
    A[1, 2] = A[1, 3] = 1.0 / settings.moving_mass
    F = expm(A * settings.sample_period)
    return F[:3, :3], F[:3, 3]


@pytest.mark.parametrize("friction", [0.0, 1e-3, 99.0, 101.0, 2000.0, 1e5])
@pytest.mark.parametrize("period", [1e-3, 1e-2])
def test_transition_is_exact(friction, period):
    """On both sides of where the series takes over."""
    settings = replace(SETTINGS, viscous_friction=friction, sample_period=period)
    step, (F, g) = cylinder_step(settings), matrices(settings)
    assert (step.keeping, step.reach, step.lift) == pytest.approx((F[1, 1], F[0, 1], 100.0 * g[0]), rel=1e-10)
    assert 100.0 * g[1] == pytest.approx(step.reach, rel=1e-12)


@pytest.mark.parametrize("friction", [0.0, 2000.0])
def test_errors_fade_by_one_triple_root(friction):
    """(z - exp(-w h))^3 is the characteristic polynomial of (I - K C) F."""
    settings = replace(SETTINGS, viscous_friction=friction)
    F, _ = matrices(settings)
    gains = np.array(load_gains(cylinder_step(settings), settings))
    M = (np.eye(3) - np.outer(gains, [1.0, 0.0, 0.0])) @ F
    z = np.exp(-80.0 * 1e-3)
    assert np.poly(M) == pytest.approx([1.0, -3.0 * z, 3.0 * z**2, -(z**3)], rel=1e-10)


def test_gains_by_hand_for_fine_sampling():
    """Without friction they go to 3 w h, 3 w^2 h and m w^3 h for a small period."""
    fine = replace(SETTINGS, viscous_friction=0.0, sample_period=1e-6)
    found = np.array(load_gains(cylinder_step(fine), fine)) / 1e-6
    assert found == pytest.approx([240.0, 19_200.0, 100.0 * 80.0**3], rel=1e-3)


def moved(settings, true_load, told, until=2.0, force=None):
    """Last velocity, and memory of the observer, of a cylinder that moves exactly under a force of the oil held."""
    F, g = matrices(settings)
    y, memory = np.array([0.1, 0.0, true_load]), load_observer_start(0.1, told)
    force = 900.0 if force is None else force
    memory = memory._replace(oil_force=force)
    for _ in range(round(until / settings.sample_period)):
        y = F @ y + g * force
        memory = load_observer_step(memory, float(y[0]), force, settings)
    return y, memory


def test_an_unknown_load_leaves_no_bias():
    """To rounding: after 2 s the error of 1 kN has faded by exp(-160), what is told by exp(-30)."""
    y, memory = moved(SETTINGS, true_load=-2000.0, told=-1000.0)
    assert memory.velocity == pytest.approx(y[1], rel=1e-9)
    assert memory.load_force == pytest.approx(-2000.0, rel=1e-9)
    assert memory.position == pytest.approx(y[0], rel=1e-12)


def test_two_states_would_be_biased_by_an_unknown_load():
    """2 dF/(m w): 1 kN on 100 kg at 80 1/s, 0.25 m/s. Without friction, (s + w)^2 has gains 2 w and w^2."""
    w, m, h, dF = 80.0, 100.0, 1e-5, 1000.0
    x, v, believed = 0.0, 0.0, np.zeros(2)
    for _ in range(40_000):
        a = dF / m
        x, v = x + h * v + 0.5 * h * h * a, v + h * a
        innovation = x - believed[0]
        believed = believed + h * np.array([believed[1] + 2.0 * w * innovation, w * w * innovation])
    assert v - believed[1] == pytest.approx(2.0 * dF / (m * w), rel=1e-2)
    assert 2.0 * dF / (m * w) == pytest.approx(0.25)


def test_what_is_told_follows_the_estimate():
    """1 - exp(-15 h) of the distance a sample."""
    memory = load_observer_start(0.1, -1000.0)
    after = load_observer_step(memory, 0.1001, 1000.0, SETTINGS)
    share = (after.load_force + 1000.0) / (after.load_estimate + 1000.0)
    assert share == pytest.approx(1.0 - np.exp(-15e-3), rel=1e-12)
    assert after.load_estimate > -1000.0


def test_at_rest_it_stays_at_rest():
    memory = load_observer_start(0.1, -1000.0)
    for _ in range(10):
        memory = load_observer_step(memory, 0.1, 1000.0, SETTINGS)
    assert memory == pytest.approx(load_observer_start(0.1, -1000.0), abs=1e-12)


def test_an_observer_without_rate_is_refused():
    with pytest.raises(ParameterError, match="observer_rate"):
        replace(SETTINGS, observer_rate=0.0)
