"""Misprints of chapters 1 and 2 of wang2017: each number of a row worked out anew."""

from dataclasses import replace

import numpy as np
import pint
import pytest
from scipy.optimize import brentq

from vvdp.fluid.mixture import mean_bulk_modulus
from vvdp.fluid.oil import density, dynamic_viscosity
from vvdp.rivals.actuation_claim import (
    LIGHT_MASS,
    annular_stroke,
    equal_power_frequency,
    same_ports_stroke,
    spool_friction,
)
from vvdp.rivals.driving_claim import area_scale, driving_point, scaled_open_loss
from vvdp.steady.steady_states import steady_states
from vvdp.valve.geometry import transition_fraction
from vvdp.valve.losses import full_open_drop
from vvdp.valve.torque import equilibrium_speed, inlet_torque, outlet_torque, pwm_frequency

RHO, MU, Q = 876.0, 0.0387, 4e-2 / 60.0
SHARES = np.array([31.0, 38.6, 30.4]) / 100.0
"""Of the nozzles of the final rail, table 2.1."""
RAIL, SMALLEST, FINAL = 12.7, 4.2, 3.7
"""Volumes of the rail [cc]: prototype, design (d), final design; section 2.7."""


@pytest.fixture(scope="module")
def valve(source_stand):
    return source_stand.bench.valve


@pytest.fixture(scope="module")
def oil(source_stand):
    return source_stand.bench.oil


def test_forces_per_volume_have_one_dimension():
    """rho (v . grad) v, mu Laplace v and grad P are N/m^3; the Laplacian of a pressure is not."""
    unit = pint.UnitRegistry()
    inertia = unit("kg/m^3") * unit("m/s") * unit("m/s") / unit("m")
    shear = unit("Pa*s") * unit("m/s") / unit("m^2")
    assert inertia.dimensionality == shear.dimensionality == (unit("Pa") / unit("m")).dimensionality
    assert inertia.dimensionality != (unit("Pa") / unit("m^2")).dimensionality


def test_centre_coefficient_is_in_si(valve, told):
    """1.45e-6 x 0.0254^3.22 = 1.0421e-11 under (6.6667e-4)^1.91 gives 0.81 bar; as printed, 40^1.91 over 25.4^3.22."""
    si = Q**1.91 / (1.45e-6 * 0.0254**3.22)
    assert full_open_drop(Q, RHO, valve).centre_section == pytest.approx(si, rel=1e-12)
    assert f"{si / 1e5:.3f} bar" in told
    other = 40.0**1.91 / (1.45e-6 * 25.4**3.22)
    assert f"{other:.2g}".replace("e+04", "e4") + " bar" in told


@pytest.mark.parametrize("blades", [1, 4, 9])
def test_outlet_torque_is_the_sum_over_blades(valve, blades):
    """Each passes its share of the flow through its share of the area; the number of blades falls out."""
    R, area, omega = valve.outlet_radius, valve.outlet_effective_area, 150.8
    share = Q / blades
    one = RHO * share * R * (share / (area / blades) - R * omega)
    assert blades * one == pytest.approx(outlet_torque(Q, omega, RHO, valve), rel=1e-12)


@pytest.mark.parametrize("handed_on", [0.0, 4e-3, 12.7e-3])
def test_swirl_between_the_turbines_cancels(valve, handed_on):
    """The flow goes from one turbine to the other turning with the spool at any radius r_e. Euler for each:
    rho Q (R_in v_in - r_e^2 omega), and rho Q (r_e^2 omega - R_out (R_out omega - v_rel))."""
    R, omega = valve.spool_radius, 150.8
    v_in, v_rel, swirl = Q / valve.nozzle_area, Q / valve.outlet_effective_area, handed_on**2 * omega
    centre = RHO * Q * (R * v_in - swirl)
    turbine = RHO * Q * (swirl - R * (R * omega - v_rel))
    both = inlet_torque(Q, 1.0, RHO, valve) + outlet_torque(Q, omega, RHO, valve)
    assert centre + turbine == pytest.approx(both, rel=1e-12)
    assert (centre == pytest.approx(inlet_torque(Q, 1.0, RHO, valve), rel=1e-12)) == (handed_on == 0.0)


def test_frequency_is_counted_once(told):
    """72 Hz, 12.7 cc, 100 bar, 0.7 GPa: 72 * 12.7e-6 * 1e14/1.4e9 = 65.3 W, three times that with N twice."""
    once = 72.0 * 12.7e-6 * 1e7**2 / (2.0 * 0.7e9)
    N, omega = 3, 2.0 * np.pi * 24.0
    printed = 12.7e-6 * 1e7**2 / (2.0 * 0.7e9) * N * (N * omega) / (2.0 * np.pi)
    assert printed == pytest.approx(N * once, rel=1e-12)
    assert f"{printed:.0f} W instead of {once:.0f} W" in told


def test_modulus_of_several_thousand_bar_takes_air(oil, told):
    """The mean modulus to 100 bar of the oil with 1 and with 5 % of air."""
    for air, place in ((0.01, "1 %"), (0.05, "5 %")):
        modulus = mean_bulk_modulus(1e7 + 101325.0, replace(oil, air_fraction=air))
        assert f"{modulus / 1e9:.2f} GPa with {place}" in told


def test_volumes_of_the_rail(told):
    """4.2 cc has 67 %, 3.7 cc 70.9 %."""
    assert f"{100.0 * (1.0 - FINAL / RAIL):.1f} %" in told
    assert f"{100.0 * (1.0 - SMALLEST / RAIL):.0f} %" in told


