"""Density and viscosity over temperature."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

from vvdp.base.errors import ParameterError
from vvdp.fluid.oil import density, dynamic_viscosity, film_ratios, film_viscosity, kinematic_viscosity


def test_density_by_hand(make_oil):
    # 100 degC: 876/(1 + 7e-4 * 60) = 876/1.042 = 840.690979
    assert density(373.15, make_oil()) == pytest.approx(840.690979, rel=1e-9)
    assert density(313.15, make_oil()) == 876.0


@settings(deadline=None)
@given(rise=st.floats(-60.0, 60.0))
def test_volume_grows_in_proportion_to_temperature(make_oil, rise):
    oil = make_oil()
    grown = oil.density / density(313.15 + rise, oil) - 1.0
    assert grown == pytest.approx(7e-4 * rise, abs=1e-13)  # T carries an ulp of 373 K, 6e-14, times 7e-4


@settings(deadline=None)
@given(warm=st.floats(2.0, 1e4), share=st.floats(0.05, 0.95))
def test_both_points_of_the_data_sheet_are_met(make_oil, warm, share):
    hot = max(0.5, share * warm)
    oil = make_oil(viscosity_40=1e-6 * warm, viscosity_100=1e-6 * hot)
    # ln and exp carry an ulp each, magnified by ln(v + 0.7) <= 9.3 and (v + 0.7)/v <= 2.4
    assert kinematic_viscosity(313.15, oil) == pytest.approx(1e-6 * warm, rel=1e-13)
    assert kinematic_viscosity(373.15, oil) == pytest.approx(1e-6 * hot, rel=1e-13)


@pytest.mark.parametrize(("celsius", "hand"), [(30.0, 72.038), (45.0, 35.476), (50.0, 28.911)])
def test_viscosity_by_hand(make_oil, celsius, hand):
    # y40 = ln 44.878 = 3.803948, y100 = ln 7.35 = 1.994700, ln(373.15/313.15) = 0.1752978
    # B = ln(3.803948/1.994700)/0.1752978 = 0.645546/0.1752978 = 3.68257
    # 45 degC: ln(318.15/313.15) = 0.0158406; y = 3.803948 e^(-3.68257*0.0158406) = 3.588397; e^y - 0.7 = 35.476
    # 30 degC: ln(303.15/313.15) = -0.0324544; y = 4.286875; 72.038.  50 degC: 0.0314404; y = 3.388135; 28.911
    assert kinematic_viscosity(273.15 + celsius, make_oil()) * 1e6 == pytest.approx(hand, abs=1e-3)


def test_viscosity_is_the_chart_in_common_logarithms(make_oil):
    oil = make_oil()
    temperatures = np.array([313.15, 373.15])
    chart = np.log10(np.log10(np.array([44.178, 6.65]) + 0.7))
    slope, level = np.polyfit(np.log10(temperatures), chart, 1)
    for T in (263.15, 303.15, 353.15, 393.15):
        expected = 10.0**10.0 ** (level + slope * np.log10(T)) - 0.7
        assert kinematic_viscosity(T, oil) * 1e6 == pytest.approx(expected, rel=1e-9)  # the fit solves to 1e-12


@settings(deadline=None)
@given(cold=st.floats(243.15, 413.15), step=st.floats(0.1, 30.0))
def test_oil_thins_as_it_warms(make_oil, cold, step):
    oil = make_oil()
    assert kinematic_viscosity(cold + step, oil) < kinematic_viscosity(cold, oil)
    assert dynamic_viscosity(cold + step, oil) < dynamic_viscosity(cold, oil)


def test_dynamic_viscosity_by_hand(make_oil):
    # 876 kg/m3 * 44.178e-6 m2/s = 0.0386999 Pa s
    assert dynamic_viscosity(313.15, make_oil()) == pytest.approx(0.03869993, rel=1e-7)


def test_temperatures_may_be_an_array(make_oil):
    T = np.array([290.0, 330.0])
    assert dynamic_viscosity(T, make_oil()).tolist() == [dynamic_viscosity(t, make_oil()) for t in T]


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        (
            {"viscosity_100": 44.178e-6},
            "44.178 cSt at 40 degC must be greater than viscosity_100 at 100 degC, 44.178 cSt",
        ),
        ({"viscosity_40": 0.4e-6, "viscosity_100": 0.2e-6}, "0.2 cSt must be greater than 0.3 cSt"),
        ({"reference_pressure": 0.0}, "must be greater than 0 bara"),
        ({"air_fraction": 0.6}, "Oil.air_fraction"),
        ({"polytropic_exponent": 0.9}, "Oil.polytropic_exponent"),
    ],
)
def test_contradictions_are_refused(make_oil, changed, words):
    with pytest.raises(ParameterError, match=words):
        make_oil(**changed)


P0 = 101325.0
"""Reference pressure of the oil."""


def test_a_film_between_100_bar_and_the_tank_by_hand(make_oil):
    # alpha dP = 0.2: 0.2/(1 - e^-0.2) = 0.2/0.18126925 = 1.10333111; 0.0387 Pa s * 1.10333111 = 0.0426989
    oil = make_oil(pressure_viscosity=2e-8)
    assert film_ratios(P0 + 100e5, P0, oil) == pytest.approx((1.10333111, 0.90634623), rel=1e-8)
    assert film_viscosity(313.15, P0 + 100e5, P0, oil) == pytest.approx(876.0 * 44.178e-6 * 1.10333111, rel=1e-8)


def test_an_oil_that_pressure_does_not_thicken(make_oil):
    assert film_ratios(400e5, 1e5, make_oil()).viscosity == 1.0
    assert film_viscosity(313.15, 400e5, 1e5, make_oil()) == dynamic_viscosity(313.15, make_oil())


@settings(deadline=None)
@given(first=st.floats(0.0, 500e5), second=st.floats(0.0, 500e5), alpha=st.floats(0.0, 3e-8))
def test_flow_and_shear_of_a_film_are_those_of_one_viscosity(make_oil, first, second, alpha):
    """Flow goes with the mean of 1/mu over the pressure, shear with the mean of mu over the length; numerically."""
    oil = make_oil(pressure_viscosity=alpha)
    found = film_ratios(first, second, oil).viscosity
    fluidity = quad(lambda share: np.exp(-alpha * (second + share * (first - second) - P0)), 0.0, 1.0, epsrel=1e-11)[0]
    assert found == pytest.approx(1.0 / fluidity, rel=4e-5)  # (1.5)^6/322560 at the outermost
    assert found == pytest.approx(film_ratios(second, first, oil).viscosity, rel=1e-14)
    low, high = sorted((first, second))
    assert np.exp(alpha * (low - P0)) * (1.0 - 4e-5) <= found <= np.exp(alpha * (high - P0)) * (1.0 + 4e-5)


def test_mean_shear_along_a_film_from_its_pressure(make_oil):
    """The pressure along the slot integrated step by step, dP/ds = -q mu(P), and mu averaged on the way."""
    oil, alpha, first = make_oil(pressure_viscosity=2e-8), 2e-8, 300e5
    flow = first / film_ratios(P0 + first, P0, oil).viscosity  # per slot conductance

    def along(_, state):
        thick = np.exp(alpha * state[0])
        return [-flow * thick, thick]

    end = solve_ivp(along, (0.0, 1.0), [first, 0.0], rtol=1e-10, atol=[1e-3, 1e-12]).y[:, -1]
    assert end[0] == pytest.approx(0.0, abs=1e-6 * first)
    assert end[1] == pytest.approx(film_ratios(P0 + first, P0, oil).viscosity, rel=1e-6)
