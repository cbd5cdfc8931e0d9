"""The gerotor drive's static map, inverted."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vvdp.base.errors import ParameterError
from vvdp.control.calibration import Calibration, calibrated_command, dead_band_calibration, measured_calibration

FULL, DEAD, LEAST = (-2.7e-5, 3e-5), (-0.08, 0.06), 1e-6
DRIVE = dead_band_calibration(FULL, DEAD, LEAST)


def delivered(u):
    """The map itself."""
    back, forth = (q * max(0.0, s * (u - d)) / (1.0 - s * d) for q, d, s in zip(FULL, DEAD, (-1, 1), strict=True))
    return back + forth


@given(st.floats(-2.7e-5, 3e-5))
def test_inverse_of_the_dead_band(flow):
    u = calibrated_command(flow, DRIVE)
    if abs(flow) >= LEAST:
        assert delivered(u) == pytest.approx(flow, rel=1e-9)
    else:
        # straight through zero: from 0 to the 0.0913 that delivers the least flow, or to -0.1141 backward
        ends = 0.06 + 0.94 / 30.0, -0.08 - 0.92 / 27.0
        assert u == pytest.approx(abs(flow) / LEAST * ends[flow < 0.0], abs=1e-12)


def test_limits():
    assert calibrated_command(1.0, DRIVE) == 1.0
    assert calibrated_command(-1.0, DRIVE) == -1.0
    assert calibrated_command(0.0, DRIVE) == 0.0


def test_measured_table():
    """Its flat rows give way to the line through zero; what is between two rows lies on their line."""
    commands = [-1.0, -0.5, -0.1, 0.0, 0.1, 0.5, 1.0]
    flows = [-2e-5, -1e-5, 0.0, 0.0, 0.0, 1.2e-5, 2.5e-5]
    found = measured_calibration(commands, flows, 1e-6)
    assert found.flows == (-2e-5, -1e-5, 0.0, 1.2e-5, 2.5e-5)
    assert calibrated_command(1.85e-5, found) == pytest.approx(0.75)
    assert calibrated_command(6e-6, found) == pytest.approx(0.25)


STEPS = st.lists(st.floats(1e-7, 1e-5), min_size=1, max_size=5)


@given(STEPS, STEPS)
def test_any_monotone_table_is_met_at_its_points(backward, forward):
    ends = [-1e-6 - sum(backward[:i]) for i in range(len(backward), 0, -1)]
    flows = [*ends, *(1e-6 + sum(forward[: i + 1]) for i in range(len(forward)))]
    commands = [*np.linspace(-1.0, -0.1, len(backward)), *np.linspace(0.1, 1.0, len(forward))]
    found = measured_calibration(commands, flows, 1e-6)
    for command, flow in zip(commands, flows, strict=True):
        assert calibrated_command(flow, found) == pytest.approx(command, abs=1e-12)


def test_a_table_that_falls_is_refused_with_its_row():
    with pytest.raises(ParameterError, match=r"row 4 of a calibration: at command 0.5 the flow is 1e-05 m\^3/s, 2e-05"):
        measured_calibration([-1.0, 0.0, 0.2, 0.5], [-1e-5, 0.0, 2e-5, 1e-5], 1e-6)
    with pytest.raises(ParameterError, match=r"row 3 of a calibration: command -1\.2 does not exceed -1"):
        measured_calibration([-1.1, -1.0, -1.2], [-1e-5, 0.0, 1e-5], 1e-6)
    with pytest.raises(ParameterError, match="row 2 of a calibration"):
        Calibration((0.0, 1.0), (1e-5, 1e-5))


def test_other_tables_without_an_inverse_are_refused():
    with pytest.raises(ParameterError, match="reach both ways"):
        measured_calibration([0.0, 1.0], [0.0, 1e-5], 1e-6)
    with pytest.raises(ParameterError, match="expected one above 0"):
        measured_calibration([-1.0, 1.0], [-1e-5, 1e-5], 0.0)
    with pytest.raises(ParameterError, match="3 commands and 2 flows"):
        measured_calibration([-1.0, 0.0, 1.0], [-1e-5, 1e-5], 1e-6)
    with pytest.raises(ParameterError, match="at least 2"):
        Calibration((0.0,), (0.0,))
