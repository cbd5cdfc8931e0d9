"""The tutorials: their blocks run, print what stands under them, and their pictures are there."""

import importlib.util
import re
import shlex
from pathlib import Path

import pytest
from tests.words import wording

from vvdp.generator.source import known_text
from vvdp.results.store import read_result

FOLDER = Path(__file__).parents[2] / "docs" / "tutorials"
PAGE = (FOLDER / "speed-from-a-bad-encoder.md").read_text("utf-8")
BLOCK = re.compile(r"```(python|sh)\n(.*?)```\n(?:```text\n(.*?)```\n)?", re.DOTALL)
LARGEST = 100_000
"""Bytes that a picture may have."""


def run_blocks(page, vvdp, capsys):
    """One program from the first block to the last; the shell's block finds the log that the one before has written.
    What the kinds of the blocks were, and what each command said, by its last word."""
    left, ran, said = {}, [], {}
    for kind, block, shown in BLOCK.findall(page):
        if kind == "sh":
            command = shlex.split(block)
            answer = vvdp(*command[1:])
            assert command[0] == "vvdp" and answer.code == 0, answer.err
            said[command[-1]] = answer.out + answer.err
        else:
            capsys.readouterr()
            exec(compile(block, known_text(block, "page"), "exec"), left)
            assert capsys.readouterr().out == shown, block
        ran.append(kind)
    return ran, said


@pytest.mark.thorough
def test_the_crankshaft_does_what_is_said(vvdp, here, capsys):
    ran, said = run_blocks((FOLDER / "crank-wheel.md").read_text("utf-8"), vvdp, capsys)
    assert ran == ["python", "python", "sh", "python", "python"]
    assert wording.estimate.index_not_found not in said["crank"] and wording.estimate.elsewhere not in said["crank"]


def test_the_tutorial_does_what_it_says(vvdp, here, capsys):
    ran, said = run_blocks(PAGE, vvdp, capsys)
    assert ran.count("python") >= 12 and ran.count("sh") == 2
    warning = re.search(r'The command also warns: "([^"]+)"', PAGE)[1]
    assert warning in said["wheel"] and warning not in said["wheel-fit"]
    default, fitted = (read_result(here / name).numbers for name in ("wheel", "wheel-fit"))
    assert f"The fitted *q* is {fitted['acceleration_density_rad2_s3'].value:.0f} rad²/s³" in PAGE
    for digits, key in (("{:.2f}", "nis_mean"), ("{:.2g}", "speed_deviation_mean_rad_s")):
        assert "from " + " to ".join(digits.format(found[key].value) for found in (default, fitted)) in PAGE, key


def test_the_pictures_are_drawn_and_small(tmp_path):
    spec = importlib.util.spec_from_file_location("tutorial_pictures", FOLDER / "pictures.py")
    pictures = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(pictures)
    pictures.main(tmp_path)
    named = set(re.findall(r"\]\(([\w-]+\.png)\)", PAGE))
    assert {path.name for path in tmp_path.iterdir()} == named
    for name in named:
        assert (FOLDER / name).stat().st_size < LARGEST
        assert (tmp_path / name).stat().st_size < LARGEST
