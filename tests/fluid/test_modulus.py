"""Laws of the bulk modulus and the energy stored under any of them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from vvdp.base.errors import ParameterError
from vvdp.fluid import mixture
from vvdp.fluid.modulus import (
    DissolvingAir,
    IsothermalAir,
    PolytropicAir,
    YuAir,
    cho_bulk_modulus,
    compression_energy_per_mass,
    compression_energy_per_volume,
    dissolving_bulk_modulus,
    isothermal_bulk_modulus,
    mean_modulus,
    nykanen_bulk_modulus,
    specific_volume_exponent,
    yu_bulk_modulus,
)

BAR = 1e5
COMMON = {"liquid_bulk_modulus": 1.7e9, "reference_pressure": 1e5}


def yu(air=0.1, rate=0.0):
    return YuAir(**COMMON, air_fraction=air, polytropic_exponent=1.4, dissolving_rate=rate)


def polytropic(air=0.1, exponent=1.4):
    return PolytropicAir(**COMMON, air_fraction=air, polytropic_exponent=exponent)


def dissolving(air=0.1):
    return DissolvingAir(**COMMON, air_fraction=air, polytropic_exponent=1.4, critical_pressure=30e5)


def isothermal(air=0.1):
    return IsothermalAir(**COMMON, air_fraction=air)


LAWS = [
    (yu_bulk_modulus, yu),
    (cho_bulk_modulus, polytropic),
    (nykanen_bulk_modulus, polytropic),
    (isothermal_bulk_modulus, isothermal),
    (dissolving_bulk_modulus, dissolving),
]


def constant(pressure, modulus):
    return modulus


@pytest.mark.parametrize(
    ("law", "params", "hand"),
    [
        # 10 bar, R = 0.1, n = 1.4: 10^(-1/1.4) = 0.193070, v = v_g = 0.0193070, v_l = e^(-9e5/1.7e9) = 0.99947073
        # 0.980693/1.7e9 + 0.0193070/1.4e6 = 5.76878e-10 + 1.379071e-8 = 1.436758e-8
        (yu_bulk_modulus, yu(), 6.96011e7),
        # 1.01877773/(0.99947073/1.7e9 + 1.379071e-8) = 1.01877773/1.437863e-8
        (cho_bulk_modulus, polytropic(), 7.08536e7),
        # 1.7e9 * 1.0193070/(1 + 1.7e9 * 1.379071e-8) = 1.7328219e9/24.44421
        (nykanen_bulk_modulus, polytropic(), 7.08889e7),
        # 1.7e9/(1 + 1.7e9 * 0.1 * 1e5/1e12) = 1.7e9/18
        (isothermal_bulk_modulus, isothermal(), 9.444444e7),
        # x = 9/29, th = 0.7708393, th' = -6 x (1 - x)/29e5 = -4.428197e-7 1/Pa
        # (0.99947073 + 0.0193070 * 0.7708393)/(5.87924e-10 + 0.0193070 * (0.7708393/1.4e6 + 4.428197e-7))
        # = 1.01435333/1.976787e-8
        (dissolving_bulk_modulus, dissolving(), 5.13132e7),
    ],
)
def test_laws_by_hand_at_10_bar(law, params, hand):
    assert law(10 * BAR, params) == pytest.approx(hand, rel=2e-6)


def test_yu_as_usually_printed():
    """E s/(s + (R/P0) (1 - c1 (P - P0)) (E/n - P)), s = (P/P0)^(1 + 1/n)."""
    E, n, R, P0, c1 = 1.7e9, 1.4, 0.1, 1e5, 2e-8
    for P in (0.5 * BAR, 5 * BAR, 200 * BAR):
        s = (P / P0) ** (1 + 1 / n)
        printed = E * s / (s + R / P0 * (1 - c1 * (P - P0)) * (E / n - P))
        assert yu_bulk_modulus(P, yu(rate=c1)) == pytest.approx(printed, rel=1e-13)
    assert yu_bulk_modulus(600 * BAR, yu(rate=c1)) == pytest.approx(E, rel=1e-15)  # all dissolved from 501 bar on


@settings(deadline=None)
@given(pressure=st.floats(2e3, 5e7), air=st.floats(0.001, 0.3), exponent=st.floats(1.0, 1.7))
def test_cho_is_the_mixture_counted_per_volume_of_oil(make_oil, pressure, air, exponent):
    oil = make_oil(air_fraction=air, polytropic_exponent=exponent, liquid_bulk_modulus=1.7e9, reference_pressure=1e5)
    per_oil = polytropic(air / (1.0 - air), exponent)
    assert cho_bulk_modulus(pressure, per_oil) == pytest.approx(mixture.bulk_modulus(pressure, oil), rel=1e-13)


@pytest.mark.parametrize(("law", "params"), LAWS)
@settings(deadline=None)
@given(pressure=st.floats(1.1e3, 5e7), factor=st.floats(1.01, 3.0), air=st.floats(0.001, 0.3))
def test_modulus_rises_with_pressure_to_that_of_the_oil(law, params, pressure, factor, air):
    low, high = law(pressure, params(air)), law(factor * pressure, params(air))
    assert low <= high * (1.0 + 1e-14)  # equal once all air is dissolved
    assert 0.0 < low <= 1.7e9 * (1.0 + 1e-14)


@pytest.mark.parametrize(("law", "params"), LAWS)
def test_without_air_the_modulus_is_that_of_the_oil(law, params):
    for P in (0.0, 1e5, 1e7):
        assert law(P, params(0.0)) == pytest.approx(1.7e9, rel=1e-14)


@pytest.mark.parametrize(("law", "params"), LAWS)
def test_pressures_may_be_an_array(law, params):
    P = np.array([1e2, 1e5, 2e6, 4e7])
    assert law(P, params()).tolist() == pytest.approx([law(p, params()) for p in P], rel=1e-14)


def test_dissolved_air_is_gone_at_the_critical_pressure():
    assert dissolving_bulk_modulus(30 * BAR, dissolving()) == pytest.approx(1.7e9, rel=1e-14)
    assert dissolving_bulk_modulus(300 * BAR, dissolving()) == pytest.approx(1.7e9, rel=1e-14)
    assert dissolving_bulk_modulus(29 * BAR, dissolving()) < 1.7e9


TABLE = {  # bar: beta and mean modulus [Pa] at 1, 10 and 30 % air
    10: ((5.09e8, 2.30e8), (6.96e7, 2.58e7), (2.39e7, 8.37e6)),
    14: ((7.34e8, 3.43e8), (1.201e8, 4.12e7), (4.20e7, 1.35e7)),
    50: ((1.48e9, 1.06e9), (6.86e8, 2.41e8), (3.13e8, 8.64e7)),
    100: ((1.63e9, 1.41e9), (1.17e9, 5.55e8), (7.24e8, 2.31e8)),
    350: ((1.69e9, 1.64e9), (1.62e9, 1.32e9), (1.47e9, 9.13e8)),
}


@pytest.mark.parametrize("bar", TABLE)
@pytest.mark.parametrize("column", [0, 1, 2])
def test_modulus_and_mean_modulus_over_pressure(bar, column):
    params, (beta, mean) = yu((0.01, 0.1, 0.3)[column]), TABLE[bar][column]
    # three digits: half a unit of the last is at most 0.5 %
    assert yu_bulk_modulus(bar * BAR, params) == pytest.approx(beta, rel=5e-3)
    assert mean_modulus(bar * BAR, BAR, yu_bulk_modulus, params) == pytest.approx(mean, rel=5e-3)


def test_energy_between_two_pressures():
    assert compression_energy_per_volume(14 * BAR, 10 * BAR, yu_bulk_modulus, yu()) == pytest.approx(793.25, abs=5e-3)
    assert compression_energy_per_volume(10 * BAR, 14 * BAR, yu_bulk_modulus, yu()) == pytest.approx(948.80, abs=5e-3)
    exponent = specific_volume_exponent(14 * BAR, 10 * BAR, yu_bulk_modulus, yu())
    assert exponent == pytest.approx(4.35598e-3, abs=5e-9)


def test_constant_modulus_has_a_closed_form():
    # z = 0.1: b (e^z - 1 - z) = 1e9 * 0.0051709181 = 5170918.1 J/m3; mean/b = z^2/(2 * 0.0051709181) = 0.966946
    b, P, Pd = 1e9, 1e8 + 1e5, 1e5
    assert compression_energy_per_volume(P, Pd, constant, b) == pytest.approx(5170918.1, rel=1e-8)
    assert compression_energy_per_volume(P, Pd, constant, b) == pytest.approx(b * (np.expm1(0.1) - 0.1), rel=1e-12)
    assert mean_modulus(P, Pd, constant, b) / b == pytest.approx(0.966946, rel=1e-6)
    assert specific_volume_exponent(P, Pd, constant, b) == pytest.approx(0.1, rel=1e-13)
    # W_m = W_V/rho(P), rho(P) = rho e^z: 5170918.1/(876 * 1.10517092) = 5341.15 J/kg
    assert compression_energy_per_mass(P, Pd, 876.0, constant, b) == pytest.approx(5341.15, rel=2e-6)


@pytest.mark.parametrize(
    ("pressure", "origin"), [(14e5, 10e5), (10e5, 14e5), (350e5, 1e5), (1e5, 350e5), (1e7, 9.99e6)]
)
def test_any_law_agrees_with_the_closed_form_of_the_mixture(make_oil, pressure, origin):
    oil = make_oil(air_fraction=0.1)
    general = compression_energy_per_volume(pressure, origin, mixture.bulk_modulus, oil)
    assert general == pytest.approx(mixture.compression_energy_per_volume(pressure, origin, oil), rel=1e-9)
    denser = mixture.specific_volume_ratio(origin, oil) / mixture.specific_volume_ratio(pressure, oil)
    exponent = specific_volume_exponent(pressure, origin, mixture.bulk_modulus, oil)
    assert np.exp(exponent) == pytest.approx(denser, rel=1e-12)
    per_mass = compression_energy_per_mass(
        pressure, origin, mixture.fluid_density(origin, 330.0, oil), mixture.bulk_modulus, oil
    )
    assert per_mass == pytest.approx(mixture.compression_energy_per_mass(pressure, origin, 330.0, oil), rel=1e-9)


@pytest.mark.parametrize(("law", "params"), LAWS[:4])
def test_energy_is_the_excess_volume(law, params):
    """W_V = int (e^g - 1) dP', the other form of the integral, by plain quadrature."""
    P, Pd = 60 * BAR, 2 * BAR

    def excess(p):
        return np.expm1(specific_volume_exponent(P, p, law, params()))

    expected = quad(excess, Pd, P, epsabs=0.0, epsrel=1e-9, limit=200)[0]
    assert compression_energy_per_volume(P, Pd, law, params()) == pytest.approx(expected, rel=1e-8)


