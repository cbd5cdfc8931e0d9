"""Flows while barriers narrower than the nozzles let both ports be open at once, in closed form.

Derived in docs/models/rotary-valve.md, "Losses". One port closes while the other opens, their open fractions adding up
to 1 - lambda, lambda the lap ratio. Flows are counted in parts of the pump flow, so that a port of open fraction a
passes g root(drop), g = a / root(n + r a^2), with n the nozzle's and r the other drop of the open valve.

Source  ours, docs/models/rotary-valve.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import PressureDifference, Ratio
from vvdp.base.select import clip, maximum, select
from vvdp.fluid.mixture import NODES, WEIGHTS

STEPS = 5
"""Newton steps to the opening where the relief valve closes: their remaining error enters a mean as its square only."""
RELIEF_STEPS = 3
"""Of Newton, to the pressure at which the relief valve takes the rest: the flows hardly bend over its override."""
LEAST_JOINT = 1e-9
"""Open fraction at which the ports are taken where they are never open together: their time there is nothing."""


class Ends(NamedTuple):
    """Pressures around both ports [Pa]: relief setting above the load and above the tank, and how far the relief valve
    lets it rise with the whole flow; nozzle's and other drop of the open valve."""

    relief_over_load: PressureDifference
    relief_over_tank: PressureDifference
    rise: PressureDifference
    nozzle: PressureDifference
    other: PressureDifference


class JoinedPorts(NamedTuple):
    """Integrals over the tank port's open fraction while both ports are open: the drop in excess of the fully open
    valve [Pa], flow to the load, flow over the relief valve [parts of the pump flow]."""

    excess_drop: PressureDifference
    load_flow: Ratio
    relief_flow: Ratio


def joined_ports(joint: float, ends: Ends) -> JoinedPorts:
    """Integrals while both ports are open, together by `joint` = max(1 - lambda, 0) [Pa, 1, 1].

    By 16 Gauss points on each of three stretches, which end where the relief valve closes, and where it opens again or
    the load begins to flow back.

    joint  sum of the open fractions [1]
    """
    whole = maximum(joint, LEAST_JOINT)
    closes, turns = _breaks(whole, ends)
    excess = load = relief = 0.0
    for start, end in ((0.0, closes), (closes, turns), (turns, whole)):
        for i in range(16):
            found = _at(start + (0.5 + NODES[i]) * (end - start), whole, ends)
            weight = WEIGHTS[i] * (end - start)
            excess = excess + weight * found.excess_drop
            load = load + weight * found.load_flow
            relief = relief + weight * found.relief_flow
    share = joint / whole
    return JoinedPorts(share * excess, share * load, share * relief)


def _conductance(opening: float, ends: Ends) -> float:
    """Flow of a port over the root of its drop [1/Pa^0.5]."""
    flow: float = opening / np.sqrt(ends.nozzle + ends.other * opening * opening)
    return flow


def _capacity(tank_opening: float, whole: float, ends: Ends) -> float:
    """Flow of both ports at the relief setting [1]: concave, and the relief valve is open where it is below 1."""
    load: float = _conductance(whole - tank_opening, ends) * np.sqrt(ends.relief_over_load)
    tank: float = _conductance(tank_opening, ends) * np.sqrt(ends.relief_over_tank)
    return load + tank


def _capacity_slope(tank_opening: float, whole: float, ends: Ends) -> float:
    """Its derivative: g' = n / (n + r a^2)^(3/2)."""
    n, r, a, b = ends.nozzle, ends.other, tank_opening, whole - tank_opening
    load: float = n * np.sqrt(ends.relief_over_load) / (n + r * b * b) ** 1.5
    tank: float = n * np.sqrt(ends.relief_over_tank) / (n + r * a * a) ** 1.5
    return tank - load


def _breaks(whole: float, ends: Ends) -> tuple[float, float]:
    """Tank openings at which the relief valve closes, and at which it opens again or the load begins to flow back.

    Newton on a concave function from where it is below 1 does not pass its root. Where the relief valve stays open both
    lie anywhere, which moves nothing.
    """
    closes, opens = 0.0 * whole, 1.0 * whole
    for _ in range(STEPS):
        closes = _newton(closes, whole, ends)
        opens = _newton(opens, whole, ends)
    over_tank = maximum(ends.relief_over_tank - ends.relief_over_load - ends.other, ends.nozzle)
    backflow = np.sqrt(ends.nozzle / over_tank)
    turns = select(_capacity(whole, whole, ends) < 1.0, opens, backflow)
    return closes, clip(turns, closes, whole)


def _newton(tank_opening: float, whole: float, ends: Ends) -> float:
    slope = _capacity_slope(tank_opening, whole, ends)
    steep = select(abs(slope) > 1e-12, slope, 1e-12)
    return clip(tank_opening + (1.0 - _capacity(tank_opening, whole, ends)) / steep, 0.0, whole)


def _at(tank_opening: float, whole: float, ends: Ends) -> JoinedPorts:
    """Flows at one instant, and the loss in excess of that of the fully open valve.

    With the relief valve open the inlet is x above its setting, x = o (1 - q_L - q_T). With it close, y the root of the
    inlet over the tank and D the load over the tank, g_L root(y^2 - D) + g_T y = 1, a quadratic equation; below the
    load's pressure, with g_T root(D) > 1, oil flows back.
    """
    H_L, H_T = ends.relief_over_load, ends.relief_over_tank
    g_L, g_T, D = _conductance(whole - tank_opening, ends), _conductance(tank_opening, ends), H_T - H_L
    is_open = g_L * np.sqrt(H_L) + g_T * np.sqrt(H_T) < 1.0
    x = 0.0 * g_L
    for _ in range(RELIEF_STEPS):
        load, tank = np.sqrt(H_L + x), np.sqrt(H_T + x)
        slope = 1.0 + 0.5 * ends.rise * (g_L / load + g_T / tank)
        x = maximum(x - (ends.rise * (g_L * load + g_T * tank - 1.0) + x) / slope, 0.0)
    forward = g_T * g_T * D < 1.0
    side = select(forward, 1.0, -1.0)
    b = side * g_L * g_L
    root = g_L * np.sqrt(maximum(side * (1.0 + (b - g_T * g_T) * D), 0.0) + 1e-30)
    y = select(forward, (1.0 + b * D) / (g_T + root), (g_T + root) / (g_L * g_L + g_T * g_T))
    load_flow = select(is_open, g_L * np.sqrt(H_L + x), 1.0 - g_T * y)
    inlet = select(is_open, H_T + x, y * y)
    relief_flow = select(is_open, 1.0 - g_L * np.sqrt(H_L + x) - g_T * np.sqrt(H_T + x), 0.0)
    return JoinedPorts(inlet - load_flow * D - ends.nozzle - ends.other, load_flow, relief_flow)
