"""The spool as a journal bearing: what pushes it sideways, and how far it gives way.

Derived in docs/design.md, "Where the model leaves its range".
"""

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.select import select
from vvdp.valve.rotary import RotaryValve

BISECTIONS = 50


def radial_force(flows: Array, openings: Array, density: float) -> float:
    """The force that evenly spaced jets leave on the spool [N]: the size of the sum of rho q^2/A along each of them.

    flows     through the nozzles, in their order round the axis [m^3/s]
    openings  of the nozzles in the bore, A [m^2]
    density   rho [kg/m^3]

    Source  ours, docs/models/cfd.md
    """
    directions = np.exp(2j * np.pi * np.arange(len(flows)) / len(flows))
    return float(abs(np.sum(density * flows**2 / openings * directions)))


def radial_jet_force(flow: float, excess_share: float, density: float, valve: RotaryValve) -> float:
    """Radial force of the jets when one nozzle takes more than its share, the others alike less [N].

    F = rho Q^2/(N A_in) ((1 + e)^2 - (1 - e/(N - 1))^2), e the excess over 1/N of the flow; a jet pushes with its
    momentum, and equal jets in a circle cancel. Zero for one nozzle.

    flow          through all nozzles [m^3/s]
    excess_share  e [1]
    density       [kg/m^3]

    Source  ours, docs/design.md, after wang2017, section 2.7
    """
    N, e = valve.sections, excess_share
    others = e / (N - 1.0 + (N == 1.0))
    imbalance = (1.0 + e) * (1.0 + e) - (1.0 - others) * (1.0 - others)
    force = density * flow * flow / (N * valve.nozzle_area) * imbalance
    return select(N > 1.0, force, 0.0)


def bearing_force(eccentricity: float, spool_speed: float, viscosity: float, valve: RotaryValve) -> float:
    """Radial force that the two end lands bear as short journal bearings [N].

    W = 2 mu omega R l^3/c^2 eps/(4 (1 - eps^2)^2) sqrt(pi^2 (1 - eps^2) + 16 eps^2), l the length of one land: short
    against its diameter, half of the film cavitated.

    eccentricity  eps, below 1 [1]
    spool_speed   [rad/s]
    viscosity     dynamic [Pa s]

    Source  ocvirk1952
    Holds   for lands shorter than about half their diameter, and laminar films

    >>> print(round(bearing_force(0.5, 150.0, 0.03, valve), 1))
    531.8
    """
    e, l, c = eccentricity, valve.land_length, valve.radial_clearance
    free = 1.0 - e * e
    load: float = e / (4.0 * free * free) * np.sqrt(np.pi * np.pi * free + 16.0 * e * e)
    return 2.0 * viscosity * abs(spool_speed) * valve.spool_radius * l * l * l / (c * c) * load


def bearing_eccentricity(force: float, spool_speed: float, viscosity: float, valve: RotaryValve) -> float:
    """Eccentricity at which the end lands bear a radial force, 0 centred, 1 touching [1].

    By bisection of `bearing_force`, which grows with it; 1 for a spool at rest that anything pushes.

    force        [N]
    spool_speed  [rad/s]
    viscosity    dynamic [Pa s]

    Source  ocvirk1952
    """
    low, high = 0.0, 1.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        bears = bearing_force(middle, spool_speed, viscosity, valve) >= force
        low, high = select(bears, low, middle), select(bears, middle, high)
    return high
