"""The whole machine with everything off nominal, as the shipped study has it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from vvdp.studies.run import run_study
from vvdp.studies.study import load_study

pytestmark = pytest.mark.heavy

STUDY = Path(__file__).parents[3] / "docs" / "whole-machine-spread.toml"
UNSEEN = 7
"""A seed at which no limit of the supervision was chosen."""


def drawn(count: int, seed: int, until: str | None = None):
    study = load_study(STUDY)
    return replace(study, variations=replace(study.variations, count=count, seed=seed), until=until)


@pytest.mark.thorough
def test_the_study_runs_as_it_stands(tmp_path):
    found = run_study(drawn(2, 1, "0.2 s"), tmp_path / "kept")
    assert found.is_finished
    assert not found.failures
    assert np.all(found.outputs["alarm"].values == 0.0)
    assert np.all(np.abs(found.outputs["energy_residual"].values) < 1e-6)


@pytest.mark.slow
def test_most_draws_follow_the_triangle_and_none_empties_a_chamber(tmp_path):
    found = run_study(drawn(200, UNSEEN), tmp_path / "kept")
    assert found.is_finished
    assert not found.failures
    error, lowest = (found.outputs[key].values for key in ("tracking_error_max_m", "pressure_min_Pa"))
    assert np.mean(error < 5e-3) > 0.85
    assert np.nanmin(lowest) > 0.0
    assert np.nanmax(np.abs(found.outputs["energy_residual"].values)) < 1e-6
