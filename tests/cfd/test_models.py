"""Models of turbulence side by side: laws of drop and torque, and their range."""

from types import SimpleNamespace

import numpy as np
import pytest
from tests.cfd.conftest import QUALITY, say

from vvdp.base.kinds import PRESSURE_DIFFERENCE, TORQUE
from vvdp.cfd.case import Fluid
from vvdp.cfd.convergence import Judgement
from vvdp.cfd.grids_result import OnGrids
from vvdp.cfd.models_result import APPROACHES, models_result
from vvdp.cfd.rail import RailOrder
from vvdp.cfd.rail_result import Told
from vvdp.geometry.shape_tables import given_shape
from vvdp.numerics.square_law import square_law
from vvdp.results.result import Column, Listing
from vvdp.systems.system import load_system

FLOWS = (2e-4, 4e-4, 8e-4)
SHARES = (1.0, 1.1, 0.9, 0.8)
EXPONENTS = (2.0, 2.0, 2.0, 1.8)


def test_a_square_is_found_by_hand():
    """(1, 5, 16) at (1, 2, 4): c = (1 + 4 * 5 + 16 * 16) / (1 + 16 + 256) = 277/273; m = ln 16 / ln 4 = 2."""
    found = square_law(np.array([1.0, 2.0, 4.0]), np.array([1.0, 5.0, 16.0]))
    assert found.coefficient == pytest.approx(277.0 / 273.0)
    assert found.exponent == pytest.approx(2.0)


def test_no_power_is_fitted_to_a_drop_below_zero():
    assert np.isnan(square_law(np.array([1.0, 2.0]), np.array([-1.0, 4.0])).exponent)


@pytest.fixture(scope="module")
def result():
    """Four approaches whose drops are shares of that of the first, the last with another exponent."""
    system = load_system("prototype")
    valve = system.case.params.valve
    shape, rows = given_shape(valve, None, [], system.lengths)
    flows = np.array(FLOWS)
    drops = np.concatenate([4e5 * share * (flows / 8e-4) ** m for share, m in zip(SHARES, EXPONENTS, strict=True)])
    solved = [
        SimpleNamespace(
            judgement=Judgement(160, drop, 10.0, 0.0, 1e-5),
            settled=True,
            quality=QUALITY,
            mesh=SimpleNamespace(cells=1000),
            took=1.0,
        )
        for drop in drops
    ]
    columns = {
        "pressure_drop_Pa": Column(drops, PRESSURE_DIFFERENCE, "pressure drop"),
        "torque_N_m": Column(1e-6 * drops, TORQUE, "torque"),
    }
    part = OnGrids("The part", "", solved, columns, ((), ""), ("", Listing(title="", heads=("value",), rows=())))
    order = RailOrder(valve, shape, Fluid(876.0, 0.0387), 4e-4, 8.0)
    return models_result(order, part, FLOWS, Told("prototype", "coarse", "oil", rows))


def test_ratios_and_exponents_come_back(result):
    """c of 0.8 Q^1.8 on (1/4, 1/2, 1): (4^-3.8 + 2^-3.8 + 1) / (4^-4 + 2^-4 + 1) = 1.00988 of 0.8."""
    ratio = 0.8 * (4.0**-3.8 + 2.0**-3.8 + 1.0) / (4.0**-4 + 2.0**-4 + 1.0)
    assert ratio == pytest.approx(0.80791, abs=1e-5)
    laws = result.tables["laws"]
    assert laws["drop_ratio"] == pytest.approx([1.0, 1.1, 0.9, ratio])
    assert laws["drop_exponent"] == pytest.approx(EXPONENTS)
    assert result.numbers["torque_ratio_low"].value == pytest.approx(ratio)
    assert result.numbers["drop_ratio_high"].value == pytest.approx(1.1)
    assert result.numbers["drop_exponent_low"].value == pytest.approx(1.8)


def test_a_residual_above_its_criterion_is_told_and_is_no_warning(result):
    told = [each.text for each in result.findings]
    assert any(text.startswith("U 0.0020 (criterion 0.001). ") for text in told)
    assert result.flat["warnings"] == []


def test_walls_and_residuals_are_listed_for_every_run(result):
    walls, residuals = result.listings["walls"], result.listings["residuals"]
    assert len(walls.rows) == len(FLOWS) * len(APPROACHES)
    assert walls.rows[0].values == (0.5, 4.0, 14.0)
    assert [row.values for row in residuals.rows[:2]] == [(2e-3, 1e-3), (5e-3, 1e-2)]


def test_the_first_approach_is_that_of_all_other_studies():
    first, *others = APPROACHES.values()
    assert first == (RailOrder._field_defaults["turbulence"], RailOrder._field_defaults["phases"])
    assert len({*APPROACHES.values()}) == 4
    assert sum(each.phases[-1].order == "first order" for each in others) == 1


def test_every_key_of_the_models_is_described(result, keys_as_described):
    keys_as_described("cfd models", {**result.flat, "out": "results"})


@pytest.mark.slow
def test_a_small_rail_by_every_approach(openfoam, tmp_path):
    words = ("--grid", "4", "--flow", "20 lpm", "60 lpm", "3", "--cores", "1", "--out", str(tmp_path / "models"))
    said = say("prototype", *words, "--json", verb="models")
    assert said.code == 0, said.err
    assert (tmp_path / "models" / "report.html").is_file()
