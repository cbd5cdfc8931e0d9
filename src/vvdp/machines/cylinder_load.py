"""The cylinder with what it moves, as a part of any network: chambers, rod, friction, end stops, a force from outside.

Source  wang2017, section 6.1
"""

from dataclasses import dataclass

from vvdp.base.kinds import Position, Pressure
from vvdp.base.params import Params
from vvdp.components.rods import CYLINDER, END_STOP, LOAD_FORCE, ROD_FRICTION
from vvdp.control.duty_cycle import DutyCycle, resting_pressures
from vvdp.hydraulics.cylinder import Cylinder
from vvdp.hydraulics.friction import RodFriction
from vvdp.hydraulics.rod import EndStop
from vvdp.hydraulics.volume import Vessel
from vvdp.network.network import Network
from vvdp.network.nodes import Load, Source

LOW_SIDE = 5e5
"""At which a side that carries nothing starts where no supply holds it, gauge [Pa]."""
CHAMBERS = ("chamber_a", "chamber_b")
"""Names of the volumes at both sides of the piston, with their hoses."""


class InitialCylinder(Params):
    """Where a run starts: `position` of the rod, at rest, and the pressures of both chambers and of what feeds them."""

    position: Position
    pressure_a: Pressure
    pressure_b: Pressure
    supply_pressure: Pressure


@dataclass(frozen=True, kw_only=True)
class LoadedCylinder:
    """A cylinder with its hoses, what it moves, and what hinders it."""

    cylinder: Cylinder
    chamber_a: Vessel
    chamber_b: Vessel
    load: Load
    friction: RodFriction
    end_stops: EndStop


def start_at_rest(
    cycle: DutyCycle, cylinder: Cylinder, reference_pressure: float, level: float, supply: float | None = None
) -> InitialCylinder:
    """Where a run starts: at rest under the first force of a cycle, the lower side at `level`, absolute [Pa].

    reference_pressure  that of the outside, absolute [Pa]
    supply              pressure of what feeds the cylinder, absolute [Pa]; that of the higher side where none is given
    """
    a, b = resting_pressures(cycle.forces[0], level - reference_pressure, cylinder)
    return InitialCylinder(
        position=cycle.positions[0],
        pressure_a=reference_pressure + a,
        pressure_b=reference_pressure + b,
        supply_pressure=reference_pressure + max(a, b) if supply is None else supply,
    )


def add_cylinder(net: Network, parts: LoadedCylinder, force: Source, position: str = "position") -> None:
    """Add a cylinder with its load to a network that has values `initial` with the fields of `InitialCylinder`.

    Its nodes are `chamber_a`, `chamber_b` and `rod`, its components `cylinder`, `friction`, `end_stops` and
    `load_force`.

    force     on the rod from outside, in the direction of its position [N]
    position  field of `initial` with the position at which the rod starts
    """
    a, b = CHAMBERS
    net.volume(a, parts.chamber_a, start="initial.pressure_a")
    net.volume(b, parts.chamber_b, start="initial.pressure_b")
    net.rod("rod", parts.load, position=f"initial.{position}")
    net.add("cylinder", CYLINDER, parts.cylinder, a=a, b=b, rod="rod")
    net.add("friction", ROD_FRICTION, parts.friction, rod="rod")
    net.add("end_stops", END_STOP, parts.end_stops, rod="rod")
    net.add("load_force", LOAD_FORCE, rod="rod", force=force)
