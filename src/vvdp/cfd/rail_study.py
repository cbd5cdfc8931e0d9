"""The flow through inlet rails at several flows, of several shapes, or on several grids."""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from vvdp.cfd.monitor import read_monitor
from vvdp.cfd.rail import RailOrder, outlets, rail_case, turned_rail
from vvdp.cfd.section import Plane
from vvdp.cfd.series import NamedCase, case_folder, solve_series
from vvdp.cfd.solve import Hear, Solved
from vvdp.cfd.watching import flow_name
from vvdp.geometry.measure import Mouth, rail_mouths
from vvdp.studies.engine import Engine


class RailRun(NamedTuple):
    """A rail that was computed: the run, its mouths by the surface, their areas in the mesh [m^2], the mean flows
    through them over the last window [m^3/s], the volume of oil [m^3], seconds in all."""

    solved: Solved
    mouths: tuple[Mouth, ...]
    mesh_areas: tuple[float, ...]
    flows: tuple[float, ...]
    volume: float
    seconds: float


def run_rails(orders: Mapping[str, RailOrder], directory: Path, engine: Engine, hear: Hear) -> tuple[RailRun, ...]:
    """Computes orders by name, those of one shape and grid on one mesh, or goes on with them; see `solve`."""
    first = next(iter(orders.values()))
    domains = {order.shape: turned_rail(order) for order in orders.values()}
    # A hair off the middle, where the nozzles' corners lie.
    plane = Plane((0.0, 0.0, 1e-3 * first.valve.spool_radius), (0.0, 0.0, 1.0))
    cases = [NamedCase(name, rail_case(order, domains[order.shape])) for name, order in orders.items()]
    runs, patches = [], outlets(first.valve)
    solved_cases = solve_series(cases, plane, directory, engine, hear)
    for place, (order, solved) in enumerate(zip(orders.values(), solved_cases, strict=True)):
        folder = case_folder(directory, place)
        window, domain = order.phases[-1].window, domains[order.shape]
        run = RailRun(
            solved=solved,
            mouths=tuple(rail_mouths(domain.mesh, order.valve)),
            mesh_areas=tuple(read_monitor(folder, flow_name(patch)).area for patch in patches),
            flows=tuple(float(solved.history.flows[patch][-window:].mean()) for patch in patches),
            volume=domain.volume,
            seconds=solved.took,
        )
        runs.append(run)
    return tuple(runs)
