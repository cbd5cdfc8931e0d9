"""Control of a variable pump that holds a pressure: a fixed one, or a margin above the highest load.

Source  ours, docs/models/components.md, where a function names no other.
"""

from typing import NamedTuple

from vvdp.base.errors import ParameterError
from vvdp.base.kinds import Fraction, Pressure, PressureDifference, Time
from vvdp.base.modes import between
from vvdp.base.params import Params
from vvdp.base.select import clip, maximum, minimum


class PumpControl(Params):
    """A shortfall of the pressure by `proportional_band` swivels the pump from rest to its full displacement at once.

    What is missing is made up with the time constant `reset_time`, so that nothing is missing in the end.
    """

    proportional_band: PressureDifference
    reset_time: Time

    def check(self) -> None:
        name = type(self).__name__
        if self.proportional_band <= 0.0:
            raise ParameterError(f"{name}.proportional_band: 0 Pa; expected a pressure above zero")
        if self.reset_time <= 0.0:
            raise ParameterError(f"{name}.reset_time: 0 s; expected a time above zero")


class PressureControl(PumpControl):
    """Holds the level `held_pressure`, whatever the load."""

    held_pressure: Pressure


class LoadSensingControl(PumpControl):
    """Holds `margin` above the highest load, up to the level `highest_pressure`."""

    margin: PressureDifference
    highest_pressure: Pressure


class SwivelState(NamedTuple):
    """Share of its displacement to which a control has brought a pump without what is missing now."""

    swivel: Fraction


def load_sensing_level(
    control: LoadSensingControl, load_pressure: float, second_pressure: float, third_pressure: float
) -> float:
    """The level that a load-sensing pump is to hold [Pa]: min(max(P_1, P_2, P_3) + margin, P_highest).

    load_pressure, second_pressure, third_pressure  of the loads that it feels, one of them again where there are fewer,
                                                    absolute [Pa]
    """
    highest = maximum(maximum(load_pressure, second_pressure), third_pressure)
    level: float = minimum(highest + control.margin, control.highest_pressure)
    return level


def held_level(control: PressureControl) -> float:
    """The level that a pressure-compensated pump is to hold [Pa]."""
    return control.held_pressure


def wanted_swivel(shortfall: float, swivel: float, control: PumpControl) -> float:
    """Share of a pump's displacement that its control asks for [1], not bounded: s + (P_set - P)/band.

    shortfall  P_set - P [Pa]
    swivel     s, the control's state [1]
    """
    return swivel + shortfall / control.proportional_band


def swivel_share(shortfall: float, swivel: float, control: PumpControl) -> float:
    """Share of its displacement to which a pump is swivelled [1], from 0 to 1.

    shortfall  P_set - P [Pa]
    swivel     s, the control's state [1]

    >>> control = PumpControl(proportional_band=1e7, reset_time=0.01)
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
