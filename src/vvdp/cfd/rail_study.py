"""The flow through an inlet rail, from a valve's shape to a result in a directory that a later call goes on with."""

import shutil
import time
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from vvdp.base.display import with_unit
from vvdp.base.errors import unusable
from vvdp.base.kinds import FLOW
from vvdp.cfd.engine import find_openfoam
from vvdp.cfd.monitor import read_monitor
from vvdp.cfd.rail import RailOrder, outlets, rail_case, turned_rail
from vvdp.cfd.section import Plane, cut_sections
from vvdp.cfd.solve import STATE, Hear, Progress, Solved, solve
from vvdp.cfd.watching import flow_name
from vvdp.geometry.measure import Mouth, rail_mouths
from vvdp.results.store import DESCRIPTION, read_result

CASE = "case"
"""Folder of the case in the directory of a result."""
MIDDLE = "middle"
"""The section through the axes of all nozzles."""


class RailRun(NamedTuple):
    """A rail that was computed: the run, its mouths by the surface, their areas in the mesh [m^2], seconds in all."""

    solved: Solved
    mouths: tuple[Mouth, ...]
    mesh_areas: tuple[float, ...]
    seconds: float


def run_rail(order: RailOrder, directory: Path, cores: int, hear: Hear) -> RailRun:
    """Computes an order in `directory`, or goes on with it; see `solve` for what is raised and kept."""
    return _run_in(directory / CASE, order, cores, hear, None)


def run_sweep(order: RailOrder, flows: Sequence[float], directory: Path, cores: int, hear: Hear) -> tuple[RailRun, ...]:
    """Computes an order at each of several flows [m^3/s] on one mesh, or goes on with it; see `solve`."""
    found: list[RailRun] = []
    for place, flow in enumerate(flows):

        def hear_of_all(now: Progress, place: int = place, flow: float = flow) -> None:
            words = f"{with_unit(flow, FLOW)}, {now.words}" if now.judgement else now.words
            hear(Progress(words, place * now.most + now.done, len(flows) * now.most, now.judgement))

        folder = directory / (f"{CASE}-{place + 1}" if place else CASE)
        mesh_of = directory / CASE if place else None
        found.append(_run_in(folder, order._replace(flow=flow), cores, hear_of_all, mesh_of))
    return tuple(found)


def _run_in(folder: Path, order: RailOrder, cores: int, hear: Hear, mesh_of: Path | None) -> RailRun:
    began, openfoam = time.perf_counter(), find_openfoam()
    domain = turned_rail(order)
    solved = solve(rail_case(order, domain), folder, openfoam, cores, hear, mesh_of)
    # A hair off the middle, where the nozzles' corners lie.
    height = 1e-3 * order.valve.spool_radius
    cut_sections({MIDDLE: Plane((0.0, 0.0, height), (0.0, 0.0, 1.0))}, folder, openfoam)
    return RailRun(
        solved=solved,
        mouths=tuple(rail_mouths(domain.mesh, order.valve)),
        mesh_areas=tuple(read_monitor(folder, flow_name(mouth)).area for mouth in outlets(order.valve)),
        seconds=time.perf_counter() - began,
    )


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
