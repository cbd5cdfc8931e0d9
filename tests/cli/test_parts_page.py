"""docs/parts.md, to the letter: each file is written, each command run, each printed block compared."""

import re
import shlex
from pathlib import Path

PAGE = (Path(__file__).parents[2] / "docs" / "parts.md").read_text("utf-8")
BLOCK = re.compile(r"(?:`(\w+\.toml)`:\n\n)?```(toml|sh)\n(.*?)```\n(?:\n```text\n(.*?)```\n)?", re.DOTALL)
MISTAKES = (
    ("plant.toml", 'dirty = "rail"', 'drity = "rail"'),
    ("plant.toml", 'clean = "line"', 'clean = "lime"'),
    ("plant.toml", '"1e-9 m^3/(s*Pa)"', '"1e-9 m^3/s"'),
    ("plant.toml", "conductance", "conductence"),
    ("plant.toml", "filter.toml", "fliter.toml"),
    ("plant.toml", "[parts.fine]", "[parts.load]"),
    ("plant.toml", 'rail = { type = "volume", volume = "100 cc", start = "5 bar" }', 'rail = { type = "shaft" }'),
    ("filter.toml", '"60 mm^2"', '"60 mm"'),
    ("filter.toml", "[values]", '[parts.second]\nfile = "filter.toml"\ndirty = "dirty"\nclean = "clean"\n[values]'),
)
"""The file, and what is changed in it, for each of the mistakes, in their order."""


def test_the_page_does_what_it_says(vvdp, here, changed, is_shown):
    ran = 0
    for name, kind, block, shown in BLOCK.findall(PAGE):
        if kind == "toml":
            file = here / (name or "plant.toml")
            file.write_text(changed(file.read_text() if file.exists() else "", block))
            continue
        command = shlex.split(block)
        assert command[0] == "vvdp" and shown
        answer = vvdp(*command[1:])
        assert answer.code == 0, answer.err
        assert is_shown(shown, answer.out), (block, answer.out)
        ran += 1
    assert ran == 5
    report = (here / "results" / "plant" / "report.html").read_text("utf-8")
    for part in ("fine", "coarse"):
        assert report.count(f'href="#figure-circuit-{part}"') == report.count(f'id="figure-circuit-{part}"') == 1
    _mistakes(vvdp, here)


def _mistakes(vvdp, folder):
    said = []
    for name, old, new in MISTAKES:
        good = (folder / name).read_text()
        assert old in good, old
        (folder / name).write_text(good.replace(old, new, 1))
        answer = vvdp("run", "plant.toml")
        assert answer.code == 2
        said += answer.err.splitlines()[:1]
        (folder / name).write_text(good)
    section = PAGE.partition("\n## Mistakes\n")[2].partition("\n## ")[0]
    assert re.findall(r"^    (.+)$", section, re.MULTILINE) == said
