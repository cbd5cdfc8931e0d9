"""The whole machine: fixed pump, spinning rotary valve, line, directional valve, cylinder and throttled return.

The functions that return a `Network` are what a system file names as its circuit; their arguments are its tables.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from vvdp.components.axial_drive import ChamberDrive, PilotJoints, add_chamber_drive, add_gerotor_drive
from vvdp.components.controlled_valves import DUMP_VALVE
from vvdp.components.directional_valves import (
    THROTTLED_DIRECTIONAL_VALVE,
    ThreeWayProportionalValve,
    ThrottledDirectionalValve,
)
from vvdp.components.lagging_drive import LAGGING_DRIVE, LaggingDrive, LaggingState
from vvdp.components.meters import ACTUATOR_METER, SUPPLY_METER, TRANSITION_METER
from vvdp.components.pump_motors import PUMP_MOTOR
from vvdp.components.pump_unit import PumpUnit, UnitJoints, add_pump_unit
from vvdp.components.rods import WEIGHT
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.check_valve import CheckPoppet
from vvdp.hydraulics.cylinder import Cylinder, Plunger
from vvdp.hydraulics.friction import RodFriction
from vvdp.hydraulics.gerotor_drive import GerotorCalibration, GerotorDrive, GerotorMap
from vvdp.hydraulics.pump import Pump
from vvdp.hydraulics.pump_motor import PumpMotor
from vvdp.hydraulics.relief_valve import ReliefValve
from vvdp.hydraulics.rod import EndStop, Spring, Weight
from vvdp.hydraulics.seat_valve import SeatValve
from vvdp.hydraulics.spool_drive import SpoolDrive
from vvdp.hydraulics.volume import Vessel
from vvdp.network.network import Network
from vvdp.network.nodes import Chamber, Connection, Load, Source
from vvdp.programs.axial_loop import PROGRAM as AXIAL
from vvdp.systems.axial_tables import PilotSupply
from vvdp.systems.bench_tables import Limits
from vvdp.systems.displacement.cylinder_load import LoadedCylinder, add_cylinder
from vvdp.systems.displacement.machine_checks import refuse_stops
from vvdp.systems.displacement.machine_tables import (
    InitialGerotorMachine,
    InitialMachine,
    InitialSpringMachine,
    MachineOperation,
    PrescribedCommands,
)
from vvdp.systems.rotary_bench import cavitation_limit, pump_unit
from vvdp.valve.rotary import RotaryValve

OUTER = "displacement"
"""Name of the program that leads all drives."""


NO_MORE = Load(mass=0.0)
"""What moves with the rod beside the cylinder's own moving mass and a weight."""


@dataclass(frozen=True)
class MachineParts:
    """What all machines have: pump unit and motor, line, valve, cylinder; a weight and a dump valve if any."""

    unit: PumpUnit
    motor: PumpMotor
    line: Vessel
    directional_valve: ThrottledDirectionalValve
    loaded: LoadedCylinder
    weight: Weight | None = None
    dump_valve: SeatValve | None = None


@dataclass(frozen=True)
class MachineCommands:
    """Where each drive gets its command: a signal, or the path of a program's command."""

    direction: Source
    opening: Source
    pump: Source
    dump: Source
    drive: Source
    spool_position: Source


def led_commands(program: str) -> MachineCommands:
    """The commands of the outer loop's program, and that of the axial drive."""
    return MachineCommands(
        direction=f"{program}.direction",
        opening=f"{program}.opening",
        pump=f"{program}.pump",
        dump=f"{program}.dump",
        drive=f"{AXIAL}.drive",
        spool_position=f"{program}.spool_position",
    )


def prescribed_commands(table: PrescribedCommands) -> MachineCommands:
    """The commands that a table prescribes."""
    return MachineCommands(
        direction=table.direction,
        opening=table.opening,
        pump=table.pump,
        dump=table.dump,
        drive=table.drive,
        spool_position=table.spool_position,
    )


