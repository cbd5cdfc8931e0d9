"""One branch of the valve: nozzles, centre section and outlet turbine in series.

Derived in docs/models/rotary-valve.md, "Branch law".

Source  ours, docs/models/rotary-valve.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import Flow, Fraction, Pressure, PressureDifference, Ratio
from vvdp.base.powers import power
from vvdp.base.select import maximum, select
from vvdp.valve.rotary import PowerResistance, QuadraticResistance, RotaryValve

# Flow below which the centre section's power law becomes linear [m^3/s]; far below any flow of interest, it only
# keeps the law finite at zero.
STILL_FLOW = 1e-11

CRITICAL_RATIO = 0.96
"""Pressure in the narrowest section of a choked flow over the vapour pressure: 0.96 - 0.28 sqrt(P_v/P_c), P_c the
critical pressure, is 0.957 where P_v is a ten-thousandth of it, and oil's is less."""


class BranchDrops(NamedTuple):
    """Pressure drops of the parts of a branch, with the sign of the flow; the outlet turbine includes its rail."""

    nozzle: PressureDifference
    centre_section: PressureDifference
    outlet_turbine: PressureDifference


class BranchFlow(NamedTuple):
    """Flow of a branch, the flow that the same drop would send through its nozzle per open fraction, and the parts'
    shares of the drop, which sum to 1.

    `full_section_flow` is `flow` over the open fraction, and stays finite when the port closes.
    """

    flow: Flow
    full_section_flow: Flow
    nozzle_share: Fraction
    centre_share: Fraction
    outlet_share: Fraction


class Fractional(NamedTuple):
    """A ratio that is not divided yet."""

    above: Ratio
    below: Ratio


class BranchLaw(NamedTuple):
    """Resistances of a fully open branch at one density, with what else its law needs: all that a flow depends on
    besides drop and opening."""

    nozzle: QuadraticResistance
    centre_section: PowerResistance
    outlet_turbine: QuadraticResistance
    flow_exponent: Ratio
    transition_pressure: PressureDifference
    pressure_recovery: Fraction
    boiling_pressure: Pressure


def branch_law(density: float, valve: RotaryValve, vapour_pressure: float = 0.0) -> BranchLaw:
    """The law of a branch at one density, for many calls of `throttled_flow` or `law_flow`.

    density          [kg/m^3]
    vapour_pressure  of the oil, absolute [Pa]

    Source  wang2017, eqs. 2.3 to 2.5; choking: iec2011
    """
    return BranchLaw(
        nozzle=nozzle_resistance(density, valve),
        centre_section=centre_resistance(valve),
        outlet_turbine=outlet_resistance(density, valve),
        flow_exponent=valve.centre_flow_exponent,
        transition_pressure=valve.transition_pressure,
        pressure_recovery=valve.pressure_recovery,
        boiling_pressure=CRITICAL_RATIO * vapour_pressure,
    )


def nozzle_resistance(density: float, valve: RotaryValve) -> float:
    """Drop of the fully open nozzles over flow squared, rho / (2 (C_d A_in)^2) [Pa s^2/m^6].

    density  [kg/m^3]

    Source  wang2017, eq. 2.3, with the area of all nozzles
    """
    conductance = valve.nozzle_discharge_coefficient * valve.nozzle_area
    return 0.5 * density / (conductance * conductance)


def outlet_resistance(density: float, valve: RotaryValve) -> float:
    """Drop of an outlet turbine and its rail over flow squared, rho / (2 (C_d A_out)^2) + k_rail [Pa s^2/m^6].

    density  [kg/m^3]

    Source  wang2017, eq. 2.5; the rail's term is ours, docs/models/rotary-valve.md
    """
    conductance = valve.outlet_discharge_coefficient * valve.outlet_area
    return 0.5 * density / (conductance * conductance) + valve.rail_coefficient


def centre_resistance(valve: RotaryValve) -> float:
    """Drop of the centre section over flow to the power m, 1 / (k D^n) [SI].

    Source  wang2017, eq. 2.4, with D the spool diameter
    """
    conductance: float = valve.centre_coefficient * (2.0 * valve.spool_radius) ** valve.centre_diameter_exponent
    return 1.0 / conductance


