"""Section 5.6: what the law of the chamber does with estimated states, against the true motion.

The pressure law is given x_est and x_est' = v - e_1' while the plant moves by x and v; e_1 = x - x_est, e_2 = e_1'.
Rates are central differences along the true motion. Two of them check the bounds (5.35) and (5.66).
"""

from dataclasses import replace
from typing import NamedTuple

import pytest

from vvdp.base.select import maximum
from vvdp.control.chamber import ChamberReading, chamber_volume, desired_pressure, desired_rate_sensitivities
from vvdp.control.passivity import printed_feedforward, printed_passivity_law
from vvdp.control.reference import Reference, reference_ahead
from vvdp.control.storage import loop_balance
from vvdp.fluid.mixture import bulk_modulus, compression_energy_per_volume, density_rise

STEP = 1e-6
START = Reference(3.0e-3, 0.02, 0.4, 5.0)


class Case(NamedTuple):
    """The true reading at time 0, the errors e_1, e_2 and e_2' of its estimate, and what the flow adds to Q_d."""

    reading: ChamberReading
    e1: float
    e2: float
    de2: float
    added: float


CASES = [
    Case(ChamberReading(3.1e-3, 0.024, 14.2e5), 1e-4, -3e-3, 0.5, -2e-5),
    Case(ChamberReading(2.8e-3, 0.011, 12.7e5), -8e-5, 2e-3, -0.8, 1e-5),
    Case(ChamberReading(3.05e-3, 0.021, 13.1e5), 2e-5, 1e-3, 0.3, 0.0),
]
pytestmark = pytest.mark.parametrize("case", CASES)


def estimated(case, reading=None, time=0.0):
    """What the law is told, with e_1 = e1 + e2 t + de2 t^2/2."""
    x, v, P = reading or case.reading
    e1 = case.e1 + case.e2 * time + 0.5 * case.de2 * time**2
    return ChamberReading(x - e1, v - case.e2 - case.de2 * time, P)


def acceleration(reading, drive):
    force = drive.area * (reading.pressure - drive.oil.reference_pressure) - drive.stiffness * reading.position
    return (force - drive.preload) / drive.moving_mass


def truth(case, flow, time, drive):
    """The true reading a little later or earlier, with P' = beta/V (Q - A x')."""
    x, v, P = case.reading
    a = acceleration(case.reading, drive)
    slope = bulk_modulus(P, drive.oil) / chamber_volume(x, drive) * (flow - drive.area * v)
    return ChamberReading(x + v * time + 0.5 * a * time**2, v + a * time, P + slope * time)


def slope_of(function, case, flow, drive):
    """d/dt of function(reference, estimate) along the true motion."""
    ends = []
    for time in (-STEP, STEP):
        ends.append(function(reference_ahead(START, time), estimated(case, truth(case, flow, time, drive), time)))
    return (ends[1] - ends[0]) / (2.0 * STEP)


def told(case, drive, gains):
    """Desired pressure and errors as the law has them, and P - P_dn."""
    wanted = desired_pressure(START, estimated(case), gains, drive)
    return wanted, case.reading.pressure - wanted.pressure


def test_errors_of_the_estimate_and_true_errors(drive, passive, case):
    """(5.58), (5.59): e = e_n + e_1, r = r_n - l e_1, e_v = e_vn + e_2 + l e_1, e_vn = e_n' + l e_n."""
    n, _ = told(case, drive, passive)
    true = desired_pressure(START, case.reading, passive, drive)
    assert true.position_error == pytest.approx(n.position_error + case.e1, rel=1e-12)
    assert true.reference_velocity == pytest.approx(n.reference_velocity - 50.0 * case.e1, rel=1e-12)
    assert true.velocity_error == pytest.approx(n.velocity_error + case.e2 + 50.0 * case.e1, rel=1e-12)

    def error(reference, reading):
        return desired_pressure(reference, reading, passive, drive).position_error

    rate = slope_of(error, case, 0.0, drive)
    assert n.velocity_error == pytest.approx(rate + 50.0 * n.position_error, rel=1e-7)