def shared_parts(tables: Mapping[str, Any]) -> MachineParts:
    """What all machines have, from the tables of a system by name."""
    unit = pump_unit(
        pump=tables["pump"],
        inlet=tables["inlet"],
        relief_valve=tables["relief_valve"],
        valve=tables["valve"],
        spool_drive=tables["spool_drive"],
        check_valve=tables["check_valve"],
    )
    loaded = LoadedCylinder(
        cylinder=tables["cylinder"],
        chamber_a=tables["chamber_a"],
        chamber_b=tables["chamber_b"],
        load=NO_MORE,
        friction=tables["cylinder_friction"],
        end_stops=tables["cylinder_stops"],
    )
    return MachineParts(
        unit=unit,
        motor=tables["motor"],
        line=tables["line"],
        directional_valve=tables["directional_valve"],
        loaded=loaded,
        weight=tables["weight"],
        dump_valve=tables["dump_valve"],
    )


def add_machine(net: Network, parts: MachineParts, commands: MachineCommands, spool: Source) -> None:
    """Add everything but the axial drive; `spool` is the path of the position that it gives the spool.

    The nodes are `line`, `chamber_a`, `chamber_b` and `rod` beside those of a pump unit, the components `pump_motor`,
    `directional_valve`, those of the cylinder, and what is fitted of `weight` and `dump_valve`; and meters.
    """
    values = net.values
    operation: MachineOperation = values["operation"]  # type: ignore[assignment]
    net.volume("line", parts.line, start="initial.line_pressure")
    net.add("pump_motor", PUMP_MOTOR, parts.motor, command=commands.pump, rated_speed=operation.pump_speed)
    joints = UnitJoints(
        tank="tank",
        load="line",
        pump_speed="pump_motor.speed",
        axial_position=spool,
        spool_motor_speed=operation.spool_motor_speed,
        cavitation_pressure=Connection(cavitation_limit, (values["limits"],)),
    )
    add_pump_unit(net, parts.unit, joints)
    net.add(
        "transition_meter",
        TRANSITION_METER,
        parts.unit.valve,
        inlet="inlet",
        to_load="valve.load_flow",
        to_tank="valve.tank_flow",
        leakage="valve.leakage",
        load_opening="valve.load_opening",
        tank_opening="valve.tank_opening",
    )
    add_actuator(net, parts, commands, operation)
    if parts.dump_valve is not None:
        net.add("dump_valve", DUMP_VALVE, parts.dump_valve, a="line", b="tank", command=commands.dump)


def add_actuator(net: Network, parts: MachineParts, commands: MachineCommands, operation: MachineOperation) -> None:
    """Add directional valve, cylinder and load between line and tank, with the meters of their powers."""
    refuse_stops(parts.loaded.cylinder, parts.loaded.end_stops)
    add_cylinder(net, parts.loaded, operation.load_force, "cylinder_position")
    if parts.weight is not None:
        net.add("weight", WEIGHT, parts.weight, rod="rod")
    net.add(
        "directional_valve",
        THROTTLED_DIRECTIONAL_VALVE,
        parts.directional_valve,
        pressure="line",
        tank="tank",
        a="chamber_a",
        b="chamber_b",
        command=commands.direction,
        return_command=commands.opening,
    )
    to_a, to_b = "directional_valve.a_flow", "directional_valve.b_flow"
    net.add("supply_meter", SUPPLY_METER, a="chamber_a", b="chamber_b", to_a=to_a, to_b=to_b)
    net.add("actuator_meter", ACTUATOR_METER, rod="rod", force="cylinder.rod")


def new_machine(
    oil: Oil, operation: MachineOperation, initial: InitialMachine, limits: Limits, pilot: PilotSupply | None = None
) -> Network:
    """The network of a machine with its tank, before anything else is drawn."""
    shared = {} if pilot is None else {"pilot": pilot}
    net = Network(
        oil,
        temperature=operation.oil_temperature,
        operation=operation,
        initial=initial,
        limits=limits,
        **shared,
    )
    net.tank("tank", operation.tank_pressure)
    return net


