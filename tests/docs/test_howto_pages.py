"""The how-to pages, to the letter: each file is written, each command run, each printed block compared."""

import re
import runpy
import shlex
from pathlib import Path

import pytest
from tests.cli.conftest import changed, here, is_shown, vvdp  # noqa: F401

from vvdp.components.library import COMPONENTS
from vvdp.generator.source import known_text
from vvdp.systems.drawing import NODES

FOLDER = Path(__file__).parents[2] / "docs" / "howto"
BLOCK = re.compile(r"(?:`([\w-]+\.\w+)`:\n\n)?```(toml|csv|python|sh)\n(.*?)```\n(?:\n```text\n(.*?)```\n)?", re.DOTALL)
RUNS = {
    "real-pump": 1,
    "gauge-and-absolute": 2,
    "fit-your-data": 5,
    "replace-a-controller": 4,
    "troubleshooting": 0,
}


@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", RUNS)
def test_the_page_does_what_it_says(name, vvdp, here, is_shown, capsys, monkeypatch):  # noqa: F811
    monkeypatch.syspath_prepend(str(here))
    ran = 0
    for file, kind, block, shown in BLOCK.findall((FOLDER / f"{name}.md").read_text("utf-8")):
        if file:
            (here / file).write_text(block, "utf-8")
        elif kind == "python":
            exec(compile(block, known_text(block, f"{name}.md"), "exec"), {})
        elif kind == "sh":
            said = output_of(shlex.split(block), vvdp, capsys)
            assert shown and is_shown(shown, said), (block, said)
            ran += 1
    assert ran == RUNS[name]


def output_of(words, vvdp, capsys):  # noqa: F811
    """What a command of a page prints on stdout."""
    if words[0] == "python":
        runpy.run_path(words[1])
        return capsys.readouterr().out
    assert words[0] == "vvdp"
    answer = vvdp(*words[1:])
    assert answer.code == 0, answer.err
    return answer.out


def test_every_page_is_in_the_list():
    assert {path.stem for path in FOLDER.glob("*.md")} == RUNS.keys()


def test_types_of_other_tools_lead_to_types_that_exist():
    page = (FOLDER.parent / "coming-from.md").read_text("utf-8")
    rows = [line.split("|")[-2] for line in page.partition("## Components")[2].splitlines() if line.startswith("| ")]
    named = {word for cell in rows[1:] for word in re.findall(r"`([\w-]+)`", cell)}
    assert len(named) > 25
    assert named <= {*COMPONENTS, *NODES}


def test_messages_that_are_explained_exist():
    """Each part of a message between its gaps is a text of the package."""
    page = (FOLDER / "troubleshooting.md").read_text("utf-8")
    sources = "\n".join(path.read_text("utf-8") for path in (FOLDER.parents[1] / "src").rglob("*.py"))
    sources = re.sub(r'"\s*\n\s*f?"', "", sources)
    shown = [
        text for line in re.findall(r"^\| (.*?) \|", page, re.MULTILINE) for text in re.findall(r"`([^`]+)`", line)
    ]
    for message in shown:
        for piece in re.split(r"\.\.\.|'[xy]'|\d+ (?=assumed)|: \d+ of (?=the)|[\d.]+ %", message):
            assert piece.strip() in sources, piece
