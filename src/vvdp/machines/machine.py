"""The whole machine: fixed pump, spinning rotary valve, line, directional valve, cylinder and throttled return.

The functions that return a `Network` are what a system file names as its circuit; the fields of their
argument are its tables.
"""

from dataclasses import dataclass

from vvdp.base.params import Params
from vvdp.components.axial_drive import PilotJoints, add_chamber_drive, add_gerotor_drive
from vvdp.components.controlled_valves import DUMP_VALVE
from vvdp.components.directional_valves import (
    THROTTLED_DIRECTIONAL_VALVE,
    ThrottledDirectionalValve,
)
from vvdp.components.lagging_drive import LAGGING_DRIVE, LaggingDrive, LaggingState
from vvdp.components.meters import ACTUATOR_METER, SUPPLY_METER, TRANSITION_METER
from vvdp.components.pump_motors import PUMP_MOTOR
from vvdp.components.pump_unit import UnitJoints, add_pump_unit
from vvdp.components.rods import WEIGHT
from vvdp.hydraulics.cylinder import Cylinder
from vvdp.hydraulics.friction import RodFriction
from vvdp.hydraulics.pump_motor import PumpMotor
from vvdp.hydraulics.rod import EndStop, Weight
from vvdp.hydraulics.seat_valve import SeatValve
from vvdp.hydraulics.volume import Vessel
from vvdp.machines.axial_records import ChamberDriveTables, GerotorDriveTables
from vvdp.machines.cylinder_load import LoadedCylinder, add_cylinder
from vvdp.machines.machine_checks import refuse_stops
from vvdp.machines.machine_tables import (
    InitialGerotorMachine,
    InitialMachine,
    InitialSpringMachine,
    MachineOperation,
    PrescribedCommands,
)
from vvdp.machines.rotary_bench import PumpUnitTables, cavitation_limit
from vvdp.network.network import Network
from vvdp.network.nodes import Connection, Load, Source
from vvdp.programs.axial_loop import PROGRAM as AXIAL
from vvdp.systems.bench_tables import Limits

OUTER = "displacement"
"""Name of the program that leads all drives."""


NO_MORE = Load(mass=0.0)
"""What moves with the rod beside the cylinder's own moving mass and a weight."""


@dataclass(frozen=True, kw_only=True)
class MachineHydraulics(PumpUnitTables):
    """What all machines have: pump unit and motor, line, valve, cylinder; a weight and a dump valve if any."""

    motor: PumpMotor
    line: Vessel
    directional_valve: ThrottledDirectionalValve
    cylinder: Cylinder
    chamber_a: Vessel
    chamber_b: Vessel
    cylinder_friction: RodFriction
    cylinder_stops: EndStop
    operation: MachineOperation
    initial: InitialMachine
    limits: Limits
    weight: Weight | None = None
    dump_valve: SeatValve | None = None

    @property
    def load(self) -> LoadedCylinder:
        """The cylinder with what holds it up."""
        return LoadedCylinder(
            cylinder=self.cylinder,
            chamber_a=self.chamber_a,
            chamber_b=self.chamber_b,
            load=NO_MORE,
            friction=self.cylinder_friction,
            end_stops=self.cylinder_stops,
        )


@dataclass(frozen=True, kw_only=True)
class SpringPlant(ChamberDriveTables, MachineHydraulics):
    """The machine whose spool a chamber moves against a spring."""

    initial: InitialSpringMachine


@dataclass(frozen=True, kw_only=True)
class GerotorPlant(GerotorDriveTables, MachineHydraulics):
    """The same with a gerotor pump that moves the spool, and a dump valve that empties the line when all is off."""

    initial: InitialGerotorMachine


@dataclass(frozen=True, kw_only=True)
class Led:
    """What every drive is commanded over time; without, the outer loop leads them."""

    prescribed: PrescribedCommands | None = None

    @property
    def commands(self) -> "MachineCommands":
        """Where each drive gets its command."""
        return led_commands(OUTER) if self.prescribed is None else prescribed_commands(self.prescribed)


@dataclass(frozen=True, kw_only=True)
class LedSpringPlant(Led, SpringPlant):
    """The machine with a chamber drive, whatever leads it."""


@dataclass(frozen=True, kw_only=True)
class LedGerotorPlant(Led, GerotorPlant):
    """The machine with a gerotor drive, whatever leads it."""


