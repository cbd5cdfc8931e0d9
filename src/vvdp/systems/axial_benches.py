"""The axial drives of a spool on their own: drive, sensor, and a spool that is turned at a prescribed speed.

The functions that return a `Network` are what a system file names as its circuit; their arguments are its tables.
"""

from typing import TypeVar

from vvdp.base.errors import ParameterError
from vvdp.base.signal import map_signal
from vvdp.components.axial_drive import (
    ChamberDrive,
    PilotJoints,
    add_chamber_drive,
    add_gerotor_drive,
    check_reach,
)
from vvdp.components.directional_valves import ThreeWayProportionalValve
from vvdp.components.library import UsualOil
from vvdp.control.backstepping import BacksteppingGains
from vvdp.control.passivity import PassivityGains
from vvdp.control.reference import ReferenceFilter
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.cylinder import Plunger
from vvdp.hydraulics.friction import RodFriction
from vvdp.hydraulics.gerotor_drive import GerotorCalibration, GerotorDrive, GerotorMap
from vvdp.hydraulics.rod import EndStop, Spring
from vvdp.network.network import Network
from vvdp.network.nodes import Chamber
from vvdp.programs.axial_loop import PROGRAM, AxialObserverTable, AxialSequence
from vvdp.programs.axial_sensor import AxialSensorTable, add_axial_sensor
from vvdp.programs.gerotor_loop import DriveBelief, GerotorSequence
from vvdp.systems.axial_control import (
    AxialControl,
    add_chamber_control,
    add_drive,
    chamber_loop,
    chosen_law,
)
from vvdp.systems.axial_numbers import AxialLoop, ChamberReach
from vvdp.systems.axial_tables import (
    AxialStroke,
    ChamberOperation,
    ControlledChamber,
    ControlledGerotor,
    GerotorOperation,
    InitialChamber,
    InitialPosition,
    PilotSupply,
)
from vvdp.systems.chamber_feedback import RawFeedback, TrueFeedback
from vvdp.systems.gerotor_control import (
    ClockedTable,
    GeneratorTable,
    GerotorTables,
    LumpedTable,
    ObserverTable,
    PIGains,
    add_gerotor_control,
)
from vvdp.systems.gerotor_numbers import GerotorHeld

Given = TypeVar("Given")


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
    operation: ControlledChamber | ChamberOperation,
    initial: InitialChamber,
    axial_observer: AxialObserverTable | None = None,
    axial_reference: ReferenceFilter | None = None,
    axial_sequence: AxialSequence | None = None,
    passivity: PassivityGains | None = None,
    printed_passivity: PassivityGains | None = None,
    backstepping: BacksteppingGains | None = None,
    raw_feedback: RawFeedback | None = None,
    true_feedback: TrueFeedback | None = None,
    believed_oil: Oil | None = None,
) -> Network:
    """One pressure chamber against a spring: its valve on a prescribed command, or controlled to a duty ratio."""
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
    check_reach("stroke.highest_position", stroke.highest_position, pilot.supply_pressure.extremes[0], drive)
    net = Network(pilot_oil, temperature=operation.oil_temperature, operation=operation, pilot=pilot, initial=initial)
    net.driven_shaft("spool", operation.spool_speed)
    if isinstance(operation, ChamberOperation):
        net.extras = ChamberReach
        joints = PilotJoints(pilot.supply_pressure, pilot.tank_pressure, operation.command)
        add_axial_sensor(net, add_chamber_drive(net, drive, joints), "spool", axial_sensor)
        return net
    net.extras = AxialLoop
    add_drive(net, drive, pilot)
    control = AxialControl(
        sensor=axial_sensor,
        observer=_require("axial_observer", axial_observer),
        law=chosen_law(passivity, printed_passivity, backstepping),
        reference=_require("axial_reference", axial_reference),
        sequence=_require("axial_sequence", axial_sequence),
        helix_length=stroke.helix_length,
        wanted=map_signal(operation.duty_ratio, lambda d: d * stroke.helix_length),
        feedback=_feedback(raw_feedback, true_feedback),
        oil=believed_oil,
    )
    add_chamber_control(net, control, chamber_loop(control, drive, pilot), "spool")
    return net


def _require(name: str, table: Given | None) -> Given:
    if table is None:
        raise ParameterError(f"table {name!r} is missing; a duty ratio is held by an observer, a reference and a law")
    return table


def _feedback(raw: RawFeedback | None, true: TrueFeedback | None) -> RawFeedback | TrueFeedback | None:
    """What the law is told in the observer's place, if anything."""
    if raw is not None and true is not None:
        raise ParameterError("expected at most one of the tables [raw_feedback] and [true_feedback]")
    return raw or true


def axial_gerotor(
    gerotor: GerotorDrive,
    characteristic: GerotorMap | GerotorCalibration,
    stroke: AxialStroke,
    axial_sensor: AxialSensorTable,
    operation: ControlledGerotor | GerotorOperation,
    initial: InitialPosition,
    axial_observer: AxialObserverTable | ClockedTable | LumpedTable | GeneratorTable | None = None,
    calibration: DriveBelief | None = None,
    position_control: PIGains | None = None,
    axial_reference: ReferenceFilter | None = None,
    axial_sequence: GerotorSequence | None = None,
) -> Network:
    """A gerotor pump between both ends of the spool: on a prescribed command, or controlled to a duty ratio."""
    net = Network(UsualOil(), operation=operation)
    net.driven_shaft("spool", operation.spool_speed)
    if isinstance(operation, GerotorOperation):
        position = add_gerotor_drive(net, gerotor, characteristic, operation.command, initial.axial_position)
        add_axial_sensor(net, position, "spool", axial_sensor)
        return net
    net.extras = GerotorHeld
    observer: ObserverTable = _require("axial_observer", axial_observer)  # type: ignore[assignment]
    add_gerotor_drive(net, gerotor, characteristic, f"{PROGRAM}.drive", initial.axial_position)
    tables = GerotorTables(
        sensor=axial_sensor,
        observer=observer,
        gains=_require("position_control", position_control),
        calibration=_require("calibration", calibration),
        reference=_require("axial_reference", axial_reference),
        sequence=_require("axial_sequence", axial_sequence),
        helix_length=stroke.helix_length,
        wanted=map_signal(operation.duty_ratio, lambda d: d * stroke.helix_length),
    )
    add_gerotor_control(net, tables, gerotor, "spool")
    return net
