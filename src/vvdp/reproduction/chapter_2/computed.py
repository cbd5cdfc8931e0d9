"""Flows that were computed before, kept as tables with the command that repeats them; and one computed at once."""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from vvdp.base import kinds
from vvdp.base.extras import MissingExtraError, require_solids
from vvdp.base.kinds import Kind
from vvdp.cfd.case import Fluid
from vvdp.cfd.engine import MissingProgramError, find_openfoam
from vvdp.cfd.kept import KeptStudy, kept_studies, kept_study
from vvdp.geometry.shape_tables import valve_shape
from vvdp.reproduction.chapter_2.valve import DENSITY, FLOW, VISCOSITY, valve
from vvdp.results.result import Column, Table

KINDS = {
    "m3_s": kinds.FLOW,
    "N_m": kinds.TORQUE,
    "rad_s": kinds.SPEED,
    "m3": kinds.VOLUME,
    "m2": kinds.AREA,
    "Pa": kinds.SIGNED_PRESSURE,
    "N": kinds.FORCE,
    "m": kinds.LENGTH,
    "rad": kinds.ANGLE,
}
"""Kinds of the columns of a kept study, by the unit with which their names end."""


def kept_or_none(name: str) -> KeptStudy | None:
    """A kept study; None where it is not there."""
    return kept_study(name) if name in kept_studies() else None


def turbine_over(column: str) -> KeptStudy | None:
    """The kept study of the outlet turbine in which a column takes several values; None where there is none."""
    known = filter(None, map(kept_or_none, ("turbine-flows", "turbine-speeds")))
    return next((study for study in known if np.unique(study[column]).size > 2), None)


def kind_of(key: str, is_text: bool) -> Kind | None:
    """The kind of a column."""
    if is_text:
        return None
    return next((kind for unit, kind in KINDS.items() if key.endswith(f"_{unit}")), kinds.NUMBER)


def kept_table(study: KeptStudy) -> Table:
    """A kept study as a table of a result, with its command."""
    columns = {
        key: Column(values, kind_of(key, values.dtype.kind == "U"), key.replace("_", " "))
        for key, values in study.columns.items()
    }
    return Table(title=f"Computed before: {study.command}", columns=columns, note=study.provenance)


def live_rail(grid: float) -> Table | None:
    """The inlet rail at 40 lpm, computed now with so many cells per spool radius; None without what it takes."""
    try:
        openfoam = find_openfoam()
        require_solids()
    except (MissingProgramError, MissingExtraError):
        return None
    from vvdp.cfd.rail import RailOrder, rail_case, turned_rail
    from vvdp.cfd.solve import solve

    order = RailOrder(valve(), valve_shape(valve()).shape, Fluid(DENSITY, VISCOSITY), FLOW, grid)
    with TemporaryDirectory() as place:
        folder = Path(place) / "case"
        folder.mkdir()
        solved = solve(rail_case(order, turned_rail(order)), folder, openfoam, 1, lambda progress: None)
    columns = {
        "cells": Column(np.array([float(solved.mesh.cells)]), kinds.COUNT, "cells"),
        "pressure_drop_Pa": Column(np.array([solved.judgement.value]), kinds.PRESSURE_DIFFERENCE, "drop"),
        "mass_imbalance": Column(np.array([solved.judgement.imbalance]), kinds.NUMBER, "imbalance"),
    }
    return Table(title="Computed just now", columns=columns)
