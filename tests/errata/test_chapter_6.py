"""Misprints and gaps of chapter 6 of wang2017: each number of a row worked out anew."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from tests.displacement_case import ATMOSPHERE, BAR, LPM, settings_of_chapter_6

from vvdp.control.capacities import CircuitPressures, capacities
from vvdp.control.cylinder_force import Motion, desired_force, total_effort
from vvdp.control.cylinder_storage import cylinder_balance, force_distance
from vvdp.control.direction import DirectionSettings
from vvdp.control.displacement import CylinderSeen, displacement_start, displacement_step
from vvdp.control.pressure_modes import Swept, mode_ends
from vvdp.control.reference import Reference, ReferenceFilter, reference_at_rest, reference_step

SETTINGS = settings_of_chapter_6()
CYLINDER, GAINS = SETTINGS.cylinder, SETTINGS.gains
A, B, VA, VB = CYLINDER.area_a, CYLINDER.area_b, CYLINDER.oil_volume_a, CYLINDER.oil_volume_b
BETA = CYLINDER.bulk_modulus


def slenderness(x):
    """L without beta [m]."""
    return A**2 / (VA + A * x) + B**2 / (VB - B * x)


def test_stiffness_counts_the_bulk_modulus_once(told):
    """beta L with L of the brace without beta: 3.13e6 N/m at 0.1 m; with it twice, 2.19e15."""
    stiffness = capacities(1.0, 0.1, ATMOSPHERE, CYLINDER).stiffness
    assert stiffness == pytest.approx(BETA * slenderness(0.1), rel=1e-12)
    assert f"{stiffness:.2e}".replace("e+0", "e") in told
    assert f"{BETA * stiffness:.2e}".replace("e+", "e") in told


def test_disturbance_does_work_with_its_own_sign():
    """m e_v' = F_H - F_v - K_v e_v - K_p e + d: the rate of W with a disturbance has + e_v d."""
    reference, motion, disturbance = Reference(0.1, 0.05, 0.2, 0.0), Motion(0.103, 0.04, -700.0, 100.0), 50.0
    found = desired_force(reference, motion, 1500.0, GAINS, CYLINDER)
    e, ev, m = found.position_error, found.velocity_error, 100.0
    push = 1500.0 - CYLINDER.viscous_friction * 0.04 - 700.0
    rates = []
    for d in (0.0, disturbance):
        de, dev = motion.velocity - reference.velocity, (push + d) / m - found.reference_acceleration
        rates.append(m * ev * dev + GAINS.position_gain * e * de)
    assert ev != 0.0
    assert rates[1] - rates[0] == pytest.approx(ev * disturbance, rel=1e-9)


def test_printed_measure_does_not_rise(told):
    """h' = A_1^2/V_1 - A_2^2/V_2 for equal areas: zero at mid stroke, with either sign beside it."""

    def slope(x, area=10.77e-4, volume=1.2e-3, stroke=0.3):
        return area**2 / (volume + area * x) - area**2 / (volume + area * (stroke - x))

    ends = [slope(0.0), slope(0.15), slope(0.3)]
    assert ends[1] == pytest.approx(0.0, abs=1e-18)
    assert ends[0] == pytest.approx(-ends[2])
    assert f"{ends[0] * 1e4:.2f}e-4" in told


def test_robust_control_counts_the_bulk_modulus_once():
    """beta u_rob in U* with u_rob = -K_rob (F_H - F_v) is a rate like lambda_3 beta; with another beta 7e8 times it."""
    reference, motion = Reference(0.1, 0.05, 0.2, 0.0), Motion(0.101, 0.055, -1000.0, 100.0)
    desired = desired_force(reference, motion, 1500.0, GAINS, CYLINDER)
    robust = replace(GAINS, robust_rate=BETA * 1e-9)
    added = total_effort(3e6, desired, 1500.0, 1.0, robust) - total_effort(3e6, desired, 1500.0, 1.0, GAINS)
    assert added == pytest.approx(-BETA * 1e-9 * (1500.0 - desired.force), rel=1e-9)


def test_robust_gain_is_not_needed(told):
    """W_F falls with (lambda_3 + K_rob - gamma_F |r|)/L(alpha) at least: gamma_F |r| at 0.1 m/s is far below 4e-8."""
    x = np.linspace(0.0, 0.3, 301)
    steepest = np.max(np.abs(-(A**3) / (VA + A * x) ** 2 + B**3 / (VB - B * x) ** 2))
    bound = steepest / (BETA * np.min(slenderness(x)))
    assert f"{bound:.1e}".replace("e-0", "e-") in told
    assert 0.1 * bound < 0.01 * GAINS.pressure_rate / BETA
    rng = np.random.default_rng(5)
    for _ in range(200):
        at, error = float(rng.uniform(0.05, 0.25)), float(rng.uniform(-5e4, 5e4))
        d = force_distance(error, at, CYLINDER)
        between = error / (BETA * d)
        assert abs(slenderness(at) - between) <= bound * abs(error)


def test_sum_of_the_pressures_is_left_open():
    """Flow and opening that give the same effort raise both pressures at different rates."""
    capacity, psi = capacities(1.0, 0.1, ATMOSPHERE, CYLINDER), 1e-4
    H, K = capacity.supply_gain, capacity.return_gain * psi

    def rates(flow, opening):
        return BETA / (VA + A * 0.1) * (flow - A * 0.05), BETA / (VB - B * 0.1) * (B * 0.05 - psi * opening)

    one, other = rates(1e-4, 0.5), rates(1e-4 + 0.3 * K / H, 0.2)
    assert A * one[0] - B * one[1] == pytest.approx(A * other[0] - B * other[1], rel=1e-9)
    assert sum(other) - sum(one) > 1e6


