"""The chamber's laws: the published numbers, and the identities on which passivity rests, at random states."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vvdp.base.errors import ParameterError
from vvdp.control.backstepping import backstepping_law, best_pressure_weight, velocity_share
from vvdp.control.chamber import (
    ChamberReading,
    chamber_volume,
    desired_pressure,
    desired_rate_sensitivities,
    volume_compliance,
)
from vvdp.control.passivity import (
    PassivityGains,
    exact_feedforward,
    held_gain,
    passivity_law,
    pressure_error_gain,
    printed_feedforward,
    printed_passivity_law,
)
from vvdp.control.reference import Reference
from vvdp.control.storage import loop_balance, pressure_balance, pressure_storage
from vvdp.fluid.mixture import bulk_modulus, compression_energy_per_volume, density_rise

BAR = 1e5
REFERENCES = st.builds(
    Reference, st.floats(0.5e-3, 5e-3), st.floats(-0.05, 0.05), st.floats(-5.0, 5.0), st.floats(-500.0, 500.0)
)
READINGS = st.builds(ChamberReading, st.floats(0.5e-3, 5e-3), st.floats(-0.05, 0.05), st.floats(10e5, 14e5))


FRICTIONS = st.sampled_from([0.0, 8.3, 20.0])


def moved(reference, reading, flow, drive, dt, friction=0.0):
    """Reference and reading a moment later, to second order: the reference of constant jerk, the plant by its laws."""
    M, A, K, P0 = drive.moving_mass, drive.area, drive.stiffness, drive.oil.reference_pressure

    def rates(y):
        x, v, P = y
        beta, V = bulk_modulus(P, drive.oil), chamber_volume(x, drive)
        return np.array([v, (A * (P - P0) - K * x - drive.preload - friction * v) / M, beta / V * (flow - A * v)])

    y = np.array(reading)
    y = y + dt * rates(y + 0.5 * dt * rates(y))
    x, v, a, j = reference
    later = Reference(x + v * dt + a * dt**2 / 2 + j * dt**3 / 6, v + a * dt + j * dt**2 / 2, a + j * dt, j)
    return later, ChamberReading(*y)


def derivative(value, reference, reading, flow, drive, friction=0.0, dt=2e-7):
    """Rate of a value of reference and reading along the plant's motion, by central difference."""
    ends = [value(*moved(reference, reading, flow, drive, s * dt, friction)) for s in (-1.0, 1.0)]
    return (ends[1] - ends[0]) / (2.0 * dt)


def test_energies_of_the_published_oil(oil):
    """Cho's law with 10 % of air per oil. 14 and 10 bar, absolute."""
    assert compression_energy_per_volume(14 * BAR, 10 * BAR, oil) == pytest.approx(781.6, abs=0.05)
    assert compression_energy_per_volume(10 * BAR, 14 * BAR, oil) == pytest.approx(933.5, abs=0.05)


def test_compliance_of_the_published_chamber(drive):
    """V/beta at 14 bar, 4.93e-13 m^3/Pa, six times less than the published lambda_2; pressure pole 811 1/s."""
    found = volume_compliance(0.0, 14 * BAR, drive)
    assert found == pytest.approx(4.93e-13, rel=1e-3)
    assert 4e-10 / found == pytest.approx(811.0, abs=0.5)
    assert 3e-12 / found == pytest.approx(6.0, abs=0.1)


def test_sensitivities_of_the_published_gains(drive, passive, backstepping):
    """alpha_e = ((M l + K_v)(K + K_p)/M - l (M l^2 - K_p))/A = (29 * 2649/0.5 - 50 * 1195)/1.74e-4, and so on."""
    found = desired_rate_sensitivities(passive, drive)
    assert found == pytest.approx(
        ((29 * 2649 / 0.5 - 50 * 1195) / 1.74e-4, (29 * 8 + 1195) / 1.74e-4, -58.0), rel=1e-12
    )
    assert found == pytest.approx((5.396e8, 8.201e6, -58.0), rel=1e-4)
    assert desired_rate_sensitivities(backstepping, drive) == pytest.approx((2.329e9, 4.023e7, -140.0), rel=3e-4)


