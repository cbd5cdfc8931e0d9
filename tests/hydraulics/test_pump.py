import numpy as np
import pytest
from scipy.integrate import quad

from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.pump import (
    Pump,
    pump_flow,
    pump_friction_power,
    pump_friction_torque,
    pump_torque,
    shaft_power,
)

PUMP = Pump(
    displacement=22.8e-6 / (2.0 * np.pi),
    leakage_conductance=2e-12,
    ripple_amplitude=0.03,
    ripple_count=10.0,
    friction_torque=1.5,
)


def test_pump_by_hand():
    flow = pump_flow(0.0, 2.0 * np.pi * 30.0, 1e7, PUMP)
    assert flow.ideal == pytest.approx(6.84e-4, rel=1e-14)  # 22.8 cc/rev * 30 rev/s
    assert flow.leakage == pytest.approx(2e-5, rel=1e-14)  # 2e-12 * 1e7
    crest = pump_flow(np.pi / 20.0, 2.0 * np.pi * 30.0, 0.0, PUMP)  # 10 * pi/20 = pi/2
    assert crest.ideal == pytest.approx(6.84e-4 * 1.03, rel=1e-14)
    assert crest.leakage == 0.0


def test_ripple_leaves_the_mean():
    mean, _ = quad(lambda angle: pump_flow(angle, 1.0, 0.0, PUMP).ideal, 0.0, 2.0 * np.pi, limit=200)
    assert mean == pytest.approx(22.8e-6, rel=1e-10)  # one revolution displaces 22.8 cc


def test_shaft_power_by_hand():
    tank, out = FluidState(1e5, 1.0, 1e9, 0.0), FluidState(1e5, 0.99, 1e9, 1e7)
    # 6e-4 * 1e7 = 6000 W; 1.5 N m * 200 rad/s = 300 W
    assert shaft_power(6e-4, 200.0, tank, out, PUMP) == pytest.approx(6300.0, rel=1e-14)
    assert pump_friction_power(-200.0, PUMP) == pump_friction_power(200.0, PUMP) == 300.0


def test_a_pump_at_rest_only_leaks():
    assert pump_flow(1.0, 0.0, -1e5, PUMP) == (0.0, -2e-7)


def test_torques_by_hand():
    tank, out = FluidState(1e5, 1.0, 1e9, 0.0), FluidState(1e5, 0.99, 1e9, 1e7)
    assert pump_torque(0.0, tank, out, PUMP) == pytest.approx(22.8e-6 / (2.0 * np.pi) * 1e7, rel=1e-14)
    boost = FluidState(1e6, 0.8, 1e9, 2e6)
    assert pump_torque(0.0, boost, out, PUMP) == pytest.approx(22.8e-6 / (2.0 * np.pi) * 1e7, rel=1e-14)  # 8e6/0.8
    assert [pump_friction_torque(w, PUMP) for w in (-3.0, 0.0, 1e-9)] == [-1.5, 0.0, 1.5]


def test_torque_times_speed_is_the_power_of_the_shaft():
    tank, out = FluidState(1e5, 1.0, 1e9, 0.0), FluidState(1e5, 0.99, 1e9, 1e7)
    for angle, speed in ((0.3, 150.0), (1.1, -20.0), (0.0, 0.0)):
        torque = pump_torque(angle, tank, out, PUMP) + pump_friction_torque(speed, PUMP)
        power = shaft_power(pump_flow(angle, speed, 1e7, PUMP).ideal, speed, tank, out, PUMP)
        assert torque * speed == pytest.approx(power, rel=1e-13, abs=1e-12)
