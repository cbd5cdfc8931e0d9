"""The averages solved angle by angle against the ones over whole arrays, against closed forms, and compiled."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vvdp.steady import cycle_means as module
from vvdp.steady.averages import averages, means_at
from vvdp.steady.cycle_means import SLOWEST, CyclePoint, cycle_means, half_period, speed_after
from vvdp.valve import flow_map
from vvdp.valve.condition import Condition
from vvdp.valve.flow_map import averaged_spool_speed, quasi_steady_mean
from vvdp.valve.losses import closed_form_load_flow
from vvdp.valve.torque import friction_coefficient

TANK, RELIEF, FLOW, RHO, MU = 101325.0, 121.01325e5, 40e-3 / 60.0, 876.0, 0.0387
RATED = 30e-3 / 60.0


def condition(load, override=0.0, leakage=0.0):
    return Condition(
        flow=FLOW,
        load_pressure=load,
        relief_pressure=RELIEF,
        tank_pressure=TANK,
        density=RHO,
        relief_override=override,
        relief_rated_flow=RATED,
        pump_leakage=leakage,
    )


def point(duty=0.5, load=101.01325e5, override=0.0, leakage=0.0):
    return CyclePoint(
        duty_ratio=duty,
        load_pressure=load,
        tank_pressure=TANK,
        relief_pressure=RELIEF,
        relief_override=override,
        relief_rated_flow=RATED,
        flow=FLOW,
        pump_leakage=leakage,
        density=RHO,
        viscosity=MU,
    )


@given(
    duty=st.floats(-0.2, 1.2),
    load=st.floats(1.5e5, 118e5),
    override=st.sampled_from([0.0, 10e5]),
    leakage=st.sampled_from([0.0, 2.45e-12]),
    lap=st.sampled_from([0.5, 1.0, 1.3]),
)
def test_same_as_over_whole_arrays(source_stand, duty, load, override, leakage, lap):
    """At the same angles: bisection over arrays of angles against closed form and regula falsi at each angle."""
    valve = source_stand.with_tables(valve={"lap_ratio": lap}).bench.valve
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(module, "ANGLES", 60)
        patched.setattr(flow_map, "ANGLES", 60)
        found = cycle_means(point(duty, load, override, leakage), valve)
        known = quasi_steady_mean(duty, condition(load, override, leakage), valve)
        speed = averaged_spool_speed(duty, condition(load, override, leakage), MU, valve)
    assert found.load_flow == pytest.approx(known.load_flow, abs=1e-9 * FLOW)
    assert found.tank_flow == pytest.approx(known.tank_flow, abs=1e-9 * FLOW)
    assert found.inlet_pressure == pytest.approx(known.inlet_pressure, rel=1e-9)
    assert found.spool_speed == pytest.approx(speed, rel=1e-8)


def test_closed_form_where_it_holds(source_stand):
    """Q d - lost; 2e-4 is what neglecting the centre section's exponent below a* costs, docs/models/rotary-valve.md."""
    valve = source_stand.bench.valve
    found = cycle_means(point(0.5), valve).load_flow
    assert found == pytest.approx(closed_form_load_flow(0.5, condition(101.01325e5), valve), rel=2e-4)


def test_flows_add_up_with_pump_leakage(source_stand):
    """Load, tank, relief and leakage at the mean inlet pressure: the leak is linear, so its mean is exact."""
    leakage = 2e-12
    found = cycle_means(point(leakage=leakage, override=10e5), source_stand.bench.valve)
    leak = leakage * (found.inlet_pressure - TANK)
    assert found.load_flow + found.tank_flow + found.relief_flow + leak == pytest.approx(FLOW, rel=1e-9)


def test_resistance_by_hand(source_stand):
    """That of friction, and of the swirl with which oil leaves, rho R_out^2 q: 876 x 0.0127^2 x 6.6667e-4 = 9.4193e-5
    N m s for all of the pump flow, so that times the share of it that passes the ports.
    """
    valve = source_stand.bench.valve
    found = cycle_means(point(), valve)
    passed = (found.load_flow + found.tank_flow) / FLOW
    assert found.resistance == pytest.approx(friction_coefficient(MU, valve) + 9.4193e-5 * passed, rel=1e-4)


def test_pump_leakage_takes_from_the_load(source_stand):
    valve = source_stand.bench.valve
    tight, leaking = (cycle_means(point(leakage=g), valve).load_flow for g in (0.0, 2e-12))
    assert leaking < tight


def test_compiled_is_the_same_text(source_stand):
    points = [point(d, p, o) for d in (0.05, 0.5, 0.93) for p, o in ((20e5, 0.0), (110e5, 5e5))]
    found = averages(np.array(points), source_stand.bench.valve, cores=2)
    for row, one in enumerate(points):
        np.testing.assert_allclose(means_at(found, row), cycle_means(one, source_stand.bench.valve), rtol=1e-11)


def test_number_of_angles_is_enough(source_stand):
    """Doubling the angles changes the mean flow by less than 1e-5 of the pump flow: the midpoint rule at kinks."""
    valve = source_stand.bench.valve
    coarse = cycle_means(point(0.37, 80e5), valve)
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(module, "ANGLES", 4 * module.ANGLES)
        fine = cycle_means(point(0.37, 80e5), valve)
    assert coarse.load_flow == pytest.approx(fine.load_flow, abs=1e-5 * FLOW)
    assert coarse.inlet_pressure == pytest.approx(fine.inlet_pressure, rel=2e-4)


def test_speed_after_a_stretch_by_hand():
    """J = 2, from 3 rad/s with 5 N m - 1 N m s omega over 1 rad: omega^2 - 9 = 5 - omega, omega = 3.2749."""
    assert speed_after(1.0, 3.0, 5.0, 1.0, 2.0) == pytest.approx(0.5 * (57.0**0.5 - 1.0), rel=1e-12)


def test_slowness_tells_a_spool_that_stops(source_stand):
    """Even torque: the time at the balanced speed. Friction fourfold: still turning; twentyfold and more: it stops."""
    even = np.full(50, 0.2)
    assert half_period(even, 0.1 * even, 1e-5, 0.02) == pytest.approx(50 * 0.02 / 10.0, rel=1e-9)
    area = source_stand.bench.valve.friction_area
    slowness = [
        cycle_means(point(), source_stand.with_tables(valve={"friction_area": factor * area}).bench.valve).slowness
        for factor in (1.0, 4.0, 20.0, 300.0)
    ]
    assert all(each < 1.5 for each in slowness[:2])
    assert all(each > 2.0 * SLOWEST for each in slowness[2:])


def test_choking_nozzles_lose_more_and_agree_with_the_bisection(source_stand):
    """A closing tank port that chokes sends more over the relief valve; both ways of averaging say how much."""
    prototype = source_stand.bench.valve
    usual = cycle_means(point(0.5), prototype)
    for recovery in (0.9, 0.5):
        valve = replace(prototype, pressure_recovery=recovery)
        found, other = cycle_means(point(0.5), valve), quasi_steady_mean(0.5, condition(point().load_pressure), valve)
        assert found.relief_flow > 1.01 * usual.relief_flow
        assert found.tank_flow < usual.tank_flow
        assert found.relief_flow == pytest.approx(other.relief_flow, rel=2e-3)
        assert found.load_flow == pytest.approx(other.load_flow, rel=2e-3)
    nearly = cycle_means(point(0.5), replace(prototype, pressure_recovery=1.0))
    assert nearly == pytest.approx(usual, rel=1e-9)
