"""Storage as evidence: it never rises under the exact law, and what is reported where it does."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from vvdp.base.errors import ParameterError
from vvdp.base.signal import signal_value, table
from vvdp.control.backstepping import backstepping_law, best_pressure_weight
from vvdp.control.chamber import ChamberReading, chamber_volume, volume_compliance
from vvdp.control.orifice import valve_command, valve_flow
from vvdp.control.passivity import passivity_law, printed_passivity_law
from vvdp.control.reference import Pauses, Reference, ReferenceFilter, reference_at_rest, reference_step, trapezoid
from vvdp.control.storage import (
    StorageBalance,
    estimation_storage,
    least_estimation_weight,
    loop_balance,
    storage_excess,
)
from vvdp.control.tuning import sampling_limits
from vvdp.fluid.mixture import bulk_modulus

START = 0.25e-3
BALANCED = 1e5 + (2594.0 * START + 211.5) / 1.74e-4


def rates(y, flow, drive):
    """The plant, volume-counting, as the source has it."""
    x, v, P = y
    beta, V = bulk_modulus(P, drive.oil), chamber_volume(x, drive)
    force = drive.area * (P - drive.oil.reference_pressure) - drive.stiffness * x - drive.preload
    return v, force / drive.moving_mass, beta / V * (flow - drive.area * v)


def continuous(law, drive, gains, reference, start):
    """The loop without sampling, about a reference at rest: storage at 2000 instants of 0.2 s."""

    def flow_at(y):
        return law(reference, ChamberReading(*y), gains, drive).flow

    times = np.linspace(0.0, 0.2, 2000)
    found = solve_ivp(
        lambda t, y: rates(y, flow_at(y), drive),
        (0.0, 0.2),
        start,
        "DOP853",
        times,
        rtol=1e-9,
        atol=(1e-12, 1e-9, 1e-3),
    )
    return np.array([loop_balance(flow_at(y), reference, ChamberReading(*y), gains, drive) for y in found.y.T])


def test_storage_never_rises_without_sampling(drive, passive):
    """From rest 1 mm beside the reference, an ideal source of flow: 1.98e-3 J falls to nothing. But for rounding."""
    start = 1e-3, 0.0, 1e5 + (2594.0 * 1e-3 + 211.5) / 1.74e-4
    storage, supply = continuous(passivity_law, drive, passive, reference_at_rest(2e-3), start).T
    assert storage[0] == pytest.approx(1.98e-3, rel=0.05)
    assert np.all(np.diff(storage) <= 1e-11 * storage[0])
    assert storage[-1] < 1e-8 * storage[0]
    assert np.all(supply <= 0.0)
    change = np.sum(0.5 * (supply[1:] + supply[:-1])) * 0.2 / 1999
    assert storage[-1] - storage[0] == pytest.approx(change, rel=3e-3)


SAMPLES = 12479


def swing(t):
    """A reference of 1 mm at 5 Hz about 3 mm, with its derivatives."""
    w, a = 10.0 * np.pi, 1e-3
    s, c = a * np.sin(w * t), a * np.cos(w * t)
    return Reference(3e-3 + s, w * c, -(w**2) * s, -(w**3) * c)


def rest(t):
    return reference_at_rest(3e-3)


@pytest.mark.thorough
@pytest.mark.parametrize("path", [rest, swing], ids=["fixed", "moving"])
def test_storage_falls_from_an_error_of_1_mm(drive, passive, path):
    """With an ideal flow source: from 1.98e-3 J to 1e-20 J or less, no rise in 12479 samples; its change is that of the
    identity (5.33)."""
    strong = replace(drive, valve=replace(drive.valve, supply_pressure=1e7))
    begin = path(0.0)
    start = (begin.position - 1e-3, begin.velocity, 1e5 + (2594.0 * (begin.position - 1e-3) + 211.5) / 1.74e-4)

    def slope(t, y):
        flow = passivity_law(path(t), ChamberReading(*y), passive, strong).flow
        return rates(y, flow, strong)

    times = np.linspace(0.0, 0.8, SAMPLES)
    found = solve_ivp(slope, (0.0, 0.8), start, "DOP853", times, rtol=1e-12, atol=(1e-15, 1e-13, 1e-8))
    stored, supply = [], []
    for t, y in zip(times, found.y.T, strict=True):
        flow = passivity_law(path(t), ChamberReading(*y), passive, strong).flow
        balance = loop_balance(flow, path(t), ChamberReading(*y), passive, strong)
        stored.append(balance.storage)
        supply.append(balance.supply)
    stored, supply = np.array(stored), np.array(supply)
    assert stored[0] == pytest.approx(1.98e-3, rel=0.03)
    assert stored[-1] < 1e-20
    assert np.count_nonzero(np.diff(stored) > 1e-16 * stored[0]) == 0
    residual = np.gradient(stored, times)[1:-1] - supply[1:-1]
    assert np.max(np.abs(residual)) < 0.003 * np.max(np.abs(supply))


def move(y, command, drive, period, pieces=10):
    """The plant a period later, by Runge and Kutta's method."""
    h = period / pieces

    def slope(y):
        return np.array(rates(y, valve_flow(command, y[2], drive.valve), drive))

    for _ in range(pieces):
        a = slope(y)
        b = slope(y + 0.5 * h * a)
        c = slope(y + 0.5 * h * b)
        y = y + h / 6.0 * (a + 2.0 * b + 2.0 * c + slope(y + h * c))
    return y


