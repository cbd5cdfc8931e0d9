"""docs/own-circuit.md is one program: its blocks run and print what stands under them."""

import re
import shlex
from pathlib import Path

from vvdp.generator.source import known_text

PAGE = (Path(__file__).parents[2] / "docs" / "own-circuit.md").read_text("utf-8")
BLOCK = re.compile(r"(?:`([\w.]+)`:\n\n)?```(python|toml|sh)\n(.*?)```\n(?:\n```text\n(.*?)```\n)?", re.DOTALL)


def test_the_page_does_what_it_says(vvdp, here, is_shown, capsys):
    left, ran = {}, []
    for name, kind, block, shown in BLOCK.findall(PAGE):
        if name:
            (here / name).write_text(block)
            continue
        capsys.readouterr()
        if kind == "sh":
            answer = vvdp(*shlex.split(block)[1:])
            assert answer.code == 0, answer.err
            said = answer.out
        else:
            exec(compile(block, known_text(block, "own-circuit.md"), "exec"), left)
            said = capsys.readouterr().out
        assert is_shown(shown, said) if shown else not said, (block, said)
        ran.append(kind)
    assert ran.count("python") >= 10 and ran.count("sh") == 1
    assert (here / "results" / "mine" / "report.html").is_file()


def test_the_network_is_short_and_the_component_too():
    network = next(block for _, _, block, _ in BLOCK.findall(PAGE) if "net = Network(oil)" in block)
    drawn = [line for line in network.splitlines() if line and not line.startswith(("from ", "import "))]
    assert len(drawn) <= 20
    law = next(block for _, _, block, _ in BLOCK.findall(PAGE) if "THROTTLE = Component" in block)
    assert len(law.partition("def throttle(")[2].splitlines()) <= 15
