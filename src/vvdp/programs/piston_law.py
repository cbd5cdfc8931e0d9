"""Choice of the pistons of a pump that deliver: a program that is called for each one.

Source  ours, docs/circuits-compared.md
"""

import math
from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import Count, Flow, Ratio
from vvdp.base.params import Params
from vvdp.base.select import clip
from vvdp.hydraulics.digital_pump import EnabledPistons
from vvdp.network.program import ProgramType


class PistonLaw(Params):
    """A pump of so many `pistons` that gives the `largest_flow` with all of them."""

    pistons: Count
    largest_flow: Flow


class FlowDemand(NamedTuple):
    """The demanded flow of the pump."""

    flow: Flow


class PistonMemory(NamedTuple):
    """Memory of the law from piston to piston: how many strokes it owes, the number of the piston, the enabled pistons
    of the last half revolution as the bits of a number, and the sums over these pistons."""

    owed: Ratio
    place: Count
    enabled: Count
    cosine: Ratio
    sine: Ratio


def piston_start(settings: PistonLaw) -> PistonMemory:
    """The memory before the first piston: all idle."""
    return PistonMemory(0.0, 0.0, 0.0, 0.0, 0.0)


def piston_step(
    t: float, memory: PistonMemory, asked: FlowDemand, settings: PistonLaw
) -> tuple[PistonMemory, EnabledPistons]:
    """Enable a piston of a digital pump if half a stroke or more is owed; called for each at its bottom dead centre.

    What is owed grows by the flow over the largest one, and falls by 1 with each enabled piston, so that it stays
    between -1/2 and 1/2. The piston half a revolution before ends its stroke.
    """
    half, angle = settings.pistons / 2.0, 2.0 * math.pi * memory.place / settings.pistons
    owed = memory.owed + clip(asked.flow / settings.largest_flow, 0.0, 1.0)
    enable = 1.0 if owed >= 0.5 else 0.0
    top = 2.0 ** (half - 1.0)
    ended = 1.0 if memory.enabled >= top else 0.0
    enabled = 2.0 * (memory.enabled - ended * top) + enable
    some, change = (1.0 if enabled > 0.0 else 0.0), enable + ended  # the angle of the ended one is less by pi
    cosine = some * (memory.cosine + change * float(np.cos(angle)))
    sine = some * (memory.sine + change * float(np.sin(angle)))
    place = 0.0 if memory.place + 1.0 >= settings.pistons else memory.place + 1.0
    after = PistonMemory(owed - enable, place, enabled, cosine, sine)
    return after, EnabledPistons(cosine, sine, ones(enabled) / half, enable)


def ones(number: float) -> float:
    """Number of bits of a whole number that are 1.

    >>> ones(11.0)
    3.0
    """
    left, count = number, 0.0
    while left > 0.0:
        half = float(np.floor(left / 2.0))
        count, left = count + left - 2.0 * half, half
    return count


PISTON_LAW = ProgramType(piston_step, FlowDemand, EnabledPistons(0.0, 0.0, 0.0, 0.0), PistonLaw, piston_start)
