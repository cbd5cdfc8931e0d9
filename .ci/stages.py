"""Run the stages of continuous integration in order, and report where the time went.

The report comes last: the seconds of each stage beside its share of the limit, and the slowest tests. A stage that
takes more than twice its share fails the run although it passed, before the limit itself is exceeded.
"""

import os
import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

LIMIT = 90 * 60.0
"""Time for all stages together [s]."""
SLOWEST = 20
"""Tests that the report names."""


class Stage(NamedTuple):
    """A command of the Makefile and the share of `LIMIT` that it takes on two quiet cores with empty caches."""

    target: str
    share: float

    @property
    def most(self) -> float:
        """Seconds above which the stage fails."""
        return 2.0 * self.share * LIMIT


class Timed(NamedTuple):
    """A stage after it ran: its exit code, and seconds."""

    stage: Stage
    code: int
    seconds: float


STAGES = (
    Stage("setup", share=0.03),
    Stage("lint", share=0.02),
    Stage("docs", share=0.02),
    Stage("test", share=0.22),
    Stage("test-thorough", share=0.20),
)


def run_stage(stage: Stage, tests: Path) -> Timed:
    """Run `make TARGET`; the times of its tests are written to the folder `tests`."""
    options = f"{os.environ.get('PYTEST_ADDOPTS', '')} --junitxml={tests / stage.target}.xml"
    began = time.monotonic()
    done = subprocess.run(["make", stage.target], env={**os.environ, "PYTEST_ADDOPTS": options}, check=False)
    return Timed(stage, done.returncode, time.monotonic() - began)


def slowest_tests(tests: Path) -> list[tuple[float, str]]:
    """Seconds and name of the slowest tests of all stages, the slowest first."""
    cases = [case for path in tests.glob("*.xml") for case in ElementTree.parse(path).iter("testcase")]
    return sorted(((float(case.get("time", 0.0)), test_name(case)) for case in cases), reverse=True)[:SLOWEST]


def test_name(case: ElementTree.Element) -> str:
    """The name of a test as pytest takes it, without the folder of all tests."""
    return f"{case.get('classname', '').removeprefix('tests.')}::{case.get('name', '')}"


def report(timed: list[Timed], slowest: list[tuple[float, str]]) -> str:
    """The times of stages and tests as text."""
    lines = [f"{'stage':14} {'s':>6} {'share':>6} {'of at most':>11}"]
    lines += [f"{s.target:14} {seconds:6.0f} {seconds / LIMIT:6.1%} {s.most:9.0f} s" for s, _, seconds in timed]
    lines += [f"{'all':14} {sum(each.seconds for each in timed):6.0f}", "", f"the {len(slowest)} slowest tests [s]"]
    lines += [f"{seconds:6.1f}  {name}" for seconds, name in slowest]
    return "\n".join(lines)


def main() -> int:
    """Run all stages up to the first that fails. Returns the exit code of the run."""
    timed: list[Timed] = []
    with TemporaryDirectory() as folder:
        for stage in STAGES:
            timed.append(run_stage(stage, Path(folder)))
            if timed[-1].code:
                break
        print(report(timed, slowest_tests(Path(folder))))
    slow = [each for each in timed if each.seconds > each.stage.most]
    for stage, _, seconds in slow:
        print(f"make {stage.target}: {seconds:.0f} s are more than twice its share of the limit, {stage.most:.0f} s")
    return timed[-1].code or bool(slow)


if __name__ == "__main__":
    sys.exit(main())
