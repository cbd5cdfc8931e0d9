"""Cases in one directory, solved by an engine, which a later call goes on with."""

import json
import re
import shutil
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import NamedTuple

from vvdp.base.errors import unusable
from vvdp.base.files import clear_below, write_whole
from vvdp.base.manifest import has_list, open_directory, refuse_foreign, refuse_links
from vvdp.cfd.balance import openings
from vvdp.cfd.case import Case
from vvdp.cfd.convergence import Judgement
from vvdp.cfd.engine import find_openfoam
from vvdp.cfd.monitor import TIME
from vvdp.cfd.section import Plane, cut_sections
from vvdp.cfd.solve import LOOK, STATE, Hear, Progress, Solved, solve
from vvdp.results.store import DESCRIPTION
from vvdp.studies.engine import Engine
from vvdp.studies.work import Batching, batches

CASE = "case"
"""Folder of the first case in the directory of a result; others have a number behind it."""
CASES = re.compile(rf"{CASE}(-\d+)?")
OF_CASE = re.compile(r"log\.\w+|processor\d+|constant|system|postProcessing|state\.json|progress\.json|lock|stop")
"""Files that vvdp and OpenFOAM write into the folder of a case, except the folders of times."""
MIDDLE = "middle"
"""The section that is cut through every flow."""


PROGRESS = "progress.json"
"""How far a case is, as the process that computes it has noted."""
ONE_BY_ONE = Batching(least=1, seconds=0.0)


class SeriesStopped(KeyboardInterrupt):
    """A series was stopped; `missing` are the names of its cases that are not finished, of `total` cases."""

    def __init__(self, missing: Sequence[str], total: int) -> None:
        super().__init__()
        self.missing, self.total = tuple(missing), total

    @property
    def words(self) -> str:
        """The missing cases, in words."""
        if self.total == 1:
            return "the case is not finished"
        return f"{len(self.missing)} of {self.total} cases are missing: {'; '.join(self.missing)}"


class NamedCase(NamedTuple):
    """A case, and what it is called among others of a series."""

    name: str
    case: Case


def case_folder(directory: Path, place: int) -> Path:
    """The folder of a case by its place in a series, from 0."""
    return directory / (f"{CASE}-{place + 1}" if place else CASE)


class _Item(NamedTuple):
    """A case in its place, and the folder of the case whose mesh it has."""

    place: int
    case: Case
    folder: Path
    mesh_of: Path | None

    @property
    def most(self) -> int:
        """Iterations at most."""
        return sum(phase.most for phase in self.case.phases)


def solve_series(cases: Sequence[NamedCase], plane: Plane, directory: Path, engine: Engine, hear: Hear) -> list[Solved]:
    """Computes cases on an engine whose workers see the directory, with the section `plane` cut, in their order.

    One that is meshed as another has its mesh, and waits for it; the others are computed as workers are free. See
    `solve` for what is raised and kept; where it is stopped, SeriesStopped says which cases are missing.
    """
    find_openfoam()
    items = list(_items([case for _, case in cases], directory.resolve()))
    solved: dict[int, Solved] = {}
    names = [name for name, _ in cases]
    try:
        with engine, _listen(items, names, solved, hear):
            for has_mesh in (False, True):
                ready = [item for item in items if (item.mesh_of is not None) == has_mesh]
                for done in batches(partial(_solve_items, plane), ready, engine, threading.Event(), ONE_BY_ONE):
                    solved.update(done)
    except KeyboardInterrupt:
        missing = [name for place, name in enumerate(names) if place not in solved]
        raise SeriesStopped(missing, len(names)) from None
    return [solved[place] for place in range(len(cases))]


def _items(cases: Sequence[Case], directory: Path) -> Iterator[_Item]:
    for place, case in enumerate(cases):
        like = next((k for k in range(place) if cases[k].mesh_files == case.mesh_files), None)
        yield _Item(place, case, case_folder(directory, place), None if like is None else case_folder(directory, like))


def _solve_items(plane: Plane, items: Sequence[_Item], cores: int) -> list[tuple[int, Solved]]:
    """Computes cases where a worker is, and cuts their flow."""
    openfoam, done = find_openfoam(), []
    for item in items:
        solved = solve(item.case, item.folder, openfoam, cores, partial(_note, item.folder), item.mesh_of)
        cut_sections({MIDDLE: plane}, openings(item.case), item.folder, openfoam)
        done.append((item.place, solved))
    return done


def _note(folder: Path, now: Progress) -> None:
    """Leaves in a folder how far its case is."""
    write_whole(folder / PROGRESS, json.dumps(now))


def _read_note(folder: Path) -> Progress | None:
    """How far a case is, None where that is not known."""
    try:
        words, done, most, judgement = json.loads((folder / PROGRESS).read_text("utf-8"))
    except (OSError, ValueError):
        return None
    return Progress(words, done, most, Judgement(*judgement) if judgement else None)


@contextmanager
def _listen(items: Sequence[_Item], names: Sequence[str], solved: Mapping[int, Solved], hear: Hear) -> Iterator[None]:
    """Shows how far all cases are together, wherever they are computed, each time that one has left a note."""
    for item in items:
        (item.folder / PROGRESS).unlink(missing_ok=True)
    most, ended = sum(item.most for item in items), threading.Event()

    def listen() -> None:
        told: dict[int, Progress] = {}
        while not ended.wait(LOOK):
            for item, name in zip(items, names, strict=True):
                now = _read_note(item.folder)
                if now is None or now == told.get(item.place):
                    continue
                told[item.place] = now
                done = sum(each.most for each in items if each.place in solved)
                done += sum(each.done for place, each in told.items() if place not in solved)
                words = f"{name}, {now.words}" if now.judgement and name else now.words
                hear(Progress(words, done, most, now.judgement))

    listener = threading.Thread(target=listen, daemon=True)
    listener.start()
    try:
        yield
    finally:
        ended.set()
        listener.join()


def make_place(directory: Path, verb: str, *, force: bool) -> None:
    """Makes `directory` the place of a run of `verb`, new or to be gone on with.

    With `force` an earlier one is discarded. Raises ConfigError where it holds something else, files that have changed
    or, with `force`, any that vvdp and OpenFOAM did not write; or where it cannot be written.
    """
    if directory.exists() and not directory.is_dir():
        raise unusable(directory, "is not a directory")
    is_run = (directory / CASE / STATE).is_file()
    if directory.is_dir() and any(directory.iterdir()) and not is_run:
        raise unusable(directory, "holds something else than a computed flow; choose another directory")
    if is_run:
        refuse_links(directory)
        _require_flow(directory, verb)
    try:
        if force and directory.exists():
            clear_below(directory)
            refuse_foreign(directory, directory, lambda path: _is_of_case(path.relative_to(directory)))
            shutil.rmtree(directory)
        directory.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise unusable(directory, f"cannot be written ({problem.strerror})") from None


def _require_flow(directory: Path, verb: str) -> None:
    """Raises ConfigError where the result in a directory has changed, or is of another verb."""
    if has_list(directory):
        opened = open_directory(directory, resuming=True)
        if DESCRIPTION in opened.files and opened.json(DESCRIPTION).get("verb") != verb:
            raise unusable(directory, "holds the result of another command; choose another directory")


def _is_of_case(path: Path) -> bool:
    """Whether a path below the directory of a flow is named as what vvdp and OpenFOAM write for a case."""
    folder, *inner = path.parts
    return (
        bool(inner) and bool(CASES.fullmatch(folder)) and bool(OF_CASE.fullmatch(inner[0]) or TIME.fullmatch(inner[0]))
    )
