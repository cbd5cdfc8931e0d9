"""Estimators side by side: the same readings for all of them, many random seeds, all cores."""

import secrets
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.version import VERSION
from vvdp.comparison.contest import Ran, Trial, contest_of, refuse_nothing, run_trials
from vvdp.comparison.estimators import AdaptingSettings, Contender, adapting_start
from vvdp.comparison.figures import Measured
from vvdp.comparison.results import Comparison, Traced
from vvdp.comparison.scenarios import Record, Scenario
from vvdp.comparison.scores import Score, Traces, Truth, score, summary, without_direction
from vvdp.sensing.encoder import Shaft, encoder_start, encoder_step
from vvdp.sensing.wheel import TURN
from vvdp.simulation.link import quiet
from vvdp.simulation.replay import Replay
from vvdp.studies.engine import HERE, Engine
from vvdp.studies.run import silent
from vvdp.studies.work import check_same

COST_SAMPLES = 20_000
"""Samples of the record on which estimators are timed."""
COST_ROUNDS = 9
"""How often each is timed, in turns with the others."""


def simulate_record(scenario: Scenario, encoder: Replay, seed: int, samples: int | None = None) -> Record:
    """The record of one run: clock phase, wheel angle and all noise follow from `seed`.

    `encoder` is the compiled encoder of the scenario; `samples` those until its end unless given.
    """
    random = np.random.default_rng([seed, 3])
    count = scenario.samples if samples is None else samples
    times: Array = (random.uniform() + np.arange(float(count))) / scenario.rate
    angles: Array = random.uniform(0.0, TURN) + scenario.motion.angle(times)
    truth = Truth(times, angles, scenario.motion.speed(times))
    memory = encoder_start(scenario.encoder, times[0], angles[0], float(seed))
    return Record(seed, truth, encoder(memory, np.column_stack(truth), scenario.encoder).shown)


@dataclass(frozen=True)
class _Plan:
    """The comparison, as it is sent to other processes; plans of one name are one plan. `say` stays here."""

    name: str
    scenarios: Mapping[str, Scenario] = field(compare=False)
    contenders: Sequence[Contender] = field(compare=False)
    traced: str = field(compare=False)
    say: Callable[[str], None] = field(compare=False)


@dataclass(frozen=True)
class _Field:
    """All that is needed for a run: the compiled encoders of the scenarios, the compiled steps of the contenders."""

    contenders: Sequence[Contender]
    encoders: Mapping[str, Replay]
    steps: Mapping[str, Replay]
    loops: Mapping[tuple[str, str], Replay]  # by estimator and scenario
    traced: str

    @property
    def program(self) -> tuple[str, ...]:
        """Versions and digests that its results depend on, besides the plan."""
        compiled = (*self.encoders.values(), *self.steps.values(), *self.loops.values())
        return VERSION, *(each.digest for each in compiled)

    def run(self, scenario: Scenario, seed: int) -> Ran:
        record = simulate_record(scenario, self.encoders[scenario.name], seed)
        truth = without_direction(record.truth, scenario.motion)
        scores: dict[str, Score] = {}
        speeds: dict[str, Array] = {}
        for contender in self.contenders:
            traces = self.traces(contender, scenario, record)
            scores[contender.name] = score(traces, truth, scenario.motion, scenario.scored_from, scenario.sector)
            speeds[contender.name] = traces.speed
        shown = seed == 0 and scenario.name == self.traced
        traced = Traced(scenario.name, truth.time, truth.speed, speeds) if shown else None
        return Ran(scenario.name, seed, scores, traced)

    def traces(self, contender: Contender, scenario: Scenario, record: Record) -> Traces:
        if contender.loop is None:
            return run_estimator(contender, self.steps[contender.name], record, contender.rows(scenario, record))
        loop = self.loops[contender.name, scenario.name]
        memory = adapting_start(scenario, record, contender.settings)
        return _shown_traces(loop, loop(memory, np.column_stack(record.truth)).shown)


def run_estimator(contender: Contender, step: Replay, record: Record, rows: Array) -> Traces:
    """Estimates of a contender from its `rows`; `step` is its own, compiled."""
    shown = step(contender.memory, rows).shown
    if contender.afterwards is not None:
        return contender.afterwards(record.truth.time, shown, contender.settings)
    return _shown_traces(step, shown)


def _shown_traces(step: Replay, shown: Array) -> Traces:
    """The fields of `Estimate` in what a step shows, by itself or as its field `estimate`."""
    place = {column.removeprefix("estimate."): place for place, column in reversed(list(enumerate(step.columns)))}
    return Traces(**{name: shown[:, place[name]] for name in Traces._fields})


