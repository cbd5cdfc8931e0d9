"""Studies on finer grids: what is kept of them agrees with itself."""

import re

import numpy as np
import pytest

from vvdp.base.errors import ParameterError
from vvdp.cfd.convergence import LARGEST_IMBALANCE
from vvdp.cfd.kept import kept_studies, kept_study


@pytest.mark.parametrize("name", kept_studies())
def test_every_study_says_how_it_was_made_and_balances(name):
    study = kept_study(name)
    assert study.command.startswith("vvdp cfd ")
    assert "OpenFOAM" in study.provenance
    assert study.rows > 0
    assert "{" not in study.command_of(0)
    if "mass_imbalance" in study.columns:
        assert study["mass_imbalance"].max() < LARGEST_IMBALANCE


@pytest.mark.parametrize("name", [name for name in kept_studies() if "split_1" in kept_study(name).columns])
def test_shares_of_the_flow_are_one(name):
    study = kept_study(name)
    shares = [study[key] for key in study.columns if re.fullmatch(r"split_\d", key)]
    assert np.sum(shares, axis=0) == pytest.approx(np.ones(study.rows), abs=3e-6)


def test_command_of_a_row_holds_its_values():
    study = kept_study("rail-arm")
    assert study.command_of(1) == 'vvdp cfd rail prototype --grid medium --set geometry.nozzle_arm="0.0092 m"'


def test_a_study_that_is_not_kept_is_refused_with_those_that_are():
    with pytest.raises(ParameterError, match=r"no study 'nothing' is kept; expected one of .*rail-arm"):
        kept_study("nothing")
