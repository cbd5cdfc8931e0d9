"""docs/design.md names what there is, and its commands are commands."""

import re
import shlex

import pytest

from vvdp.design.problem import problem
from vvdp.design.quantities import KINDS
from vvdp.design.spreads import usual_spreads
from vvdp.design.variables import VARIABLES


@pytest.fixture(scope="module")
def page(root_of_docs):
    return (root_of_docs / "design.md").read_text("utf-8")


def test_every_variable_is_described_with_its_bounds(page):
    rows = dict(re.findall(r"^\| `(\w+)` \| [^|]+ \| ([\d.]+ to [\d.]+)", page, re.MULTILINE))
    assert rows == {name: f"{each.lowest:g} to {each.highest:g}" for name, each in VARIABLES.items()}


def test_every_quantity_is_described_with_its_unit(page):
    rows = dict(re.findall(r"^\| `(\w+)` \| (\S+) \| ", page, re.MULTILINE))
    found = {name: kind.unit for name, kind in KINDS.items() if not name.startswith("pressure_drop_")}
    assert {name: unit for name, unit in rows.items() if name in KINDS and not name.startswith("pressure")} == found
    assert all(f"`{name}`" in page for name in KINDS)


def test_every_spread_is_described(page, prototype):
    assert all(f"`{each.name}`" in page for each in usual_spreads(prototype))


@pytest.mark.thorough
def test_commands_are_commands(page, designing):
    commands = re.findall(r"^    vvdp design (.+)$", page, re.MULTILINE)
    assert len(commands) == 7
    for command in commands:
        words = shlex.split(command)
        quick = {
            "pareto": ["--points", "8", "--generations", "2"],
            "tolerance": ["--samples", "64", "--runs", "16"],
            "temperature": [],
            "levers": ["--no-simulation"],
            "robust": ["--draws", "1", "--designs", "2", "--generations", "1"],
        }
        code, _, err = designing(*words, *quick.get(words[0], ["--starts", "2", "--no-simulation"]))
        assert code == 0, err


def test_the_cycle_of_the_page_can_be_read(page, prototype, tmp_path):
    text = re.search(r"```toml\n(\[\[points\]\].*?)```", page, re.DOTALL)[1]
    file = tmp_path / "cycle.toml"
    file.write_text(text)
    assert [point.weight for point in problem(prototype, "loss_total", cycle=file).points] == [3.0, 1.0]
