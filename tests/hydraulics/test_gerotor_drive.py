"""The gerotor drive's map, its inverse, calibrations that are refused, ends and effort."""

import numpy as np
import pytest

from vvdp.base.errors import ParameterError
from vvdp.hydraulics.gerotor_drive import (
    GerotorBelief,
    GerotorCalibration,
    GerotorDrive,
    GerotorMap,
    GerotorState,
    calibrated_command,
    calibrated_flow,
    gerotor_command,
    gerotor_effort,
    gerotor_ends,
    gerotor_flow,
    gerotor_rate,
)

MAP = {"largest_flow": 3e-5, "forward_dead_band": 0.06, "backward_dead_band": 0.08, "backward_gain": 0.9}
CALIBRATION = GerotorCalibration(commands=(-1.0, -0.08, 0.06, 0.5, 1.0), flows=(-2.7e-5, 0.0, 0.0, 1e-5, 3e-5))


@pytest.fixture(scope="module")
def drive():
    return GerotorDrive(
        area=5.067e-4, lag=10e-3, conductance=1.1e-10, viscous_friction=8.3, lower_end=-6.2e-3, upper_end=27e-3
    )


@pytest.mark.parametrize(
    ("command", "flow"),
    [
        (0.06, 0.0),
        (-0.08, 0.0),
        (0.0, 0.0),
        (0.53, 1.5e-5),
        (1.0, 3e-5),
        (1.7, 3e-5),
        (-0.54, -1.35e-5),
        (-1.0, -2.7e-5),
    ],
)
def test_map_by_hand(command, flow):
    """Half way between dead band and full command, half of the flow; nothing within, no more beyond."""
    assert gerotor_flow(command, GerotorMap(**MAP)) == pytest.approx(flow, abs=1e-18)


def test_belief_inverts_the_map_but_where_the_flow_is_small():
    belief = GerotorBelief(**MAP, straight_flow=1e-6)
    for flow in (*np.linspace(1e-6, 3e-5, 30), *np.linspace(-2.7e-5, -1e-6, 30)):
        assert gerotor_flow(gerotor_command(flow, belief), belief) == pytest.approx(flow, rel=1e-12)
    small = [gerotor_command(flow, belief) for flow in (0.0, 5e-7, 1e-6, -5e-7, -1e-6)]
    assert small[0] == 0.0
    assert small[1] == pytest.approx(0.5 * small[2])
    assert small[3] == pytest.approx(0.5 * small[4])
    assert gerotor_command(1.0, belief) == 1.0
    assert gerotor_command(-1.0, belief) == -1.0


def test_calibration_goes_through_its_rows_and_back():
    for command, flow in zip(CALIBRATION.commands, CALIBRATION.flows, strict=True):
        assert calibrated_flow(command, CALIBRATION) == pytest.approx(flow, abs=1e-18)
    assert calibrated_flow(0.75, CALIBRATION) == pytest.approx(2e-5)
    for flow in (*np.linspace(-2.7e-5, -1e-7, 20), *np.linspace(1e-7, 3e-5, 20)):
        assert calibrated_flow(calibrated_command(flow, CALIBRATION), CALIBRATION) == pytest.approx(flow, rel=1e-12)
    assert calibrated_command(0.0, CALIBRATION) == 0.0
    assert calibrated_command(1e-20, CALIBRATION) == pytest.approx(0.06)
    assert calibrated_command(-1e-20, CALIBRATION) == pytest.approx(-0.08)


@pytest.mark.parametrize(
    ("commands", "flows", "told"),
    [
        ((-1.0, 0.0, 1.0), (-1e-5, 1e-6, 0.0), r"flows: row 3, 0 lpm, must be at least row 2, 0.06 lpm"),
        ((-1.0, 0.5, 0.5), (-1e-5, 0.0, 1e-5), r"commands: row 3, 0.5, must be greater than row 2, 0.5"),
        ((-1.0, 1.0), (0.0,), "flows: 1 rows for 2 commands"),
    ],
)
def test_calibration_that_is_not_monotone_is_refused_with_its_row(commands, flows, told):
    with pytest.raises(ParameterError, match=told):
        GerotorCalibration(commands=commands, flows=flows)


def test_rate_of_the_spool_is_flow_over_area(drive):
    rate = gerotor_rate(3e-5, GerotorState(1e-5, 0.0), 0.0, 0.0, drive)
    assert rate.flow == pytest.approx(2e-5 / 10e-3)
    assert rate.position == pytest.approx(1e-5 / 5.067e-4)
    assert gerotor_rate(3e-5, GerotorState(1e-5, 0.027), 0.0, 1.0, drive).position == 0.0


def test_an_end_holds_until_the_flow_turns_round(drive):
    def upper(flow, position, held):
        return np.floor(gerotor_ends(GerotorState(flow, position), 0.0, held, drive).upper)

    assert upper(1e-5, 0.020, 0.0) == 0.0
    assert upper(1e-5, 0.028, 0.0) == 1.0
    assert upper(1e-5, 0.027 - 1e-12, 1.0) == 1.0
    assert upper(-1e-5, 0.027, 1.0) == 0.0
    assert np.floor(gerotor_ends(GerotorState(-1e-5, -0.007), 0.0, 0.0, drive).lower) == 1.0


def test_effort_stays_below_what_the_source_says(drive):
    """At the largest flow: less than 40 psi (2.76 bar) and 200 W; the drop times the flow is all that is lost."""
    effort = gerotor_effort(3e-5, 3e-5 / drive.area, drive)
    assert effort.pressure_difference < 2.76e5
    assert effort.pressure_difference * 3e-5 == pytest.approx(effort.passages + effort.friction)
    assert effort.passages + effort.friction < 200.0
