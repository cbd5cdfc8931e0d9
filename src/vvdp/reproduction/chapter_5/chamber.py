"""The chamber drive of chapter 5 as the experiments of section 5.7 have it, and how well it follows."""

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np

from vvdp.control.chamber import ChamberDrive, volume_compliance
from vvdp.programs.axial_numbers import Controlled
from vvdp.reproduction.variant import variant
from vvdp.simulation.run import simulate
from vvdp.systems.axial_numbers import loop_of, rows_under_control
from vvdp.systems.system import System

HELIX = 20.32
"""Length of the helix [mm]."""
LOW, HIGH, MIDDLE = 0.25, 5.25, 2.75
"""Positions [mm]; the supply of 190 psi does not lift the spool over the whole helix."""
RAMP, PAUSE, BEGIN = 0.05, 0.2, 0.6
TURN = 2.0 * np.pi
PASSIVE = {"error_rate": "50 1/s", "position_gain": "55 N/m", "velocity_gain": "4 N*s/m"}
BACKSTEPPING = {
    "error_rate": "50 1/s",
    "position_gain": "550 N/m",
    "velocity_gain": "45 N*s/m",
    "pressure_weight": "3e-12 m^3/Pa",
    "flow_gain": "4e-10 m^3/(s*Pa)",
}
"""Table 5.1."""
MILD = BACKSTEPPING | PASSIVE
"""Backstepping with the gains of the passivity law."""

Tables = Mapping[str, Mapping[str, Any]]


def duty_ratio(position: float) -> str:
    """Of a position [mm]."""
    return f"{position / HELIX:.12g}"


def trapezoids() -> tuple[dict[str, Any], float]:
    """Three trapezoids as a signal of the duty ratio, and when they end [s]."""
    points, now = [(0.0, LOW), (BEGIN, LOW)], BEGIN
    for _ in range(3):
        for duration, end in ((RAMP, HIGH), (PAUSE, HIGH), (RAMP, LOW), (PAUSE, LOW)):
            now += duration
            points.append((now, end))
    return {"table": [[f"{t:.9g} s", duty_ratio(x)] for t, x in points]}, now


def experiment(gains: Mapping[str, str] | None = None, **tables: Mapping[str, Any]) -> System:
    """The drive on trapezoids, told the truth, under the passivity law, or under backstepping with `gains`."""
    signal, end = trapezoids()
    chosen: dict[str, Mapping[str, Any]] = {
        "operation": {"duty_ratio": signal},
        "axial_friction": {"viscous_friction": "0 N*s/m"},
        "axial_reference": {"filter_rate": "250 1/s"},
        "axial_sequence": {"learn_time": "0 s"},
        "true_feedback": {"velocity_rate": "1e6 1/s"},
        "run": {"until": f"{end:.6g} s", "average_from": f"{end - 0.1:.6g} s"},
    }
    if gains is None:
        chosen["passivity"] = {"flow_gain": "4e-10 m^3/(s*Pa)", "pressure_rate": "0 1/s"}
    else:
        chosen["backstepping"] = gains
    for name, values in tables.items():
        chosen[name] = {**chosen.get(name, {}), **values}
    dropped = {name for name, values in chosen.items() if not values}
    kept = {name: values for name, values in chosen.items() if values}
    return variant("axial-chamber", without=(*dropped, *(() if gains is None else ("passivity",))), **kept)


def rows(system: System, begin: float = BEGIN) -> Controlled:
    """The samples of a run from `begin` [s] on."""
    run = simulate(system.model, system.case, system.stepping)
    found = rows_under_control(run, loop_of(system).observer.sample_period)
    late = found.times >= begin - 1e-9
    return Controlled(
        times=found.times[late],
        true=type(found.true)(*(column[late] for column in found.true)),
        shown=type(found.shown)(*(column[late] for column in found.shown)),
        reference=type(found.reference)(*(column[late] for column in found.reference)),
    )


def tracking_error(found: Controlled) -> float:
    """Of the spool against the reference, root of the mean square [m]."""
    return float(np.sqrt(np.mean((found.true.position - found.shown.reference) ** 2)))


@cache
def known_drive() -> ChamberDrive:
    """What the controller knows of the drive."""
    return loop_of(experiment()).drive


@cache
def middle_compliance() -> float:
    """V/beta at the middle position [m^3/Pa]."""
    drive = known_drive()
    pressure = drive.oil.reference_pressure + (drive.stiffness * MIDDLE * 1e-3 + drive.preload) / drive.area
    return volume_compliance(MIDDLE * 1e-3, pressure, drive)


def sine_experiment(gains: Mapping[str, str] | None = None, **tables: Mapping[str, Any]) -> System:
    """1.5 mm at 5 Hz, the velocity low-passed at 1 Hz."""
    swing = {"sine": duty_ratio(MIDDLE), "amplitude": duty_ratio(1.5), "frequency": "5 Hz"}
    chosen: dict[str, Mapping[str, Any]] = {
        "operation": {"duty_ratio": swing},
        "true_feedback": {"velocity_rate": f"{TURN} 1/s"},
        "run": {"until": "2 s", "average_from": "1.6 s"},
    }
    for name, values in tables.items():
        chosen[name] = {**chosen.get(name, {}), **values}
    return experiment(gains, **chosen)
