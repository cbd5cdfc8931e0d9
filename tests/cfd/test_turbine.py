"""`vvdp cfd turbine`: the frame that turns with the spool, torque over speed, and the file it ends in."""

import json
from types import SimpleNamespace

import numpy as np
import pytest
from tests.cfd.conftest import QUALITY, say
from tests.words import wording

from vvdp.cfd import rail
from vvdp.cfd.balance import Torques
from vvdp.cfd.case import Fluid, start_files
from vvdp.cfd.convergence import Judgement
from vvdp.cfd.kept import kept_study
from vvdp.cfd.rail_result import Told
from vvdp.cfd.rotor import rotor_patches
from vvdp.cfd.turbine import TurbineOrder, turbine_case, turned_turbine
from vvdp.cfd.turbine_result import fitted_settings, turbine_result
from vvdp.cfd.turbine_study import TurbineRun
from vvdp.geometry.shape_tables import given_shape
from vvdp.systems.system import load_system
from vvdp.valve.torque import outlet_torque

SPEEDS = (0.0, 75.0, 150.0)


@pytest.fixture(scope="module")
def shaped():
    system = load_system("prototype")
    valve = system.case.params.valve
    return valve, *given_shape(valve, None, [], system.lengths)


@pytest.fixture(scope="module")
def order(shaped) -> TurbineOrder:
    valve, shape, _ = shaped
    return TurbineOrder(valve, shape, Fluid(876.0, 0.0387), 40.0 / 60e3, 0.0, 0.5 * valve.helix_length, 8.0)


@pytest.fixture(scope="module")
def domain(order):
    return turned_turbine(order)


def test_what_does_not_turn_is_named_in_the_frame(order, domain):
    """A patch of the zone that is not named would be taken to turn."""
    case = turbine_case(order._replace(speed=150.0), domain)
    turning = rotor_patches(domain)
    assert set(turning) == {"spool", "chamber", "channels"}
    frame = start_files(case)["constant/MRFProperties"]
    assert "nonRotatingPatches ( inlet outlet collector );" in frame
    assert "omega 150.0;" in frame
    assert set(case.patches) == set(domain.mesh.names)
    velocity = start_files(case)["0/U"]
    assert velocity.count("rotatingWallVelocity") == len(turning)


def test_speeds_are_cases_of_their_own_on_one_mesh(order, domain):
    still, fast = (turbine_case(order._replace(speed=speed), domain) for speed in (0.0, 150.0))
    assert still.identity != fast.identity
    assert still.mesh_files == fast.mesh_files


@pytest.fixture(scope="module")
def result(order, shaped):
    """Of three runs that have never been: a turbine that obeys the law of the system."""
    runs = []
    for speed in SPEEDS:
        solved = SimpleNamespace(
            judgement=Judgement(160, 2.1e5, 300.0, 0.0, 1e-5),
            settled=True,
            quality=QUALITY,
            mesh=SimpleNamespace(cells=33702),
        )
        torque = outlet_torque(order.flow, speed, 876.0, order.valve)
        torques = Torques(torque, 1e-4, 0.97 * torque)
        runs.append(TurbineRun(order._replace(speed=speed), solved, torques, 2.0e4, 1.0))
    return turbine_result(runs, Told("prototype", "coarse", "oil", shaped[2]))


def test_the_law_of_the_system_comes_back(result, order):
    found = {key: each.value for key, each in result.numbers.items()}
    assert found["effective_area_m2"] == pytest.approx(order.valve.outlet_effective_area)
    assert found["torque_slope_N_m_s"] == pytest.approx(found["torque_slope_law_N_m_s"])
    assert found["torque_slope_error_N_m_s"] == pytest.approx(0.0, abs=1e-12)
    assert found["turbine_drop_Pa"] == pytest.approx(1.9e5)
    assert found["momentum_imbalance"] == pytest.approx(0.03)
    ideal = order.valve.outlet_area * np.sqrt(2.0 * 1.9e5 / 876.0)
    assert found["discharge_coefficient"] == pytest.approx(order.flow / ideal)


def test_every_key_of_a_turbine_is_described(result, keys_as_described):
    keys_as_described("cfd turbine", {**result.flat, "out": "results"})


def test_the_fitted_system_has_area_and_coefficient(result):
    valve = load_system("prototype", fitted_settings(result)).case.params.valve
    assert valve.outlet_effective_area == pytest.approx(61.8e-6, rel=1e-5)
    assert valve.outlet_discharge_coefficient == pytest.approx(result.numbers["discharge_coefficient"].value, rel=1e-5)


def test_speeds_that_no_line_goes_through_are_refused(tmp_path):
    said = say("prototype", "--speed", "0 rpm", "1500 rpm", "2", "--out", str(tmp_path / "new"), verb="turbine")
    assert said.code == 2
    assert "--speed: 0 rpm 1500 rpm 2: " + wording.cfd.lower_first in said.err


@pytest.mark.slow
def test_torque_falls_with_the_speed(openfoam, tmp_path, monkeypatch):
    """On the coarsest of three grids, whose drop and torque at rest are kept; the slope is 1.5 times the law's."""
    kept = kept_study("turbine-grids")
    monkeypatch.setattr(rail, "GRIDS", {"coarse": 4.0 * np.sqrt(2.0)})
    words = ("--flow", "40 lpm", "--cores", "1", "--out", str(tmp_path / "turbine"), "--json")
    said = say("prototype", *words, verb="turbine")
    assert said.code == 0, said.err
    told = json.loads(said.out)
    assert told["torque_at_rest_N_m"] == pytest.approx(kept["torque_N_m"][0], rel=0.03)
    assert told["torque_slope_N_m_s"] == pytest.approx(-1.42e-4, rel=0.1)
    assert told["turbine_drop_Pa"] == pytest.approx(kept["pressure_drop_Pa"][0], rel=0.03)
    assert max(told["runs_mass_imbalance"]) < 1e-3
    assert all(told["runs_has_settled"])
    assert (tmp_path / "turbine" / "report.html").is_file()
