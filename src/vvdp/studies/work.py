"""Many cases carried out by an engine: in batches of the right size, each kept as soon as it is done."""

import functools
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Generic, TypeAlias, TypeVar

import numpy as np

from vvdp.studies.engine import Engine
from vvdp.studies.store import Finished, is_store, keep_finished, write_finished

BATCH_SECONDS = 4.0
"""What a batch should take: no more than that is lost when a machine is switched off."""

FIRST_BATCH, LARGEST_BATCH = 16, 1000
"""Cases in the first batches, which show how long they take, and in any at most."""

Case = TypeVar("Case")
Task: TypeAlias = Callable[[Sequence[Case], int], list[Finished]]
"""Runs a batch of cases on so many cores."""


def kept_batches(
    task: Task[Case],
    cases: Sequence[Case],
    directory: Path,
    engine: Engine,
    interrupted: threading.Event,
    group: Callable[[Case], object] = type,
) -> Iterator[list[Finished]]:
    """Yields the finished cases of each batch as they come, written to the store `directory` and its index.

    Cases follow one another as given; those of a batch are of the same `group`. Once `interrupted` is set, only the
    batches at hand are finished. A worker that sees `directory` writes there itself: should the caller be gone by
    then, the next run finds the batch. What `task` raises is raised here.
    """
    work = _Work(list(cases), engine, group, interrupted)
    for _, ran in engine.completed(functools.partial(_kept_batch, task, directory.resolve()), work.batches()):
        work.learn(ran)
        keep_finished(directory, ran.done)
        yield ran.done


@dataclass(frozen=True)
class _Ran:
    """A batch as it comes back from where it was run."""

    done: list[Finished]
    seconds: float


def _kept_batch(task: Task[Case], directory: Path, batch: Sequence[Case], cores: int) -> _Ran:
    began = time.perf_counter()
    done = task(batch, cores)
    if is_store(directory):
        with suppress(OSError):  # then the caller keeps it
            write_finished(directory, done)
    return _Ran(done, time.perf_counter() - began)


class _Work(Generic[Case]):
    """The cases not yet handed out."""

    def __init__(
        self, cases: list[Case], engine: Engine, group: Callable[[Case], object], interrupted: threading.Event
    ) -> None:
        self.cases, self.engine, self.group, self.interrupted = cases, engine, group, interrupted
        self.least = self.timely = int(np.clip(self.share(), 1, FIRST_BATCH))

    def share(self) -> int:
        """The number of cases that leaves as many for every worker."""
        return -(-len(self.cases) // self.engine.workers)

    def batches(self) -> Iterator[list[Case]]:
        """Batches as they are asked for."""
        while self.cases and not self.interrupted.is_set():
            size = max(self.least, min(self.timely, self.share()))
            _, alike = next(groupby(self.cases[:size], self.group))
            batch = list(alike)
            self.cases = self.cases[len(batch) :]
            yield batch

    def learn(self, ran: _Ran) -> None:
        """Takes the size of the batches to come from how long one took."""
        self.timely = int(np.clip(BATCH_SECONDS * len(ran.done) / ran.seconds, self.least, LARGEST_BATCH))