def turbulent_drops(flow: float, opening: float, density: float, valve: RotaryValve) -> BranchDrops:
    """Pressure drops of the parts of a branch by their quadratic and power laws alone, with the sign of the flow [Pa].

    flow     [m^3/s]
    opening  open fraction of the branch's ports, > 0 [1]
    density  [kg/m^3]

    Source  wang2017, eqs. 2.3 to 2.5; the opening is ours, docs/models/rotary-valve.md
    """
    Q, e = flow, 0.5 * valve.centre_flow_exponent - 1.0
    nozzle = nozzle_resistance(density, valve) * Q * abs(Q) / (opening * opening)
    centre = centre_resistance(valve) * Q * abs(Q) * power(Q * Q + STILL_FLOW * STILL_FLOW, e)
    outlet = outlet_resistance(density, valve) * Q * abs(Q)
    return BranchDrops(nozzle, centre, outlet)


def branch_drops(flow: float, opening: float, density: float, valve: RotaryValve) -> BranchDrops:
    """Pressure drops of the parts of a branch, with the sign of the flow [Pa].

    The turbulent drops, scaled together so that their sum goes over into a linear law below the transition pressure:
    the exact inverse of `branch_flow`.

    flow     [m^3/s]
    opening  open fraction of the branch's ports, > 0 [1]
    density  [kg/m^3]

    Source  wang2017, eqs. 2.3 to 2.5; the smoothing is ours, docs/models/rotary-valve.md
    Holds   for flow in either direction, and ports open by more than nothing
    Error   above the turbulent drop by (eps/dp)^2/2, eps the transition pressure

    >>> drops = branch_drops(6.3e-4, 1.0, 870.0, valve)
    >>> print(*[round(drop / 1e5, 2) for drop in drops])  # bar
    3.48 0.73 1.72
    """
    Q, e, eps = flow, 0.5 * valve.centre_flow_exponent - 1.0, valve.transition_pressure
    nozzle = nozzle_resistance(density, valve) / (opening * opening)
    centre = centre_resistance(valve) * power(Q * Q + STILL_FLOW * STILL_FLOW, e)
    outlet = outlet_resistance(density, valve)
    total = nozzle + centre + outlet
    s = total * Q * Q
    # dp^2 / sqrt(dp^2 + eps^2) = s, solved for dp, and divided by total Q |Q| without dividing by zero.
    factor = Q * np.sqrt(0.5 * (s + np.sqrt(s * s + 4.0 * eps * eps)) / total)
    return BranchDrops(nozzle * factor, centre * factor, outlet * factor)


def power_near_one(base: float, exponent: float) -> float:
    """Base to a power without a power function, (2, 2) Pade approximant about 1 [1].

    Within 2e-3 of the power for bases 0.3 to 1 and exponents -0.15 to 0, within 1.5e-4 for bases above 0.5.

    base, exponent  [1]
    """
    near = fraction_near_one(base, 1.0, exponent)
    return near.above / near.below


def fraction_near_one(above: float, below: float, exponent: float) -> Fractional:
    """The same as `power_near_one`, of a fraction and as a fraction: nothing is divided [1].

    above, below  of the base [1]
    exponent      [1]
    """
    d, e = above - below, exponent
    ends, middle = 12.0 * below * below, 6.0 * below
    return Fractional(
        ends + d * (middle * (2.0 + e) + d * ((1.0 + e) * (2.0 + e))),
        ends + d * (middle * (2.0 - e) + d * ((1.0 - e) * (2.0 - e))),
    )


def branch_flow(pressure_drop: float, opening: float, density: float, valve: RotaryValve) -> BranchFlow:
    """Flow through a branch and how its drop divides [m^3/s, 1]; `law_flow` is the same for many calls at one density.

    pressure_drop  from inlet rail to outlet port, either sign [Pa]
    opening        open fraction of the branch's ports, 0 to 1 [1]
    density        [kg/m^3]

    Source  wang2017, eqs. 2.3 to 2.5; the inversion is ours, docs/models/rotary-valve.md
    """
    return law_flow(pressure_drop, opening, branch_law(density, valve))


def closed_flow(pressure_drop: float, law: BranchLaw) -> BranchFlow:
    """Result of `law_flow` for a closed port: no flow, and the whole drop over the nozzles [m^3/s, 1].

    pressure_drop  from inlet rail to outlet port, either sign [Pa]
    """
    dp, eps = pressure_drop, law.transition_pressure
    full_section_flow = dp / np.sqrt(np.sqrt(dp * dp + eps * eps) * law.nozzle)
    return BranchFlow(0.0 * full_section_flow, full_section_flow, 1.0, 0.0, 0.0)


