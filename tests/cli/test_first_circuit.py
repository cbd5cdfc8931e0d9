"""docs/first-circuit.md, to the letter: each file is written, each command run, each printed block compared."""

import re
import shlex
from pathlib import Path

PAGE = (Path(__file__).parents[2] / "docs" / "first-circuit.md").read_text("utf-8")
BLOCK = re.compile(r"(?:`(\w+\.toml)`:\n\n)?```(toml|sh)\n(.*?)```\n(?:\n```text\n(.*?)```\n)?", re.DOTALL)
MISTAKES = (
    ('rail", flow', 'rial", flow'),
    ('"20 lpm"', '"20"'),
    ('"20 lpm"', '"20 bar"'),
    ("override_pressure", "overide_pressure"),
    ('a = "line", b = "tank", area', 'a = "line", area'),
    ("line.pressure", "line"),
)
"""What is changed in the file for each of the mistakes, in their order."""


def test_the_page_does_what_it_says(vvdp, here, changed, is_shown):
    """One drawing from its first lines to its report."""
    ran = 0
    for name, kind, block, shown in BLOCK.findall(PAGE):
        if kind == "toml":
            file = here / (name or "press.toml")
            file.write_text(changed(file.read_text() if file.exists() else "", block))
            continue
        command = shlex.split(block)
        assert command[0] == "vvdp" and shown
        answer = vvdp(*command[1:])
        assert answer.code == (3 if "results/rough" in block else 0), answer.err
        assert is_shown(shown, answer.out), (block, answer.out)
        ran += 1
    assert ran == 12
    assert (here / "results" / "limits" / "report.html").is_file()
    _mistakes(vvdp, here / "press.toml")


def _mistakes(vvdp, file):
    good, said = file.read_text(), []
    for old, new in MISTAKES:
        assert good.count(old) == 1, old
        file.write_text(good.replace(old, new))
        answer = vvdp("run", "press.toml")
        assert answer.code == 2
        said += answer.err.splitlines()
    section = PAGE.partition("\n## Mistakes\n")[2].partition("\n## ")[0]
    assert re.findall(r"^    (.+)$", section, re.MULTILINE) == said


def test_the_first_file_is_short_and_the_comparison_bites(is_shown):
    first = BLOCK.search(PAGE)
    assert first[1] == "press.toml" and len(first[3].splitlines()) == 12
    assert is_shown("...\nb\n", "a\nb") and is_shown("a\n...\n", "a\nb") and is_shown("a 1.0e-10", "a -2.0e-11")
    assert not is_shown("b", "a\nb") and not is_shown("a", "a\nb") and not is_shown("...\nc", "a\nb")


def test_a_pump_unit_needs_few_lines():
    blocks = {name: text for name, _, text, _ in BLOCK.findall(PAGE) if name}
    assert len(blocks["unit.toml"].splitlines()) <= 25 and 'type = "pump-unit"' in blocks["unit.toml"]


def test_the_readme_shows_the_same_first_file():
    readme = (Path(__file__).parents[2] / "README.md").read_text("utf-8")
    assert BLOCK.search(PAGE)[3] in readme
