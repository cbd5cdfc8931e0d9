"""How far a command has come, on stderr: a bar on a terminal, now and then a line elsewhere."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import NamedTuple

from vvdp.base.display import long_time

LINE_INTERVAL = 2.0
"""Seconds between two lines on a stderr that is no terminal."""


@contextmanager
def count_lines(what: str, seconds_each: float = 0.0) -> Iterator[Callable[[int, int], None]]:
    """Receives how many of `what` are done, of all; the first time, and each further tenth, is a line at once.

    seconds_each  usual time of one [s], for saying before the first how long all will take; 0 if unknown
    """
    from vvdp.cli.screen import console, say

    screen = console(err=True)
    if screen.is_terminal:
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

        words = TextColumn(what)
        with Progress(
            MofNCompleteColumn(), words, BarColumn(), TimeRemainingColumn(), console=screen, transient=True
        ) as bar:
            task = bar.add_task("", total=None)

            def move(done: int, total: int) -> None:
                if bar.tasks[task].total is None and seconds_each:
                    screen.print(f"{total} {what}{_about(seconds_each * (total - done))}")
                bar.update(task, completed=done, total=total)

            yield move
        return
    tenth, last = -1, 0.0
    began: tuple[float, int] | None = None

    def line(done: int, total: int) -> None:
        nonlocal tenth, last, began
        now = time.monotonic()
        first, began = began is None, began or (now, done)
        if 10 * done // total > tenth or now - last >= LINE_INTERVAL:
            tenth, last = 10 * done // total, now
            left = _about(seconds_each * total) if first else _time_left(now - began[0], done - began[1], total - done)
            say(f"{done} of {total} {what}{left if done < total else ''}")

    yield line


def _about(seconds: float) -> str:
    """How long all of it usually takes, in words; empty if that is unknown."""
    return f", about {long_time(seconds)}" if seconds else ""


def _time_left(elapsed: float, gone: float, still: float) -> str:
    """How long the rest will take at the pace so far, in words; empty where none can be determined."""
    if not (gone > 0.0 and elapsed > 0.0):
        return ""
    seconds = still * elapsed / gone
    return f", about {long_time(seconds)} left"


class Reach(NamedTuple):
    """Receives how far something is."""

    move: Callable[[float], None]
    """Receives how much is reached."""
    say: Callable[[str], None]
    """Receives notices, such as what is compiled first."""


@contextmanager
def report_reach(end: float, words: Callable[[float], str]) -> Iterator[Reach]:
    """Receives how much is reached, of `end`, which `words` puts into words.

    The pace counts from the first time on: what is compiled before takes no part in it.
    """
    from vvdp.cli.screen import console, say

    screen = console(err=True)
    if screen.is_terminal:
        from vvdp.cli.bars import reach_bar

        with reach_bar(screen, end, words) as bar:
            yield Reach(*bar)
        return
    last, began = 0.0, None

    def line(now: float) -> None:
        nonlocal last, began
        if began is None:
            last = time.monotonic()
            began = last, now
        if now < end and time.monotonic() - last >= LINE_INTERVAL:
            last = time.monotonic()
            say(f"{words(now)}{_time_left(last - began[0], now - began[1], end - now)}")

    yield Reach(line, say)
