"""One program of OpenFOAM at work in a case: started, watched, ended, and what went wrong, in a line."""

import errno
import os
import re
import shutil
import signal
import subprocess
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

from vvdp.base.errors import RunError, WriteError
from vvdp.cfd.engine import OpenFoam

GLANCE = 0.25
"""Seconds between two looks at a program that is at work."""
PATIENCE = 60.0
"""Seconds that a program may take to write and end when it is asked to."""
LEAST_ROOM = 32 << 20
"""Bytes on the disk below which a failure is put down to it."""
FATAL = re.compile(r"FOAM FATAL (?:IO )?ERROR.*?\n(.*?)(?:\n\s*From |\nFOAM |\Z)", re.DOTALL)


def log_path(case: Path, program: str) -> Path:
    """The file that keeps what a program says."""
    return case / f"log.{program}"


def run_program(
    words: Sequence[str],
    case: Path,
    openfoam: OpenFoam,
    cores: int = 1,
    watch: Callable[[], None] | None = None,
    stop: str = "",
) -> float:
    """Runs a program in a case to its end, its words appended to its log; the seconds that it took.

    `watch` is called while it works. At Ctrl-C the program is ended, by the file `stop` where it heeds one, then
    KeyboardInterrupt goes on. Raises RunError where the program fails, WriteError where the disk is full.
    """
    began, log = time.monotonic(), log_path(case, words[0])
    with log.open("ab") as file:
        # In a session of its own: Ctrl-C is for vvdp, which lets the solver write first.
        process = subprocess.Popen(
            openfoam.command(words, cores),
            cwd=case,
            env={**openfoam.environment, "PWD": str(case.resolve())},
            stdin=subprocess.DEVNULL,
            stdout=file,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            close_fds=False,
        )
    try:
        while _is_running(process):
            if watch:
                watch()
    except KeyboardInterrupt:
        if stop:
            (case / stop).touch()
            _wait(process)
        _end(process)
        raise
    except BaseException:
        _end(process)
        raise
    if process.returncode:
        raise failure(words[0], process.returncode, case)
    return time.monotonic() - began


def _is_running(process: "subprocess.Popen[bytes]") -> bool:
    try:
        process.wait(GLANCE)
    except subprocess.TimeoutExpired:
        return True
    return False


def _end(process: "subprocess.Popen[bytes]") -> None:
    """Ends a program and all that it has started."""
    for number in (signal.SIGTERM, signal.SIGKILL):
        if process.poll() is None:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, number)
            _wait(process)


def _wait(process: "subprocess.Popen[bytes]") -> None:
    """Waits for a program that was asked to end; a second Ctrl-C ends the patience."""
    with suppress(subprocess.TimeoutExpired, KeyboardInterrupt):
        process.wait(PATIENCE)


def failure(program: str, code: int, case: Path) -> RunError | WriteError:
    """The message for a program that ended with a code other than 0."""
    if shutil.disk_usage(case).free < LEAST_ROOM:
        return WriteError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(case))
    log = log_path(case, program)
    with log.open("rb") as file:
        file.seek(max(0, log.stat().st_size - 20_000))
        text = file.read().decode("utf-8", "replace")
    if code in (-signal.SIGFPE, 128 + signal.SIGFPE) or "sigFpe" in text:
        return RunError(f"{program} divided by zero or overflowed: the flow diverged; see {log}")
    if found := FATAL.search(text):
        return RunError(f"{program} failed: {' '.join(found[1].split())}; see {log}")
    if code < 0 or code > 128:
        name = signal.Signals(-code if code < 0 else code - 128).name
        return RunError(
            f"{program} was killed ({name}); rerun the same command to go on from its last written state; see {log}"
        )
    return RunError(f"{program} failed with exit code {code}; see {log}")