def compare(
    scenarios: Sequence[Scenario],
    contenders: Sequence[Contender],
    seeds: int,
    *,
    engine: Engine = HERE,
    progress: Callable[[int, int], None] = silent,
    say: Callable[[str], None] = quiet,
) -> Comparison:
    """Scores of every contender in every scenario over `seeds` random runs.

    All contenders get the same readings. `engine` says where the runs are made; what a sample costs is measured here.
    `progress` receives how many runs are done, of all. Ctrl-C ends the comparison after the current batches, at once
    the second time, and keeps the runs that are done. Raises ParameterError where there is nothing to compare, RunError
    where a worker has another vvdp, or none is left.
    """
    refuse_nothing(scenarios, contenders, seeds, "estimators")
    began = time.perf_counter()
    traced = next((scenario for scenario in scenarios if scenario.motion.step), scenarios[0])
    by_name = {each.name: each for each in scenarios}
    plan = _Plan(name=secrets.token_hex(8), scenarios=by_name, contenders=contenders, traced=traced.name, say=say)
    compiled = _field(plan)
    costs = _costs(compiled, scenarios[0])  # before the runs: these would slow each other, and all is compiled then
    task = partial(_runs_done, replace(plan, say=quiet), compiled.program)
    done = run_trials(task, by_name, seeds, engine, progress)
    return Comparison(
        **contest_of(done, scenarios, contenders, seeds, summary),
        sectors=scenarios[0].sectors,
        rate=scenarios[0].rate,
        costs=costs,
        steps=frozenset(each.name for each in scenarios if each.motion.step is not None),
        causal=frozenset(each.name for each in contenders if each.afterwards is None),
        seconds=time.perf_counter() - began,
    )


@lru_cache(maxsize=1)
def _field(plan: _Plan) -> _Field:
    """A plan compiled, once in each process."""
    say, scenarios = plan.say, plan.scenarios
    loops = [each for each in plan.contenders if each.loop is not None]
    return _Field(
        contenders=plan.contenders,
        encoders={name: compiled_encoder(each, say=_with_name(say, "encoder")) for name, each in scenarios.items()},
        steps={each.name: compiled_step(each, say=_with_name(say, each.name)) for each in plan.contenders},
        loops={
            (each.name, name): compiled_loop(each, scenario, say=_with_name(say, each.name))
            for each in loops
            for name, scenario in scenarios.items()
        },
        traced=plan.traced,
    )


def _with_name(say: Callable[[str], None], name: str) -> Callable[[str], None]:
    """Says what is being compiled, in place of a line that is the same for all."""

    def say_name(_: str) -> None:
        say(f"compiling {name} (once, a few seconds)")

    return say_name


def compiled_encoder(scenario: Scenario, *, say: Callable[[str], None] = quiet) -> Replay:
    """The encoder of a scenario, compiled."""
    memory = encoder_start(scenario.encoder, 0.0, 0.0, 0.0)
    return Replay(encoder_step, memory, Shaft(0.0, 0.0, 0.0), scenario.encoder, say=say)


def compiled_step(contender: Contender, *, say: Callable[[str], None] = quiet) -> Replay:
    """The step of an estimator, compiled."""
    return Replay(contender.step, contender.memory, contender.reading, contender.settings, say=say)


def compiled_loop(contender: Contender, scenario: Scenario, *, say: Callable[[str], None] = quiet) -> Replay:
    """An estimator in a loop with the encoder of a scenario, compiled."""
    assert contender.loop is not None
    truth = Truth(np.zeros(1), np.zeros(1), np.zeros(1))
    memory = adapting_start(scenario, Record(0, truth, np.zeros((1, 5))), contender.settings)
    settings = AdaptingSettings(encoder=scenario.encoder, estimator=contender.settings)
    return Replay(contender.loop, memory, Shaft(0.0, 0.0, 0.0), settings, say=say)


def _runs_done(plan: _Plan, program: tuple[str, ...], batch: Sequence[Trial], cores: int) -> list[Ran]:
    """Results of a batch, in the process that runs it."""
    compiled = _field(plan)
    check_same(compiled.program, program)
    with ThreadPoolExecutor(cores) as pool:
        return list(pool.map(lambda trial: compiled.run(plan.scenarios[trial.scenario], trial.seed), batch))


def _costs(field: _Field, scenario: Scenario) -> dict[str, Measured]:
    """Time that a sample takes each contender on one core [s]: the least of all rounds, as other work only adds to it;
    its error is by how much the median of the rounds is longer."""
    record = simulate_record(scenario, field.encoders[scenario.name], 0, COST_SAMPLES)
    rows = {contender.name: contender.rows(scenario, record) for contender in field.contenders}
    taken: dict[str, list[float]] = {name: [] for name in rows}
    for _ in range(COST_ROUNDS):
        for contender in field.contenders:
            began = time.perf_counter()
            run_estimator(contender, field.steps[contender.name], record, rows[contender.name])
            taken[contender.name].append((time.perf_counter() - began) / COST_SAMPLES)
    return {name: Measured(min(times), float(np.median(times)) - min(times)) for name, times in taken.items()}