def displacement_control(
    oil: Oil,
    pump: Pump,
    motor: PumpMotor,
    inlet: Chamber,
    relief_valve: ReliefValve,
    valve: RotaryValve,
    spool_drive: SpoolDrive,
    check_valve: CheckPoppet,
    line: Vessel,
    directional_valve: ThrottledDirectionalValve,
    cylinder: Cylinder,
    chamber_a: Vessel,
    chamber_b: Vessel,
    cylinder_friction: RodFriction,
    cylinder_stops: EndStop,
    pilot_oil: Oil,
    axial_piston: Plunger,
    axial_spring: Spring,
    axial_friction: RodFriction,
    axial_stops: EndStop,
    pilot_valve: ThreeWayProportionalValve,
    pilot_chamber: Chamber,
    pilot: PilotSupply,
    operation: MachineOperation,
    initial: InitialSpringMachine,
    limits: Limits,
    weight: Weight | None = None,
    dump_valve: SeatValve | None = None,
    prescribed: PrescribedCommands | None = None,
) -> Network:
    """The machine whose spool a chamber moves against a spring."""
    tables = locals()
    axial = ChamberDrive(
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
    net = new_machine(oil, operation, initial, limits, pilot)
    commands = prescribed_commands(prescribed) if prescribed is not None else led_commands(OUTER)
    spool = add_chamber_drive(net, axial, PilotJoints(pilot.supply_pressure, pilot.tank_pressure, commands.drive))
    add_machine(net, shared_parts(tables), commands, spool)
    return net


def displacement_control_gerotor(
    oil: Oil,
    pump: Pump,
    motor: PumpMotor,
    inlet: Chamber,
    relief_valve: ReliefValve,
    valve: RotaryValve,
    spool_drive: SpoolDrive,
    check_valve: CheckPoppet,
    line: Vessel,
    directional_valve: ThrottledDirectionalValve,
    cylinder: Cylinder,
    chamber_a: Vessel,
    chamber_b: Vessel,
    cylinder_friction: RodFriction,
    cylinder_stops: EndStop,
    gerotor: GerotorDrive,
    characteristic: GerotorMap | GerotorCalibration,
    operation: MachineOperation,
    initial: InitialGerotorMachine,
    limits: Limits,
    weight: Weight | None = None,
    dump_valve: SeatValve | None = None,
    prescribed: PrescribedCommands | None = None,
) -> Network:
    """The same with a gerotor pump that moves the spool, and a dump valve that empties the line when all is off."""
    tables = locals()
    net = new_machine(oil, operation, initial, limits)
    commands = prescribed_commands(prescribed) if prescribed is not None else led_commands(OUTER)
    spool = add_gerotor_drive(net, gerotor, characteristic, commands.drive, initial.axial_position)
    add_machine(net, shared_parts(tables), commands, spool)
    return net


def displacement_control_ideal(
    oil: Oil,
    pump: Pump,
    motor: PumpMotor,
    inlet: Chamber,
    relief_valve: ReliefValve,
    valve: RotaryValve,
    spool_drive: SpoolDrive,
    check_valve: CheckPoppet,
    line: Vessel,
    directional_valve: ThrottledDirectionalValve,
    cylinder: Cylinder,
    chamber_a: Vessel,
    chamber_b: Vessel,
    cylinder_friction: RodFriction,
    cylinder_stops: EndStop,
    axial_drive: LaggingDrive,
    operation: MachineOperation,
    initial: InitialGerotorMachine,
    limits: Limits,
    weight: Weight | None = None,
    dump_valve: SeatValve | None = None,
    prescribed: PrescribedCommands | None = None,
) -> Network:
    """The same with a spool that follows the wanted position with a lag, to tell what an axial drive costs."""
    tables = locals()
    net = new_machine(oil, operation, initial, limits)
    commands = prescribed_commands(prescribed) if prescribed is not None else led_commands(OUTER)
    state = LaggingState(initial.axial_position)
    net.add("spool_drive", LAGGING_DRIVE, axial_drive, start=state, wanted=commands.spool_position)
    add_machine(net, shared_parts(tables), commands, "spool_drive.position")
    return net
