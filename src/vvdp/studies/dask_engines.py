"""Engines on Dask: workers of this machine, those of a scheduler that runs already, and jobs of a SLURM cluster.

Every one keeps as many items under way as there are workers, and gives each all threads of its worker. A worker that is
lost costs the item it was at, which another one begins again.
"""

import functools
import importlib
import logging
import math
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import KW_ONLY, dataclass, field
from pathlib import Path
from queue import Empty, Queue
from typing import Any, ClassVar, Self

from vvdp.base.errors import ParameterError, RunError, unusable
from vvdp.base.extras import require
from vvdp.simulation.crew import all_cores
from vvdp.simulation.link import quiet
from vvdp.studies.engine import Item, Result

PATIENCE = 0.5
"""Time [s] after which the workers are counted again while none of the items is finished."""

CENSUS = 10.0
"""Time [s] between two looks at which jobs have ended, while workers are missing."""

MOST_LOST = 4
"""Jobs that may end one after the other before one of them has begun to work."""

CONNECTING = 15.0
"""Time [s] within which a scheduler must answer."""


@dataclass
class DaskEngine(ABC):
    """Common parts of the engines on Dask.

    Workers are started for every call of `run_all`; within `with engine:` they are kept. `say` is informed of a wait.
    """

    _longest_wait: ClassVar[float] = math.inf  # [s] for workers to come

    _: KW_ONLY
    say: Callable[[str], None] = quiet
    _client: Any = field(default=None, init=False, repr=False)
    _opened: ExitStack = field(default_factory=ExitStack, init=False, repr=False)
    _depth: int = field(default=0, init=False, repr=False)  # of `with` in `with`

    @property
    @abstractmethod
    def workers(self) -> int:
        """How many items are worked on at a time, as far as is known now; at least 1."""

    @abstractmethod
    def _scheduler(self, opened: ExitStack) -> Any:
        """A cluster that ends with `opened`, or the address of a scheduler."""

    def _plugins(self) -> Sequence[Any]:
        """Plugins that workers load before they get work."""
        return ()

    def _tend(self, count: int) -> None:  # noqa: B027
        """Sees to workers that are missing, `count` being there. Raises RunError where none will come."""

    def __enter__(self) -> Self:
        if self._client is None:
            with ExitStack() as opened:
                self._client = opened.enter_context(self._connect(opened))
                self._opened = opened.pop_all()
        self._depth += 1
        return self

    def __exit__(self, *reason: object) -> None:
        self._depth -= 1
        if self._depth == 0:
            self._client = None
            self._opened.close()

    @contextmanager
    def _connect(self, opened: ExitStack) -> Iterator[Any]:
        """A Dask client. Raises ConfigError where no scheduler answers."""
        distributed = library("distributed")
        place = self._scheduler(opened)
        try:
            client = distributed.Client(place, timeout=CONNECTING, set_as_default=False)
        except (OSError, ValueError) as problem:
            raise unusable(str(place), f"no Dask scheduler answers there ({problem})") from None
        with client:
            for plugin in self._plugins():
                client.register_plugin(plugin, name="vvdp")
            yield client

    def run_all(self, task: Callable[[Item, int], Result], items: Iterable[Item]) -> Iterator[tuple[Item, Result]]:
        """See `Engine`. Raises RunError where an item brings its workers down, and where the scheduler is lost."""
        with self:
            yield from self._run_all(task, items)

    def _run_all(self, task: Callable[[Item, int], Result], items: Iterable[Item]) -> Iterator[tuple[Item, Result]]:
        client, supply = self._client, iter(items)
        on_worker = functools.partial(_on_worker, task)
        under_way: dict[Any, Item] = {}
        ended: Queue[Any] = Queue()
        more, since = True, math.inf
        try:
            while True:
                count = _worker_count(client)
                while more and len(under_way) < count:
                    try:
                        item = next(supply)
                    except StopIteration:
                        more = False
                    else:
                        future = client.submit(on_worker, item, pure=False)
                        under_way[future] = item
                        future.add_done_callback(ended.put)
                if not under_way and not more:
                    return
                self._tend(count)
                if count:
                    since = math.inf
                elif since == math.inf:
                    since = time.monotonic()
                    self.say("waiting for Dask workers")
                elif time.monotonic() - since > self._longest_wait:
                    raise RunError("no Dask worker is left")
                try:
                    future = ended.get(timeout=PATIENCE)
                except Empty:
                    continue
                yield under_way.pop(future), _result(future)
        finally:
            for future in under_way:
                future.cancel()


