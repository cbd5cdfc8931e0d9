"""Two-way flow control valve: a compensator holds the drop over a metering orifice, and so its flow.

Source  ours, docs/models/components.md, where a function names no other.
"""

from vvdp.base.kinds import Flow, Fraction, PressureDifference
from vvdp.base.modes import between
from vvdp.base.params import Params
from vvdp.base.rules import require_less, require_positive
from vvdp.base.select import clip
from vvdp.hydraulics.flow import rated_edge_flow


class FlowControlValve(Params):
    """Passes `rated_flow`, fully open, from `minimum_drop` on, and a share `flow_rise` more at `maximum_drop`.

    Below the minimum drop the compensator is fully open, above the maximum drop as far closed as it goes, and the valve
    is a plain throttle.
    """

    rated_flow: Flow
    minimum_drop: PressureDifference
    maximum_drop: PressureDifference
    flow_rise: Fraction

    def check(self) -> None:
        require_positive(self, "rated_flow")
        require_positive(self, "minimum_drop")
        require_less(self, "minimum_drop", "maximum_drop")


def controlled_side(pressure_drop: float, valve: FlowControlValve) -> float:
    """Whether a flow control valve is below, in or above the drops that it balances [1], see `base.modes.between`.

    pressure_drop  first-named side less the second [Pa]
    """
    return between((pressure_drop - valve.minimum_drop) / (valve.maximum_drop - valve.minimum_drop))


def controlled_flow(pressure_drop: float, opening: float, valve: FlowControlValve) -> float:
    """Volume flow of a flow control valve [m^3/s], signed like the drop; backwards it is a plain throttle.

    Q_r u (1 + rise (d - d_min)/(d_max - d_min)) root(dp)/root(d), with d the drop held between d_min and d_max

    pressure_drop  dp, first-named side less the second [Pa]
    opening        u, of the metering orifice, held between 0 and 1 [1]
    """
    u: float = clip(opening, 0.0, 1.0)
    held: float = clip(pressure_drop, valve.minimum_drop, valve.maximum_drop)
    rise = valve.flow_rise * (held - valve.minimum_drop) / (valve.maximum_drop - valve.minimum_drop)
    return rated_edge_flow(valve.rated_flow * u, 1.0 + rise, pressure_drop, held)
