"""Pilot-operated check valve: a pilot piston can push its poppet open against its direction, or hold it close.

Source  ours, docs/models/components.md, where a function names no other.
"""

from vvdp.base.kinds import Ratio
from vvdp.base.select import maximum
from vvdp.hydraulics.check_valve import CheckValve


class PilotCheckValve(CheckValve):
    """A check valve whose pilot piston has `pilot_ratio` times the area of the seat."""

    pilot_ratio: Ratio


def lifting_drop(pressure_drop: float, pilot_difference: float, valve: PilotCheckValve) -> float:
    """Drop that lifts the poppet like the drop of a plain check valve [Pa]: dp + R max(P_x - P_a, 0).

    The back of the pilot piston is at the inlet; the piston pushes and does not pull.

    pressure_drop     dp, inlet less outlet [Pa]
    pilot_difference  P_x - P_a, pilot less inlet [Pa]
    """
    push: float = maximum(pilot_difference, 0.0)
    return pressure_drop + valve.pilot_ratio * push


def closing_drop(pressure_drop: float, pilot_difference: float, valve: PilotCheckValve) -> float:
    """Drop that lifts the poppet like the drop of a plain check valve, whose pilot closes it [Pa].

    dp - R max(P_x - P_b, 0): the back of the pilot piston is at the outlet; the piston pushes and does not pull.

    pressure_drop     dp, inlet less outlet [Pa]
    pilot_difference  P_x - P_b, pilot less outlet [Pa]
    """
    push: float = maximum(pilot_difference, 0.0)
    return pressure_drop - valve.pilot_ratio * push
