import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vvdp.base.errors import ParameterError
from vvdp.fluid.mixture import FluidState, fluid_state
from vvdp.hydraulics.flow import passage, rated_root, signed_root
from vvdp.hydraulics.orifice import Orifice, orifice_area_for, orifice_flow

ORIFICE = Orifice(discharge_coefficient=0.6, transition_pressure=2e4)
PRESSURES = st.floats(1e3, 5e7)


def test_passage_counts_the_side_the_oil_comes_from():
    dense, thin = FluidState(1e5, 0.98, 1e9, 1e7), FluidState(1e5, 1.0, 1e9, 0.0)
    forward = passage(4.9e-4, dense, thin)
    assert forward.flow == pytest.approx(5e-4, rel=1e-15)  # 4.9e-4 / 0.98
    assert forward.loss == pytest.approx(5000.0, rel=1e-15)  # 5e-4 * 1e7
    backward = passage(-3e-4, dense, thin)  # driven up the pressure: it gains what the loss is short of
    assert backward.flow == pytest.approx(-3e-4, rel=1e-15)
    assert backward.loss == pytest.approx(-3000.0, rel=1e-15)


@given(first=PRESSURES, second=PRESSURES, area=st.floats(0.0, 1e-3))
def test_an_orifice_never_gives_power(oil, first, second, area):
    flow = orifice_flow(area, first - second, 876.0, ORIFICE)
    a, b = fluid_state(first, oil), fluid_state(second, oil)
    there, back = passage(flow, a, b), passage(-flow, b, a)
    assert there.loss >= 0.0
    assert back.flow == -there.flow and back.loss == pytest.approx(there.loss, rel=1e-12)


def test_signed_root_limits_and_symmetry():
    eps = 2e4
    assert signed_root(0.0, eps) == 0.0
    assert signed_root(-3e5, eps) == -signed_root(3e5, eps)
    # dp = 100 eps: 1 - (1/100)^2/4, the next term being 5/32 (1/100)^4
    assert signed_root(2e6, eps) / np.sqrt(2e6) == pytest.approx(1.0 - 0.25e-4, abs=2e-9)
    assert signed_root(1e-3, eps) == pytest.approx(1e-3 / np.sqrt(eps), rel=1e-14)
    drops = np.linspace(-1e6, 1e6, 2001)
    assert np.all(np.diff(signed_root(drops, eps)) > 0.0)


def test_rated_root_is_one_at_the_rated_drop():
    assert rated_root(7e5, 7e5) == 1.0
    assert rated_root(-7e5, 7e5) == -1.0
    # 4 times the drop: twice the flow, but for the transition ((1 + 1e-4)/(1 + 1e-4/16))^(1/4)
    assert rated_root(2.8e6, 7e5) == pytest.approx(2.0 * ((1.0 + 1e-4) / (1.0 + 1e-4 / 16.0)) ** 0.25, rel=1e-14)


def test_orifice_by_hand():
    # sqrt(2/800) = 0.05; 0.6 * 1e-5 * 0.05 * sqrt(1e6) = 3e-4 m3/s; transition (1 + 0.02^2)^(-1/4)
    assert orifice_flow(1e-5, 1e6, 800.0, ORIFICE) == pytest.approx(3e-4 * 1.0004**-0.25, rel=1e-14)
    assert orifice_flow(0.0, 1e6, 800.0, ORIFICE) == 0.0
    assert orifice_flow(1e-5, 0.0, 800.0, ORIFICE) == 0.0


def test_orifice_is_free_of_units():
    m, kg, s = 3.0, 5.0, 7.0
    Pa = kg / (m * s**2)
    scaled = Orifice(discharge_coefficient=0.6, transition_pressure=2e4 * Pa)
    for drop in (1e3, 2e4, 3e6):
        flow = orifice_flow(1e-5 * m**2, drop * Pa, 876.0 * kg / m**3, scaled)
        assert flow == pytest.approx(orifice_flow(1e-5, drop, 876.0, ORIFICE) * m**3 / s, rel=1e-13)


@given(flow=st.floats(1e-7, 1e-2), drop=st.floats(1.0, 1e8))
def test_the_sized_area_passes_the_flow(flow, drop):
    area = orifice_area_for(flow, drop, 876.0, ORIFICE)
    assert orifice_flow(area, drop, 876.0, ORIFICE) == pytest.approx(flow, rel=1e-12)


def test_orifice_without_transition_is_refused():
    with pytest.raises(ParameterError, match="transition_pressure"):
        Orifice(discharge_coefficient=0.6, transition_pressure=0.0)
