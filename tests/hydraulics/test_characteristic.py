import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vvdp.base.errors import ParameterError
from vvdp.hydraulics.characteristic import Characteristic, flow_share, opening_for


def test_characteristic_by_hand():
    progressive = Characteristic(dead_band=0.1, rangeability=100.0)
    # half way from 0.1 to 1: (sqrt(100) - 1)/(100 - 1) = 1/11
    assert flow_share(0.55, progressive) == pytest.approx(1.0 / 11.0, rel=1e-13)
    assert opening_for(1.0 / 11.0, progressive) == pytest.approx(0.55, rel=1e-13)
    linear = Characteristic(dead_band=0.2, rangeability=1.0)
    assert flow_share(0.4, linear) == pytest.approx(0.25, rel=1e-13)
    assert opening_for(0.25, linear) == pytest.approx(0.4, rel=1e-13)


@given(share=st.floats(1e-6, 1.0), dead=st.floats(0.0, 0.9), ratio=st.floats(1.0, 1000.0))
def test_the_inverse_gives_the_share_back(share, dead, ratio):
    law = Characteristic(dead_band=dead, rangeability=ratio)
    assert flow_share(opening_for(share, law), law) == pytest.approx(share, rel=1e-7)


@given(dead=st.floats(0.0, 0.9), ratio=st.floats(1.0, 1000.0))
def test_ends(dead, ratio):
    law = Characteristic(dead_band=dead, rangeability=ratio)
    assert flow_share(0.0, law) == flow_share(dead, law) == flow_share(-1.0, law) == 0.0
    assert flow_share(1.0, law) == flow_share(1.5, law) == 1.0
    assert opening_for(0.0, law) == dead
    assert opening_for(1.0, law) == pytest.approx(1.0, rel=1e-14)


def test_rangeability_is_the_ratio_of_the_slopes():
    law = Characteristic(dead_band=0.1, rangeability=30.0)
    share = flow_share(np.array([0.1, 0.1 + 1e-6, 1.0 - 1e-6, 1.0]), law)
    assert (share[3] - share[2]) / (share[1] - share[0]) == pytest.approx(30.0, rel=1e-4)


def test_a_rangeability_next_to_one_is_nearly_linear():
    near = Characteristic(dead_band=0.0, rangeability=1.0 + 1e-9)
    openings = np.linspace(0.0, 1.0, 11)
    np.testing.assert_allclose(flow_share(openings, near), openings, atol=1e-9)
    np.testing.assert_allclose(opening_for(openings, near), openings, atol=1e-9)


def test_contradictions_are_refused():
    with pytest.raises(ParameterError, match="dead_band"):
        Characteristic(dead_band=1.0, rangeability=10.0)
    with pytest.raises(ParameterError, match="rangeability"):
        Characteristic(dead_band=0.0, rangeability=0.5)
