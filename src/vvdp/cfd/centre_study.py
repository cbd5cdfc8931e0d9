"""The flow through a centre section at several flows, spool angles, diameters, or on several grids."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from vvdp.cfd.centre import CentreOrder, centre_case, inlets, turned_centre
from vvdp.cfd.monitor import read_monitor
from vvdp.cfd.section import Plane
from vvdp.cfd.series import NamedCase, case_folder, solve_series
from vvdp.cfd.solve import Hear, Solved
from vvdp.cfd.watching import flow_name, read_torque
from vvdp.geometry.domains import Domain
from vvdp.studies.engine import Engine


class CentreRun(NamedTuple):
    """A centre section that was computed: the run, torque on the spool [N m], area of the stubs in the mesh [m^2]."""

    order: CentreOrder
    solved: Solved
    torque: float
    stub_area: float
    seconds: float


def run_centre(orders: Mapping[str, CentreOrder], directory: Path, engine: Engine, hear: Hear) -> tuple[CentreRun, ...]:
    """Computes orders by name, those of one shape, angle and grid on one mesh, or goes on with them; see `solve`.

    Raises ParameterError where the nozzles are closed.
    """
    made: dict[CentreOrder, Domain] = {}
    cases = []
    for name, order in orders.items():
        alike = order._replace(flow=0.0)
        made[alike] = made.get(alike) or turned_centre(order)
        cases.append(NamedCase(name, centre_case(order, made[alike])))
    first = next(iter(orders.values()))
    plane = Plane((0.0, 0.0, 1e-3 * first.valve.spool_radius), (0.0, 0.0, 1.0))
    runs = []
    solved_cases = solve_series(cases, plane, directory, engine, hear)
    for place, (order, solved) in enumerate(zip(orders.values(), solved_cases, strict=True)):
        folder = case_folder(directory, place)
        count, window = len(solved.history.iterations), order.phases[-1].window
        torque = float(read_torque(folder).value[count - window : count].mean())
        area = math.fsum(read_monitor(folder, flow_name(end)).area for end in inlets(order.valve))
        runs.append(CentreRun(order, solved, torque, area, solved.took))
    return tuple(runs)
