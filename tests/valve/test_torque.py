from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_bvp

from vvdp.base.errors import ParameterError
from vvdp.fluid.oil import density, dynamic_viscosity, film_viscosity
from vvdp.valve.branch import BranchFlow, branch_flow
from vvdp.valve.condition import Condition
from vvdp.valve.flow_map import averaged_spool_speed, quasi_steady_cycle
from vvdp.valve.geometry import EVEN, JetSkews, Openings, jet_skews, port_shape
from vvdp.valve.torque import (
    SpoolSurface,
    equilibrium_speed,
    fit_friction_area,
    friction_area_from_lands,
    friction_coefficient,
    inlet_torque,
    outlet_torque,
    pwm_frequency,
    spool_inertia,
    spool_time_constant,
    spool_torque,
)

RHO, MU = 876.0, 0.0387
LPM = 1.0 / 6e4
Q40 = 40.0 * LPM
OMEGA = 2.0 * np.pi * 24.0


def full_open_frequency(flow, valve, rho=RHO, mu=MU):
    return pwm_frequency(equilibrium_speed(flow, rho, mu, valve), valve)


def test_torques_of_the_open_valve_at_40_lpm(prototype):
    # rho R Q^2 / A = 876 * 0.0127 * 4.4444e-7 / 36.5e-6 = 0.13547 N m
    assert inlet_torque(Q40, 1.0, RHO, prototype) == pytest.approx(0.13547, rel=1e-4)
    # 876 * 0.0127 * 4.4444e-7 / 61.8e-6 = 0.08001; 876 * 1.6129e-4 * 150.796 * 6.6667e-4 = 0.01420
    assert outlet_torque(Q40, 0.0, RHO, prototype) == pytest.approx(0.08001, rel=1e-4)
    assert outlet_torque(Q40, OMEGA, RHO, prototype) == pytest.approx(0.06580, rel=2e-4)
    # the published torque at this speed is about 30 W
    power = (inlet_torque(Q40, 1.0, RHO, prototype) + outlet_torque(Q40, OMEGA, RHO, prototype)) * OMEGA
    assert power == pytest.approx(30.35, rel=1e-3)


def test_jets_of_another_arm_have_another_torque(prototype):
    """876 * 0.0127 * 4.4444e-7 / (0.945 * 36.5e-6) = 0.14335 N m; the speed goes with the torque of both turbines."""
    fine = replace(prototype, inlet_area_ratio=0.945)
    assert inlet_torque(Q40, 1.0, RHO, fine) == pytest.approx(0.14335, rel=1e-4)
    share = (0.14335 + 0.08001) / (0.13547 + 0.08001)
    assert full_open_frequency(Q40, fine) / full_open_frequency(Q40, prototype) == pytest.approx(share, rel=1e-4)
    with pytest.raises(ParameterError, match="inlet_area_ratio: 0 must be greater than 0"):
        replace(prototype, inlet_area_ratio=0.0)


@pytest.mark.parametrize("nozzles", [1.0, 3.0, 7.0])
def test_inlet_torque_is_the_sum_over_single_nozzles(prototype, nozzles):
    # each nozzle has A / N and carries Q / N
    one = replace(prototype, nozzle_area=prototype.nozzle_area / nozzles)
    assert nozzles * inlet_torque(Q40 / nozzles, 1.0, RHO, one) == pytest.approx(
        inlet_torque(Q40, 1.0, RHO, prototype), rel=1e-14
    )


def test_friction_coefficient_and_inertia(prototype):
    # 2.716e-3 * 0.0387 * 1.6129e-4 / 12.7e-6 = 1.3349e-3 N m s; 0.5 * 0.5 * 1.6129e-4 = 4.0323e-5 kg m2
    assert friction_coefficient(MU, prototype) == pytest.approx(1.3349e-3, rel=1e-4)
    assert spool_inertia(prototype) == pytest.approx(4.0323e-5, rel=1e-4)
    # 4.0323e-5 / (1.3349e-3 + 876 * 1.6129e-4 * 6.6667e-4 = 9.419e-5) = 28.2 ms
    assert spool_time_constant(Q40, RHO, MU, prototype) == pytest.approx(28.2e-3, rel=1e-3)


def test_friction_of_a_spool_off_its_centre(prototype):
    """Shear goes with one over the gap c (1 + eps cos), averaged round the circumference."""
    angle = 2.0 * np.pi * (np.arange(2000) + 0.5) / 2000
    centred = friction_coefficient(MU, prototype)
    for eps in (0.3, 0.9):
        mean = np.mean(1.0 / (1.0 + eps * np.cos(angle)))
        valve = replace(prototype, eccentricity=eps)
        assert friction_coefficient(MU, valve) == pytest.approx(centred * mean, rel=1e-12)
    # 1/sqrt(1 - 0.81) = 2.29416; 0.215484/(2.29416 * 1.33494e-3 + 9.4188e-5) = 68.260 rad/s = 32.59 Hz
    assert friction_coefficient(MU, valve) / centred == pytest.approx(2.29416, rel=1e-5)
    assert full_open_frequency(Q40, valve) == pytest.approx(32.6, abs=0.05)
    assert fit_friction_area(32.6, Q40, RHO, MU, valve) == pytest.approx(2.716e-3, rel=1e-3)


