"""What all benchmarks share: interleaved timing, what the machine is, and lines of results."""

import argparse
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

ROUNDS = 11
HERE = Path(__file__).parent


@dataclass(frozen=True)
class Line:
    """A result: what was measured, the figure, and the target with whether it was met, where there is one."""

    name: str
    text: str
    target: str = ""
    met: bool | None = None


_listed: list[Line] = []
"""Lines for the table in README.md."""


def run_as_command(main: Callable[[bool], None]) -> None:
    """Calls `main` with whether the short form is asked for, and leaves the lines of the table where wanted."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("--short", action="store_true", help="in seconds; its figures mean nothing")
    parser.add_argument("--lines", type=Path, help="file for the lines of the table")
    given = parser.parse_args()
    print(machine())
    if given.short:
        print("the short form: that it runs is all that it tells")
    main(given.short)
    if given.lines:
        given.lines.write_text(json.dumps([asdict(line) for line in _listed]))


def interleaved(
    variants: Mapping[str, Callable[[], object]],
    rounds: int = ROUNDS,
    clock: Callable[[], float] = time.process_time,
) -> dict[str, list[float]]:
    """Times [s] of each variant, taken in turns (A B A B ...), so that a busy machine slows all of them alike.

    Processor time, unless another clock is given.
    """
    times: dict[str, list[float]] = {name: [] for name in variants}
    for _ in range(rounds):
        for name, variant in variants.items():
            began = clock()
            variant()
            times[name].append(clock() - began)
    return times


def spread(values: list[float], unit: str, scale: float = 1.0) -> str:
    """Median and range."""
    shown = [scale * value for value in values]
    return f"{statistics.median(shown):.4g} {unit} (min {min(shown):.4g}, max {max(shown):.4g}, {len(shown)} times)"


def ratios(times: Mapping[str, list[float]], one: str, other: str) -> list[float]:
    """Time of `one` over that of `other`, neighbour by neighbour."""
    return [a / b for a, b in zip(times[one], times[other], strict=True)]


def report(name: str, text: str, target: str = "", met: bool | None = None, *, listed: bool = False) -> None:
    """One line of results; with a target, or `listed`, it is one of the table in README.md."""
    verdict = "" if met is None else ("   target met" if met else "   TARGET MISSED")
    print(f"{name:46s} {text}{f'   target {target}' if target else ''}{verdict}", flush=True)
    if listed or target:
        _listed.append(Line(name.strip(), text, target, None if met is None else bool(met)))


def machine() -> str:
    """What this ran on."""
    cpu = "unknown processor"
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        cpu = next(line.split(":")[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        pass
    import numpy
    import scipy

    from vvdp.generator import binding

    cores = len(os.sched_getaffinity(0))
    versions = f"llvmlite {binding.version().split()[0]}, numpy {numpy.__version__}, scipy {scipy.__version__}"
    system = f"{platform.system()} {platform.machine()}"
    return f"{cpu}, {cores} cores, {system}; Python {platform.python_version()}, {versions}"


@contextmanager
def empty_caches(environment: Mapping[str, str]) -> Iterator[dict[str, str]]:
    """`environment` with caches for compiled code that are empty yet."""
    with tempfile.TemporaryDirectory() as folder:
        yield {**environment, "VVDP_CACHE": f"{folder}/code"}


def compiled(function: Callable[..., Any], kinds: tuple[Any, ...]) -> Any:
    """A plain function for arguments of these types as machine code, which may call the functions of a model."""
    from vvdp.simulation.assembly import Assembly
    from vvdp.simulation.cache import default_cache
    from vvdp.simulation.loops import plain_part

    return Assembly([plain_part(function, kinds)]).load(default_cache())[function.__name__]


def in_new_process(code: str, environment: Mapping[str, str] | None = None) -> dict[str, float]:
    """What `code` prints as JSON on its last line, run in a new process; `wall` and `processor` [s] are added."""
    with tempfile.TemporaryFile() as said, tempfile.TemporaryFile() as answered:
        began = time.perf_counter()
        with subprocess.Popen(
            [sys.executable, "-c", code], stdout=answered, stderr=said, env=environment or os.environ
        ) as running:
            _, status, used = os.wait4(running.pid, 0)
            running.returncode = os.waitstatus_to_exitcode(status)
        wall = time.perf_counter() - began
        said.seek(0), answered.seek(0)
        if running.returncode:
            raise SystemExit(f"a benchmark's process failed:\n{said.read().decode()}")
        last = answered.read().decode().splitlines()[-1]
    return {**json.loads(last), "wall": wall, "processor": used.ru_utime + used.ru_stime}
