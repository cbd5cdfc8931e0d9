"""The cycle that a cylinder is to follow: there and back in straight lines, or one of a user's own, point by point.

Source  ours, docs/models/displacement-control.md
"""

from itertools import pairwise
from typing import Annotated

import numpy as np

from vvdp.base.errors import ParameterError
from vvdp.base.kinds import POSITION, TIME, Fraction, Position, Time
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.numerics.piecewise import line_through


class Triangle(Params):
    """The [cycle] table: from `lower_end` over a `stroke` and back, each way in `stroke_time`, again and again.

    What is known ahead is read `preview` earlier, which makes up for the delay of the reference filter.
    """

    lower_end: Position
    stroke: Position
    stroke_time: Time
    preview: Time = 0.0

    def check(self) -> None:
        require_positive(self, "stroke", "stroke_time")


class OwnCycle(Params):
    """The [cycle] table: straight lines through points, the first at time 0; over and over where it `repeats`, else the
    last is held."""

    times: Annotated[tuple[float, ...], TIME]
    positions: Annotated[tuple[float, ...], POSITION]
    repeats: Fraction = 0.0
    preview: Time = 0.0

    def check(self) -> None:
        refuse_bad_points(self.times, self.positions)
        if self.repeats not in (0.0, 1.0) or (self.repeats and self.positions[0] != self.positions[-1]):
            raise ParameterError(
                f"repeats = {self.repeats:g}; expected 0, or 1 if the last position, {1e3 * self.positions[-1]:g} "
                f"mm, equals the first, {1e3 * self.positions[0]:g} mm"
            )


def refuse_bad_points(times: tuple[float, ...], positions: tuple[float, ...]) -> None:
    """Raises ParameterError, with its row from 1 on, where points make no cycle: times that do not rise from 0.

    times      [s]
    positions  [m]
    """
    if len(times) != len(positions) or len(times) < 2:
        raise ParameterError(f"{len(times)} times and {len(positions)} positions; expected as many, two at least")
    if times[0] != 0.0:
        raise ParameterError(f"row 1: the time is {times[0]:g} s; expected 0 s, where control begins")
    for row, (before, after) in enumerate(pairwise(times), 2):
        if not after > before:
            raise ParameterError(f"row {row}: the time is {after:g} s after {before:g} s; expected times that rise")


def refuse_fast_points(cycle: Triangle | OwnCycle, fastest: float, longest_gap: float = 1.0) -> None:
    """Raises ParameterError, with its row, where a cycle goes faster than the machine can, or where rows are missing.

    A row is taken to be missing where the time to it is above `longest_gap` [s] and above ten times the usual one.

    fastest  speed that the machine can reach [m/s]
    """
    points = points_of(cycle)
    intervals = np.diff(points.times)
    speeds = np.abs(np.diff(points.positions)) / intervals
    if np.any(speeds > fastest):
        row = int(np.argmax(speeds > fastest)) + 2
        raise ParameterError(
            f"cycle: row {row}: {1e3 * speeds[row - 2]:.4g} mm/s are asked for; pump and cylinder reach "
            f"{1e3 * fastest:.4g} mm/s"
        )
    usual = float(np.median(intervals))
    gaps = intervals > max(longest_gap, 10.0 * usual)
    if np.any(gaps):
        row = int(np.argmax(gaps)) + 2
        raise ParameterError(
            f"cycle: row {row}: {intervals[row - 2]:.4g} s after the row before, where {usual:.4g} s are "
            "usual; expected no gap"
        )


class Points(Params):
    """A cycle as the program reads it."""

    times: Annotated[tuple[float, ...], TIME]
    positions: Annotated[tuple[float, ...], POSITION]
    repeats: Fraction
    preview: Time


def points_of(cycle: Triangle | OwnCycle) -> Points:
    """The points of a cycle."""
    if isinstance(cycle, OwnCycle):
        return Points(times=cycle.times, positions=cycle.positions, repeats=cycle.repeats, preview=cycle.preview)
    ends = (cycle.lower_end, cycle.lower_end + cycle.stroke, cycle.lower_end)
    return Points(
        times=(0.0, cycle.stroke_time, 2.0 * cycle.stroke_time), positions=ends, repeats=1.0, preview=cycle.preview
    )


def fastest(points: Points) -> float:
    """Highest speed of a cycle, before any filter [m/s]."""
    return float(np.max(np.abs(np.diff(points.positions) / np.diff(points.times))))


def cycle_position(time: float, points: Points) -> float:
    """Position of a cycle [m], before any filter.

    time  since control began [s]
    """
    return line_through(time + points.preview, points.times, points.positions, points.repeats)


def first_direction(cycle: Triangle | OwnCycle) -> float:
    """Direction of a cycle's first move: 1 outward, also for a cycle that never moves, -1 inward."""
    moves = np.diff(points_of(cycle).positions)
    return -1.0 if np.any(moves) and moves[np.flatnonzero(moves)[0]] < 0.0 else 1.0
