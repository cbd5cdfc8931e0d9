"""What the site makes from the code: the gallery, docstrings as Markdown, notebooks as pages."""

import json
import re
from pathlib import Path

import pytest

from vvdp.systems.system import shipped_systems

pytestmark = pytest.mark.heavy

DOCS = Path(__file__).parents[2] / "docs"
NUMBER = re.compile(r"(?<=\| )-?[\d.]+(?= \S+ \|)")
ANY_NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e-?\d+)?")


@pytest.mark.thorough
def test_the_gallery_is_what_its_command_writes(tmp_path):
    """To the letter but for the numbers, which may differ in their last digit on another machine."""
    import gallery

    gallery.main(tmp_path)
    made, kept = ((folder / "gallery.md").read_text("utf-8") for folder in (tmp_path, DOCS))
    assert NUMBER.sub("~", made) == NUMBER.sub("~", kept)
    numbers = [[float(each) for each in NUMBER.findall(text)] for text in (made, kept)]
    assert numbers[0] == pytest.approx(numbers[1], rel=2e-3)
    assert len(numbers[0]) == 3 * len(shipped_systems())
    for name in shipped_systems():
        picture = gallery.PICTURES / f"{name}.svg"
        assert (tmp_path / picture).read_text("utf-8") == (DOCS / picture).read_text("utf-8")


def test_the_page_on_compilation_shows_what_the_generator_writes():
    import how_vvdp_compiles

    assert (DOCS / "how-vvdp-compiles.md").read_text("utf-8") == how_vvdp_compiles.page()


def _page_and_generator():
    import keys

    return keys.PAGE.read_text("utf-8"), keys


def test_keys_of_a_run_have_their_units_and_labels():
    page, keys = _page_and_generator()
    assert keys.fill_in(page, "run", keys.run_keys()) == page


@pytest.mark.thorough
def test_keys_of_results_have_their_units_and_labels():
    page, keys = _page_and_generator()
    for verb, result in keys.results_of(keys.COMMANDS):
        assert keys.fill_in(page, verb, keys.keys_of(result)) == page, verb


@pytest.mark.slow
def test_keys_of_long_studies_have_their_units_and_labels():
    page, keys = _page_and_generator()
    for verb, result in keys.results_of(keys.LONG_COMMANDS):
        assert keys.fill_in(page, verb, keys.keys_of(result)) == page, verb


TABLE = """
## `vvdp some verb`

| key | unit | label | meaning |
|---|---|---|---|
| `pressure_<node>_Pa` | W | | at a node |
| `steps` | s | | number of steps |

Words that stay.
"""


def test_a_key_gets_unit_label_and_row_and_keeps_its_meaning():
    _, keys = _page_and_generator()
    found = {
        "pressure_load_line_Pa": ("Pa", "load line pressure"),
        "steps": ("1", "steps"),
        "new_W": ("W", "new power"),
    }
    rows = [line for line in keys.fill_in(TABLE, "some verb", found).splitlines() if line.startswith("| `")]
    assert rows == [
        "| `pressure_<node>_Pa` | Pa | <node> pressure | at a node |",
        "| `steps` | 1 | steps | number of steps |",
        "| `new_W` | W | new power | |",
    ]
    assert keys.fill_in(TABLE, "some verb", found).endswith("\nWords that stay.\n")


def test_the_nomenclature_is_what_its_command_writes():
    import nomenclature

    page = nomenclature.PAGE.read_text("utf-8")
    units = nomenclature.units_of_words()
    assert len(units) > 150
    assert nomenclature.fill_in(page, units) == page
    wrong = page.replace("| `spool_radius` | R | m |", "| `spool_radius` | R | mm |")
    assert wrong != page == nomenclature.fill_in(wrong, units)
    assert nomenclature.fill_in(page, {**units, "new_word": {"Pa"}}) == page + "| `new_word` |  | Pa |  |\n"


