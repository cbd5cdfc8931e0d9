"""Score of a rival circuit on a duty: mean powers, tracking errors, pressures.

Source  ours, docs/circuits-compared.md
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array, Rows
from vvdp.base.errors import ConfigError, ParameterError, RunError
from vvdp.control.duty_cycle import DutyCycle, cycle_point
from vvdp.control.reference import ReferenceFilter, reference_at_rest, reference_step
from vvdp.evaluation.summary import simulated_summary
from vvdp.machines.cylinder_load import CHAMBERS
from vvdp.machines.duties import Duty
from vvdp.network.nodes import Rod
from vvdp.rivals.rival_circuits import SINKS, RivalCircuit
from vvdp.rivals.sizing import SUFFIXES, Task, known_cylinder_of
from vvdp.simulation.balance import balance_between
from vvdp.simulation.outcome import outcome
from vvdp.simulation.record import record_of
from vvdp.simulation.run import Run, simulate
from vvdp.systems.system import System, load_system

ROUNDS = 3
"""How often a cycle is gone through; powers are those of the last round."""
SETTLED = 1.0
"""Errors count from this time on [s]."""
LEAST_STROKE = 0.5
"""Share of a cycle's stroke that a filtered reference goes through at least."""
LONGEST_START = 8.0
"""Within which control has begun [s]."""
COMMON_RATE, SAMPLE = 25.0, 1e-3
"""Poles of the filter behind which errors count [1/s], as shipped in every circuit, and its sample period [s]."""
RECORD = 1e-3
"""Between two recorded rows [s]."""
OUTSIDE = (*(f"supplied.load_force{suffix}" for suffix in SUFFIXES), "supplied.tank", "supplied.pilot_tank")
"""Sources of energy that are not drives."""
ADDED = ("drawn", "returned", "delivered", "received", "friction", "stored")
"""Powers of a score."""
WORST = ("tracking_max", "tracking_rms", "tracking_first", "pressure_max", "energy_residual", "mass_residual")
"""Of what in a score the largest counts."""
MOST_POINTS = 1000
"""Points of a trace."""


