"""Sequence, counterbalance and brake valves: a poppet that a pressure opens, and a check valve beside it.

Source  ours, docs/models/components.md, where a function names no other.
"""

from vvdp.base.kinds import PressureDifference, Ratio
from vvdp.base.modes import between
from vvdp.base.rules import require_positive
from vvdp.base.select import clip
from vvdp.hydraulics.balanced_valve import BalancedValve
from vvdp.hydraulics.flow import rated_root


class SequenceValve(BalancedValve):
    """A valve that opens one way, and the other way a check valve.

    That leaves its seat at `reverse_cracking_pressure` and is fully open `reverse_override_pressure` above it, where it
    passes the same flow.
    """

    reverse_cracking_pressure: PressureDifference
    reverse_override_pressure: PressureDifference

    def check(self) -> None:
        require_positive(self, "reverse_override_pressure")


class CounterbalanceValve(SequenceValve):
    """A valve that holds a load until a pilot opens it, whose area is `pilot_ratio` times that of the seat."""

    pilot_ratio: Ratio


def pilot_aid(pilot_difference: float, valve: CounterbalanceValve) -> float:
    """Pressure of the pilot that adds to the drop that opens a counterbalance valve [Pa]: R (P_x - P_b).

    On the poppet act A_s P_a + A_x P_x against (A_s + A_x) P_b and the spring, R = A_x/A_s. So a pressure behind the
    valve raises what opens it by 1 + R of it.

    pilot_difference  P_x - P_b, pilot less outlet [Pa]
    """
    return valve.pilot_ratio * pilot_difference


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


def reverse_side(pressure_drop: float, valve: SequenceValve) -> float:
    """Whether the check valve is closed, in between or fully open [1]; see `base.modes.between`.

    pressure_drop  inlet less outlet [Pa]
    """
    return between(reverse_share(pressure_drop, valve))
