"""A flow map and its inverse: exact between its rows, ready to deliver at zero flow, full open beyond all."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vvdp.base.errors import ParameterError
from vvdp.control.flow_map import FlowMap, duty_for_flow, flow_for_duty

DUTIES = (-0.3, 0.0, 0.1, 0.3, 1.0, 1.3)
MAP = FlowMap(
    duty_ratios=DUTIES,
    line_pressures=(1e5, 21e5, 61e5),
    flows=(0.0, 0.0, 2e-5, 1.8e-4, 6.4e-4, 6.6e-4, 0.0, 0.0, 1.6e-5, 1.7e-4, 6.3e-4, 6.6e-4,
           0.0, 0.0, 0.0, 1e-4, 6e-4, 6.5e-4),
)  # fmt: skip


def test_map_by_hand():
    """Half way between 1 and 21 bar, half way from 0.1 to 0.3: (2 + 18 + 1.6 + 17)/4 1e-5 m3/s."""
    assert flow_for_duty(0.2, 11e5, MAP) == pytest.approx(9.65e-5, rel=1e-12)
    assert duty_for_flow(9.65e-5, 11e5, MAP) == pytest.approx(0.2, rel=1e-12)


@given(st.floats(1e-7, 6.4e-4), st.floats(0.0, 70e5))
def test_inverse_is_exact(flow, pressure):
    assert flow_for_duty(duty_for_flow(flow, pressure, MAP), pressure, MAP) == pytest.approx(flow, rel=1e-9)


@given(st.floats(0.0, 8e-4), st.floats(0.0, 8e-4), st.floats(0.0, 70e5))
def test_more_flow_never_takes_a_lower_duty_ratio(one, other, pressure):
    low, high = sorted((one, other))
    assert duty_for_flow(low, pressure, MAP) <= duty_for_flow(high, pressure, MAP) + 1e-12


def test_without_flow_the_valve_is_ready_to_deliver():
    """At 61 bar it delivers nothing up to 0.1; between the pressures from 0 on."""
    assert duty_for_flow(0.0, 61e5, MAP) == pytest.approx(0.1)
    assert duty_for_flow(0.0, 11e5, MAP) == pytest.approx(0.0)
    assert duty_for_flow(-1e-4, 11e5, MAP) == pytest.approx(0.0)


def test_beyond_the_map_its_ends_hold():
    assert duty_for_flow(1.0, 11e5, MAP) == 1.3
    assert flow_for_duty(2.0, 1e8, MAP) == pytest.approx(6.5e-4)
    assert flow_for_duty(-2.0, 0.0, MAP) == 0.0


def test_a_map_that_falls_is_refused():
    with pytest.raises(ParameterError, match="row 3, 6 lpm, must be at least row 2, 12 lpm"):
        FlowMap(duty_ratios=(0.0, 0.5, 1.0), line_pressures=(1e5, 2e5), flows=(0.0, 2e-4, 1e-4, 0.0, 1e-4, 2e-4))
    with pytest.raises(ParameterError, match="5 flows for 3 duty ratios and 2 pressures"):
        FlowMap(duty_ratios=(0.0, 0.5, 1.0), line_pressures=(1e5, 2e5), flows=(0.0, 2e-4, 1e-4, 0.0, 1e-4))
