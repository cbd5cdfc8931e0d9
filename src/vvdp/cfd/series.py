"""Cases in one directory, solved one after the other, which a later call goes on with."""

import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from vvdp.base.errors import unusable
from vvdp.cfd.balance import openings
from vvdp.cfd.case import Case
from vvdp.cfd.engine import find_openfoam
from vvdp.cfd.section import Plane, cut_sections
from vvdp.cfd.solve import STATE, Hear, Progress, Solved, solve
from vvdp.results.store import DESCRIPTION, read_result

CASE = "case"
"""Folder of the first case in the directory of a result; others have a number behind it."""
MIDDLE = "middle"
"""The section that is cut through every flow."""


class NamedCase(NamedTuple):
    """A case, and what it is called among others of a series."""

    name: str
    case: Case


def case_folder(directory: Path, place: int) -> Path:
    """The folder of a case by its place in a series, from 0."""
    return directory / (f"{CASE}-{place + 1}" if place else CASE)


def solve_series(cases: Sequence[NamedCase], plane: Plane, directory: Path, cores: int, hear: Hear) -> Iterator[Solved]:
    """Yields each case as it is computed, with the section `plane` cut; one that is meshed as another has its mesh.

    See `solve` for what is raised and kept.
    """
    openfoam = find_openfoam()
    for place, (name, case) in enumerate(cases):

        def hear_of_all(now: Progress, place: int = place, name: str = name) -> None:
            words = f"{name}, {now.words}" if now.judgement and name else now.words
            hear(Progress(words, place * now.most + now.done, len(cases) * now.most, now.judgement))

        folder = case_folder(directory, place)
        like = next((k for k in range(place) if cases[k].case.mesh_files == case.mesh_files), None)
        mesh_of = None if like is None else case_folder(directory, like)
        solved = solve(case, folder, openfoam, cores, hear_of_all, mesh_of)
        cut_sections({MIDDLE: plane}, openings(case), folder, openfoam)
        yield solved


def make_place(directory: Path, verb: str, *, force: bool) -> None:
    """Makes `directory` the place of a run of `verb`, new or to be gone on with.

    With `force` an earlier one is discarded. Raises ConfigError where it holds something else, or cannot be written.
    """
    if directory.exists() and not directory.is_dir():
        raise unusable(directory, "is not a directory")
    is_run = (directory / CASE / STATE).is_file()
    if directory.is_dir() and any(directory.iterdir()) and not is_run:
        raise unusable(directory, "holds something else than a computed flow; choose another directory")
    if is_run and (directory / DESCRIPTION).is_file() and read_result(directory).verb != verb:
        raise unusable(directory, "holds the result of another command; choose another directory")
    try:
        if force and directory.exists():
            shutil.rmtree(directory)
        directory.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise unusable(directory, f"cannot be written ({problem.strerror})") from None
