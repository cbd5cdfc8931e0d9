"""Axial drive by one pressure chamber against a spring: where it comes to rest, and how fast it swings.

Source  ours, docs/models/axial-drives.md, where a function names no other.
"""

import numpy as np

from vvdp.hydraulics.cylinder import Plunger
from vvdp.hydraulics.rod import Spring, spring_force


def static_reach(pressure: float, reference_pressure: float, plunger: Plunger, spring: Spring) -> float:
    """Position at which the spring holds a pressure in the chamber [m]: ((p - ref) A - F_0)/k beyond its rest position.

    Without end stops; the highest pressure at hand, the supply's, gives the end of the stroke that can be had.

    pressure            in the chamber, absolute [Pa]
    reference_pressure  outside, absolute [Pa]

    Source  wang2017, eq. 5.1, with P as gauge pressure
    """
    force = (pressure - reference_pressure) * plunger.area_a
    return spring.rest_position + (force - spring.preload) / spring.stiffness


def holding_pressure(position: float, reference_pressure: float, plunger: Plunger, spring: Spring) -> float:
    """Pressure in the chamber that holds the spool at a position, absolute [Pa]; the inverse of `static_reach`.

    position            [m]
    reference_pressure  outside, absolute [Pa]

    Source  wang2017, eq. 5.1, with P as gauge pressure
    """
    return reference_pressure - spring_force(position, spring) / plunger.area_a


def spring_frequency(mass: float, spring: Spring) -> float:
    """Angular frequency of a mass on its spring while the chamber's pressure holds [rad/s]: sqrt(k/M).

    mass  M, all that moves [kg]

    Source  wang2017, section 5.5
    """
    frequency: float = np.sqrt(spring.stiffness / mass)
    return frequency


def oil_stiffness(volume: float, bulk_modulus: float, plunger: Plunger) -> float:
    """Stiffness of the oil enclosed a chamber [N/m]: beta A^2/V.

    volume        V of the chamber at the position, the swept volume included [m^3]
    bulk_modulus  beta [Pa]
    """
    return bulk_modulus * plunger.area_a * plunger.area_a / volume
