"""Sharp-edged orifice: turbulent, with a laminar transition around zero drop."""

import numpy as np

from vvdp.base.kinds import DischargeCoefficient, PressureDifference
from vvdp.base.params import Params
from vvdp.base.rules import require_positive


class Orifice(Params):
    """Properties of an orifice of any area: the flow turns linear in the drop below about `transition_pressure`.

    Source  merritt1967, ch. 3 (a sharp edge, 0.61); the usual transition pressure is assumed
    """

    discharge_coefficient: DischargeCoefficient = 0.61
    transition_pressure: PressureDifference = 5e4

    def check(self) -> None:
        require_positive(self, "transition_pressure")


def orifice_flow(area: float, pressure_drop: float, density: float, orifice: Orifice) -> float:
    """Volume flow through an orifice [m^3/s], signed like the drop.

    Cd A sqrt(2/rho) dp / (dp^2 + eps^2)^(1/4)

    area           open area [m^2]
    pressure_drop  first-named side less the second [Pa]
    density        of the oil [kg/m^3]

    Source  merritt1967, ch. 3 (root law); transition: ours, docs/models/components.md
    Holds   for sharp edges without cavitation
    Error   1 % below the root law at a drop of five transition pressures, less above

    >>> print(round(6e4 * orifice_flow(10e-6, 50e5, 870.0, Orifice()), 2))  # l/min
    39.24
    """
    cd, eps = orifice.discharge_coefficient, orifice.transition_pressure
    # The two roots as one, which costs compiled code a root and a division less.
    smooth = np.sqrt(pressure_drop * pressure_drop + eps * eps)
    flow: float = cd * area * pressure_drop / np.sqrt(0.5 * density * smooth)
    return flow


def orifice_area_for(flow: float, pressure_drop: float, density: float, orifice: Orifice) -> float:
    """Area [m^2] through which an orifice passes a given flow at a given drop; the inverse of `orifice_flow`.

    flow           [m^3/s], of the sign of the drop
    pressure_drop  other than zero [Pa]
    density        of the oil [kg/m^3]

    Source  ours, docs/models/components.md
    Error   none but rounding

    >>> print(round(1e6 * orifice_area_for(6.54e-4, 50e5, 870.0, Orifice()), 1))  # mm2
    10.0
    """
    return flow / orifice_flow(1.0, pressure_drop, density, orifice)
