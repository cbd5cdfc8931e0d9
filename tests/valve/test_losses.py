from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from vvdp.fluid.mixture import bulk_modulus, mean_bulk_modulus, specific_volume_ratio
from vvdp.valve.condition import Condition
from vvdp.valve.geometry import nozzle_width, pitch, transition_fraction
from vvdp.valve.losses import (
    best_relief_pressure,
    closed_form_load_flow,
    compressibility_loss,
    compression_regime,
    friction_loss,
    full_open_drop,
    full_open_loss,
    leakage_loss,
    port_ramp,
    range_warnings,
    transition_loss,
)
from vvdp.valve.torque import equilibrium_speed, friction_coefficient

RHO, MU = 876.0, 0.0387
BAR, T = 1e5, 101325.0
Q = 40.0 / 6e4
P_L = 100.0 * BAR + T


def condition(relief, override=0.0):
    return Condition(
        flow=Q,
        load_pressure=P_L,
        relief_pressure=relief * BAR + T,
        tank_pressure=T,
        density=RHO,
        relief_override=override * BAR,
        relief_rated_flow=Q,
    )


def at_relief(bar, valve):
    return transition_loss(condition(bar), valve)


@pytest.mark.parametrize(
    ("relief", "a_load", "a_tank", "watts", "lost", "relieved"),
    [
        (110.0, 0.736, 0.191, 1397.0, 0.102, 0.130),
        (120.0, 0.477, 0.183, 1333.0, 0.069, 0.096),
        (140.0, 0.325, 0.169, 1417.0, 0.048, 0.073),
        (200.0, 0.201, 0.141, 1781.0, 0.030, 0.051),
    ],
)
def test_transition_loss_over_relief_pressure(prototype, relief, a_load, a_tank, watts, lost, relieved):
    # to half a unit of the last digit
    found = at_relief(relief, prototype)
    assert found.load_relief_opening == pytest.approx(a_load, abs=6e-4)
    assert found.tank_relief_opening == pytest.approx(a_tank, abs=6e-4)
    assert found.loss == pytest.approx(watts, abs=0.6)
    assert found.load_flow_lost / Q == pytest.approx(lost, abs=6e-4)
    assert found.relief_flow / Q == pytest.approx(relieved, abs=6e-4)


def test_transition_loss_by_hand(prototype):
    # n 3.92687e5, r 2.74966e5, H_L 20e5: a* = sqrt(3.92687 / 17.25034) = 0.47712,
    #   Qv = (0.47712 * 20e5 - sqrt(20e5 * 3.92687e5)) / 2.74966e5 = (954233 - 886213) / 274966 = 0.24737
    #   E_load = 3.92687e5 * (2.09592 - 2 + 0.47712) + 0.24737 * 20e5 + 0.22975 * 120e5 - 0.47712 * 6.67653e5
    #          = 225021 + 494740 + 2756940 - 318548 = 3158153 Pa
    # H_T 120e5: a* = 0.18301, Qv = (2196076 - 2170769) / 274966 = 0.09204
    #   E_tank = 3.92687e5 * (5.46430 - 2 + 0.18301) + 0.09204 * 120e5 + 0.09097 * 120e5 - 0.18301 * 6.67653e5
    #          = 1432251 + 1104480 + 1091640 - 122187 = 3506184 Pa
    # 2 d_c / pitch = 0.30007; L = 0.30007 * 6.66667e-4 * 6664337 = 1333.2 W
    assert at_relief(120.0, prototype).loss == pytest.approx(1333.2, rel=1e-4)


@pytest.mark.parametrize(
    ("millimetres", "kappa", "watts"),
    [(18.0, 0.319, 1416.0), (20.32, 0.300, 1333.0), (23.3, 0.280, 1245.0), (26.0, 0.265, 1179.0)],
)
def test_transition_loss_over_helix_length(prototype, millimetres, kappa, watts):
    valve = replace(prototype, helix_length=1e-3 * millimetres)
    assert transition_fraction(valve) == pytest.approx(kappa, abs=6e-4)
    assert at_relief(120.0, valve).loss == pytest.approx(watts, abs=0.6)


@pytest.mark.parametrize("port", [100.0, 0.0])
@pytest.mark.parametrize("relief", [115.0, 120.0, 180.0])
def test_port_ramp_by_quadrature(prototype, port, relief):
    drops = full_open_drop(Q, RHO, prototype)
    n, r = drops.nozzle, drops.centre_section + drops.outlet_turbine
    H, P_R = (relief - port) * BAR, relief * BAR

    def port_flow(a):
        return min(1.0, np.sqrt(H / (n / a**2 + r)))

    def excess(a):
        q = port_flow(a)
        drop = n / a**2 + r if q == 1.0 else H
        return q * drop + (1.0 - q) * P_R - (n + r)

    found = port_ramp(port * BAR + T, condition(relief), drops)
    a = found.relief_opening
    assert port_flow(a) == pytest.approx(1.0, rel=1e-12)
    volume = quad(port_flow, 0.0, a, epsrel=1e-10)[0]
    total = quad(excess, 1e-12, a, epsrel=1e-10)[0] + quad(excess, a, 1.0, epsrel=1e-10)[0]
    assert found.relieved_port_flow == pytest.approx(volume, rel=1e-9)
    assert found.excess_drop == pytest.approx(total, rel=1e-8)


