"""The chamber drive of chapter 5 as the experiments of section 5.7 have it, and how well it follows."""

from collections.abc import Mapping
from functools import cache
from types import MappingProxyType
from typing import Any

import numpy as np

from vvdp.control.chamber import ChamberDrive, volume_compliance
from vvdp.programs.axial_numbers import Controlled, ExactLaw
from vvdp.programs.chamber_report import ChamberLawReport
from vvdp.reproduction.variant import variant
from vvdp.simulation.run import simulate
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

Changes = Mapping[str, object]
"""Entries of the drawn circuit by their paths."""
LAW = "programs.drive_law"


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


def experiment(gains: Mapping[str, str] | None = None, changes: Changes = MappingProxyType({})) -> System:
    """The drive on trapezoids, with the true state, under the passivity law, or under backstepping with `gains`."""
    signal, end = trapezoids()
    chosen: dict[str, Any] = {
        "programs.drive_wanted.first": signal,
        "components.drive_axial_friction.viscous_friction": "0 N*s/m",
        "programs.drive_observer.viscous_friction": "0 N*s/m",
        f"{LAW}.friction": "0 N*s/m",
        "programs.drive_observer.learn_time": "0 s",
        "programs.drive_reference.filter_rate": "250 1/s",
        "programs.velocity": {"type": "low-pass", "reads": "drive_slide.velocity", "time_constant": "1 us"},
        f"{LAW}.position": "drive_slide.position",
        f"{LAW}.velocity": "velocity.value",
        "run.until": f"{end:.6g} s",
        "run.average_from": f"{end - 0.1:.6g} s",
    }
    if gains is None:
        chosen |= {f"{LAW}.flow_gain": "4e-10 m^3/(s*Pa)", f"{LAW}.pressure_rate": "0 1/s"}
    else:
        chosen |= {f"{LAW}.type": "backstepping"} | {f"{LAW}.{key}": value for key, value in gains.items()}
    return variant("axial-chamber", chosen | dict(changes))


def law_report(system: System) -> ChamberLawReport:
    """Report of the law of an experiment."""
    return ChamberLawReport(system.circuit.network, "drive_law", system.stepping.sample_period)


def law_of(system: System) -> ExactLaw:
    """The law of an experiment."""
    found = law_report(system).law
    assert found is not None
    return found


def rows(system: System, begin: float = BEGIN) -> Controlled:
    """The samples of a run from `begin` [s] on."""
    found = law_report(system).run_rows(simulate(system.model, system.case, system.stepping))
    return found.rows(found.times >= begin - 1e-9)


def tracking_error(found: Controlled) -> float:
    """Of the spool against the reference, root of the mean square [m]."""
    return float(np.sqrt(np.mean((found.true.position - found.reference.position) ** 2)))


@cache
def known_drive() -> ChamberDrive:
    """Model of the drive in its controller."""
    return law_of(experiment()).drive


@cache
def middle_compliance() -> float:
    """V/beta at the middle position [m^3/Pa]."""
    drive = known_drive()
    pressure = drive.oil.reference_pressure + (drive.stiffness * MIDDLE * 1e-3 + drive.preload) / drive.area
    return volume_compliance(MIDDLE * 1e-3, pressure, drive)


def sine_experiment(gains: Mapping[str, str] | None = None) -> System:
    """1.5 mm at 5 Hz, the velocity low-passed at 1 Hz."""
    swing = {"sine": duty_ratio(MIDDLE), "amplitude": duty_ratio(1.5), "frequency": "5 Hz"}
    changes = {
        "programs.drive_wanted.first": swing,
        "programs.velocity.time_constant": f"{1.0 / TURN!r} s",
        "run.until": "2 s",
        "run.average_from": "1.6 s",
    }
    return experiment(gains, changes)
