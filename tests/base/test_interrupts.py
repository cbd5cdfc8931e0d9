"""Ctrl-C ends a wait for work in C at once, and work that is done elsewhere keeps its result or its error."""

import signal
import threading
import time

import pytest

from vvdp.base.errors import RunError
from vvdp.base.interrupts import interruptible


def test_what_work_returns_or_raises_comes_back():
    assert interruptible(lambda: 6 * 7) == 42

    def fails():
        raise RunError("no step is short enough")

    with pytest.raises(RunError, match="no step is short enough"):
        interruptible(fails)


@pytest.fixture
def heard():
    """SIGINT raises KeyboardInterrupt, even if the tests were started in the background, where it is ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_an_interrupt_does_not_wait_for_the_work(heard):
    """The work takes 5 s here; the interrupt is raised within 0.3 s."""
    let_go = threading.Event()
    threading.Timer(0.1, lambda: signal.raise_signal(signal.SIGINT)).start()
    began = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        interruptible(lambda: let_go.wait(5.0))
    assert time.monotonic() - began < 2.0
    let_go.set()


def test_in_another_thread_the_work_is_done_there():
    found = []
    thread = threading.Thread(target=lambda: found.append(interruptible(threading.get_ident)))
    thread.start()
    thread.join()
    assert found == [thread.ident]
