"""Ctrl-C while a record goes by: what was reached is kept."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType


class Stopped(Exception):
    """Ctrl-C was pressed where the record can be left."""


@contextmanager
def catch_interrupt() -> Iterator[Callable[[], None]]:
    """A function that raises Stopped after Ctrl-C, to be called where the record can be left; a second Ctrl-C ends
    everything at once."""
    pressed = False

    def check() -> None:
        if pressed:
            raise Stopped

    if threading.current_thread() is not threading.main_thread():
        yield check
        return

    def note(number: int, frame: FrameType | None) -> None:
        nonlocal pressed
        if pressed:
            raise KeyboardInterrupt
        pressed = True

    before = signal.signal(signal.SIGINT, note)
    try:
        yield check
    finally:
        signal.signal(signal.SIGINT, before)
