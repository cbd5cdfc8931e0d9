"""Lossless converters: their ratios by hand, power kept, and the border where the tube stops."""

import numpy as np
import pytest

from vvdp.hydraulics.converter import boost_pressure, buck_pressure, flow_swing, stopping_buck_flow


def test_ratios_by_hand():
    """A quarter of 200 bar, with 10 bar at the base 57.5; 50 bar at three quarters go up to 200, with 10 bar to 170."""
    assert buck_pressure(0.25, 200e5, 0.0) == pytest.approx(50e5)
    assert buck_pressure(0.25, 200e5, 10e5) == pytest.approx(57.5e5)
    assert boost_pressure(0.75, 50e5, 0.0) == pytest.approx(200e5)
    assert boost_pressure(0.75, 50e5, 10e5) == pytest.approx(170e5)


def test_no_power_is_lost_and_one_undoes_the_other():
    """A buck takes d q from its supply and (1 - d) q from its base; a boost lets d q go there."""
    rng = np.random.default_rng(2)
    for _ in range(100):
        duty, supply, base, flow = rng.uniform(0.05, 0.95), rng.uniform(50e5, 300e5), rng.uniform(0.0, 20e5), 1e-3
        low = buck_pressure(duty, supply, base)
        assert low * flow == pytest.approx(duty * flow * supply + (1.0 - duty) * flow * base, rel=1e-12)
        high = boost_pressure(duty, supply, base)
        assert supply * flow == pytest.approx((1.0 - duty) * flow * high + duty * flow * base, rel=1e-12)
        assert boost_pressure(1.0 - duty, low, base) == pytest.approx(supply, rel=1e-9)


def test_flow_that_stops_by_integration():
    """Straight flanks from zero up and down again: half the peak for as long as they last."""
    duty, above, below, f, inertance = 0.3, 60e5, 140e5, 100.0, 4.6e7
    swing = flow_swing(duty, above, f, inertance)
    assert swing == pytest.approx(0.3 * 60e5 / (100.0 * 4.6e7), rel=1e-12)
    time = np.linspace(0.0, 1.0 / f, 200_001)
    flow = np.where(time < duty / f, above * time, above * duty / f - below * (time - duty / f)) / inertance
    mean = f * np.trapezoid(np.clip(flow, 0.0, None), time)
    assert stopping_buck_flow(swing, duty, above, below) == pytest.approx(mean, rel=1e-6)


def test_the_border_of_stopping_is_half_the_swing():
    """Where the load is at the ratio, the tube stops for an instant: the mean of a triangle that has no gap."""
    duty, supply = 0.4, 200e5
    load = buck_pressure(duty, supply, 0.0)
    swing = flow_swing(duty, supply - load, 100.0, 5e7)
    assert stopping_buck_flow(swing, duty, supply - load, load) == pytest.approx(0.5 * swing, rel=1e-12)
