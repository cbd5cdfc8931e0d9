"""Every engine does the same: yields items as they are finished, draws them late, survives its workers."""

import json
import os
import pickle
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
import psutil
import pytest
from tests.words import wording

from vvdp.base.errors import ConfigError, Fault, ParameterError, RunError
from vvdp.base.extras import MissingExtraError
from vvdp.studies import dask_engines
from vvdp.studies.dask_engines import DaskScheduler, LocalDask, Slurm
from vvdp.studies.engine import Engine, ThisProcess, all_cores
from vvdp.studies.run import run_study
from vvdp.studies.study import Random, Study, Uniform

pytestmark = pytest.mark.thorough


@pytest.fixture(scope="module")
def two_workers() -> Iterator[LocalDask]:
    """Two workers, kept from test to test."""
    with LocalDask(2) as engine:
        yield engine


@pytest.fixture(params=["here", "dask"])
def engine(request: pytest.FixtureRequest) -> Engine:
    return ThisProcess(1) if request.param == "here" else request.getfixturevalue("two_workers")


def squared(item: int, cores: int) -> tuple[int, int, int]:
    return item**2, cores, os.getpid()


def refused(item: int, cores: int) -> int:
    raise ParameterError(f"item {item} on {cores} cores")


def asleep(item: float, cores: int) -> float:
    time.sleep(item)
    return item


def deadly(item: int, cores: int) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def test_every_item_comes_once_with_its_result(engine: Engine) -> None:
    found = list(engine.run_all(squared, range(20)))
    assert sorted(item for item, _ in found) == list(range(20))
    assert all(square == item**2 and cores == 1 for item, (square, cores, _) in found)
    assert len({process for _, (_, _, process) in found}) == engine.workers
    assert list(engine.run_all(squared, [])) == []


def test_items_are_drawn_as_workers_are_free(engine: Engine) -> None:
    """So that a caller decides late what comes next: no more are under way than there are workers."""
    drawn: list[int] = []

    def items() -> Iterator[int]:
        for item in range(8):
            drawn.append(item)
            yield item

    come = 0
    for _ in engine.run_all(squared, items()):
        come += 1
        assert len(drawn) <= come - 1 + engine.workers
    assert come == 8


def test_an_error_of_a_task_is_raised_and_the_engine_can_be_used_again(engine: Engine) -> None:
    with pytest.raises(ParameterError, match="item 3 on 1 cores"):
        list(engine.run_all(refused, [3]))
    assert [item for item, _ in engine.run_all(squared, [5])] == [5]


def test_an_error_of_a_file_comes_back_from_a_worker_as_it_was() -> None:
    fault = Fault("drop.toml", 3, "flow", "expected a number")
    sent = pickle.loads(pickle.dumps(ConfigError([fault])))
    assert isinstance(sent, ConfigError) and sent.faults == (fault,) and str(sent) == str(ConfigError([fault]))


def test_workers_are_kept_within_with(two_workers: LocalDask) -> None:
    processes: list[set[int]] = []
    for _ in range(2):
        with two_workers:
            processes.append({process for _, (_, _, process) in two_workers.run_all(squared, range(20))})
    assert processes[0] == processes[1]
    with ThisProcess(1) as here:
        assert [item for item, _ in here.run_all(squared, [5])] == [5]


def test_the_first_to_finish_comes_first(two_workers: LocalDask) -> None:
    assert [item for item, _ in two_workers.run_all(asleep, [1.0, 0.1])] == [0.1, 1.0]


def test_a_caller_may_stop_early(engine: Engine) -> None:
    found = engine.run_all(squared, range(1000))
    next(found)
    found.close()
    assert len(list(engine.run_all(squared, range(3)))) == 3


def test_senseless_numbers_are_refused() -> None:
    with pytest.raises(ParameterError, match=wording.engine.expected_up_to.format(cores=all_cores())):
        ThisProcess(0)
    with pytest.raises(ParameterError, match=wording.engine.workers_with.format(workers=0, cores=1)):
        LocalDask(0)
    with pytest.raises(ParameterError, match=wording.engine.jobs_with.format(jobs=1, cores=0)):
        Slurm(1, 0)


