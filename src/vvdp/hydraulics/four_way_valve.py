"""Proportional directional valves whose edges have laps of their own: four, and a bypass that is open in the middle.

Source  ours, docs/models/components.md, where a function names no other.
"""

from typing import NamedTuple

from vvdp.base.kinds import FlowCoefficient, Fraction, Kink, PressureDifference, SignedFraction
from vvdp.base.modes import between
from vvdp.base.rules import field_text, refuse, require_positive
from vvdp.base.select import clip, select
from vvdp.hydraulics.proportional_spool import ProportionalSpool

EDGES = ("overlap_pa", "overlap_pb", "overlap_at", "overlap_bt")


class LappedValve(ProportionalSpool):
    """`conductance` of each edge fully open; laps are shares of the stroke, negative ones are underlaps.

    Edges pa and bt open forward, pb and at backward. All laps positive: closed centre; those of at and bt negative:
    float; of pa and pb: regenerative; all negative: open. What is open in the middle alone, a bypass, is closed from
    `bypass_travel` of the stroke on either way.
    """

    conductance: FlowCoefficient
    overlap_pa: SignedFraction
    overlap_pb: SignedFraction
    overlap_at: SignedFraction
    overlap_bt: SignedFraction
    transition_pressure: PressureDifference
    bypass_travel: Fraction = 1.0

    def check(self) -> None:
        for name in EDGES:
            if abs(getattr(self, name)) >= 1.0:
                refuse(self, name, f"must lie between -1 and 1, not at {field_text(self, name)}")
        require_positive(self, "conductance", "transition_pressure", "bypass_travel")


class FourWayValve(LappedValve):
    """A valve whose bypass of `bypass_conductance`, from pump to tank, makes a closed centre a tandem one."""

    bypass_conductance: FlowCoefficient = 0.0


class SixWayValve(LappedValve):
    """A valve with a bypass of `bypass_conductance` between ports of its own."""

    bypass_conductance: FlowCoefficient

    def check(self) -> None:
        require_positive(self, "bypass_conductance")


class SensingValve(FourWayValve):
    """A valve with a port for the pressure of the load.

    A passage of `sensing_conductance` joins that port in the middle with the tank, and from `bypass_travel` on with the
    side that the pump feeds.
    """

    sensing_conductance: FlowCoefficient

    def check(self) -> None:
        require_positive(self, "sensing_conductance")


class Edges(NamedTuple):
    """Openings of the four edges and of the bypass."""

    pa: Fraction
    pb: Fraction
    at: Fraction
    bt: Fraction
    bypass: Fraction


class EdgeStands(NamedTuple):
    """Whether each edge is closed, in between or fully open; `base.modes.between`."""

    pa: Kink
    pb: Kink
    at: Kink
    bt: Kink
    bypass: Kink


class SensingOpenings(NamedTuple):
    """Openings of a load-sensing port to both loads and to the tank."""

    a: Fraction
    b: Fraction
    tank: Fraction


class EdgeDrops(NamedTuple):
    """Drop over each of the four edges, in the direction of its name."""

    pa: PressureDifference
    pb: PressureDifference
    at: PressureDifference
    bt: PressureDifference


def _travels(position: float, valve: LappedValve) -> Edges:
    """Opening of each edge, before it is held between 0 and 1: (y - lap)/(1 - lap), y towards its side [1]."""
    x = position
    return Edges(
        pa=(x - valve.overlap_pa) / (1.0 - valve.overlap_pa),
        pb=(-x - valve.overlap_pb) / (1.0 - valve.overlap_pb),
        at=(-x - valve.overlap_at) / (1.0 - valve.overlap_at),
        bt=(x - valve.overlap_bt) / (1.0 - valve.overlap_bt),
        bypass=1.0 - abs(x) / valve.bypass_travel,
    )


def four_edges(position: float, valve: LappedValve) -> Edges:
    """Openings of the four edges [1]: (y - lap)/(1 - lap) between 0 and 1, y the position towards the edge's side.

    That of the bypass is 1 - |x|/x_b.

    position  x, from -1 to 1 [1]
    """
    travel = _travels(position, valve)
    return Edges(
        clip(travel.pa, 0.0, 1.0),
        clip(travel.pb, 0.0, 1.0),
        clip(travel.at, 0.0, 1.0),
        clip(travel.bt, 0.0, 1.0),
        clip(travel.bypass, 0.0, 1.0),
    )


def four_sides(position: float, valve: LappedValve) -> EdgeStands:
    """Whether each edge is closed, in between or fully open [1].

    position  from -1 to 1 [1]
    """
    travel = _travels(position, valve)
    return EdgeStands(
        between(travel.pa), between(travel.pb), between(travel.at), between(travel.bt), between(travel.bypass)
    )


def sensing_openings(position: float, bypass: float) -> SensingOpenings:
    """Openings of a load-sensing port [1]: to the tank as the bypass, to the side of the spool what that leaves.

    position  from -1 to 1 [1]
    bypass    opening of the bypass [1]
    """
    joined = 1.0 - bypass
    return SensingOpenings(select(position > 0.0, joined, 0.0), select(position < 0.0, joined, 0.0), bypass)


def flow_push(edges: Edges, drops: EdgeDrops, valve: LappedValve) -> float:
    """Displacement of a spool back to its middle by flow forces [1]: c (y_pa |dp| + y_bt |dp| - y_pb |dp| - y_at |dp|).

    A jet pushes its edge closed with 0.43 w x dp, w the width of the edge and x its opening; over the stiffness k that
    centres the spool that is c = 0.43 w/k per opening and drop.

    Source  merritt1967, ch. 5 (steady flow force)

    >>> valve = FourWayValve(conductance=1e-7, overlap_pa=0.0, overlap_pb=0.0, overlap_at=0.0, overlap_bt=0.0,
    ...     transition_pressure=1e4, natural_frequency=0.0, response_time=0.02, largest_rate=1e4, flow_yield=2e-9)
    >>> print(flow_push(four_edges(0.5, valve), EdgeDrops(1e7, 1e7, 2e7, 1e7), valve))
    0.02
    """
    forward = edges.pa * abs(drops.pa) + edges.bt * abs(drops.bt)
    backward = edges.pb * abs(drops.pb) + edges.at * abs(drops.at)
    return valve.flow_yield * (forward - backward)
