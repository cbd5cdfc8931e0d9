"""The pump unit whose duty ratio is held: a self-spinning rotary valve with its axial drive, encoder and control.

The functions that return a `Network` are what a system file names as its circuit; the fields of their
argument are its tables.
"""

from dataclasses import dataclass, replace

from vvdp.base.signal import map_signal
from vvdp.components.axial_drive import add_gerotor_drive
from vvdp.control.passivity import PassivityGains
from vvdp.machines.axial_control import (
    AxialControl,
    add_drive,
    add_watched_control,
    chamber_loop,
    chosen_law,
)
from vvdp.machines.axial_records import ChamberDriveTables, GerotorControlTables, SpoolControlTables
from vvdp.machines.axial_tables import InitialChamber, InitialPosition
from vvdp.machines.chamber_feedback import RawFeedback
from vvdp.machines.gerotor_control import add_watched_gerotor
from vvdp.machines.rotary_bench import OrificeBench, join_load, new_bench
from vvdp.network.network import Network
from vvdp.programs.axial_loop import PROGRAM
from vvdp.programs.spool_encoder import watch_settings
from vvdp.systems.bench_tables import DutyOperation, InitialBench


class InitialDutyControl(InitialBench, InitialChamber):
    """Where a run starts."""


class InitialGerotorControl(InitialBench, InitialPosition):
    """Where a run starts."""


@dataclass(frozen=True, kw_only=True)
class ChamberUnit(SpoolControlTables, ChamberDriveTables, OrificeBench):
    """A pump unit whose spool a chamber moves; one of the three tables of gains is given."""

    operation: DutyOperation
    initial: InitialDutyControl
    passivity: PassivityGains | None = None
    printed_passivity: PassivityGains | None = None
    raw_feedback: RawFeedback | None = None


@dataclass(frozen=True, kw_only=True)
class GerotorUnit(GerotorControlTables, OrificeBench):
    """A pump unit whose spool a gerotor pump moves."""

    operation: DutyOperation
    initial: InitialGerotorControl


def duty_control(tables: ChamberUnit) -> Network:
    """A pump unit with an orifice load; a chamber moves its spool against a spring, to the duty ratio that is asked."""
    length, drive, pilot = tables.valve.helix_length, tables.drive, tables.pilot
    net = new_bench(tables)
    join_load(net, tables, replace(tables.joints, axial_position="slide.position"))
    control = AxialControl(
        sensor=tables.axial_sensor,
        observer=tables.axial_observer,
        law=chosen_law(tables.passivity, tables.printed_passivity),
        reference=tables.axial_reference,
        sequence=tables.axial_sequence,
        helix_length=length,
        wanted=map_signal(tables.operation.duty_ratio, lambda d: d * length),
        feedback=tables.raw_feedback,
    )
    add_drive(net, drive, pilot)
    watch = watch_settings(tables.encoder, tables.spool_filter, tables.initial.spool_angle)
    add_watched_control(net, control, chamber_loop(control, drive, pilot), "spool", watch)
    return net


def duty_control_gerotor(tables: GerotorUnit) -> Network:
    """The same with a gerotor pump that moves the spool."""
    length = tables.valve.helix_length
    net = new_bench(tables)
    join_load(net, tables, replace(tables.joints, axial_position="gerotor.position"))
    add_gerotor_drive(net, tables.gerotor, tables.characteristic, f"{PROGRAM}.drive", tables.initial.axial_position)
    wanted = map_signal(tables.operation.duty_ratio, lambda d: d * length)
    watch = watch_settings(tables.encoder, tables.spool_filter, tables.initial.spool_angle)
    add_watched_gerotor(net, tables.control(length, wanted), tables.gerotor, "spool", watch)
    return net
