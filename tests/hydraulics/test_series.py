import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from vvdp.hydraulics.flow import signed_root
from vvdp.hydraulics.series import first_share, series_conductance, series_flow

CONDUCTANCES = st.floats(1e-9, 1e-5)


def test_series_by_hand():
    # 3 and 4 give 12/5; the drop divides as 16 to 9: 3e-7 sqrt(0.64e6) = 4e-7 sqrt(0.36e6) = 2.4e-4
    assert series_conductance(3e-7, 4e-7) == pytest.approx(2.4e-7, rel=1e-14)
    assert first_share(3e-7, 4e-7) == pytest.approx(0.64, rel=1e-14)
    assert series_flow(1e6, 3e-7, 4e-7, 2e4) == pytest.approx(2.4e-4 * 1.0004**-0.25, rel=1e-13)
    assert series_flow(-1e6, 3e-7, 4e-7, 2e4) == -series_flow(1e6, 3e-7, 4e-7, 2e4)


@given(first=CONDUCTANCES, second=CONDUCTANCES, drop=st.floats(1e3, 1e8))
def test_it_is_what_two_root_laws_with_a_pressure_between_them_pass(first, second, drop):
    """The pressure between is found here by bisection."""
    over_first = brentq(lambda d: first**2 * d - second**2 * (drop - d), 0.0, drop, xtol=1e-12 * drop)
    assert first_share(first, second) * drop == pytest.approx(over_first, rel=1e-9, abs=1e-10 * drop)
    assert series_flow(drop, first, second, 1e-9) == pytest.approx(
        max(first * np.sqrt(over_first), second * np.sqrt(max(drop - over_first, 0.0))), rel=1e-6
    )


@given(drop=st.floats(-1e7, 1e7), conductance=CONDUCTANCES)
def test_two_equal_ones_pass_the_root_of_one_half_at_every_drop(drop, conductance):
    one = conductance * signed_root(drop, 2e4)
    # Below 1e-300 the numbers themselves lose digits.
    assert series_flow(drop, conductance, conductance, 2e4) == pytest.approx(one / np.sqrt(2.0), rel=1e-12, abs=1e-300)


@given(first=CONDUCTANCES, second=CONDUCTANCES)
def test_the_narrow_one_counts(first, second):
    both = series_conductance(first, second)
    assert both == series_conductance(second, first)
    assert min(first, second) / np.sqrt(2.0) * (1.0 - 1e-12) <= both <= min(first, second)
    assert series_conductance(first, 1e6 * first) == pytest.approx(first, rel=1e-12)


def test_shut_on_either_side_is_shut():
    for first, second in ((0.0, 1e-7), (1e-7, 0.0), (0.0, 0.0)):
        assert series_conductance(first, second) == 0.0
        assert series_flow(1e7, first, second, 2e4) == 0.0
    assert first_share(0.0, 1e-7) == 1.0
    assert first_share(1e-7, 0.0) == 0.0
    assert first_share(0.0, 0.0) == 0.5