def test_friction_area_with_oil_that_pressure_thickens(prototype, vg46):
    """The frequency is kept against the load of the system, so what the films thicken by, the area is less."""
    oil = replace(vg46, pressure_viscosity=2e-8)
    thick = film_viscosity(313.15, 100e5 + 101325.0, 101325.0, oil)
    # 0.2/(1 - e^-0.2) = 1.1033311; 2716/1.1033311 = 2461.6 mm2
    area = fit_friction_area(72.0, Q40, RHO, thick, prototype)
    assert area == pytest.approx(2.4616e-3, rel=3e-4)
    assert full_open_frequency(Q40, replace(prototype, friction_area=area), RHO, thick) == pytest.approx(
        72.0, rel=1e-12
    )
    # without a new area: 0.215484/(1.1033311 * 1.33494e-3 + 9.4188e-5) = 137.50 rad/s = 65.65 Hz
    assert full_open_frequency(Q40, prototype, RHO, thick) == pytest.approx(65.7, abs=0.06)


def test_friction_power_is_quadratic_in_speed_and_torque_linear(prototype):
    still = BranchFlow(0.0, 0.0, 1.0, 0.0, 0.0)
    one, two = (
        spool_torque(
            still, still, Openings(0.0, 1.0), EVEN, omega, RHO, friction_coefficient(MU, prototype), prototype
        ).friction
        for omega in (100.0, 200.0)
    )
    assert two == pytest.approx(2.0 * one, rel=1e-15)


@pytest.mark.parametrize(("lpm", "hertz"), [(20, 18.6), (26.7, 32.8), (30, 41.2), (40, 72.0), (50, 110.7)])
def test_frequency_over_flow(prototype, lpm, hertz):
    # printed to 0.1 Hz; the friction area, to four digits, is good for 0.01 Hz
    assert full_open_frequency(lpm * LPM, prototype) == pytest.approx(hertz, abs=0.07)


@pytest.mark.parametrize(("micrometres", "hertz"), [(10.0, 57.5), (12.7, 72.0), (15.0, 84.0), (20.0, 109.2)])
def test_frequency_over_clearance(prototype, micrometres, hertz):
    valve = replace(prototype, radial_clearance=1e-6 * micrometres)
    assert full_open_frequency(Q40, valve) == pytest.approx(hertz, abs=0.07)


@pytest.mark.parametrize(("celsius", "hertz"), [(30.0, 45.3), (40.0, 72.0), (45.0, 88.2), (50.0, 106.3)])
def test_frequency_over_temperature(prototype, vg46, celsius, hertz):
    T = celsius + 273.15
    rho, mu = density(T, vg46), dynamic_viscosity(T, vg46)
    assert full_open_frequency(Q40, prototype, rho, mu) == pytest.approx(hertz, abs=0.07)


def test_equilibrium_speed_does_not_depend_on_density_at_given_kinematic_viscosity(prototype):
    nu = MU / RHO
    assert equilibrium_speed(Q40, 800.0, 800.0 * nu, prototype) == pytest.approx(
        equilibrium_speed(Q40, RHO, MU, prototype), rel=1e-14
    )


def test_torques_balance_at_the_equilibrium_speed(prototype):
    omega = equilibrium_speed(Q40, RHO, MU, prototype)
    load = BranchFlow(Q40, Q40, 0.6, 0.1, 0.3)
    still = BranchFlow(0.0, 1e-3, 1.0, 0.0, 0.0)
    torque = spool_torque(
        load, still, Openings(1.0, 0.0), EVEN, omega, RHO, friction_coefficient(MU, prototype), prototype
    )
    assert torque.turbine == pytest.approx(torque.friction, rel=1e-14)


def test_friction_area_is_fitted_to_a_frequency(prototype):
    assert fit_friction_area(72.0, Q40, RHO, MU, prototype) == pytest.approx(2.716e-3, rel=3e-4)
    valve = replace(prototype, friction_area=fit_friction_area(60.0, 30.0 * LPM, RHO, MU, prototype))
    assert full_open_frequency(30.0 * LPM, valve) == pytest.approx(60.0, rel=1e-13)


