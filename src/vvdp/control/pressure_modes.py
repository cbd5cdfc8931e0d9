"""Bounds of pressure in both chambers of a cylinder: two laws that guard one each, and their blend.

Where no bound acts, flow and opening are those of the split. Near a bound of the supply chamber the flow is pushed to
one that moves it away, and the opening makes up for it; near one of the return chamber it is the other way round. The
blend has no jump anywhere for a fixed direction.

Source  ours, docs/models/displacement-control.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

from vvdp.base.kinds import Flow, Fraction, Kind, Number, Pressure, PressureDifference, Ratio
from vvdp.base.params import Params
from vvdp.base.rules import field_text, refuse, require_positive
from vvdp.base.select import clip, maximum, select
from vvdp.control.capacities import Sides
from vvdp.control.flow_split import Authority

PRESSURE_MODE = Kind("pressure mode", "1", 0.0, 5.5, "1")

PressureMode = Annotated[float, PRESSURE_MODE]


class PressureBounds(Params):
    """Chambers stay between `lowest_pressure` and `highest_pressure`, absolute; guards act from `transition_band` on.

    `low_margin` is xi of modes 2 and 3, `supply_margin` zeta_Q of mode 4, `return_margin` zeta_u of mode 5.
    """

    lowest_pressure: Pressure
    highest_pressure: Pressure
    transition_band: PressureDifference
    low_margin: Ratio
    supply_margin: Ratio
    return_margin: Ratio
    boost_flow: Flow

    def check(self) -> None:
        require_positive(self, "transition_band", why="flows would jump at a bound")
        if not self.highest_pressure - self.lowest_pressure > 2.0 * self.transition_band:
            band, low = field_text(self, "transition_band"), field_text(self, "lowest_pressure")
            refuse(
                self,
                "highest_pressure",
                f"must be more than two transition bands of {band} above lowest_pressure, {low}",
            )


class Guards(NamedTuple):
    """Action of each guard, 0 to 1."""

    supply_low: Fraction
    supply_high: Fraction
    return_low: Fraction
    return_high: Fraction


class Actuation(NamedTuple):
    """Flow of the pump and opening of the return valve; not limited, the opening may be any number."""

    flow: Flow
    opening: Number


def guards(sides: Sides, bounds: PressureBounds) -> Guards:
    """Action of each guard, 0 to 1.

    Source  wang2017, eqs. 6.35, 6.37, 6.39 and 6.41
    """
    low, high, band = bounds.lowest_pressure, bounds.highest_pressure, bounds.transition_band
    Ps, Pr = sides.supply_pressure, sides.return_pressure
    return Guards(
        clip((low + band - Ps) / band, 0.0, 1.0),
        clip((Ps - high + band) / band, 0.0, 1.0),
        clip((low + band - Pr) / band, 0.0, 1.0),
        clip((Pr - high + band) / band, 0.0, 1.0),
    )


def acting_mode(acting: Guards) -> float:
    """The mode by the pressures [1]: 1 none, 2 supply low, 3 return low, 4 supply high, 5 return high; half a mode more
    within the band. Of two that act, the one that acts more, and the supply's where both act alike."""
    most = maximum(maximum(acting.supply_low, acting.supply_high), maximum(acting.return_low, acting.return_high))
    if most == 0.0:
        return 1.0
    mode = 5.0
    if acting.supply_low == most:
        mode = 2.0
    elif acting.supply_high == most:
        mode = 4.0
    elif acting.return_low == most:
        mode = 3.0
    return mode if most == 1.0 else mode + 0.5


class Swept(NamedTuple):
    """Flow that the moving piston takes from the supply and gives to the return [m^3/s]."""

    supply: Flow
    returned: Flow


def swept_flows(direction: float, velocity: float, sides: Sides) -> Swept:
    """q_s = u_d A_s x' and q_r = u_d A_r x' [m^3/s].  direction: 1 or -1 [1]; velocity: [m/s]."""
    return Swept(direction * sides.supply_area * velocity, direction * sides.return_area * velocity)


