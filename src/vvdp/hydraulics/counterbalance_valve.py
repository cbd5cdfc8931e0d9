"""Poppets that the pressure at their inlet opens against another one: sequence and counterbalance valves.

Source  ours, docs/models/components.md, where a function names no other.
"""

from vvdp.base.kinds import Flow, PressureDifference, Ratio, Time
from vvdp.base.modes import between
from vvdp.base.params import Params, require_positive
from vvdp.base.select import clip, select
from vvdp.hydraulics.flow import rated_root


class SequenceValve(Params):
    """Opens `cracking_pressure` above the pressure behind its spring, fully `override_pressure` higher.

    Fully open it passes `rated_flow` at `rated_drop`. `opening_time` > 0: the poppet follows with that time constant;
    0: at once. Backwards a check valve leaves its seat at `reverse_cracking_pressure` and is fully open
    `reverse_override_pressure` above it, where it passes the same flow.
    """

    cracking_pressure: PressureDifference
    override_pressure: PressureDifference
    rated_flow: Flow
    rated_drop: PressureDifference
    opening_time: Time = 0.0
    reverse_cracking_pressure: PressureDifference
    reverse_override_pressure: PressureDifference

    def check(self) -> None:
        require_positive(self, "cracking_pressure", "override_pressure", "rated_flow", "rated_drop")
        require_positive(self, "reverse_override_pressure")


class CounterbalanceValve(SequenceValve):
    """A valve that holds a load until a pilot opens it, whose area is `pilot_ratio` times that of the seat."""

    pilot_ratio: Ratio


def pilot_aid(pilot_difference: float, valve: CounterbalanceValve) -> float:
    """What a pilot adds to the drop that opens a counterbalance valve [Pa]: R (P_x - P_b).

    On the poppet act A_s P_a + A_x P_x against (A_s + A_x) P_b and the spring, R = A_x/A_s. So a pressure behind the
    valve raises what opens it by 1 + R of it.

    pilot_difference  P_x - P_b, pilot less outlet [Pa]
    """
    return valve.pilot_ratio * pilot_difference


def opening_share(lifting: float, valve: SequenceValve) -> float:
    """Static opening of a valve before it is held between 0 and 1 [1]: (lifting - cracking)/override.

    lifting  pressure that opens it, above that behind its spring [Pa]
    """
    return (lifting - valve.cracking_pressure) / valve.override_pressure


def lift_rate(lifting: float, opening: float, valve: SequenceValve) -> float:
    """Rate of the opening [1/s]: (y_static - y)/tau, and 0 without an opening time.

    lifting  pressure that opens it, above that behind its spring [Pa]
    opening  y [1]
    """
    tau = valve.opening_time
    lag = (clip(opening_share(lifting, valve), 0.0, 1.0) - opening) / select(tau > 0.0, tau, 1.0)
    rate: float = select(tau > 0.0, lag, 0.0)
    return rate


def reverse_share(pressure_drop: float, valve: SequenceValve) -> float:
    """Opening of the check valve before it is held between 0 and 1 [1].

    pressure_drop  inlet less outlet [Pa]
    """
    return (-pressure_drop - valve.reverse_cracking_pressure) / valve.reverse_override_pressure


def two_way_flow(pressure_drop: float, opening: float, valve: SequenceValve) -> float:
    """Volume flow over the poppet and, backwards, over the check valve beside it [m^3/s].

    Q_r (y root(dp)/root(dp_r) + y_c root(dp)/root(dp_c + dp_co)); the check valve opens for dp < 0 alone.

    pressure_drop  dp, inlet less outlet [Pa]
    opening        y of the poppet [1]

    >>> valve = SequenceValve(cracking_pressure=1e7, override_pressure=2e6, rated_flow=1e-3, rated_drop=1e6,
    ...                       reverse_cracking_pressure=5e4, reverse_override_pressure=3.5e5)
    >>> print(round(two_way_flow(1e6, 0.5, valve), 9), round(two_way_flow(-4e5, 0.0, valve), 9))
    0.0005 -0.001
    """
    check = clip(reverse_share(pressure_drop, valve), 0.0, 1.0)
    over_poppet = opening * rated_root(pressure_drop, valve.rated_drop)
    reverse_drop = valve.reverse_cracking_pressure + valve.reverse_override_pressure
    flow: float = valve.rated_flow * (over_poppet + check * rated_root(pressure_drop, reverse_drop))
    return flow


def lift_side(lifting: float, valve: SequenceValve) -> float:
    """Whether a valve without opening time is shut, in between or fully open [1]; see `base.modes.between`.

    lifting  pressure that opens it, above that behind its spring [Pa]
    """
    return between(opening_share(lifting, valve))


def reverse_side(pressure_drop: float, valve: SequenceValve) -> float:
    """Whether the check valve is shut, in between or fully open [1]; see `base.modes.between`.

    pressure_drop  inlet less outlet [Pa]
    """
    return between(reverse_share(pressure_drop, valve))