def test_energy_through_the_kink_of_dissolved_air():
    """Beyond the critical pressure the oil alone yields: the energy up to there plus closed forms."""
    E, P, Pc, Pd = 1.7e9, 50 * BAR, 30 * BAR, 1 * BAR
    to_kink = compression_energy_per_volume(Pc, Pd, dissolving_bulk_modulus, dissolving())
    z = (P - Pc) / E
    # dW/dP = (P - Pd + W)/E from Pc on: W + P - Pd + E grows as e^z
    expected = (to_kink + Pc - Pd + E) * np.exp(z) - (P - Pd + E)
    found = compression_energy_per_volume(P, Pd, dissolving_bulk_modulus, dissolving())
    assert found == pytest.approx(expected, rel=1e-8)


def test_small_steps_lose_no_digits():
    params = yu()
    assert mean_modulus(14 * BAR, 14 * BAR, yu_bulk_modulus, params) == yu_bulk_modulus(14 * BAR, params)
    assert compression_energy_per_volume(14 * BAR, 14 * BAR, yu_bulk_modulus, params) == 0.0
    for d in (1e3, 1.0, 1e-3, -1.0):
        # mean = beta(P) (1 - beta' d/(...)): first order in d/P, of slope below 2
        mean = mean_modulus(14 * BAR + d, 14 * BAR, yu_bulk_modulus, params)
        assert mean == pytest.approx(yu_bulk_modulus(14 * BAR, params), rel=2.0 * abs(d) / (14 * BAR) + 1e-12)


