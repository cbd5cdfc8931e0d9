"""The process of the command line: the console script `vvdp`, and `python -m vvdp`.

Nothing is imported here before Ctrl-C is taken care of, so that it ends the process in one line at any instant.
"""

import signal
import sys
from types import FrameType
from typing import Any

INTERRUPTED = 130


def main() -> None:
    """Run the command line in `sys.argv` and exit with its code."""
    catches = signal.getsignal(signal.SIGINT) is signal.default_int_handler  # else it is ignored, as in the background
    if catches:
        signal.signal(signal.SIGINT, _leave)
        sys.unraisablehook = _interrupt_again
    from vvdp.cli.main import main as run_command

    if catches:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        run_command()
    except KeyboardInterrupt:  # before or after the command itself
        _leave(signal.SIGINT, None)
    finally:
        if catches:
            signal.signal(signal.SIGINT, signal.SIG_IGN)  # everything is done but for the end of the interpreter


def _leave(number: int, frame: FrameType | None) -> None:
    """End the process while modules are loaded: nothing has begun that must be cleared away."""
    import os

    os.write(2, b"interrupted\n")
    os._exit(INTERRUPTED)


def _interrupt_again(problem: Any) -> None:
    """Interrupt the main thread a moment later, if Ctrl-C came where it cannot be raised (a callback, a destructor)."""
    if issubclass(problem.exc_type, KeyboardInterrupt):
        import _thread
        import threading

        threading.Timer(0.05, _thread.interrupt_main).start()
    else:
        sys.__unraisablehook__(problem)


if __name__ == "__main__":
    main()