@given(REFERENCES, READINGS, FRICTIONS)
def test_rate_is_the_known_one_and_the_sensitivities(drive, passive, reference, reading, friction):
    """(5.31) with the jerk: P_d' = P_d1' + alpha_e e + alpha_ev e_v + alpha_P p."""
    passive = replace(passive, friction=friction)
    wide = replace(drive, valve=replace(drive.valve, supply_pressure=9e8, tank_pressure=0.0))
    found, alpha = desired_pressure(reference, reading, passive, wide), desired_rate_sensitivities(passive, drive)
    errors = found.position_error, found.velocity_error, reading.pressure - found.pressure
    f = sum(a * e for a, e in zip(alpha, errors, strict=True))
    if found.pressure > 0.0:
        assert found.rate == pytest.approx(found.known_rate + f, rel=1e-9, abs=1.0)


@given(REFERENCES, READINGS, st.floats(-1e-4, 1e-4), FRICTIONS)
def test_rate_of_the_desired_pressure_is_its_derivative(drive, passive, reference, reading, flow, friction):
    passive = replace(passive, friction=friction)

    def pressure(reference, reading):
        return desired_pressure(reference, reading, passive, drive).pressure

    found = desired_pressure(reference, reading, passive, drive)
    if found.rate:
        rate = derivative(pressure, reference, reading, flow, drive, friction)
        # the plant's pressure, but not its flow, tells the acceleration
        assert rate == pytest.approx(found.rate, rel=1e-5, abs=200.0)


def test_desired_pressure_stays_between_tank_and_supply(drive, passive):
    for position, level in ((0.02, drive.valve.supply_pressure), (-0.2, drive.valve.tank_pressure)):
        found = desired_pressure(Reference(position, 0.01, 0.0, 0.0), ChamberReading(0.0, 0.0, 13e5), passive, drive)
        assert (found.pressure, found.rate, found.known_rate) == (level, 0.0, 0.0)


def test_at_rest_the_pressure_holds_the_spring(drive, passive):
    """x = 0 takes 12.16 bar gauge; 190 psi reach 6.34 mm."""
    found = desired_pressure(Reference(0.0, 0.0, 0.0, 0.0), ChamberReading(0.0, 0.0, 13e5), passive, drive)
    assert (found.pressure - 1e5) / BAR == pytest.approx(12.155, abs=1e-3)
    reach = (1.310e6 * drive.area - drive.preload) / drive.stiffness
    assert reach == pytest.approx(6.34e-3, abs=5e-6)


@given(REFERENCES, READINGS, st.floats(-1e-4, 1e-4), st.sampled_from([0.001, 0.0909, 0.23]))
def test_storage_rises_by_exactly_what_is_supplied(drive, passive, reference, reading, flow, air):
    """d(V W_V)/dt = (p + W_V)(Q - Q_d) - p A e_v, identically, also where the desired pressure is held."""
    drive = replace(drive, oil=replace(drive.oil, air_fraction=air))
    desired = desired_pressure(reference, reading, passive, drive)
    found = pressure_balance(flow, desired, reading, drive)

    def storage(r, y):
        return pressure_storage(desired_pressure(r, y, passive, drive), y, drive)

    rate = derivative(storage, reference, reading, flow, drive)
    size = abs(reading.pressure - desired.pressure) * (abs(flow) + 1e-5)
    assert rate == pytest.approx(found.supply, rel=1e-4, abs=2e-4 * size + 1e-9)


@given(REFERENCES, READINGS, FRICTIONS)
def test_closed_loop_loses_what_its_gains_take(drive, passive, reference, reading, friction):
    """(5.33): with the exact law nothing else is left, and it is below zero; with friction for b l < 4 (K + K_p)."""
    passive = replace(passive, friction=friction)
    control = passivity_law(reference, reading, passive, drive)
    found = loop_balance(control.flow, reference, reading, passive, drive)
    if not control.desired.rate:
        return
    assert found.supply <= 0.0

    def storage(r, y):
        return loop_balance(0.0, r, y, passive, drive).storage

    rate = derivative(storage, reference, reading, control.flow, drive, friction)
    assert rate == pytest.approx(found.supply, rel=1e-4, abs=1e-4 * found.storage / 0.01 + 1e-9)


