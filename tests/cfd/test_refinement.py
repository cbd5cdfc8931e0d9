"""What three grids tell: order and extrapolation of values whose law is known, and the result of a rail."""

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest
from tests.cfd.conftest import QUALITY, say
from tests.words import wording

from vvdp.base.errors import ParameterError
from vvdp.cfd import rail
from vvdp.cfd.case import Fluid
from vvdp.cfd.convergence import History, Judgement
from vvdp.cfd.grids_result import grids_result, rail_on_grids
from vvdp.cfd.rail import RailOrder, outlets, three_grids
from vvdp.cfd.rail_result import Told
from vvdp.cfd.rail_study import RailRun
from vvdp.cfd.refinement import grid_convergence
from vvdp.geometry.measure import Mouth
from vvdp.geometry.shape_tables import given_shape
from vvdp.systems.system import load_system


@pytest.mark.parametrize("sizes", [(1.0, 2.0, 4.0), (1.0, 1.4, 1.96), (0.7, 1.0, 1.6)])
@pytest.mark.parametrize("order", [1.0, 1.7, 2.0])
@pytest.mark.parametrize("slope", [0.3, -0.3])
def test_an_error_that_is_a_power_of_the_size_is_found_exactly(sizes, order, slope):
    values = tuple(5.0 + slope * size**order for size in sizes)
    found = grid_convergence(sizes, values)
    assert found.order == pytest.approx(order, rel=1e-6)
    assert found.extrapolated == pytest.approx(5.0, rel=1e-9)
    assert found.is_monotone
    assert found.band == pytest.approx(1.25 * abs(5.0 / values[0] - 1.0), rel=1e-6)


def test_a_published_example():
    """Celik and others, table 1, first column: phi 6.063, 5.972, 5.863; r 1.5 and 1.333; p 1.53, GCI 2.2 %."""
    found = grid_convergence((1.0, 1.5, 2.0), (6.063, 5.972, 5.863))
    assert found.order == pytest.approx(1.53, abs=0.01)
    assert found.extrapolated == pytest.approx(6.1685, abs=1e-3)
    assert found.band == pytest.approx(0.022, abs=5e-4)


def test_an_order_above_that_of_the_schemes_is_not_believed():
    """Steps of 0.8 and 0.1 are of third order; at second 1.25 * (0.1/5) / (4 - 1), and 5 + 0.1/3 without cells."""
    found = grid_convergence((1.0, 2.0, 4.0), (5.0, 4.9, 4.1))
    assert found.order == pytest.approx(3.0)
    assert found.band == pytest.approx(0.025 / 3.0)
    assert found.extrapolated == pytest.approx(5.0 + 0.1 / 3.0)


def test_values_that_swing_are_told_as_such():
    found = grid_convergence((1.0, 1.4, 1.96), (2.226, 2.177, 2.195))
    assert not found.is_monotone
    assert found.spread == pytest.approx(0.049 / 2.226)


def test_values_that_drift_apart_have_no_order():
    """The index is that of first order: 1.25 * (1/5) / (2 - 1)."""
    found = grid_convergence((1.0, 2.0, 4.0), (5.0, 4.0, 3.9))
    assert math.isnan(found.order)
    assert math.isnan(found.extrapolated)
    assert found.band == pytest.approx(0.25)
    assert grid_convergence((1.0, 2.0, 4.0), (5.0, 5.0, 5.0)).band == 0.0


def test_a_value_that_only_the_finest_grid_changes_is_not_converged():
    """1.25 * (0.1/5) / (2 - 1), as of values that drift apart; not 0."""
    found = grid_convergence((1.0, 2.0, 4.0), (5.0, 4.9, 4.9))
    assert found.band == pytest.approx(0.025)
    assert math.isnan(found.order) and found.is_monotone


def test_grids_out_of_order_are_refused():
    with pytest.raises(ParameterError, match=wording.cfd.finest_first):
        grid_convergence((4.0, 2.0, 1.0), (1.0, 2.0, 3.0))


def rail_run(solved) -> RailRun:
    return RailRun(
        solved=solved,
        mouths=(Mouth(12.17e-6, 7.94e-6),) * 3,
        mesh_areas=(12.1e-6,) * 3,
        flows=(4e-4 / 3.0,) * 3,
        volume=12.7e-6,
        seconds=1.0,
    )


@pytest.fixture(scope="module")
def result():
    """Of three runs that have never been: cells halved in size, an error of the first order."""
    system = load_system("prototype")
    valve = system.case.params.valve
    shape, rows = given_shape(valve, None, [], system.lengths)
    order = RailOrder(valve, shape, Fluid(876.0, 0.0387), 4e-4, 8.0)
    runs = []
    for cells in (1000, 8000, 64000):
        drop = 4e5 * (1.0 - 1.0 / np.cbrt(cells))
        flows = {name: np.full(60, 4e-4 / 3.0) for name in outlets(valve)}
        solved = SimpleNamespace(
            history=History(np.arange(60.0), np.full(60, drop), flows),
            judgement=Judgement(160, drop, 10.0, 0.0, 1e-5),
            settled=True,
            quality=QUALITY,
            mesh=SimpleNamespace(cells=cells),
            seconds={"second order": 1.0},
        )
        runs.append(rail_run(solved))
    about = Told("prototype", "coarse", "oil", rows)
    return grids_result(order, rail_on_grids(runs, about), ("coarse", "medium", "fine"), about)


def test_three_grids_of_the_family_end_with_the_finest():
    assert list(three_grids(16.0)) == ["coarse", "medium", "fine"]
    assert three_grids(8.0) == pytest.approx({"R/4": 4.0, "R/5.66": 4.0 * math.sqrt(2.0), "coarse": 8.0})


def test_the_drop_is_extrapolated(result):
    assert result.numbers["observed_order"].value == pytest.approx(1.0)
    assert result.numbers["pressure_drop_extrapolated_Pa"].value == pytest.approx(4e5)
    assert result.numbers["grid_convergence_index"].value == pytest.approx(1.25 * (1.0 / 0.975 - 1.0))


def test_every_key_of_the_grids_is_described(result, keys_as_described):
    keys_as_described("cfd grids", {**result.flat, "out": "results"})


@pytest.mark.slow
def test_three_small_grids_are_meshed_and_solved(openfoam, tmp_path, monkeypatch):
    monkeypatch.setattr(rail, "GRIDS", {"small": 6.4})
    words = ("--grid", "small", "--flow", "40 lpm", "--cores", "1", "--out", str(tmp_path / "grids"), "--json")
    said = say("prototype", *words, verb="grids")
    assert said.code == 0, said.err
    told = json.loads(said.out)
    assert told["grid"] == ["R/3.2", "R/4.53", "small"]
    assert told["cells"] == sorted(told["cells"])
    assert (tmp_path / "grids" / "case-3" / "log.snappyHexMesh").is_file()
    assert (tmp_path / "grids" / "report.html").is_file()
