"""Common parts of all comparisons: each scenario with many seeds, all contenders in each of these runs, all cores."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol, TypeVar

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ParameterError
from vvdp.comparison.figures import Measured
from vvdp.studies.engine import Engine
from vvdp.studies.run import hold_interrupts
from vvdp.studies.work import FOR_CASES, Batching, Task, batches

Asked = TypeVar("Asked")
Done = TypeVar("Done")


class Titled(Protocol):
    """A scenario or a contender: its name, and what it is."""

    @property
    def name(self) -> str: ...

    @property
    def title(self) -> str: ...


class Trial(NamedTuple):
    """A run: the name of its scenario, and its seed."""

    scenario: str
    seed: int


class Ran(NamedTuple):
    """A run that came to its end: the score of every contender, and what is to be drawn of it, if anything."""

    scenario: str
    seed: int
    scores: Mapping[str, object]
    traced: Any = None


class Played(NamedTuple):
    """A scenario as it was run: with how many seeds."""

    title: str
    runs: int


@dataclass(frozen=True, kw_only=True)
class Contest:
    """Scores of every contender in every scenario.

    `seeds` were asked for; `contenders` has their titles, `scores` the figures by scenario and contender; `traced` is
    what is drawn of one run.
    """

    seeds: int
    scenarios: Mapping[str, Played]
    contenders: Mapping[str, str]
    scores: Mapping[tuple[str, str], Mapping[str, Measured]]
    traced: Any
    seconds: float
    finished: bool

    @property
    def runs(self) -> int:
        """How many runs were made."""
        return sum(played.runs for played in self.scenarios.values())

    @property
    def all_runs(self) -> int:
        """How many were asked for."""
        return self.seeds * len(self.scenarios)

    @property
    def missing(self) -> tuple[str, ...]:
        """The scenarios that lack runs, each with how many."""
        lacking = {name: self.seeds - played.runs for name, played in self.scenarios.items()}
        return tuple(f"{count} of {name}" for name, count in lacking.items() if count)

    @property
    def scenarios_run(self) -> dict[str, Played]:
        """The scenarios that were run at least once."""
        return {name: played for name, played in self.scenarios.items() if played.runs}


def refuse_nothing(scenarios: Sequence[Titled], contenders: Sequence[Titled], seeds: int, what: str) -> None:
    """Raises ParameterError where there is nothing to compare; `what` the contenders are, such as "estimators"."""
    if not scenarios or not contenders or seeds < 1:
        raise ParameterError(
            f"{len(scenarios)} scenarios, {len(contenders)} {what} and {seeds} seeds; expected at least one each"
        )


def run_trials(
    task: Task[Trial, Ran],
    scenarios: Iterable[str],
    seeds: int,
    engine: Engine,
    progress: Callable[[int, int], None],
) -> list[Ran]:
    """The runs that came to their end, ordered by seed; `task` makes them, seed by seed through all scenarios.

    Ctrl-C ends it after the current batches, at once the second time; raised again where no run was done by then.
    """
    trials = [Trial(scenario, seed) for seed in range(seeds) for scenario in scenarios]
    done = carry_out(task, trials, engine, progress)
    return sorted(done, key=lambda ran: ran.seed)  # sums then do not depend on which was done first


def carry_out(
    task: Task[Asked, Done],
    asked: Sequence[Asked],
    engine: Engine,
    progress: Callable[[int, int], None],
    batching: Batching = FOR_CASES,
) -> list[Done]:
    """Results of `task` for all that is `asked`, as far as it came to its end.

    Ctrl-C ends it after the current batches, at once the second time; raised again where nothing was done by then.
    """
    done: list[Done] = []
    progress(0, len(asked))
    try:
        with hold_interrupts() as interrupted:
            for some in batches(task, asked, engine, interrupted, batching):
                done += some
                progress(len(done), len(asked))
    except KeyboardInterrupt:
        if not done:
            raise
    if not done:
        raise KeyboardInterrupt  # nothing to keep
    return done


def contest_of(
    done: Sequence[Ran],
    scenarios: Sequence[Titled],
    contenders: Sequence[Titled],
    seeds: int,
    summary: Callable[[Array], Mapping[str, Measured]],
) -> dict[str, Any]:
    """The fields of a contest but its seconds; `summary` makes figures of the scores of a pair, a row for each run."""
    runs = {scenario.name: [ran for ran in done if ran.scenario == scenario.name] for scenario in scenarios}
    return {
        "seeds": seeds,
        "scenarios": {each.name: Played(each.title, len(runs[each.name])) for each in scenarios},
        "contenders": {each.name: each.title for each in contenders},
        "scores": {
            (name, contender.name): summary(np.array([ran.scores[contender.name] for ran in found]))
            for name, found in runs.items()
            if found
            for contender in contenders
        },
        "traced": next((ran.traced for ran in done if ran.traced is not None), None),
        "finished": len(done) == seeds * len(scenarios),
    }
