"""Hydraulic motor of fixed displacement that runs either way, driving or driven.

Source  ours, docs/models/components.md, where a function names no other.
"""

from typing import Protocol

from vvdp.base.kinds import Conductance, Displacement, Inertia
from vvdp.base.rules import require_positive
from vvdp.base.select import select
from vvdp.fluid.mixture import FluidState
from vvdp.hydraulics.friction import ShaftFriction


class Displacing(Protocol):
    """Properties of a machine that displaces oil, as the formulas need them."""

    @property
    def displacement(self) -> Displacement: ...


class Motor(ShaftFriction):
    """A motor: its friction is that of a shaft, `inertia` what turns with it.

    It turns forward when oil goes from its first port to its second.
    """

    displacement: Displacement
    leakage_conductance: Conductance
    inertia: Inertia

    def check(self) -> None:
        require_positive(self, "displacement")


def motor_flow(shaft_speed: float, motor: Displacing) -> float:
    """Flow that a motor displaces from its first port to its second [m^3/s], at the side it comes from: D omega.

    shaft_speed  omega [rad/s]
    """
    return motor.displacement * shaft_speed


def motor_torque(a: FluidState, b: FluidState, motor: Displacing) -> float:
    """Hydraulic torque of a motor on its shaft [N m]: D (P_a - P_b).

    a, b  oil at the first and at the second port
    """
    return motor.displacement * (a.pressure - b.pressure)


def motor_compression_loss(shaft_speed: float, a: FluidState, b: FluidState, motor: Displacing) -> float:
    """Power lost where a motor's chambers meet the pressure of the other side [W], never negative.

    D omega ((h_a - h_b)/nu - (P_a - P_b)), nu on the side that the oil comes from: the power of
    the oil that the torque does not take.

    shaft_speed  omega [rad/s]
    a, b         oil at the first and at the second port
    """
    source = select(shaft_speed > 0.0, a.volume_ratio, b.volume_ratio)
    unused = (a.enthalpy - b.enthalpy) / source - (a.pressure - b.pressure)
    return motor.displacement * shaft_speed * unused
