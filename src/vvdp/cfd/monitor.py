"""Tables that OpenFOAM writes while it works, and what its mesh programs show, read back."""

import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import RunError

FOLDER = "postProcessing"
TIME = re.compile(r"[0-9.]+(e-[0-9]+)?")
HAIR = 1e-6
"""Of a time, by which two may differ that are one."""
END = b"* //"
"""How every field ends that a solver has written to its end."""


PIECES = "cellToRegion"
"""File that checkMesh leaves beside the start if a mesh is in pieces; no solver writes it."""


class Monitor(NamedTuple):
    """Table of a function object: an iteration and a row of values at a time; `area` of its patch [m^2], or nan."""

    iterations: Array
    values: Array
    area: float


EMPTY = Monitor(np.zeros(0), np.zeros((0, 1)), float("nan"))


def read_monitor(case: Path, name: str, table: str = "surfaceFieldValue.dat") -> Monitor:
    """Rows of a function object over all parts of a run, from the table `table`; no rows if it has not begun.

    Where a run went on from an earlier state, its rows take the place of those that an earlier part has beyond it.
    """
    paths = [path for start in starts(case, name) if (path := start / table).is_file()]
    whole = EMPTY
    for part in filter(lambda part: part.iterations.size, map(read_table, paths)):
        if not whole.iterations.size:
            whole = part
            continue
        before = whole.iterations < part.iterations[0]
        whole = Monitor(
            np.concatenate([whole.iterations[before], part.iterations]),
            np.concatenate([whole.values[before], part.values]),
            part.area,
        )
    return whole


def starts(case: Path, name: str) -> list[Path]:
    """The folders of a function object, one for each iteration at which the solver was started, in order."""
    return list(times(case / FOLDER / name).values())


def times(folder: Path) -> dict[float, Path]:
    """The folders that are named by an iteration, or by a time [s], in order; none where `folder` is not there."""
    found = [path for path in folder.iterdir() if TIME.fullmatch(path.name)] if folder.is_dir() else []
    return {float(path.name): path for path in sorted(found, key=lambda path: float(path.name))}


def forget_from(case: Path, begin: float) -> None:
    """Removes what was written by solvers that were started at `begin` or later: it is about to be repeated."""
    names = [path.name for path in (case / FOLDER).iterdir()] if (case / FOLDER).is_dir() else []
    for name in names:
        for time, start in times(case / FOLDER / name).items():
            if time > begin - HAIR * abs(begin) or time == begin:
                shutil.rmtree(start)


def read_table(path: Path) -> Monitor:
    """A table of a function object. A last line that is still being written is left out; vectors lie flat."""
    text = path.read_text("utf-8", errors="replace")
    lines = text[: text.rfind("\n") + 1].splitlines()
    rows = [_numbers(line) for line in lines if line.strip() and not line.startswith("#")]
    width = len(rows[0]) if rows else 1
    numbers = np.array([row for row in rows if len(row) == width], float).reshape(-1, width)
    area = next((float(line.split(":")[1]) for line in lines if line.startswith("# Area")), float("nan"))
    return Monitor(numbers[:, 0], numbers[:, 1:], area)


def _numbers(line: str) -> list[float]:
    return [float(word) for word in re.sub(r"[()]", " ", line).split()]


class MeshCheck(NamedTuple):
    """Verdict of checkMesh on a mesh; `faults` are its own words, none where the mesh is sound."""

    cells: int
    non_orthogonality: float
    skewness: float
    faults: tuple[str, ...]


def read_mesh_check(text: str) -> MeshCheck:
    """The last verdict that checkMesh printed. Raises RunError where it shows no number of cells."""
    text = text[text.rfind("Mesh stats") :]
    cells = re.search(r"^\s+cells:\s+(\d+)", text, re.MULTILINE)
    if cells is None:
        raise RunError("checkMesh shows no number of cells")
    angle = re.search(r"non-orthogonality Max: ([\d.eE+-]+)", text)
    skewness = re.search(r"Max skewness = ([\d.eE+-]+)", text)
    faults = re.findall(r"\*\*\*\s*(.*)", text)
    return MeshCheck(
        int(cells[1]),
        float(angle[1]) if angle else float("nan"),
        float(skewness[1]) if skewness else float("nan"),
        tuple(" ".join(fault.split()) for fault in faults),
    )


def patch_faces(case: Path) -> dict[str, int]:
    """Number of faces of each patch of a mesh."""
    text = (case / "constant" / "polyMesh" / "boundary").read_text("utf-8")
    return dict(_patches(text))


def _patches(text: str) -> Iterator[tuple[str, int]]:
    for name, body in re.findall(r"([\w-]+)\s*\{([^{}]*)\}", text):
        if count := re.search(r"nFaces\s+(\d+)", body):
            yield name, int(count[1])


def states(case: Path) -> list[Path]:
    """The folders of whole states in a case, in order; 0 is the start.

    A state that a killed solver had not finished lacks a field, or the line at the end of one.
    """
    fields = [path.name for path in (case / "0").iterdir() if path.name != PIECES]
    return [path for time, path in times(case).items() if time == 0.0 or all(_is_whole(path / name) for name in fields)]


def _is_whole(field: Path) -> bool:
    return field.is_file() and field.read_bytes()[-len(END) - 8 :].rstrip().endswith(END)
