"""The flow through an outlet turbine at several flows and speeds of its spool, or on several grids."""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from vvdp.cfd.balance import Torques, read_torques
from vvdp.cfd.monitor import read_monitor
from vvdp.cfd.passage import BEHIND
from vvdp.cfd.section import Plane
from vvdp.cfd.series import NamedCase, case_folder, solve_series
from vvdp.cfd.solve import Hear, Solved
from vvdp.cfd.turbine import TurbineOrder, turbine_case, turned_turbine
from vvdp.studies.engine import Engine


class TurbineRun(NamedTuple):
    """A turbine that was computed: the run, torques on the spool, drop behind it [Pa]."""

    order: TurbineOrder
    solved: Solved
    torques: Torques
    behind: float
    seconds: float


def run_turbine(
    orders: Mapping[str, TurbineOrder], directory: Path, engine: Engine, hear: Hear
) -> tuple[TurbineRun, ...]:
    """Computes orders of one shape by name, those of one grid on one mesh, or goes on with them; see `solve`."""
    domain = turned_turbine(next(iter(orders.values())))
    heights = domain.mesh.of("channels")[:, :, 2]
    plane = Plane((0.0, 0.0, 0.5 * float(heights.min() + heights.max())), (0.0, 0.0, 1.0))
    cases = [NamedCase(name, turbine_case(order, domain)) for name, order in orders.items()]
    runs = []
    solved_cases = solve_series(cases, plane, directory, engine, hear)
    for place, (order, solved) in enumerate(zip(orders.values(), solved_cases, strict=True)):
        folder = case_folder(directory, place)
        count = len(solved.history.iterations)
        window = order.phases[-1].window
        behind = order.fluid.density * read_monitor(folder, BEHIND).values[count - window : count, 0]
        run = TurbineRun(
            order=order,
            solved=solved,
            torques=read_torques(cases[place].case, folder, count),
            behind=float(behind.mean()),
            seconds=solved.took,
        )
        runs.append(run)
    return tuple(runs)