def sampled(law, drive, gains, period=1e-3):
    """Position errors [m] and what storage rose beyond its supply [J], over a trapezoid of 5 mm in 0.4 s.

    The command is held over the sample.
    """
    points, settings = (
        trapezoid(START, 5.25e-3, Pauses(0.15, 0.15), 0.05, periods=1),
        ReferenceFilter(filter_rate=250.0),
    )
    signal = table(*zip(*points, strict=True))
    reference, y, errors, excesses = reference_at_rest(START), np.array([START, 0.0, BALANCED]), [], []
    for k in range(round(0.4 / period)):
        wanted = law(reference, ChamberReading(*y), gains, drive).flow
        command = valve_command(wanted, y[2], drive.valve)
        flow = valve_flow(command, y[2], drive.valve)
        errors.append(y[0] - reference.position)
        before = loop_balance(flow, reference, ChamberReading(*y), gains, drive)
        y = move(y, command, drive, period)
        reference = reference_step(reference, signal_value(k * period, signal), period, settings)
        flow = valve_flow(command, y[2], drive.valve)
        after = loop_balance(flow, reference, ChamberReading(*y), gains, drive)
        excesses.append(storage_excess(before, after, period))
    return np.array(errors), np.array(excesses)


def rms(errors):
    return 1e6 * np.sqrt(np.mean(errors**2))


@pytest.mark.parametrize("law", [passivity_law, printed_passivity_law])
def test_trapezoid_of_5_mm(drive, passive, law):
    """Published 7.70 um rms, here over 0.4 s, from pause to pause; within 10 %."""
    errors, excesses = sampled(law, drive, passive)
    assert rms(errors) == pytest.approx(7.70, rel=0.10)
    assert np.max(np.abs(errors)) < 50e-6
    assert np.max(excesses) < 1e-7


@pytest.mark.thorough
def test_trapezoid_by_backstepping(drive, passive, backstepping):
    """9.16 um with the table's gains, 18.4 um with the passive ones, 7.45 um with them and lambda_2 = V/beta."""
    mild = replace(backstepping, position_gain=55.0, velocity_gain=4.0)
    assert rms(sampled(backstepping_law, drive, backstepping)[0]) == pytest.approx(9.16, rel=0.10)
    assert rms(sampled(backstepping_law, drive, mild)[0]) == pytest.approx(18.4, rel=0.10)
    right = replace(mild, pressure_weight=5.0e-13)
    assert rms(sampled(backstepping_law, drive, right)[0]) == pytest.approx(7.45, rel=0.10)


