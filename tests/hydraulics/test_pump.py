import numpy as np
import pytest
from scipy.integrate import quad

from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.pump import Pump, pump_friction_power, pump_friction_torque, tank_displacement

PUMP = Pump(
    displacement=22.8e-6 / (2.0 * np.pi),
    leakage_conductance=2e-12,
    ripple_amplitude=0.03,
    ripple_count=10.0,
    friction_torque=1.5,
)


TANK = FluidState(1e5, 1.0, 1e9, 0.0)


def test_pump_by_hand():
    # 22.8 cc/rev * 30 rev/s
    assert tank_displacement(0.0, TANK, PUMP) * 2.0 * np.pi * 30.0 == pytest.approx(6.84e-4, rel=1e-14)
    crest = tank_displacement(np.pi / 20.0, TANK, PUMP)  # 10 * pi/20 = pi/2
    assert crest * 2.0 * np.pi * 30.0 == pytest.approx(6.84e-4 * 1.03, rel=1e-14)
    boosted = tank_displacement(0.0, FluidState(1e6, 0.8, 1e9, 2e6), PUMP)  # 1/0.8 more mass in the same volume
    assert boosted == pytest.approx(1.25 * 22.8e-6 / (2.0 * np.pi), rel=1e-14)


def test_ripple_leaves_the_mean():
    mean, _ = quad(lambda angle: tank_displacement(angle, TANK, PUMP), 0.0, 2.0 * np.pi, limit=200)
    assert mean == pytest.approx(22.8e-6, rel=1e-10)  # one revolution displaces 22.8 cc


def test_friction_by_hand():
    assert pump_friction_power(-200.0, PUMP) == pump_friction_power(200.0, PUMP) == 300.0  # 1.5 N m * 200 rad/s
    assert [pump_friction_torque(w, PUMP) for w in (-3.0, 0.0, 1e-9)] == [-1.5, 0.0, 1.5]
    assert all(pump_friction_torque(w, PUMP) * w == pump_friction_power(w, PUMP) for w in (-3.0, 0.0, 7.0))
