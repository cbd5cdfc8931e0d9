"""What all benchmarks share: interleaved timing, what the machine is, and lines of results."""

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
from pathlib import Path

ROUNDS = 11
HERE = Path(__file__).parent


def interleaved(variants: Mapping[str, Callable[[], object]], rounds: int = ROUNDS) -> dict[str, list[float]]:
    """Times [s] of each variant, taken in turns (A B A B ...), so that a busy machine slows all of them alike."""
    times: dict[str, list[float]] = {name: [] for name in variants}
    for _ in range(rounds):
        for name, variant in variants.items():
            began = time.perf_counter()
            variant()
            times[name].append(time.perf_counter() - began)
    return times


def spread(values: list[float], unit: str, scale: float = 1.0) -> str:
    """Median and range."""
    shown = [scale * value for value in values]
    return f"{statistics.median(shown):.4g} {unit} (min {min(shown):.4g}, max {max(shown):.4g}, {len(shown)} times)"


def ratios(times: Mapping[str, list[float]], one: str, other: str) -> list[float]:
    """Time of `one` over that of `other`, neighbour by neighbour."""
    return [a / b for a, b in zip(times[one], times[other], strict=True)]


def report(name: str, text: str, target: str = "", met: bool | None = None) -> None:
    """One line of results."""
    verdict = "" if met is None else ("   target met" if met else "   TARGET MISSED")
    print(f"{name:46s} {text}{f'   target {target}' if target else ''}{verdict}", flush=True)


def machine() -> str:
    """What this ran on."""
    cpu = "unknown processor"
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        cpu = next(line.split(":")[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        pass
    import numba
    import numpy
    import scipy

    cores = len(os.sched_getaffinity(0))
    load = ", ".join(f"{x:.1f}" for x in os.getloadavg())
    versions = f"numba {numba.__version__}, numpy {numpy.__version__}, scipy {scipy.__version__}"
    system = f"{platform.system()} {platform.machine()}"
    return f"{cpu}, {cores} cores, {system}, load {load}; Python {platform.python_version()}, {versions}"


@contextmanager
def empty_caches(environment: Mapping[str, str]) -> Iterator[dict[str, str]]:
    """`environment` with caches for compiled code that are empty yet."""
    with tempfile.TemporaryDirectory() as folder:
        yield {**environment, "VVDP_CACHE": f"{folder}/circuits", "NUMBA_CACHE_DIR": f"{folder}/numba"}


def in_new_process(code: str, environment: Mapping[str, str] | None = None) -> dict[str, float]:
    """What `code` prints as JSON on its last line, run in a new process; `wall` [s] is added."""
    began = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, env=environment or os.environ
    )
    wall = time.perf_counter() - began
    if done.returncode:
        raise SystemExit(f"a benchmark's process failed:\n{done.stderr}")
    return {**json.loads(done.stdout.splitlines()[-1]), "wall": wall}