def test_a_docstring_becomes_markdown():
    from docstrings import markdown

    text = """Volume flow through an orifice [m^3/s].

Cd A sqrt(2/rho) dp / (dp^2 + eps^2)^(1/4)

area           open area [m^2]
pressure_drop  first side
               less the second [Pa]

Raises ParameterError where the drop is zero.

Source  merritt1967, ch. 3; docs/models/components.md
"""
    parts = markdown(text).split("\n\n")
    assert parts[0] == "Volume flow through an orifice [m^3/s]."
    assert parts[1] == "```text\nCd A sqrt(2/rho) dp / (dp^2 + eps^2)^(1/4)\n```"
    assert parts[2].splitlines()[2:] == [
        "| `area` | open area [m^2] |",
        "| `pressure_drop` | first side less the second [Pa] |",
    ]
    assert parts[3] == "Raises ParameterError where the drop is zero."
    assert parts[4] == "*Source:* merritt1967, ch. 3; [docs/models/components.md](../../models/components.md)"


def test_every_verb_and_every_package_has_its_place():
    import reference_pages

    pages = reference_pages.pages()
    assert pages["reference/verbs.md"].count("\n## vvdp") > 20
    assert "::: vvdp.hydraulics.orifice\n" in pages["reference/python/hydraulics.md"]
    assert len(reference_pages.PACKAGES) > 15 and set(reference_pages.PACKAGES) <= {
        path.split("/")[-1][:-3] for path in pages
    }


def test_a_notebook_becomes_a_page(tmp_path):
    from notebooks import page

    cells = [
        {"cell_type": "markdown", "source": ["# Title\n", "text"]},
        {"cell_type": "code", "source": ["1 + 1"], "outputs": [{"data": {"text/plain": ["2"]}}]},
        {
            "cell_type": "code",
            "source": ["plot()"],
            "outputs": [{"data": {"image/png": "AAAA\n", "text/plain": ["x"]}}],
        },
    ]
    file = tmp_path / "one.ipynb"
    file.write_text(json.dumps({"cells": cells}))
    assert page(file).startswith(
        "# Title\ntext\n\n```python\n1 + 1\n```\n\n```text\n2\n```\n\n```python\nplot()\n```\n\n<img "
    )
    assert "base64,AAAA" in page(file)


def test_a_script_becomes_cells():
    from notebooks import script_cells

    text, code = script_cells("# %% [markdown]\n# # Title\n#\n# text\n\n# %%\nx = 1\n\nx\n")
    assert (text["cell_type"], "".join(text["source"])) == ("markdown", "# Title\n\ntext")
    assert (code["cell_type"], "".join(code["source"])) == ("code", "x = 1\n\nx")


@pytest.mark.parametrize("path", sorted((DOCS / "notebooks").glob("*.py")), ids=lambda path: path.stem)
def test_a_notebook_is_its_script(path):
    import notebooks

    def sources(cells):
        return [(cell["cell_type"], "".join(cell["source"])) for cell in cells]

    made = notebooks.script_cells(path.read_text("utf-8"))
    assert sources(made) == sources(notebooks.read(path.with_suffix(".ipynb"))["cells"])


def plain(output):
    """What an output says as text."""
    return output.get("text", output.get("data", {}).get("text/plain", []))


@pytest.mark.sampled(3)
@pytest.mark.parametrize("path", sorted((DOCS / "notebooks").glob("*.ipynb")), ids=lambda path: path.stem)
def test_a_notebook_prints_what_it_shows(path, tmp_path, monkeypatch):
    """Its cells run one after the other; numbers may differ in their last digits on another machine."""
    import notebooks

    monkeypatch.chdir(tmp_path)
    cells = notebooks.read(path)["cells"]
    made, kept = notebooks.run(cells), [cell.get("outputs", []) for cell in cells]
    assert any(kept)
    for new, old in zip(made, kept, strict=True):
        assert [each["output_type"] for each in new] == [each["output_type"] for each in old]
        texts = ["".join(part for each in outputs for part in plain(each)) for outputs in (new, old)]
        assert ANY_NUMBER.sub("~", texts[0]) == ANY_NUMBER.sub("~", texts[1])
        numbers = [[float(each) for each in ANY_NUMBER.findall(text)] for text in texts]
        assert numbers[0] == pytest.approx(numbers[1], rel=1e-2)
