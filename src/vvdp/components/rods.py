"""Components that move a rod or hold it: cylinders, end stops, friction, springs, weights, forces from outside."""

from typing import NamedTuple

from vvdp.base.conservation import Stored
from vvdp.base.kinds import Flow, Force, FrictionForce, Kink, Power
from vvdp.fluid.mixture import FluidState
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.cylinder import Cylinder, Plunger, cylinder_force, plunger_force, wall_a, wall_b
from vvdp.hydraulics.flow import passage
from vvdp.hydraulics.friction import RodFriction, rod_friction_force, smooth_sign
from vvdp.hydraulics.ports import ExchangedPower, RodState, Wall
from vvdp.hydraulics.rod import (
    EndStop,
    Spring,
    Weight,
    spring_energy,
    spring_force,
    stop_energy,
    stop_force,
    stop_sides,
    weight_energy,
    weight_force,
)
from vvdp.network.component import Component


class CylinderEffect(NamedTuple):
    """Force of a cylinder on its rod, tank volumes into its chambers by leakage past the piston, and its loss."""

    a: Flow
    b: Flow
    rod: Force
    loss: Power


class CylinderWalls(NamedTuple):
    """Volumes that the piston has added to both chambers, and their rates."""

    a: Wall
    b: Wall


class PlungerEffect(NamedTuple):
    """Force of a single-acting cylinder on its rod."""

    rod: Force


class PlungerWalls(NamedTuple):
    """Volume that the piston has added to the chamber, and its rate."""

    a: Wall


class RodEffect(NamedTuple):
    """A force on the rod, in the direction of its position, without loss."""

    rod: Force


class RodLoss(NamedTuple):
    """A force on the rod, in the direction of its position, and the power it dissipates."""

    rod: Force
    loss: Power


class LoadEffect(NamedTuple):
    """A force on the rod from outside, and the power that it brings; negative where the load takes it."""

    rod: Force
    supplied: ExchangedPower


def cylinder(a: FluidState, b: FluidState, rod: RodState, oil: Oil, values: Cylinder) -> CylinderEffect:
    """A double-acting cylinder, kept within its stroke by an end-stop only: force on the rod, and leakage past the
    piston. Its friction, its end stops and its chambers' own volumes are components and nodes of their own.
    """
    leak = passage(values.leakage_conductance * (a.pressure - b.pressure), a, b)
    force = cylinder_force(a.pressure, b.pressure, oil.reference_pressure, values)
    return CylinderEffect(-leak.flow, leak.flow, force, leak.loss)


def cylinder_walls(rod: RodState, values: Cylinder) -> CylinderWalls:
    """The walls of both chambers."""
    return CylinderWalls(wall_a(rod.position, rod.velocity, values), wall_b(rod.position, rod.velocity, values))


def piston_mass(values: Cylinder) -> float:
    """Mass that a cylinder adds to its rod [kg]."""
    return values.moving_mass


def plunger(a: FluidState, rod: RodState, oil: Oil, values: Plunger) -> PlungerEffect:
    """A single-acting cylinder: force on the rod. A `spring` on the same rod brings it back."""
    return PlungerEffect(plunger_force(a.pressure, oil.reference_pressure, values))


def plunger_walls(rod: RodState, values: Plunger) -> PlungerWalls:
    """The wall of the chamber."""
    return PlungerWalls(wall_a(rod.position, rod.velocity, values))


def plunger_mass(values: Plunger) -> float:
    """Mass that a single-acting cylinder adds to its rod [kg]."""
    return values.moving_mass


class StopEffect(NamedTuple):
    """Force of end stops on a rod, and whether it touches them."""

    rod: Force
    loss: Power
    near: Kink
    far: Kink


def end_stop(rod: RodState, values: EndStop) -> StopEffect:
    """Elastic stops at both ends of a rod's travel; see `stop_force`."""
    stop, sides = stop_force(rod.position, rod.velocity, values), stop_sides(rod.position, values)
    return StopEffect(stop.force, stop.loss, sides.near, sides.far)


def end_stop_stored(rod: RodState, values: EndStop) -> Stored:
    """Energy in the end stops."""
    return Stored(stop_energy(rod.position, values), 0.0)


def rod_friction(rod: RodState, values: RodFriction) -> RodLoss:
    """Viscous and dry friction on a rod; see `rod_friction_force`."""
    friction = rod_friction_force(rod.velocity, values)
    return RodLoss(-friction, friction * rod.velocity)


def spring(rod: RodState, values: Spring) -> RodEffect:
    """A straight spring with preload on a rod; see `spring_force`."""
    return RodEffect(spring_force(rod.position, values))


def spring_stored(rod: RodState, values: Spring) -> Stored:
    """Energy in the spring."""
    return Stored(spring_energy(rod.position, values), 0.0)


def weight(rod: RodState, values: Weight) -> RodEffect:
    """A mass on a rod and its pull on a slope; see `weight_force`."""
    return RodEffect(weight_force(values))


def weight_stored(rod: RodState, values: Weight) -> Stored:
    """Energy of height; that of motion is the rod's."""
    return Stored(weight_energy(rod.position, values), 0.0)


def weight_mass(values: Weight) -> float:
    """Mass that a weight adds to its rod [kg]."""
    return values.mass


def load_force(rod: RodState, force: Force) -> LoadEffect:
    """A force on a rod that something outside prescribes, in the direction of the position [N]."""
    return LoadEffect(force, force * rod.velocity)


CREEP = 1e-4
"""Velocity at which a brake has 71 % of its force [m/s]."""


def rod_brake(rod: RodState, force: FrictionForce) -> RodLoss:
    """Brake on a rod with a commanded Coulomb friction force: a brake, or a rod that jams [N]."""
    held = force * smooth_sign(rod.velocity, CREEP)
    return RodLoss(-held, held * rod.velocity)


CYLINDER = Component(cylinder, symbol="cylinder", walls=cylinder_walls, inertia=piston_mass)
PLUNGER = Component(plunger, symbol="plunger", walls=plunger_walls, inertia=plunger_mass)
END_STOP = Component(end_stop, symbol="end_stop", stored=end_stop_stored)
ROD_FRICTION = Component(rod_friction, symbol="friction")
SPRING = Component(spring, symbol="spring", stored=spring_stored)
WEIGHT = Component(weight, symbol="mass", stored=weight_stored, inertia=weight_mass)
LOAD_FORCE = Component(load_force, symbol="force")
ROD_BRAKE = Component(rod_brake, symbol="friction")
