"""Leakage of the load region past the spool."""

import numpy as np

from vvdp.valve.geometry import barrier_width, helix_slope
from vvdp.valve.rotary import RotaryValve


def leakage_conductance(viscosity: float, valve: RotaryValve) -> float:
    """Laminar conductance from the load region to the tank [m^3/(s Pa)].

    G = c^3 / (12 mu) (l_b / w_b + 2 (2 pi R / l_land)) (1 + 1.5 eps^2): slots across the 2 N barriers, of length
    l_b = 2 N L / sin(alpha) and breadth w_b = b sin(alpha), and the two end lands. All films are wedges round a spool
    of eccentricity eps, whose c^3 is larger on the mean by 1 + 1.5 eps^2.

    viscosity  dynamic, in the films [Pa s]; `fluid.oil.film_viscosity`

    Source  merritt1967, laminar flow between plates; its use here is ours, docs/models/rotary-valve.md
    Holds   for laminar flow through clearances that are small against every width

    >>> leakage = leakage_conductance(0.03, valve) * 100e5
    >>> print(round(6e4 * leakage, 3))  # l/min at 100 bar
    0.203
    """
    R, c, t = valve.spool_radius, valve.radial_clearance, helix_slope(valve)
    sin2 = t * t / (1.0 + t * t)
    barriers = 2.0 * valve.sections * valve.helix_length / (barrier_width(valve) * sin2)
    lands = 2.0 * (2.0 * np.pi * R / valve.land_length)
    off_centre = 1.0 + 1.5 * valve.eccentricity * valve.eccentricity
    return c * c * c / (12.0 * viscosity) * (barriers + lands) * off_centre
