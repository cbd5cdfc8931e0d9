"""Line: a column of oil with inertia and wall friction between two volumes.

Source  ours, docs/models/components.md, where a function names no other.
"""

from typing import Protocol

import numpy as np

from vvdp.base.kinds import Length, Ratio
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.base.select import clip, maximum
from vvdp.fluid.mixture import FluidState

LAMINAR_UP_TO = 2300.0
TURBULENT_FROM = 4000.0


class RoundLine(Protocol):
    """Properties of a line, or of a piece of one, that the formulas need."""

    @property
    def length(self) -> Length: ...
    @property
    def diameter(self) -> Length: ...
    @property
    def wall_friction(self) -> Ratio: ...


class Line(Params):
    """A straight run of pipe or hose, round. `wall_friction` multiplies the friction of a smooth wall; 0 has none."""

    length: Length
    diameter: Length
    wall_friction: Ratio = 1.0

    def check(self) -> None:
        require_positive(self, "length", "diameter")


def line_volume(line: RoundLine) -> float:
    """Volume inside a line [m^3]: pi d^2 l/4."""
    return 0.25 * np.pi * line.diameter**2 * line.length


def inertance(density: float, line: RoundLine) -> float:
    """Inertance of a line [Pa s^2/m^3]: rho l/A.

    density  of the oil at the tank [kg/m^3]

    >>> inertance(870.0, Line(length=2.0, diameter=0.01)) == 870.0 * 2.0 / (np.pi * 0.005**2)
    True
    """
    return density * line.length / (0.25 * np.pi * line.diameter**2)


def flow_scale(a: FluidState, b: FluidState) -> float:
    """Root of the mean volume ratio in a line, sigma [1]: sqrt((nu_a + nu_b)/2).

    A line's flow z is the geometric mean of its flow in tank volumes, q = z/sigma, and the actual one, Q = z sigma.

    a, b  oil at its ends
    """
    scale: float = np.sqrt(0.5 * (a.volume_ratio + b.volume_ratio))
    return scale


def line_flow_rate(
    flow: float, a: FluidState, b: FluidState, density: float, viscosity: float, line: RoundLine
) -> float:
    """Rate of the flow of a line [m^3/s^2]: I z' = (h_a - h_b)/sigma - sigma dp_f(sigma z).

    Its kinetic energy I z^2/2, friction and q (h_a - h_b) balance exactly; a small wave has the momentum I q' = dP.

    flow       z, from a to b; see `flow_scale` [m^3/s]
    a, b       oil at its ends
    density    of the oil at the tank [kg/m^3]
    viscosity  dynamic [Pa s]
    """
    sigma = flow_scale(a, b)
    drop = line_friction_drop(sigma * flow, density / sigma**2, viscosity, line)
    return ((a.enthalpy - b.enthalpy) / sigma - sigma * drop) / inertance(density, line)


def line_friction_drop(flow: float, density: float, viscosity: float, line: RoundLine) -> float:
    """Pressure that wall friction takes from a steady flow [Pa], signed like the flow.

    128 mu l Q/(pi d^4), laminar, times a factor that goes smoothly from 1 at Re 2300 to that of Blasius,
    0.3164 Re^(-1/4) over 64/Re, at Re 4000; times `wall_friction`.

    flow       Q, actual [m^3/s]
    density    of the oil, actual [kg/m^3]
    viscosity  dynamic, mu [Pa s]

    Source  merritt1967, ch. 3 (laminar, Blasius); transition: ours, docs/models/components.md
    Holds   for smooth round walls up to Re 100 000, without entry losses
    Error   open between Re 2300 and 4000, where a flow may be either

    >>> hose = Line(length=2.0, diameter=0.01)
    >>> print(round(line_friction_drop(1e-4, 870.0, 0.03, hose) / 1e5, 3))  # laminar
    0.244
    """
    d = line.diameter
    Re = 4.0 * density * abs(flow) / (np.pi * d * viscosity)
    x = clip((Re - LAMINAR_UP_TO) / (TURBULENT_FROM - LAMINAR_UP_TO), 0.0, 1.0)
    turbulent: float = 0.3164 / 64.0 * maximum(Re, LAMINAR_UP_TO) ** 0.75
    factor: float = 1.0 + x**2 * (3.0 - 2.0 * x) * (turbulent - 1.0)
    return line.wall_friction * 128.0 * viscosity * line.length / (np.pi * d**4) * flow * factor


def line_friction_power(
    flow: float, a: FluidState, b: FluidState, density: float, viscosity: float, line: RoundLine
) -> float:
    """Power that wall friction in a line dissipates [W]: Q dp_f(Q), Q = sigma z, never negative.

    flow       z, from a to b; see `flow_scale` [m^3/s]
    a, b       oil at its ends
    density    of the oil at the tank [kg/m^3]
    viscosity  dynamic [Pa s]
    """
    sigma = flow_scale(a, b)
    return sigma * flow * line_friction_drop(sigma * flow, density / sigma**2, viscosity, line)


def line_energy(flow: float, density: float, line: RoundLine) -> float:
    """Kinetic energy of the column in a line [J]: I z^2/2.

    flow     z; see `flow_scale` [m^3/s]
    density  of the oil at the tank [kg/m^3]
    """
    return 0.5 * inertance(density, line) * flow**2
