"""Elastic links of shafts and rods by a ratio: gear, lever, arm, drum, wheel; the load of a road on a vehicle;
stick-slip friction.
"""

from typing import NamedTuple

from vvdp.base.conservation import Stored
from vvdp.base.kinds import Force, Mode, Power, Torque
from vvdp.base.select import maximum
from vvdp.hydraulics.linkage import (
    Arm,
    Drum,
    Gear,
    Lever,
    RoadLoad,
    arm_lever,
    arm_stretch,
    gear_energy,
    gear_torque,
    link_energy,
    link_force,
    road_energy,
    road_force,
    rope_force,
)
from vvdp.hydraulics.ports import RodState, ShaftState
from vvdp.hydraulics.stick_friction import StickFriction, StickState, stick_energy, stick_force, stick_mode
from vvdp.network.component import Component


class GearEffect(NamedTuple):
    """Torques of a gear on both shafts, and its loss."""

    first: Torque
    second: Torque
    loss: Power


class LeverEffect(NamedTuple):
    """Forces of a lever on both rods, and its loss."""

    first: Force
    second: Force
    loss: Power


class WheelEffect(NamedTuple):
    """Torque on a shaft, force on a rod, and the loss between them."""

    shaft: Torque
    rod: Force
    loss: Power


class RoadEffect(NamedTuple):
    """Force of a road on a vehicle, and its loss."""

    rod: Force
    loss: Power


class StickEffect(NamedTuple):
    """Friction on a rod, its loss, how its surfaces give way, and whether it slides."""

    rod: Force
    loss: Power
    rates: StickState
    sliding: Mode


def gear(first: ShaftState, second: ShaftState, values: Gear) -> GearEffect:
    """A gear between two shafts, whose teeth give way."""
    mesh = gear_torque(first, second, values)
    return GearEffect(-mesh.force, values.gear_ratio * mesh.force, mesh.loss)


def gear_stored(first: ShaftState, second: ShaftState, values: Gear) -> Stored:
    """Energy in its teeth."""
    return Stored(gear_energy(first, second, values), 0.0)


def _lever_stretch(first: RodState, second: RodState, values: Lever) -> float:
    return values.lever_ratio * first.position - second.position


def lever(first: RodState, second: RodState, values: Lever) -> LeverEffect:
    """A lever between two rods, with small angles, which gives way."""
    rate = values.lever_ratio * first.velocity - second.velocity
    link = link_force(_lever_stretch(first, second, values), rate, values)
    return LeverEffect(-values.lever_ratio * link.force, link.force, link.loss)


def lever_stored(first: RodState, second: RodState, values: Lever) -> Stored:
    """Energy by which it has given way."""
    return Stored(link_energy(_lever_stretch(first, second, values), values), 0.0)


def arm(shaft: ShaftState, rod: RodState, values: Arm) -> WheelEffect:
    """An arm on a shaft that a cylinder on a rod turns, both eyes of which give way."""
    by_angle = arm_lever(shaft.angle, values)
    link = link_force(arm_stretch(shaft, rod, values), rod.velocity - by_angle * shaft.speed, values)
    return WheelEffect(by_angle * link.force, -link.force, link.loss)


def arm_stored(shaft: ShaftState, rod: RodState, values: Arm) -> Stored:
    """Energy in its eyes."""
    return Stored(link_energy(arm_stretch(shaft, rod, values), values), 0.0)


def _wound(shaft: ShaftState, rod: RodState, values: Drum) -> float:
    return values.drum_radius * shaft.angle - rod.position


def drum(shaft: ShaftState, rod: RodState, values: Drum) -> WheelEffect:
    """A drum that winds a rope, which draws a rod in the direction of its position and never pushes it."""
    rate = values.drum_radius * shaft.speed - rod.velocity
    rope = rope_force(_wound(shaft, rod, values), rate, values)
    return WheelEffect(-values.drum_radius * rope.force, rope.force, rope.loss)


def drum_stored(shaft: ShaftState, rod: RodState, values: Drum) -> Stored:
    """Energy in its rope."""
    return Stored(link_energy(maximum(_wound(shaft, rod, values), 0.0), values), 0.0)


def wheel(shaft: ShaftState, rod: RodState, values: Drum) -> WheelEffect:
    """A wheel that rolls without sliding and moves a vehicle, on a tyre that gives way."""
    rate = values.drum_radius * shaft.speed - rod.velocity
    tyre = link_force(_wound(shaft, rod, values), rate, values)
    return WheelEffect(-values.drum_radius * tyre.force, tyre.force, tyre.loss)


def wheel_stored(shaft: ShaftState, rod: RodState, values: Drum) -> Stored:
    """Energy in its tyre."""
    return Stored(link_energy(_wound(shaft, rod, values), values), 0.0)


def road_load(rod: RodState, values: RoadLoad) -> RoadEffect:
    """A vehicle on a road: its mass, rolling resistance, air and slope."""
    road = road_force(rod.velocity, values)
    return RoadEffect(road.force, road.loss)


def road_load_stored(rod: RodState, values: RoadLoad) -> Stored:
    """Energy of height; that of motion is the rod's."""
    return Stored(road_energy(rod.position, values), 0.0)


def road_load_mass(values: RoadLoad) -> float:
    """Mass that it adds to its rod [kg]."""
    return values.mass


def stick_friction(rod: RodState, state: StickState, sliding: Mode, values: StickFriction) -> StickEffect:
    """Dry friction that holds a rod without creep until it breaks away."""
    found = stick_force(rod.velocity, state.give, sliding, values)
    mode = stick_mode(rod.velocity, state.give, sliding, values)
    return StickEffect(-found.force, found.loss, StickState(found.rate), mode)


def stick_friction_stored(state: StickState, values: StickFriction) -> Stored:
    """Energy in its surfaces."""
    return Stored(stick_energy(state.give, values), 0.0)


GEAR = Component(gear, symbol="gear", stored=gear_stored)
LEVER = Component(lever, symbol="lever", stored=lever_stored)
ARM = Component(arm, symbol="arm", stored=arm_stored)
DRUM = Component(drum, symbol="drum", stored=drum_stored)
WHEEL = Component(wheel, symbol="wheel", stored=wheel_stored)
ROAD_LOAD = Component(road_load, symbol="vehicle", stored=road_load_stored, inertia=road_load_mass)
STICK_FRICTION = Component(stick_friction, symbol="friction", stored=stick_friction_stored)
