"""A duty cycle of a cylinder: where its rod is to be and what pulls on it, point by point, over and over.

Source  ours, docs/circuits-compared.md
"""

from itertools import pairwise
from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import FORCE, POSITION, TIME, Force, Position
from vvdp.base.params import Params
from vvdp.base.rules import refuse_rows, require_rising
from vvdp.hydraulics.cylinder import Cylinder
from vvdp.hydraulics.friction import RodFriction
from vvdp.numerics.piecewise import line_through

SAME_PLACE = 1e-6
"""A cycle ends where it began when it does so within this [m]."""
PIECES = 8
"""Number of pieces into which each line of a cycle is cut for its demand."""


class DutyCycle(Params):
    """Straight lines through points; the last one is the first one of the next round.

    `forces` are on the rod, in the direction in which its position grows: a load that resists extending is below 0.
    """

    times: Annotated[tuple[float, ...], TIME]
    positions: Annotated[tuple[float, ...], POSITION]
    forces: Annotated[tuple[float, ...], FORCE]

    def check(self) -> None:
        counts = len(self.times), len(self.positions), len(self.forces)
        if len(set(counts)) > 1 or counts[0] < 2:
            refuse_rows(
                self,
                "times",
                f"{counts[0]} times, {counts[1]} positions and {counts[2]} forces; expected as many of each, at "
                "least two",
            )
        if self.times[0] != 0.0:
            refuse_rows(self, "times", f"row 1 is at {self.times[0]:g} s; expected 0 s")
        require_rising(self, "times")
        if abs(self.positions[-1] - self.positions[0]) > SAME_PLACE:
            refuse_rows(
                self,
                "positions",
                f"row {len(self.positions)} is at {1e3 * self.positions[-1]:g} mm and row 1 at "
                f"{1e3 * self.positions[0]:g} mm; expected a cycle that ends where it begins",
            )


class CyclePoint(NamedTuple):
    """Position and load force of a cycle at an instant."""

    position: Position
    force: Force


def cycle_point(time: float, cycle: DutyCycle) -> CyclePoint:
    """Position and force of a cycle at `time` [s].

    Source  ours, docs/circuits-compared.md
    """
    return CyclePoint(
        line_through(time, cycle.times, cycle.positions, 1.0), line_through(time, cycle.times, cycle.forces, 1.0)
    )


class CycleDemand(NamedTuple):
    """Demand of a cycle on the supply of its cylinder, piece by piece: duration, flow, pressure above that of the tank.

    An overrunning load needs no pressure, and neither does a rod at rest, whose valve is closed.
    """

    time: Array  # [s]
    flow: Array  # [m^3/s]
    rise: Array  # [Pa]


def cycle_demand(cycle: DutyCycle, cylinder: Cylinder, friction: RodFriction) -> CycleDemand:
    """The demand of a cycle at steady velocities, `PIECES` for each of its lines.

    Source  ours, docs/when-switching-pays.md
    """
    times = np.concatenate([np.linspace(a, b, PIECES, endpoint=False) for a, b in pairwise(cycle.times)])
    length = np.repeat(np.diff(cycle.times) / PIECES, PIECES)
    force = np.array([cycle_point(float(t), cycle).force for t in times + 0.5 * length])
    velocity = np.repeat(cycle_speeds(cycle), PIECES)
    way, speed = np.sign(velocity), np.abs(velocity)
    area = np.where(way > 0.0, cylinder.area_a, cylinder.area_b)
    held = friction.viscous_friction * speed + friction.coulomb_friction - way * force
    return CycleDemand(length, area * speed, np.where(way == 0.0, 0.0, np.clip(held, 0.0, None) / area))


def resting_pressures(force: float, low: float, cylinder: Cylinder) -> tuple[float, float]:
    """Pressures of both chambers that hold a rod at rest under a force, the lower one being `low`, gauge [Pa].

    force  on the rod, in the direction of its position [N]

    Source  ours, docs/circuits-compared.md
    """
    other = (low * cylinder.area_a + force) / cylinder.area_b
    if other >= low:
        return low, other
    return (low * cylinder.area_b - force) / cylinder.area_a, low


def cycle_period(cycle: DutyCycle) -> float:
    """After which time a cycle comes back [s]."""
    return cycle.times[-1]


def cycle_speeds(cycle: DutyCycle) -> tuple[float, ...]:
    """The velocity of a cycle from each point to the next [m/s]."""
    return tuple(float(v) for v in np.diff(cycle.positions) / np.diff(cycle.times))


def refuse_fast_cycle(cycle: DutyCycle, fastest: float) -> None:
    """Raises ParameterError, with its row, where a cycle goes faster than a machine can.

    fastest  speed that the machine can reach [m/s]
    """
    for row, speed in enumerate(cycle_speeds(cycle), 2):
        if abs(speed) > fastest:
            speeds = f"{1e3 * abs(speed):.4g} mm/s; pump and cylinder reach {1e3 * fastest:.4g} mm/s"
            refuse_rows(cycle, "positions", f"row {row} asks for {speeds}")


def refuse_long_cycle(cycle: DutyCycle, lowest: float, highest: float) -> None:
    """Raises ParameterError, with its row, where a cycle leaves the cylinder's travel.

    lowest, highest  ends of the travel [m]
    """
    for row, position in enumerate(cycle.positions, 1):
        if not lowest <= position <= highest:
            travel = f"{1e3 * lowest:.4g} to {1e3 * highest:.4g} mm"
            refuse_rows(cycle, "positions", f"row {row} is at {1e3 * position:.4g} mm; the rod travels from {travel}")
