"""The command for a flow, and back."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vvdp.base.errors import ParameterError
from vvdp.control.orifice import ChamberValve, valve_command, valve_flow

K = 0.62 * 20e-6 * np.sqrt(2.0 / 876.0)
VALVE = ChamberValve(conductance=K, supply_pressure=14.1e5, tank_pressure=1e5)


def test_commands_by_hand():
    """K = 5.925e-7; 1e-4 m^3/s in at 10.1 bar: a drop of 4 bar, 0.2669; as much out: 9.1 bar, -0.1769."""
    assert pytest.approx(5.925e-7, rel=1e-4) == K
    assert valve_command(1e-4, 10.1e5, VALVE) == pytest.approx(1e-4 / (K * np.sqrt(4e5)), rel=1e-14)
    assert valve_command(1e-4, 10.1e5, VALVE) == pytest.approx(0.2669, abs=1e-4)
    assert valve_command(-1e-4, 10.1e5, VALVE) == pytest.approx(-0.1769, abs=1e-4)


@given(st.floats(-3e-4, 3e-4), st.floats(1.1e5, 14.0e5))
def test_inverse(flow, pressure):
    """Wherever the drop exceeds the least one and the command its limits."""
    u = valve_command(flow, pressure, VALVE)
    assert -1.0 <= u <= 1.0
    if abs(u) < 1.0:
        assert valve_flow(u, pressure, VALVE) == pytest.approx(flow, rel=1e-12, abs=1e-20)


@given(st.floats(-1e-3, 1e-3), st.floats(0.0, 20e5))
def test_command_is_finite_at_any_pressure_and_grows_with_the_flow(flow, pressure):
    assert abs(valve_command(flow, pressure, VALVE)) <= 1.0
    assert valve_command(flow, pressure, VALVE) <= valve_command(flow + 1e-6, pressure, VALVE)


def test_floor_of_the_drop():
    """Without one the command would be infinite at the supply's own pressure."""
    assert valve_command(1e-6, 14.1e5, VALVE) == pytest.approx(1e-6 / (K * np.sqrt(1e3)))
    assert valve_command(-1e-6, 0.9e5, VALVE) == pytest.approx(-1e-6 / (K * np.sqrt(1e3)))
    assert valve_flow(1.0, 15e5, VALVE) == 0.0 == valve_flow(-1.0, 0.9e5, VALVE)


def test_contradictions_are_refused():
    with pytest.raises(
        ParameterError,
        match=r"supply_pressure: -0.01325 bar \(1 bara\) must be greater than tank_pressure, 0.98675 bar",
    ):
        ChamberValve(conductance=K, supply_pressure=1e5, tank_pressure=2e5)
    with pytest.raises(ParameterError, match="least_drop: 0 bar must be greater than 0"):
        ChamberValve(conductance=K, supply_pressure=2e5, tank_pressure=1e5, least_drop=0.0)
