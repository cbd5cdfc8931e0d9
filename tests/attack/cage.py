"""A call in a forked process with limits: how it ended, what it said, what it took and what it touched.

The parent is warmed up once, so that a case costs a fork and not the start of an interpreter.
"""

import json
import os
import resource
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Callable
from enum import StrEnum
from pathlib import Path
from typing import Any, NamedTuple

LONGEST = 10.0
"""Processor time that a file may take [s]."""
LARGEST = 1_000_000_000
"""Memory that a process may hold while it reads a file [B]."""
PATIENCE = 120
"""Wall time after which a process that waits is ended [s]."""
ENDS = (0, 1, 2, 3)
"""Exit codes for a result, a failure, bad input and a result that is not valid."""


class Outcome(StrEnum):
    """What becomes of a file; all but the first two are faults of vvdp."""

    REFUSED = "refused"
    READ = "read as it stands"
    MISREAD = "read as something else"
    TRACEBACK = "traceback"
    SLOW = "over 10 s"
    LARGE = "over 1 GB"
    TOUCHED = "touched other files"


class Reading(NamedTuple):
    """Exit code of a command, and what is wrong with its reading of the file, if anything."""

    code: int
    complaint: str = ""


class Verdict(NamedTuple):
    """What became of a file, and what was said."""

    outcome: Outcome
    said: str
    seconds: float
    memory: int


def caged(attack: Callable[[], Reading], folder: Path) -> Verdict:
    """Verdict on `attack`, which may write into `folder` and nowhere else."""
    receiving, sending = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(receiving)
        _answer(attack, folder, sending)
    os.close(sending)
    with os.fdopen(receiving, "rb") as pipe:
        told = pipe.read()
    _, status = os.waitpid(child, 0)
    if not told:
        ended = os.waitstatus_to_exitcode(status)
        slow = -ended in (signal.SIGXCPU, signal.SIGALRM)
        return Verdict(Outcome.SLOW if slow else Outcome.TRACEBACK, f"ended by signal {-ended}", LONGEST, 0)
    return _verdict(**json.loads(told))


def _verdict(code: int, complaint: str, said: str, touched: list[str], seconds: float, memory: int) -> Verdict:
    if seconds > LONGEST:
        found, why = Outcome.SLOW, f"{seconds:.1f} s"
    elif memory > LARGEST or "not enough memory" in said:
        found, why = Outcome.LARGE, f"{memory / 1e6:.0f} MB"
    elif code not in ENDS or "Traceback" in said or "mistake of vvdp" in said or (code and not said.strip()):
        found, why = Outcome.TRACEBACK, f"exit code {code}"
    elif touched:
        found, why = Outcome.TOUCHED, ", ".join(touched)
    elif code:
        found, why = Outcome.REFUSED, ""
    else:
        found, why = (Outcome.MISREAD, complaint) if complaint else (Outcome.READ, "")
    return Verdict(found, "\n".join(filter(None, (why, said.strip()))), seconds, memory)


def _answer(attack: Callable[[], Reading], folder: Path, pipe: int) -> None:
    """Runs the attack in this process, tells of it, and ends the process."""
    said = os.open(folder / ".said", os.O_RDWR | os.O_CREAT | os.O_TRUNC)
    for stream in (1, 2):
        os.dup2(said, stream)
    _limit()
    tempfile.tempdir = str(folder)
    touched: list[str] = []
    sys.dont_write_bytecode = True  # byte code that Python keeps is no file that an attack has touched
    sys.addaudithook(_watch(folder, touched))
    try:
        code, complaint = attack()
    except MemoryError:  # as the command line says it
        print("not enough memory", file=sys.stderr)
        code, complaint = 1, ""
    except BaseException:
        traceback.print_exc()
        code, complaint = 1, ""
    told: dict[str, Any] = {"code": code, "complaint": complaint, "touched": sorted(set(touched))}
    sys.stdout.flush()
    sys.stderr.flush()
    told |= {"said": os.pread(said, 100_000, 0).decode(errors="replace"), "seconds": time.process_time()}
    told |= {"memory": _held("VmHWM")}
    os.write(pipe, json.dumps(told).encode()[:500_000])
    os._exit(0)


def _limit() -> None:
    signal.alarm(PATIENCE)
    resource.setrlimit(resource.RLIMIT_CPU, (int(LONGEST) + 2, int(LONGEST) + 4))
    most = _held("VmData") + LARGEST
    resource.setrlimit(resource.RLIMIT_DATA, (most, most))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _held(word: str) -> int:
    """A number of /proc/self/status [B]; what a child is told to have used at most begins with what it holds."""
    line = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith(f"{word}:"))
    return int(line.split()[1]) * 1024


CHANGES = ("os.remove", "os.rename", "os.rmdir", "os.mkdir", "os.link", "os.symlink", "os.truncate", "shutil.rmtree")
PROCESSES = ("subprocess.Popen", "os.system", "os.exec", "os.posix_spawn", "os.fork", "socket.connect")
WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC


def _watch(folder: Path, touched: list[str]) -> Callable[[str, tuple[Any, ...]], None]:
    """An audit hook that notes what is written outside of `folder`, and processes and code started from it."""
    own = (os.path.realpath(folder), "/dev/null", "/dev/tty")

    def hook(event: str, given: tuple[Any, ...]) -> None:
        if event in PROCESSES:
            touched.append(f"{event} {given[0]}"[:200])
        elif event == "exec" and str(getattr(given[0], "co_filename", "")).startswith(own[0]):
            touched.append(f"ran {given[0].co_filename}")
        elif event in CHANGES or (event == "open" and isinstance(given[2], int) and given[2] & WRITING):
            for path in given[event == "os.symlink" : 2 if event in ("os.rename", "os.link", "os.symlink") else 1]:
                place = _place(path, given[-1], is_opened=event == "open")
                if place and not place.startswith(own) and not (event == "os.mkdir" and Path(place).exists()):
                    touched.append(f"{event} {place}"[:200])

    return hook


def _place(path: object, folder: object, *, is_opened: bool) -> str:
    """Where a path leads that an audit event names, below the open directory `folder` if there is one.

    Only a file that is opened is looked for behind a link; what is moved or removed is the link.
    """
    if not isinstance(path, str | bytes | os.PathLike):
        return ""
    above = f"/proc/self/fd/{folder}" if isinstance(folder, int) and Path(f"/proc/self/fd/{folder}").is_dir() else ""
    named = Path(above, os.fsdecode(path))
    return os.path.realpath(named) if is_opened else str(Path(os.path.realpath(named.parent), named.name))