def test_velocity_error_of_the_estimate_moves_by_its_errors(drive, passive, case):
    """(5.60), (5.61): M e_vn' = -(K + K_p) e_n - K_v e_vn + A p - M e_2' - K e_1; 0.1 mm of e_1 is 0.2594 N."""
    n, p = told(case, drive, passive)
    e, ev, K, M, A = n.position_error, n.velocity_error, drive.stiffness, drive.moving_mass, drive.area

    def mechanical(reference, reading):
        wanted = desired_pressure(reference, reading, passive, drive)
        return 0.5 * M * wanted.velocity_error**2 + 0.5 * (K + 55.0) * wanted.position_error**2

    def velocity_error(reference, reading):
        return desired_pressure(reference, reading, passive, drive).velocity_error

    assert pytest.approx(0.2594) == K * 1e-4
    forces = -(K + 55.0) * e - 4.0 * ev + A * p - M * case.de2 - K * case.e1
    assert M * slope_of(velocity_error, case, 0.0, drive) == pytest.approx(forces, rel=1e-6, abs=1e-7)
    power = -4.0 * ev**2 - 50.0 * (K + 55.0) * e**2 + p * A * ev - case.de2 * M * ev - case.e1 * K * ev
    assert slope_of(mechanical, case, 0.0, drive) == pytest.approx(power, rel=1e-6, abs=1e-9)


def alphas(gains, drive):
    """alpha_1 = alpha_2 K/M, alpha_2 = (M l + K_v)/A: (0.5 x 50 + 4)/1.74e-4 = 1.6667e5 Pa s/m, x 5188 1/s^2."""
    second = (drive.moving_mass * gains.error_rate + gains.velocity_gain) / drive.area
    return second * drive.stiffness / drive.moving_mass, second


def true_rate(case, drive, gains):
    """P_dn' by (5.62), corrected."""
    n, p = told(case, drive, gains)
    f = desired_rate_sensitivities(gains, drive)
    first, second = alphas(gains, drive)
    of_errors = f.position * n.position_error + f.velocity * n.velocity_error + f.pressure * p
    return n.known_rate + of_errors + first * case.e1 + second * case.de2


def test_rate_of_the_desired_pressure_has_the_errors_of_the_estimate(drive, passive, case):
    """(5.62) with alpha_1 = 8.647e8 Pa/(m s) and alpha_2 = 1.6667e5 Pa s/m of e_1 and e_2'."""
    assert alphas(passive, drive) == pytest.approx((8.6467e8, 1.66667e5), rel=1e-4)

    def pressure(reference, reading):
        return desired_pressure(reference, reading, passive, drive).pressure

    rate = slope_of(pressure, case, 0.0, drive)
    assert rate == pytest.approx(true_rate(case, drive, passive), rel=1e-5)


def flow_of(case, drive, gains):
    """Q_dn + q of (5.65)."""
    wanted, _ = told(case, drive, gains)
    return printed_feedforward(wanted, estimated(case), drive) + case.added


def written_rate(case, drive, gains):
    """W' by (5.64) with P_dn' of (5.62), corrected by the two terms of docs/errata.md."""
    n, p = told(case, drive, gains)
    x, v, P = case.reading
    place, flow, A = estimated(case), flow_of(case, drive, gains), drive.area
    W = compression_energy_per_volume(P, n.pressure, drive.oil)
    rise = chamber_volume(place.position, drive) * density_rise(P, n.pressure, drive.oil)
    e, ev, K, M = n.position_error, n.velocity_error, drive.stiffness, drive.moving_mass
    moved = -4.0 * ev**2 - 50.0 * (K + 55.0) * e**2 + p * A * ev - case.de2 * M * ev - case.e1 * K * ev
    oil = p * flow - p * A * place.velocity + W * flow - rise * true_rate(case, drive, gains)
    other = chamber_volume(place.position, drive) / chamber_volume(x, drive) - 1.0
    return moved + oil, -A * case.e2 * (p + W) + other * (p + W) * (flow - A * v)


