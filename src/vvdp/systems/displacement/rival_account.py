"""What a rival circuit came to on a duty: where the power went, how well the rod followed, pressures.

Source  ours, docs/circuits-compared.md
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array, Rows
from vvdp.base.errors import ParameterError
from vvdp.simulation.outcome import outcome
from vvdp.simulation.record import record_of
from vvdp.simulation.run import Run
from vvdp.systems.displacement.duties import Duty
from vvdp.systems.displacement.rival_circuits import SINKS, RivalCircuit
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
MOST_POINTS = 1000
"""Points of a trace."""


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


def system_for(circuit: RivalCircuit, duty: Duty) -> System:
    """A circuit sized for a duty, to be run for a few rounds. Raises ParameterError where it cannot follow."""
    try:
        system = circuit.system_for(duty)
    except ParameterError as problem:
        raise ParameterError(f"{circuit.name} on {duty.name}: {problem}") from None
    stepping = replace(system.stepping, until=ROUNDS * duty.period, record_interval=RECORD, window=0.0)
    return replace(system, stepping=stepping, average_from=(ROUNDS - 1) * duty.period)


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


def circuit_trace(system: System, run: Run) -> CircuitTrace:
    """The last round of a run."""
    rows = np.flatnonzero(run.times >= system.average_from)
    thin = rows[:: max(1, rows.size // MOST_POINTS)]
    reference, state = system.tables["oil"].reference_pressure, run.state
    return CircuitTrace(
        time=run.times[thin] - system.average_from,
        reference=run.command.loop.reference[thin],
        position=state.rod.position[thin],
        pressure_a=state.chamber_a[thin] - reference,
        pressure_b=state.chamber_b[thin] - reference,
    )