def law_flow(pressure_drop: float, opening: float, law: BranchLaw) -> BranchFlow:
    """Flow through a branch and how its drop divides, by a law made once for many calls [m^3/s, 1].

    pressure_drop  from inlet rail to outlet port, either sign [Pa]
    opening        open fraction of the branch's ports, 0 to 1 [1]

    Source  wang2017, eqs. 2.3 to 2.5; the inversion is ours, docs/models/rotary-valve.md
    """
    return open_flow(pressure_drop, opening, law)


def law_flow_compiled(pressure_drop: float, opening: float, law: BranchLaw) -> BranchFlow:
    """The same as `law_flow`, which it replaces in compiled code: most of the time one of the ports is closed.

    pressure_drop  from inlet rail to outlet port, either sign [Pa]
    opening        open fraction of the branch's ports, 0 to 1 [1]
    """
    if opening == 0.0:
        return closed_flow(pressure_drop, law)
    return open_flow(pressure_drop, opening, law)


def open_flow(pressure_drop: float, opening: float, law: BranchLaw) -> BranchFlow:
    """Flow through a branch and how its drop divides [m^3/s, 1].

    Inverts Q |Q| (R_n / a^2 + R_c (Q^2 + q_0^2)^(m/2 - 1) + R_o) = sign(dp) dp^2 / sqrt(dp^2 + eps^2)
    with two powers and one Halley step. For flows above 1e-7 m^3/s its error is below 1e-12 while the centre section
    takes less than half of the drop, and below 1e-9 up to two thirds.

    pressure_drop  from inlet rail to outlet port, either sign [Pa]
    opening        open fraction of the branch's ports, 0 to 1 [1]

    Source  wang2017, eqs. 2.3 to 2.5; the inversion is ours, docs/models/rotary-valve.md
    """
    dp, eps, e = pressure_drop, law.transition_pressure, 0.5 * law.flow_exponent - 1.0
    a2, x0 = opening * opening, STILL_FLOW * STILL_FLOW
    smooth = np.sqrt(dp * dp + eps * eps)
    s = dp * dp / smooth
    nozzle = law.nozzle
    outlet = a2 * law.outlet_turbine
    B = a2 * law.centre_section
    A = nozzle + outlet
    # Guess x from the power at x_max = s / A, carried down to ratio x_max without another power. Ratios are kept as
    # fractions and the steps of a formula multiplied out, as divisions take longest.
    per_A = 1.0 / A
    x_max = s * per_A
    far = B * per_A * power(a2 * x_max + x0, e)
    carried = fraction_near_one(1.0, 1.0 + far, e)
    carried = fraction_near_one(carried.below, carried.below + far * carried.above, e)
    x = x_max * (carried.below / (carried.below + far * carried.above))
    n, z = a2 * x, a2 * x + x0
    term = B * power(z, e)
    # Halley's step for x (A + B (a^2 x + x_0)^e) = s, as a share v of z, then the power at its end by its Taylor
    # series. The slope of the left side times z is h, its bend times z^2 is bend.
    g, h = x * (A + term) - s, (A + term) * z + e * term * n
    bend = e * a2 * term * (2.0 * z + (e - 1.0) * n)
    v = 2.0 * a2 * g * h / (g * bend - 2.0 * h * h)
    centre = term * (1.0 + e * v * (1.0 + 0.5 * (e - 1.0) * v))
    per_root = 1.0 / np.sqrt(smooth * (A + centre))
    full_section_flow = dp * per_root
    per_total = per_root * per_root * smooth
    return BranchFlow(
        opening * full_section_flow,
        full_section_flow,
        nozzle * per_total,
        centre * per_total,
        outlet * per_total,
    )


def throttled_flow(upstream_pressure: float, downstream_pressure: float, opening: float, law: BranchLaw) -> BranchFlow:
    """Flow through a branch and how its drop divides, with nozzles that may choke [m^3/s, 1].

    upstream_pressure, downstream_pressure  at inlet rail and outlet port, absolute [Pa]
    opening                                 open fraction of the branch's ports, 0 to 1 [1]

    Source  wang2017, eqs. 2.3 to 2.5; choking: iec2011
    """
    free = law_flow(upstream_pressure - downstream_pressure, opening, law)
    return choked_flow(free, choking_ratio(free, upstream_pressure, law), law)


