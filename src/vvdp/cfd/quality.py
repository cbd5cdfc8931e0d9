"""Quality of a run: distance of the first cells from the walls (y+), and residuals of each field."""

import re
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from vvdp.cfd.dictionary import Entry
from vvdp.cfd.monitor import patch_faces, starts
from vvdp.cfd.turbulence import Turbulence

WALLS, RESIDUALS = "yPlus", "residuals"
"""Function objects of both; the first one carries the name of its table."""
VISCOUS, LOGARITHMIC = 5.0, 30.0
"""y+ up to which the velocity is linear in the distance, and from which the logarithmic law holds."""
CRITERIA: Mapping[str, float] = MappingProxyType(
    {"U": 1e-3, "p": 1e-2, "k": 1e-3, "epsilon": 1e-3, "omega": 1e-3},
)
"""Largest initial residual of each field, as OpenFOAM normalises it, mean over the last window."""


class WallDistance(NamedTuple):
    """y+ = y u_tau / nu of the cells at one patch of walls: least, mean of its `faces`, largest.

    u_tau is C_mu^(1/4) k^(1/2) of the cell where a model of turbulence has wall functions, and that of the wall's shear
    in laminar flow.
    """

    patch: str
    faces: int
    least: float
    mean: float
    largest: float


class Quality(NamedTuple):
    """y+ of each patch of walls, in the last state; the residual of each field, mean over the last window."""

    walls: tuple[WallDistance, ...]
    residuals: Mapping[str, float]

    @property
    def over_all_walls(self) -> tuple[float, float, float]:
        """y+ of all walls together: least, mean of the faces, largest; nan where there is none."""
        if not self.walls:
            return np.nan, np.nan, np.nan
        faces = sum(each.faces for each in self.walls)
        mean = sum(each.faces * each.mean for each in self.walls) / faces
        return min(each.least for each in self.walls), mean, max(each.largest for each in self.walls)

    @property
    def residual_share(self) -> float:
        """Largest residual over its criterion of all fields; nan where none is known."""
        return max((residual / CRITERIA[field] for field, residual in self.residuals.items()), default=np.nan)

    @property
    def unmet(self) -> tuple[str, ...]:
        """Fields whose residual is above its criterion."""
        return tuple(field for field, residual in self.residuals.items() if not residual < CRITERIA[field])


def quality_monitors(turbulence: Turbulence) -> Mapping[str, Mapping[str, Entry]]:
    """Function objects that write y+ with every state and the residuals at every iteration."""
    fields = ("U", "p", *(("k", turbulence.scale) if turbulence.scale else ()))
    walls: Mapping[str, Entry] = {
        "type": "yPlus",
        "libs": ("fieldFunctionObjects",),
        "log": False,
        "executeControl": "writeTime",
        "writeControl": "writeTime",
    }
    residuals: Mapping[str, Entry] = {
        "type": "solverInfo",
        "libs": ("utilityFunctionObjects",),
        "fields": fields,
        "writeResidualFields": False,
        "executeControl": "timeStep",
        "writeControl": "timeStep",
    }
    return {WALLS: walls, RESIDUALS: residuals}


def read_quality(case: Path, end: float, window: int) -> Quality:
    """Quality of a run that counts up to the iteration `end`, residuals as means over its last `window` iterations.

    y+ is that of the first state at or after `end`, of the last one where there is none.
    """
    return Quality(_read_walls(case, end), _read_residuals(case, end, window))


def _lines(case: Path, name: str, table: str) -> list[list[str]]:
    """The words of each line that a function object wrote over all parts of a run."""
    paths = [path for start in starts(case, name) if (path := start / table).is_file()]
    return [line.split() for path in paths for line in path.read_text("utf-8").splitlines() if line.strip()]


def _read_walls(case: Path, end: float) -> tuple[WallDistance, ...]:
    rows = [words for words in _lines(case, WALLS, f"{WALLS}.dat") if words[0] != "#" and len(words) == 5]
    times = sorted({float(words[0]) for words in rows})
    if not times:
        return ()
    at = next((time for time in times if time >= end), times[-1])
    found = {words[1]: tuple(map(float, words[2:])) for words in rows if float(words[0]) == at}
    faces = patch_faces(case)
    return tuple(WallDistance(patch, faces[patch], low, mean, high) for patch, (low, high, mean) in found.items())


def _read_residuals(case: Path, end: float, window: int) -> Mapping[str, float]:
    """The largest component counts for a velocity."""
    rows = _lines(case, RESIDUALS, "solverInfo.dat")
    heads = next((words[1:] for words in rows if words[:2] == ["#", "Time"]), [])
    numbers = {float(words[0]): words for words in rows if words[0] != "#" and len(words) == len(heads)}
    last = [numbers[time] for time in sorted(numbers) if end - window < time <= end]
    found: dict[str, float] = {}
    for place, head in enumerate(heads):
        if last and (match := re.fullmatch(r"(\w+?)[xyz]?_initial", head)):
            mean = float(np.mean([float(words[place]) for words in last]))
            found[match[1]] = max(mean, found.get(match[1], 0.0))
    return found
