"""Rival circuits on the same duty cycles: every pair of both is run, and what became of the power is read."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

import vvdp
from vvdp.base.arrays import Array, Rows
from vvdp.base.errors import ParameterError, RunError
from vvdp.comparison.circuits import SINKS, RivalCircuit
from vvdp.comparison.contest import carry_out
from vvdp.comparison.duties import Duty
from vvdp.simulation.link import quiet
from vvdp.simulation.outcome import outcome
from vvdp.simulation.record import record_of
from vvdp.simulation.run import Run, compiled_loop, simulate
from vvdp.studies.engine import HERE, Engine
from vvdp.studies.run import silent
from vvdp.studies.work import Batching, check_same
from vvdp.systems.summary import Summary, simulated_summary
from vvdp.systems.system import System

ROUNDS = 3
"""How often a cycle is gone through; powers are those of the last round."""
SETTLED = 1.0
"""Errors count from this time on [s]."""
RECORD = 1e-3
"""Between two recorded rows [s]."""
OUTSIDE = ("books.supplied.load_force", "books.supplied.tank")
"""What brings energy in but is no drive."""


class Pair(NamedTuple):
    """A duty and a circuit, by name."""

    duty: str
    circuit: str


class CircuitScore(NamedTuple):
    """What a circuit came to on a duty: mean powers over the last round [W], errors [m], pressures, gauge [Pa].

    `delivered` goes to the rod while it is pushed, `received` comes from it while the load overruns; `drawn` is taken
    from the drives of all pumps, `returned` given back to them. Pressures are those of both chambers and the supply,
    over every step; `charge` is what the low side is held at, NaN where nothing holds it.
    """

    tracking_max: float
    tracking_rms: float
    tracking_first: float
    drawn: float
    returned: float
    delivered: float
    received: float
    friction: float
    stored: float
    sinks: tuple[float, ...]
    pressure_max: float
    pressure_min: float
    charge: float
    energy_residual: float
    mass_residual: float


class CircuitTrace(NamedTuple):
    """The last round of a run, thinned: times from its begin [s], reference, position [m] and both pressures [Pa]."""

    time: Array
    reference: Array
    position: Array
    pressure_a: Array
    pressure_b: Array


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

    @property
    def runs(self) -> int:
        """How many runs were made."""
        return len(self.found)

    @property
    def asked(self) -> int:
        """How many were asked for."""
        return len(self.duties) * len(self.circuits)

    @property
    def finished(self) -> bool:
        """Whether all were made."""
        return self.runs == self.asked

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

    `engine` says where the runs are made, `progress` hears how many are done, of all. Ctrl-C ends the comparison after
    the current runs, at once the second time, and keeps what is done. Raises ParameterError where there is nothing to
    compare, and for a duty that a circuit cannot follow, before any run.
    """
    if not duties or not circuits:
        raise ParameterError(f"{len(duties)} duty cycles and {len(circuits)} circuits; expected at least one of each")
    began = time.perf_counter()
    plan = _Plan({each.name: each for each in duties}, {each.name: each for each in circuits}, cache, say)
    pairs = [Pair(duty, circuit) for duty in plan.duties for circuit in plan.circuits]
    for pair in pairs:
        timed_system(plan.circuits[pair.circuit], plan.duties[pair.duty])
    compiled_loop(say)
    task = partial(_runs, replace(plan, say=quiet), vvdp.__version__)
    done = carry_out(task, pairs, engine, progress, Batching(least=1, seconds=2.0))
    order = {pair: place for place, pair in enumerate(pairs)}
    found = tuple(sorted(done, key=lambda run: order[Pair(run.duty, run.circuit)]))
    return CircuitComparison(
        duties=plan.duties, circuits=plan.circuits, found=found, seconds=time.perf_counter() - began
    )


def timed_system(circuit: RivalCircuit, duty: Duty) -> System:
    """A circuit sized for a duty, to be run for a few rounds. Raises ParameterError where it cannot follow."""
    try:
        system = circuit.sized(duty)
    except ParameterError as problem:
        raise ParameterError(f"{circuit.name} on {duty.name}: {problem}") from None
    stepping = replace(system.stepping, until=ROUNDS * duty.period, record_interval=RECORD, window=0.0)
    return replace(system, stepping=stepping, average_from=(ROUNDS - 1) * duty.period)


