"""Pilot-operated check valve, reducing valve, flow control valve, seat valve, ideal source."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from vvdp.base.errors import ParameterError
from vvdp.hydraulics.check_valve import check_opening
from vvdp.hydraulics.flow import rated_edge_flow
from vvdp.hydraulics.flow_control_valve import FlowControlValve, controlled_flow
from vvdp.hydraulics.flow_source import FlowSource, source_flow
from vvdp.hydraulics.pilot_check_valve import PilotCheckValve, lifting_drop
from vvdp.hydraulics.reducing_valve import ReducingValve, reducing_opening, reducing_opening_rate
from vvdp.hydraulics.seat_valve import SeatValve, seat_flow, seat_rate


def pilot_check(**changed):
    values = {
        "cracking_pressure": 0.5e5, "rated_flow": 6e-4, "rated_drop": 2.5e5, "reverse_opening": 0.0,
        "opening_time": 0.0, "pilot_ratio": 3.0,
    }  # fmt: skip
    return PilotCheckValve(**(values | changed))


def reducing(**changed):
    values = {
        "closing_pressure": 51e5, "override_pressure": 5e5, "rated_flow": 5e-4, "rated_drop": 4e5, "opening_time": 5e-3
    }  # fmt: skip
    return ReducingValve(**(values | changed))


def flow_control(**changed):
    values = {"rated_flow": 1e-4, "minimum_drop": 8e5, "maximum_drop": 50e5, "flow_rise": 0.05}
    return FlowControlValve(**(values | changed))


SEAT = SeatValve(rated_flow=1e-3, rated_drop=5e5, lag=0.01)


def pilot_check_opening(drop, pilot, valve):
    """Static opening at a pilot less outlet [Pa]."""
    return check_opening(lifting_drop(drop, pilot, valve), valve)


def test_pilot_by_hand():
    # against 100 bar at b and 1 bar at a, half lift (1.5 bar) takes a pilot of 1 + (99 + 1.5)/3 = 34.5 bar
    assert lifting_drop(-99e5, 33.5e5, pilot_check()) == pytest.approx(1.5e5, rel=1e-9)
    assert pilot_check_opening(-99e5, 33.5e5, pilot_check()) == pytest.approx(0.5, rel=1e-9)
    assert pilot_check_opening(-99e5, 33e5, pilot_check()) == 0.0


@given(drop=st.floats(-1e7, 1e7), pilot=st.floats(-1e7, 1e7), ratio=st.floats(0.0, 10.0))
def test_a_pilot_only_opens(drop, pilot, ratio):
    valve = pilot_check(pilot_ratio=ratio)
    assert pilot_check_opening(drop, pilot, valve) >= check_opening(drop, valve)
    assert pilot_check_opening(drop, -abs(pilot), valve) == check_opening(drop, valve)
    assert pilot_check_opening(drop, pilot, pilot_check(pilot_ratio=0.0)) == check_opening(drop, valve)


def test_a_pilot_lifts_without_a_jump():
    pilots = np.linspace(0.0, 1e7, 20001)
    y = pilot_check_opening(-5e6, pilots, pilot_check())
    # at most R dp/(2 bar) from one to the next
    assert np.all(np.diff(y) >= 0.0)
    assert np.max(np.diff(y)) <= 3.0 * 500.0 / 2e5 * (1.0 + 1e-9)
    assert y[0] == 0.0
    assert y[-1] == 1.0


def test_reducing_valve_by_hand():
    valve = reducing()
    assert reducing_opening(48.5e5, valve) == pytest.approx(0.5, rel=1e-14)
    assert reducing_opening(51e5, valve) == reducing_opening(300e5, valve) == 0.0
    assert reducing_opening(46e5, valve) == reducing_opening(1e5, valve) == 1.0
    assert rated_edge_flow(valve.rated_flow, 0.5, 4e5, valve.rated_drop) == pytest.approx(2.5e-4, rel=1e-14)
    assert rated_edge_flow(valve.rated_flow, 0.5, -4e5, valve.rated_drop) == pytest.approx(-2.5e-4, rel=1e-14)
    assert reducing_opening_rate(48.5e5, 0.1, valve) == pytest.approx(80.0, rel=1e-12)  # (0.5 - 0.1)/5 ms
    assert reducing_opening_rate(48.5e5, 0.1, reducing(opening_time=0.0)) == 0.0


@pytest.mark.parametrize("demand", [1e-6, 1e-4, 4e-4])
def test_a_reduced_pressure_stays_within_the_override(demand):
    """Whatever the inlet, where the valve can pass the demand at all."""
    valve = reducing()

    def outlet(inlet):
        def excess(p):
            return rated_edge_flow(valve.rated_flow, reducing_opening(p, valve), inlet - p, valve.rated_drop) - demand

        return brentq(excess, 1e5, inlet)

    for inlet in (80e5, 150e5, 300e5):
        assert 46e5 <= outlet(inlet) <= 51e5
    assert outlet(80e5) < outlet(300e5)  # it rises a little with the inlet


def test_flow_control_by_hand():
    valve = flow_control()
    assert controlled_flow(8e5, 1.0, valve) == pytest.approx(1e-4, rel=1e-14)
    assert controlled_flow(29e5, 1.0, valve) == pytest.approx(1.025e-4, rel=1e-14)
    assert controlled_flow(29e5, 0.5, valve) == pytest.approx(0.5125e-4, rel=1e-14)
    # a quarter of the minimum drop: half the flow, transition (1.0001/(1 + 16e-4))^(1/4)
    assert controlled_flow(2e5, 1.0, valve) == pytest.approx(0.5e-4 * (1.0001 / 1.0016) ** 0.25, rel=1e-13)
    # four times the maximum drop: a throttle again
    assert controlled_flow(200e5, 1.0, valve) == pytest.approx(2.1e-4 * (1.0001 / (1.0 + 1e-4 / 16)) ** 0.25, rel=1e-13)
    # backwards a throttle of the same size
    assert controlled_flow(-8e5, 1.0, valve) == pytest.approx(-1e-4, rel=1e-14)
    assert controlled_flow(29e5, -0.3, valve) == 0.0
    assert controlled_flow(29e5, 1.7, valve) == controlled_flow(29e5, 1.0, valve)


@pytest.mark.parametrize("rise", [0.0, 0.05])
def test_flow_control_never_falls_with_the_drop_and_never_jumps(rise):
    drops = np.linspace(-20e5, 100e5, 120001)
    flow = controlled_flow(drops, 1.0, flow_control(flow_rise=rise))
    assert np.all(np.diff(flow) >= -1e-19)
    # the steepest place is the straight line through zero, 1.0001^(1/4)/sqrt(0.01) of the rated flow per minimum drop
    assert np.max(np.diff(flow)) <= 1e-4 * 10.0 * 1.0001**0.25 * 100.0 / 8e5 * (1.0 + 1e-9)
    held = (drops >= 8e5) & (drops <= 50e5)
    assert np.max(flow[held]) <= (1.0 + rise) * 1e-4 * (1.0 + 1e-12)


def test_seat_valve_by_hand():
    assert seat_flow(5e5, 0.25, SEAT) == pytest.approx(2.5e-4, rel=1e-14)
    assert seat_flow(-5e5, 1.0, SEAT) == pytest.approx(-1e-3, rel=1e-14)
    assert seat_flow(5e5, -0.1, SEAT) == 0.0
    assert seat_flow(5e5, 1.1, SEAT) == pytest.approx(1e-3, rel=1e-14)
    assert seat_rate(1.0, 0.2, SEAT) == pytest.approx(80.0, rel=1e-13)
    assert seat_rate(5.0, 1.0, SEAT) == 0.0


def test_source_counts_where_it_is_told_to():
    assert source_flow(1e-3, 0.98, FlowSource(counted_at_outlet=0.0)) == 1e-3
    assert source_flow(1e-3, 0.98, FlowSource(counted_at_outlet=1.0)) == pytest.approx(1.0204081632653e-3, rel=1e-12)


@pytest.mark.parametrize(
    ("make", "changed", "told"),
    [
        (reducing, {"override_pressure": 0.0}, "override_pressure"),
        (reducing, {"override_pressure": 51e5}, "must be less than closing_pressure"),
        (reducing, {"rated_flow": 0.0}, "rated_flow"),
        (reducing, {"rated_drop": 0.0}, "rated_drop"),
        (flow_control, {"rated_flow": -1e-4}, "rated_flow"),
        (flow_control, {"minimum_drop": 0.0}, "minimum_drop"),
        (flow_control, {"maximum_drop": 8e5}, "must be less than maximum_drop, 8 bar"),
        (pilot_check, {"rated_drop": 0.5e5}, "must be greater than cracking_pressure"),
    ],
)
def test_contradictions_are_refused(make, changed, told):
    with pytest.raises(ParameterError, match=told):
        make(**changed)


@pytest.mark.parametrize("name", ["rated_flow", "rated_drop", "lag"])
def test_a_seat_valve_needs_all_its_values(name):
    with pytest.raises(ParameterError, match=name):
        SeatValve(**({"rated_flow": 1e-3, "rated_drop": 5e5, "lag": 0.01} | {name: 0.0}))


def test_a_source_counts_one_way_or_the_other():
    with pytest.raises(ParameterError, match="counted_at_outlet"):
        FlowSource(counted_at_outlet=0.5)
