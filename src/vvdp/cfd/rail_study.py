"""The flow through an inlet rail, at one flow or several, from a valve's shape to what was computed."""

import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from vvdp.base.display import with_unit
from vvdp.base.kinds import FLOW
from vvdp.cfd.monitor import read_monitor
from vvdp.cfd.rail import RailOrder, outlets, rail_case, turned_rail
from vvdp.cfd.section import Plane
from vvdp.cfd.series import NamedCase, case_folder, solve_series
from vvdp.cfd.solve import Hear, Solved
from vvdp.cfd.watching import flow_name
from vvdp.geometry.measure import Mouth, rail_mouths


class RailRun(NamedTuple):
    """A rail that was computed: the run, its mouths by the surface, their areas in the mesh [m^2], the mean flows
    through them over the last window [m^3/s], the volume of oil [m^3], seconds in all."""

    solved: Solved
    mouths: tuple[Mouth, ...]
    mesh_areas: tuple[float, ...]
    flows: tuple[float, ...]
    volume: float
    seconds: float


def run_rail(order: RailOrder, directory: Path, cores: int, hear: Hear) -> RailRun:
    """Computes an order in `directory`, or goes on with it; see `solve` for what is raised and kept."""
    return _run([NamedOrder("", order)], directory, cores, hear)[0]


def run_sweep(order: RailOrder, flows: Sequence[float], directory: Path, cores: int, hear: Hear) -> tuple[RailRun, ...]:
    """Computes an order at each of several flows [m^3/s] on one mesh, or goes on with it; see `solve`."""
    return _run(
        [NamedOrder(with_unit(flow, FLOW), order._replace(flow=flow)) for flow in flows], directory, cores, hear
    )


def run_grids(
    order: RailOrder, grids: Mapping[str, float], directory: Path, cores: int, hear: Hear
) -> tuple[RailRun, ...]:
    """Computes an order on each of several grids, by name [cells per spool radius], or goes on with it; see `solve`."""
    return _run([NamedOrder(name, order._replace(grid=grid)) for name, grid in grids.items()], directory, cores, hear)


def run_designs(orders: Mapping[str, RailOrder], directory: Path, cores: int, hear: Hear) -> tuple[RailRun, ...]:
    """Computes orders whose shapes differ, by name, each on a mesh of its own, or goes on with them; see `solve`."""
    return _run([NamedOrder(name, order) for name, order in orders.items()], directory, cores, hear)


class NamedOrder(NamedTuple):
    """An order, and what it is called among others of a series."""

    name: str
    order: RailOrder


def _run(orders: Sequence[NamedOrder], directory: Path, cores: int, hear: Hear) -> tuple[RailRun, ...]:
    first = orders[0].order
    domains = {order.shape: turned_rail(order) for _, order in orders}
    # A hair off the middle, where the nozzles' corners lie.
    plane = Plane((0.0, 0.0, 1e-3 * first.valve.spool_radius), (0.0, 0.0, 1.0))
    cases = [NamedCase(name, rail_case(order, domains[order.shape])) for name, order in orders]
    runs, began, patches = [], time.perf_counter(), outlets(first.valve)
    for place, solved in enumerate(solve_series(cases, plane, directory, cores, hear)):
        folder, now, order = case_folder(directory, place), time.perf_counter(), orders[place].order
        window, domain = order.phases[-1].window, domains[order.shape]
        run = RailRun(
            solved=solved,
            mouths=tuple(rail_mouths(domain.mesh, order.valve)),
            mesh_areas=tuple(read_monitor(folder, flow_name(patch)).area for patch in patches),
            flows=tuple(float(solved.history.flows[patch][-window:].mean()) for patch in patches),
            volume=domain.volume,
            seconds=now - began,
        )
        runs.append(run)
        began = now
    return tuple(runs)
