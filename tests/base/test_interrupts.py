"""Ctrl-C is not lost within a call of C, and does not come twice."""

import ctypes
import signal
import threading

import pytest

from vvdp.base.interrupts import interrupts_afterwards


def interrupted_within_a_callback():
    """What Numba does while it compiles: C calls Python, where Ctrl-C arrives."""
    callback = ctypes.CFUNCTYPE(None)(lambda: signal.raise_signal(signal.SIGINT))
    callback()


def test_an_interrupt_within_a_callback_comes_afterwards():
    interrupted_within_a_callback()  # without the block it is lost
    with pytest.raises(KeyboardInterrupt), interrupts_afterwards():
        interrupted_within_a_callback()
        reached = True
    assert reached


def test_handlers_are_put_back_and_a_second_one_acts_at_once():
    before = signal.getsignal(signal.SIGINT)
    with interrupts_afterwards():
        pass
    assert signal.getsignal(signal.SIGINT) is before
    reached = False
    with pytest.raises(KeyboardInterrupt), interrupts_afterwards():
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)
        reached = True
    assert not reached
    assert signal.getsignal(signal.SIGINT) is before


def test_other_threads_change_nothing():
    seen = []

    def work():
        with interrupts_afterwards():
            seen.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert seen == [signal.getsignal(signal.SIGINT)]
