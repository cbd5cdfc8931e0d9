"""Shuttle valve: the higher of two pressures moves its ball aside, and reaches the port between.

Source  ours, docs/models/components.md, where a function names no other.
"""

from vvdp.base.kinds import Flow, PressureDifference
from vvdp.base.modes import between
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.base.select import clip


class ShuttleValve(Params):
    """Its ball changes seats while the pressures at both ends differ by less than `changeover_pressure`.

    With the ball on the other seat an end passes `rated_flow` at `rated_drop`.
    """

    changeover_pressure: PressureDifference
    rated_flow: Flow
    rated_drop: PressureDifference

    def check(self) -> None:
        require_positive(self, "changeover_pressure", "rated_flow", "rated_drop")


def ball_share(pressure_difference: float, shuttle: ShuttleValve) -> float:
    """Position of the ball, before it is held between its seats [1]: 0 closes port a, 1 closes port b.

    1/2 + (P_a - P_b)/(2 dP_c)

    pressure_difference  P_a - P_b [Pa]
    """
    return 0.5 + 0.5 * pressure_difference / shuttle.changeover_pressure


def ball_position(pressure_difference: float, shuttle: ShuttleValve) -> float:
    """Position of the ball [1]: 0 on the seat of port a, 1 on that of port b.

    pressure_difference  P_a - P_b [Pa]

    >>> shuttle = ShuttleValve(changeover_pressure=1e5, rated_flow=1e-4, rated_drop=2e5)
    >>> ball_position(5e4, shuttle), ball_position(-3e5, shuttle)
    (0.75, 0.0)
    """
    position: float = clip(ball_share(pressure_difference, shuttle), 0.0, 1.0)
    return position


def ball_side(pressure_difference: float, shuttle: ShuttleValve) -> float:
    """Whether the ball is on a seat or between [1]; see `base.modes.between`.

    pressure_difference  P_a - P_b [Pa]
    """
    return between(ball_share(pressure_difference, shuttle))
