"""The two axial drives of a spool as parts of any network; each returns the path of the spool's position."""

from dataclasses import dataclass

from vvdp.base.errors import ParameterError
from vvdp.base.signal import Signal
from vvdp.components.directional_valves import THREE_WAY_PROPORTIONAL_VALVE, ThreeWayProportionalValve
from vvdp.components.rods import END_STOP, PLUNGER, ROD_FRICTION, SPRING
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.cylinder import Plunger
from vvdp.hydraulics.friction import RodFriction
from vvdp.hydraulics.rod import EndStop, Spring
from vvdp.network.network import Network
from vvdp.network.nodes import Chamber, Source, Start


@dataclass(frozen=True)
class ChamberDrive:
    """A chamber against a spring, with its valve and an oil of its own, and where it starts [Pa absolute, m].

    `chamber` is the volume at position 0; what the piston sweeps comes on top.
    """

    piston: Plunger
    spring: Spring
    friction: RodFriction
    stops: EndStop
    valve: ThreeWayProportionalValve
    chamber: Chamber
    oil: Oil
    pressure: Start
    position: Start


@dataclass(frozen=True)
class PilotJoints:
    """Sources that feed a chamber drive and move its valve: signals, states or commands [Pa absolute, 1]."""

    supply_pressure: Signal
    tank_pressure: Signal
    command: Source


def add_chamber_drive(net: Network, drive: ChamberDrive, joints: PilotJoints, prefix: str = "") -> str:
    """Add a chamber drive to a network; `prefix` goes before its names where there are several.

    Its nodes are `pilot_supply`, `pilot_tank`, `pilot_chamber` and `slide`, its components `pilot_valve`,
    `axial_piston`, `axial_spring`, `axial_friction` and `axial_stops`.
    """
    supply, tank, chamber, slide = (prefix + n for n in ("pilot_supply", "pilot_tank", "pilot_chamber", "slide"))
    net.pressure_source(supply, joints.supply_pressure, oil=drive.oil)
    net.tank(tank, joints.tank_pressure, oil=drive.oil)
    net.volume(chamber, drive.chamber, start=drive.pressure, oil=drive.oil)
    net.rod(slide, position=drive.position)
    net.add(
        prefix + "pilot_valve",
        THREE_WAY_PROPORTIONAL_VALVE,
        drive.valve,
        pressure=supply,
        tank=tank,
        a=chamber,
        command=joints.command,
    )
    net.add(prefix + "axial_piston", PLUNGER, drive.piston, a=chamber, rod=slide)
    net.add(prefix + "axial_spring", SPRING, drive.spring, rod=slide)
    net.add(prefix + "axial_friction", ROD_FRICTION, drive.friction, rod=slide)
    net.add(prefix + "axial_stops", END_STOP, drive.stops, rod=slide)
    return f"{slide}.position"


def check_stroke(asked_by: str, wanted: float, stops: EndStop) -> None:
    """Refuse, with a ParameterError, a stroke that a stop ends.

    asked_by  the value that asks for it, such as "stroke.highest_position"
    wanted    highest position that is asked for [m]
    """
    if wanted > stops.upper_end:
        raise ParameterError(
            f"{asked_by}: {1e3 * wanted:.4g} mm; the end stop ends the stroke at {1e3 * stops.upper_end:.4g} mm"
        )
