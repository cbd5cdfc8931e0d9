"""Killed at any instant and called again, a command gives the result to the last bit that it gives when left alone."""

import functools
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.resuming.kills import Verb, carried_out, content, kill_again_and_again, timeless

STUDY = """
title = "Cases"
system = "prototype-constant-load"
until = "0.05 s"
outputs = ["pwm_frequency_Hz", "efficiency"]
[random]
count = 24
seed = 3
[random.spreads]
"oil.air_fraction" = { uniform = ["0.5 %", "2 %"] }
"""
CONSTANT = "prototype-constant-load"
SMALL = ("--duty", "0.4", "0.8", "3", "--pressure", "40 bar", "80 bar", "2")
QUICK = ("--estimator", "inverse-time", "--estimator", "m-over-t", "--scenario", "constant", "--seeds", "2")
LAST = ("--out", "out", "--no-report")
VERBS = {
    "study": Verb(("study", "../study.toml", *LAST[:2]), 0.5, True, "out/cases-*.json"),
    "map": Verb(("map", CONSTANT, *SMALL, *LAST), 0.5, True, "out/points/cases-*.json"),
    "run": Verb(("run", CONSTANT, "--until", "0.1 s", *LAST[:2]), 1.5),
    "rig": Verb(("rig", "pressure-drop", CONSTANT, *LAST[:2]), 1.0),
    "estimate": Verb(("estimate", "../edges.csv", "--edges", "edge", "--sectors", "8", *LAST), 0.3),
    "design": Verb(("design", "optimum", "prototype", "--starts", "1", "--no-simulation", *LAST), 6.0),
    "compare": Verb(("compare", "estimators", *QUICK, *LAST), 3.0),
    "reproduce": Verb(("reproduce", "3.9", *LAST), 3.0),
    "cfd": Verb(("cfd", "rail", "prototype", "--grid", "5", "--cores", "1", *LAST), 20.0, True),
}


def prepared(above: Path) -> Path:
    """A folder in which commands write `out`; a log and a study lie above it."""
    edges = 0.2 + np.arange(600) * (np.pi / 4.0) / (2.0 * np.pi * 24.7)
    (above / "edges.csv").write_text("edge [s]\n" + "\n".join(f"{t:.9g}" for t in edges) + "\n")
    (above / "study.toml").write_text(STUDY)
    folder = above / "place"
    folder.mkdir()
    return folder


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], dict[str, Any]]:
    """What each command gives when it is left alone, by its name."""

    @functools.cache
    def alone(name: str) -> dict[str, Any]:
        folder = prepared(tmp_path_factory.mktemp(name))
        return carried_out(VERBS[name], folder)

    return alone


SUITE = [("study", 1, 3), ("map", 2, 3)]
MANY = [
    ("study", 1, 10),
    ("map", 2, 10),
    *(("study", seed, 10) for seed in range(3, 9)),
    *(("map", seed, 10) for seed in range(9, 13)),
    *((name, seed, 10) for name in ("estimate", "design", "compare", "reproduce") for seed in (13, 14)),
    *((name, 20, 10) for name in ("run", "rig")),
    *(("cfd", seed, 5) for seed in range(15, 19)),
]


@pytest.mark.parametrize(
    ("name", "seed", "kills"), [*SUITE, *(pytest.param(*each, marks=pytest.mark.slow) for each in MANY)]
)  # fmt: skip
def test_killed_again_and_again(whole, tmp_path, name, seed, kills):
    for found in kill_again_and_again(VERBS[name], prepared(tmp_path), seed, kills):
        assert found.keys() == whole(name).keys()
        for file, held in found.items():
            assert held == whole(name)[file], file


def test_a_number_that_differs_is_seen_in_any_batch(tmp_path):
    """Else none of the above could fail."""

    def kept(**batches: float) -> dict[str, Any]:
        for name, value in batches.items():
            cases = [{"key": name, "summary": {"loss_W": value, "wall_time_s": np.random.default_rng().random()}}]
            (tmp_path / f"cases-{name}.json").write_text(json.dumps({"cases": cases}))
        return content(tmp_path)

    assert kept(one=1.0, two=2.0) == kept(one=1.0) != kept(two=2.0 + 1e-15)


def test_times_are_left_out_and_nothing_else():
    assert timeless({"a": [{"seconds": 1.0, "b": 2.0}], "written": "x"}) == {"a": [{"b": 2.0}]}
