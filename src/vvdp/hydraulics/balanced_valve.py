"""Valves whose poppet or spool a difference of pressures moves against a spring: compensators, priority, cartridge.

Source  ours, docs/models/components.md, where a function names no other.
"""

from vvdp.base.kinds import Flow, PressureDifference, Ratio, Time
from vvdp.base.modes import between
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.base.select import clip, select
from vvdp.hydraulics.opening import lagged_rate


class BalancedValve(Params):
    """Leaves an end position at the difference `cracking_pressure`, is at the other one `override_pressure` higher.

    Fully open it passes `rated_flow` at `rated_drop`. `opening_time` > 0: it follows with that time constant; 0: at
    once.
    """

    cracking_pressure: PressureDifference
    override_pressure: PressureDifference
    rated_flow: Flow
    rated_drop: PressureDifference
    opening_time: Time = 0.0

    def check(self) -> None:
        require_positive(self, "cracking_pressure", "override_pressure", "rated_flow", "rated_drop")


class CartridgeValve(BalancedValve):
    """A poppet whose ring at port b has `ring_ratio` times the area at port a, and whose back both areas together."""

    ring_ratio: Ratio


def opening_share(lifting: float, valve: BalancedValve) -> float:
    """Static travel of a valve before it is held between 0 and 1 [1]: (lifting - cracking)/override.

    lifting  pressure that moves it, above that behind its spring [Pa]
    """
    return (lifting - valve.cracking_pressure) / valve.override_pressure


def balanced_travel(lifting: float, opening: float, valve: BalancedValve) -> float:
    """Travel of a valve [1]: its state, or without an opening time its static travel.

    lifting  pressure that moves it, above that behind its spring [Pa]
    opening  as a state; read only with an opening time [1]
    """
    travel: float = select(valve.opening_time > 0.0, opening, clip(opening_share(lifting, valve), 0.0, 1.0))
    return travel


def lift_rate(lifting: float, opening: float, valve: BalancedValve) -> float:
    """Rate of the travel [1/s]: (y_static - y)/tau, and 0 without an opening time.

    lifting  pressure that moves it, above that behind its spring [Pa]
    opening  y [1]
    """
    return lagged_rate(clip(opening_share(lifting, valve), 0.0, 1.0), opening, valve.opening_time)


def lift_side(lifting: float, valve: BalancedValve) -> float:
    """Whether a valve without opening time is at an end or in between [1]; see `base.modes.between`.

    lifting  pressure that moves it, above that behind its spring [Pa]
    """
    return between(opening_share(lifting, valve))


def cartridge_lift(pressure: float, ring_pressure: float, pilot_pressure: float, valve: CartridgeValve) -> float:
    """Pressure that lifts a cartridge valve against its spring [Pa]: P_a + r P_b - (1 + r) P_x.

    The forces on the poppet, A_a P_a + A_b P_b against (A_a + A_b) P_x and the spring, over A_a; r = A_b/A_a.

    pressure, ring_pressure, pilot_pressure  at a, at b and behind the poppet, absolute [Pa]
    """
    return pressure + valve.ring_ratio * ring_pressure - (1.0 + valve.ring_ratio) * pilot_pressure
