"""What is said of progress: lines where stderr is no terminal, a bar on one."""

import re

import pytest
from tests.words import wording

from vvdp.cli import progress


@pytest.fixture
def clock(monkeypatch):
    """A clock that is set by hand."""
    now = [1000.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    return now


def test_the_first_call_each_tenth_and_every_two_seconds_is_a_line(capsys, clock):
    with progress.count_lines("points") as heard:
        for done in (0, 1, 9, 10, 11, 100):
            heard(done, 100)
        clock[0] += 60.0
    assert [line.split()[0] for line in capsys.readouterr().err.splitlines()] == ["0", "10", "100"]
    with progress.count_lines("points") as heard:
        for done in range(4):
            heard(done, 1000)
            clock[0] += 1.0
    first, second = (wording.progress.count.format(done=done, all=1000, what="points") for done in (0, 2))
    assert capsys.readouterr().err.splitlines() == [first, f"{second}, about 16.6 min left"]  # 998 at 1 s each


def test_a_quantity_is_told_every_two_seconds_until_the_end(capsys, clock):
    with progress.report_reach(9.0, lambda now: f"t = {now:g} s") as heard:
        for now in range(10):
            heard(float(now))
            clock[0] += 1.0
    left = {2: 7, 4: 5, 6: 3, 8: 1}  # at the pace so far
    expected = [wording.progress.reach.format(now=now, left=seconds) for now, seconds in left.items()]
    assert capsys.readouterr().err.splitlines() == expected


@pytest.mark.parametrize(
    ("listening", "heard", "words"),
    [
        (progress.count_lines("points"), (3, 12), "3/12 points"),
        (progress.report_reach(2.0, lambda now: f"t = {now:g} s"), (1.5,), "t = 1.5 s"),
    ],
)
def test_on_a_terminal_there_is_a_bar(capsys, monkeypatch, listening, heard, words):
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm")
    with listening as progress_of:
        progress_of(*heard)
    assert words in re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", capsys.readouterr().err)
