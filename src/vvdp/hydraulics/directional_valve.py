"""Four-way directional valve with closed centre: pressure to one side of a cylinder, the other side to the return.

Source  ours, docs/models/components.md, where a function names no other.
"""

from typing import NamedTuple

from vvdp.base.kinds import FlowCoefficient, Fraction, Kink, PressureDifference, SignedFraction, Time
from vvdp.base.modes import between
from vvdp.base.params import Params
from vvdp.base.rules import refuse, require_positive
from vvdp.base.select import clip


class DirectionalValve(Params):
    """`conductance` of each edge fully open; `overlap` is the share of the stroke, either way, with all edges closed.

    `lag` is the time constant with which the position, -1 to 1, follows its command.
    """

    conductance: FlowCoefficient
    overlap: Fraction
    transition_pressure: PressureDifference
    lag: Time

    def check(self) -> None:
        if self.overlap >= 1.0:
            refuse(self, "overlap", "must be less than 1: the valve would never open")
        require_positive(self, "transition_pressure", "lag")


class EdgeSides(NamedTuple):
    """Whether the edges are closed, in between or fully open; `base.modes.between`."""

    forward: Kink
    backward: Kink


class DirectionalState(NamedTuple):
    """Position of the spool: 1 forward, -1 backward."""

    position: SignedFraction


class EdgeOpenings(NamedTuple):
    """Openings of the edges: `forward` supply to A and B to return, `backward` supply to B and A to return."""

    forward: Fraction
    backward: Fraction


def position_rate(command: float, position: float, valve: DirectionalValve) -> float:
    """Rate of the position of a directional valve [1/s]: (command - y)/lag, the command held between -1 and 1.

    command   wanted position [1]
    position  y, now [1]
    """
    wanted: float = clip(command, -1.0, 1.0)
    return (wanted - position) / valve.lag


def edge_openings(position: float, valve: DirectionalValve) -> EdgeOpenings:
    """Openings of the forward and backward edges [1]: (|y| - lap)/(1 - lap) on the side of y, 0 inside the overlap.

    position  y, from -1 to 1 [1]
    """
    lap = valve.overlap
    return EdgeOpenings(
        clip((position - lap) / (1.0 - lap), 0.0, 1.0),
        clip((-position - lap) / (1.0 - lap), 0.0, 1.0),
    )


def edge_sides(position: float, valve: DirectionalValve) -> EdgeSides:
    """Whether the forward and the backward edges are closed, in between or fully open [1].

    position  y, from -1 to 1 [1]
    """
    lap = valve.overlap
    return EdgeSides(between((position - lap) / (1.0 - lap)), between((-position - lap) / (1.0 - lap)))
