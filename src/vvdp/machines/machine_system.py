"""The whole machine with its control: what system files name as their circuit, each with a record of its tables."""

from dataclasses import dataclass, fields, replace
from typing import Any

from vvdp.base.signal import constant
from vvdp.control.adaptation import Adaptation
from vvdp.control.capacities import CylinderEnds
from vvdp.control.cylinder_force import ForceGains
from vvdp.control.direction import DirectionSettings
from vvdp.control.displacement import SupplySupport
from vvdp.control.flow_gain import FlowGain
from vvdp.control.flow_map import FlowMap
from vvdp.control.flow_split import FlowSplit
from vvdp.control.passivity import PassivityGains
from vvdp.control.pressure_modes import PressureBounds
from vvdp.control.reference import ReferenceFilter
from vvdp.fluid.oil import density
from vvdp.hydraulics.rod import weight_force
from vvdp.machines.axial_control import AxialControl, chamber_loop, chosen_law
from vvdp.machines.axial_records import GerotorControlTables, SpoolControlTables
from vvdp.machines.cycle import OwnCycle, Triangle, fastest, refuse_fast_points
from vvdp.machines.flow_table import flow_map_of, valve_condition
from vvdp.machines.gerotor_control import control_values, periodic_observer
from vvdp.machines.machine import (
    OUTER,
    GerotorPlant,
    MachineHydraulics,
    SpringPlant,
    gerotor_plant,
    led_commands,
    spring_plant,
)
from vvdp.machines.machine_checks import (
    CylinderDuty,
    WorkingPressures,
    refuse_load,
    refuse_precharge,
    working_pressures,
)
from vvdp.machines.machine_control import (
    CylinderSensors,
    LoadObserverTable,
    MachineBelief,
    MachinePaths,
    MachineTables,
    add_led_drive,
    add_outer_loop,
    machine_loop,
)
from vvdp.machines.machine_extras import MachineExtras
from vvdp.machines.machine_loop import SpoolRange
from vvdp.machines.machine_tally import add_machine_tally
from vvdp.machines.stages import MachineSequence
from vvdp.machines.supervision import NO_SPRING, SpoolSpring, Supervision
from vvdp.network.network import Network
from vvdp.programs.chamber_loop import PassiveLoop
from vvdp.programs.gerotor_loop import GerotorLoop
from vvdp.programs.position_loop import LoopTable
from vvdp.programs.spool_encoder import watch_settings

HIGHEST_DUTY = 1.3
"""Duty ratio at which the spool's stroke ends: all flow goes to the line, free of transitions."""


@dataclass(frozen=True, kw_only=True)
class OuterTables:
    """The outer loop: cycle, laws, what they believe, sensors, stages."""

    cycle: Triangle | OwnCycle
    reference: ReferenceFilter
    gains: ForceGains
    direction: DirectionSettings
    flow_split: FlowSplit
    pressure_bounds: PressureBounds
    supply_support: SupplySupport
    flow_gain: FlowGain
    belief: MachineBelief
    load_observer: LoadObserverTable
    cylinder_sensors: CylinderSensors
    machine_sequence: MachineSequence
    adaptation: Adaptation | None = None
    supervision: Supervision | None = None


@dataclass(frozen=True, kw_only=True)
class ControlledMachine(OuterTables, MachineHydraulics):
    """A machine under displacement control."""


@dataclass(frozen=True, kw_only=True)
class SpringMachineTables(ControlledMachine, SpoolControlTables, SpringPlant):
    """The machine under displacement control, its spool moved by a chamber against a spring.

    With a `loop` the position loop of the rival circuits leads it in place of the laws of chapter 6.
    """

    passivity: PassivityGains
    loop: LoopTable | None = None

    @property
    def spool_spring(self) -> SpoolSpring:
        """The spring of the spool, for the supervision."""
        spring = self.axial_spring
        return SpoolSpring(
            stiffness=spring.stiffness,
            preload=spring.preload - spring.stiffness * spring.rest_position,
            area=self.axial_piston.area_a,
            reference_pressure=self.pilot_oil.reference_pressure,
        )


@dataclass(frozen=True, kw_only=True)
class GerotorMachineTables(ControlledMachine, GerotorControlTables, GerotorPlant):
    """The machine under displacement control, its spool moved by a gerotor pump."""


def spring_machine(tables: SpringMachineTables) -> Network:
    """The machine under displacement control, its spool moved by a chamber against a spring."""
    net = spring_plant(tables, led_commands(OUTER))
    length = tables.valve.helix_length
    spool = SpoolRange(
        helix_length=length,
        rest_position=tables.axial_stops.lower_end,
        highest_position=HIGHEST_DUTY * length,
        sections=tables.valve.sections,
    )
    control = AxialControl(
        sensor=tables.axial_sensor,
        observer=tables.axial_observer,
        law=chosen_law(tables.passivity),
        reference=tables.axial_reference,
        sequence=tables.axial_sequence,
        helix_length=length,
        wanted=constant(spool.highest_position),
        asked_by="axial_stops.upper_end",
    )
    inner = chamber_loop(control, tables.drive, tables.pilot)
    assert isinstance(inner, PassiveLoop)
    paths = _paths("slide.position", "pilot_chamber.pressure")
    _add_outer(net, tables, spool, paths, tables.spool_spring, tables.loop)
    _add_inner(net, tables, inner, paths)
    return net


