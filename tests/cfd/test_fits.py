"""The result and file in which laws that are fitted to computed drops end."""

import json
from types import SimpleNamespace

import numpy as np
import pytest
from tests.cfd.conftest import QUALITY, say
from tests.words import wording

from vvdp.cfd import rail
from vvdp.cfd.case import Fluid
from vvdp.cfd.convergence import History, Judgement
from vvdp.cfd.kept import kept_study
from vvdp.cfd.rail import RailOrder, outlets
from vvdp.cfd.rail_result import Told
from vvdp.cfd.rail_study import RailRun
from vvdp.cfd.sweep_result import fitted_settings, sweep_result
from vvdp.geometry.measure import Mouth
from vvdp.geometry.shape_tables import given_shape
from vvdp.systems.system import load_system

FLOWS = np.array([10.0, 20.0, 40.0, 60.0]) / 60e3


@pytest.fixture(scope="module")
def result():
    """Of four runs that have never been: an orifice of 0.6, with a hundredth of scatter."""
    system = load_system("prototype")
    valve = system.case.params.valve
    shape, rows = given_shape(valve, None, [], system.lengths)
    order = RailOrder(valve, shape, Fluid(876.0, 0.0387), float(FLOWS[0]), 8.0)
    mouths = (Mouth(12.17e-6, 7.94e-6),) * 3
    runs = []
    for flow, scatter in zip(FLOWS, (1.01, 0.99, 1.01, 0.99), strict=True):
        drop = 0.5 * 876.0 * (flow / (0.6 * 36.51e-6)) ** 2 * scatter
        flows = {name: np.full(60, flow / 3.0) for name in outlets(valve)}
        history = History(np.arange(60.0), np.full(60, drop), {"inlet": np.full(60, -flow), **flows})
        solved = SimpleNamespace(
            history=history,
            judgement=Judgement(60, drop, 10.0, 0.0, 1e-5),
            settled=True,
            quality=QUALITY,
            mesh=SimpleNamespace(cells=16256),
        )
        run = RailRun(
            solved=solved,
            mouths=mouths,
            mesh_areas=(12.1e-6,) * 3,
            flows=(flow / 3.0,) * 3,
            volume=12.7e-6,
            seconds=1.0,
        )
        runs.append(run)
    return sweep_result(order, runs, Told("prototype", "coarse", "oil", rows))


def test_the_coefficient_comes_back_within_its_interval(result):
    found = {key: each.value for key, each in result.numbers.items()}
    assert found["discharge_coefficient"] == pytest.approx(0.6, rel=0.01)
    assert found["discharge_coefficient_low"] < found["discharge_coefficient"] < found["discharge_coefficient_high"]
    assert found["flow_exponent"] == pytest.approx(2.0, abs=0.02)
    assert result.tables["sweep"]["point_coefficient"] == pytest.approx([0.6] * 4, rel=0.006)
    assert result.tables["sweep"]["split_1"] == pytest.approx([1 / 3] * 4)


def test_every_key_of_a_sweep_is_described(result, keys_as_described):
    keys_as_described("cfd sweep", {**result.flat, "out": "results"})


def test_the_fitted_system_has_the_coefficient_and_its_origin(result):
    system = load_system("prototype", fitted_settings(result))
    assert system.case.params.valve.nozzle_discharge_coefficient == pytest.approx(0.6, rel=0.01)
    (row,) = [row for row in system.rows if row.key == "nozzle_discharge_coefficient"]
    assert row.status == "derived"
    assert row.note == wording.cfd.fitted_to.format(low="10 lpm", high="60 lpm", model="kEpsilon", cells=16256)


@pytest.mark.parametrize("words", [("10 lpm", "60 lpm", "2"), ("60 lpm", "10 lpm", "4"), ("0 lpm", "10 lpm", "4")])
def test_flows_that_no_law_can_be_fitted_to_are_refused(words, tmp_path):
    said = say("prototype", "--flow", *words, "--out", str(tmp_path / "new"), verb="sweep")
    assert said.code == 2
    assert "--flow: " in said.err
    assert not (tmp_path / "new").exists()


@pytest.mark.slow
def test_a_sweep_is_solved_on_one_mesh_and_its_system_runs(openfoam, tmp_path, monkeypatch):
    """On the coarsest of three grids, whose drop at 40 lpm is kept."""
    monkeypatch.setattr(rail, "GRIDS", {"coarse": 4.0 * np.sqrt(2.0)})
    place = tmp_path / "sweep"
    words = ("--flow", "20 lpm", "60 lpm", "3", "--cores", "1", "--out", str(place), "--json")
    said = say("prototype", *words, verb="sweep")
    assert said.code == 0, said.err
    told = json.loads(said.out)
    assert told["sweep_pressure_drop_Pa"][1] == pytest.approx(kept_study("rail-grids")["pressure_drop_Pa"][0], rel=0.02)
    assert told["flow_exponent"] == pytest.approx(1.8, abs=0.06)
    assert (place / "case" / "log.snappyHexMesh").is_file()
    assert not (place / "case-2" / "log.snappyHexMesh").exists()
    fitted = load_system(str(place / "fitted.toml"))
    coefficient = fitted.case.params.valve.nozzle_discharge_coefficient
    assert coefficient == pytest.approx(told["discharge_coefficient"], rel=1e-5)
    assert (place / "report.html").is_file()