def test_a_frequency_beyond_the_frictionless_one_is_refused(prototype):
    # Q (1/A_in + 1/A_out) / R = 6.6667e-4 * 43579 / 0.0127 = 2287.6 rad/s = 1092 Hz
    with pytest.raises(ParameterError, match="without any friction the valve spins at 1092 Hz"):
        fit_friction_area(1100.0, Q40, RHO, MU, prototype)


@given(st.floats(0.0, 1.0), st.floats(0.01, 1.0))
def test_jet_exponent_weights_the_momentum_by_the_opening(prototype, s, a):
    # rho R Q^2 / (A a^s) with Q = a Q_f
    valve = replace(prototype, jet_exponent=s)
    expected = RHO * 0.0127 * (a * 1e-3) ** 2 / (36.5e-6 * a**s)
    assert inlet_torque(1e-3, a, RHO, valve) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("s", [0.0, 0.5, 1.0])
def test_a_shut_port_gives_no_torque(prototype, s):
    valve = replace(prototype, jet_exponent=s)
    assert inlet_torque(1.5e-3, 0.0, RHO, valve) == 0.0


@given(st.floats(1e-6, 1e-3), st.floats(1.0, 400.0))
def test_reversed_flow_only_brakes_by_the_swirl_it_takes_away(prototype, flow, omega):
    valve = replace(prototype, inlet_radius=11e-3)
    assert inlet_torque(-flow, 1.0, RHO, valve) == 0.0
    # Euler: mass flow times (swirl in - swirl out) = rho Q (0 - R_in^2 omega)
    assert outlet_torque(-flow, omega, RHO, valve) == pytest.approx(-RHO * flow * 11e-3**2 * omega, rel=1e-14)


@given(st.floats(1e-5, 2e-3), st.floats(0.0, 300.0))
def test_turbine_power_is_what_the_fluid_loses(prototype, flow, omega):
    """In the frame of the spool the jet and the outlet do work as Euler's equation says, whatever the swirl between."""
    R = prototype.spool_radius
    v_in, v_out = flow / prototype.nozzle_area, flow / prototype.outlet_effective_area
    moment_in, moment_out = R * v_in, R * (R * omega - v_out)
    load = BranchFlow(flow, flow, 0.6, 0.1, 0.3)
    still = BranchFlow(0.0, 1e-3, 1.0, 0.0, 0.0)
    torque = spool_torque(load, still, Openings(1.0, 0.0), EVEN, omega, RHO, 1e-3, prototype)
    assert torque.turbine == pytest.approx(RHO * flow * (moment_in - moment_out), rel=1e-12)


def test_both_branches_add(prototype):
    load = branch_flow(2e6, 0.3, RHO, prototype)
    tank = branch_flow(6e6, 0.1, RHO, prototype)
    still = BranchFlow(0.0, 0.0, 1.0, 0.0, 0.0)
    both = spool_torque(load, tank, Openings(0.3, 0.1), EVEN, 150.0, RHO, 1e-3, prototype)
    one = spool_torque(load, still, Openings(0.3, 0.1), EVEN, 150.0, RHO, 1e-3, prototype)
    other = spool_torque(still, tank, Openings(0.3, 0.1), EVEN, 150.0, RHO, 1e-3, prototype)
    assert both.turbine == pytest.approx(one.turbine + other.turbine, rel=1e-14)


def surface(**changes):
    given = {
        "bearing_length": 20e-3,
        "pocket_length": 40e-3,
        "pocket_coverage": 0.8,
        "pocket_depth": 4e-3,
        "pocket_drag_factor": 4.0,
    }
    return SpoolSurface(**(given | changes))


def test_friction_area_from_lands_and_pockets(prototype):
    # 2 pi 0.0127 = 0.079796 m; lands 20 + 40 * 0.2 = 28 mm; pockets 32 mm * 4 * 12.7 / 4012.7 = 0.40511 mm
    assert friction_area_from_lands(surface(), prototype) == pytest.approx(0.079796 * 28.40511e-3, rel=1e-4)


def test_pockets_without_depth_are_land_and_deep_ones_do_not_drag(prototype):
    whole = 2.0 * np.pi * 12.7e-3 * 60e-3
    flush = surface(pocket_depth=0.0, pocket_drag_factor=1.0)
    assert friction_area_from_lands(flush, prototype) == pytest.approx(whole, rel=1e-14)
    deep = surface(pocket_depth=10.0)
    assert friction_area_from_lands(deep, prototype) == pytest.approx(2.0 * np.pi * 12.7e-3 * 28e-3, rel=1e-3)


