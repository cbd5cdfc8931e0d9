"""Elastic links that join two motions by a ratio: gears, levers, arms, drums, wheels; the load of a road.

Source  ours, docs/models/components.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.kinds import (
    Angle,
    Coupling,
    Force,
    Kind,
    Length,
    Mass,
    Power,
    Ratio,
    Stiffness,
    Velocity,
    ViscousFriction,
)
from vvdp.base.params import Params
from vvdp.base.rules import refuse, require_positive
from vvdp.base.select import maximum, select
from vvdp.hydraulics.friction import smooth_sign
from vvdp.hydraulics.ports import RodState, ShaftState
from vvdp.hydraulics.rod import GRAVITY, Acceleration
from vvdp.hydraulics.shaft import TorsionalStiffness

AIR_DENSITY = Kind("density of air", "kg/m^3", 0.0, 10.0, "1.2 kg/m^3")
AirDensity = Annotated[float, AIR_DENSITY]
DRAG_AREA = Kind("drag area", "m^2", 0.0, 100.0, "0.6 m^2")
DragArea = Annotated[float, DRAG_AREA]


class Gear(Params):
    """The second shaft turns `gear_ratio` times slower; teeth give way by `torsional_stiffness`, seen at the first."""

    gear_ratio: Ratio
    torsional_stiffness: TorsionalStiffness
    tooth_damping: Coupling

    def check(self) -> None:
        require_positive(self, "gear_ratio", "torsional_stiffness")


class Link(Params):
    """Elastic joint between two ends: its stiffness and damping at the second end."""

    stiffness: Stiffness
    link_damping: ViscousFriction

    def check(self) -> None:
        require_positive(self, "stiffness")


class Lever(Link):
    """The second rod moves `lever_ratio` times as far as the first."""

    lever_ratio: Ratio

    def check(self) -> None:
        require_positive(self, "lever_ratio")


class Drum(Link):
    """A drum of `drum_radius` that winds a rope, or a wheel with a tyre."""

    drum_radius: Length

    def check(self) -> None:
        require_positive(self, "drum_radius")


class Arm(Link):
    """An arm that a cylinder turns: the cylinder's foot is `base_arm` from the arm's pivot, its eye `eye_arm`.

    The angle is that between the two; the rod is at position 0 where the two eyes are `retracted_length` apart.
    """

    base_arm: Length
    eye_arm: Length
    retracted_length: Length

    def check(self) -> None:
        if not abs(self.base_arm - self.eye_arm) < self.retracted_length < self.base_arm + self.eye_arm:
            refuse(self, "retracted_length", "must lie between the difference and the sum of both arms")


class RoadLoad(Params):
    """A vehicle on a road: rolling resistance over its weight, air, slope."""

    mass: Mass
    rolling_resistance: Ratio
    drag_area: DragArea
    slope: Angle = 0.0
    air_density: AirDensity = 1.2
    creep_velocity: Velocity = 0.01
    gravity: Acceleration = GRAVITY

    def check(self) -> None:
        require_positive(self, "creep_velocity")


class LinkForce(NamedTuple):
    """Force that a link gives to its second end in the direction of that, and its loss."""

    force: Force
    loss: Power


class RoadForce(NamedTuple):
    """Force of a road on a vehicle, and the dissipated part."""

    force: Force
    loss: Power


def link_force(stretch: float, rate: float, link: Link) -> LinkForce:
    """Force of a link on its second end [N] and its loss [W]: k s + d s', d s'^2.

    stretch  s, by which the first end is ahead [m]
    rate     s' [m/s]
    """
    return LinkForce(link.stiffness * stretch + link.link_damping * rate, link.link_damping * rate * rate)


def rope_force(stretch: float, rate: float, link: Link) -> LinkForce:
    """Force of a rope on its second end [N] and its loss [W]: k s max(1 + (d/k) s'/s, 0) where s > 0; it never pushes.

    stretch  s [m]
    rate     s' [m/s]
    """
    spring = link.stiffness * maximum(stretch, 0.0)
    damping = select(stretch > 0.0, link.link_damping * rate, 0.0)
    force = maximum(spring + damping, 0.0)
    return LinkForce(force, (force - spring) * rate)


def link_energy(stretch: float, link: Link) -> float:
    """Energy in a link [J]: k s^2/2.

    stretch  s [m]
    """
    return 0.5 * link.stiffness * stretch * stretch


def gear_torque(first: ShaftState, second: ShaftState, gear: Gear) -> LinkForce:
    """Torque of a gear against its first shaft [N m], and its loss [W]; against the second it is as many times larger.

    first, second  shafts

    >>> gear = Gear(gear_ratio=2.0, torsional_stiffness=100.0, tooth_damping=0.0)
    >>> gear_torque(ShaftState(0.5, 0.0), ShaftState(0.2, 0.0), gear).force
    9.999999999999998
    """
    twist = first.angle - gear.gear_ratio * second.angle
    rate = first.speed - gear.gear_ratio * second.speed
    return LinkForce(gear.torsional_stiffness * twist + gear.tooth_damping * rate, gear.tooth_damping * rate * rate)


def gear_energy(first: ShaftState, second: ShaftState, gear: Gear) -> float:
    """Energy in the teeth of a gear [J]."""
    twist = first.angle - gear.gear_ratio * second.angle
    return 0.5 * gear.torsional_stiffness * twist * twist


def arm_length(angle: float, arm: Arm) -> float:
    """Distance of the eyes of the cylinder at an arm [m]: root(a^2 + b^2 - 2 a b cos(angle)).

    angle  between base and eye [rad]

    >>> arm = Arm(base_arm=0.3, eye_arm=0.4, retracted_length=0.45, stiffness=1e8, link_damping=1e4)
    >>> print(round(arm_length(0.5 * 3.141592653589793, arm), 12))
    0.5
    """
    a, b = arm.base_arm, arm.eye_arm
    length: float = np.sqrt(a * a + b * b - 2.0 * a * b * np.cos(angle))
    return length


def arm_lever(angle: float, arm: Arm) -> float:
    """Lever of the cylinder at an arm [m]: d length/d angle = a b sin(angle)/length.

    angle  between base and eye [rad]
    """
    lever: float = arm.base_arm * arm.eye_arm * np.sin(angle) / arm_length(angle, arm)
    return lever


def arm_stretch(shaft: ShaftState, rod: RodState, arm: Arm) -> float:
    """Length of the rod of an arm's cylinder beyond the distance between its eyes [m]."""
    return rod.position + arm.retracted_length - arm_length(shaft.angle, arm)


def road_force(velocity: float, road: RoadLoad) -> RoadForce:
    """Force of a road on a vehicle in its direction [N], and the dissipated part of its power [W].

    -m g sin(slope) - m g c_r cos(slope) sgn(v) - rho c_d A v |v|/2

    velocity  v [m/s]

    >>> van = RoadLoad(mass=2000.0, rolling_resistance=0.01, drag_area=1.0)
    >>> print(round(road_force(20.0, van).force))
    -436
    """
    weight = road.mass * road.gravity
    rolling = road.rolling_resistance * weight * np.cos(road.slope) * smooth_sign(velocity, road.creep_velocity)
    lost = rolling + 0.5 * road.air_density * road.drag_area * velocity * abs(velocity)
    return RoadForce(-weight * np.sin(road.slope) - lost, lost * velocity)


def road_energy(position: float, road: RoadLoad) -> float:
    """Energy of height of a vehicle over position 0 [J]: m g x sin(slope).

    position  x, along the road [m]
    """
    energy: float = road.mass * road.gravity * np.sin(road.slope) * position
    return energy
