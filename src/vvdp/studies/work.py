"""Many cases carried out by an engine: in batches of the right size, each kept as soon as it is done if wanted."""

import functools
import platform
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from itertools import groupby
from pathlib import Path
from typing import Any, Generic, NamedTuple, TypeAlias, TypeVar

import numpy as np

from vvdp.base.errors import RunError
from vvdp.studies.engine import Engine, Result
from vvdp.studies.store import Finished, is_store, keep_finished, write_finished

LARGEST_BATCH = 1000
"""Cases in a batch at most."""

Case = TypeVar("Case")
Task: TypeAlias = Callable[[Sequence[Case], int], list[Result]]
"""Runs a batch of cases on so many cores."""


class Batching(NamedTuple):
    """How cases are put together.

    least    cases in a batch at least, and in the first ones, which show how long they take
    seconds  what a batch should take: no more than that is lost when a machine is switched off
    group    cases of a batch are of the same
    """

    least: int = 16
    seconds: float = 4.0
    group: Callable[[Any], object] = type


FOR_CASES = Batching()


def kept_batches(
    task: Task[Case, Finished],
    cases: Sequence[Case],
    directory: Path,
    engine: Engine,
    interrupted: threading.Event,
    batching: Batching = FOR_CASES,
) -> Iterator[list[Finished]]:
    """Yields the finished cases of each batch as they come, written to the store `directory` and its index.

    Batches are those of `batches`. A worker that sees `directory` writes there itself: should the caller be gone by
    then, the next run finds the batch.
    """
    for done in batches(
        functools.partial(_run_and_keep, task, directory.resolve()), cases, engine, interrupted, batching
    ):
        keep_finished(directory, done)
        yield done


def batches(
    task: Task[Case, Result],
    cases: Sequence[Case],
    engine: Engine,
    interrupted: threading.Event,
    batching: Batching = FOR_CASES,
) -> Iterator[list[Result]]:
    """Yields what `task` makes of each batch of `cases` as they come.

    Cases follow one another as given. Once `interrupted` is set, only the current batches are finished. What `task`
    raises is raised here.
    """
    work = _Work(list(cases), engine, batching, interrupted)
    for batch, (done, seconds) in engine.run_all(functools.partial(_run_timed, task), work.batches()):
        work.learn(len(batch), seconds)
        yield done


def check_same(here: object, asked: object) -> None:
    """Raises RunError where a worker, `here`, has another program than the machine that `asked`."""
    if here != asked:
        raise RunError(f"{platform.node()} has another vvdp, Python, NumPy or LLVM than this machine; install the same")


def _run_and_keep(task: Task[Case, Finished], directory: Path, batch: Sequence[Case], cores: int) -> list[Finished]:
    done = task(batch, cores)
    if is_store(directory):
        with suppress(OSError):  # then the caller keeps it
            write_finished(directory, done)
    return done


def _run_timed(task: Task[Case, Result], batch: Sequence[Case], cores: int) -> tuple[list[Result], float]:
    began = time.perf_counter()
    done = task(batch, cores)
    return done, time.perf_counter() - began


class _Work(Generic[Case]):
    """The cases not yet handed out."""

    def __init__(self, cases: list[Case], engine: Engine, batching: Batching, interrupted: threading.Event) -> None:
        self.cases, self.engine, self.batching, self.interrupted = cases, engine, batching, interrupted
        self.least = self.timely = int(np.clip(self.share(), 1, batching.least))

    def share(self) -> int:
        """The number of cases that leaves as many for every worker."""
        return -(-len(self.cases) // self.engine.workers)

    def batches(self) -> Iterator[list[Case]]:
        """Batches as they are asked for."""
        while self.cases and not self.interrupted.is_set():
            size = max(self.least, min(self.timely, self.share()))
            _, alike = next(groupby(self.cases[:size], self.batching.group))
            batch = list(alike)
            self.cases = self.cases[len(batch) :]
            yield batch

    def learn(self, count: int, seconds: float) -> None:
        """Takes the size of the batches to come from how long one with `count` cases took."""
        self.timely = int(np.clip(self.batching.seconds * count / seconds, self.least, LARGEST_BATCH))
