"""Relief valve: one law with its three limits, first-order, static and ideal."""

from typing import NamedTuple

from vvdp.base.errors import ParameterError
from vvdp.base.kinds import Flow, Pressure, PressureDifference, Ratio, Time
from vvdp.base.params import Params
from vvdp.base.select import maximum, select
from vvdp.hydraulics.flow import rated_root


class ReliefValve(Params):
    """Opens at the level `cracking_pressure` and passes `rated_flow` at `override_pressure` above it.

    `opening_time` > 0: the opening follows the pressure with that time constant; 0: at once (static).
    `override_pressure` 0: ideal, holds the cracking pressure whatever the flow.
    """

    cracking_pressure: Pressure
    override_pressure: PressureDifference
    rated_flow: Flow
    opening_time: Time = 0.0

    def check(self) -> None:
        if self.cracking_pressure <= 0.0:
            raise ParameterError("ReliefValve.cracking_pressure: 0 Pa absolute; expected a level above the tank's")
        if self.rated_flow <= 0.0:
            raise ParameterError(f"ReliefValve.rated_flow: {self.rated_flow:g} m^3/s; expected a flow above zero")
        if self.override_pressure <= 0.0 < self.opening_time:
            raise ParameterError(
                f"ReliefValve: override_pressure 0 (ideal) contradicts opening_time {self.opening_time:g} s; "
                "make the opening time 0 or give an override"
            )


class ShockValve(ReliefValve):
    """A relief valve with an override, which needs to know nothing of its volume but the pressure."""

    def check(self) -> None:
        super().check()
        if self.override_pressure <= 0.0:
            raise ParameterError("ShockValve.override_pressure: 0 Pa; expected one above zero, or take a relief valve")


class ReliefState(NamedTuple):
    """Opening of a relief valve, 1 at its rated point."""

    opening: Ratio


def relief_flow(
    pressure: float, tank_pressure: float, opening: float, surplus_flow: float, relief: ReliefValve
) -> float:
    """Volume flow over a relief valve at the pressure it limits [m^3/s].

    Q_r y root(P - P_t) / root(P_cr + override - P_t), y the opening or, for a valve without opening time, its static
    value. Ideal: the whole surplus, max(surplus, 0), from P_cr on.

    pressure       of the volume it protects, absolute [Pa]
    tank_pressure  absolute [Pa]
    opening        y, as a state; read only with an opening time [1]
    surplus_flow   nu sum(q) - dV/dt of that volume without the valve; read only by the ideal one [m^3/s]

    Source  ours, docs/models/components.md
    """
    throttled = throttled_relief_flow(pressure, tank_pressure, opening, relief)
    flow: float = select(relief.override_pressure > 0.0, throttled, ideal_relief_flow(pressure, surplus_flow, relief))
    return flow


def relief_flow_compiled(
    pressure: float, tank_pressure: float, opening: float, surplus_flow: float, relief: ReliefValve
) -> float:
    """The same as `relief_flow`, which it replaces in compiled code: only the law that counts is worked out.

    Arguments as there.

    Source  ours, docs/models/components.md
    """
    if relief.override_pressure > 0.0:
        return throttled_relief_flow(pressure, tank_pressure, opening, relief)
    return ideal_relief_flow(pressure, surplus_flow, relief)


def throttled_relief_flow(pressure: float, tank_pressure: float, opening: float, relief: ReliefValve) -> float:
    """Volume flow over a relief valve with an override [m^3/s]; see `relief_flow`.

    pressure, tank_pressure  absolute [Pa]
    opening                  y, as a state; read only with an opening time [1]

    Source  ours, docs/models/components.md
    """
    y = select(relief.opening_time > 0.0, opening, relief_opening(pressure, relief))
    design_drop = relief.cracking_pressure + relief.override_pressure - tank_pressure
    # A tank above the setting is a contradiction that only a run can see: stay finite there
    design_drop = select(design_drop > 0.0, design_drop, relief.cracking_pressure)
    flow: float = relief.rated_flow * y * rated_root(pressure - tank_pressure, design_drop)
    return flow


def ideal_relief_flow(pressure: float, surplus_flow: float, relief: ReliefValve) -> float:
    """Volume flow over a relief valve without an override [m^3/s]: the whole surplus from its cracking pressure on.

    pressure      absolute [Pa]
    surplus_flow  what would otherwise raise the pressure [m^3/s]

    Source  ours, docs/models/components.md
    """
    flow: float = select(pressure >= relief.cracking_pressure, maximum(surplus_flow, 0.0), 0.0)
    return flow


def relief_opening(pressure: float, relief: ReliefValve) -> float:
    """Static opening of a relief valve [1]: max(P - P_cr, 0) / override, 1 at its rated point and not bounded there.

    pressure  absolute [Pa]

    Source  ours, docs/models/components.md
    """
    override: float = select(relief.override_pressure > 0.0, relief.override_pressure, relief.cracking_pressure)
    excess: float = maximum(pressure - relief.cracking_pressure, 0.0)
    return excess / override


def relief_opening_rate(pressure: float, opening: float, relief: ReliefValve) -> float:
    """Rate of the opening of a relief valve [1/s]: (y_static(P) - y)/tau, and 0 without an opening time.

    pressure  absolute [Pa]
    opening   y [1]

    Source  ours, docs/models/components.md
    """
    tau = relief.opening_time
    lag = (relief_opening(pressure, relief) - opening) / select(tau > 0.0, tau, 1.0)
    rate: float = select(tau > 0.0, lag, 0.0)
    return rate
