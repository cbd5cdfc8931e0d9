"""`vvdp show --json` of every shipped system, and what `vvdp list` finds."""

import json

import pytest
from tests.cli.conftest import vvdp  # noqa: F401

from vvdp.systems.system import shipped_systems


@pytest.mark.parametrize("name", shipped_systems())
def test_every_shipped_system_is_shown_as_json(vvdp, name):  # noqa: F811
    answer = vvdp("show", name, "--json")
    assert answer.code == 0
    shown = json.loads(answer.out)["parameters"]
    assert shown and all(entry["value"] != [] for entry in shown.values())


def test_a_word_lists_what_has_it_in_its_name(vvdp):  # noqa: F811
    listed = json.loads(vvdp("list", "orifice", "--json").out)
    assert [*listed["components"]] == ["orifice", "released-orifice"]
    assert listed["components"]["orifice"]["ports"] == ["a", "b"]
    assert not any(listed[key] for key in ("circuits", "systems", "files", "nodes", "programs", "parts"))
    shown = vvdp("list", "orifice").out
    assert "discharge_coefficient" in shown and "gerotor" not in shown


def test_a_word_that_nothing_has_names_what_is_alike(vvdp):  # noqa: F811
    answer = vvdp("list", "orifce")
    assert answer.code == 2
    assert answer.err == "list: orifce: nothing has this in its name or description; did you mean 'orifice'?\n"


def test_the_page_of_a_type_stands_alone_and_other_names_follow_in_a_line(vvdp):  # noqa: F811
    said = vvdp("list", "pi").out
    assert said.startswith("pi: ") and "integral time" in said
    last = said.strip().splitlines()[-1]
    assert last.startswith("Other names with these letters: ") and "pid" in last and "pipe" in last


def test_a_word_in_no_name_is_looked_for_in_descriptions(vvdp):  # noqa: F811
    found = json.loads(vvdp("list", "controller", "--json").out)
    assert {"pi", "pid"} <= found["programs"].keys() and not found["components"]


def test_the_page_of_a_program_says_how_its_inputs_are_written(vvdp):  # noqa: F811
    inputs, _, values = vvdp("list", "pi").out.partition("Values")
    assert '"NAME.QUANTITY"' in inputs and "is a value, a signal over time" not in values


HELD = """title = "Held pressure"

[nodes]
tank = { type = "tank" }
rail = { type = "volume", volume = "1 L", start = "0 bar" }

[components]
pump = { type = "flow-source", a = "tank", b = "rail", flow = { from = "control.value" } }
load = { type = "orifice", a = "rail", b = "tank", area = "4 mm^2" }

[programs.control]
type = "pi"
period = "1 ms"
reads = "rail.pressure"
reference = "50 bar"
gain = "GAIN"
reset_time = "50 ms"

[run]
until = "0.8 s"
"""


def test_a_gain_has_the_unit_that_the_command_needs(vvdp, tmp_path):  # noqa: F811
    """A flow per pressure makes a flow; one per pressure makes a number, which no source of flow takes."""
    file = tmp_path / "held.toml"
    file.write_text(HELD.replace("GAIN", "0.5 lpm/bar"), "utf-8")
    assert vvdp("show", str(file)).code == 0
    file.write_text(HELD.replace("GAIN", "0.5 1/bar"), "utf-8")
    answer = vvdp("show", str(file))
    assert answer.code == 2
    assert "a program commands a volume flow if its values have such units" in answer.err
