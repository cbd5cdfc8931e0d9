"""Pressure-reducing valve: closes as the pressure behind it rises; it does not relieve that pressure.

Source  ours, docs/models/components.md, where a function names no other.
"""

from vvdp.base.kinds import Flow, Pressure, PressureDifference, Time
from vvdp.base.modes import between
from vvdp.base.params import Params
from vvdp.base.rules import require_less, require_positive
from vvdp.base.select import clip
from vvdp.hydraulics.opening import lagged_rate


class ReducingValve(Params):
    """Is closed from the outlet level `closing_pressure` on and fully open `override_pressure` below it.

    Fully open it passes `rated_flow` at `rated_drop`. `opening_time` > 0: the opening follows the outlet's pressure
    with that time constant; 0: at once.
    """

    closing_pressure: Pressure
    override_pressure: PressureDifference
    rated_flow: Flow
    rated_drop: PressureDifference
    opening_time: Time

    def check(self) -> None:
        require_positive(self, "override_pressure", "rated_flow", "rated_drop")
        require_less(self, "override_pressure", "closing_pressure")


def reducing_opening(outlet_pressure: float, valve: ReducingValve) -> float:
    """Static opening of a reducing valve [1]: (P_close - P)/override, between 0 and 1.

    outlet_pressure  P, absolute [Pa]
    """
    opening: float = clip((valve.closing_pressure - outlet_pressure) / valve.override_pressure, 0.0, 1.0)
    return opening


def reducing_side(outlet_pressure: float, valve: ReducingValve) -> float:
    """Whether a reducing valve is closed, in between or fully open [1], see `base.modes.between`.

    outlet_pressure  P, absolute [Pa]
    """
    return between((valve.closing_pressure - outlet_pressure) / valve.override_pressure)


def reducing_opening_rate(outlet_pressure: float, opening: float, valve: ReducingValve) -> float:
    """Rate of the opening of a reducing valve [1/s]: (y_static(P) - y)/tau, and 0 without an opening time.

    outlet_pressure  P, absolute [Pa]
    opening          y [1]
    """
    return lagged_rate(reducing_opening(outlet_pressure, valve), opening, valve.opening_time)
