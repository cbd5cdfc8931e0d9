"""Wall friction in a line that rises with frequency: layers of oil that the flow drags along.

Source  ours, docs/models/components.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import Flow
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.line import RoundLine, flow_scale, inertance, line_energy, line_flow_rate, line_friction_power

LAYERS = 5
LAYER_RATES = (28.7511, 134.636, 668.445, 3490.60, 33724.9)
LAYER_WEIGHTS = (1.26566, 2.86658, 6.65809, 16.1490, 112.141)
"""Zielke's weighting function as a sum of five exponentials, ours: within 1.5 % for omega d^2/(4 nu) from 1 to 1e4."""


class LayeredState(NamedTuple):
    """Flow of a line, and of the layers of oil that follow it one slower than the other; see `flow_scale`."""

    flow: Flow
    layer_1: Flow
    layer_2: Flow
    layer_3: Flow
    layer_4: Flow
    layer_5: Flow


def layer_resistance(viscosity: float, line: RoundLine) -> float:
    """Pressure per flow with which a layer of weight 1 clings [Pa s/m^3]: 64 mu l/(pi d^4) times `wall_friction`.

    viscosity  dynamic, mu [Pa s]

    Source  zielke1968 (half the steady friction)
    """
    steady = 128.0 * viscosity * line.length / (np.pi * line.diameter**4)
    return 0.5 * line.wall_friction * steady


def layered_rate(
    state: LayeredState, a: FluidState, b: FluidState, density: float, viscosity: float, line: RoundLine
) -> LayeredState:
    """Rates of the flow of a line and of its layers [m^3/s^2].

    I z' = (h_a - h_b)/sigma - sigma dp_f - sigma^2 sum R m_i (z - z_i), z_i' = n_i 4 mu sigma^2/(rho d^2) (z - z_i)

    state      z and z_i, from a to b
    a, b       oil at the line's ends
    density    of the oil at the tank [kg/m^3]
    viscosity  dynamic [Pa s]

    Source  zielke1968; as layers: ours, docs/models/components.md
    """
    z, sigma = state[0], flow_scale(a, b)
    pace = 4.0 * viscosity * sigma**2 / (density * line.diameter**2)
    clinging = 0.0
    for i in range(LAYERS):
        clinging = clinging + LAYER_WEIGHTS[i] * (z - state[i + 1])
    drop = sigma**2 * layer_resistance(viscosity, line) * clinging
    rate = line_flow_rate(z, a, b, density, viscosity, line) - drop / inertance(density, line)
    return LayeredState(
        flow=rate,
        layer_1=LAYER_RATES[0] * pace * (z - state.layer_1),
        layer_2=LAYER_RATES[1] * pace * (z - state.layer_2),
        layer_3=LAYER_RATES[2] * pace * (z - state.layer_3),
        layer_4=LAYER_RATES[3] * pace * (z - state.layer_4),
        layer_5=LAYER_RATES[4] * pace * (z - state.layer_5),
    )


def layered_power(
    state: LayeredState, a: FluidState, b: FluidState, density: float, viscosity: float, line: RoundLine
) -> float:
    """Power that wall friction in a line dissipates [W]: steady, and sigma^2 R m_i (z - z_i)^2; never negative.

    state      z and z_i, from a to b
    a, b       oil at the line's ends
    density    of the oil at the tank [kg/m^3]
    viscosity  dynamic [Pa s]
    """
    z, sigma = state[0], flow_scale(a, b)
    slip = 0.0
    for i in range(LAYERS):
        slip = slip + LAYER_WEIGHTS[i] * (z - state[i + 1]) ** 2
    steady = line_friction_power(z, a, b, density, viscosity, line)
    return steady + sigma**2 * layer_resistance(viscosity, line) * slip


def layered_energy(state: LayeredState, density: float, line: RoundLine) -> float:
    """Kinetic energy in a line [J]: I z^2/2 and that of its layers, 2 I m_i/n_i z_i^2 times `wall_friction`.

    state    z and z_i
    density  of the oil at the tank [kg/m^3]
    """
    layers = 0.0
    for i in range(LAYERS):
        layers = layers + LAYER_WEIGHTS[i] / LAYER_RATES[i] * state[i + 1] ** 2
    return line_energy(state[0], density, line) + 2.0 * line.wall_friction * inertance(density, line) * layers