def test_a_thinner_rail_is_not_that_small(told):
    """A torus has the volume 2 pi^2 R r^2: r less by 30 %, R by 16 % as well, and what r would have to be."""
    thinner = 0.7**2 * RAIL
    assert f"{thinner:.1f} cc" in told
    assert f"{0.84 * thinner:.1f} cc" in told
    assert f"{100.0 * (1.0 - np.sqrt(SMALLEST / RAIL)):.0f} %" in told


def test_mismatch_in_points_and_per_cent(told):
    spread = np.ptp(SHARES)
    assert f"{100.0 * spread:.1f} points" in told
    assert f"{100.0 * 3.0 * spread:.1f} %" in told
    assert f"{100.0 * (3.0 * SHARES.max() - 1.0):.1f} %" in told


def test_radial_force_of_the_final_rail(valve, told):
    """Three jets under 120 degrees: with share^2 of the momentum, and with the mean speed of the jets."""
    angles = 2.0 * np.pi * np.arange(3) / 3.0
    directions = np.exp(1j * angles)
    own = RHO * (SHARES * Q) ** 2 / (valve.nozzle_area / 3.0)
    mean = RHO * SHARES * Q * Q / valve.nozzle_area
    assert f"{abs(own @ directions):.2f} N" in told
    assert f"{abs(mean @ directions):.2f} N" in told


def test_drop_of_the_final_rail(told):
    assert f"{100.0 * (4.73 / 4.17 - 1.0):.1f} %" in told


def test_throttling_has_three_parts(valve, told):
    """Without (2.5) 4.74 bar, with it 6.68; printed is 6.61."""
    drops = full_open_drop(Q, RHO, valve)
    parts = [drops.nozzle, drops.centre_section, drops.outlet_turbine]
    assert " + ".join(f"{part / 1e5:.2f}" for part in parts) + f" = {sum(parts) / 1e5:.2f}$ bar" in told
    assert f"{100.0 * (sum(parts) / 6.61e5 - 1.0):.1f} %" in told


def test_optimum_saves_what_is_printed(told):
    """1 - 2.48/6.61; the optimum itself is `test_published_drop`."""
    assert f"{100.0 * (1.0 - 2.48 / 6.61):.1f} %" in told


def test_pump_delivers_more_than_is_said(told):
    flow = 22.8e-3 * 1800.0
    assert f"{flow:.2f} lpm" in told
    assert f"{100.0 * 40.0 / flow:.1f} %" in told


def test_torque_about_an_axis_is_one_component():
    """The power of forces on a turning body is its speed times e_z . sum(r x F); no other component works."""
    rng = np.random.default_rng(2)
    r, F, omega = rng.normal(size=(50, 3)), rng.normal(size=(50, 3)), 150.8
    power = np.sum(F * np.cross([0.0, 0.0, omega], r))
    torque = np.sum(np.cross(r, F), axis=0)
    assert power == pytest.approx(omega * torque[2], rel=1e-12)
    assert np.hypot(*torque[:2]) > 0.1 * abs(torque[2])
    split = np.cross(r, 0.3 * F) + np.cross(r, 0.7 * F)
    assert np.sum(split, axis=0) == pytest.approx(torque, rel=1e-12)


def test_spool_speeds_of_the_source(valve, oil, told):
    """The open valve at 40 lpm, and the oil's temperature at which it would turn as the other chapters say."""

    def speed(celsius, flow=Q):
        T = celsius + 273.15
        return equilibrium_speed(flow, density(T, oil), dynamic_viscosity(T, oil), valve) / (2.0 * np.pi)

    assert f"{speed(40.0):.1f} Hz at 40 degC" in told
    assert f"{speed(40.0, 26.7e-3 / 60.0):.1f} Hz at 26.7 lpm" in told
    for hertz in (13.0, 9.766, 25.0):
        celsius = brentq(lambda c, wanted=hertz: speed(c) - wanted, 0.0, 90.0)
        assert f"{celsius:.0f} degC" in told


def test_power_of_rotary_and_linear_switching(source_stand, valve, told):
    kappa, friction = transition_fraction(valve), spool_friction(source_stand)
    light = equal_power_frequency(3.0, friction, LIGHT_MASS, annular_stroke(valve), kappa)
    same = equal_power_frequency(3.0, friction, 0.5, same_ports_stroke(valve), kappa)
    assert f"up to {light:.0f} Hz" in told
    assert f"from {same:.1f} Hz" in told
    assert f"{1e3 * annular_stroke(valve):.3f} mm" in told


def test_loss_of_a_driven_spool(source_stand, valve, told):
    """Simulated against a source of 72 bar, the motor's power counted, at two frequencies. With a quarter of the flow
    the ripple d (1 - d) Q/f is kept by a quarter of the frequency, and torque goes with one over the areas."""
    point = driving_point(source_stand, Q)
    losses = []
    for state in steady_states([(source_stand.with_motor(f), point) for f in (45.0, 90.0)]):
        found = state.summary
        motor = max(found["spool_motor_power_W"], 0.0)
        losses.append(found["input_power_W"] + motor - found["load_power_W"])
    assert f"{losses[0]:.0f} W at 45 Hz and {losses[1]:.0f} W at 90 Hz" in told
    open_frequency = pwm_frequency(equilibrium_speed(Q, RHO, MU, valve), valve)
    scale = area_scale(0.25 * Q, 0.25 * open_frequency, RHO, MU, valve)
    assert f"{0.25 * open_frequency:.0f} Hz" in told
    assert f"{100.0 * scale:.0f} % of its areas" in told
    assert f"{scaled_open_loss(scale, Q, RHO, valve) / 1e3:.1f} kW" in told
