"""Friction of rods and shafts: viscous, dry, and the dry friction that falls from breaking away (Stribeck).

Source  ours, docs/models/components.md, where a function names no other.
"""

from typing import Annotated, TypeAlias

import numpy as np

from vvdp.base.kinds import Coupling, Force, FrictionTorque, Speed, Velocity, ViscousFriction
from vvdp.base.params import Params, without_effect
from vvdp.base.rules import field_text, refuse, require_less, require_positive

DryVelocity: TypeAlias = Annotated[Velocity, without_effect("coulomb_friction", "breakaway_friction")]


class RodFriction(Params):
    """Friction on a rod.

    Dry friction is `breakaway_friction` near rest and falls over `stribeck_velocity` to `coulomb_friction`; the two
    are equal where it does not fall. `coulomb_velocity` is where its sign has reached 71 %.
    """

    viscous_friction: ViscousFriction
    coulomb_friction: Force = 0.0
    breakaway_friction: Force = 0.0
    stribeck_velocity: DryVelocity = 0.1
    coulomb_velocity: DryVelocity = 0.01

    def check(self) -> None:
        F_c, F_s = self.coulomb_friction, self.breakaway_friction
        if F_c < 0.0:
            refuse(self, "coulomb_friction", "must be at least 0: it would drive the rod")
        if F_s < F_c:
            least = field_text(self, "coulomb_friction")
            refuse(self, "breakaway_friction", f"must be at least coulomb_friction, {least}")
        require_positive(self, "stribeck_velocity", "coulomb_velocity")
        if F_s > F_c:  # else the breakaway friction would never be reached
            require_less(self, "coulomb_velocity", "stribeck_velocity")


class ShaftFriction(Params):
    """Friction on a shaft: `shaft_damping` times the speed, and `coulomb_torque`, 71 % of it at `coulomb_speed`."""

    shaft_damping: Coupling
    coulomb_torque: FrictionTorque = 0.0
    coulomb_speed: Speed = 0.1

    def check(self) -> None:
        if self.coulomb_torque < 0.0:
            refuse(self, "coulomb_torque", "must be at least 0: it would drive the shaft")
        require_positive(self, "coulomb_speed")


def smooth_sign(value: float, width: float) -> float:
    """Sign of a value [1], a straight line through zero: x/sqrt(x^2 + w^2), 71 % at w.

    value  x
    width  w, greater than zero, in the unit of x
    """
    sign: float = value / np.sqrt(value * value + width * width)
    return sign


def rod_friction_force(velocity: float, friction: RodFriction) -> float:
    """Friction of a rod [N], against the velocity: b v + (F_c + (F_s - F_c) exp(-(v/v_s)^2)) v/sqrt(v^2 + v_c^2).

    velocity  v [m/s]

    Source  wang2017, eq. 6.1 (viscous); armstrong1994 (falling dry friction); its sign: ours, docs/models/components.md
    Holds   for a rod that slides; at rest it creeps instead of sticking

    >>> seal = RodFriction(
    ...     viscous_friction=100.0,
    ...     coulomb_friction=50.0,
    ...     breakaway_friction=80.0,
    ...     stribeck_velocity=0.02,
    ...     coulomb_velocity=1e-3,
    ... )
    >>> print(round(rod_friction_force(0.5, seal), 1))
    100.0
    """
    ratio = velocity / friction.stribeck_velocity
    excess = (friction.breakaway_friction - friction.coulomb_friction) * np.exp(-ratio * ratio)
    dry: float = (friction.coulomb_friction + excess) * smooth_sign(velocity, friction.coulomb_velocity)
    return friction.viscous_friction * velocity + dry


def shaft_friction_torque(speed: float, friction: ShaftFriction) -> float:
    """Friction of a shaft [N m], against the speed: b omega + T_c omega/sqrt(omega^2 + omega_c^2).

    speed  omega [rad/s]
    """
    dry = friction.coulomb_torque * smooth_sign(speed, friction.coulomb_speed)
    return friction.shaft_damping * speed + dry
