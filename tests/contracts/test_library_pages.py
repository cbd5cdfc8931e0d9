"""Every component and program has an example that runs, a meaning for each word, and a page."""

import json
import re
import sys
import tomllib
from collections.abc import Mapping
from pathlib import Path

import pytest
from tests.cli.conftest import vvdp  # noqa: F401

from vvdp.base.tables import parsed_table
from vvdp.components.library import COMPONENTS
from vvdp.evaluation.summary import summary
from vvdp.programs.library import PROGRAMS
from vvdp.simulation.run import simulate
from vvdp.systems.library_examples import FOLDER, example_text, example_values
from vvdp.systems.library_pages import library_page
from vvdp.systems.system import built_system

TYPES = [*COMPONENTS, *PROGRAMS]
FILES = sorted((FOLDER / "programs").iterdir(), key=lambda file: file.name)


def loaded(text, name):
    return built_system(parsed_table(text, name), name)


def assert_runs(text, name):
    """It reaches its end, and its balances and bounds say that the run can be relied on."""
    system = loaded(text, name)
    run = simulate(system.model, system.case, system.stepping)
    found = summary(system, run)
    assert found["trusted"], name
    assert run.times[-1] == pytest.approx(system.stepping.until)


@pytest.fixture(scope="module")
def pages():
    return {kind: library_page(kind) for kind in TYPES}


@pytest.mark.parametrize("kind", COMPONENTS)
def test_every_listed_example_of_a_component_is_accepted(kind, pages):
    """All of them at once, those with a default included, but for what is said instead of another."""
    page = pages[kind]
    rows = [each for each in (*page.inputs, *page.values) if not each.usual.startswith("instead of")]
    listed = tomllib.loads("\n".join(f"{each.name} = {each.example}" for each in rows))
    assert loaded(example_text(kind, listed), kind).circuit.network.parts
    assert f'type = "{kind}"' in example_text(kind)


def test_every_listed_example_of_a_program_is_in_its_file(pages):
    """A value that must be given has an example from a file that loads; the others have a default."""
    for kind in PROGRAMS:
        used = {*dotted(example_values(kind))}
        assert {each.name for each in pages[kind].values if not each.usual} <= used, kind


def dotted(given, above=""):
    """The keys of a table and of those inside of it."""
    for key, each in given.items():
        yield above + key
        yield from dotted(each, f"{above}{key}.") if isinstance(each, Mapping) else ()


def test_every_listed_input_of_a_program_is_that_of_its_file(pages):
    """No pressure stands as the example of an input of any quantity: `reads = "ram.position"`, unit "any"."""
    for kind in PROGRAMS:
        used = next(each for each in tomllib.loads(pages[kind].example)["programs"].values() if each["type"] == kind)
        for each in (each for each in pages[kind].inputs if each.name in used):
            assert tomllib.loads(f"example = {each.example}")["example"] == used[each.name], (kind, each.name)
    (reads,) = pages["comparator"].inputs
    assert (reads.example, reads.unit) == ('"ram.position"', "any")


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_examples_of_programs_load(file):
    assert loaded(file.read_text("utf-8"), file.name).circuit.network.programs


@pytest.mark.thorough
@pytest.mark.parametrize("kind", COMPONENTS)
def test_examples_of_components_run(kind):
    assert_runs(example_text(kind), kind)


@pytest.mark.thorough
@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_examples_of_programs_run(file):
    assert_runs(file.read_text("utf-8"), file.name)


def test_one_example_runs():
    assert_runs(example_text("relief-valve"), "relief-valve")


def test_every_word_has_a_meaning(pages):
    for kind, page in pages.items():
        without = [each.name for each in (*page.inputs, *page.values, *page.outputs) if not each.meaning]
        assert not without, f"{kind}: add {without} to systems/examples/words.toml or docs/nomenclature.md"


def test_no_word_is_without_use(pages):
    words = tomllib.loads((FOLDER / "words.toml").read_text("utf-8"))
    named = {
        kind: {each.name.rpartition(".")[2] for each in (*p.inputs, *p.values, *p.outputs)} for kind, p in pages.items()
    }
    assert words["words"].keys() <= set().union(*named.values())
    assert all(own.keys() - {"as"} <= named[kind] for kind, own in words["types"].items())


def test_equations_follow_the_calls(pages):
    """The orifice: its law, the passage between two volumes, the flow law of merritt1967."""
    equations = {each.name: each for each in pages["orifice"].equations}
    assert [*equations] == ["orifice", "passage", "orifice_flow"]
    assert equations["orifice_flow"].source.startswith("merritt1967, ch. 3 (root law)")
    assert "cd * area * pressure_drop" in equations["orifice_flow"].text and '"""' not in equations["orifice_flow"].text
    alone = {kind for kind in COMPONENTS if not any(each.source for each in pages[kind].equations)}
    assert alone == {"load-force", "load-torque"}


def test_rules_are_those_of_the_class(pages):
    assert "`lower_end`: less than `upper_end`" in pages["end-stop"].rules
    assert any("20 bar" in each for each in pages["orifice"].warnings)


def test_each_type_has_a_page_of_the_site(pages, root):
    sys.path.insert(0, str(root / "docs/site"))
    import type_pages

    found = type_pages.pages()
    assert {Path(path).stem for path in found} == {*TYPES, "index"}
    relief = found["reference/components/relief-valve.md"]
    assert "<svg" in relief and "| `cracking_pressure` |" in relief and "vvdp new mine --from relief-valve" in relief
    assert "[docs/models/components.md](../../models/components.md)" in relief
    table = (root / "docs/components.md").read_text("utf-8")
    assert "[`relief-valve`](reference/components/relief-valve.md)" in type_pages.linked(table, "components.md")
    assert not re.search(r"\bnan\b|None", relief)


def test_the_command_line_describes_a_type(vvdp, tmp_path, monkeypatch):  # noqa: F811
    monkeypatch.chdir(tmp_path)
    shown = vvdp("list", "orifice").out
    assert all(
        word in shown
        for word in ("Flow and loss of an orifice", "cd * area", "vvdp new NAME --from orifice", "above 20 bar")
    )
    described = json.loads(vvdp("list", "orifice", "--json").out)["described"][0]
    assert described["type"] == "orifice" and described["values"][0]["usual"] == "0.61"
    assert vvdp("new", "mine", "--from", "orifice").code == 0
    assert tomllib.loads(Path("mine.toml").read_text("utf-8"))["components"]["orifice"]["area"] == "5 mm^2"
    assert vvdp("docs", "orifise").err == "orifise: is no component or program; did you mean 'orifice'?\n"


def test_errors_name_the_pages(vvdp, tmp_path, monkeypatch):  # noqa: F811
    monkeypatch.chdir(tmp_path)
    text = example_text("relief-valve").replace('"40 lpm"', '"40 bar"')
    Path("wrong.toml").write_text(text, "utf-8")
    told = vvdp("run", "wrong.toml").err.splitlines()
    assert told[-1] == "values with their meaning, and a file that runs: vvdp list relief-valve"
    assert "components.relief_valve.rated_flow" in told[0]
