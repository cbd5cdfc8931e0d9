"""Check valve: opens with the drop in its direction, stays open against it by a given share.

Source  ours, docs/models/components.md, where a function names no other.
"""

from vvdp.base.kinds import Flow, Fraction, PressureDifference, Time
from vvdp.base.modes import between
from vvdp.base.params import Params
from vvdp.base.rules import field_text, refuse, require_positive
from vvdp.base.select import clip, select
from vvdp.hydraulics.flow import rated_edge_flow
from vvdp.hydraulics.opening import lagged_rate


class CheckPoppet(Params):
    """Leaves its seat at `cracking_pressure` and is fully open at `rated_drop`.

    `reverse_opening` is the share that stays open against the direction: 0 tight, 1 none fitted (open both ways).
    `opening_time` > 0: the poppet follows with that time constant; 0: at once.
    """

    cracking_pressure: PressureDifference
    rated_drop: PressureDifference
    reverse_opening: Fraction = 0.0
    opening_time: Time = 0.0

    def check(self) -> None:
        if self.rated_drop <= self.cracking_pressure:
            limit = field_text(self, "cracking_pressure")
            refuse(self, "rated_drop", f"must be greater than cracking_pressure, {limit}")


class CheckValve(CheckPoppet):
    """A check valve with a flow law of its own: it passes `rated_flow` at its rated drop.

    `closing_time` > 0: with an opening time, its poppet closes with that time constant.
    """

    rated_flow: Flow
    closing_time: Time = 0.0

    def check(self) -> None:
        require_positive(self, "rated_flow")
        if self.opening_time <= 0.0 < self.closing_time:
            refuse(self, "closing_time", "must be 0 if opening_time is 0 (a valve that follows at once)")


def check_opening(pressure_drop: float, check: CheckPoppet) -> float:
    """Static opening of a check valve [1], from `reverse_opening` below its cracking pressure to 1 at its rated drop.

    In series with another resistance it multiplies that one's area.

    pressure_drop  in the direction of the valve [Pa]
    """
    lift: float = clip(
        (pressure_drop - check.cracking_pressure) / (check.rated_drop - check.cracking_pressure), 0.0, 1.0
    )
    return check.reverse_opening + (1.0 - check.reverse_opening) * lift


def check_opening_compiled(pressure_drop: float, check: CheckPoppet) -> float:
    """The same as `check_opening`, which it replaces in compiled code: nothing is calculated where no valve is fitted.

    pressure_drop  in the direction of the valve [Pa]
    """
    if check.reverse_opening == 1.0:
        return 1.0
    lift: float = clip(
        (pressure_drop - check.cracking_pressure) / (check.rated_drop - check.cracking_pressure), 0.0, 1.0
    )
    return check.reverse_opening + (1.0 - check.reverse_opening) * lift


def check_side(pressure_drop: float, check: CheckPoppet) -> float:
    """Side of its cracking pressure and of its rated drop on which a check valve stands [1], see `base.modes.between`.

    pressure_drop  in the direction of the valve [Pa]
    """
    lift = (pressure_drop - check.cracking_pressure) / (check.rated_drop - check.cracking_pressure)
    return between(select(check.reverse_opening < 1.0, lift, 0.5))


def check_side_compiled(pressure_drop: float, check: CheckPoppet) -> float:
    """The same as `check_side`, which it replaces in compiled code: nothing is calculated where no valve is fitted.

    pressure_drop  in the direction of the valve [Pa]
    """
    if check.reverse_opening == 1.0:
        return between(0.5)
    return between((pressure_drop - check.cracking_pressure) / (check.rated_drop - check.cracking_pressure))


def check_opening_rate(pressure_drop: float, opening: float, check: CheckPoppet) -> float:
    """Rate of the opening of a check valve [1/s]: (y_static(dp) - y)/tau, and 0 without an opening time.

    pressure_drop  in the direction of the valve [Pa]
    opening        y [1]
    """
    return lagged_rate(check_opening(pressure_drop, check), opening, check.opening_time)


def check_opening_rate_compiled(pressure_drop: float, opening: float, check: CheckPoppet) -> float:
    """The same as `check_opening_rate`, which it replaces in compiled code: none without an opening time.

    pressure_drop  in the direction of the valve [Pa]
    opening        y [1]
    """
    if check.opening_time == 0.0:
        return 0.0
    return (check_opening(pressure_drop, check) - opening) / check.opening_time


def check_flow(pressure_drop: float, check: CheckValve) -> float:
    """Volume flow of a check valve that follows its drop at once [m^3/s].

    pressure_drop  in the direction of the valve [Pa]
    """
    return rated_edge_flow(check.rated_flow, check_opening(pressure_drop, check), pressure_drop, check.rated_drop)
