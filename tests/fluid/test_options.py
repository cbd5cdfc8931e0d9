"""Oil that stiffens under pressure and in the cold, and oil that boils: numbers by hand, and one law behind all."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from vvdp.base.errors import ParameterError
from vvdp.fluid.mixture import (
    aerated_state,
    bulk_modulus,
    compression_energy_per_volume,
    enthalpy,
    fluid_state,
    fluid_state_compiled,
    is_plain,
    mean_bulk_modulus,
    plain_state,
    specific_volume_ratio,
)
from vvdp.fluid.oil import density, kinematic_viscosity, modulus_at
from vvdp.fluid.parts import air_part, liquid_part, vapour_part

P0 = 101325.0
SLOPE = st.sampled_from([0.0, 1.0]) | st.floats(0.01, 20.0)
VAPOUR = st.sampled_from([0.0]) | st.floats(10.0, 9e4)
PRESSURE = st.floats(1.0, 8.0).map(lambda power: 10.0**power)


def test_a_growing_modulus_by_hand(make_oil):
    # K = 1.4 GPa + 11 * 299 bar = 1.7289 GPa; l = (1.7289/1.4)^(-1/11) = e^(-0.2110130/11) = 0.9809998
    # h = 1.4e9 (e^(10 * 0.0191830) - 1)/10 = 1.4e8 * 0.2114647 = 2.960506e7
    oil = make_oil(air_fraction=0.0, bulk_modulus_slope=11.0)
    state = fluid_state(P0 + 299e5, oil)
    assert state.bulk_modulus == pytest.approx(1.7289e9, rel=1e-12)
    assert state.volume_ratio == pytest.approx(0.9809998, abs=1e-7)
    assert state.enthalpy == pytest.approx(2.960506e7, rel=1e-6)


@settings(max_examples=60, deadline=None)
@given(slope=SLOPE, vapour=VAPOUR, one=PRESSURE, other=PRESSURE)
def test_enthalpy_and_modulus_are_those_of_the_volume(make_oil, slope, vapour, one, other):
    """dh = nu dP and d(ln nu) = -dP/beta, by an independent integration."""
    oil = make_oil(bulk_modulus_slope=slope, vapour_pressure=vapour)
    low, high = sorted((one, other))
    joints = sorted({p for p in (vapour, 0.01 * vapour, 0.01 * P0) if low < p < high} | {low, high})

    def over(value):
        parts = pairwise(joints)
        return sum(
            quad(lambda u: value(np.exp(u)) * np.exp(u), np.log(a), np.log(b), epsabs=0.0, epsrel=1e-11, limit=300)[0]
            for a, b in parts
        )

    gained = enthalpy(high, oil) - enthalpy(low, oil)
    assert gained == pytest.approx(over(lambda P: specific_volume_ratio(P, oil)), rel=1e-9, abs=1e-7)
    yielded = np.log(specific_volume_ratio(low, oil) / specific_volume_ratio(high, oil))
    assert yielded == pytest.approx(over(lambda P: 1.0 / bulk_modulus(P, oil)), rel=1e-9, abs=1e-13)


@settings(deadline=None)
@given(pressure=PRESSURE, air=st.floats(0.0, 0.3), n=st.floats(1.0, 1.7))
def test_neutral_options_are_the_plain_law(make_oil, pressure, air, n):
    oil = make_oil(air_fraction=air, polytropic_exponent=n)
    assert is_plain(oil)
    plain = plain_state(pressure, oil)
    assert fluid_state_compiled(pressure, oil) == plain
    assert aerated_state(pressure, air, oil) == pytest.approx(plain, rel=1e-13, abs=1e-9)


@settings(max_examples=40, deadline=None)
@given(slope=SLOPE, vapour=VAPOUR, pressure=st.floats(2e4, 4e7), origin=st.floats(2e4, 4e7))
def test_stored_energy_is_that_of_the_enthalpies(make_oil, slope, vapour, pressure, origin):
    """nu W_V = h - h_d - nu (P - Pd): the closed form against the difference that loses digits."""
    oil = make_oil(bulk_modulus_slope=slope, vapour_pressure=vapour)
    nu = specific_volume_ratio(pressure, oil)
    expected = (enthalpy(pressure, oil) - enthalpy(origin, oil)) / nu - (pressure - origin)
    found = compression_energy_per_volume(pressure, origin, oil)
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-7)  # rounding of enthalpies of 4e7
    assert found >= -1e-7


def test_mean_modulus_of_stiffening_oil(make_oil):
    """Between its ends, and above that of a constant modulus."""
    oil = make_oil(air_fraction=0.0, bulk_modulus_slope=10.0)
    mean = mean_bulk_modulus(P0 + 3e7, oil)
    # int p/(K + m p) dp = p/m - K/m^2 ln(1 + m p/K): 3e6 - 1.4e7 ln(1.2142857) = 281775; p^2/2 over it
    by_hand = 0.5 * 9e14 / (3e6 - 1.4e7 * np.log(1.0 + 3.0 / 14.0))
    assert mean == pytest.approx(by_hand, rel=1e-9)
    assert 1.4e9 < mean < 1.7e9


def test_a_chain_of_parts_has_a_symmetric_slope(make_oil):
    """h of pressure and free air: d2h/dP dphi is d(nu)/dphi either way."""
    oil, step = make_oil(vapour_pressure=5e3, bulk_modulus_slope=11.0), 1e-6
    for P in (2e3, 4e4, 5e6):
        more, less = aerated_state(P, 0.02 + step, oil), aerated_state(P, 0.02 - step, oil)
        assert (more.volume_ratio - less.volume_ratio) / (2.0 * step) == pytest.approx(
            air_part(P, oil).volume, rel=1e-8
        )
        assert (more.enthalpy - less.enthalpy) / (2.0 * step) == pytest.approx(
            air_part(P, oil).enthalpy, rel=1e-6, abs=1e-3
        )


def test_vapour_by_hand(make_oil):
    # L = ln 2: v = 4 * 0.480453 = 1.921812; int v dP = 4 * 1e3 (0.480453 + 1.386294 + 2) - 4 * 4e3 = -533.01
    boiling = make_oil(vapour_pressure=2e3)
    half = vapour_part(1e3, boiling)
    assert half.volume == pytest.approx(1.921812, abs=1e-6)
    assert half.enthalpy == pytest.approx(-533.01, abs=0.01)
    assert vapour_part(2e3, boiling) == (0.0, 0.0, 0.0)
    assert vapour_part(1e7, boiling).volume == 0.0
    assert vapour_part(1e3, make_oil()) == (0.0, 0.0, 0.0) == vapour_part(-1e3, make_oil())


def test_vapour_is_a_floor_of_the_pressure(make_oil):
    """As much vapour as oil at 0.61 of the vapour pressure, ten times as much at a fifth of it."""
    boiling = make_oil(vapour_pressure=5e3)
    assert vapour_part(0.61 * 5e3, boiling).volume == pytest.approx(1.0, abs=0.03)
    assert vapour_part(0.2 * 5e3, boiling).volume == pytest.approx(10.4, abs=0.1)
    pressures = np.linspace(-2e3, 2e4, 500)
    volumes = [specific_volume_ratio(p, boiling) for p in pressures]
    assert np.all(np.diff(volumes) < 0.0)
    assert all(bulk_modulus(p, boiling) > 0.0 for p in pressures)


def test_modulus_falls_with_temperature(make_oil):
    # 60 degC: 1.4 GPa * e^(-5.5e-3 * 20) = 1.4 * 0.8958341 = 1.254168
    oil = make_oil(bulk_modulus_fall=5.5e-3)
    assert modulus_at(333.15, oil) == pytest.approx(1.254168e9, rel=1e-6)
    assert modulus_at(313.15, oil) == 1.4e9 == modulus_at(300.0, make_oil())


def test_the_rule_for_mineral_oils(make_oil):
    """docs/models/fluid.md: 1.7 GPa at 40 degC, a slope of 10 and a fall of 5.5e-3 1/K."""
    thickness = 1e6 * kinematic_viscosity(293.15, make_oil())
    secant = (1.57 + 0.15 * np.log10(thickness)) * 10.0 ** (0.0024 * (20.0 - 40.0))
    assert secant == pytest.approx(1.7, abs=0.05)
    assert 0.0024 * np.log(10.0) == pytest.approx(5.5e-3, abs=5e-5)
    stiff, rise = make_oil(air_fraction=0.0, bulk_modulus_slope=10.2), 1e7  # (10.2 + 1)/2 = 5.6
    assert rise / (1.0 - specific_volume_ratio(P0 + rise, stiff)) == pytest.approx(1.4e9 + 5.6 * rise, rel=5e-4)


def test_density_holds_where_the_data_sheet_says(make_oil):
    # 876 at 15.6 degC: at 40 degC 876/(1 + 7e-4 * 24.4) = 876/1.01708 = 861.2892
    oil = make_oil(density_temperature=273.15 + 15.6)
    assert density(288.75, oil) == 876.0
    assert density(313.15, oil) == pytest.approx(861.2892, abs=1e-4)


def test_liquid_alone_has_the_modulus_that_is_asked_for(make_oil):
    oil = make_oil(bulk_modulus_slope=8.0)
    for P in (0.0, P0, 1e7, 4e7):
        part = liquid_part(P, oil)
        assert part.volume / part.yielding == pytest.approx(1.4e9 + 8.0 * (P - P0), rel=1e-12)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"vapour_pressure": 101325.0}, "the oil would boil"),
        ({"bunsen_coefficient": 0.09}, "time: 0 ms must be greater than 0"),
        ({"bunsen_coefficient": 0.09, "release_time": 0.1}, "time: 0 ms must be greater than 0"),
        ({"bulk_modulus_slope": -1.0}, "Oil.bulk_modulus_slope"),
        ({"bulk_modulus_fall": 1.0}, "Oil.bulk_modulus_fall"),
    ],
)
def test_contradictions_are_refused(make_oil, changed, words):
    with pytest.raises(ParameterError, match=words):
        make_oil(**changed)
