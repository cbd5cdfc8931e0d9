"""Quantities watched while a flow is computed: pressure drop and flows of ducts, or force and torque on walls."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from vvdp.base.arrays import Array
from vvdp.cfd.convergence import History
from vvdp.cfd.dictionary import Entry
from vvdp.cfd.monitor import Monitor, read_monitor
from vvdp.cfd.numerics import patch_mean

PRESSURE, FORCES, STILL = "pressure", "forces", "forces-still"
Monitors = Mapping[str, Mapping[str, Entry]]


def flow_name(patch: str) -> str:
    """The name of the function object that counts the flow through a patch."""
    return f"flow-{patch}"


def drop_monitors(inlet: str, openings: Sequence[str]) -> Monitors:
    """Function objects for the mean pressure at the inlet and the flow through every opening."""
    return {PRESSURE: patch_mean(inlet, "areaAverage", "p"), **flow_monitors(openings)}


def flow_monitors(openings: Sequence[str]) -> Monitors:
    """Function objects for the flow through every opening."""
    return {flow_name(patch): patch_mean(patch, "sum", "phi") for patch in openings}


def read_drop(openings: Sequence[str], density: float, case: Path) -> History:
    """The drop from the inlet to where the pressure is 0 [Pa], and the flows."""
    pressure, *flows = align(
        [read_monitor(case, PRESSURE), *(read_monitor(case, flow_name(each)) for each in openings)]
    )
    values = {patch: flow.values[:, 0] for patch, flow in zip(openings, flows, strict=True)}
    return History(pressure.iterations, density * pressure.values[:, 0], values)


def force_monitors(walls: Sequence[str], density: float, name: str = FORCES) -> Monitors:
    """A function object for force and torque on walls about the axis z."""
    forces: Mapping[str, Entry] = {
        "type": "forces",
        "libs": ("forces",),
        "patches": tuple(walls),
        "rho": "rhoInf",
        "rhoInf": density,
        "CofR": (0.0, 0.0, 0.0),
        "log": False,
        "executeControl": "timeStep",
        "writeControl": "timeStep",
    }
    return {name: forces}


def read_axial_force(case: Path) -> History:
    """The force on the walls along z [N]."""
    return _read_along_axis("force.dat", case)


def read_torque(case: Path, name: str = FORCES) -> History:
    """The torque on the walls about z [N m]."""
    return _read_along_axis("moment.dat", case, name)


def _read_along_axis(table: str, case: Path, name: str = FORCES) -> History:
    found = read_monitor(case, name, table)
    whole: Array = found.values[:, 2] if found.iterations.size else np.zeros(0)
    return History(found.iterations, whole, {})


def align(monitors: Sequence[Monitor]) -> list[Monitor]:
    """Tables cut to the rows that all have: one may be an iteration ahead while the solver works."""
    rows = min(len(monitor.iterations) for monitor in monitors)
    return [Monitor(each.iterations[:rows], each.values[:rows], each.area) for each in monitors]
