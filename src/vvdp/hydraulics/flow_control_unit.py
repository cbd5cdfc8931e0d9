"""Digital flow control unit: on/off valves in parallel, of which a code opens some.

Source  ours, docs/when-switching-pays.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import Count, Flow, Fraction, PressureDifference, Time
from vvdp.base.params import Params
from vvdp.base.rules import refuse, require_positive
from vvdp.base.select import clip, select
from vvdp.hydraulics.flow import rated_edge_flow

NEAR = 0.02
"""Share of its travel on which a poppet comes to rest."""


class OnOffValve(Params):
    """A valve that is open or closed: it passes `rated_flow` at `rated_drop`.

    Its poppet travels from end to end in `opening_time` or `closing_time` after a command; `dead_travel` of that at
    either end does not change the flow. So half the flow is there, or gone, after half the time.
    """

    rated_flow: Flow
    rated_drop: PressureDifference
    opening_time: Time
    closing_time: Time
    dead_travel: Fraction = 0.25

    def check(self) -> None:
        require_positive(self, "rated_flow", "rated_drop", "opening_time", "closing_time")
        if not NEAR <= self.dead_travel < 0.5:
            refuse(self, "dead_travel", f"must be at least {NEAR:g} and less than 0.5")

    @property
    def conductance(self) -> float:
        """K = Q/root(P) of the open valve [m^3/(s Pa^0.5)]."""
        return self.rated_flow / float(np.sqrt(self.rated_drop))


class UnitValve(OnOffValve):
    """An on/off valve of a unit: open while the unit's code, counted modulo `modulus`, is `weight` or more."""

    weight: Count
    modulus: Count

    def check(self) -> None:
        if not 1.0 <= self.weight < self.modulus:
            refuse(self, "weight", f"must be at least 1 and less than modulus, {self.modulus:g}")


class PoppetState(NamedTuple):
    """Travel of a poppet, 0 closed and 1 open."""

    travel: Fraction


def binary_valves(count: int, smallest: OnOffValve) -> tuple[UnitValve, ...]:
    """The valves of a unit whose sizes double from the smallest on: 2^N codes, as many flows.

    count  N

    Source  wang2017, section 1.2.1
    """
    sizes = [2**place for place in range(count)]
    return tuple(_unit_valve(smallest, size, weight=size, modulus=2 * size) for size in sizes)


def equal_valves(count: int, smallest: OnOffValve) -> tuple[UnitValve, ...]:
    """The valves of a unit of one size: N + 1 codes, each the number of valves that are open.

    count  N
    """
    return tuple(_unit_valve(smallest, 1, weight=place, modulus=count + 1) for place in range(1, count + 1))


def _unit_valve(valve: OnOffValve, size: int, weight: int, modulus: int) -> UnitValve:
    return UnitValve(
        rated_flow=size * valve.rated_flow,
        rated_drop=valve.rated_drop,
        opening_time=valve.opening_time,
        closing_time=valve.closing_time,
        dead_travel=valve.dead_travel,
        weight=float(weight),
        modulus=float(modulus),
    )


class FlowControlUnit(OnOffValve):
    """A unit of `valves` on/off valves: the values are those of the smallest.

    Sizes double from valve to valve; where `equal_sizes` is 1, all are as large as the smallest.
    """

    valves: Count
    equal_sizes: Fraction = 0.0

    def check(self) -> None:
        if self.valves < 1.0 or self.valves != round(self.valves):
            refuse(self, "valves", "must be a whole number of at least 1")
        if self.equal_sizes not in (0.0, 1.0):
            refuse(self, "equal_sizes", "must be 0 or 1")

    @property
    def parts(self) -> tuple[UnitValve, ...]:
        """Its valves, the smallest first."""
        return (equal_valves if self.equal_sizes else binary_valves)(int(self.valves), self)


def code_count(valves: tuple[UnitValve, ...]) -> int:
    """Number of codes of a unit, from 0 on: 2^N of binary sizes, N + 1 of equal ones."""
    return int(max(valve.modulus for valve in valves))


def code_flow(code: float, pressure_drop: float, valves: tuple[UnitValve, ...]) -> float:
    """Flow of a unit at rest [m^3/s]: that of all its valves that are open.

    code           whole number
    pressure_drop  [Pa]
    """
    return sum(valve_command(code, valve) * poppet_flow(pressure_drop, 1.0, valve) for valve in valves)


def pulse_volume(before: float, after: float, pressure_drop: float, valves: tuple[UnitValve, ...]) -> float:
    """Volume that a unit passes too much, below 0 too little, when its code changes [m^3].

    Against the flow that changes at once: a valve that opens misses Q t_o/2, one that closes adds Q t_c/2.

    before, after  codes
    pressure_drop  held [Pa]
    """
    volume = 0.0
    for valve in valves:
        change = valve_command(after, valve) - valve_command(before, valve)
        lag = 0.5 * (valve.opening_time if change > 0.0 else valve.closing_time)
        volume -= change * lag * poppet_flow(pressure_drop, 1.0, valve)
    return volume


def valve_command(code: float, valve: UnitValve) -> float:
    """Whether a code opens a valve of its unit [1].

    code  whole number from 0 on
    """
    place = code - valve.modulus * np.floor(code / valve.modulus)
    command: float = select(place > valve.weight - 0.5, 1.0, 0.0)
    return command


def poppet_rate(command: float, travel: float, valve: OnOffValve) -> float:
    """Rate of a poppet's travel [1/s]: to its other end in the opening or closing time, where it comes to rest.

    command  1 open, 0 closed
    travel   now [1]
    """
    time = select(command > 0.5, valve.opening_time, valve.closing_time)
    rate: float = clip((command - travel) * (1.0 / NEAR), -1.0, 1.0) / time
    return rate


def poppet_opening(travel: float, valve: OnOffValve) -> float:
    """Travel minus the dead travel, over the effective travel [1]: below 0 closed, above 1 fully open.

    travel  [1]
    """
    return (travel - valve.dead_travel) / (1.0 - 2.0 * valve.dead_travel)


def poppet_flow(pressure_drop: float, travel: float, valve: OnOffValve) -> float:
    """Volume flow of an on/off valve [m^3/s], either way.

    pressure_drop  first-named side less the second [Pa]
    travel         [1]
    """
    opening = clip(poppet_opening(travel, valve), 0.0, 1.0)
    return rated_edge_flow(valve.rated_flow, opening, pressure_drop, valve.rated_drop)
