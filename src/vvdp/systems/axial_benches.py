"""The axial drives of a spool on their own: drive, sensor, and a spool that is turned at a prescribed speed.

The functions that return a `Network` are what a system file names as its circuit; their arguments are its tables.
"""

from types import MappingProxyType

from vvdp.base.kinds import (
    DUTY_RATIO,
    POSITION,
    Length,
    Position,
    Pressure,
    PressureSignal,
    SignedFractionSignal,
    SpeedSignal,
    TemperatureSignal,
)
from vvdp.base.params import Params
from vvdp.components.axial_drive import (
    ChamberDrive,
    PilotJoints,
    add_chamber_drive,
    add_gerotor_drive,
    check_reach,
)
from vvdp.components.directional_valves import ThreeWayProportionalValve
from vvdp.components.library import UsualOil
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.chamber_drive import static_reach
from vvdp.hydraulics.cylinder import Plunger
from vvdp.hydraulics.friction import RodFriction
from vvdp.hydraulics.gerotor_drive import GerotorCalibration, GerotorDrive, GerotorMap
from vvdp.hydraulics.rod import EndStop, Spring
from vvdp.network.network import Network
from vvdp.network.nodes import Chamber
from vvdp.simulation.outcome import Outcome
from vvdp.systems.axial_sensor import AxialSensorTable, add_axial_sensor
from vvdp.systems.extras import Extras, Summary


class AxialStroke(Params):
    """Length of the helix, duty ratio 0 to 1, and between which positions the spool is to move."""

    helix_length: Length
    lowest_position: Position
    highest_position: Position


class PilotSupply(Params):
    """What feeds the chamber of an axial drive."""

    supply_pressure: PressureSignal
    tank_pressure: PressureSignal


class ChamberOperation(Params):
    """What is prescribed from outside: the valve's command, and how fast the spool is turned."""

    command: SignedFractionSignal
    spool_speed: SpeedSignal
    oil_temperature: TemperatureSignal


class GerotorOperation(Params):
    """What is prescribed from outside: the pump's command, and how fast the spool is turned."""

    command: SignedFractionSignal
    spool_speed: SpeedSignal


class InitialPosition(Params):
    """Where a run starts."""

    axial_position: Position


class InitialChamber(InitialPosition):
    """Where a run with a pressure chamber starts."""

    chamber_pressure: Pressure


class ChamberReach(Extras):
    """How far the supply of a chamber drive holds the spool against its spring."""

    QUANTITIES = MappingProxyType(
        {
            "axial_reach_m": (POSITION, "position that the pilot supply holds against the spring"),
            "duty_reach": (DUTY_RATIO, "duty ratio of the position that the pilot supply holds"),
        }
    )

    def simulation_numbers(self, run: Outcome, found: Summary) -> Summary:  # noqa: ARG002
        """The reach, and the duty ratio there, at the lowest pressure of the supply."""
        tables = self.tables
        pressure = tables["pilot"].supply_pressure.extremes[0]
        reference = tables["pilot_oil"].reference_pressure
        reach = static_reach(pressure, reference, tables["axial_piston"], tables["axial_spring"])
        reach = min(reach, tables["axial_stops"].upper_end)
        return {"axial_reach_m": reach, "duty_reach": reach / tables["stroke"].helix_length}


def axial_chamber(
    pilot_oil: Oil,
    axial_piston: Plunger,
    axial_spring: Spring,
    axial_friction: RodFriction,
    axial_stops: EndStop,
    pilot_valve: ThreeWayProportionalValve,
    pilot_chamber: Chamber,
    pilot: PilotSupply,
    stroke: AxialStroke,
    axial_sensor: AxialSensorTable,
    operation: ChamberOperation,
    initial: InitialChamber,
) -> Network:
    """One pressure chamber against a spring, its valve on a prescribed command."""
    drive = ChamberDrive(
        piston=axial_piston,
        spring=axial_spring,
        friction=axial_friction,
        stops=axial_stops,
        valve=pilot_valve,
        chamber=pilot_chamber,
        oil=pilot_oil,
        pressure="initial.chamber_pressure",
        position="initial.axial_position",
    )
    check_reach(stroke.highest_position, pilot.supply_pressure.extremes[0], drive)
    net = Network(pilot_oil, temperature=operation.oil_temperature, operation=operation, pilot=pilot, initial=initial)
    net.extras = ChamberReach
    net.driven_shaft("spool", operation.spool_speed)
    joints = PilotJoints(pilot.supply_pressure, pilot.tank_pressure, operation.command)
    add_axial_sensor(net, add_chamber_drive(net, drive, joints), "spool", axial_sensor)
    return net


def axial_gerotor(
    gerotor: GerotorDrive,
    characteristic: GerotorMap | GerotorCalibration,
    stroke: AxialStroke,
    axial_sensor: AxialSensorTable,
    operation: GerotorOperation,
    initial: InitialPosition,
) -> Network:
    """A gerotor pump between both ends of the spool, on a prescribed command."""
    net = Network(UsualOil(), operation=operation)
    net.driven_shaft("spool", operation.spool_speed)
    position = add_gerotor_drive(net, gerotor, characteristic, operation.command, initial.axial_position)
    add_axial_sensor(net, position, "spool", axial_sensor)
    return net
