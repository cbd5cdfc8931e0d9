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
from vvdp.results.result import Texts

FOLDER = "kept"
_GAP = re.compile(r"\{(\w+)\}")


@dataclass(frozen=True)
class KeptStudy:
    """A table of computed flows.

    name        of its file
    command     that repeats it; where it holds names of columns in braces, a run for each row
    provenance  program, model of turbulence, grid
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
