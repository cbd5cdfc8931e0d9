"""`vvdp cfd designs`: the force that an uneven split leaves, and shapes computed side by side."""

import json
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from tests.cfd.conftest import say
from tests.words import wording

import vvdp.cfd
from vvdp.cfd import rail
from vvdp.valve.bearing import radial_force

PUBLISHED = {"rail-a": 1, "rail-b": 2, "rail-c": 1, "rail-final": 2}
"""Of each design of table 2.1 in Wang (2017) the nozzle with the largest share; (d) is decided by 0.3 points there."""


def test_radial_force_of_one_jet_is_its_momentum_and_that_of_equal_jets_is_nothing():
    openings = np.full(3, 12e-6)
    assert radial_force(np.array([3e-4, 0.0, 0.0]), openings, 876.0) == pytest.approx(876.0 * 9e-8 / 12e-6)
    assert radial_force(np.full(3, 2e-4), openings, 876.0) == pytest.approx(0.0, abs=1e-12)


def test_radial_force_turns_with_the_nozzles():
    openings, flows = np.array([12e-6, 11e-6, 13e-6]), np.array([2e-4, 2.5e-4, 1.8e-4])
    around = [radial_force(np.roll(flows, k), np.roll(openings, k), 876.0) for k in range(3)]
    assert around == pytest.approx([around[0]] * 3)


def test_radial_force_of_the_published_final_split_by_hand():
    """Shares 31.0, 38.6, 30.4 % of 40 lpm through 12.167 mm2 each: 32.0 N times 0.1490 - (0.0961 + 0.0924) / 2, and a
    little for the difference of the other two."""
    shares, opening = np.array([0.310, 0.386, 0.304]), 36.5e-6 / 3.0
    scale = 876.0 * (40.0 / 60e3) ** 2 / opening
    across = 0.5 * np.sqrt(3.0) * (shares[0] ** 2 - shares[2] ** 2)
    along = shares[1] ** 2 - 0.5 * (shares[0] ** 2 + shares[2] ** 2)
    found = radial_force(shares * 40.0 / 60e3, np.full(3, opening), 876.0)
    assert found == pytest.approx(scale * np.hypot(along, across))
    assert found == pytest.approx(1.75, rel=0.01)


def test_one_shape_alone_is_refused(openfoam):
    said = say("prototype", "--shape", "rail-a", verb="designs")
    assert said.code == 2
    assert "--shape: rail-a: " + wording.cfd.different_shapes in said.err


@pytest.mark.slow
def test_five_shapes_divide_the_flow_as_published(openfoam, monkeypatch, tmp_path):
    monkeypatch.setattr(rail, "GRIDS", {"coarse": 5.0})
    said = say("prototype", "--flow", "40 lpm", "--out", str(tmp_path / "designs"), "--json", verb="designs")
    assert said.code == 0, said.err
    told = json.loads(said.out)
    largest = dict(zip(told["design"], told["largest_nozzle"], strict=True))
    assert {name: largest[name] for name in ("rail-b", "rail-final")} == {"rail-b": 2, "rail-final": 2}
    assert told["drop_change"][0] == 0.0
    assert (tmp_path / "designs" / "report.html").is_file()


@pytest.mark.parametrize("name", sorted(path.stem for path in Path(vvdp.cfd.__path__[0]).glob("*_result.py")))
def test_every_result_tells_the_density_that_the_picture_of_its_section_needs(name):
    module = import_module(f"vvdp.cfd.{name}")
    assert any(isinstance(each, Mapping) and "density_kg_m3" in each for each in vars(module).values())
