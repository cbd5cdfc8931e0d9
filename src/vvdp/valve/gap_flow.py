"""Cavitation at the nozzles, and effects of the oil in the clearance besides sealing and drag.

Derived in docs/design.md, "Where the model leaves its range".

Source  ours, docs/design.md, where a function names no other.
"""

import numpy as np

from vvdp.base.select import maximum
from vvdp.valve.rotary import RotaryValve


def cavitation_number(upstream_pressure: float, downstream_pressure: float, cavitation_pressure: float) -> float:
    """Pressure left above cavitation behind an opening, over its drop [1]: (p_2 - p_c)/(p_1 - p_2), drop above 0.

    upstream_pressure, downstream_pressure  p_1, p_2, absolute [Pa]
    cavitation_pressure                     p_c, at which air or vapour comes out, absolute [Pa]

    Source  merritt1967, flow through orifices

    >>> cavitation_number(11e5, 3e5, 1e5)
    0.25
    """
    drop = maximum(upstream_pressure - downstream_pressure, 1.0)
    return (downstream_pressure - cavitation_pressure) / drop


def gap_reynolds_number(spool_speed: float, density: float, viscosity: float, valve: RotaryValve) -> float:
    """Reynolds number of the shear flow in the clearance, rho omega R c/mu [1].

    spool_speed  [rad/s]
    density      [kg/m^3]
    viscosity    dynamic [Pa s]
    """
    return density * abs(spool_speed) * valve.spool_radius * valve.radial_clearance / viscosity


def taylor_number(spool_speed: float, density: float, viscosity: float, valve: RotaryValve) -> float:
    """Re sqrt(c/R) of the clearance [1]; vortices, and more friction, from 41.2 on.

    spool_speed  [rad/s]
    density      [kg/m^3]
    viscosity    dynamic [Pa s]

    Source  taylor1923
    Holds   for a smooth clearance that is small against the radius, its outer wall at rest

    >>> print(round(taylor_number(150.0, 870.0, 0.03, valve), 3))
    0.022
    """
    slenderness: float = np.sqrt(valve.radial_clearance / valve.spool_radius)
    return gap_reynolds_number(spool_speed, density, viscosity, valve) * slenderness


def sheared_temperature_rise(
    spool_speed: float, viscosity: float, thermal_conductivity: float, valve: RotaryValve
) -> float:
    """Temperature rise of the middle of the clearance over its walls, mu (omega R)^2/(8 lambda) [K].

    Shear turns mu (u/c)^2 per volume to heat, which is conducted to two walls of one temperature.

    spool_speed           [rad/s]
    viscosity             dynamic [Pa s]
    thermal_conductivity  of the oil [W/(m K)]
    """
    u = spool_speed * valve.spool_radius
    return viscosity * u * u / (8.0 * thermal_conductivity)


def carried_temperature_rise(
    friction_power: float, pressure_difference: float, leakage_flow: float, density: float, specific_heat: float
) -> float:
    """Temperature rise of the leaking oil if it alone carries off friction and its own throttling [K].

    (P_f + q dP)/(rho c_p q): an upper bound, since the walls carry off heat too.

    friction_power       P_f [W]
    pressure_difference  along the gap [Pa]
    leakage_flow         q, above 0 [m^3/s]
    density              [kg/m^3]
    specific_heat        c_p [J/(kg K)]
    """
    return (friction_power / leakage_flow + pressure_difference) / (density * specific_heat)