def search_flow(upstream_pressure: float, downstream_pressure: float, opening: float, law: BranchLaw) -> float:
    """The flow of `throttled_flow` alone, for searches: without the drops behind choked nozzles [m^3/s].

    upstream_pressure, downstream_pressure  at inlet rail and outlet port, absolute [Pa]
    opening                                 open fraction of the branch's ports, 0 to 1 [1]

    Source  wang2017, eqs. 2.3 to 2.5; choking: iec2011
    """
    free = law_flow(upstream_pressure - downstream_pressure, opening, law)
    kept: float = np.sqrt(1.0 / maximum(choking_ratio(free, upstream_pressure, law), 1.0))
    return free.flow * kept


def choking_drop(upstream_pressure: float, law: BranchLaw) -> float:
    """Drop over the nozzles from which on they choke, F_L^2 (P_1 - F_F P_v), F_L the pressure recovery [Pa].

    P_1 - F_F P_v counts at least as much as the transition pressure.

    upstream_pressure  P_1, at the inlet rail, absolute [Pa]

    Source  iec2011
    """
    left = maximum(upstream_pressure - law.boiling_pressure, law.transition_pressure)
    return law.pressure_recovery * law.pressure_recovery * left


def choking_ratio(free: BranchFlow, upstream_pressure: float, law: BranchLaw) -> float:
    """Drop over the nozzles, as their flow has it, over the drop from which on they choke [1].

    R_n Q_f^2 over `choking_drop`; 0 for reversed flow, and for a pressure recovery of 0, with which they never choke.

    free               what flows without choking
    upstream_pressure  P_1, at the inlet rail, absolute [Pa]

    Source  iec2011
    """
    Q, chokes = maximum(free.full_section_flow, 0.0), law.pressure_recovery > 0.0
    ratio = law.nozzle * Q * Q / select(chokes, choking_drop(upstream_pressure, law), 1.0)
    return select(chokes, ratio, 0.0)


def choking_ratio_compiled(free: BranchFlow, upstream_pressure: float, law: BranchLaw) -> float:
    """The same as `choking_ratio`, which it replaces in compiled code: a valve that never chokes costs nothing.

    free               what flows without choking
    upstream_pressure  P_1, at the inlet rail, absolute [Pa]

    Source  iec2011
    """
    if law.pressure_recovery == 0.0:
        return 0.0
    Q = maximum(free.full_section_flow, 0.0)
    return law.nozzle * Q * Q / choking_drop(upstream_pressure, law)


def choked_flow(free: BranchFlow, ratio: float, law: BranchLaw) -> BranchFlow:
    """A flow held at that of choked nozzles, Q/sqrt(ratio), where the ratio exceeds 1 [m^3/s, 1].

    Behind the nozzles the drops follow their laws at that flow, and the rest of the whole is that of the nozzles.

    free   flow without choking
    ratio  `choking_ratio` [1]

    Source  iec2011; the shares are ours, docs/models/rotary-valve.md
    """
    kept = 1.0 / maximum(ratio, 1.0)
    root = np.sqrt(kept)
    centre = free.centre_share * power(kept, 0.5 * law.flow_exponent)
    outlet = free.outlet_share * kept
    return BranchFlow(
        flow=free.flow * root,
        full_section_flow=free.full_section_flow * root,
        nozzle_share=1.0 - centre - outlet,
        centre_share=centre,
        outlet_share=outlet,
    )


def choked_flow_compiled(free: BranchFlow, ratio: float, law: BranchLaw) -> BranchFlow:
    """The same as `choked_flow`, which it replaces in compiled code: mostly nothing chokes.

    free   flow without choking
    ratio  `choking_ratio` [1]

    Source  iec2011
    """
    if ratio <= 1.0:
        return free
    kept = 1.0 / ratio
    root = np.sqrt(kept)
    centre = free.centre_share * power(kept, 0.5 * law.flow_exponent)
    outlet = free.outlet_share * kept
    return BranchFlow(free.flow * root, free.full_section_flow * root, 1.0 - centre - outlet, centre, outlet)
