"""The present code against a commit that has landed, run in turns: what an error of the means costs in both.

The commit is taken out of the history into a temporary folder and runs in a process of its own, by what a person calls:
`load_system` and `simulate`. Each part of the books (every loss, flow and mean) is held against a run of the present
code at the tightest tolerance, relative to the part or, where that is smaller, to a thousandth of the largest of its
kind.
"""

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from statistics import median
from typing import Any

from benchmarks.measure import HERE, report, run_as_command

COMMIT = "9f61fe19"
"""Landed before events were: what "today" means in the targets."""
SYSTEM, UNTIL = "prototype", 0.5
TOLERANCES = (1e-5, 1e-6, 1e-7, 1e-8, 1e-9)
CONVERGED = 1e-12
PART_ERROR, SPEED_TARGET, COST_TARGET = 1e-5, 2.4, 3.5

WORKER = """
import json, sys, time
from dataclasses import replace
from vvdp.simulation.run import simulate
from vvdp.simulation.values import leaves
from vvdp.systems.system import load_system

loaded = {}
for line in sys.stdin:
    name, until, tolerance = json.loads(line)
    if (name, until) not in loaded:
        loaded[name, until] = load_system(name, until=f"{until!r} s")
    system = loaded[name, until]
    stepping = system.stepping
    if tolerance is not None:
        stepping = replace(stepping, relative_tolerance=tolerance)
    began, began_cpu = time.perf_counter(), time.process_time()
    run = simulate(system.model, system.case, stepping)
    cpu, wall = time.process_time() - began_cpu, time.perf_counter() - began
    books = dict(zip([path for path, _, _ in leaves(system.case.state)], map(float, run.final)))
    books = {path: value for path, value in books.items() if path.startswith("books.")}
    print(json.dumps({"cpu": cpu, "wall": wall, "tolerance": stepping.relative_tolerance, "books": books}), flush=True)
"""


class Build:
    """A version of the code in a process of its own."""

    def __init__(self, folder: Path, cache: Path | None) -> None:
        environment = {**os.environ, "PYTHONPATH": str(folder / "src")}
        if cache is not None:
            environment |= {"VVDP_CACHE": str(cache)}
        self.process = subprocess.Popen(
            [sys.executable, "-c", WORKER], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment
        )

    def run(self, until: float, tolerance: float | None) -> dict[str, Any]:
        """Processor and wall time [s], tolerance and books of a run."""
        assert self.process.stdin is not None and self.process.stdout is not None
        self.process.stdin.write(json.dumps([SYSTEM, until, tolerance]) + "\n")
        self.process.stdin.flush()
        answer = self.process.stdout.readline()
        if not answer:
            raise SystemExit("a build has ended with an error")
        found: dict[str, Any] = json.loads(answer)
        return found

    def __enter__(self) -> "Build":
        return self

    def __exit__(self, *_: object) -> None:
        assert self.process.stdin is not None
        self.process.stdin.close()
        self.process.wait()


@contextmanager
def taken_out(commit: str) -> Iterator[Path | None]:
    """A folder with the tree of a commit; None where the history is not there."""
    root = HERE.parent
    with tempfile.TemporaryDirectory() as folder:
        try:
            tree = subprocess.run(["git", "-C", root, "archive", commit], capture_output=True, check=True).stdout
        except (OSError, subprocess.CalledProcessError):
            yield None
            return
        subprocess.run(["tar", "-x", "-C", folder], input=tree, check=True)
        yield Path(folder)


def part_error(books: Mapping[str, float], converged: Mapping[str, float]) -> float:
    """Largest error of a part that both builds book; the sums at the top of the books are parts as well."""
    found = 0.0
    for path in books.keys() & converged.keys():
        group = path.rpartition(".")[0]
        throughput = max(abs(value) for other, value in converged.items() if other.rpartition(".")[0] == group)
        if throughput > 0.0:
            found = max(found, abs(books[path] - converged[path]) / max(abs(converged[path]), 1e-3 * throughput))
    return found


def main(short: bool) -> None:
    """Seconds and errors of both at several tolerances, and what the default and an error of 1e-5 cost."""
    until, rounds, tolerances = (0.005, 2, TOLERANCES[:1]) if short else (UNTIL, 9, TOLERANCES)
    with ExitStack() as stack:
        folder = stack.enter_context(taken_out(COMMIT))
        if folder is None:
            report("reference build", f"skipped: commit {COMMIT} is not in the history here", listed=True)
            return
        cache = Path(stack.enter_context(tempfile.TemporaryDirectory())) / "cache"
        # The short form runs the present code twice: the other's loop takes half a minute to compile.
        builds = {
            "now": stack.enter_context(Build(HERE.parent, None)),
            COMMIT: stack.enter_context(Build(*((HERE.parent, None) if short else (folder, cache)))),
        }
        converged = builds["now"].run(until, CONVERGED)["books"]
        measured: dict[tuple[str, float | None], list[dict[str, Any]]] = {}
        for tolerance in (None, *tolerances):
            for build in builds.values():
                build.run(until, tolerance)  # compiled before the clock starts
            for _ in range(rounds):
                for name, build in builds.items():
                    measured.setdefault((name, tolerance), []).append(build.run(until, tolerance))
    _tell(measured, converged, until)


def _tell(
    measured: Mapping[tuple[str, float | None], list[dict[str, Any]]], converged: Mapping[str, float], until: float
) -> None:
    least: dict[str, float] = {}
    for (name, tolerance), runs in measured.items():
        seconds, error = min(run["cpu"] for run in runs), part_error(runs[0]["books"], converged)
        at = f"at {runs[0]['tolerance']:.0e}" + (", its default" if tolerance is None else "")
        text = f"{1e3 * seconds / until:.3g} ms of processor time per simulated second, largest error of a part"
        report(f"{name} {at}", f"{text} {error:.1e}", listed=True)
        if error <= PART_ERROR:
            least[name] = min(least.get(name, seconds), seconds)
    pairs = zip(measured[COMMIT, None], measured["now", None], strict=True)
    speed = median(old["cpu"] / new["cpu"] for old, new in pairs)
    name = "simulated seconds per second at the defaults, now over then"
    report(name, f"{speed:.3g} times", f"{SPEED_TARGET:g}", speed >= SPEED_TARGET)
    if least.keys() >= {"now", COMMIT}:
        cost = least[COMMIT] / least["now"]
        name = f"processor time with all parts within {PART_ERROR:.0e}, then over now"
        report(name, f"{cost:.3g} times", f"{COST_TARGET:g}", cost >= COST_TARGET)


if __name__ == "__main__":
    run_as_command(main)
