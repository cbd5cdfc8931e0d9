"""Studies on finer grids: what is kept of them agrees with itself."""

import json
import re
import shlex

import numpy as np
import pytest
from tests.cfd.conftest import say
from tests.words import wording

from vvdp.base.errors import ParameterError
from vvdp.cfd.convergence import LARGEST_IMBALANCE
from vvdp.cfd.kept import kept_studies, kept_study
from vvdp.cfd.models_result import APPROACHES
from vvdp.fitting.drop import fit_centre
from vvdp.valve.bearing import radial_force


@pytest.mark.parametrize("name", kept_studies())
def test_every_study_says_how_it_was_made_and_balances(name):
    study = kept_study(name)
    assert study.command.startswith("vvdp cfd ")
    assert "OpenFOAM" in study.provenance
    assert study.rows > 0
    assert "{" not in study.command_of(0)
    if "mass_imbalance" in study.columns:
        assert study["mass_imbalance"].max() < LARGEST_IMBALANCE


@pytest.mark.parametrize("name", kept_studies())
def test_every_study_says_by_which_model_and_scheme_and_what_grids_leave_open(name):
    study = kept_study(name)
    assert study.model in ("standard k-epsilon", "laminar", "model by approach")
    assert re.match("first|second|upwind|scheme by approach", study.scheme)
    assert 0.0 < study.grid_index < 0.2
    assert ("approach" in study.columns) == (study.model == "model by approach")


def test_an_index_is_that_of_the_three_grids_of_its_part():
    """The centre section swings, so its spread counts: (367297 - 356095) / 357733 = 3.131 %."""
    assert kept_study("openings").grid_index == pytest.approx((367297.0 - 356095.0) / 357733.0)
    assert kept_study("rail-final-grids").grid_index != kept_study("rail-flows").grid_index


@pytest.mark.parametrize("name", [name for name in kept_studies() if name.endswith("-models")])
def test_models_are_the_four_approaches_with_the_walls_and_residuals_of_each_run(name):
    study = kept_study(name)
    assert tuple(dict.fromkeys(study["approach"].tolist())) == tuple(APPROACHES)
    assert (study["y_plus_least"] < study["y_plus_mean"]).all()
    assert (study["y_plus_mean"] < study["y_plus_largest"]).all()
    assert (study["residual_share"] > 0.0).all()
    assert study["has_settled"].all()


def test_the_first_approach_repeats_the_flows_that_are_kept():
    """At 10 and 60 lpm, on the same mesh, to the digits that are kept and the iteration at which vvdp looked."""
    flows, models = kept_study("rail-flows"), kept_study("rail-models")
    first = models["approach"] == "k-epsilon"
    assert models["pressure_drop_Pa"][first][[0, 2]] == pytest.approx(flows["pressure_drop_Pa"][[0, 3]], rel=1e-4)


@pytest.mark.parametrize("name", [name for name in kept_studies() if "split_1" in kept_study(name).columns])
def test_shares_of_the_flow_are_one(name):
    study = kept_study(name)
    shares = [study[key] for key in study.columns if re.fullmatch(r"split_\d", key)]
    assert np.sum(shares, axis=0) == pytest.approx(np.ones(study.rows), abs=3e-6)


@pytest.mark.parametrize("name", [name for name in kept_studies() if name.endswith("-grids")])
def test_grids_are_finer_by_a_quarter_and_more(name):
    """The background by the root of two, the cells, by the cube root of their number, by a little less."""
    cells = kept_study(name)["cells"]
    assert (np.diff(np.log(cells)) / 3.0 > np.log(1.25)).all()


def test_the_nozzle_with_the_largest_share_is_the_published_one():
    """Table 2.1 of Wang (2017): 1, 2, 1, 1, 2, the smallest in (c) nozzle 2; (d) is decided by 0.3 points there."""
    study = kept_study("rail-designs")
    largest = dict(zip(study["design"], study["largest_nozzle"], strict=True))
    assert {name: largest[name] for name in largest if name != "rail-d"} == {
        "rail-a": 1, "rail-b": 2, "rail-c": 1, "rail-final": 2,
    }  # fmt: skip
    assert study["smallest_nozzle"][2] == 2


def test_radial_forces_are_those_of_the_shares():
    study = kept_study("rail-designs")
    for row in range(study.rows):
        flows = study["flow_m3_s"][row] * np.array([study[f"split_{k}"][row] for k in (1, 2, 3)])
        found = radial_force(flows, np.full(3, 36.5e-6 / 3.0), 876.0)
        assert found == pytest.approx(study["radial_force_N"][row], rel=2e-3, abs=2e-4)


def test_the_drop_of_the_published_flow_lies_between_the_arms():
    """A drop goes with the flow to the power 1.77 (the source's 4.17 bar is at 40 lpm, the study at 41.04 lpm)."""
    study = kept_study("rail-arm")
    drops = study["pressure_drop_Pa"] * (40.0 / 60e3 / study["flow_m3_s"]) ** 1.77
    arm = 8.8e-3 + (4.17e5 - drops[0]) * 0.4e-3 / (drops[1] - drops[0])
    assert arm == pytest.approx(8.74e-3, abs=0.02e-3)


def test_the_centre_section_scales_about_as_published():
    """Wang (2017), section 2.4.2: m = 1.91, n = 3.22, 0.81 bar at 40 lpm; torques within a tenth of eq. 2.6."""
    study = kept_study("centre-flows")
    columns = {"flow": study["flow_m3_s"], "diameter": study["diameter_m"], "pressure_drop": study["static_drop_Pa"]}
    found = fit_centre(columns, None).coefficients
    assert found["exponent"].interval.value == pytest.approx(1.91, abs=0.07)
    assert found["diameter_exponent"].interval.value == pytest.approx(3.22, abs=0.3)
    assert study["static_drop_Pa"][1] == pytest.approx(0.81e5, rel=0.01)
    assert study["torque_N_m"] == pytest.approx(study["torque_law_N_m"], rel=0.08)


def test_the_exponent_of_the_flow_is_the_published_one_on_the_finer_grid():
    """Wang (2017), section 2.4.2: m = 1.91; 2 % of the total drop are a tenth of the static one, 0.05 in m."""
    study = kept_study("centre-flows-medium")
    assert np.polyfit(np.log(study["flow_m3_s"]), np.log(study["static_drop_Pa"]), 1)[0] == pytest.approx(
        1.91, abs=0.05
    )


@pytest.mark.slow
def test_a_row_is_repeated_by_its_command(openfoam, tmp_path):
    study = kept_study("rail-arm")
    words = shlex.split(study.command_of(0))[4:]
    said = say("prototype", *words, "--cores", "1", "--out", str(tmp_path / "row"), "--json", "--no-report")
    assert said.code == 0, said.err
    told = json.loads(said.out)
    assert told["cells"] == pytest.approx(study["cells"][0], rel=0.02)
    assert told["pressure_drop_Pa"] == pytest.approx(study["pressure_drop_Pa"][0], rel=0.01)
    assert told["flow_split"] == pytest.approx([study[f"split_{k}"][0] for k in (1, 2, 3)], abs=2e-3)


def test_command_of_a_row_holds_its_values():
    study = kept_study("rail-arm")
    assert study.command_of(1) == 'vvdp cfd rail prototype --grid medium --set geometry.nozzle_arm="0.0092 m"'


def test_a_study_that_is_not_kept_is_refused_with_those_that_are():
    with pytest.raises(ParameterError, match=wording.cfd.no_study_kept.format(name="nothing") + ".*rail-arm"):
        kept_study("nothing")
