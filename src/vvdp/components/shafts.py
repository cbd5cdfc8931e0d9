"""Components that turn with a shaft, brake it or drive it: rotors, springs, torques from outside."""

from typing import NamedTuple

from vvdp.base.conservation import Stored
from vvdp.base.kinds import FrictionTorque, Power, Torque
from vvdp.hydraulics.friction import ShaftFriction, shaft_friction_torque, smooth_sign
from vvdp.hydraulics.ports import ExchangedPower, ShaftSpeed, ShaftState
from vvdp.hydraulics.shaft import Rotor, TorsionSpring, torsion_energy, torsion_torque
from vvdp.network.component import Component


class ShaftEffect(NamedTuple):
    """A torque on the shaft without loss."""

    shaft: Torque


class ShaftLoss(NamedTuple):
    """A torque on the shaft and the power that it dissipates."""

    shaft: Torque
    loss: Power


class ShaftLoad(NamedTuple):
    """A torque on the shaft from outside, and the power that it brings; negative where the load takes it."""

    shaft: Torque
    supplied: ExchangedPower


def shaft_friction(shaft: ShaftSpeed, values: ShaftFriction) -> ShaftLoss:
    """Viscous and dry friction on a shaft, or a load torque of that form; see `shaft_friction_torque`."""
    friction = shaft_friction_torque(shaft.speed, values)
    return ShaftLoss(-friction, friction * shaft.speed)


def rotor(shaft: ShaftSpeed, values: Rotor) -> ShaftLoss:
    """A body that turns with a shaft, in bearings with friction."""
    friction = shaft_friction_torque(shaft.speed, values)
    return ShaftLoss(-friction, friction * shaft.speed)


def rotor_inertia(values: Rotor) -> float:
    """Moment of inertia that a rotor adds to its shaft [kg m^2]."""
    return values.inertia


def torsion_spring(shaft: ShaftState, values: TorsionSpring) -> ShaftEffect:
    """A straight spring with preload on a shaft; see `torsion_torque`."""
    return ShaftEffect(torsion_torque(shaft.angle, values))


def torsion_spring_stored(shaft: ShaftState, values: TorsionSpring) -> Stored:
    """Energy in the spring."""
    return Stored(torsion_energy(shaft.angle, values), 0.0)


def load_torque(shaft: ShaftSpeed, torque: Torque) -> ShaftLoad:
    """A torque on a shaft that something outside prescribes, in the direction of its speed [N m]."""
    return ShaftLoad(torque, torque * shaft.speed)


CREEP = 0.02
"""Speed at which a brake has 71 % of its torque [rad/s]."""


def shaft_brake(shaft: ShaftSpeed, torque: FrictionTorque) -> ShaftLoss:
    """Dry friction on a shaft as large as something outside prescribes: a brake, or a shaft that jams [N m]."""
    held = torque * smooth_sign(shaft.speed, CREEP)
    return ShaftLoss(-held, held * shaft.speed)


SHAFT_FRICTION = Component(shaft_friction, symbol="friction")
ROTOR = Component(rotor, symbol="inertia", inertia=rotor_inertia)
TORSION_SPRING = Component(torsion_spring, symbol="spring", stored=torsion_spring_stored)
LOAD_TORQUE = Component(load_torque, symbol="torque")
SHAFT_BRAKE = Component(shaft_brake, symbol="friction")
