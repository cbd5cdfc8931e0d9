"""Line: a column of oil with inertia and friction between two volumes; its compliance belongs to these."""

import numpy as np

from vvdp.base.errors import ParameterError
from vvdp.base.kinds import Length
from vvdp.base.params import Params
from vvdp.base.select import clip, maximum
from vvdp.fluid.mixture import FluidState

LAMINAR_UP_TO = 2300.0
TURBULENT_FROM = 4000.0


class Line(Params):
    """A smooth pipe or hose, round."""

    length: Length
    diameter: Length

    def check(self) -> None:
        if self.length <= 0.0 or self.diameter <= 0.0:
            raise ParameterError(f"Line: length {self.length:g} m, diameter {self.diameter:g} m; expected both above 0")


def line_flow_rate(
    flow: float, upstream: FluidState, downstream: FluidState, density: float, viscosity: float, line: Line
) -> float:
    """Rate of the flow in a line [tank volumes, m^3/s^2].

    I q' = h_up - h_down - dp_f(q), inertance I = rho L/A. It is the enthalpy difference that drives a column of equal
    mass flow: I q^2/2, the friction and q (h_up - h_down) then balance exactly.

    flow        q, positive from upstream to downstream [tank volumes, m^3/s]
    upstream    oil at the first-named end
    downstream  oil at the second-named end
    density     of the oil at the tank [kg/m^3]
    viscosity   dynamic [Pa s]

    Source  ours, docs/models/components.md
    """
    drive = upstream.enthalpy - downstream.enthalpy
    return (drive - line_friction_drop(flow, density, viscosity, line)) / inertance(density, line)


def inertance(density: float, line: Line) -> float:
    """Inertance of a line [Pa s^2/m^3]: rho L/A.

    density  of the oil at the tank [kg/m^3]

    Source  ours, docs/models/components.md
    """
    return density * line.length / (0.25 * np.pi * line.diameter**2)


def line_friction_drop(flow: float, density: float, viscosity: float, line: Line) -> float:
    """Pressure that wall friction takes from a steady flow [Pa], signed like the flow.

    128 mu L q/(pi d^4), laminar, times a factor that goes smoothly from 1 at Re 2300 to that of Blasius,
    0.3164 Re^(-1/4) over 64/Re, at Re 4000.

    flow       q [m^3/s]
    density    of the oil [kg/m^3]
    viscosity  dynamic, mu [Pa s]

    Source  merritt1967, ch. 3 (laminar, Blasius); transition: ours, docs/models/components.md
    """
    L, d = line.length, line.diameter
    Re = 4.0 * density * abs(flow) / (np.pi * d * viscosity)
    x = clip((Re - LAMINAR_UP_TO) / (TURBULENT_FROM - LAMINAR_UP_TO), 0.0, 1.0)
    turbulent: float = 0.3164 / 64.0 * maximum(Re, LAMINAR_UP_TO) ** 0.75
    factor: float = 1.0 + x**2 * (3.0 - 2.0 * x) * (turbulent - 1.0)
    return 128.0 * viscosity * L / (np.pi * d**4) * flow * factor


def line_friction_power(flow: float, density: float, viscosity: float, line: Line) -> float:
    """Power that wall friction in a line turns to heat [W]: q dp_f(q), never negative.

    flow       q [tank volumes, m^3/s]
    density    of the oil at the tank [kg/m^3]
    viscosity  dynamic [Pa s]

    Source  ours, docs/models/components.md
    """
    return flow * line_friction_drop(flow, density, viscosity, line)


def line_energy(flow: float, density: float, line: Line) -> float:
    """Kinetic energy of the column in a line [J]: I q^2/2.

    flow     q [tank volumes, m^3/s]
    density  of the oil at the tank [kg/m^3]

    Source  ours, docs/models/components.md
    """
    return 0.5 * inertance(density, line) * flow**2
