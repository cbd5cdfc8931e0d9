"""The tables of an axial drive and of its control as records, for circuits that have both."""

from dataclasses import dataclass

from vvdp.base.signal import Signal
from vvdp.components.axial_drive import ChamberDrive
from vvdp.components.directional_valves import ThreeWayProportionalValve
from vvdp.control.reference import ReferenceFilter
from vvdp.estimation.event_settings import EventFilterValues
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.cylinder import Plunger
from vvdp.hydraulics.friction import RodFriction
from vvdp.hydraulics.gerotor_drive import GerotorCalibration, GerotorDrive, GerotorMap
from vvdp.hydraulics.rod import EndStop, Spring
from vvdp.machines.axial_tables import PilotSupply
from vvdp.machines.gerotor_control import GerotorTables, PIGains
from vvdp.network.nodes import Chamber
from vvdp.programs.axial_loop import AxialObserverTable, AxialSequence
from vvdp.programs.axial_sensor import AxialSensorTable
from vvdp.programs.gerotor_loop import DriveBelief, GerotorSequence
from vvdp.programs.spool_encoder import EncoderTable


@dataclass(frozen=True, kw_only=True)
class ChamberDriveTables:
    """A chamber that moves a spool against a spring, with its pilot supply."""

    pilot_oil: Oil
    axial_piston: Plunger
    axial_spring: Spring
    axial_friction: RodFriction
    axial_stops: EndStop
    pilot_valve: ThreeWayProportionalValve
    pilot_chamber: Chamber
    pilot: PilotSupply

    @property
    def drive(self) -> ChamberDrive:
        """The drive, which starts where the table [initial] says."""
        return ChamberDrive(
            piston=self.axial_piston,
            spring=self.axial_spring,
            friction=self.axial_friction,
            stops=self.axial_stops,
            valve=self.pilot_valve,
            chamber=self.pilot_chamber,
            oil=self.pilot_oil,
            pressure="initial.chamber_pressure",
            position="initial.axial_position",
        )


@dataclass(frozen=True, kw_only=True)
class GerotorDriveTables:
    """A gerotor pump that moves a spool."""

    gerotor: GerotorDrive
    characteristic: GerotorMap | GerotorCalibration


@dataclass(frozen=True, kw_only=True)
class SpoolControlTables:
    """What the control of a spool has with any drive."""

    axial_sensor: AxialSensorTable
    axial_observer: AxialObserverTable
    axial_reference: ReferenceFilter
    axial_sequence: AxialSequence
    encoder: EncoderTable
    spool_filter: EventFilterValues


@dataclass(frozen=True, kw_only=True)
class GerotorControlTables(SpoolControlTables, GerotorDriveTables):
    """A gerotor pump that moves a spool, with its control."""

    axial_sequence: GerotorSequence
    calibration: DriveBelief
    position_control: PIGains

    def control(self, helix_length: float, wanted: Signal) -> GerotorTables:
        """The control of the drive: length of the helix [m], and the position that is asked for [m]."""
        return GerotorTables(
            sensor=self.axial_sensor,
            observer=self.axial_observer,
            gains=self.position_control,
            calibration=self.calibration,
            reference=self.axial_reference,
            sequence=self.axial_sequence,
            helix_length=helix_length,
            wanted=wanted,
        )
