"""Cylinders as transformers: pressures to a force on the rod, the rod's motion to walls that move.

Source  ours, docs/models/components.md, where a function names no other.
"""

from vvdp.base.kinds import Area, Conductance, Length, Mass
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.hydraulics.ports import Wall


class Plunger(Params):
    """A single-acting cylinder; the position counts from where its chamber is smallest.

    The other side is open to the reference pressure. `moving_mass` is that of piston and rod.
    """

    area_a: Area
    moving_mass: Mass

    def check(self) -> None:
        require_positive(self, "area_a")


class Cylinder(Plunger):
    """A double-acting cylinder; the position counts from the end where chamber A is smallest.

    A piston on an equal rod either way has two equal areas. `leakage_conductance` is that past the piston. The
    volumes that its ports join are the dead volumes at the ends, with the hoses; the swept volumes are added.
    `stroke` determines the swept volume of chamber B, and limits no motion.
    """

    area_b: Area
    stroke: Length
    leakage_conductance: Conductance

    def check(self) -> None:
        require_positive(self, "area_b", why="with one chamber it is a plunger")
        require_positive(self, "stroke")


def plunger_force(pressure_a: float, reference_pressure: float, plunger: Plunger) -> float:
    """Force of the oil on the rod of a single-acting cylinder [N], outward: (P_a - ref) A_a.

    pressure_a          in the chamber, absolute [Pa]
    reference_pressure  outside, absolute [Pa]

    Source  wang2017, eq. 6.1
    """
    return (pressure_a - reference_pressure) * plunger.area_a


def cylinder_force(pressure_a: float, pressure_b: float, reference_pressure: float, cylinder: Cylinder) -> float:
    """Force of the oil on the rod of a cylinder [N], outward: (P_a - ref) A_a - (P_b - ref) A_b.

    The reference pressure accounts for the atmosphere on the rod.

    pressure_a, pressure_b  in the chambers, absolute [Pa]
    reference_pressure      outside, absolute [Pa]

    Source  wang2017, eq. 6.1
    Holds   at any speed; the friction of seals is `rod_friction_force`

    >>> cylinder = Cylinder(area_a=2e-3, area_b=1e-3, moving_mass=5.0, stroke=0.3, leakage_conductance=0.0)
    >>> cylinder_force(51e5, 11e5, 1e5, cylinder)
    9000.0
    """
    return plunger_force(pressure_a, reference_pressure, cylinder) - (pressure_b - reference_pressure) * cylinder.area_b


def wall_a(position: float, velocity: float, plunger: Plunger) -> Wall:
    """Volume that the piston has added to chamber A [m^3] and its rate [m^3/s]: A_a x and A_a v.

    position  x [m]
    velocity  v [m/s]
    """
    return Wall(plunger.area_a * position, plunger.area_a * velocity)


def wall_b(position: float, velocity: float, cylinder: Cylinder) -> Wall:
    """Volume that the piston has added to chamber B [m^3] and its rate [m^3/s]: A_b (H - x) and -A_b v.

    position  x [m]
    velocity  v [m/s]
    """
    return Wall(cylinder.area_b * (cylinder.stroke - position), -cylinder.area_b * velocity)
