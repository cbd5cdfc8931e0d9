"""The process of the command line: the console script `vvdp`, and `python -m vvdp`.

Ctrl-C ends it in one line and with exit code 130 at any instant from here on: nothing else is imported earlier.
"""

import sys

if __name__ == "__main__" and not sys.flags.safe_path:  # as for the script: nothing comes from the working folder
    del sys.path[0]

import os
from typing import TYPE_CHECKING, Any, NoReturn

if TYPE_CHECKING:
    from types import FrameType

INTERRUPTED = 130


def main() -> None:
    """Run the command line in `sys.argv` and exit with its code."""
    try:
        _run()
    except KeyboardInterrupt:
        leave()
    except SystemExit as end:
        if end.code != INTERRUPTED:
            raise
        _end()


def _run() -> None:
    import signal

    catches = signal.getsignal(signal.SIGINT) is signal.default_int_handler  # else it is ignored, as in the background
    if catches:
        signal.signal(signal.SIGINT, leave)
        sys.unraisablehook = _interrupt_again
    from vvdp.cli.main import main as run_command

    if catches:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        run_command()
    finally:
        if catches:
            signal.signal(signal.SIGINT, signal.SIG_IGN)  # only the end of the interpreter is left


def leave(number: int = 0, frame: "FrameType | None" = None) -> NoReturn:
    """End the process where nothing has begun that must be cleared away; the handler while modules are loaded."""
    os.write(2, b"interrupted\n")
    os._exit(INTERRUPTED)


def _end() -> NoReturn:
    """End with the code: after a KeyboardInterrupt in `exec` Python itself would end as if killed by the signal."""
    import atexit

    atexit._run_exitfuncs()
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
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
