"""The cylinder with what it moves, as a part of any network: chambers, rod, friction, end stops, a force from outside.

Source  wang2017, section 6.1
"""

from dataclasses import dataclass

from vvdp.base.kinds import Position, Pressure
from vvdp.base.params import Params
from vvdp.components.rods import CYLINDER, END_STOP, LOAD_FORCE, ROD_FRICTION
from vvdp.hydraulics.cylinder import Cylinder
from vvdp.hydraulics.friction import RodFriction
from vvdp.hydraulics.rod import EndStop
from vvdp.hydraulics.volume import Vessel
from vvdp.network.network import Network
from vvdp.network.nodes import Load, Source, Start

CHAMBERS = ("chamber_a", "chamber_b")
"""Names of the volumes at both sides of the piston, with their hoses."""


class InitialCylinder(Params):
    """Where a run starts: `position` of the rod, at rest, and the pressures of both chambers and of what feeds them."""

    position: Position
    pressure_a: Pressure
    pressure_b: Pressure
    supply_pressure: Pressure


@dataclass(frozen=True)
class LoadedCylinder:
    """A cylinder with its hoses, what it moves, and what hinders it."""

    cylinder: Cylinder
    chamber_a: Vessel
    chamber_b: Vessel
    load: Load
    friction: RodFriction
    end_stops: EndStop


def add_cylinder(net: Network, parts: LoadedCylinder, force: Source, position: Start = "initial.position") -> None:
    """Add a cylinder with its load to a network that has values `initial` with the fields of `InitialCylinder`.

    Its nodes are `chamber_a`, `chamber_b` and `rod`, its components `cylinder`, `friction`, `end_stops` and
    `load_force`.

    force     on the rod from outside, in the direction of its position [N]
    position  at which the rod starts
    """
    net.volume("chamber_a", parts.chamber_a, start="initial.pressure_a")
    net.volume("chamber_b", parts.chamber_b, start="initial.pressure_b")
    net.rod("rod", parts.load, position=position)
    net.add("cylinder", CYLINDER, parts.cylinder, a="chamber_a", b="chamber_b", rod="rod")
    net.add("friction", ROD_FRICTION, parts.friction, rod="rod")
    net.add("end_stops", END_STOP, parts.end_stops, rod="rod")
    net.add("load_force", LOAD_FORCE, rod="rod", force=force)
