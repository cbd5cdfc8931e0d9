"""The threads that carry out the compiled work of a batch, and who may stop them."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from vvdp.base.errors import ParameterError
from vvdp.simulation import places

LOOK = 5e-3
"""Between two questions whether to stop [s]."""

Queue = npt.NDArray[np.int64]  # (2,), see `vvdp.simulation.places`


def all_cores() -> int:
    """How many cores this process may use; `VVDP_THREADS` can make them fewer."""
    affinity = getattr(os, "sched_getaffinity", None)
    cores = len(affinity(0)) if affinity else os.cpu_count() or 1
    return max(1, min(cores, int(os.environ.get("VVDP_THREADS") or cores)))


def never() -> bool:
    """Does not stop anything."""
    return False


def require_cores(cores: int | None) -> None:
    """Raises ParameterError where this process may not use so many cores; None is all of them."""
    if cores is not None and not 1 <= cores <= all_cores():
        raise ParameterError(f"{cores} cores; expected 1 to {all_cores()}")


@dataclass(frozen=True)
class Crew:
    """A thread for each of `cores` (all unless said), for one piece of work after the other until `stop` states this.

    `stop` is asked every few milliseconds, in the thread of the caller; then all is left as it is. Raises
    ParameterError where there are not so many cores.
    """

    cores: int | None = None
    stop: Callable[[], bool] = never
    queue: Queue = field(default_factory=lambda: np.zeros(2, np.int64))

    def __post_init__(self) -> None:
        require_cores(self.cores)

    @property
    def is_halted(self) -> bool:
        """Whether the threads were stopped."""
        return bool(self.queue[places.HALT])

    def carry_out(self, work: Callable[[Queue], None]) -> None:
        """Calls `work`, compiled code without the interpreter's lock, on each thread, with a queue that they share.

        Ctrl-C, or whatever else `stop` raises, halts the threads and is raised again when they have ended.
        """
        self.queue[places.NEXT] = 0
        threads = self.cores or all_cores()
        with ThreadPoolExecutor(threads) as pool:
            try:
                at_work = {pool.submit(work, self.queue) for _ in range(threads)}
                while at_work:
                    if self.stop():
                        self.queue[places.HALT] = 1
                    ended, at_work = wait(at_work, LOOK)
                    for each in ended:
                        each.result()
            except BaseException:
                self.queue[places.HALT] = 1
                raise