def test_fewer_cores_can_be_set_from_outside(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VVDP_THREADS", "1")
    assert all_cores() == 1
    assert list(ThisProcess().run_all(squared, [2])) == [(2, (4, 1, os.getpid()))]


def test_dask_gives_the_same_numbers(two_workers: LocalDask, tmp_path: Path) -> None:
    random = Random({"oil.air_fraction": Uniform("0.5 %", "2 %")}, 12, 3)
    study = Study("prototype", random, ("efficiency", "mean_load_flow_m3_s"), until="0.1 s")
    here, there = (
        run_study(study, tmp_path / name, engine=on) for name, on in (("a", ThisProcess()), ("b", two_workers))
    )
    for name, column in here.outputs.items():
        assert np.array_equal(column.values, there.outputs[name].values)
    heard: list[str] = []
    again = run_study(study, tmp_path / "a", engine=two_workers, say=heard.append)
    assert again.ran == 0 and heard == [wording.progress.finished_already.format(done=12, all=12, what="cases")]


@pytest.mark.slow
def test_a_worker_that_is_killed_costs_nothing_that_was_finished(
    two_workers: LocalDask, kill_a_worker, kept, tmp_path: Path
) -> None:
    random = Random({"oil.air_fraction": Uniform("0.5 %", "2 %")}, 120, 5)
    study = Study("prototype", random, ("efficiency",), until="0.2 s")
    finished: list[set[str]] = []

    def progress(done: int, total: int) -> None:
        finished.append(kept(tmp_path / "s"))
        if done > 0 and len(finished) <= 3:
            kill_a_worker(lambda: psutil.Process().children(recursive=True))

    found = run_study(study, tmp_path / "s", engine=two_workers, progress=progress)
    assert found.is_finished and found.ran == 120 and not found.failures
    assert all(earlier <= later for earlier, later in pairwise(finished))
    assert np.isfinite(found.outputs["efficiency"].values).all()


def test_an_item_that_kills_every_worker_is_told() -> None:
    with LocalDask(2) as engine, pytest.raises(RunError, match=wording.engine.lost_one_by_one):
        list(engine.run_all(deadly, [1]))


def test_an_engine_without_workers_gives_up_here(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(LocalDask, "_longest_wait", 1.0)
    with LocalDask(1) as engine:
        engine._client.retire_workers()
        with pytest.raises(RunError, match=wording.engine.no_worker_left):
            list(engine.run_all(squared, [1]))


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Callable[..., subprocess.Popen[bytes]]]:
    """Starts a module with arguments; it finds the tests, unless `bare`."""
    started: list[subprocess.Popen[bytes]] = []

    def begun(*command: str, bare: bool = False) -> subprocess.Popen[bytes]:
        path = {} if bare else {"PYTHONPATH": str(Path(__file__).parents[2])}
        quiet = subprocess.DEVNULL
        command = (sys.executable, "-m", *command)
        started.append(subprocess.Popen(command, env={**os.environ, **path}, cwd=tmp_path, stdout=quiet, stderr=quiet))
        return started[-1]

    yield begun
    for process in started:
        process.kill()
        process.wait()


def scheduler_at(place: Path) -> tuple[str, ...]:
    """The command of a scheduler that writes its address to a file."""
    ports = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard")
    return ("distributed.cli.dask_scheduler", *ports, "--scheduler-file", str(place))


def worker_of(address: str) -> tuple[str, ...]:
    return ("distributed.cli.dask_worker", address, "--no-nanny", "--nthreads", "2", "--no-dashboard")


def address_in(place: Path) -> str:
    until = time.monotonic() + 60.0
    while not (place.exists() and place.read_text()) and time.monotonic() < until:
        time.sleep(0.05)
    return json.loads(place.read_text())["address"]


def test_a_scheduler_by_its_address(start, tmp_path: Path) -> None:
    """A scheduler and its workers, each started by hand: workers come late, go, and at last the scheduler goes."""
    scheduler = start(*scheduler_at(tmp_path / "scheduler.json"))
    address = address_in(tmp_path / "scheduler.json")
    heard: list[str] = []
    engine = DaskScheduler(address, say=heard.append)
    with engine:
        assert engine.workers == 1
        first = start(*worker_of(address))
        ((item, (square, cores, process)),) = engine.run_all(squared, [3])
        assert (item, square, cores, process) == (3, 9, min(2, all_cores()), first.pid)
        assert heard == [wording.engine.waiting]
        second = start(*worker_of(address))
        until = time.monotonic() + 60.0
        while engine.workers < 2 and time.monotonic() < until:
            time.sleep(0.05)
        assert engine.workers == 2
        first.kill()
        assert {pid for _, (_, _, pid) in engine.run_all(squared, range(4))} == {second.pid}
        endless = engine.run_all(asleep, [0.01, 60.0])
        next(endless)
        scheduler.kill()
        with pytest.raises(RunError, match=wording.engine.scheduler_lost):
            next(endless)


def test_a_scheduler_without_the_package_of_the_task_is_told(start, tmp_path: Path) -> None:
    start(*scheduler_at(tmp_path / "scheduler.json"), bare=True)
    address = address_in(tmp_path / "scheduler.json")
    start(*worker_of(address))
    with pytest.raises(RunError, match=wording.engine.not_installed_there.format(reason="No module named 'tests'")):
        list(DaskScheduler(address).run_all(squared, [3]))


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "nonsense://x"])
def test_an_address_without_a_scheduler_is_told(address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dask_engines, "CONNECTING", 1.0)
    with pytest.raises(ConfigError, match=wording.engine.no_scheduler):
        list(DaskScheduler(address).run_all(squared, [3]))


def test_what_is_not_installed_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    for engine in (LocalDask(1), DaskScheduler("tcp://127.0.0.1:9"), Slurm()):
        with pytest.raises(MissingExtraError, match=r"which is not installed: pip install 'vvdp\[scale\]'"):
            engine.__enter__()
