"""Further cylinders: a cushion at the end of a stroke, a telescope."""

from typing import NamedTuple

from vvdp.base.kinds import Area, Flow, Force, Power
from vvdp.fluid.mixture import FluidState
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.cushion import Cushion, cushion_area
from vvdp.hydraulics.flow import passage
from vvdp.hydraulics.orifice import orifice_flow
from vvdp.hydraulics.ports import Medium, RodState, Wall
from vvdp.hydraulics.telescope import Telescope, telescope_area, telescope_wall
from vvdp.network.component import Component


class CushionPassage(NamedTuple):
    """Flow through a cushion, its loss, and its area."""

    flow: Flow
    loss: Power
    area: Area


class TelescopeEffect(NamedTuple):
    """Force of a telescopic cylinder on its rod."""

    rod: Force


class TelescopeWalls(NamedTuple):
    """Volume that its stages have added to the chamber, and its rate."""

    a: Wall


def cushion(a: FluidState, b: FluidState, rod: RodState, medium: Medium, values: Cushion) -> CushionPassage:
    """A cushion from the port a to the chamber b of a cylinder, whose piston is on the rod."""
    drop = a.pressure - b.pressure
    area = cushion_area(rod.position, drop, values)
    flow, loss = passage(orifice_flow(area, drop, medium.density, values), a, b)
    return CushionPassage(flow, loss, area)


def telescopic_cylinder(a: FluidState, rod: RodState, oil: Oil, values: Telescope) -> TelescopeEffect:
    """A single-acting cylinder of several stages; an end stop on the same rod holds the last one."""
    return TelescopeEffect((a.pressure - oil.reference_pressure) * telescope_area(rod.position, values))


def telescopic_cylinder_walls(rod: RodState, values: Telescope) -> TelescopeWalls:
    """The wall of its chamber."""
    return TelescopeWalls(telescope_wall(rod.position, rod.velocity, values))


def telescopic_cylinder_mass(values: Telescope) -> float:
    """Mass that it adds to its rod [kg]."""
    return values.moving_mass


CUSHION = Component(cushion, symbol="one_way_throttle")
TELESCOPIC_CYLINDER = Component(
    telescopic_cylinder, symbol="telescope", walls=telescopic_cylinder_walls, inertia=telescopic_cylinder_mass
)
