"""Studies in processes of their own, to be killed."""

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import psutil
import pytest
from tests.slurm import own_slurm  # noqa: F401

from vvdp.studies.study import Random, Study, Uniform

LONG = """
import sys
from pathlib import Path
from vvdp.studies.dask_engines import LocalDask, Slurm
from vvdp.studies.engine import ThisProcess
from vvdp.studies.run import run_study
from vvdp.studies.study import Random, Study, Uniform

if __name__ == "__main__":
    random = Random({"oil.air_fraction": Uniform("0.5 %", "2 %")}, 120, 5)
    jobs = Slurm(2, memory="1 GiB", options=["--partition=short"], interface="lo", logs=Path(sys.argv[1], "slurm"))
    engine = {"here": ThisProcess(), "dask": LocalDask(2), "slurm": jobs}[sys.argv[2]]
    run_study(Study("prototype", random, ("efficiency",), until="0.3 s"), sys.argv[1], engine=engine)
    print("end")
"""


@pytest.fixture
def begin_study(tmp_path: Path) -> Iterator[Callable[[Path, str], subprocess.Popen[str]]]:
    """Begins a study of 120 cases into a directory, here, on Dask or on SLURM, in a process group of its own."""
    script = tmp_path / "long.py"
    script.write_text(LONG)
    begun: list[subprocess.Popen[str]] = []

    def begin(directory: Path, where: str) -> subprocess.Popen[str]:
        begun.append(
            subprocess.Popen(
                [sys.executable, str(script), str(directory), where],
                env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
                start_new_session=True,
            )
        )
        return begun[-1]

    yield begin
    for process in begun:
        process.kill()
        process.communicate()


@pytest.fixture
def long_study() -> Study:
    """The study that `begin_study` begins."""
    random = Random({"oil.air_fraction": Uniform("0.5 %", "2 %")}, 120, 5)
    return Study("prototype", random, ("efficiency",), until="0.3 s")


@pytest.fixture
def awaited() -> Callable[[Callable[[], object], subprocess.Popen[str]], None]:
    """Waits until a condition is fulfilled, or a process has ended."""

    def wait(condition: Callable[[], object], process: subprocess.Popen[str]) -> None:
        until = time.monotonic() + 300.0
        while not condition() and process.poll() is None and time.monotonic() < until:
            time.sleep(0.002)

    return wait


@pytest.fixture
def kept() -> Callable[[Path], set[str]]:
    """The keys of the cases that the files of a study have."""

    def keys(directory: Path) -> set[str]:
        return {
            case["key"] for path in directory.glob("cases-*.json") for case in json.loads(path.read_text())["cases"]
        }

    return keys


@pytest.fixture
def kill_a_worker() -> Callable[[Callable[[], Iterable[psutil.Process]]], None]:
    """Kills the first process of Dask's workers among those given, which may end while they are looked at."""

    def is_worker(process: psutil.Process) -> bool:
        try:
            return "spawn_main" in " ".join(process.cmdline())
        except psutil.NoSuchProcess:  # a zombie is one too
            return False

    def kill(processes: Callable[[], Iterable[psutil.Process]]) -> None:
        until = time.monotonic() + 60.0
        while not (workers := [p for p in processes() if is_worker(p)]) and time.monotonic() < until:
            time.sleep(0.01)
        workers[0].kill()

    return kill