@pytest.mark.thorough
@pytest.mark.parametrize(("law", "params"), LAWS)
@settings(max_examples=30, deadline=None)
@given(one=st.floats(0.0, 2.54), other=st.floats(0.0, 2.54), air=st.sampled_from([0.01, 0.1, 0.3]))
def test_bounds_of_the_mean_modulus(law, params, one, other, air):
    """Propositions 1 and 2: the mean lies between beta(P) and beta(Pd) e^-g(P, Pd), W_V/(P - Pd) between 0 and e^g - 1,
    above -1; both for laws that rise, as all do. Dissolved air leaves a kink, which costs the quadrature digits."""
    P, Pd, fluid = BAR * 10.0**one, BAR * 10.0**other, params(air)
    mean = mean_modulus(P, Pd, law, fluid)
    g = specific_volume_exponent(P, Pd, law, fluid)
    ends = sorted((law(P, fluid), law(Pd, fluid) * np.exp(-g)))
    assert ends[0] * (1.0 - 1e-6) <= mean <= ends[1] * (1.0 + 1e-6)
    share = (P - Pd) / (2.0 * mean)
    assert min(np.expm1(g), 0.0) - 1e-9 <= share <= max(np.expm1(g), 0.0) + 1e-9
    assert share > -1.0


@pytest.mark.parametrize(("law", "params"), LAWS)
def test_modulus_times_density_rises_along_a_compression(law, params):
    """beta(s) e^-g(P, s), whose extremes bound the mean, takes them at the ends: its slope is (beta' + 1) e^-g."""
    P = 60 * BAR
    s = np.geomspace(1 * BAR, P, 40)
    bound = [law(p, params()) * np.exp(-specific_volume_exponent(P, p, law, params())) for p in s]
    assert np.all(np.diff(bound) > 0.0)


