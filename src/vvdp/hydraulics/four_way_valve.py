"""Four-way proportional valve whose edges have laps of their own and whose spool has a second-order response.

Source  ours, docs/models/components.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.kinds import (
    FlowCoefficient,
    Fraction,
    Frequency,
    Kind,
    Kink,
    PressureDifference,
    Rate,
    Ratio,
    SignedFraction,
)
from vvdp.base.modes import between
from vvdp.base.params import Params, field_text, refuse, require_positive
from vvdp.base.select import clip
from vvdp.hydraulics.flow import signed_root

SPOOL_POSITION = Kind("position of a spool", "1", -2.0, 2.0, "0.5", scale=1e-2)
"""One that is lightly damped overshoots its command, also at either end."""
SPOOL_RATE = Kind("rate of a spool", "1/s", -1e6, 1e6, "20 1/s")
EDGES = ("overlap_pa", "overlap_pb", "overlap_at", "overlap_bt")


class FourWayValve(Params):
    """`conductance` of each edge fully open; laps are shares of the stroke, negative ones are underlaps.

    Edges pa and bt open forward, pb and at backward. All laps positive: closed centre; those of at and bt negative:
    float; all negative: open. The position, -1 to 1, follows its command as a system of `natural_frequency` and
    `damping_ratio`, never faster than `largest_rate` strokes per second.
    """

    conductance: FlowCoefficient
    overlap_pa: SignedFraction
    overlap_pb: SignedFraction
    overlap_at: SignedFraction
    overlap_bt: SignedFraction
    transition_pressure: PressureDifference
    natural_frequency: Frequency
    damping_ratio: Ratio = 0.7
    largest_rate: Rate

    def check(self) -> None:
        for name in EDGES:
            if abs(getattr(self, name)) >= 1.0:
                refuse(self, name, f"must lie between -1 and 1, not at {field_text(self, name)}")
        require_positive(self, "conductance", "transition_pressure", "natural_frequency", "damping_ratio")
        require_positive(self, "largest_rate")


class ValveSpool(NamedTuple):
    """Position of a spool, 1 forward and -1 backward, and what its drive asks of its rate, in strokes per second."""

    position: Annotated[float, SPOOL_POSITION]
    wanted_rate: Annotated[float, SPOOL_RATE]


class Edges(NamedTuple):
    """Openings of the four edges."""

    pa: Fraction
    pb: Fraction
    at: Fraction
    bt: Fraction


class EdgeStands(NamedTuple):
    """Whether each edge is shut, in between or fully open; `base.modes.between`."""

    pa: Kink
    pb: Kink
    at: Kink
    bt: Kink


def spool_motion(command: float, spool: ValveSpool, valve: FourWayValve) -> ValveSpool:
    """Rates of a spool's position [1/s] and of the rate that its drive asks for [1/s^2].

    x' = clip(v, +-r), v' = omega^2 (u - x) - 2 zeta omega v: below the largest rate r a second-order system; at it v
    is held there, and does not wind up.

    command  u, held between -1 and 1 [1]
    """
    omega, zeta, r = 2.0 * np.pi * valve.natural_frequency, valve.damping_ratio, valve.largest_rate
    v = clip(spool.wanted_rate, -r, r)
    wanted = clip(command, -1.0, 1.0)
    acceleration = omega * omega * (wanted - spool.position) - 2.0 * zeta * omega * v
    beyond = spool.wanted_rate - v
    return ValveSpool(v, acceleration - omega * beyond)


def rate_side(spool: ValveSpool, valve: FourWayValve) -> float:
    """Whether a spool moves at its largest rate, either way, or below it [1]; see `base.modes.between`."""
    return between(0.5 + 0.5 * spool.wanted_rate / valve.largest_rate)


def _travels(position: float, valve: FourWayValve) -> Edges:
    """How far each edge is open, before it is held between 0 and 1: (y - lap)/(1 - lap), y towards its side [1]."""
    x = position
    return Edges(
        pa=(x - valve.overlap_pa) / (1.0 - valve.overlap_pa),
        pb=(-x - valve.overlap_pb) / (1.0 - valve.overlap_pb),
        at=(-x - valve.overlap_at) / (1.0 - valve.overlap_at),
        bt=(x - valve.overlap_bt) / (1.0 - valve.overlap_bt),
    )


def four_edges(position: float, valve: FourWayValve) -> Edges:
    """Openings of the four edges [1]: (y - lap)/(1 - lap) between 0 and 1, y the position towards the edge's side.

    position  from -1 to 1 [1]
    """
    travel = _travels(position, valve)
    return Edges(
        clip(travel.pa, 0.0, 1.0), clip(travel.pb, 0.0, 1.0), clip(travel.at, 0.0, 1.0), clip(travel.bt, 0.0, 1.0)
    )


def four_sides(position: float, valve: FourWayValve) -> EdgeStands:
    """Whether each edge is shut, in between or fully open [1].

    position  from -1 to 1 [1]
    """
    travel = _travels(position, valve)
    return EdgeStands(between(travel.pa), between(travel.pb), between(travel.at), between(travel.bt))


def four_way_flow(pressure_drop: float, opening: float, valve: FourWayValve) -> float:
    """Volume flow over one edge [m^3/s]: K y root(dp), signed like the drop.

    pressure_drop  first-named side less the second [Pa]
    opening        of the edge, 0 to 1 [1]
    """
    return valve.conductance * opening * signed_root(pressure_drop, valve.transition_pressure)
