"""Rival circuits on the same duty cycles: every pair of both is run, and what became of the power is read."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

from vvdp.base.errors import ParameterError, RunError
from vvdp.base.version import VERSION
from vvdp.comparison.contest import carry_out
from vvdp.simulation.link import quiet
from vvdp.simulation.run import compiled_loop, simulate
from vvdp.studies.engine import HERE, Engine
from vvdp.studies.run import silent
from vvdp.studies.work import Batching, check_same
from vvdp.systems.displacement.duties import Duty
from vvdp.systems.displacement.rival_account import (
    CircuitScore,
    CircuitTrace,
    begin_of,
    circuit_score,
    circuit_trace,
    joint_score,
    refuse_unled,
    system_for,
)
from vvdp.systems.displacement.rival_circuits import RivalCircuit


class Pair(NamedTuple):
    """A duty and a circuit, by name."""

    duty: str
    circuit: str


class CircuitRun(NamedTuple):
    """A pair that was run; `failure` says why it broke off, and its score is None then."""

    duty: str
    circuit: str
    score: CircuitScore | None
    trace: CircuitTrace | None
    failure: str = ""


@dataclass(frozen=True, kw_only=True)
class CircuitComparison:
    """What every circuit came to on every duty, in the order in which they were asked for."""

    duties: Mapping[str, Duty]
    circuits: Mapping[str, RivalCircuit]
    found: tuple[CircuitRun, ...]
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
        """The pairs that were not run."""
        done = {(run.duty, run.circuit) for run in self.found}
        return tuple(f"{c} on {d}" for d in self.duties for c in self.circuits if (d, c) not in done)

    def score(self, duty: str, circuit: str) -> CircuitScore | None:
        """The score of a pair; None where it was not run, or broke off."""
        return next((run.score for run in self.found if (run.duty, run.circuit) == (duty, circuit)), None)


@dataclass(frozen=True)
class _Plan:
    """What is compared, as it travels to other processes. `say` stays here."""

    duties: Mapping[str, Duty]
    circuits: Mapping[str, RivalCircuit]
    cache: Path | None
    say: Callable[[str], None] = field(compare=False)


def compare_circuits(
    duties: Sequence[Duty],
    circuits: Sequence[RivalCircuit],
    *,
    engine: Engine = HERE,
    progress: Callable[[int, int], None] = silent,
    say: Callable[[str], None] = quiet,
    cache: Path | None = None,
) -> CircuitComparison:
    """What every circuit comes to on every duty.

    `engine` says where the runs are made, `progress` receives how many are done, of all. Ctrl-C ends the comparison
    after the current runs, at once the second time, and keeps what is done. Raises ParameterError where there is
    nothing to compare, and for a duty that a circuit cannot follow, before any run.
    """
    if not duties or not circuits:
        raise ParameterError(f"{len(duties)} duty cycles and {len(circuits)} circuits; expected at least one of each")
    began = time.perf_counter()
    plan = _Plan({each.name: each for each in duties}, {each.name: each for each in circuits}, cache, say)
    pairs = [Pair(duty, circuit) for duty in plan.duties for circuit in plan.circuits]
    for pair in pairs:
        circuit, duty = plan.circuits[pair.circuit], plan.duties[pair.duty]
        for each in (duty,) if circuit.shares else duty.alone:
            system_for(circuit, each)
    compiled_loop(say)
    task = partial(_runs, replace(plan, say=quiet), VERSION)
    done = carry_out(task, pairs, engine, progress, Batching(least=1, seconds=2.0))
    order = {pair: place for place, pair in enumerate(pairs)}
    found = tuple(sorted(done, key=lambda run: order[Pair(run.duty, run.circuit)]))
    return CircuitComparison(
        duties=plan.duties,
        circuits=plan.circuits,
        found=found,
        seconds=time.perf_counter() - began,
        finished=len(found) == len(pairs),
    )


def run_pair(circuit: RivalCircuit, duty: Duty, cache: Path | None = None) -> CircuitRun:
    """The run of a circuit on a duty, with its score; one that breaks off says why.

    Where a duty has several cylinders and the circuit moves one, each has a circuit of its own, and the trace is that
    of the first.
    """
    if circuit.shares:
        return _run_circuit(circuit, duty, cache)
    runs = [_run_circuit(circuit, each, cache) for each in duty.alone]
    scores = [run.score for run in runs if run.score is not None]
    if len(scores) < len(runs):
        return CircuitRun(duty.name, circuit.name, None, None, next(run.failure for run in runs if run.failure))
    return CircuitRun(duty.name, circuit.name, joint_score(scores), runs[0].trace)


def _run_circuit(circuit: RivalCircuit, duty: Duty, cache: Path | None) -> CircuitRun:
    """The run of one circuit on a duty."""
    try:
        begin = begin_of(circuit, duty, cache)
        system = system_for(circuit, duty, begin)
        run = simulate(system.model, system.case, system.stepping, cache=cache)
        refuse_unled(circuit, system, duty, run)
    except RunError as problem:
        return CircuitRun(duty.name, circuit.name, None, None, str(problem))
    score = circuit_score(circuit, system, run, begin)
    return CircuitRun(duty.name, circuit.name, score, circuit_trace(circuit, system, run))


def _runs(plan: _Plan, version: str, pairs: Sequence[Pair], cores: int) -> list[CircuitRun]:
    """What comes of some pairs, where they are run."""
    check_same(VERSION, version)
    return [run_pair(plan.circuits[pair.circuit], plan.duties[pair.duty], plan.cache) for pair in pairs]