def test_a_lasting_disturbance_leaves_an_error():
    """Where d stays, the errors end where W's rate is zero, not at zero: K_p e + K_v lambda e = d at rest."""
    d = 500.0
    reference = reference_at_rest(0.1)
    e = d / (GAINS.position_gain + GAINS.velocity_gain * GAINS.error_rate)
    motion = Motion(0.1 + e, 0.0, 0.0, 100.0)
    force = desired_force(reference, motion, 0.0, GAINS, CYLINDER).force
    assert force + d == pytest.approx(0.0, abs=1e-9)
    still = desired_force(reference, motion, force, GAINS, CYLINDER)
    assert cylinder_balance(still.rate, still, motion, force, GAINS, CYLINDER).storage > 0.0


def follow_triangle(settings, until=5.5):
    """Time, direction and opening at every sample of the nominal case; the pump follows in 50 ms."""
    y, memory = np.array([0.05, 0.0, 10.0 * BAR, 10.0 * BAR, 0.0]), displacement_start(settings)
    reference, smooth, rows, h = reference_at_rest(0.05), ReferenceFilter(filter_rate=12.0), [], 5e-4

    def rates(y, demand):
        x, v, Pa, Pb, Q = y.tolist()
        at = Pb if demand.direction > 0.0 else Pa
        out = demand.opening * CYLINDER.return_conductance * np.sign(at) * abs(at) ** 0.5
        into_a, into_b = (Q, -out) if demand.direction > 0.0 else (-out, Q)
        force = Pa * A - Pb * B - CYLINDER.viscous_friction * v - 1000.0
        rate_a, rate_b = BETA / (VA + A * x) * (into_a - A * v), BETA / (VB - B * x) * (into_b + B * v)
        return np.array([v, force / 100.0, rate_a, rate_b, (demand.flow - Q) / 0.05])

    for n in range(round(until * 1e3)):
        wanted = 0.05 + 0.216 * (1.0 - abs(1.0 - n * 1e-3 / 4.0))
        reference = reference_step(reference, wanted, 1e-3, smooth)
        P = CircuitPressures(y[2] + ATMOSPHERE, y[3] + ATMOSPHERE, ATMOSPHERE)
        seen = CylinderSeen(position=y[0], velocity=y[1], load_force=-1000.0, fast=P, slow=P, delivered_flow=y[4])
        memory, demand = displacement_step(memory, seen, reference, settings)
        rows.append((n * 1e-3, demand.direction, demand.opening, y[0] - reference.position))
        for _ in range(2):
            k1 = rates(y, demand)
            k2 = rates(y + h / 2 * k1, demand)
            k3 = rates(y + h / 2 * k2, demand)
            y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + rates(y + h * k3, demand))
    return np.array(rows).T


@cache
def nominal():
    return follow_triangle(SETTINGS)


@cache
def as_printed():
    split = replace(SETTINGS.split, expected_flow=0.0, uses_delivered_flow=0.0)
    return follow_triangle(replace(SETTINGS, split=split, direction=DirectionSettings()))


def switches(rows):
    """Changes of direction after the first second."""
    t, direction = rows[0], rows[1]
    return int(np.sum(np.diff(direction[t > 1.0]) != 0.0))


def test_bare_sign_of_the_effort_chatters(told):
    """At a reversal: switches in a burst with the bare sign, one with the hysteresis."""
    assert switches(nominal()) == 1
    assert 5 <= switches(as_printed()) <= 11
    assert "5 to 11 switches" in told
    assert np.max(np.abs(nominal()[3][nominal()[0] > 1.0])) < 1.2e-3


def test_without_its_mean_the_pump_leaves_the_valve_wide_open(told):
    """Mean opening after the first second, over a way out and the beginning of the way back."""
    for rows in (nominal(), as_printed()):
        t, opening = rows[0], rows[2]
        assert f"{np.mean(opening[t > 1.0]):.2f}" in told


def test_mode_5_is_a_lower_bound_of_the_opening():
    """The return lets out more than the piston brings: with zeta_u > 1 for either sign of the velocity, else not."""
    for margin, either in ((0.5, False), (1.2, True)):
        bounds = replace(SETTINGS.bounds, return_margin=margin)
        ways = [mode_ends(Swept(0.0, q), 1e-4, 0.0, bounds).letting * 1e-4 for q in (5.0 * LPM, -5.0 * LPM)]
        assert ways[0] > 5.0 * LPM
        assert (min(ways) > 0.0) == either


def test_mode_2_does_not_fill_a_chamber_at_rest(told):
    """Published Q = A_s x' + xi |A_s x'| is 0 at x' = 0; in retraction it exceeds -A_2 x', which is what 6.24d asks."""
    bounds = SETTINGS.bounds
    assert mode_ends(Swept(0.0, 0.0), 1e-4, 0.0, bounds).filling == 0.0
    assert f"{mode_ends(Swept(0.0, 0.0), 1e-4, bounds.boost_flow, bounds).filling / LPM:.1f} lpm" in told
    retracting = Swept(-B * -0.05, -A * -0.05)
    assert mode_ends(retracting, 1e-4, 0.0, bounds).filling > B * 0.05
