"""The pressure modes as published, for comparison: one applies at a time, and flow and opening jump between some.

Source  wang2017, section 6.4
"""

from vvdp.control.flow_split import Authority
from vvdp.control.pressure_modes import Actuation, Guards, ModeEnds, PressureBounds, Swept, mode_ends


def printed_actuation(
    effort: float, flow: float, swept: Swept, acting: Guards, authority: Authority, bounds: PressureBounds
) -> Actuation:
    """Flow and opening as published, before the limits of pump and valve; mode 3.5 goes over to the opening of 6.34.

    effort  U* [N/s]
    flow    of the pump by the split [m^3/s]

    Source  wang2017, eqs. 6.33 to 6.41
    """
    ends = mode_ends(swept, authority.full_return, 0.0, bounds)
    cited = (effort - authority.per_flow * ends.filling) / authority.per_opening
    return first_match(effort, flow, ends, acting, authority, cited)


def first_match(
    effort: float, flow: float, ends: ModeEnds, acting: Guards, authority: Authority, low_end: float
) -> Actuation:
    """The first of modes 2, 2.5, 3, 3.5, 4, 4.5, 5 and 5.5 that the pressures allow; else mode 1.

    effort   U* [N/s]
    flow     of the pump by the split [m^3/s]
    low_end  opening that mode 3.5 goes over to [1]
    """
    H, K = authority.per_flow, authority.per_opening
    mixed, opening = flow, (effort - H * flow) / K
    if acting.supply_low > 0.0:
        mixed = flow + acting.supply_low * (ends.filling - flow)
    elif acting.return_low > 0.0:
        end = ends.holding if acting.return_low == 1.0 else low_end
        opening = opening + acting.return_low * (end - opening)
        return Actuation((effort - K * opening) / H, opening)
    elif acting.supply_high > 0.0:
        mixed = flow + acting.supply_high * (ends.draining - flow)
    elif acting.return_high > 0.0:
        opening = opening + acting.return_high * (ends.letting - opening)
        return Actuation((effort - K * opening) / H, opening)
    return Actuation(mixed, (effort - H * mixed) / K)