def test_pressure_against_friction_by_hand(drive, passive):
    """20 N s/m at 0.1 m/s are 2 N, 11494 Pa on 1.74 cm^2; at 2 m/s^2 they grow by 40 N/s, 229885 Pa/s.

    The measured 0.05 m/s against friction is 1 N less on 0.5 kg: M l + K_v = 29 times 2 m/s^2 is 58 N/s of 1.74e-4 m^2.
    """
    reference, reading = Reference(2e-3, 0.1, 2.0, 0.0), ChamberReading(2e-3, 0.05, 13e5)
    wide = replace(drive, valve=replace(drive.valve, supply_pressure=9e8))
    free, rubbed = (
        desired_pressure(reference, reading, replace(passive, friction=friction), wide) for friction in (0.0, 20.0)
    )
    assert rubbed.pressure - free.pressure == pytest.approx(2.0 / 1.74e-4, rel=1e-9)
    assert rubbed.known_rate - free.known_rate == pytest.approx(40.0 / 1.74e-4, rel=1e-9)
    assert rubbed.rate - free.rate == pytest.approx((40.0 + 29.0 * 2.0) / 1.74e-4, rel=1e-9)


def test_without_friction_not_a_bit_changes(drive, passive):
    """Pressure and rate by the formulas without b, term by term in their order."""
    A, M, K, P0 = drive.area, drive.moving_mass, drive.stiffness, drive.oil.reference_pressure
    r, y = Reference(2.1e-3, 0.013, 0.7, 31.0), ChamberReading(2.3e-3, 0.017, 12.9e5)
    e, de = y.position - r.position, y.velocity - r.velocity
    ev, dde = de + 50.0 * e, (A * (y.pressure - P0) - K * y.position - drive.preload) / M - r.acceleration
    found = desired_pressure(r, y, passive, drive)
    forces = M * (r.acceleration - 50.0 * de) + K * r.position + drive.preload
    assert found.pressure == P0 + (forces - 55.0 * e - 4.0 * ev) / A
    known = (M * r.jerk + K * r.velocity) / A
    assert (found.known_rate, found.rate) == (
        known,
        known - (M * 50.0 * dde + 55.0 * de + 4.0 * (dde + 50.0 * de)) / A,
    )


def test_storage_may_rise_where_friction_is_larger_than_the_springs(drive, passive):
    """b l = 4 (K + K_p) at b = 211.9 N s/m. With 1e5 N s/m some errors raise it: e_v = l e/2 at p = 0."""
    reference = Reference(2e-3, 0.0, 0.0, 0.0)
    wide = replace(drive, valve=replace(drive.valve, supply_pressure=9e8, tank_pressure=0.0))

    def supply(friction):
        gains = replace(passive, friction=friction)
        e = 1e-5
        reading = ChamberReading(2e-3 + e, 25.0 * e - 50.0 * e, 13e5)
        level = desired_pressure(reference, reading, gains, wide).pressure
        reading = reading._replace(pressure=level)
        return loop_balance(passivity_law(reference, reading, gains, wide).flow, reference, reading, gains, wide).supply

    assert supply(211.0) < 0.0 < supply(1e5)


@given(REFERENCES, READINGS)
def test_printed_feedforward_leaves_a_rest(drive, passive, reference, reading):
    """p (Q_d - A r - V/B P_d') + W_V Q_d is zero for the exact one alone."""
    desired = desired_pressure(reference, reading, passive, drive)
    p = reading.pressure - desired.pressure
    W = compression_energy_per_volume(reading.pressure, desired.pressure, drive.oil)
    B_part = chamber_volume(reading.position, drive) * density_rise(reading.pressure, desired.pressure, drive.oil)

    def rest(flow):
        return p * (flow - drive.area * desired.reference_velocity) - B_part * desired.rate + W * flow

    exact, printed = (f(desired, reading, drive) for f in (exact_feedforward, printed_feedforward))
    size = abs(p * exact) + abs(B_part * desired.rate) + 1e-12
    assert abs(rest(exact)) < 1e-12 * size
    if abs(exact - printed) > 1e-7 and abs(p) > 1e3:
        assert abs(rest(printed)) > 1e-3 * abs(p) * 1e-7


