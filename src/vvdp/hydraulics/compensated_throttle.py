"""Metering throttle behind its own pressure compensator, which holds the drop over it whatever the supply.

Source  ours, docs/models/components.md, where a function names no other.
"""

from vvdp.base.kinds import FlowCoefficient, PressureDifference, Time
from vvdp.base.modes import between
from vvdp.base.params import Params
from vvdp.base.rules import field_text, refuse, require_positive
from vvdp.base.select import clip
from vvdp.hydraulics.series import first_share


class CompensatedThrottle(Params):
    """Conductances fully open, of the throttle and of the compensator before it.

    The compensator is closed from the drop `metering_drop` over the throttle on, and fully open `override_pressure`
    below it; it follows with the time constant `opening_time`. The flow turns linear in the drop over both below about
    `transition_pressure`.
    """

    conductance: FlowCoefficient
    compensator_conductance: FlowCoefficient
    metering_drop: PressureDifference
    override_pressure: PressureDifference
    transition_pressure: PressureDifference
    opening_time: Time

    def check(self) -> None:
        require_positive(
            self, "conductance", "compensator_conductance", "transition_pressure", "opening_time", "override_pressure"
        )
        if not self.override_pressure <= self.metering_drop:
            refuse(self, "override_pressure", f"must be at most metering_drop, {field_text(self, 'metering_drop')}")


def metering_share(opening: float, compensator_opening: float, valve: CompensatedThrottle) -> float:
    """Share of the whole drop that lies over the throttle, not over its compensator [1].

    opening              of the throttle [1]
    compensator_opening  [1]
    """
    first = valve.compensator_conductance * compensator_opening
    return 1.0 - first_share(first, valve.conductance * opening)


def compensator_lift(drop: float, valve: CompensatedThrottle) -> float:
    """Opening of a compensator, not bounded [1]: (dP_m - dP)/override.

    drop  dP over its throttle [Pa]
    """
    return (valve.metering_drop - drop) / valve.override_pressure


def compensator_side(drop: float, valve: CompensatedThrottle) -> float:
    """Whether a compensator is to be closed, in between or fully open [1], see `base.modes.between`.

    drop  over its throttle [Pa]
    """
    return between(compensator_lift(drop, valve))


def compensator_rate(drop: float, compensator_opening: float, valve: CompensatedThrottle) -> float:
    """Rate of the opening of a compensator [1/s]: (clip((dP_m - dP)/override, 0, 1) - y)/tau.

    drop                 dP over its throttle [Pa]
    compensator_opening  y [1]
    """
    static = clip(compensator_lift(drop, valve), 0.0, 1.0)
    rate: float = (static - compensator_opening) / valve.opening_time
    return rate


def flow_opening(valve: CompensatedThrottle, flow: float) -> float:
    """Opening of a compensated throttle for a flow [1]: Q/(K root(dP_m)).

    flow  [m^3/s]

    >>> section = CompensatedThrottle(
    ...     conductance=1e-6,
    ...     compensator_conductance=1e-6,
    ...     metering_drop=1e6,
    ...     override_pressure=2e5,
    ...     transition_pressure=1e4,
    ...     opening_time=5e-3,
    ... )
    >>> flow_opening(section, 2e-4)
    0.2
    """
    opening: float = flow / (valve.conductance * valve.metering_drop**0.5)
    return opening
