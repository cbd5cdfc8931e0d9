import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vvdp.base.errors import ParameterError
from vvdp.fluid.mixture import FluidState, fluid_state
from vvdp.hydraulics.motor import Motor, motor_compression_loss, motor_flow, motor_torque

VALUES = {
    "displacement": 50e-6 / (2.0 * np.pi), "leakage_conductance": 1e-12, "shaft_damping": 0.01, "coulomb_torque": 2.0,
    "coulomb_speed": 1.0, "inertia": 0.01,
}  # fmt: skip
MOTOR = Motor(**VALUES)


def test_motor_by_hand():
    assert motor_flow(2.0 * np.pi * 20.0, MOTOR) == pytest.approx(1e-3, rel=1e-14)  # 50 cc * 20 rev/s
    a, b = FluidState(2e7, 0.98, 1e9, 1.98e7), FluidState(0.0, 1.0, 1e9, 0.0)
    assert motor_torque(a, b, MOTOR) == pytest.approx(1000.0 / (2.0 * np.pi), rel=1e-14)  # 50 cc * 200 bar = 1 kJ/rev
    # driven forward: 1e-3 m^3/s at a; its oil gives 1.98e7/0.98 per m^3, the torque takes 2e7
    assert motor_compression_loss(2.0 * np.pi * 20.0, a, b, MOTOR) == pytest.approx(
        1e-3 * (1.98e7 / 0.98 - 2e7), rel=1e-10
    )
    # the other way round it pumps: 1e-3 m^3/s at b; the torque gives 2e7 per m^3, the oil takes 1.98e7
    assert motor_compression_loss(-2.0 * np.pi * 20.0, a, b, MOTOR) == pytest.approx(200.0, rel=1e-10)


@given(P_a=st.floats(1e3, 4e7), P_b=st.floats(1e3, 4e7), speed=st.floats(-500.0, 500.0))
def test_compression_only_takes(oil, P_a, P_b, speed):
    a, b = fluid_state(P_a, oil), fluid_state(P_b, oil)
    power = MOTOR.displacement * abs(speed) * (P_a + P_b)
    assert motor_compression_loss(speed, a, b, MOTOR) >= -1e-12 * power


def test_contradictions_are_refused():
    for name, value in (("displacement", 0.0), ("coulomb_torque", -1.0), ("coulomb_speed", 0.0)):
        with pytest.raises(ParameterError, match=name):
            Motor(**(VALUES | {name: value}))
