"""Two-way seat valve that is opened and closed by a command: unloading and dump valves.

Source  ours, docs/models/components.md, where a function names no other.
"""

from vvdp.base.kinds import Flow, PressureDifference, Time
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.base.select import clip
from vvdp.hydraulics.flow import rated_edge_flow


class SeatValve(Params):
    """Passes `rated_flow` at `rated_drop` when open; `lag` is the time constant of its opening."""

    rated_flow: Flow
    rated_drop: PressureDifference
    lag: Time

    def check(self) -> None:
        require_positive(self, "rated_flow", "rated_drop", "lag")


def seat_flow(pressure_drop: float, opening: float, valve: SeatValve) -> float:
    """Volume flow of a seat valve [m^3/s], either way: Q_r y root(dp)/root(rated drop).

    pressure_drop  first-named side less the second [Pa]
    opening        y, held between 0 and 1 [1]
    """
    y: float = clip(opening, 0.0, 1.0)
    return rated_edge_flow(valve.rated_flow, y, pressure_drop, valve.rated_drop)


def seat_rate(wanted_opening: float, opening: float, valve: SeatValve) -> float:
    """Rate of the opening of a seat valve [1/s]: (y_c - y)/lag, the commanded opening y_c held between 0 and 1.

    wanted_opening  [1]
    opening         y, now [1]
    """
    wanted: float = clip(wanted_opening, 0.0, 1.0)
    return (wanted - opening) / valve.lag