class ModeEnds(NamedTuple):
    """Demand of modes 2 and 4 on the pump, and of modes 3 and 5 on the return valve."""

    filling: Flow
    draining: Flow
    holding: Number
    letting: Number


def mode_ends(swept: Swept, full_return: float, boost_flow: float, bounds: PressureBounds) -> ModeEnds:
    """Flows and openings that move a pressure away from its bound.

    full_return  Psi [m^3/s]
    boost_flow   by which mode 2 fills a chamber whose piston stands [m^3/s]

    Source  wang2017, eqs. 6.34, 6.36, 6.38 and 6.40; the boost is ours, docs/models/displacement-control.md
    """
    qs, qr = abs(swept.supply), abs(swept.returned)
    return ModeEnds(
        filling=swept.supply + bounds.low_margin * qs + boost_flow,
        draining=swept.supply - bounds.supply_margin * qs,
        holding=(swept.returned - bounds.low_margin * qr) / full_return,
        letting=(swept.returned + bounds.return_margin * qr) / full_return,
    )


def guarded_actuation(
    effort: float, flow: float, swept: Swept, acting: Guards, authority: Authority, bounds: PressureBounds
) -> Actuation:
    """Flow and opening as the guards blend them, before the limits of pump and valve; together they give the effort.

    effort  U* [N/s]
    flow    of the pump by the split [m^3/s]

    Source  wang2017, eqs. 6.33 to 6.41, made continuous: docs/errata.md
    """
    H, K = authority.per_flow, authority.per_opening
    ends = mode_ends(swept, authority.full_return, bounds.boost_flow, bounds)
    more, less = maximum(ends.filling - flow, 0.0), maximum(flow - ends.draining, 0.0)
    supply_flow = flow + acting.supply_low * more - acting.supply_high * less
    opening = (effort - H * flow) / K
    closing, widening = maximum(opening - ends.holding, 0.0), maximum(ends.letting - opening, 0.0)
    return_opening = opening - acting.return_low * closing + acting.return_high * widening
    w = supply_weight(acting)
    return Actuation(
        flow=w * supply_flow + (1.0 - w) * (effort - K * return_opening) / H,
        opening=w * (effort - H * supply_flow) / K + (1.0 - w) * return_opening,
    )


def supply_weight(acting: Guards) -> float:
    """Weight of the guards of the supply against those of the return [1]; 1 where none acts."""
    supply, returned = maximum(acting.supply_low, acting.supply_high), maximum(acting.return_low, acting.return_high)
    both = supply + returned
    idle = both == 0.0
    return select(idle, 1.0, supply / select(idle, 1.0, both))


def limit_actuation(effort: float, wanted: Actuation, authority: Authority, largest_flow: float) -> Actuation:
    """Flow within 0 to `largest_flow` [m^3/s] and opening within 0 to 1; where one ends the other takes over.

    effort  U* [N/s]

    Source  ours, docs/models/displacement-control.md
    """
    H, K = authority.per_flow, authority.per_opening
    opening = clip(wanted.opening, 0.0, 1.0)
    flow = select(opening == wanted.opening, wanted.flow, (effort - K * opening) / H)
    within = clip(flow, 0.0, largest_flow)
    return Actuation(within, clip(select(within == flow, opening, (effort - H * within) / K), 0.0, 1.0))


def make_up(opening: float, missing: float, acting: Guards, authority: Authority) -> float:
    """The opening [1] with which the return valve makes up for flow that the pump does not deliver.

    A guard of the return holds the opening where it is, by as much as it acts.

    opening  without that [1]
    missing  demanded minus delivered flow [m^3/s]

    Source  ours, docs/models/displacement-control.md
    """
    returned = maximum(acting.return_low, acting.return_high)
    share = 1.0 - (1.0 - supply_weight(acting)) * returned
    return clip(opening + share * missing * authority.per_flow / authority.per_opening, 0.0, 1.0)
