"""Relief valve: one law with its three limits, first-order, static and ideal.

Source  ours, docs/models/components.md, where a function names no other.
"""

from vvdp.base.kinds import Flow, Opening, Pressure, PressureDifference, Time
from vvdp.base.modes import side
from vvdp.base.params import Params
from vvdp.base.rules import refuse, require_less, require_positive
from vvdp.base.select import maximum, minimum, select
from vvdp.hydraulics.flow import rated_edge_flow
from vvdp.hydraulics.opening import lagged_rate


class ReliefValve(Params):
    """Opens at the level `cracking_pressure` and passes `rated_flow` at `override_pressure` above it.

    `opening_time` > 0: the opening follows the pressure with that time constant; 0: at once (static).
    `override_pressure` 0: ideal, holds the cracking pressure whatever the flow.
    `reseat_drop` > 0: once open it closes only so far below its cracking pressure.
    """

    cracking_pressure: Pressure
    override_pressure: PressureDifference
    rated_flow: Flow
    opening_time: Time = 0.0
    reseat_drop: PressureDifference = 0.0

    def check(self) -> None:
        require_positive(self, "cracking_pressure")
        require_positive(self, "rated_flow")
        if self.override_pressure <= 0.0 < self.opening_time:
            refuse(self, "opening_time", "must be 0 if override_pressure is 0 (an ideal valve)")
        if self.override_pressure <= 0.0 < self.reseat_drop:
            refuse(self, "reseat_drop", "must be 0 if override_pressure is 0 (an ideal valve)")
        require_less(self, "reseat_drop", "cracking_pressure")


class ShockValve(ReliefValve):
    """A relief valve with an override, which needs to know nothing of its volume but the pressure.

    It opens by up to `largest_opening`, 1 at its rated point. `closing_time` > 0: with an opening time, it closes with
    that time constant.
    """

    largest_opening: Opening = 1e6
    closing_time: Time = 0.0

    def check(self) -> None:
        require_positive(self, "largest_opening")
        if self.override_pressure <= 0.0:
            refuse(self, "override_pressure", "must be greater than 0; an ideal one is of type relief-valve")
        if self.opening_time <= 0.0 < self.closing_time:
            refuse(self, "closing_time", "must be 0 if opening_time is 0 (a valve that follows at once)")


class LoadReliefValve(ShockValve):
    """A relief valve whose setting follows a load pressure: `margin` above it, from `least_pressure` on and up to its
    cracking pressure."""

    margin: PressureDifference
    least_pressure: Pressure


def relief_flow(
    pressure: float, tank_pressure: float, opening: float, surplus_flow: float, mode: float, relief: ReliefValve
) -> float:
    """Volume flow over a relief valve at the pressure it limits [m^3/s].

    Q_r y root(P - P_t) / root(P_cr + override - P_t), y the opening or, for a valve without opening time, its static
    value. Ideal: the whole surplus while it is open.

    pressure       of the volume it protects, absolute [Pa]
    tank_pressure  absolute [Pa]
    opening        y, as a state; read only with an opening time [1]
    surplus_flow   nu sum(q) - dV/dt of that volume without the valve; read only by the ideal one [m^3/s]
    mode           1 while it is open, 0 while it is closed
    """
    throttled = throttled_relief_flow(pressure, tank_pressure, opening, mode, relief)
    flow: float = select(relief.override_pressure > 0.0, throttled, mode * surplus_flow)
    return flow


def relief_flow_compiled(
    pressure: float, tank_pressure: float, opening: float, surplus_flow: float, mode: float, relief: ReliefValve
) -> float:
    """The same as `relief_flow`, which it replaces in compiled code: only the law that counts is calculated.

    Arguments as there.
    """
    if relief.override_pressure > 0.0:
        return throttled_relief_flow(pressure, tank_pressure, opening, mode, relief)
    return mode * surplus_flow