def test_feedforward_is_smooth_through_a_met_pressure(drive, passive):
    """1/B goes to 1/beta and W/p to 0: no series is needed, down to the last digits of p."""
    reference = Reference(2e-3, 0.02, 1.0, 100.0)
    desired = desired_pressure(reference, ChamberReading(2e-3, 0.01, 13e5), passive, drive)
    values = {}
    for p in (-100.0, -1.0, -1e-3, -1e-6, 0.0, 1e-6, 1e-3, 1.0, 100.0):
        reading = ChamberReading(2e-3, 0.01, desired.pressure + p)
        values[p] = exact_feedforward(desired, reading, drive)
    slope = (values[100.0] - values[-100.0]) / 200.0
    compliance = volume_compliance(2e-3, desired.pressure, drive)
    assert values[0.0] == pytest.approx(drive.area * desired.reference_velocity + compliance * desired.rate, rel=1e-12)
    for p, value in values.items():
        assert value == pytest.approx(values[0.0] + slope * p, rel=1e-8)


def test_gain_is_scheduled_by_volume_over_modulus(drive, passive):
    gains = replace(passive, flow_gain=0.0, pressure_rate=500.0)
    found = pressure_error_gain(2e-3, 14e5, gains, drive)
    assert found == pytest.approx(500.0 * (60e-6 + 1.74e-4 * 2e-3) / bulk_modulus(14e5, drive.oil), rel=1e-14)
    assert pressure_error_gain(2e-3, 14e5, passive, drive) == 4e-10


def test_flow_by_hand(drive, passive):
    """At rest on the reference and at its pressure nothing flows; 1 bar below, 4e-10 * 1e5 = 4e-5 m^3/s and more."""
    at_rest = Reference(2e-3, 0.0, 0.0, 0.0)
    held = 1e5 + (2594 * 2e-3 + 211.5) / 1.74e-4
    assert passivity_law(at_rest, ChamberReading(2e-3, 0.0, held), passive, drive).flow == pytest.approx(0.0, abs=1e-18)
    low = passivity_law(at_rest, ChamberReading(2e-3, 0.0, held - 1e5), passive, drive)
    assert low.flow - low.feedforward == pytest.approx(4e-5, rel=1e-9)
    # P_d' = alpha_P p = 58e5 Pa/s takes V/B of it; printed, the feedforward is 0
    softness = density_rise(held - 1e5, held, drive.oil) / -1e5
    W = compression_energy_per_volume(held - 1e5, held, drive.oil)
    expected = chamber_volume(2e-3, drive) * softness * 58e5 / (1.0 + W / -1e5)
    assert low.feedforward == pytest.approx(expected, rel=1e-9)
    assert printed_passivity_law(at_rest, ChamberReading(2e-3, 0.0, held - 1e5), passive, drive).flow == pytest.approx(
        4e-5, rel=1e-9
    )


def test_a_held_flow_by_hand(drive, passive):
    """1 bar below P_d, held for 3 ms: w T = 4e-10/C 3e-3, and 4e-5 m^3/s times (1 - e^-wT)/(w T).

    A reference of 0.02 m/s and 1 m/s^2 is 1.5 mm/s faster in the middle: A times that more flow, K/A of it in the rate.
    """
    gains = replace(passive, flow_hold=3e-3)
    held = 1e5 + (2594 * 2e-3 + 211.5) / 1.74e-4
    low = passivity_law(Reference(2e-3, 0.0, 0.0, 0.0), ChamberReading(2e-3, 0.0, held - 1e5), gains, drive)
    faded = 4e-10 / volume_compliance(2e-3, held, drive) * 3e-3
    assert 2.0 < faded < 2.5
    assert low.flow - low.feedforward == pytest.approx(4e-5 * (1.0 - np.exp(-faded)) / faded, rel=1e-9)
    moving, reading = Reference(2e-3, 0.02, 1.0, 0.0), ChamberReading(2e-3, 0.02, 13.5e5)
    more = printed_passivity_law(moving, reading, gains, drive)
    less = printed_passivity_law(moving, reading, passive, drive)
    compliance = volume_compliance(2e-3, less.desired.pressure, drive)
    expected = 1.74e-4 * 1.5e-3 + compliance * 2594.0 * 1.5e-3 / 1.74e-4
    assert more.feedforward - less.feedforward == pytest.approx(expected, rel=1e-9)


@given(st.floats(-11.0, -8.0), st.floats(-14.0, -11.0), st.floats(-5.0, -1.0))
def test_a_held_gain_lets_the_pressure_error_fade_as_in_continuous_time(gain, compliance, hold):
    """C p' = -g p(0) over the hold leaves e^-wT of p(0), and never turns it round."""
    gain, compliance, hold = 10.0**gain, 10.0**compliance, 10.0**hold
    left = 1.0 - held_gain(gain, compliance, hold) * hold / compliance
    assert left == pytest.approx(np.exp(-gain * hold / compliance), abs=1e-12)
    assert held_gain(gain, compliance, 0.0) == gain


