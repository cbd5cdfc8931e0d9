"""The yielding of oil with air, and the energy it stores: numbers by hand, and the laws that tie them together."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from vvdp.fluid.mixture import (
    bulk_modulus,
    compression_energy_per_mass,
    compression_energy_per_volume,
    density_rise,
    enthalpy,
    fluid_density,
    fluid_state,
    mean_bulk_modulus,
    specific_volume_ratio,
    strain_energy,
)

AIR = st.sampled_from([0.0]) | st.floats(0.001, 0.3)
EXPONENT = st.sampled_from([1.0]) | st.floats(1.0, 1.7)
PRESSURE = st.floats(3.0, 8.0).map(lambda power: 10.0**power)


def over_pressure(value, low, high):
    """Integral of value(P) dP, taken over ln P."""
    found = quad(lambda u: value(np.exp(u)) * np.exp(u), np.log(low), np.log(high), epsabs=0.0, epsrel=1e-12, limit=200)
    return found[0]


def test_one_state_by_hand(make_oil):
    # P = 10 P0, air 10 %: 10^(-1/1.4) = 0.19306977, so a = 0.019306977
    # l = 0.9 e^(-911925/1.4e9) = 0.9 * 0.999348837 = 0.899413953; nu = 0.918720931
    # a/(1.4 * 1013250) = 1.361035e-8, l/1.4e9 = 6.424385e-10; beta = nu/1.425279e-8 = 6.445902e7
    # h = 0.1 * 101325 * (10^(0.4/1.4) - 1)/(0.4/1.4) + 1.4e9 * (0.9 - l) = 33006.0 + 820465.3 = 853471.3
    # w = 853471.3 - 911925 * 0.918720931 = 15666.7
    oil = make_oil(air_fraction=0.1)
    state = fluid_state(1013250.0, oil)
    assert state.volume_ratio == pytest.approx(0.918720931, rel=1e-9)
    assert state.bulk_modulus == pytest.approx(6.445902e7, rel=1e-6)
    assert state.enthalpy == pytest.approx(853471.3, abs=0.1)
    assert strain_energy(1013250.0, oil) == pytest.approx(15666.7, abs=0.1)


def test_parts_are_the_parts_of_the_state(make_oil):
    oil = make_oil()
    parts = 5e6, specific_volume_ratio(5e6, oil), bulk_modulus(5e6, oil), enthalpy(5e6, oil)
    assert parts == fluid_state(5e6, oil)


@settings(deadline=None)
@given(air=AIR, exponent=EXPONENT)
def test_reference_state(make_oil, air, exponent):
    oil = make_oil(air_fraction=air, polytropic_exponent=exponent)
    assert specific_volume_ratio(101325.0, oil) == pytest.approx(1.0, abs=2.3e-16)
    assert enthalpy(101325.0, oil) == 0.0
    assert strain_energy(101325.0, oil) == 0.0
    assert mean_bulk_modulus(101325.0, oil) == pytest.approx(bulk_modulus(101325.0, oil), rel=1e-14)


@settings(max_examples=40, deadline=None)
@given(air=AIR, exponent=EXPONENT, one=PRESSURE, other=PRESSURE)
def test_modulus_and_enthalpy_are_those_of_the_volume(make_oil, air, exponent, one, other):
    """d(ln nu) = -dP/beta and dh = nu dP, as integrals by an independent method."""
    oil = make_oil(air_fraction=air, polytropic_exponent=exponent)
    low, high = sorted((max(one, 1.1e3), max(other, 1.1e3)))
    yielded = over_pressure(lambda P: 1.0 / bulk_modulus(P, oil), low, high)
    ratio = specific_volume_ratio(high, oil) / specific_volume_ratio(low, oil)
    assert ratio == pytest.approx(np.exp(-yielded), rel=1e-11)
    gained = over_pressure(lambda P: specific_volume_ratio(P, oil), low, high)
    # abs: two enthalpies of up to 1e8 Pa are subtracted
    assert enthalpy(high, oil) - enthalpy(low, oil) == pytest.approx(
        gained, rel=1e-11, abs=64 * np.finfo(float).eps * high
    )


@pytest.mark.parametrize("exponent", [1.0, 1.4])
@pytest.mark.parametrize("pressure", [-2000.0, 0.0, 500.0, 1013.25, 2000.0])
def test_relations_hold_into_vacuum(make_oil, exponent, pressure):
    """Below P0/100 the air follows its tangent: the same relations, by differences, at any pressure."""
    oil = make_oil(polytropic_exponent=exponent)
    state, step = fluid_state(pressure, oil), 0.01
    before, after = fluid_state(pressure - step, oil), fluid_state(pressure + step, oil)
    slope = (after.volume_ratio - before.volume_ratio) / (2.0 * step)
    # at the joint slopes differ by step/P of a few; rounding: 2e-16 nu/step against nu' of 3e-4
    assert slope == pytest.approx(-state.volume_ratio / state.bulk_modulus, rel=3e-5)
    assert (after.enthalpy - before.enthalpy) / (2.0 * step) == pytest.approx(state.volume_ratio, rel=1e-7)
    assert state.bulk_modulus > 0.0


@settings(deadline=None)
@given(air=st.floats(0.001, 0.3), exponent=EXPONENT, pressure=PRESSURE, factor=st.floats(1.01, 10.0))
def test_stiffer_under_more_pressure_and_less_air(make_oil, air, exponent, pressure, factor):
    oil = make_oil(air_fraction=air, polytropic_exponent=exponent)
    pressure = max(pressure, 1013.25)
    assert bulk_modulus(factor * pressure, oil) > bulk_modulus(pressure, oil)
    assert bulk_modulus(pressure, make_oil(air_fraction=0.5 * air, polytropic_exponent=exponent)) > bulk_modulus(
        pressure, oil
    )
    assert bulk_modulus(pressure, oil) < 1.4e9


@settings(deadline=None)
@given(pressure=PRESSURE)
def test_stiff_oil_without_air_counts_volumes(make_oil, pressure):
    oil = make_oil(liquid_bulk_modulus=1e12, air_fraction=0.0)
    gauge = pressure - 101325.0
    state = fluid_state(pressure, oil)
    # nu = 1 - p/b + ..., h = p (1 - p/(2 b) + ...), the next terms below (p/b)^2 <= 1e-8
    assert state.volume_ratio == pytest.approx(1.0 - gauge / 1e12, abs=1e-8)
    assert state.enthalpy == pytest.approx(gauge * (1.0 - 0.5 * gauge / 1e12), rel=1e-8)
    assert state.bulk_modulus == pytest.approx(1e12, rel=1e-14)


@pytest.mark.parametrize("above", [1e-3, 1e-6, 1e-9, 1e-12, 1e-15])
def test_enthalpy_is_smooth_at_the_isotherm(make_oil, above):
    """h(n) - h(1) = phi P0 k L^2/2 + ..., k = 1 - 1/n, L = ln(P/P0) = 4.6: no step and no lost digits at n = 1."""
    isotherm = make_oil(air_fraction=0.1, polytropic_exponent=1.0)
    n = 1.0 + above
    near = make_oil(air_fraction=0.1, polytropic_exponent=n)
    L, k = np.log(1e7 / 101325.0), (n - 1.0) / n
    rise = 0.1 * 101325.0 * k * L * L / 2.0
    # next term: k L/3 of the rise; rounding: a few ulp of h = 9e6
    found = enthalpy(1e7, near) - enthalpy(1e7, isotherm)
    assert found == pytest.approx(rise, rel=2.0 * k * L / 3.0, abs=1e-8)
    stored = compression_energy_per_volume(1e7, 2e5, near)
    assert stored == pytest.approx(compression_energy_per_volume(1e7, 2e5, isotherm), rel=2.0 * k * L + 1e-12)


def test_isotherm_by_hand(make_oil):
    # P = 10 P0, n = 1, air 10 %: h = 0.1 * 101325 * ln 10 + 820465.3 = 23330.9 + 820465.3 = 843796.2
    oil = make_oil(air_fraction=0.1, polytropic_exponent=1.0)
    assert enthalpy(1013250.0, oil) == pytest.approx(843796.2, abs=0.1)
    # nu = 0.01 + 0.899413953; 1/beta = (0.01/1013250 + 0.899413953/1.4e9)/nu, beta = 0.909413953/1.051165e-8
    assert bulk_modulus(1013250.0, oil) == pytest.approx(8.65149e7, rel=1e-5)


@pytest.mark.parametrize(("air", "published"), [(0.001, 1.377e9), (0.01, 1.200e9), (0.05, 7.51e8), (0.10, 4.98e8)])
def test_mean_modulus_at_100_bar(make_oil, air, published):
    assert mean_bulk_modulus(101325.0 + 1e7, make_oil(air_fraction=air)) == pytest.approx(published, rel=6e-4)


@pytest.mark.parametrize("air", [0.0, 0.001, 0.3])
@pytest.mark.parametrize("pressure", [2e3, 5e4, 2e5, 1e6, 1e7, 3.5e7, 1e8])
def test_mean_modulus_is_its_integral(make_oil, air, pressure):
    oil = make_oil(air_fraction=air)
    low, high = sorted((101325.0, pressure))
    W = over_pressure(lambda P: (P - 101325.0) / bulk_modulus(P, oil), low, high)
    expected = (pressure - 101325.0) ** 2 / (2.0 * abs(W))
    assert mean_bulk_modulus(pressure, oil) == pytest.approx(expected, rel=1e-11)


@settings(deadline=None)
@given(air=AIR, exponent=EXPONENT, pressure=PRESSURE, origin=PRESSURE)
def test_stored_energy_is_never_negative(make_oil, air, exponent, pressure, origin):
    oil = make_oil(air_fraction=air, polytropic_exponent=exponent)
    d = pressure - origin
    rounding = 1e-15 * abs(d)  # b (e^(d/b) - 1) - d: one ulp of d
    assert compression_energy_per_volume(pressure, origin, oil) >= -rounding
    assert strain_energy(pressure, oil) >= -1e-7


@settings(max_examples=40, deadline=None)
@given(air=AIR, exponent=EXPONENT, pressure=st.floats(2e4, 4e7), origin=st.floats(2e4, 4e7))
def test_stored_energy_is_its_integral(make_oil, air, exponent, pressure, origin):
    oil = make_oil(air_fraction=air, polytropic_exponent=exponent)
    end = fluid_state(pressure, oil)
    low, high = sorted((pressure, origin))
    excess = over_pressure(
        lambda P: (P - origin) * (lambda s: s.volume_ratio / s.bulk_modulus)(fluid_state(P, oil)), low, high
    )
    expected = abs(excess) / end.volume_ratio
    # rounding: one ulp of d in l (b (e^(d/b) - 1) - d)
    assert compression_energy_per_volume(pressure, origin, oil) == pytest.approx(
        expected, rel=1e-11, abs=1e-15 * abs(pressure - origin)
    )


def test_stored_energy_against_the_reference_is_the_strain_energy(make_oil):
    oil = make_oil(air_fraction=0.05)
    for P in (2e5, 1e6, 2e7):
        stored = compression_energy_per_volume(P, 101325.0, oil) * specific_volume_ratio(P, oil)
        assert stored == pytest.approx(strain_energy(P, oil), rel=1e-9)  # h of 2e7 against w of 1e5 at the least


@pytest.mark.parametrize("air", [0.0, 0.1])
def test_stored_energy_of_a_small_step_is_quadratic(make_oil, air):
    """W_V = d^2/(2 beta) to first order in d/P, without loss where differences of enthalpy would cancel."""
    oil = make_oil(air_fraction=air)
    for d in (100.0, -100.0, 10.0):
        quadratic = d * d / (2.0 * bulk_modulus(1e7, oil))
        assert compression_energy_per_volume(1e7 + d, 1e7, oil) == pytest.approx(
            quadratic, rel=3.0 * abs(d) / 1e7 + 1e-7
        )


def test_rates_of_the_stored_energy(make_oil):
    """dW_V/dP = (P - Pd + W_V)/beta(P) and dW_V/dPd = -(rho(P)/rho(Pd) - 1)."""
    oil, P, Pd, step = make_oil(air_fraction=0.1), 1.4e6, 1.0e6, 100.0

    def stored(end, origin):
        return compression_energy_per_volume(end, origin, oil)

    # central differences err by (step/P)^2 = 1e-8 and by 1e-15 * 4e5/step/4e-3
    by_end = (stored(P + step, Pd) - stored(P - step, Pd)) / (2.0 * step)
    assert by_end == pytest.approx((P - Pd + stored(P, Pd)) / bulk_modulus(P, oil), rel=1e-7)
    by_origin = (stored(P, Pd + step) - stored(P, Pd - step)) / (2.0 * step)
    denser = specific_volume_ratio(Pd, oil) / specific_volume_ratio(P, oil)
    assert by_origin == pytest.approx(-(denser - 1.0), rel=1e-7)


def test_energy_per_mass_times_density(make_oil):
    oil = make_oil()
    assert fluid_density(101325.0, 313.15, oil) == 876.0
    assert fluid_density(2e7, 330.0, oil) > fluid_density(1e7, 330.0, oil)
    per_mass = compression_energy_per_mass(2e7, 1e6, 330.0, oil)
    per_volume = compression_energy_per_volume(2e7, 1e6, oil)
    assert per_mass * fluid_density(2e7, 330.0, oil) == pytest.approx(per_volume, rel=1e-15)
    # a mass keeps its energy: m W_m = V0 w when compressed from the reference pressure
    whole = compression_energy_per_mass(2e7, 101325.0, 313.15, oil) * 876.0
    assert whole == pytest.approx(strain_energy(2e7, oil), rel=1e-9)


@settings(deadline=None)
@given(air=AIR, pressure=PRESSURE, scale=st.sampled_from([1e-5 * 101325.0, 0.5, 3.0]))
def test_another_unit_of_pressure(make_oil, air, pressure, scale):
    """With every pressure in another unit the ratio stays, and modulus and energies come out in that unit."""
    pascal = make_oil(air_fraction=air)
    other = make_oil(air_fraction=air, liquid_bulk_modulus=1.4e9 * scale, reference_pressure=101325.0 * scale)
    a, b = fluid_state(pressure, pascal), fluid_state(pressure * scale, other)
    assert b.volume_ratio == pytest.approx(a.volume_ratio, rel=1e-13)
    assert b.bulk_modulus == pytest.approx(a.bulk_modulus * scale, rel=1e-13)
    assert b.enthalpy == pytest.approx(a.enthalpy * scale, rel=1e-12, abs=1e-6)
    assert mean_bulk_modulus(pressure * scale, other) == pytest.approx(
        mean_bulk_modulus(pressure, pascal) * scale, rel=1e-12
    )


def test_pressures_may_be_an_array(make_oil):
    oil, P = make_oil(), np.array([-1e3, 101325.0, 1e7])
    state = fluid_state(P, oil)
    for i, pressure in enumerate(P):
        assert tuple(part[i] for part in state) == pytest.approx(tuple(fluid_state(pressure, oil)), rel=1e-15)
    assert mean_bulk_modulus(P, oil)[2] == pytest.approx(mean_bulk_modulus(1e7, oil), rel=1e-14)
    assert compression_energy_per_volume(P, 2e5, oil).shape == (3,)


@pytest.mark.parametrize(
    "changed",
    [
        {"air_fraction": 0.0909},
        {"polytropic_exponent": 1.0},
        {"air_fraction": 0.0},
        {"bulk_modulus_slope": 11.0},
        {"vapour_pressure": 3e4},
    ],
)
@pytest.mark.parametrize(("one", "other"), [(14e5, 10e5), (10e5, 14e5), (3e7, 1e5), (2e4, 1e6)])
def test_density_rise_is_that_of_the_volume_ratios(make_oil, changed, one, other):
    oil = make_oil(**changed)
    expected = specific_volume_ratio(other, oil) / specific_volume_ratio(one, oil) - 1.0
    assert density_rise(one, other, oil) == pytest.approx(expected, rel=1e-10, abs=1e-15)


def test_small_density_rises_lose_no_digits(make_oil):
    """1/beta over small differences: the quotient of the ratios would have none left."""
    oil = make_oil(air_fraction=0.0909)
    for d in (1.0, 1e-3, -1e-6):
        found = density_rise(14e5 + d, 14e5, oil) / ((14e5 + d) - 14e5)
        assert found == pytest.approx(1.0 / bulk_modulus(14e5, oil), rel=2e-6 * abs(d) + 1e-14)
    assert density_rise(14e5, 14e5, oil) == 0.0