def test_a_closed_pocket_drags_four_times_as_much_as_a_groove():
    """Laminar flow between a moving wall and one at rest, with the pressure gradient that leaves no net flow."""

    def rates(y, state):
        u, shear, _, gradient = state
        return np.vstack([shear, gradient, u, 0.0 * gradient])

    def ends(bottom, top):
        return np.array([bottom[0], top[0] - 1.0, bottom[2], top[2]])

    y = np.linspace(0.0, 1.0, 11)
    solution = solve_bvp(rates, ends, y, np.zeros((4, y.size)))
    assert solution.y[1, -1] == pytest.approx(4.0, rel=1e-6)


def test_torque_of_an_uneven_jet(prototype):
    # s = 0.65, eps_j = 0.85, a = 0.5 closing: 0.5^0.35 * (0.5 + 0.85 * 0.25) = 0.784584 * 0.7125 = 0.559016;
    # against 0.5^1.35 = 0.392292: 1 + 0.85 * 0.5 = 1.425 times as much; opening 0.575 times
    valve = replace(prototype, jet_exponent=0.65, jet_asymmetry=0.85)
    still = BranchFlow(0.0, 0.0, 1.0, 0.0, 0.0)
    load, skew = BranchFlow(5e-4, 1e-3, 0.6, 0.1, 0.3), 0.85 * 0.25
    even, closing, opening = (
        spool_torque(load, still, Openings(0.5, 0.0), JetSkews(extra, 0.0), 0.0, RHO, 0.0, valve).turbine
        - outlet_torque(5e-4, 0.0, RHO, valve)
        for extra in (0.0, skew, -skew)
    )
    assert even == pytest.approx(RHO * 0.0127 * 1e-6 / 36.5e-6 * 0.392292, rel=1e-5)
    assert closing / even == pytest.approx(1.425, rel=1e-12)
    assert opening / even == pytest.approx(0.575, rel=1e-12)


@pytest.mark.parametrize(("load_pressure", "hertz"), [(100.0, 76.1), (50.0, 82.3), (30.0, 83.3), (10.0, 84.1)])
def test_frequency_of_the_switching_valve_with_the_measured_jet(prototype, load_pressure, hertz):
    """The table for any asymmetry: over a whole period its torque vanishes at equal flows."""
    at = Condition(
        flow=Q40,
        load_pressure=load_pressure * 1e5 + 101325.0,
        relief_pressure=120e5 + 101325.0,
        tank_pressure=101325.0,
        density=RHO,
    )
    for asymmetry in (0.0, 0.85):
        valve = replace(prototype, jet_exponent=0.65, jet_asymmetry=asymmetry)
        omega = averaged_spool_speed(0.5, at, MU, valve)
        assert pwm_frequency(omega, valve) == pytest.approx(hertz, abs=0.06)


@pytest.mark.parametrize(("s", "asymmetry", "per_cent"), [(0.0, 0.0, 3.5), (0.65, 0.0, 3.3), (0.65, 0.85, 4.7)])
def test_ripple_of_the_spool_speed(prototype, s, asymmetry, per_cent):
    """Quasi-steady flows; the spool's energy J omega^2/2 carried on from angle to angle until it repeats."""
    valve = replace(prototype, jet_exponent=s, jet_asymmetry=asymmetry)
    at = Condition(flow=Q40, load_pressure=100e5 + 1e5, relief_pressure=120e5 + 1e5, tank_pressure=1e5, density=RHO)
    cycle = quasi_steady_cycle(0.5, at, valve)
    n, J, k_f = cycle.relief_flow.size, spool_inertia(valve), friction_coefficient(MU, valve)
    step = np.pi / 3.0 / n
    angle = step * (np.arange(n) + 0.5)
    before, after = (
        [
            spool_torque(
                cycle.load,
                cycle.tank,
                cycle.openings,
                jet_skews(sign * angle, 0.5 * valve.helix_length, asymmetry, port_shape(valve)),
                omega,
                RHO,
                k_f,
                valve,
            )
            for omega in (0.0, 1.0)
        ]
        for sign in (-1.0, 1.0)
    )
    drive = np.concatenate([before[0].turbine[::-1], after[0].turbine])
    turning = np.concatenate([(before[1].turbine - before[1].friction)[::-1], after[1].turbine - after[1].friction])
    speeds = np.full(2 * n, averaged_spool_speed(0.5, at, MU, valve))
    for _ in range(30):
        omega = speeds[-1]
        for place in range(2 * n):
            torque = drive[place] + (turning[place] - drive[place]) * omega
            omega = np.sqrt(omega * omega + 2.0 * torque * step / J)
            speeds[place] = omega
    assert 100.0 * np.ptp(speeds) / np.mean(speeds) == pytest.approx(per_cent, abs=0.06)
    # What the asymmetry adds before the middle of a wedge it takes behind it.
    assert 1.0 / np.mean(1.0 / speeds) == pytest.approx(averaged_spool_speed(0.5, at, MU, valve), rel=1e-3)