def gerotor_machine(tables: GerotorMachineTables) -> Network:
    """The same with a gerotor pump that moves the spool, and a dump valve that empties the line when all is off."""
    net = gerotor_plant(tables, led_commands(OUTER))
    length, gerotor = tables.valve.helix_length, tables.gerotor
    spool = SpoolRange(
        helix_length=length,
        rest_position=gerotor.lower_end,
        highest_position=min(HIGHEST_DUTY * length, gerotor.upper_end),
        sections=tables.valve.sections,
    )
    control = tables.control(length, constant(spool.highest_position))
    observer = periodic_observer(tables.axial_observer, gerotor, length)
    inner = GerotorLoop(observer=observer, **control_values(control, gerotor))
    paths = _paths("gerotor.position")
    _add_outer(net, tables, spool, paths, NO_SPRING)
    _add_inner(net, tables, inner, paths)
    return net


def _add_inner(
    net: Network,
    tables: SpringMachineTables | GerotorMachineTables,
    inner: PassiveLoop | GerotorLoop,
    paths: MachinePaths,
) -> None:
    """Add the program of the axial drive, which an encoder watches, and the tally."""
    add_led_drive(net, inner, watch_settings(tables.encoder, tables.spool_filter, tables.initial.spool_angle), paths)
    add_machine_tally(net, paths, tables.operation.tank_pressure.extremes[1])
    net.extras = MachineExtras


def _paths(spool_position: str, chamber_pressure: str = "") -> MachinePaths:
    return MachinePaths(
        position="rod.position",
        pressure_a="chamber_a.pressure",
        pressure_b="chamber_b.pressure",
        line_pressure="line.pressure",
        spool="spool",
        spool_position=spool_position,
        chamber_pressure=chamber_pressure,
    )


def _add_outer(
    net: Network,
    tables: ControlledMachine,
    spool: SpoolRange,
    paths: MachinePaths,
    spring: SpoolSpring,
    table: LoopTable | None = None,
) -> None:
    """Add the program of the outer loop, with what its tables say and believe."""
    own: dict[str, Any] = {field.name: getattr(tables, field.name, None) for field in fields(MachineTables)}
    outer = MachineTables(**own | {"adaptation": tables.adaptation or Adaptation(), "spool_spring": spring})
    cylinder, stops = tables.cylinder, tables.cylinder_stops
    ends = CylinderEnds(
        area_a=cylinder.area_a,
        area_b=cylinder.area_b,
        lowest_position=stops.lower_end,
        highest_position=stops.upper_end,
    )
    tank = tables.operation.tank_pressure.extremes[1]
    check_demands(tables, tank)
    loop = machine_loop(outer, ends, spool, believed_map(tables), tank)
    add_outer_loop(net, loop, tables.cylinder_sensors, paths, table)


def check_demands(tables: ControlledMachine, tank_pressure: float) -> None:
    """Raises ParameterError where the cycle is faster than the pump, the load takes more than the relief valve allows
    with the return fully open, or the accumulator is charged above all pressures at which the line is to work.

    tank_pressure  absolute [Pa]
    """
    cylinder = tables.cylinder
    flow = tables.pump.displacement * tables.operation.pump_speed.extremes[1]
    refuse_fast_points(tables.cycle, flow / max(cylinder.area_a, cylinder.area_b))
    least, greatest = tables.operation.load_force.extremes
    if tables.weight is not None:
        pull = weight_force(tables.weight)
        least, greatest = least + pull, greatest + pull
    speed = fastest(tables.cycle)

    def pressures(opening: float) -> WorkingPressures:
        duty = CylinderDuty(least, greatest, speed, opening)
        return working_pressures(duty, cylinder, tables.cylinder_friction, tables.directional_valve)

    refuse_load(pressures(1.0), tables.relief_valve, tank_pressure)
    support = tables.supply_support
    supported = support.support_pressure - tank_pressure if support.support_conductance > 0.0 else 0.0
    refuse_precharge(max(*pressures(tables.flow_split.mean_opening), supported), tables.line, tank_pressure)


def believed_map(tables: ControlledMachine) -> FlowMap:
    """The flow map of the valve, with the relief valve as it is believed to be set."""
    pump, operation = tables.pump, tables.operation
    relief = replace(tables.relief_valve, cracking_pressure=tables.belief.relief_pressure)
    at = valve_condition(
        pump.displacement * operation.pump_speed.base,
        density(operation.oil_temperature.base, tables.oil),
        operation.tank_pressure.base,
        pump,
        relief,
    )
    return flow_map_of(tables.valve, at)
