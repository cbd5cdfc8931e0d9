"""Rival circuits on the same duty cycles: every pair of both is run, brought to one tracking error, and what became of
the power is read."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import NamedTuple

from vvdp.base.errors import ParameterError, RunError
from vvdp.base.version import VERSION
from vvdp.comparison.contest import carry_out
from vvdp.comparison.equal_error import Attempt, attempts, closest, common_error, rms_speed
from vvdp.machines.duties import Duty
from vvdp.rivals.rival_account import (
    COMMON_RATE,
    CircuitScore,
    CircuitTrace,
    begin_of,
    circuit_score,
    circuit_trace,
    joint_score,
    refuse_unled,
    system_for,
)
from vvdp.rivals.rival_circuits import RivalCircuit
from vvdp.simulation.link import quiet
from vvdp.simulation.run import compiled_loop, simulate
from vvdp.studies.engine import HERE, Engine
from vvdp.studies.run import silent
from vvdp.studies.work import Batching, check_same


class Pair(NamedTuple):
    """A duty and a circuit, by name."""

    duty: str
    circuit: str


class CircuitRun(NamedTuple):
    """A pair that was run; `failure` says why it broke off, and its score is None then.

    `tried` is what the poles of the filter before its loop come to; the score is that of `tried[kept]`. `begins` are
    the times at which control of each cylinder begins [s].
    """

    duty: str
    circuit: str
    score: CircuitScore | None
    trace: CircuitTrace | None
    failure: str = ""
    tried: tuple[Attempt, ...] = ()
    kept: int = 0
    begins: tuple[float, ...] = ()


@dataclass(frozen=True, kw_only=True)
class CircuitComparison:
    """Results of every circuit on every duty, in the order in which they were asked for.

    `error` is the rms error to which all were brought [m]; None where not all were, and then `untuned` names those
    that were run with the common reference only.
    """

    duties: Mapping[str, Duty]
    circuits: Mapping[str, RivalCircuit]
    found: tuple[CircuitRun, ...]
    error: float | None
    untuned: tuple[Pair, ...]
    seconds: float
    finished: bool

    @property
    def runs(self) -> int:
        """How many runs were made."""
        return len(self.found)

    @property
    def all_runs(self) -> int:
        """How many were asked for."""
        return len(self.duties) * len(self.circuits)

    @property
    def missing(self) -> tuple[str, ...]:
        """The pairs that were not run, and those that were not brought to the common error."""
        done = {(run.duty, run.circuit) for run in self.found}
        left = [f"{c} on {d}" for d in self.duties for c in self.circuits if (d, c) not in done]
        return (*left, *(f"{pair.circuit} on {pair.duty} at the common error" for pair in self.untuned))

    def score(self, duty: str, circuit: str) -> CircuitScore | None:
        """The score of a pair; None where it was not run, or broke off."""
        return next((run.score for run in self.found if (run.duty, run.circuit) == (duty, circuit)), None)


@dataclass(frozen=True)
class _Plan:
    """The comparison, as it is sent to other processes. `say` stays here."""

    duties: Mapping[str, Duty]
    circuits: Mapping[str, RivalCircuit]
    say: Callable[[str], None] = field(compare=False)


def compare_circuits(
    duties: Sequence[Duty],
    circuits: Sequence[RivalCircuit],
    *,
    error: float | None = None,
    engine: Engine = HERE,
    progress: Callable[[int, int], None] = silent,
    say: Callable[[str], None] = quiet,
) -> CircuitComparison:
    """Results of every circuit on every duty, all at one tracking error.

    All are run with the common reference first. Then each is run with other poles before its loop until its rms error
    is `error` [m], without it the largest that any had at first, rounded up to three digits.

    `engine` says where the runs are made, `progress` receives how many are done, of all. Ctrl-C ends the comparison
    after the current runs, at once the second time, and keeps what is done. Raises ParameterError where there is
    nothing to compare, and for a duty that a circuit cannot follow, before any run.
    """
    if not duties or not circuits:
        raise ParameterError(f"{len(duties)} duty cycles and {len(circuits)} circuits; expected at least one of each")
    if error is not None and not error > 0.0:
        raise ParameterError(f"error: {1e3 * error:g} mm must be greater than 0")
    began = time.perf_counter()
    plan = _Plan({each.name: each for each in duties}, {each.name: each for each in circuits}, say)
    pairs = [Pair(duty, circuit) for duty in plan.duties for circuit in plan.circuits]
    for pair in pairs:
        circuit, duty = plan.circuits[pair.circuit], plan.duties[pair.duty]
        for each in (duty,) if circuit.shares else duty.alone:
            system_for(circuit, each)
    compiled_loop(say)
    done, wanted, untuned = _carried_out(replace(plan, say=quiet), pairs, error, engine, progress)
    order = {pair: place for place, pair in enumerate(pairs)}
    return CircuitComparison(
        duties=plan.duties,
        circuits=plan.circuits,
        found=tuple(sorted(done, key=lambda run: order[Pair(run.duty, run.circuit)])),
        error=wanted if not untuned else None,
        untuned=tuple(sorted(untuned, key=lambda pair: order[pair])),
        seconds=time.perf_counter() - began,
        finished=len(done) == len(pairs) and not untuned,
    )


def _carried_out(
    plan: _Plan, pairs: Sequence[Pair], error: float | None, engine: Engine, progress: Callable[[int, int], None]
) -> tuple[list[CircuitRun], float | None, list[Pair]]:
    """All pairs at the common reference, then at one error; the error, and the pairs that were not brought to it."""
    both, batching = 2 * len(pairs), Batching(least=1, seconds=2.0)

    def first(done: int, total: int) -> None:
        progress(done, both)

    def second(done: int, total: int) -> None:
        progress(both - total + done, both)

    found = carry_out(partial(_runs, plan, VERSION), pairs, engine, first, batching)
    scores = [run.score for run in found if run.score is not None]
    if len(found) < len(pairs) or not scores:
        return found, None, []
    wanted = common_error([score.tracking_rms for score in scores]) if error is None else error
    tunable = [run for run in found if run.score is not None]
    failed = [run for run in found if run.score is None]
    try:
        tuned = carry_out(partial(_tune_pairs, plan, VERSION, wanted), tunable, engine, second, batching)
    except KeyboardInterrupt:
        tuned = []
    done = {(run.duty, run.circuit) for run in tuned}
    left = [run for run in tunable if (run.duty, run.circuit) not in done]
    return failed + left + tuned, wanted, [Pair(run.duty, run.circuit) for run in left]


def run_pair(
    circuit: RivalCircuit,
    duty: Duty,
    rate: float = COMMON_RATE,
    begins: Sequence[float] = (),
) -> CircuitRun:
    """The run of a circuit on a duty, with its score; one that breaks off says why.

    Where a duty has several cylinders and the circuit moves one, each has a circuit of its own, and the trace is that
    of the first.

    rate    of the poles of the filter before its loop [1/s]
    begins  when control of each begins, where that is known [s]
    """
    parts = (duty,) if circuit.shares else duty.alone
    try:
        starts = tuple(begins) or tuple(begin_of(circuit, each) for each in parts)
        runs = [_run_circuit(circuit, each, begin, rate) for each, begin in zip(parts, starts, strict=True)]
    except RunError as problem:
        return CircuitRun(duty.name, circuit.name, None, None, str(problem))
    score = joint_score([score for score, _ in runs]) if len(runs) > 1 else runs[0][0]
    attempt = Attempt(rate, score.tracking_rms, score.drawn - score.returned)
    return CircuitRun(duty.name, circuit.name, score, runs[0][1], tried=(attempt,), begins=starts)


def _run_circuit(circuit: RivalCircuit, duty: Duty, begin: float, rate: float) -> tuple[CircuitScore, CircuitTrace]:
    """The score of a circuit on a duty that begins at `begin` [s], and its last round."""
    system = system_for(circuit, duty, begin, rate)
    run = simulate(system.model, system.case, system.stepping)
    refuse_unled(circuit, system, duty, run)
    return circuit_score(circuit, system, run, duty, begin), circuit_trace(system, run, duty, begin)


def tuned_pair(circuit: RivalCircuit, duty: Duty, run: CircuitRun, wanted: float) -> CircuitRun:
    """A run brought to the `wanted` rms error [m], or as close as its poles bring it."""
    runs = [run]

    def attempt(rate: float) -> Attempt | None:
        found = run_pair(circuit, duty, rate, run.begins)
        if found.score is None:
            return None
        runs.append(found)
        return found.tried[0]

    tried = attempts(attempt, run.tried[0], wanted, rms_speed(duty.cycle))
    kept = closest(tried, wanted)
    return runs[kept]._replace(tried=tuple(tried), kept=kept)


def _runs(plan: _Plan, version: str, pairs: Sequence[Pair], cores: int) -> list[CircuitRun]:
    """Results of some pairs, in the process that runs them."""
    check_same(VERSION, version)
    return [run_pair(plan.circuits[pair.circuit], plan.duties[pair.duty]) for pair in pairs]


def _tune_pairs(plan: _Plan, version: str, wanted: float, runs: Sequence[CircuitRun], cores: int) -> list[CircuitRun]:
    """Results of some runs at the wanted error, in the process that runs them."""
    check_same(VERSION, version)
    return [tuned_pair(plan.circuits[run.circuit], plan.duties[run.duty], run, wanted) for run in runs]