class CircuitScore(NamedTuple):
    """Score of a circuit on a duty: mean powers over the last round [W], errors [m], pressures, gauge [Pa].

    `delivered` goes to the rod while it is pushed, `received` comes from it while the load overruns; `drawn` is taken
    from the drives of all pumps, `returned` given back to them. Pressures are those of both chambers and the supply,
    over every step; `charge` is the pressure at which the low side is held, NaN where nothing holds it.
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
    """The last round of a run's first cylinder, thinned: times from its begin [s], reference, position [m], both
    pressures [Pa]."""

    time: Array
    reference: Array
    position: Array
    pressure_a: Array
    pressure_b: Array


def system_for(circuit: RivalCircuit, duty: Duty, begin: float = 0.0, rate: float = COMMON_RATE) -> System:
    """A circuit sized for a duty that begins at `begin` [s], to be run for a few rounds, the rod at rest at first.

    rate  of the poles of the filter before its loop [1/s]

    Raises ParameterError where it cannot follow.
    """
    system = load_system(circuit.system)
    try:
        system = circuit.size(system, Task(duty, begin, ROUNDS, rate))
    except ParameterError as problem:
        raise ParameterError(f"{circuit.name} on {duty.name}: {problem}") from None
    except ConfigError as problem:
        faults = "; ".join(f"{each.key}: {each.message}" for each in problem.faults)
        raise ParameterError(f"{circuit.name} on {duty.name}: {faults}") from None
    until = begin + ROUNDS * duty.period
    last = until - duty.period
    stepping = replace(system.stepping, until=until, average_from=last, record_interval=RECORD, window=0.0)
    return replace(system, stepping=stepping)


def begin_of(circuit: RivalCircuit, duty: Duty) -> float:
    """When a circuit takes up control of a rod that rests under the first force of a duty [s]."""
    if circuit.begin is None:
        return 0.0
    system = system_for(circuit, duty, LONGEST_START)
    stepping = replace(system.stepping, until=LONGEST_START, average_from=None)
    return circuit.begin(simulate(system.model, system.case, stepping))


def refuse_unled(circuit: RivalCircuit, system: System, duty: Duty, run: Run) -> None:
    """Raises RunError where a reference of the last round has not gone through its duty cycle: control was left."""
    for suffix, each in zip(SUFFIXES, duty.alone, strict=False):
        reference = getattr(run.command, circuit.program + suffix).reference[run.times >= system.average_from]
        gone, asked = float(np.ptp(reference)), float(np.ptp(each.cycle.positions))
        if gone < LEAST_STROKE * asked:
            travel = f"{1e3 * gone:.3g} of {1e3 * asked:.3g} mm"
            raise RunError(f"the reference went through {travel} in the last round: control was left")


def circuit_score(circuit: RivalCircuit, system: System, run: Run, duty: Duty, begin: float = 0.0) -> CircuitScore:
    """The score of a run on a duty that came to its end, controlled from `begin` [s] on."""
    found = simulated_summary(outcome(run), system)
    since = run.times - begin
    errors = [_error(run, suffix, each, since) for suffix, each in zip(SUFFIXES, duty.alone, strict=False)]
    early, late = (since >= 0.0) & (since < SETTLED), since >= SETTLED
    last = np.flatnonzero(run.times >= system.average_from - 0.5 * RECORD)
    books = _books(run)
    drawn, returned = _drive_powers(books, run.times, last)
    delivered, received = np.sum([_rod_powers(system, run, last, suffix) for suffix in _suffixes(run)], axis=0)
    reference = system.circuit.network.oil.reference_pressure
    chambers = [name + suffix for suffix in _suffixes(run) for name in CHAMBERS]
    lines = ["line", "pump_line", *("supply" + suffix for suffix in SUFFIXES)]
    highest = [float(found[key]) for name in (*chambers, *lines) if (key := f"pressure_max_{name}_Pa") in found]
    return CircuitScore(
        tracking_max=max(float(np.max(each[late])) for each in errors),
        tracking_rms=max(float(np.sqrt(np.mean(each[late] ** 2))) for each in errors),
        tracking_first=max(float(np.max(each[early])) for each in errors),
        drawn=drawn,
        returned=returned,
        delivered=float(delivered),
        received=float(received),
        friction=_lost_power(books, run.times, last, ("friction", "end_stops")),
        stored=_storing_power(run, last) - sum(_rod_kinetic_power(system, run, last, each) for each in _suffixes(run)),
        sinks=tuple(_lost_power(books, run.times, last, circuit.sinks.get(sink, ())) for sink in SINKS),
        pressure_max=max(highest),
        pressure_min=min(float(found[f"pressure_min_{name}_Pa"]) for name in chambers),
        charge=np.nan if circuit.charge is None else circuit.charge(system) - reference,
        energy_residual=float(found["energy_residual"]),
        mass_residual=float(found["mass_residual"]),
    )


def joint_score(scores: Sequence[CircuitScore]) -> CircuitScore:
    """The score of circuits that move a cylinder each: powers add up, errors and pressures are the worst of all."""
    added = {name: float(sum(getattr(each, name) for each in scores)) for name in ADDED}
    worst = {name: float(max((getattr(each, name) for each in scores), key=abs)) for name in WORST}
    return CircuitScore(
        **added,
        **worst,
        sinks=tuple(map(sum, zip(*(each.sinks for each in scores), strict=True))),
        pressure_min=min(each.pressure_min for each in scores),
        charge=scores[0].charge,
    )


def _suffixes(run: Run) -> tuple[str, ...]:
    """Suffixes of the names of the cylinders of a run."""
    return tuple(suffix for suffix in SUFFIXES if hasattr(run.state, f"rod{suffix}"))


def _error(run: Run, suffix: str, duty: Duty, since: Array) -> Array:
    """How far a rod is from the common reference [m], at times `since` control began [s]."""
    error: Array = np.abs(getattr(run.state, f"rod{suffix}").position - common_reference(duty.cycle, since))
    return error


def common_reference(cycle: DutyCycle, times: Array) -> Array:
    """Common reference of all circuits on a cycle, shape (n,) [m]: its points behind the common filter.

    times  since control began, which the reference begins at rest [s]
    """
    samples = np.clip(np.floor(times / SAMPLE + 1e-6).astype(int), 0, None)
    found: Array = filtered_cycle(cycle, int(samples[-1]) + 1)[samples]
    return found


@lru_cache(maxsize=8)
def filtered_cycle(cycle: DutyCycle, count: int) -> Array:
    """The first `count` samples of a cycle behind the common filter [m]."""
    poles, reference = ReferenceFilter(filter_rate=COMMON_RATE), reference_at_rest(cycle.positions[0])
    found = [reference.position]
    for sample in range(1, count):
        reference = reference_step(reference, cycle_point(sample * SAMPLE, cycle).position, SAMPLE, poles)
        found.append(reference.position)
    return np.array(found)


def _books(run: Run) -> dict[str, Array]:
    """All that the books have added up, over the recorded times, by its path in them."""
    states = record_of(run).states
    return {path.removeprefix("books."): states[path].values for path in states if path.startswith("books.")}


def _lost_power(books: Mapping[str, Array], times: Array, rows: Rows, parts: tuple[str, ...]) -> float:
    """Mean power that some parts of a circuit, for all its cylinders, dissipate over `rows` [W]."""
    split = [part.partition(".") for part in parts]
    named = [f"{head}{suffix}{dot}{rest}" for head, dot, rest in split for suffix in SUFFIXES]
    paths = [path for path in books for part in named if f"{path}.".startswith(f"spent.{part}.")]
    lost = sum(float(books[path][rows[-1]] - books[path][rows[0]]) for path in paths)
    return lost / float(times[rows[-1]] - times[rows[0]])


def _storing_power(run: Run, rows: Rows) -> float:
    """Mean power that a circuit stores over `rows` [W]."""
    balance = balance_between(run.model, run.case, run.states[rows[0]], run.states[rows[-1]])
    assert balance is not None
    return float(balance.energy_stored) / float(run.times[rows[-1]] - run.times[rows[0]])


def _rod_kinetic_power(system: System, run: Run, rows: Rows, suffix: str) -> float:
    """Mean power at which a rod gains kinetic energy over `rows` [W]: it lies behind the power that is delivered."""
    rod, velocity = system.circuit.network.nodes["rod"], getattr(run.state, f"rod{suffix}").velocity[rows]
    assert isinstance(rod, Rod)
    mass = known_cylinder_of(system).moving_mass + (rod.values.mass if rod.values else 0.0)
    gained: float = 0.5 * mass * float(velocity[-1] ** 2 - velocity[0] ** 2)
    return gained / float(run.times[rows[-1]] - run.times[rows[0]])


def _drive_powers(books: Mapping[str, Array], times: Array, rows: Rows) -> tuple[float, float]:
    """Mean power that the drives of all pumps give, and that they are given back [W], over `rows`."""
    paths = [path for path in books if path.startswith("supplied.") and path not in OUTSIDE]
    steps = np.concatenate([np.diff(books[path][rows]) for path in paths])
    lasts = float(times[rows[-1]] - times[rows[0]])
    return float(np.sum(steps[steps > 0.0])) / lasts, abs(float(np.sum(steps[steps < 0.0]))) / lasts


def _rod_powers(system: System, run: Run, rows: Rows, suffix: str) -> tuple[float, float]:
    """Mean power of the oil on the rod while it pushes, and of the rod on the oil while the load overruns [W]."""
    cylinder, reference = known_cylinder_of(system), system.circuit.network.oil.reference_pressure
    a, b, rod = (getattr(run.state, name + suffix) for name in (*CHAMBERS, "rod"))
    force = (a - reference) * cylinder.area_a - (b - reference) * cylinder.area_b
    times, power = run.times[rows], (force * rod.velocity)[rows]
    lasts = float(times[-1] - times[0])
    pushing, driven = (float(np.trapezoid(np.clip(sign * power, 0.0, None), times)) for sign in (1.0, -1.0))
    return pushing / lasts, driven / lasts


def circuit_trace(system: System, run: Run, duty: Duty, begin: float) -> CircuitTrace:
    """The last round of a run on a duty that was controlled from `begin` [s] on."""
    rows = np.flatnonzero(run.times >= system.average_from)
    thin = rows[:: max(1, rows.size // MOST_POINTS)]
    reference, state = system.circuit.network.oil.reference_pressure, run.state
    return CircuitTrace(
        time=run.times[thin] - system.average_from,
        reference=common_reference(duty.cycle, run.times - begin)[thin],
        position=state.rod.position[thin],
        pressure_a=state.chamber_a[thin] - reference,
        pressure_b=state.chamber_b[thin] - reference,
    )
