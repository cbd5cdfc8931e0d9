"""`vvdp cfd openings`: effective openings and the jets' law from runs whose law is known."""

import math
from types import SimpleNamespace

import pytest
from tests.cfd.conftest import QUALITY, say
from tests.words import wording

from vvdp.cfd.case import Fluid
from vvdp.cfd.centre import CentreOrder
from vvdp.cfd.centre_study import CentreRun
from vvdp.cfd.convergence import Judgement
from vvdp.cfd.openings_result import both_ways, openings_result
from vvdp.cfd.rail_result import Told
from vvdp.geometry.shape_tables import given_shape
from vvdp.systems.system import load_system
from vvdp.valve.geometry import jet_skews, port_openings, port_shape
from vvdp.valve.torque import inlet_torque

ANGLES = [math.radians(16.5), math.radians(21.0)]


@pytest.fixture(scope="module")
def result():
    """Of runs that have never been: the system's law of the torque, and an effective area a tenth off while closing."""
    system = load_system("prototype")
    valve = system.case.params.valve
    shape, rows = given_shape(valve, None, [], system.lengths)
    order = CentreOrder(valve, shape, Fluid(876.0, 0.0387), 40.0 / 60e3, 0.0, 0.5 * valve.helix_length, 8.0)
    runs = []
    for angle in both_ways(ANGLES):
        opening = port_openings(angle, order.position, valve).load
        skew = jet_skews(angle, order.position, valve.jet_asymmetry, port_shape(valve)).load
        torque = inlet_torque(order.flow / opening, opening, 876.0, valve, skew)
        drop = 0.5 * 876.0 * (order.flow / (22e-6 * opening * (0.9 if angle > 0.0 else 1.0))) ** 2
        solved = SimpleNamespace(
            judgement=Judgement(160, drop, 300.0, 0.0, 1e-5),
            settled=True,
            quality=QUALITY,
            mesh=SimpleNamespace(cells=22765),
        )
        runs.append(CentreRun(order._replace(angle=angle), solved, torque, 27.5e-6, 1.0))
    return openings_result(runs, Told("prototype", "coarse", "oil", rows))


def test_open_nozzles_come_first_then_each_angle_both_ways():
    assert both_ways([0.1, 0.2]) == (0.0, 0.1, -0.1, 0.2, -0.2)


def test_openings_by_formula_are_three_quarters_and_a_half(result):
    """About, as the angles are rounded: the ramp is 18 deg long, from 12 to 30 deg."""
    assert result.tables["angles"]["opening_formula"] == pytest.approx([1.0, 0.75, 0.75, 0.5, 0.5], abs=3e-4)


def test_the_law_of_the_system_comes_back(result):
    found = {key: each.value for key, each in result.numbers.items()}
    assert found["open_area_m2"] == pytest.approx(22e-6)
    assert found["closing_difference"] == pytest.approx(-0.1)
    assert found["opening_difference"] == pytest.approx(0.0, abs=1e-9)
    assert found["jet_exponent"] == pytest.approx(found["jet_exponent_law"], rel=1e-6)
    assert found["jet_asymmetry"] == pytest.approx(found["jet_asymmetry_law"], rel=1e-6)
    table = result.tables["angles"]
    assert table["torque_law_N_m"] == pytest.approx(table["torque_N_m"])


def test_every_key_of_the_openings_is_described(result, keys_as_described):
    keys_as_described("cfd openings", {**result.flat, "out": "results"})


@pytest.mark.parametrize("angles", [("--angle", "16 deg"), ("--angle", "0 deg", "--angle", "10 deg")])
def test_angles_that_no_law_can_be_fitted_to_are_refused(angles, tmp_path):
    said = say("prototype", *angles, "--out", str(tmp_path / "new"), verb="openings")
    assert said.code == 2
    assert wording.cfd.different_values in said.err
