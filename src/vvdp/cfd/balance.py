"""Torque on what turns, by its forces and by the angular momentum that enters and leaves: two ways to one number."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from vvdp.cfd.case import Case
from vvdp.cfd.section import read_section
from vvdp.cfd.watching import FORCES, STILL, Monitors, force_monitors, read_torque


class Torques(NamedTuple):
    """Torque about z on what turns [N m]: by pressure and friction on it, its range, and by angular momentum.

    All are nan where nothing turns.
    """

    forces: float
    spread: float
    momentum: float


NONE = Torques(math.nan, math.nan, math.nan)


def torque_monitors(turning: Sequence[str], still: Sequence[str], density: float) -> Monitors:
    """Function objects for the torque on what turns, and on walls at rest."""
    return {**force_monitors(turning, density), **force_monitors(still, density, STILL)}


def openings(case: Case) -> tuple[str, ...]:
    """The patches of a case that are no walls: the oil enters or leaves by them, or slides along without friction."""
    return tuple(name for name, patch in case.patches.items() if patch.kind == "patch")


def read_torques(case: Case, folder: Path, count: int) -> Torques:
    """The torques of a run that was solved and cut: means over the last window of its `count` iterations.

    In steady flow nothing is stored: what turns takes what neither walls at rest nor oil that leaves take,
    T = -T_still - sum over openings of rho (r x u)_z u_n + p (r x n)_z, over their areas.

    Source  ours, docs/models/cfd.md
    """
    last = slice(count - case.phases[-1].window, count)
    turning, still = (read_torque(folder, name).value[last] for name in (FORCES, STILL))
    if not len(turning):
        return NONE
    shown = [read_section(folder, name) for name in openings(case)]
    leaving = math.fsum(each.axial_moment for each in shown if each)
    momentum = -float(still.mean()) - case.fluid.density * leaving
    return Torques(float(turning.mean()), float(turning.max() - turning.min()), momentum)
