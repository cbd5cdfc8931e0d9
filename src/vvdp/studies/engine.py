"""Execution engines: an engine takes a task and items, and yields each item with its result as it is finished."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Protocol, Self, TypeVar

from vvdp.simulation.crew import all_cores, require_cores

Item = TypeVar("Item")
Result = TypeVar("Result")


class Engine(Protocol):
    """Carries out one task for many items, in this process or elsewhere.

    Within `with engine:` workers are kept from one call of `run_all` to the next.
    """

    def __enter__(self) -> Self: ...

    def __exit__(self, *reason: object) -> None: ...

    @property
    def workers(self) -> int:
        """How many items are worked on at a time, as far as is known now; at least 1."""
        ...

    def run_all(self, task: Callable[[Item, int], Result], items: Iterable[Item]) -> Iterator[tuple[Item, Result]]:
        """Yields every item with `task(item, cores)`, in the order in which they are finished.

        An item is enough work to keep all cores of a worker busy; `cores` says how many these are. Items are drawn only
        as workers are free for them, so `items` may be a generator that looks at what has come so far, and ends early.
        `task` and items travel to other processes: `task` is a function of a module, or a `functools.partial` of one,
        and the same item may be begun twice where a worker is lost. What a task raises is raised here.
        """
        ...


@dataclass(frozen=True)
class ThisProcess:
    """Item by item in this process, each on `cores` cores (all unless said)."""

    cores: int | None = None

    def __post_init__(self) -> None:
        require_cores(self.cores)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *reason: object) -> None:
        pass

    @property
    def workers(self) -> int:
        """One item at a time."""
        return 1

    def run_all(self, task: Callable[[Item, int], Result], items: Iterable[Item]) -> Iterator[tuple[Item, Result]]:
        """See `Engine`."""
        for item in items:
            yield item, task(item, self.cores or all_cores())


HERE = ThisProcess()
"""The engine that needs nothing: all cores of this process."""