def test_bound_as_printed_fails_for_a_constant_modulus():
    """The exponent of the upper bound belongs to the pressure in the maximum: with g(P, Pd) it would be 0.905 b."""
    mean = mean_modulus(1e8 + 1e5, 1e5, constant, 1e9)
    assert np.exp(-0.1) * 1e9 < mean < 1e9


def test_exponents_add_and_reverse():
    def g(P, origin):
        return specific_volume_exponent(P, origin, yu_bulk_modulus, yu())

    assert g(3e6, 1e6) + g(1e6, 2e5) == pytest.approx(g(3e6, 2e5), rel=1e-11)
    assert g(1e6, 3e6) == pytest.approx(-g(3e6, 1e6), rel=1e-11)


def test_another_unit_of_pressure():
    bar = YuAir(
        liquid_bulk_modulus=3.4e9,
        reference_pressure=2e5,
        air_fraction=0.1,
        polytropic_exponent=1.4,
        dissolving_rate=0.0,
    )
    assert yu_bulk_modulus(28 * BAR, bar) == pytest.approx(2.0 * yu_bulk_modulus(14 * BAR, yu()), rel=1e-14)
    doubled = compression_energy_per_volume(28 * BAR, 20 * BAR, yu_bulk_modulus, bar)
    assert doubled == pytest.approx(
        2.0 * compression_energy_per_volume(14 * BAR, 10 * BAR, yu_bulk_modulus, yu()), rel=1e-9
    )


def test_contradictions_are_refused():
    with pytest.raises(ParameterError, match=r"reference_pressure: .*must be less than critical_pressure, "):
        DissolvingAir(**COMMON, air_fraction=0.1, polytropic_exponent=1.4, critical_pressure=1e5)
    with pytest.raises(
        ParameterError, match=r"reference_pressure: -1.01325 bar \(0 bara\) must be greater than 0 bara"
    ):
        IsothermalAir(liquid_bulk_modulus=1.7e9, air_fraction=0.1, reference_pressure=0.0)