def slow_velocity(law, drive, gains, until=1.2, period=1e-3):
    """RMS error [um] over a sine of 5 Hz and 1.5 mm, from 0.6 s on; the velocity is seen through a low pass of 1 Hz."""
    settings, reference, seen, errors = ReferenceFilter(filter_rate=250.0), reference_at_rest(2.75e-3), 0.0, []
    y = np.array([2.75e-3, 0.0, 1e5 + (2594.0 * 2.75e-3 + 211.5) / 1.74e-4])
    for k in range(round(until / period)):
        seen += -np.expm1(-2.0 * np.pi * period) * (y[1] - seen)
        errors.append(y[0] - reference.position)
        wanted = law(reference, ChamberReading(y[0], seen, y[2]), gains, drive).flow
        y = move(y, valve_command(wanted, y[2], drive.valve), drive, period, pieces=4)
        wave = 2.75e-3 + 1.5e-3 * np.sin(10.0 * np.pi * k * period)
        reference = reference_step(reference, wave, period, settings)
    return rms(np.array(errors[round(0.6 / period) :]))


@pytest.mark.slow
@pytest.mark.parametrize(("velocity_gain", "multiple"), [(4.0, 1.62), (38.0, 5.96)])
def test_a_slow_velocity_does_least_harm_at_the_best_weight(drive, backstepping, velocity_gain, multiple):
    """Simulated minima, published at 1.6 and 6.0 V/beta. A fifth beside them the error is twice as large, and more."""
    gains = replace(backstepping, position_gain=55.0, velocity_gain=velocity_gain)
    compliance = volume_compliance(2.75e-3, 1e5 + (2594.0 * 2.75e-3 + 211.5) / 1.74e-4, drive)
    best = best_pressure_weight(compliance, gains, 4e-10, drive)
    assert best / compliance == pytest.approx(multiple, rel=3e-3)
    found = [slow_velocity(backstepping_law, drive, replace(gains, pressure_weight=s * best)) for s in (0.8, 1.0, 1.2)]
    assert found[1] < 0.65 * min(found[0], found[2])
    assert found[1] < 10.0


@pytest.mark.slow
def test_a_slow_velocity_under_the_passive_law(drive, passive):
    """Published 135 um, with the gains of table 5.1."""
    assert slow_velocity(passivity_law, drive, passive) == pytest.approx(135.0, rel=0.05)


def test_energy_excess_by_hand():
    before, after = StorageBalance(1.0, -3.0), StorageBalance(0.9, -2.0)
    assert storage_excess(before, after, 0.01) == pytest.approx(-0.08)
    assert storage_excess(before, StorageBalance(1.0, -2.0), 0.01) == pytest.approx(0.02)


def test_sampling_beyond_the_limit_swings(drive, passive):
    """4 ms at a pole of 811 1/s: 2.5 ms is the limit. Published 512 um against 7.7 um."""
    assert sampling_limits(4e-10, 4.93e-13).limit == pytest.approx(2.465e-3, rel=1e-3)
    quick, _ = sampled(passivity_law, drive, passive, period=2e-3)
    slow, excesses = sampled(passivity_law, drive, passive, period=4e-3)
    assert np.sqrt(np.mean(slow**2)) > 10.0 * np.sqrt(np.mean(quick**2))
    assert np.max(excesses) > 1e-5


def test_estimation_storage_by_hand():
    assert estimation_storage(np.array([1.0, 2.0]), np.diag([4.0, 0.5])) == pytest.approx(0.25 + 8.0)


def test_least_weight_makes_the_sum_fall():
    """Of a cascade: an estimation error that fades and drives a tracking error."""
    t = np.linspace(0.0, 5.0, 500)
    tracking, estimation = (t * np.exp(-2.0 * t)) ** 2, np.exp(-4.0 * t)
    c = least_estimation_weight(tracking, estimation)
    assert np.all(np.diff(tracking + 1.0001 * c * estimation) <= 0.0)
    assert not np.all(np.diff(tracking + 0.99 * c * estimation) <= 0.0)
    assert least_estimation_weight(estimation, estimation) == 0.0
    # d/dt of (t^2 + c) e^-4t is below zero for c >= (t - 2 t^2)/2, at most 1/16 at t = 1/4
    assert c == pytest.approx(1.0 / 16.0, rel=1e-3)


def test_weight_that_cannot_be_found_is_refused():
    with pytest.raises(ParameterError, match="sample 1: the tracking storage rises by 1 J"):
        least_estimation_weight(np.array([0.0, 1.0]), np.array([1.0, 1.0]))
    assert least_estimation_weight(np.array([0.0, 1.0]), np.array([1.0, 1.0]), tolerance=1.0) == 0.0
