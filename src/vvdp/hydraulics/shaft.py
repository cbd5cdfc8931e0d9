"""Inertias and springs on a shaft.

Source  ours, docs/models/components.md, where a function names no other.
"""

from typing import Annotated

from vvdp.base.kinds import Angle, Inertia, Kind, Torque
from vvdp.base.params import Params
from vvdp.hydraulics.friction import ShaftFriction

TORSIONAL_STIFFNESS = Kind("torsional stiffness", "N*m/rad", 0.0, 1e9, "100 N*m/rad")
TorsionalStiffness = Annotated[float, TORSIONAL_STIFFNESS]


class Rotor(ShaftFriction):
    """A body that turns with a shaft, in bearings with friction."""

    inertia: Inertia


class TorsionSpring(Params):
    """A spring that turns the shaft back: it gives `preload_torque` at `rest_angle`, more beyond."""

    torsional_stiffness: TorsionalStiffness
    preload_torque: Torque
    rest_angle: Angle


def torsion_torque(angle: float, spring: TorsionSpring) -> float:
    """Torque of a spring on the shaft [N m], in the direction of the angle: -T_0 - k (theta - theta_0).

    angle  theta [rad]
    """
    return -spring.preload_torque - spring.torsional_stiffness * (angle - spring.rest_angle)


def torsion_energy(angle: float, spring: TorsionSpring) -> float:
    """Energy in a torsion spring above that at its rest angle [J]: T_0 (theta - theta_0) + k (theta - theta_0)^2/2.

    angle  theta [rad]
    """
    reach = angle - spring.rest_angle
    return reach * (spring.preload_torque + 0.5 * spring.torsional_stiffness * reach)
