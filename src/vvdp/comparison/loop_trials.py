"""Controllers side by side: the same drives, sensors and noise for all of them, many random seeds, all cores."""

import secrets
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.version import VERSION
from vvdp.comparison.contest import Contest, Ran, Trial, contest_of, refuse_nothing, run_trials
from vvdp.comparison.controllers import Controller
from vvdp.comparison.loop_scenarios import LoopScenario
from vvdp.comparison.loop_scores import LoopScore, loop_score, loop_summary
from vvdp.machines.drive_loop import drawn_loop, errors_under_control, seeded_case, tally_of, with_tally
from vvdp.network.build import Circuit
from vvdp.simulation.batch import simulate_batch
from vvdp.simulation.crew import Crew
from vvdp.simulation.link import quiet
from vvdp.simulation.prepare import prepare
from vvdp.simulation.run import Stepping, simulate
from vvdp.studies.engine import HERE, Engine
from vvdp.studies.run import silent
from vvdp.studies.work import check_same

SHOWN = "polluted"
"""The scenario of which a run is drawn, where it is among those that are run."""


@dataclass(frozen=True)
class TracedLoop:
    """One run of every controller: the error against the reference [m] over the time [s] at the samples."""

    scenario: str
    time: Array
    errors: Mapping[str, Array]


@dataclass(frozen=True)
class _Plan:
    """What is compared, as it travels to other processes; plans of one name are one plan. `say` stays here."""

    name: str
    scenarios: Mapping[str, LoopScenario] = field(compare=False)
    controllers: Mapping[str, Controller] = field(compare=False)
    traced: str = field(compare=False)
    say: Callable[[str], None] = field(compare=False)


@dataclass(frozen=True)
class _Loops:
    """The closed loops of all pairs of scenario and controller, compiled, and how the runs of a scenario are stepped;
    `program` is what they depend on."""

    circuits: Mapping[tuple[str, str], Circuit]
    steppings: Mapping[str, Stepping]
    program: tuple[str, ...]


def compare_controllers(
    scenarios: Sequence[LoopScenario],
    controllers: Sequence[Controller],
    seeds: int,
    *,
    engine: Engine = HERE,
    progress: Callable[[int, int], None] = silent,
    say: Callable[[str], None] = quiet,
) -> Contest:
    """Scores of every controller in every scenario over `seeds` random runs.

    All controllers meet the same noise, and the same place of the periodic sensor error on the spool. `engine` says
    where the runs are made, `progress` receives how many are done, of all. Ctrl-C ends the comparison after the current
    batches, at once the second time, and keeps the runs that are done. Raises ParameterError where there is nothing
    to compare, RunError where a worker has another vvdp, or none is left.
    """
    refuse_nothing(scenarios, controllers, seeds, "controllers")
    began = time.perf_counter()
    by_name = {each.name: each for each in scenarios}
    plan = _Plan(
        name=secrets.token_hex(8),
        scenarios=by_name,
        controllers={each.name: each for each in controllers},
        traced=SHOWN if SHOWN in by_name else scenarios[0].name,
        say=say,
    )
    task = partial(_runs_done, replace(plan, say=quiet), _loops(plan).program)
    done = run_trials(task, by_name, seeds, engine, progress)
    found = contest_of(done, scenarios, controllers, seeds, loop_summary)
    return Contest(**found, seconds=time.perf_counter() - began)


@lru_cache(maxsize=1)
def _loops(plan: _Plan) -> _Loops:
    """A plan compiled, once in each process: a text for each controller, whatever the scenario."""
    circuits, steppings, digests = {}, {}, []
    for name, controller in plan.controllers.items():
        for scenario in plan.scenarios.values():
            system = drawn_loop(scenario.values | controller.values)
            circuits[scenario.name, name] = circuit = with_tally(system)
            steppings[scenario.name] = system.stepping
            ready = prepare(circuit.model, circuit.case, system.stepping, say=_with_name(plan, name))
            digests.append(ready.linked.digest)
    return _Loops(circuits, steppings, (VERSION, *digests))


def _with_name(plan: _Plan, name: str) -> Callable[[str], None]:
    """Says which controller is being compiled."""

    def say_name(_: str) -> None:
        plan.say(f"compiling {name} (once, some ten seconds)")

    return say_name


def _runs_done(plan: _Plan, program: tuple[str, ...], batch: Sequence[Trial], cores: int) -> list[Ran]:
    """Results of a batch, in the process that runs it."""
    loops = _loops(plan)
    check_same(loops.program, program)
    scores: dict[Trial, dict[str, LoopScore]] = {trial: {} for trial in batch}
    for name in plan.controllers:
        for alike in _alike(plan, batch):
            for trial, score in zip(alike, _scores(loops, name, alike, cores), strict=True):
                scores[trial][name] = score
    first = Trial(plan.traced, 0)
    traced = _trace(plan, loops) if first in batch else None
    return [Ran(trial.scenario, trial.seed, scores[trial], traced if trial == first else None) for trial in batch]


def _alike(plan: _Plan, batch: Sequence[Trial]) -> list[list[Trial]]:
    """The trials of a batch, those of one sample period together: these run in one call."""
    periods: dict[float, list[Trial]] = {}
    for trial in batch:
        periods.setdefault(plan.scenarios[trial.scenario].period, []).append(trial)
    return list(periods.values())


def _scores(loops: _Loops, name: str, trials: Sequence[Trial], cores: int) -> list[LoopScore]:
    """The scores of a controller in trials of one sample period."""
    cases = [seeded_case(loops.circuits[trial.scenario, name], trial.seed) for trial in trials]
    scenario = trials[0].scenario
    model, stepping = loops.circuits[scenario, name].model, loops.steppings[scenario]
    run = simulate_batch(model, cases, stepping, Crew(cores))
    return [
        loop_score(tally_of(case, memories), reason is None)
        for case, memories, reason in zip(cases, run.final_memories, run.reasons, strict=True)
    ]


def _trace(plan: _Plan, loops: _Loops) -> TracedLoop:
    """The run of seed 0 that is drawn, of every controller."""
    errors: dict[str, Array] = {}
    times = np.zeros(0)
    for name in plan.controllers:
        circuit, stepping = loops.circuits[plan.traced, name], loops.steppings[plan.traced]
        run = simulate(circuit.model, seeded_case(circuit, 0), stepping)
        times, errors[name] = errors_under_control(run, circuit, stepping.sample_period)
    return TracedLoop(plan.traced, times, errors)
