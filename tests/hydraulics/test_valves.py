import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vvdp.base.errors import ParameterError
from vvdp.hydraulics.check_valve import CheckValve, check_flow, check_opening, check_opening_rate
from vvdp.hydraulics.directional_valve import DirectionalValve, edge_openings, position_rate
from vvdp.hydraulics.flow import rated_edge_flow, root_edge_flow
from vvdp.hydraulics.proportional_valve import ProportionalValve, opening_rate, proportional_flow

DROPS = st.floats(-5e7, 5e7)


def check(reverse, time=0.0):
    return CheckValve(
        cracking_pressure=0.5e5, rated_flow=6e-4, rated_drop=2.5e5, reverse_opening=reverse, opening_time=time
    )


THROTTLE = ProportionalValve(conductance=1.2e-7, leakage_conductance=1e-13, transition_pressure=2e4, lag=5e-3)
FOUR_WAY = DirectionalValve(conductance=1e-6, overlap=0.05, transition_pressure=2e4, lag=8e-3)


def test_check_valve_by_hand():
    tight = check(0.0)
    assert check_flow(2.5e5, tight) == pytest.approx(6e-4, rel=1e-14)
    assert check_opening(1.5e5, tight) == pytest.approx(0.5, rel=1e-14)  # half way from 0.5 to 2.5 bar
    # twice the root at four times the drop, fully open; transition ((1 + 1e-4)/(1 + 1e-4/16))^(1/4)
    assert check_flow(10e5, tight) == pytest.approx(12e-4 * (1.0001 / 1.00000625) ** 0.25, rel=1e-13)
    assert check_flow(0.5e5, tight) == 0.0
    assert check_flow(-1e7, tight) == 0.0


def test_no_check_valve_fitted_is_open_both_ways():
    none = check(1.0)
    for drop in (1e3, 2e5, 3e6):
        assert check_opening(-drop, none) == 1.0
        assert check_flow(-drop, none) == -check_flow(drop, none)
    assert check_flow(2.5e5, none) == pytest.approx(6e-4, rel=1e-14)


def test_poppet_follows_its_drop():
    slow = check(0.2, 2e-3)
    # at 1.5 bar: 0.2 + 0.8 * 0.5 = 0.6; (0.6 - 0.2)/2 ms = 200 1/s
    assert check_opening_rate(1.5e5, 0.2, slow) == pytest.approx(200.0, rel=1e-13)
    assert check_opening_rate(1.5e5, 0.2, check(0.2)) == 0.0
    assert rated_edge_flow(slow.rated_flow, 0.6, 2.5e5, slow.rated_drop) == pytest.approx(3.6e-4, rel=1e-13)
    assert rated_edge_flow(slow.rated_flow, 0.6, -1e5, slow.rated_drop) < 0.0  # not yet seated: oil runs back


@given(drop=DROPS, reverse=st.floats(0.0, 1.0))
def test_valves_run_down_the_pressure(drop, reverse):
    assert check_flow(drop, check(reverse)) * drop >= 0.0
    assert 0.0 <= check_opening(drop, check(reverse)) <= 1.0
    assert proportional_flow(drop, reverse, THROTTLE) * drop >= 0.0


def test_check_flow_grows_with_the_drop():
    drops = np.linspace(-1e6, 1e6, 4001)
    assert np.all(np.diff(check_flow(drops, check(0.1))) >= 0.0)


def test_proportional_valve_by_hand():
    # 1.2e-7 * 0.5 * 1000 = 6e-5, transition (1 + 0.02^2)^(-1/4); leakage 1e-13 * 1e6 = 1e-7
    assert proportional_flow(1e6, 0.5, THROTTLE) == pytest.approx(6e-5 * 1.0004**-0.25 + 1e-7, rel=1e-13)
    assert proportional_flow(1e6, -0.2, THROTTLE) == pytest.approx(1e-7, rel=1e-13)
    assert proportional_flow(0.0, 1.0, THROTTLE) == 0.0
    assert opening_rate(0.8, 0.3, THROTTLE) == pytest.approx(100.0, rel=1e-13)  # 0.5/5 ms
    assert opening_rate(7.0, 1.0, THROTTLE) == 0.0


def test_directional_valve_by_hand():
    assert edge_openings(0.525, FOUR_WAY) == pytest.approx((0.5, 0.0), rel=1e-14)  # (0.525 - 0.05)/0.95
    assert edge_openings(-1.0, FOUR_WAY) == (0.0, 1.0)
    assert edge_openings(0.05, FOUR_WAY) == edge_openings(-0.04, FOUR_WAY) == (0.0, 0.0)
    assert root_edge_flow(FOUR_WAY.conductance, 0.5, 1e6, FOUR_WAY.transition_pressure) == pytest.approx(
        5e-4 * 1.0004**-0.25, rel=1e-13
    )
    assert position_rate(-3.0, 0.6, FOUR_WAY) == pytest.approx(-200.0, rel=1e-13)  # (-1 - 0.6)/8 ms


def test_contradictions_are_refused():
    with pytest.raises(ParameterError, match="must be greater than cracking_pressure"):
        CheckValve(cracking_pressure=2e5, rated_flow=6e-4, rated_drop=2e5, reverse_opening=0.0, opening_time=0.0)
    with pytest.raises(ParameterError, match="rated_flow"):
        CheckValve(cracking_pressure=0.0, rated_flow=-1e-4, rated_drop=2e5, reverse_opening=0.0, opening_time=0.0)
    with pytest.raises(ParameterError, match="overlap"):
        DirectionalValve(conductance=1e-6, overlap=1.0, transition_pressure=2e4, lag=8e-3)
    for changed in ({"lag": 0.0}, {"transition_pressure": 0.0}):
        values = {"conductance": 1e-6, "transition_pressure": 2e4, "lag": 8e-3} | changed
        with pytest.raises(ParameterError, match=next(iter(changed))):
            DirectionalValve(overlap=0.05, **values)
        with pytest.raises(ParameterError, match=next(iter(changed))):
            ProportionalValve(leakage_conductance=0.0, **values)
