"""Control of a variable pump: it holds a margin above the highest load, or one pressure whatever the load.

Source  ours, docs/models/components.md, where a function names no other.
"""

from typing import NamedTuple

from vvdp.base.kinds import Fraction, Pressure, PressureDifference, Time
from vvdp.base.modes import between
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.base.select import clip, maximum, minimum


class PumpControl(Params):
    """Holds `margin` above the highest load, up to the level `highest_pressure`; with a margin as large as that, the
    highest pressure whatever the load, as a pressure-compensated pump does.

    A shortfall of the pressure by `proportional_band` strokes the pump from rest to its full displacement at once;
    the remaining shortfall vanishes with the time constant `reset_time`, so that none is left in the steady state.
    """

    margin: PressureDifference
    highest_pressure: Pressure
    proportional_band: PressureDifference
    reset_time: Time

    def check(self) -> None:
        require_positive(self, "highest_pressure", "proportional_band", "reset_time")


class SwivelState(NamedTuple):
    """Share of its displacement to which a control has brought a pump, without its proportional part."""

    swivel: Fraction


def held_level(control: PumpControl, load_pressure: float, second_pressure: float, third_pressure: float) -> float:
    """The level that a controlled pump is to hold at its outlet [Pa]: min(max(P_1, P_2, P_3) + margin, P_highest).

    load_pressure, second_pressure, third_pressure  of the loads that it feels, one of them again where there are fewer,
                                                    absolute [Pa]
    """
    highest = maximum(maximum(load_pressure, second_pressure), third_pressure)
    level: float = minimum(highest + control.margin, control.highest_pressure)
    return level


def wanted_swivel(shortfall: float, swivel: float, control: PumpControl) -> float:
    """Share of a pump's displacement that its control demands [1], not bounded: s + (P_set - P)/band.

    shortfall  P_set - P [Pa]
    swivel     s, the control's state [1]
    """
    return swivel + shortfall / control.proportional_band


def swivel_share(shortfall: float, swivel: float, control: PumpControl) -> float:
    """Share of its displacement to which a pump is stroked [1], from 0 to 1.

    shortfall  P_set - P [Pa]
    swivel     s, the control's state [1]

    >>> control = PumpControl(margin=2e6, highest_pressure=2e7, proportional_band=1e7, reset_time=0.01)
    >>> print(round(swivel_share(1e6, 0.25, control), 3), swivel_share(-1e7, 0.25, control))
    0.35 0.0
    """
    share: float = clip(wanted_swivel(shortfall, swivel, control), 0.0, 1.0)
    return share


def swivel_side(shortfall: float, swivel: float, control: PumpControl) -> float:
    """Whether a pump stands at rest, in between, or at its full displacement [1], see `base.modes.between`.

    shortfall  P_set - P [Pa]
    swivel     s, the control's state [1]
    """
    return between(wanted_swivel(shortfall, swivel, control))


def swivel_rate(shortfall: float, swivel: float, control: PumpControl) -> float:
    """Rate of the state of a pump's control [1/s]: (share - s)/T, with the share that it has at this shortfall.

    Between its ends that is (P_set - P)/(band T), so that it rests only where nothing is missing; at an end s goes
    there and stays, and nothing winds up.

    shortfall  P_set - P [Pa]
    swivel     s [1]
    """
    return (swivel_share(shortfall, swivel, control) - swivel) / control.reset_time