def test_nothing_passes_a_port_at_the_relief_pressure(prototype):
    """q = 0 at H = 0, so that all goes over the relief valve until the port would take it: int (1 - 0) da = a*."""
    found = port_ramp(120.0 * BAR + T, condition(120.0), full_open_drop(Q, RHO, prototype))
    assert (found.relief_opening, found.relief_flow, found.relieved_port_flow) == (1.0, pytest.approx(1.0), 0.0)


def test_best_relief_setting_lies_a_fifth_above_the_load(prototype):
    best = best_relief_pressure(Q, P_L, T, RHO, prototype)
    assert 118.0 < (best - T) / BAR < 120.0
    least = at_relief((best - T) / BAR, prototype).loss
    for bar in np.linspace(107.5, 200.0, 60):
        assert at_relief(bar, prototype).loss >= least - 1e-9


def test_transition_loss_grows_with_the_transition_fraction_alone(prototype):
    # one more section leaves kappa and the loss as they are
    more = replace(prototype, sections=4.0)
    assert at_relief(120.0, more).loss == pytest.approx(at_relief(120.0, prototype).loss, rel=1e-13)
    assert at_relief(120.0, replace(prototype, helix_length=4.0 * 20.32e-3)).loss == pytest.approx(
        at_relief(120.0, prototype).loss / 2.0, rel=1e-13
    )


def test_overlap_adds_a_blocked_dwell(prototype):
    valve = replace(prototype, lap_ratio=1.2)
    more = at_relief(120.0, valve).loss - at_relief(120.0, prototype).loss
    dwell = 2.0 * 0.2 * nozzle_width(prototype) / pitch(prototype)
    assert more == pytest.approx(dwell * Q * (120e5 - 6.67653e5), rel=1e-5)


def test_load_flow_in_closed_form(prototype):
    flow = closed_form_load_flow(0.5, condition(120.0), prototype)
    assert flow / Q == pytest.approx(0.43106, abs=6e-6)


def test_energy_budget(prototype):
    assert full_open_loss(Q, RHO, prototype) == pytest.approx(445.1, abs=0.06)
    assert leakage_loss(100e5, MU, prototype) == pytest.approx(26.3, abs=0.06)
    omega = equilibrium_speed(Q, RHO, MU, prototype)
    assert friction_loss(omega, friction_coefficient(MU, prototype)) == pytest.approx(30.4, abs=0.06)


@pytest.mark.parametrize(
    ("air", "modulus", "watts"),
    [(0.001, 1.377e9, 33.2), (0.01, 1.200e9, 38.1), (0.05, 7.51e8, 60.9), (0.1, 4.98e8, 91.8)],
)
def test_compressibility_loss(vg46, air, modulus, watts):
    oil = replace(vg46, air_fraction=air)
    P = 100.0 * BAR + T
    assert mean_bulk_modulus(P, oil) == pytest.approx(modulus, rel=1e-3)
    # Counting volumes, the energy is int (p - T) / beta dp. What is in the volume at the end was larger before:
    # W_V = int (p - T) / beta nu(p) / nu(P) dp, with a factor between 1 and 1 / nu(P).
    W = quad(lambda p: (p - T) / bulk_modulus(p, oil), T, P, epsrel=1e-10)[0]
    assert pytest.approx(watts, abs=0.06) == 72.0 * 12.7e-6 * W
    found = compressibility_loss(72.0, 12.7e-6, P, T, oil)
    assert 1.0 < found / (72.0 * 12.7e-6 * W) < 1.0 / specific_volume_ratio(P, oil)


def test_compressibility_loss_with_a_constant_modulus(vg46):
    # f V P^2 / (2 beta) = 72 * 12.7e-6 * 1e14 / 2.8e12 = 0.0326571 W; frequency counted once
    stiff = replace(vg46, air_fraction=0.0, liquid_bulk_modulus=1.4e12)
    assert compressibility_loss(72.0, 12.7e-6, P_L, T, stiff) == pytest.approx(0.0326571, rel=1e-4)


def test_compression_regime(prototype):
    # V P / (beta Q) = 12.7e-6 * 1e7 / (1e9 * 6.66667e-4) = 0.1905 ms; d_c / (pitch f) = 0.150035 / 72 = 2.0838 ms
    assert compression_regime(72.0, 12.7e-6, 1e7, 1e9, Q, prototype) == pytest.approx(0.1905 / 2.0838, rel=1e-4)


def warnings(valve, duty=0.5, relief=120.0):
    return range_warnings(duty, condition(relief), valve)


def test_no_warning_where_the_closed_form_holds(prototype):
    assert warnings(prototype) == ()


def test_warnings_carry_numbers(prototype):
    (low,) = warnings(prototype, duty=0.2)
    assert "0.2 lies outside 0.3001 to 0.6999: the load port" in low
    (high,) = warnings(prototype, duty=0.8)
    assert "the tank port" in high
    (relief,) = warnings(prototype, relief=105.0)
    assert "105 bar does not exceed the 106.7 bar" in relief
    assert len(warnings(replace(prototype, lap_ratio=0.8), duty=0.1, relief=101.0)) == 2


def test_choking_nozzles_put_the_closed_form_in_doubt(prototype):
    # 0.81 * (120 + 1.01325) bar = 98.02 bar, less than the 120 bar over the closing tank port; 1 * 121 bar is not
    (found,) = warnings(replace(prototype, pressure_recovery=0.9), 0.5)
    assert "choke from a drop of 98.02 bar on" in found
    assert warnings(replace(prototype, pressure_recovery=1.0), 0.5) == ()
