"""The tutorials: their blocks run, print what stands under them, and their pictures are there."""

import importlib.util
import re
import shlex
import subprocess
from pathlib import Path

import pytest
from tests.conftest import required_program
from tests.words import wording

from vvdp.export.c_target import TOOLS
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


@pytest.mark.thorough
def test_the_tutorial_does_what_it_says(vvdp, here, capsys):
    ran, said = run_blocks(PAGE, vvdp, capsys)
    assert ran.count("python") >= 12 and ran.count("sh") == 2
    warning = re.search(r'The command also warns: "([^"]+)"', PAGE)[1]
    assert warning in said["wheel"] and warning not in said["wheel-fit"]
    default, fitted = (read_result(here / name).numbers for name in ("wheel", "wheel-fit"))
    assert f"The fitted *q* is {fitted['acceleration_density_rad2_s3'].value:.0f} rad²/s³" in PAGE
    for digits, key in (("{:.2f}", "nis_mean"), ("{:.2g}", "speed_deviation_mean_rad_s")):
        assert "from " + " to ".join(digits.format(found[key].value) for found in (default, fitted)) in PAGE, key


BOARD = (FOLDER / "event-filter-on-a-board.md").read_text("utf-8")


@pytest.fixture
def board(vvdp, here, capsys):
    """The folder in which the commands of the page on a board were run."""
    (here / "board.toml").write_text(re.search(r"```toml\n(.*?)```", BOARD, re.DOTALL)[1], "utf-8")
    assert run_blocks(BOARD, vvdp, capsys)[0] == ["sh", "sh"]
    return here


def printed_by_make(folder, goal):
    """What a goal prints in the exported directory."""
    required_program("make")
    done = subprocess.run(["make", "-s", "-C", "filter", goal], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.thorough
def test_the_filter_runs_on_a_board(board):
    """The program of the page compiles; `make` prints what the page shows, but for last digits of a C library."""
    (code,) = re.findall(r"```c\n(.*?)```", BOARD, re.DOTALL)
    (board / "filter" / "board.c").write_text(code, "utf-8")
    flags = ["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Wdouble-promotion", "-Werror", "-c", "board.c"]
    subprocess.run([required_program("cc"), *flags], cwd=board / "filter", check=True)
    found = printed_by_make(board, "test")
    share = float(re.search(r", (\S+) of its largest value", found)[1])
    shown = float(re.search(r"make -s -C filter test\n.*\n.*, (\S+) of its largest value", BOARD)[1])
    assert 0.2 * shown < share < 5.0 * shown


@pytest.mark.thorough
def test_the_instructions_on_a_board_are_those_of_the_page(board):
    """To 3 %: other versions of the compiler and of its library have other numbers."""
    for name in TOOLS:
        required_program(name, "arm")
    pattern = re.compile(r"(\d+) to (\d+) instructions per sample, mean (\d+).*\n.*: stack (\d+) bytes")
    found, shown = (pattern.findall(text) for text in (printed_by_make(board, "pil"), BOARD))
    assert len(found) == len(shown) == 2
    for one, other in zip(found, shown, strict=True):
        assert [int(each) for each in one] == pytest.approx([int(each) for each in other], rel=0.03)
    most, stack = shown[0][1], shown[0][3]
    assert f"{int(most):,}".replace(",", " ") + f" instructions are {int(most) / 168:.0f} us" in BOARD
    assert f"{int(most) / 168:.0f} us at one instruction per cycle, {int(most) / 1680:.0f} % of 1 ms" in BOARD
    assert f"uses {stack} bytes" in BOARD
    page = (FOLDER.parent / "c-export.md").read_text("utf-8")
    assert re.search(r"    \$ make -s -C filter pil\n(    .*\n)+", BOARD)[0] in page


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