@dataclass
class LocalDask(DaskEngine):
    """`workers` processes of this machine (as many as it has cores for), each with `cores` cores (one)."""

    _longest_wait: ClassVar[float] = 60.0  # one that was killed is replaced sooner

    count: int | None = None
    cores: int = 1

    def __post_init__(self) -> None:
        if self.cores < 1 or (self.count is not None and self.count < 1):
            raise ParameterError(f"{self.count} workers with {self.cores} cores each; expected at least one of each")

    @property
    def workers(self) -> int:
        """How many were asked for."""
        return self.count or max(1, all_cores() // self.cores)

    def _scheduler(self, opened: ExitStack) -> Any:
        cluster = library("distributed").LocalCluster(
            n_workers=self.workers,
            threads_per_worker=self.cores,
            processes=True,
            memory_limit=None,
            dashboard_address=":0",
            silence_logs=logging.CRITICAL,
        )
        return opened.enter_context(cluster)

    def _plugins(self) -> Sequence[Any]:
        return (_deaf_to_interrupts(),)


@dataclass
class DaskScheduler(DaskEngine):
    """The workers of the scheduler at `address`, for example "tcp://10.0.0.7:8786", however many there are."""

    address: str

    @property
    def workers(self) -> int:
        """How many there are now."""
        return max(1, _worker_count(self._client)) if self._client else 1

    def _scheduler(self, _opened: ExitStack) -> Any:
        return self.address


@dataclass
class Slurm(DaskEngine):
    """`jobs` SLURM jobs that are submitted from here, each a worker with `cores` cores.

    `memory` and `time` are those of a job. `options` go to sbatch as they are, for example `["--partition=short"]`;
    what is not said here is taken from dask-jobqueue's own configuration. A job that ends is submitted again.
    `interface` is the network through which jobs reach this process, `logs` the folder for what jobs print.
    """

    jobs: int = 1
    cores: int = 1
    memory: str = "2 GiB"
    time: str = "01:00:00"
    options: Sequence[str] = ()
    interface: str | None = None
    logs: Path | None = None
    _cluster: Any = field(default=None, init=False, repr=False)
    _looked: float = field(default=0.0, init=False, repr=False)
    _lost: int = field(default=0, init=False, repr=False)  # jobs that have ended since one was at work

    def __post_init__(self) -> None:
        if self.jobs < 1 or self.cores < 1:
            raise ParameterError(f"{self.jobs} jobs with {self.cores} cores each; expected at least one of each")

    @property
    def workers(self) -> int:
        """How many jobs were asked for."""
        return self.jobs

    def _scheduler(self, opened: ExitStack) -> Any:
        dask_jobqueue = library("dask_jobqueue")
        if shutil.which("sbatch") is None:
            raise unusable("sbatch", "is not installed here; SLURM jobs are submitted with it")
        import dask

        given = {} if self.interface is None else {"interface": self.interface}
        cluster = dask_jobqueue.SLURMCluster(
            cores=self.cores,
            processes=1,
            memory=self.memory,
            walltime=self.time,
            job_extra_directives=[*dask.config.get("jobqueue.slurm.job-extra-directives", ()), *self.options],
            log_directory=None if self.logs is None else str(self.logs),
            python=sys.executable,
            scheduler_options={"dashboard_address": ":0"},
            silence_logs=logging.CRITICAL,
            **given,
        )
        opened.enter_context(cluster)
        _check_job(cluster.job_script())
        cluster.adapt(minimum_jobs=self.jobs, maximum_jobs=self.jobs)
        self._cluster, self._looked, self._lost = cluster, time.monotonic(), 0
        return cluster

    def _tend(self, count: int) -> None:
        """Submits jobs again that have ended before they were workers; of those that were, Dask is informed by
        itself.
        """
        if count:
            self._lost = 0
        if count >= self.jobs or time.monotonic() - self._looked < CENSUS:
            return
        self._looked = time.monotonic()
        there = {worker["name"] for worker in self._cluster.scheduler_info["workers"].values()}
        waited_for = {name: job.job_id for name, job in dict(self._cluster.workers).items() if name not in there}
        ended = {name: job for name, job in waited_for.items() if job and not _is_queued(job)}
        if not ended:
            return
        self._lost += len(ended)
        if self._lost >= MOST_LOST and not count:
            said = f"; see {self.logs}/dask-worker-{next(iter(ended.values()))}.err" if self.logs else ""
            raise RunError(f"{self._lost} SLURM jobs have ended, one after the other, before they were at work{said}")
        self._cluster.loop.add_callback(self._submit_again, tuple(ended))

    def _submit_again(self, names: Sequence[str]) -> None:
        for name in names:
            self._cluster.workers.pop(name, None)
        self._cluster.scale(jobs=self.jobs)


def library(name: str) -> Any:
    """A library of the extra `scale`. Raises MissingExtraError where it is not installed."""
    require(name, "scale", "work on Dask or SLURM")
    return importlib.import_module(name)


def _check_job(script: str) -> None:
    """Raises ConfigError with what sbatch has against a job; once submitted, it would not be reported."""
    with tempfile.NamedTemporaryFile("w", suffix=".sh") as file:
        file.write(script)
        file.flush()
        found = subprocess.run(["sbatch", "--test-only", file.name], capture_output=True, text=True)
    if found.returncode:
        raise unusable("sbatch", found.stderr.strip() or f"ended with {found.returncode}")


def _is_queued(job: str) -> bool:
    """Whether SLURM has a job waiting or running; one of which it cannot show is taken for it."""
    found = subprocess.run(["squeue", "-h", "-o", "%i", "-j", job], capture_output=True, text=True)
    return bool(found.stdout.strip()) or (found.returncode != 0 and "Invalid job id" not in found.stderr)


def _worker_count(client: Any) -> int:
    """How many workers there are now. Raises RunError where the scheduler is lost."""
    try:
        return len(client.nthreads())
    except (OSError, ValueError) as problem:  # a client that has closed itself answers with a ValueError
        raise _worker_loss(problem) from None


def _result(future: Any) -> Any:
    """Return value of a task, or raises what the task raised. Raises RunError if the task cannot come to an end."""
    from distributed import CancelledError
    from distributed.scheduler import KilledWorker

    try:
        return future.result()
    except KilledWorker as problem:
        raise RunError(f"the workers that took up the same item were lost one after the other: {problem}") from None
    except CancelledError as problem:
        raise _worker_loss(problem) from None
    except RuntimeError as problem:
        if isinstance(problem.__cause__, ImportError):
            raise RunError(f"the task is not installed where it is to be run: {problem.__cause__}") from None
        raise


def _worker_loss(problem: BaseException) -> RunError:
    return RunError(f"the Dask scheduler is lost ({type(problem).__name__})")


_at_work = threading.Lock()


def _on_worker(task: Callable[[Item, int], Result], item: Item) -> Result:
    """A task on all cores of a worker, one at a time.

    Compiled code that the caller has kept is used where the file system is shared; a worker with another processor
    compiles its own beside it.
    """
    from distributed import get_worker

    with _at_work:
        return task(item, min(get_worker().state.nthreads, all_cores()))


def _deaf_to_interrupts() -> Any:
    """A plugin: Ctrl-C reaches all processes of a terminal, and a worker must finish what it is at."""
    from distributed import WorkerPlugin

    class DeafToInterrupts(WorkerPlugin):
        def setup(self, worker: object) -> None:  # noqa: ARG002
            if threading.current_thread() is threading.main_thread():
                signal.signal(signal.SIGINT, signal.SIG_IGN)

    return DeafToInterrupts()
