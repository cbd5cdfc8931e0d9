"""Tables of flows that were computed on finer grids than a test can afford, kept with the command that repeats them."""

import csv
import re
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ParameterError
from vvdp.cfd.refinement import grid_convergence
from vvdp.results.result import Texts

FOLDER = "kept"
PARTS = {
    "rail": "rail",
    "sleeve": "rail",
    "centre": "centre",
    "openings": "centre",
    "period": "centre",
    "turbine": "turbine",
}
"""The part of the valve that a study is of, by the first word of its name."""
_GAP = re.compile(r"\{(\w+)\}")


@dataclass(frozen=True)
class KeptStudy:
    """A table of computed flows.

    name        of its file
    command     that repeats it; where it holds names of columns in braces, a run for each row
    provenance  program, model of turbulence, scheme, grid, with commas between them
    columns     values [SI] or words, a row for each run; the names of quantities end with their unit
    """

    name: str
    command: str
    provenance: str
    columns: Mapping[str, Array | Texts]

    def __getitem__(self, key: str) -> Any:
        """The values of a column."""
        return self.columns[key]

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(next(iter(self.columns.values())))

    @property
    def model(self) -> str:
        """Model of turbulence."""
        return self.provenance.split(", ")[1]

    @property
    def scheme(self) -> str:
        """Scheme of the convection."""
        return self.provenance.split(", ")[2]

    @property
    def grid_index(self) -> float:
        """Uncertainty of the drop by the three finest grids of this part of the valve, over the drop: the convergence
        index, or the spread if drops do not converge monotonically. nan if no study of its grids is kept.
        """
        grids = f"{PARTS.get(self.name.split('-')[0])}-grids"
        study = self if self.name.endswith("-grids") else kept_study(grids) if grids in kept_studies() else None
        if study is None:
            return np.nan
        finest = study["cells"].argsort()[:-4:-1]
        sizes, drops = (
            tuple(column[finest].tolist()) for column in (study["cells"] ** (-1 / 3), study["pressure_drop_Pa"])
        )
        found = grid_convergence(sizes, drops)
        return found.band if found.is_monotone else found.spread

    def command_of(self, row: int) -> str:
        """The command that repeats a row."""
        return _GAP.sub(lambda gap: f"{self.columns[gap[1]][row]:g}", self.command)


def kept_studies() -> tuple[str, ...]:
    """Names of all studies that are kept."""
    found = (each.name for each in files(__package__).joinpath(FOLDER).iterdir() if each.name.endswith(".csv"))
    return tuple(sorted(name.removesuffix(".csv") for name in found))


def kept_study(name: str) -> KeptStudy:
    """A study that is kept. Raises ParameterError where there is none of this name."""
    if name not in kept_studies():
        raise ParameterError(f"no study {name!r} is kept; expected one of {', '.join(kept_studies())}")
    lines = files(__package__).joinpath(FOLDER, f"{name}.csv").read_text("utf-8").splitlines()
    command, provenance = (line.removeprefix("#").strip() for line in lines[:2])
    heads, *rows = csv.reader(lines[2:])
    columns = {head: _column(cells) for head, cells in zip(heads, zip(*rows, strict=True), strict=True)}
    return KeptStudy(name, command, provenance, columns)


def _column(cells: tuple[str, ...]) -> Array | Texts:
    """Numbers, an empty cell standing for one that is not known, or words."""
    try:
        return np.array([float(cell) if cell else np.nan for cell in cells])
    except ValueError:
        return np.array(cells, str)
