"""Cooler as a resistance: laminar in its narrow channels, turbulent where they join.

Source  ours, docs/models/components.md, where a function names no other.
"""

import numpy as np

from vvdp.base.kinds import DynamicViscosity, Flow, Fraction, PressureDifference, Temperature
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.hydraulics.heat import HeatConductance


class Cooler(Params):
    """At `rated_flow` and `rated_viscosity` the drop is `rated_drop`, a `laminar_share` of it proportional to both.

    With a heat balance the oil behind it gives `heat_conductance` times its excess over `coolant_temperature` to it.
    """

    rated_flow: Flow
    rated_drop: PressureDifference
    rated_viscosity: DynamicViscosity
    laminar_share: Fraction = 0.5
    heat_conductance: HeatConductance = 0.0
    coolant_temperature: Temperature = 293.15

    def check(self) -> None:
        require_positive(self, "rated_flow", "rated_drop", "rated_viscosity", "laminar_share")


def cooler_flow(drop: float, viscosity: float, cooler: Cooler) -> float:
    """Flow through a cooler [m^3/s], signed as the drop: dP = dP_r (s mu/mu_r x + (1 - s) x |x|), x = Q/Q_r.

    drop       dP [Pa]
    viscosity  mu, dynamic [Pa s]

    >>> cooler = Cooler(rated_flow=1e-3, rated_drop=1e5, rated_viscosity=0.03, laminar_share=0.5)
    >>> print(cooler_flow(1e5, 0.03, cooler), cooler_flow(3e5, 0.03, cooler))
    0.001 0.002
    """
    y = drop / cooler.rated_drop
    laminar = cooler.laminar_share * viscosity / cooler.rated_viscosity
    root = np.sqrt(laminar * laminar + 4.0 * (1.0 - cooler.laminar_share) * abs(y))
    flow: float = cooler.rated_flow * 2.0 * y / (laminar + root)
    return flow
