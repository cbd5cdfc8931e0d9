"""Several parts of the valve computed side by side at one flow, each on a mesh of its own."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from vvdp.cfd.balance import Torques, read_torques
from vvdp.cfd.section import Plane
from vvdp.cfd.series import NamedCase, case_folder, solve_series
from vvdp.cfd.solve import Hear, Solved
from vvdp.studies.engine import Engine


class PartRun(NamedTuple):
    """A part that was computed: its name, the run, the torques on the spool."""

    name: str
    solved: Solved
    torques: Torques
    seconds: float


def run_parts(
    parts: Sequence[NamedCase], plane: Plane, directory: Path, engine: Engine, hear: Hear
) -> tuple[PartRun, ...]:
    """Computes parts, or goes on with them; see `solve` for what is raised and kept."""
    runs = []
    for place, solved in enumerate(solve_series(parts, plane, directory, engine, hear)):
        part = parts[place]
        torques = read_torques(part.case, case_folder(directory, place), len(solved.history.iterations))
        runs.append(PartRun(part.name, solved, torques, solved.took))
    return tuple(runs)
