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
TRAPEZOID: Mapping[str, Any] = {
    "table": [["2 s", "0"]]
    + [[f"{t + at} s", duty] for t in (0, 5, 10) for at, duty in ((3, "1"), (5, "1"), (6, "0"), (7, "0"))]
}
"""The trapezoid of eq. 4.16, corrected."""
KNOWN = {"largest_flow": "1.8 lpm", "forward_dead_band": "0", "backward_dead_band": "0", "backward_gain": "1"}
"""A map without dead band and asymmetry."""

Tables = Mapping[str, Mapping[str, Any]]
IDEAL: Tables = {
    "gerotor": {"lag": "0.1 ms"},
    "characteristic": KNOWN,
    "calibration": {**KNOWN, "straight_flow": "0.0001 lpm"},
}
LUMPED: Tables = {"axial_observer": {"sample_period": "1 ms", "bandwidth": "60 rad/s"}}
GENERATOR: Tables = {
    "axial_observer": {
        "sample_period": "2 ms",
        "noise_period": "40 ms",
        "sensor_deviation": "30 um",
        "position_drift": "3 um",
        "generator_drift": "3 um",
    },
    "run": {"sample_period": "2 ms", "record_interval": "2 ms"},
    "operation": {"spool_speed": "25 rev/s"},
}
OFF_BY_HALF: Tables = {"axial_observer": {"noise_speed": "9.5 rev/s"}}
"""A basis in time that is 0.5 Hz slower than the spool."""
CONSTANT: Tables = {"operation": {"duty_ratio": "0.5"}}
NOISY: Tables = {"axial_sensor": {"noise": "20 um"}}


class Samples(NamedTuple):
    """What the samples show, and the errors of the believed pollution; each (samples,)."""

    time: Array
    true: Array
    reference: Array
    estimate: Array
    command: Array
    pollution: Array
    pollution_error: Array


def experiment(*changes: Tables) -> Samples:
    """The drive on the trapezoid, with changes in order; an observer of another kind replaces the shipped one."""
    chosen: dict[str, dict[str, Any]] = {
        "calibration": {"lag": "0.1 ms"},
        "axial_sensor": {"noise": "0.001 um", "seed": "1"},
        "axial_reference": {"filter_rate": "500 1/s"},
        "operation": {"duty_ratio": TRAPEZOID},
        "run": {"until": "16 s"},
    }
    for change in changes:
        for table, values in change.items():
            chosen[table] = {**chosen.get(table, {}), **values}
    replaced = {"bandwidth", "noise_period"} & set(chosen.get("axial_observer", {}))
    return _samples(json.dumps(chosen), ("axial_observer",) if replaced else ())


@cache
def _samples(tables: str, without: tuple[str, ...]) -> Samples:
    system = variant("axial-gerotor", without=without, **json.loads(tables))
    run = simulate(system.model, system.case, system.stepping)
    settings: Any = system.circuit.network.programs["axial"].settings
    at = np.flatnonzero(np.abs(run.times / settings.sample_period % 1.0 - 0.5) > 0.5 - 1e-6)
    now, after = at[:-1], at[1:]
    shown = run.command.axial
    added = np.array([pollution_at(float(angle), settings.sensor.near) for angle in run.state.spool[now]])
    return Samples(
        time=run.times[now],
        true=run.state.gerotor.position[now],
        reference=shown.reference[after],
        estimate=shown.position[after],
        command=shown.drive[after],
        pollution=added,
        pollution_error=shown.pollution[after] - added,
    )


def late(found: Samples, begin: float = SETTLED) -> Samples:
    """The samples from `begin` [s] on."""
    chosen = found.time > begin
    return Samples(**{name: column[chosen] for name, column in found._asdict().items()})


def peak(metres: Array) -> float:
    """Largest error over the stroke [1]."""
    return float(np.max(np.abs(metres))) / STROKE
