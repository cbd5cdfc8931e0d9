"""The flow through an outlet turbine at several speeds of its spool, from a valve's shape to what was computed."""

import time
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vvdp.base.display import with_unit
from vvdp.base.kinds import SPEED
from vvdp.cfd.monitor import read_monitor
from vvdp.cfd.section import Plane
from vvdp.cfd.series import NamedCase, case_folder, solve_series
from vvdp.cfd.solve import Hear, Solved
from vvdp.cfd.turbine import BEHIND, TurbineOrder, turbine_case, turned_turbine
from vvdp.cfd.watching import read_torque


class TurbineRun(NamedTuple):
    """A turbine that was computed: the run, torque on the spool about z [N m] and its range, drop behind it [Pa]."""

    speed: float
    solved: Solved
    torque: float
    torque_spread: float
    behind: float
    seconds: float


def run_turbine(
    order: TurbineOrder, speeds: Sequence[float], directory: Path, cores: int, hear: Hear
) -> tuple[TurbineRun, ...]:
    """Computes an order at each of several speeds [rad/s] on one mesh, or goes on with it; see `solve`."""
    domain = turned_turbine(order)
    heights = domain.mesh.of("channels")[:, :, 2]
    plane = Plane((0.0, 0.0, 0.5 * float(heights.min() + heights.max())), (0.0, 0.0, 1.0))
    orders = [order._replace(speed=speed) for speed in speeds]
    cases = [NamedCase(with_unit(each.speed, SPEED), turbine_case(each, domain)) for each in orders]
    runs, began, window = [], time.perf_counter(), order.phases[-1].window
    for place, solved in enumerate(solve_series(cases, plane, directory, cores, hear)):
        folder, now = case_folder(directory, place), time.perf_counter()
        last = slice(len(solved.history.iterations) - window, len(solved.history.iterations))
        torque = read_torque(folder).value[last]
        behind = order.fluid.density * read_monitor(folder, BEHIND).values[last, 0]
        spread = float(np.ptp(torque))
        runs.append(
            TurbineRun(
                speed=speeds[place],
                solved=solved,
                torque=float(torque.mean()),
                torque_spread=spread,
                behind=float(behind.mean()),
                seconds=now - began,
            )
        )
        began = now
    return tuple(runs)
