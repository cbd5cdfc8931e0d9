"""The flow through a centre section at several flows or spool angles, from a valve's shape to what was computed."""

import math
import time
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from vvdp.base.display import with_unit
from vvdp.base.kinds import ANGLE, FLOW
from vvdp.cfd.centre import CentreOrder, centre_case, inlets, turned_centre
from vvdp.cfd.monitor import read_monitor
from vvdp.cfd.section import Plane
from vvdp.cfd.series import NamedCase, case_folder, solve_series
from vvdp.cfd.solve import Hear, Solved
from vvdp.cfd.watching import flow_name, read_torque


class CentreRun(NamedTuple):
    """A centre section that was computed: the run, torque on the spool [N m], area of the stubs in the mesh [m^2]."""

    order: CentreOrder
    solved: Solved
    torque: float
    stub_area: float
    seconds: float


def run_centre(
    order: CentreOrder, flows: Sequence[float], directory: Path, cores: int, hear: Hear
) -> tuple[CentreRun, ...]:
    """Computes an order at each of several flows [m^3/s] on one mesh, or goes on with it; see `solve`.

    Raises ParameterError where the nozzles are shut.
    """
    return _run([(with_unit(flow, FLOW), order._replace(flow=flow)) for flow in flows], directory, cores, hear)


def run_angles(
    order: CentreOrder, angles: Sequence[float], directory: Path, cores: int, hear: Hear
) -> tuple[CentreRun, ...]:
    """Computes an order at each of several spool angles [rad], each on a mesh of its own, or goes on with it.

    Raises ParameterError where the nozzles are shut.
    """
    return _run([(with_unit(angle, ANGLE), order._replace(angle=angle)) for angle in angles], directory, cores, hear)


def _run(orders: Sequence[tuple[str, CentreOrder]], directory: Path, cores: int, hear: Hear) -> tuple[CentreRun, ...]:
    first = orders[0][1]
    domains = {angle: turned_centre(first._replace(angle=angle)) for angle in {each.angle for _, each in orders}}
    cases = [NamedCase(name, centre_case(each, domains[each.angle])) for name, each in orders]
    plane = Plane((0.0, 0.0, 1e-3 * first.valve.spool_radius), (0.0, 0.0, 1.0))
    runs, began, window = [], time.perf_counter(), first.phases[-1].window
    for place, solved in enumerate(solve_series(cases, plane, directory, cores, hear)):
        folder, now = case_folder(directory, place), time.perf_counter()
        count, order = len(solved.history.iterations), orders[place][1]
        torque = float(read_torque(folder).value[count - window : count].mean())
        area = math.fsum(read_monitor(folder, flow_name(end)).area for end in inlets(order.valve))
        runs.append(CentreRun(order, solved, torque, area, now - began))
        began = now
    return tuple(runs)
