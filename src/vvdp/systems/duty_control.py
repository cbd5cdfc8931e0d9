"""The pump unit whose duty ratio is held: a self-spinning rotary valve with its axial drive, encoder and control.

The functions that return a `Network` are what a system file names as its circuit; their arguments are its tables.
"""

from dataclasses import replace

from vvdp.base.signal import map_signal
from vvdp.components.axial_drive import ChamberDrive, add_gerotor_drive
from vvdp.components.directional_valves import ThreeWayProportionalValve
from vvdp.control.passivity import PassivityGains
from vvdp.control.reference import ReferenceFilter
from vvdp.estimation.event_settings import EventFilterValues
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.check_valve import CheckPoppet
from vvdp.hydraulics.cylinder import Plunger
from vvdp.hydraulics.friction import RodFriction
from vvdp.hydraulics.gerotor_drive import GerotorCalibration, GerotorDrive, GerotorMap
from vvdp.hydraulics.pump import Pump
from vvdp.hydraulics.relief_valve import ReliefValve
from vvdp.hydraulics.rod import EndStop, Spring
from vvdp.hydraulics.spool_drive import SpoolDrive
from vvdp.hydraulics.volume import Vessel
from vvdp.network.network import Network
from vvdp.network.nodes import Chamber
from vvdp.programs.axial_loop import PROGRAM, AxialObserverTable, AxialSequence
from vvdp.programs.axial_sensor import AxialSensorTable
from vvdp.programs.gerotor_loop import DriveBelief, GerotorSequence
from vvdp.programs.spool_encoder import EncoderTable, watch_settings
from vvdp.systems.axial_control import (
    AxialControl,
    add_drive,
    add_watched_control,
    chamber_loop,
    chosen_law,
)
from vvdp.systems.axial_tables import InitialChamber, InitialPosition, PilotSupply
from vvdp.systems.bench_tables import DriveMotor, DutyOperation, InitialBench, Limits, OrificeLoad
from vvdp.systems.chamber_feedback import RawFeedback
from vvdp.systems.duty_bench import DutyControl, GerotorDutyControl
from vvdp.systems.gerotor_control import GerotorTables, PIGains, add_watched_gerotor
from vvdp.systems.rotary_bench import join_load, joints, new_bench, pump_unit
from vvdp.valve.rotary import RotaryValve


class InitialDutyControl(InitialBench, InitialChamber):
    """Where a run starts."""


class InitialGerotorControl(InitialBench, InitialPosition):
    """Where a run starts."""


def duty_control(
    oil: Oil,
    pump: Pump,
    motor: DriveMotor,
    inlet: Chamber,
    relief_valve: ReliefValve,
    valve: RotaryValve,
    spool_drive: SpoolDrive,
    check_valve: CheckPoppet,
    load_line: Vessel,
    load: OrificeLoad,
    pilot_oil: Oil,
    axial_piston: Plunger,
    axial_spring: Spring,
    axial_friction: RodFriction,
    axial_stops: EndStop,
    pilot_valve: ThreeWayProportionalValve,
    pilot_chamber: Chamber,
    pilot: PilotSupply,
    axial_sensor: AxialSensorTable,
    axial_observer: AxialObserverTable,
    axial_reference: ReferenceFilter,
    axial_sequence: AxialSequence,
    encoder: EncoderTable,
    spool_filter: EventFilterValues,
    operation: DutyOperation,
    initial: InitialDutyControl,
    limits: Limits,
    passivity: PassivityGains | None = None,
    printed_passivity: PassivityGains | None = None,
    raw_feedback: RawFeedback | None = None,
) -> Network:
    """A pump unit with an orifice load; a chamber moves its spool against a spring, to the duty ratio that is asked."""
    unit = pump_unit(
        pump=pump,
        inlet=inlet,
        relief_valve=relief_valve,
        valve=valve,
        spool_drive=spool_drive,
        check_valve=check_valve,
    )
    net = new_bench(oil, unit, operation, load, initial, limits)
    net.extras = DutyControl
    join_load(net, unit, replace(joints(operation, valve, limits), axial_position="slide.position"), load_line, load)
    parts = ChamberDrive(
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
    control = AxialControl(
        sensor=axial_sensor,
        observer=axial_observer,
        law=chosen_law(passivity, printed_passivity),
        reference=axial_reference,
        sequence=axial_sequence,
        helix_length=valve.helix_length,
        wanted=map_signal(operation.duty_ratio, lambda d: d * valve.helix_length),
        feedback=raw_feedback,
    )
    add_drive(net, parts, pilot)
    loop = chamber_loop(control, parts, pilot)
    add_watched_control(net, control, loop, "spool", watch_settings(encoder, spool_filter, initial.spool_angle))
    return net


def duty_control_gerotor(
    oil: Oil,
    pump: Pump,
    motor: DriveMotor,
    inlet: Chamber,
    relief_valve: ReliefValve,
    valve: RotaryValve,
    spool_drive: SpoolDrive,
    check_valve: CheckPoppet,
    load_line: Vessel,
    load: OrificeLoad,
    gerotor: GerotorDrive,
    characteristic: GerotorMap | GerotorCalibration,
    calibration: DriveBelief,
    axial_sensor: AxialSensorTable,
    axial_observer: AxialObserverTable,
    position_control: PIGains,
    axial_reference: ReferenceFilter,
    axial_sequence: GerotorSequence,
    encoder: EncoderTable,
    spool_filter: EventFilterValues,
    operation: DutyOperation,
    initial: InitialGerotorControl,
    limits: Limits,
) -> Network:
    """The same with a gerotor pump that moves the spool."""
    unit = pump_unit(
        pump=pump,
        inlet=inlet,
        relief_valve=relief_valve,
        valve=valve,
        spool_drive=spool_drive,
        check_valve=check_valve,
    )
    net = new_bench(oil, unit, operation, load, initial, limits)
    net.extras = GerotorDutyControl
    join_load(net, unit, replace(joints(operation, valve, limits), axial_position="gerotor.position"), load_line, load)
    add_gerotor_drive(net, gerotor, characteristic, f"{PROGRAM}.drive", initial.axial_position)
    tables = GerotorTables(
        sensor=axial_sensor,
        observer=axial_observer,
        gains=position_control,
        calibration=calibration,
        reference=axial_reference,
        sequence=axial_sequence,
        helix_length=valve.helix_length,
        wanted=map_signal(operation.duty_ratio, lambda d: d * valve.helix_length),
    )
    add_watched_gerotor(net, tables, gerotor, "spool", watch_settings(encoder, spool_filter, initial.spool_angle))
    return net
