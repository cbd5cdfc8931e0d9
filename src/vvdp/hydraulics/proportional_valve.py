"""Proportional throttle valve: its opening follows a command with a lag."""

from vvdp.base.kinds import Conductance, FlowCoefficient, PressureDifference, Time
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.base.select import clip
from vvdp.hydraulics.flow import root_edge_flow


class ProportionalValve(Params):
    """A valve with one controlled edge: `conductance` fully open, `leakage_conductance` at any opening.

    The flow turns linear in the drop below about `transition_pressure`; `lag` is the time constant of the opening.
    """

    conductance: FlowCoefficient
    leakage_conductance: Conductance
    transition_pressure: PressureDifference
    lag: Time

    def check(self) -> None:
        require_positive(self, "transition_pressure", "lag")


def opening_rate(command: float, opening: float, valve: ProportionalValve) -> float:
    """Rate of the opening of a proportional valve [1/s]: (command - opening)/lag, the command held between 0 and 1.

    command  commanded opening [1]
    opening  now [1]

    Source  ours, docs/models/components.md
    """
    wanted: float = clip(command, 0.0, 1.0)
    return (wanted - opening) / valve.lag


def proportional_flow(pressure_drop: float, opening: float, valve: ProportionalValve) -> float:
    """Volume flow of a proportional valve [m^3/s]: K u root(dp) + G dp, signed like the drop.

    pressure_drop  dp, first-named side less the second [Pa]
    opening        u; below 0 it counts as closed [1]

    Source  wang2017, ch. 6 (return valve); leakage and transition: ours, docs/models/components.md
    """
    u: float = clip(opening, 0.0, 1.0)
    throttled = root_edge_flow(valve.conductance, u, pressure_drop, valve.transition_pressure)
    return throttled + valve.leakage_conductance * pressure_drop