def test_storage_with_the_estimate_grows_as_written(drive, passive, case):
    """(5.63), (5.64): W of the law's own errors, along the true motion; without the two terms it differs."""
    flow = flow_of(case, drive, passive)

    def storage(reference, reading):
        return loop_balance(flow, reference, reading, passive, drive).storage

    rate = slope_of(storage, case, flow, drive)
    printed, more = written_rate(case, drive, passive)
    assert rate == pytest.approx(printed + more, rel=1e-5)
    assert rate != pytest.approx(printed, rel=1e-5)


def test_law_with_the_estimate(drive, passive, case):
    """(5.65), (5.67): Q = A r_n + V(x_est)/beta(P_dn) P_d1' - lambda_3 p, P_d1' = (M x_d''' + K x_d')/A."""
    n, p = told(case, drive, passive)
    known = (0.5 * 5.0 + 2594.0 * 0.02) / 1.74e-4
    compliance = (60e-6 + 1.74e-4 * (case.reading.position - case.e1)) / bulk_modulus(n.pressure, drive.oil)
    flow = 1.74e-4 * n.reference_velocity + compliance * known - 4e-10 * p
    assert printed_passivity_law(START, estimated(case), passive, drive).flow == pytest.approx(flow, rel=1e-12)


def bounded_rate(case, drive, gains, size):
    """The right side of (5.66), of (5.35) without estimation errors; `size` takes P_dn' and Q_dn in kappa."""
    n, p = told(case, drive, gains)
    place, oil = estimated(case), drive.oil
    V, K, M = chamber_volume(place.position, drive), drive.stiffness, drive.moving_mass
    W, feedforward = compression_energy_per_volume(case.reading.pressure, n.pressure, oil), flow_of(case, drive, gains)
    feedforward -= case.added
    soft = 1.0 / bulk_modulus(n.pressure, oil)
    mu = abs(density_rise(case.reading.pressure, n.pressure, oil) / p - soft) / abs(p)
    rate, known = true_rate(case, drive, gains), n.known_rate
    kappa = mu * V * size(rate) + W / p**2 * abs(feedforward)
    e, ev = n.position_error, n.velocity_error
    errors = -4.0 * ev**2 - 50.0 * (K + 55.0) * e**2 - (case.de2 * M + case.e1 * K) * ev
    return errors - p * V * soft * (rate - known) + (p + W) * case.added + kappa * p**2


@pytest.mark.parametrize("estimates", [False, True], ids=["5.35", "5.66"])
def test_rate_of_the_storage_is_bounded(drive, passive, case, estimates):
    """(5.35), (5.66) with |P_d'| in kappa; the known rate is that of the reference alone."""
    case = case if estimates else case._replace(e1=0.0, e2=0.0, de2=0.0)
    exact = written_rate(case, drive, passive)[0]
    bound = bounded_rate(case, drive, passive, abs)
    assert exact <= bound + 1e-12
    assert bound - exact < maximum(abs(exact), 0.05)


def test_bound_with_a_falling_desired_pressure_needs_its_magnitude(drive, passive, case):
    """Oil without air, where 1/B - 1/beta goes with p: (5.66) is broken if kappa has P_d' without its magnitude."""
    stiff = replace(drive, oil=replace(drive.oil, air_fraction=0.0))
    falling = case._replace(de2=-40.0)
    exact = written_rate(falling, stiff, passive)[0]
    assert true_rate(falling, stiff, passive) < 0.0
    assert bounded_rate(falling, stiff, passive, float) < exact - 1e-12
    assert exact <= bounded_rate(falling, stiff, passive, abs) + 1e-12
