"""The circuits from practice: each is to be trusted, and shows what docs/practice.md says, by hand and by its run."""

import re
from functools import cache
from pathlib import Path

import pytest
from tests.systems.practice_by_hand import BY_HAND, Course

from vvdp.evaluation.overview import warnings
from vvdp.evaluation.summary import summary
from vvdp.network.nodes import HydraulicNode
from vvdp.report.circuit import graph_of
from vvdp.report.diagram import diagram
from vvdp.simulation.run import simulate
from vvdp.systems.system import load_system, shipped_systems

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "practice.md").read_text("utf-8")


@cache
def done(name: str, *settings: str) -> Course:
    """A circuit, run with settings; the same one is run once."""
    system = load_system(name, settings)
    run = simulate(system.model, system.case, system.stepping)
    nodes = [each for each, node in system.circuit.network.nodes.items() if isinstance(node, HydraulicNode)]
    return Course(run, summary(system, run), nodes)


def test_each_has_numbers_by_hand():
    assert {*BY_HAND} == {*shipped_systems("practice")}


@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", BY_HAND)
def test_it_is_to_be_trusted_without_a_warning(name):
    system, found = load_system(name), done(name).found
    assert found["trusted"] and found["finished"] and found["within_validity"]
    assert max(abs(found["energy_residual"]), abs(found["mass_residual"])) < 1e-8
    assert abs(found.get("heat_residual", 0.0)) < 1e-8
    assert list(warnings(system, found)) == []
    assert [row.key for row in system.rows if row.status == "given" and row.table != "run"] == []


@pytest.mark.parametrize("name", BY_HAND)
def test_numbers_are_those_by_hand_and_those_of_the_page(name):
    section = PAGE.partition(f"\n## `{name}`\n")[2].partition("\n## ")[0]
    assert f"vvdp run {name}" in section
    numbers = BY_HAND[name](done(name))
    for label, (by_hand, found, within) in numbers.items():
        print(f"| {label} | {by_hand:.4g} | {found:.4g} |", within, found / by_hand - 1.0)
    for label, (by_hand, found, within) in numbers.items():
        assert found == pytest.approx(by_hand, rel=within), label
    rows = re.findall(r"^\| ([^|]+) \| ([\d.]+) \| ([\d.]+) \|$", section, re.MULTILINE)
    assert [label for label, *_ in rows] == list(numbers)
    for label, *texts in rows:
        for text, number in zip(texts, numbers[label], strict=False):
            assert float(text) == pytest.approx(number, abs=0.501 * 10.0 ** -len(text.partition(".")[2])), label


@pytest.mark.parametrize("name", BY_HAND)
def test_its_picture_is_its_diagram(name):
    system = load_system(name)
    kept = DOCS / "images" / "systems" / f"{name}.svg"
    assert diagram(graph_of(system.circuit.network, system.title)) == kept.read_text("utf-8")
