"""What is said of progress: lines where stderr is no terminal, a bar on one."""

import re

import pytest
from tests.words import wording

from vvdp.cli import progress
from vvdp.cli.bars import FULLEST, ClockedProgress
from vvdp.simulation.assembly import Compiling


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
    with progress.report_reach(9.0, lambda now: f"t = {now:g} s") as reach:
        for now in range(10):
            reach.move(float(now))
            clock[0] += 1.0
    left = {2: 7, 4: 5, 6: 3, 8: 1}  # at the pace so far
    expected = [wording.progress.reach.format(now=now, left=seconds) for now, seconds in left.items()]
    assert capsys.readouterr().err.splitlines() == expected


@pytest.fixture
def terminal(monkeypatch, capsys):
    """What a terminal has shown since it was last asked."""
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm")
    return lambda: re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", capsys.readouterr().err)


def test_on_a_terminal_there_is_a_bar(terminal):
    with progress.count_lines("points") as heard:
        heard(3, 12)
    assert "3/12 points" in terminal()
    with progress.report_reach(2.0, lambda now: f"t = {now:g} s") as reach:
        reach.move(1.5)
    assert "t = 1.5 s" in terminal()


def test_the_bar_moves_by_the_clock_while_code_is_compiled():
    """Halfway after half of the time, and never full."""
    now = [0.0]
    bar = ClockedProgress(get_time=lambda: now[0])
    task = bar.add_task("compiling", total=10.0, seconds=10.0)
    for now[0], completed in ((5.0, 5.0), (20.0, 10.0 * FULLEST)):
        list(bar.get_renderables())
        assert bar.tasks[task].completed == completed


def test_compiling_has_the_bar_before_the_run(terminal):
    compiling = Compiling("it", 10.0)
    with progress.report_reach(2.0, lambda now: f"t = {now:g} s") as reach:
        for say, words in ((reach.say, "beside it"), (reach.say, compiling), (reach.move, 0.5)):
            say(words)
    shown = terminal()
    places = [shown.find(words) for words in ("beside it", compiling, "t = 0.5 s")]
    assert places == sorted(places) and -1 not in places