@given(REFERENCES, READINGS)
def test_backstepping_with_the_right_weight_is_the_printed_law(drive, passive, backstepping, reference, reading):
    """lambda_2 = V/beta turns (5.40) into (5.37), V/beta at one and the same pressure."""
    gains = replace(backstepping, position_gain=55.0, velocity_gain=4.0)
    desired = desired_pressure(reference, reading, gains, drive)
    reading = reading._replace(pressure=desired.pressure + 1e-6)
    desired = desired_pressure(reference, reading, gains, drive)
    compliance = volume_compliance(reading.position, desired.pressure, drive)
    found = backstepping_law(reference, reading, replace(gains, pressure_weight=compliance), drive)
    assert found.flow == pytest.approx(
        printed_passivity_law(reference, reading, passive, drive).flow, rel=1e-6, abs=1e-13
    )


def test_share_of_the_velocity_that_reaches_the_flow(drive, passive, backstepping):
    """By difference: -0.383 of A v in the printed passive law; 1 - (V/beta)/lambda_2 - k in backstepping, -0.091."""
    reference, reading = Reference(2e-3, 0.0, 0.0, 0.0), ChamberReading(2e-3, 0.0, 13.5e5)

    def share(law, gains):
        faster = reading._replace(velocity=1e-4)
        rise = law(reference, faster, gains, drive).flow - law(reference, reading, gains, drive).flow
        return rise / (drive.area * 1e-4)

    assert velocity_share(passive, 4e-10, drive) == pytest.approx(0.383, abs=5e-4)
    assert velocity_share(backstepping, 4e-10, drive) == pytest.approx(0.925, abs=5e-4)
    assert share(printed_passivity_law, passive) == pytest.approx(-velocity_share(passive, 4e-10, drive), rel=1e-6)
    compliance = volume_compliance(2e-3, 13.5e5, drive)
    expected = 1.0 - compliance / 3e-12 - velocity_share(backstepping, 4e-10, drive)
    assert share(backstepping_law, backstepping) == pytest.approx(expected, rel=1e-6)
    best = best_pressure_weight(compliance, backstepping, 4e-10, drive)
    assert share(backstepping_law, replace(backstepping, pressure_weight=best)) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("position_gain", "velocity_gain", "flow_gain", "multiple"),
    [(55.0, 4.0, 4e-10, 1.62), (550.0, 45.0, 4e-10, 13.3), (55.0, 38.0, 4e-10, 5.96), (55.0, 4.0, 1e-10, 1.106)],
)
def test_best_weight_as_a_multiple_of_volume_over_modulus(
    drive, backstepping, position_gain, velocity_gain, flow_gain, multiple
):
    gains = replace(backstepping, position_gain=position_gain, velocity_gain=velocity_gain, flow_gain=flow_gain)
    assert best_pressure_weight(5e-13, gains, flow_gain, drive) / 5e-13 == pytest.approx(multiple, rel=3e-3)


def test_gains_that_no_weight_can_help_are_refused(drive, backstepping):
    """A^2/(M lambda_p + K_v) = 3.0276e-8/70 = 4.33e-10."""
    message = r"must be less than A\^2/\(M lambda_p \+ K_v\) = 4.32514e-10 m\^3/\(s\*Pa\): .* k = 1.16"
    with pytest.raises(ParameterError, match=message):
        best_pressure_weight(5e-13, backstepping, 5e-10, drive)


def test_gains_that_hold_nothing_are_refused(drive, passive, backstepping):
    with pytest.raises(ParameterError, match="flow_gain or pressure_rate must be greater than 0"):
        PassivityGains(error_rate=50.0, position_gain=55.0, velocity_gain=4.0)
    with pytest.raises(ParameterError, match="velocity_gain: 0"):
        replace(passive, velocity_gain=0.0)
    with pytest.raises(ParameterError, match=r"pressure_weight: 0 m\^3/Pa"):
        replace(backstepping, pressure_weight=0.0)
    with pytest.raises(ParameterError, match=r"ChamberDrive\.moving_mass: 0 kg"):
        replace(drive, moving_mass=0.0)
