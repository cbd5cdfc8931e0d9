"""Ctrl-C where it would be lost: while a library calls back from C, an exception cannot leave the call."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from queue import Empty, Queue
from types import FrameType
from typing import Any, TypeVar, cast

Result = TypeVar("Result")
LOOK = 0.05
"""Between two looks for an interrupt [s]."""


def interruptible(work: Callable[[], Result]) -> Result:
    """What `work` returns or raises, done in another thread: Ctrl-C is raised here at once, and not when C returns.

    The thread then goes on by itself, so `work` must not change anything.
    """
    if threading.current_thread() is not threading.main_thread():
        return work()
    found: Queue[tuple[bool, Any]] = Queue()

    def run() -> None:
        try:
            found.put((True, work()))
        except BaseException as problem:
            found.put((False, problem))

    threading.Thread(target=run, daemon=True).start()
    while True:
        try:
            done, result = found.get(timeout=LOOK)
        except Empty:
            continue
        if done:
            return cast(Result, result)
        raise result


@contextmanager
def interrupts_afterwards() -> Iterator[None]:
    """Within the block Ctrl-C, and whatever does the same, is noted; behind it, it raises KeyboardInterrupt.

    A second one acts at once. In other threads than the main one, where no signal arrives, nothing changes.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.getsignal(signal.SIGINT)
    noted: list[int] = []

    def note(number: int, frame: FrameType | None) -> None:
        noted.append(number)
        if len(noted) > 1 and callable(before):
            before(number, frame)

    signal.signal(signal.SIGINT, note)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if noted:
        raise KeyboardInterrupt