def throttled_relief_flow(
    pressure: float, tank_pressure: float, opening: float, mode: float, relief: ReliefValve
) -> float:
    """Volume flow over a relief valve with an override [m^3/s]; see `relief_flow`.

    pressure, tank_pressure  absolute [Pa]
    opening                  y, as a state; read only with an opening time [1]
    mode                     1 while it is open, 0 while it is closed
    """
    y = select(relief.opening_time > 0.0, opening, relief_opening(pressure, mode, relief))
    return opened_relief_flow(pressure - tank_pressure, tank_pressure, y, relief)


def opened_relief_flow(pressure_drop: float, tank_pressure: float, opening: float, relief: ReliefValve) -> float:
    """Volume flow over a relief valve that is open by `opening` [1] at a `pressure_drop` [Pa], in m^3/s.

    tank_pressure  absolute [Pa]
    """
    design_drop = relief.cracking_pressure + relief.override_pressure - tank_pressure
    # A tank above the setting is a contradiction that only a run can see: stay finite there
    design_drop = select(design_drop > 0.0, design_drop, relief.cracking_pressure)
    return rated_edge_flow(relief.rated_flow, opening, pressure_drop, design_drop)


def setting_fall(load_pressure: float, relief: LoadReliefValve) -> float:
    """Reduction of the setting of a relief valve that follows a load, from its cracking pressure [Pa].

    max(P_cr - max(P_load + margin, P_least), 0): with it on top of the pressure that it limits, it is a plain one.

    load_pressure  absolute [Pa]
    """
    wanted = maximum(load_pressure + relief.margin, relief.least_pressure)
    fall: float = maximum(relief.cracking_pressure - wanted, 0.0)
    return fall


def relief_opening(pressure: float, mode: float, relief: ReliefValve) -> float:
    """Static opening of a relief valve [1]: (P - P_re)/(P_cr + override - P_re) while it is open, else 0.

    P_re is where it closes; at the rated point the opening is 1, and it is not bounded there.

    pressure  absolute [Pa]
    mode      1 while it is open, 0 while it is closed
    """
    span = relief.override_pressure + relief.reseat_drop
    above = pressure - (relief.cracking_pressure - relief.reseat_drop)
    return mode * above / select(span > 0.0, span, relief.cracking_pressure)


def relief_mode(pressure: float, tank_pressure: float, surplus_flow: float, mode: float, relief: ReliefValve) -> float:
    """Whether a relief valve is open: a mode, 1 or more where it is, see `base.modes.side`.

    It opens at its cracking pressure and closes at its reseat pressure; an ideal one opens there with the surplus that
    it will pass, and closes where that ends, or where the other side is under the higher pressure.

    pressure, tank_pressure, surplus_flow, mode  as in `relief_flow`
    """
    crack, surplus = relief.cracking_pressure, surplus_flow / relief.rated_flow
    per_crack = 1.0 / crack
    passing = minimum(surplus, (pressure - tank_pressure) * per_crack)
    ideal = select(mode > 0.5, passing, minimum(passing, (pressure - crack) * per_crack))
    closes_at = crack - mode * relief.reseat_drop
    return side(select(relief.override_pressure > 0.0, (pressure - closes_at) * per_crack, ideal))


def relief_opening_rate(pressure: float, opening: float, mode: float, relief: ReliefValve) -> float:
    """Rate of the opening of a relief valve [1/s]: (y_static(P) - y)/tau, and 0 without an opening time.

    pressure  absolute [Pa]
    opening   y [1]
    mode      1 while it is open, 0 while it is closed
    """
    return lagged_rate(relief_opening(pressure, mode, relief), opening, relief.opening_time)


def relief_opening_rate_compiled(pressure: float, opening: float, mode: float, relief: ReliefValve) -> float:
    """The same as `relief_opening_rate`, which it replaces in compiled code: none without an opening time.

    Arguments as there.
    """
    if relief.opening_time == 0.0:
        return 0.0
    return (relief_opening(pressure, mode, relief) - opening) / relief.opening_time