@dataclass(frozen=True, kw_only=True)
class LedIdealPlant(Led, MachineHydraulics):
    """The machine with a spool that follows with a lag, whatever leads it."""

    axial_drive: LaggingDrive
    initial: InitialGerotorMachine


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


def add_machine(net: Network, tables: MachineHydraulics, commands: MachineCommands, spool: Source) -> None:
    """Add everything but the axial drive; `spool` is the path of the position that it gives the spool.

    The nodes are `line`, `chamber_a`, `chamber_b` and `rod` beside those of a pump unit, the components `pump_motor`,
    `directional_valve`, those of the cylinder, and what is fitted of `weight` and `dump_valve`; and meters.
    """
    operation = tables.operation
    net.volume("line", tables.line, start="initial.line_pressure")
    net.add("pump_motor", PUMP_MOTOR, tables.motor, command=commands.pump, rated_speed=operation.pump_speed)
    joints = UnitJoints(
        tank="tank",
        load="line",
        pump_speed="pump_motor.speed",
        axial_position=spool,
        spool_motor_speed=operation.spool_motor_speed,
        cavitation_pressure=Connection(cavitation_limit, (tables.limits,)),
    )
    add_pump_unit(net, tables.unit, joints)
    net.add(
        "transition_meter",
        TRANSITION_METER,
        tables.valve,
        inlet="inlet",
        to_load="valve.load_flow",
        to_tank="valve.tank_flow",
        leakage="valve.leakage",
        load_opening="valve.load_opening",
        tank_opening="valve.tank_opening",
    )
    add_actuator(net, tables, commands)
    if tables.dump_valve is not None:
        net.add("dump_valve", DUMP_VALVE, tables.dump_valve, a="line", b="tank", command=commands.dump)


def add_actuator(net: Network, tables: MachineHydraulics, commands: MachineCommands) -> None:
    """Add directional valve, cylinder and load between line and tank, with the meters of their powers."""
    refuse_stops(tables.cylinder, tables.cylinder_stops)
    add_cylinder(net, tables.load, tables.operation.load_force, "cylinder_position")
    if tables.weight is not None:
        net.add("weight", WEIGHT, tables.weight, rod="rod")
    net.add(
        "directional_valve",
        THROTTLED_DIRECTIONAL_VALVE,
        tables.directional_valve,
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


def new_machine(tables: MachineHydraulics, **more: Params) -> Network:
    """The network of a machine with its tank, before anything else is drawn; `more` are values that inputs read."""
    net = Network(
        tables.oil,
        temperature=tables.operation.oil_temperature,
        operation=tables.operation,
        initial=tables.initial,
        limits=tables.limits,
        **more,
    )
    net.tank("tank", tables.operation.tank_pressure)
    return net


def spring_plant(tables: SpringPlant, commands: MachineCommands) -> Network:
    """The machine whose spool a chamber moves against a spring, its drives on commands."""
    net, pilot = new_machine(tables, pilot=tables.pilot), tables.pilot
    joints = PilotJoints(pilot.supply_pressure, pilot.tank_pressure, commands.drive)
    add_machine(net, tables, commands, add_chamber_drive(net, tables.drive, joints))
    return net


def gerotor_plant(tables: GerotorPlant, commands: MachineCommands) -> Network:
    """The machine whose spool a gerotor pump moves, its drives on commands."""
    net = new_machine(tables)
    position = tables.initial.axial_position
    spool = add_gerotor_drive(net, tables.gerotor, tables.characteristic, commands.drive, position)
    add_machine(net, tables, commands, spool)
    return net


def displacement_control(tables: LedSpringPlant) -> Network:
    """The machine whose spool a chamber moves against a spring."""
    return spring_plant(tables, tables.commands)


def displacement_control_gerotor(tables: LedGerotorPlant) -> Network:
    """The same with a gerotor pump that moves the spool, and a dump valve that empties the line when all is off."""
    return gerotor_plant(tables, tables.commands)


def displacement_control_ideal(tables: LedIdealPlant) -> Network:
    """The same with a spool that follows the wanted position with a lag, to show what an axial drive costs."""
    net, commands = new_machine(tables), tables.commands
    state = LaggingState(tables.initial.axial_position)
    net.add("spool_drive", LAGGING_DRIVE, tables.axial_drive, start=state, wanted=commands.spool_position)
    add_machine(net, tables, commands, "spool_drive.position")
    return net
