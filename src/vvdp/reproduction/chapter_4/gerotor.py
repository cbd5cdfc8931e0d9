"""The gerotor drive of chapter 4 as its simulations and experiments have it."""

import json
from collections.abc import Mapping
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.reproduction.variant import variant
from vvdp.sensing.axial_sensor import pollution_at
from vvdp.simulation.run import simulate

STROKE = 20.32e-3
SETTLED = 6.0
"""From so long after the start on errors count [s]."""
TRAPEZOID: Mapping[str, object] = {
    "table": [["2 s", "0"]]
    + [[f"{t + at} s", duty] for t in (0, 5, 10) for at, duty in ((3, "1"), (5, "1"), (6, "0"), (7, "0"))]
}
"""The trapezoid of eq. 4.16, corrected."""
KNOWN = {"largest_flow": "1.8 lpm", "forward_dead_band": "0", "backward_dead_band": "0", "backward_gain": "1"}
"""A map without dead band and asymmetry."""

Changes = Mapping[str, object]
"""Entries of the drawn circuit by their paths."""
GEROTOR, OBSERVER, LAW = "components.drive_gerotor", "programs.drive_observer", "programs.drive_law"


def belief_entries(values: Mapping[str, str]) -> Changes:
    """Values of the pump's map, as observer and law believe in it."""
    return {f"{program}.{key}": value for program in (OBSERVER, LAW) for key, value in values.items()}


IDEAL: Changes = {
    f"{GEROTOR}.lag": "0.1 ms",
    **{f"{GEROTOR}.{key}": value for key, value in KNOWN.items()},
    **belief_entries({**KNOWN, "straight_flow": "0.0001 lpm"}),
}
LUMPED: Changes = {f"{OBSERVER}.type": "lumped-observer", f"{OBSERVER}.bandwidth": "60 rad/s"}
GENERATOR: Changes = {
    f"{OBSERVER}.type": "generator-observer",
    f"{OBSERVER}.noise_period": "40 ms",
    f"{OBSERVER}.generator_drift": "3 um",
    f"{OBSERVER}.sample_period": "2 ms",
    f"{LAW}.sample_period": "2 ms",
    "run.sample_period": "2 ms",
    "run.record_interval": "2 ms",
    "nodes.spool.speed": "25 rev/s",
}
OFF_BY_HALF: Changes = {
    "nodes.clock": {"type": "driven-shaft", "speed": "9.5 rev/s"},
    f"{OBSERVER}.angle": "clock.angle",
    f"{OBSERVER}.speed": "clock.speed",
}
"""A basis in time that is 0.5 Hz slower than the spool."""
CONSTANT: Changes = {"programs.drive_wanted.first": "0.5"}
NOISY: Changes = {"programs.drive_sensor.noise": "20 um"}


class Samples(NamedTuple):
    """Values at the samples, and the errors of the estimated periodic sensor error; each (samples,)."""

    time: Array
    true: Array
    reference: Array
    estimate: Array
    command: Array
    pollution: Array
    pollution_error: Array


def experiment(*changes: Changes) -> Samples:
    """The drive on the trapezoid, with changes in order; an observer of another kind replaces the shipped one."""
    chosen: dict[str, Any] = {
        f"{OBSERVER}.lag": "0.1 ms",
        "programs.drive_sensor.noise": "0.001 um",
        "programs.drive_sensor.seed": "1",
        "programs.drive_reference.filter_rate": "500 1/s",
        "programs.drive_wanted.first": TRAPEZOID,
        "run.until": "16 s",
    }
    for change in changes:
        chosen |= change
    return _samples(json.dumps(chosen))


@cache
def _samples(changes: str) -> Samples:
    system = variant("axial-gerotor", json.loads(changes))
    run = simulate(system.model, system.case, system.stepping)
    programs: Any = system.circuit.network.programs
    period, near = programs["drive_law"].settings.sample_period, programs["drive_sensor"].settings.near
    at = np.flatnonzero(np.abs(run.times / period % 1.0 - 0.5) > 0.5 - 1e-6)
    now, after = at[:-1], at[1:]
    seen = run.command.drive_observer
    added = np.array([pollution_at(float(angle), near) for angle in run.state.spool[now]])
    return Samples(
        time=run.times[now],
        true=run.state.drive_gerotor.position[now],
        reference=run.command.drive_reference.value[after],
        estimate=seen.position[after],
        command=run.command.drive_law.command[after],
        pollution=added,
        pollution_error=seen.pollution[after] - added,
    )


def late(found: Samples, begin: float = SETTLED) -> Samples:
    """The samples from `begin` [s] on."""
    chosen = found.time > begin
    return Samples(**{name: column[chosen] for name, column in found._asdict().items()})


def peak(metres: Array) -> float:
    """Largest error over the stroke [1]."""
    return float(np.max(np.abs(metres))) / STROKE
