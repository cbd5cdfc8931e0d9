"""Ctrl-C while a library works in C: Python can raise it only when the call returns."""

import threading
from collections.abc import Callable
from queue import Empty, Queue
from typing import Any, TypeVar, cast

Result = TypeVar("Result")
LOOK = 0.05
"""Between two looks for an interrupt [s]."""


def interruptible(work: Callable[[], Result]) -> Result:
    """The result of `work`, done in another thread: Ctrl-C is raised here at once, even while `work` is within C.

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