def run_pair(circuit: RivalCircuit, duty: Duty, cache: Path | None = None) -> CircuitRun:
    """The run of a circuit on a duty, with its score; one that breaks off says why."""
    system = timed_system(circuit, duty)
    try:
        run = simulate(system.model, system.case, system.stepping, cache=cache)
    except RunError as problem:
        return CircuitRun(duty.name, circuit.name, None, None, str(problem))
    score = circuit_score(circuit, system, run)
    return CircuitRun(duty.name, circuit.name, score, _trace(system, run))


def circuit_score(circuit: RivalCircuit, system: System, run: Run) -> CircuitScore:
    """The score of a run that came to its end."""
    found = simulated_summary(outcome(run, system.average_from), system)
    t, command, state = run.times, run.command, run.state
    error = np.abs(state.rod.position - command.loop.reference)
    late, last = t >= SETTLED, np.flatnonzero(t >= system.average_from - 0.5 * RECORD)
    drawn, returned = _drive_powers(run, last)
    delivered, received = _rod_powers(system, run, last)
    reference = system.tables["oil"].reference_pressure
    volumes = [name for name in ("chamber_a", "chamber_b", "supply") if f"pressure_max_{name}_Pa" in found]
    return CircuitScore(
        tracking_max=float(np.max(error[late])),
        tracking_rms=float(np.sqrt(np.mean(error[late] ** 2))),
        tracking_first=float(np.max(error[~late])),
        drawn=drawn,
        returned=returned,
        delivered=delivered,
        received=received,
        friction=float(found["loss_friction_W"] + found["loss_end_stops_W"]),
        stored=float(found["stored_power_W"]),
        sinks=_sinks(circuit, found),
        pressure_max=max(float(found[f"pressure_max_{name}_Pa"]) for name in volumes),
        pressure_min=min(float(found[f"pressure_min_{name}_Pa"]) for name in volumes[:2]),
        charge=np.nan if circuit.charge is None else circuit.charge(system.tables) - reference,
        energy_residual=float(found["energy_residual"]),
        mass_residual=float(found["mass_residual"]),
    )


def _sinks(circuit: RivalCircuit, found: Summary) -> tuple[float, ...]:
    return tuple(float(sum(found[key] for key in circuit.sinks.get(sink, ()))) for sink in SINKS)


def _drive_powers(run: Run, rows: Rows) -> tuple[float, float]:
    """Mean power that the drives of all pumps give, and that they are given back [W], over `rows`."""
    times, states = run.times[rows], record_of(run).states
    paths = [path for path in states if path.startswith("books.supplied.") and path not in OUTSIDE]
    steps = np.concatenate([np.diff(states[path].values[rows]) for path in paths])
    lasts = float(times[-1] - times[0])
    return float(np.sum(steps[steps > 0.0])) / lasts, float(-np.sum(steps[steps < 0.0])) / lasts


def _rod_powers(system: System, run: Run, rows: Rows) -> tuple[float, float]:
    """Mean power of the oil on the rod while it pushes, and of the rod on the oil while the load overruns [W]."""
    cylinder, reference, state = system.tables["cylinder"], system.tables["oil"].reference_pressure, run.state
    force = (state.chamber_a - reference) * cylinder.area_a - (state.chamber_b - reference) * cylinder.area_b
    times, power = run.times[rows], (force * state.rod.velocity)[rows]
    lasts = float(times[-1] - times[0])
    pushing, driven = (float(np.trapezoid(np.clip(sign * power, 0.0, None), times)) for sign in (1.0, -1.0))
    return pushing / lasts, driven / lasts


def _trace(system: System, run: Run) -> CircuitTrace:
    rows = np.flatnonzero(run.times >= system.average_from)
    thin = rows[:: max(1, rows.size // 1000)]
    reference, state = system.tables["oil"].reference_pressure, run.state
    return CircuitTrace(
        time=run.times[thin] - system.average_from,
        reference=run.command.loop.reference[thin],
        position=state.rod.position[thin],
        pressure_a=state.chamber_a[thin] - reference,
        pressure_b=state.chamber_b[thin] - reference,
    )


def _runs(plan: _Plan, version: str, pairs: Sequence[Pair], cores: int) -> list[CircuitRun]:
    """What comes of some pairs, where they are run."""
    check_same(vvdp.__version__, version)
    return [run_pair(plan.circuits[pair.circuit], plan.duties[pair.duty], plan.cache) for pair in pairs]
