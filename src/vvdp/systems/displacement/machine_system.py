"""The whole machine with its control: what system files name as their circuit; their tables are the arguments."""

from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from inspect import signature
from typing import Any

from vvdp.base.signal import constant
from vvdp.components.axial_drive import ChamberDrive
from vvdp.components.directional_valves import ThreeWayProportionalValve, ThrottledDirectionalValve
from vvdp.control.adaptation import Adaptation
from vvdp.control.cylinder_force import ForceGains
from vvdp.control.direction import DirectionSettings
from vvdp.control.displacement import SupplySupport
from vvdp.control.flow_gain import FlowGain
from vvdp.control.flow_map import FlowMap
from vvdp.control.flow_split import FlowSplit
from vvdp.control.passivity import PassivityGains
from vvdp.control.pressure_modes import PressureBounds
from vvdp.control.reference import ReferenceFilter
from vvdp.estimation.event_settings import EventFilterValues
from vvdp.fluid.oil import Oil, density
from vvdp.hydraulics.check_valve import CheckPoppet
from vvdp.hydraulics.cylinder import Cylinder, Plunger
from vvdp.hydraulics.friction import RodFriction
from vvdp.hydraulics.gerotor_drive import GerotorCalibration, GerotorDrive, GerotorMap
from vvdp.hydraulics.pump import Pump
from vvdp.hydraulics.pump_motor import PumpMotor
from vvdp.hydraulics.relief_valve import ReliefValve
from vvdp.hydraulics.rod import EndStop, Spring, Weight, weight_force
from vvdp.hydraulics.seat_valve import SeatValve
from vvdp.hydraulics.spool_drive import SpoolDrive
from vvdp.hydraulics.volume import Vessel
from vvdp.network.network import Network
from vvdp.network.nodes import Chamber
from vvdp.programs.axial_loop import AxialObserverTable, AxialSequence
from vvdp.programs.axial_sensor import AxialSensorTable
from vvdp.programs.chamber_loop import PassiveLoop
from vvdp.programs.gerotor_loop import DriveBelief, GerotorLoop, GerotorSequence
from vvdp.programs.spool_encoder import EncoderTable, watch_settings
from vvdp.systems.axial_control import AxialControl, chamber_loop, chosen_law
from vvdp.systems.axial_tables import PilotSupply
from vvdp.systems.bench_tables import Limits
from vvdp.systems.displacement.cycle import OwnCycle, Triangle, fastest, refuse_fast_points
from vvdp.systems.displacement.flow_table import flow_map_of, valve_condition
from vvdp.systems.displacement.machine import displacement_control, displacement_control_gerotor
from vvdp.systems.displacement.machine_checks import (
    CylinderDuty,
    WorkingPressures,
    refuse_load,
    refuse_precharge,
    working_pressures,
)
from vvdp.systems.displacement.machine_control import (
    CylinderGeometry,
    CylinderSensors,
    LoadObserverTable,
    MachineBelief,
    MachinePaths,
    MachineTables,
    add_led_drive,
    add_outer_loop,
    machine_loop,
)
from vvdp.systems.displacement.machine_extras import GerotorMachine, SpringMachine
from vvdp.systems.displacement.machine_loop import SpoolRange
from vvdp.systems.displacement.machine_tables import InitialGerotorMachine, InitialSpringMachine, MachineOperation
from vvdp.systems.displacement.machine_tally import add_machine_tally
from vvdp.systems.displacement.stages import MachineSequence
from vvdp.systems.displacement.supervision import NO_SPRING, SpoolSpring, Supervision
from vvdp.systems.gerotor_control import GerotorTables, PIGains, control_values, periodic_observer
from vvdp.valve.rotary import RotaryValve

HIGHEST_DUTY = 1.3
"""Duty ratio at which the spool's stroke ends: all flow goes to the line, free of transitions."""


def spring_machine(
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
    axial_sensor: AxialSensorTable,
    axial_observer: AxialObserverTable,
    axial_reference: ReferenceFilter,
    axial_sequence: AxialSequence,
    passivity: PassivityGains,
    encoder: EncoderTable,
    spool_filter: EventFilterValues,
    cycle: Triangle | OwnCycle,
    reference: ReferenceFilter,
    gains: ForceGains,
    direction: DirectionSettings,
    flow_split: FlowSplit,
    pressure_bounds: PressureBounds,
    supply_support: SupplySupport,
    flow_gain: FlowGain,
    belief: MachineBelief,
    load_observer: LoadObserverTable,
    cylinder_sensors: CylinderSensors,
    machine_sequence: MachineSequence,
    operation: MachineOperation,
    initial: InitialSpringMachine,
    limits: Limits,
    adaptation: Adaptation | None = None,
    supervision: Supervision | None = None,
    weight: Weight | None = None,
    dump_valve: SeatValve | None = None,
) -> Network:
    """The machine under displacement control, its spool moved by a chamber against a spring."""
    tables = locals()
    net = displacement_control(**_of(tables, displacement_control))
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
    spool = SpoolRange(
        helix_length=valve.helix_length,
        rest_position=axial_stops.lower_end,
        highest_position=HIGHEST_DUTY * valve.helix_length,
        sections=valve.sections,
    )
    control = AxialControl(
        sensor=axial_sensor,
        observer=axial_observer,
        law=chosen_law(passivity),
        reference=axial_reference,
        sequence=axial_sequence,
        helix_length=valve.helix_length,
        wanted=constant(spool.highest_position),
        asked_by="pilot.supply_pressure",
    )
    inner = chamber_loop(control, drive, pilot)
    assert isinstance(inner, PassiveLoop)
    paths = _paths("slide.position", "pilot_chamber.pressure")
    _add_outer(net, tables, spool, paths)
    add_led_drive(net, inner, watch_settings(encoder, spool_filter, initial.spool_angle), paths)
    add_machine_tally(net, paths, operation.tank_pressure.extremes[1])
    net.extras = SpringMachine
    return net


def gerotor_machine(
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
    calibration: DriveBelief,
    axial_sensor: AxialSensorTable,
    axial_observer: AxialObserverTable,
    position_control: PIGains,
    axial_reference: ReferenceFilter,
    axial_sequence: GerotorSequence,
    encoder: EncoderTable,
    spool_filter: EventFilterValues,
    cycle: Triangle | OwnCycle,
    reference: ReferenceFilter,
    gains: ForceGains,
    direction: DirectionSettings,
    flow_split: FlowSplit,
    pressure_bounds: PressureBounds,
    supply_support: SupplySupport,
    flow_gain: FlowGain,
    belief: MachineBelief,
    load_observer: LoadObserverTable,
    cylinder_sensors: CylinderSensors,
    machine_sequence: MachineSequence,
    operation: MachineOperation,
    initial: InitialGerotorMachine,
    limits: Limits,
    adaptation: Adaptation | None = None,
    supervision: Supervision | None = None,
    weight: Weight | None = None,
    dump_valve: SeatValve | None = None,
) -> Network:
    """The same with a gerotor pump that moves the spool, and a dump valve that empties the line when all is off."""
    tables = locals()
    net = displacement_control_gerotor(**_of(tables, displacement_control_gerotor))
    spool = SpoolRange(
        helix_length=valve.helix_length,
        rest_position=gerotor.lower_end,
        highest_position=min(HIGHEST_DUTY * valve.helix_length, gerotor.upper_end),
        sections=valve.sections,
    )
    parts = GerotorTables(
        sensor=axial_sensor,
        observer=axial_observer,
        gains=position_control,
        calibration=calibration,
        reference=axial_reference,
        sequence=axial_sequence,
        helix_length=valve.helix_length,
        wanted=constant(spool.highest_position),
    )
    observer = periodic_observer(axial_observer, gerotor, valve.helix_length)
    inner = GerotorLoop(observer=observer, **control_values(parts, gerotor))
    paths = _paths("gerotor.position")
    _add_outer(net, tables, spool, paths)
    add_led_drive(net, inner, watch_settings(encoder, spool_filter, initial.spool_angle), paths)
    add_machine_tally(net, paths, operation.tank_pressure.extremes[1])
    net.extras = GerotorMachine
    return net


def _of(tables: Mapping[str, Any], function: Callable[..., Network]) -> dict[str, Any]:
    """Those tables that a function takes."""
    return {name: tables[name] for name in signature(function).parameters if name in tables}


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


def _add_outer(net: Network, tables: Mapping[str, Any], spool: SpoolRange, paths: MachinePaths) -> None:
    """Add the program of the outer loop, with what its tables say and believe."""
    spring = _spool_spring(tables) if "axial_spring" in tables else NO_SPRING
    given = {**tables, "adaptation": tables["adaptation"] or Adaptation(), "spool_spring": spring}
    cylinder, stops = tables["cylinder"], tables["cylinder_stops"]
    geometry = CylinderGeometry(cylinder.area_a, cylinder.area_b, stops.lower_end, stops.upper_end)
    outer = MachineTables(**{field.name: given[field.name] for field in fields(MachineTables)})
    tank = tables["operation"].tank_pressure.extremes[1]
    check_demands(tables, tank)
    loop = machine_loop(outer, geometry, spool, believed_map(tables), tank)
    add_outer_loop(net, loop, tables["cylinder_sensors"], paths)


def check_demands(tables: Mapping[str, Any], tank_pressure: float) -> None:
    """Raises ParameterError where the cycle is faster than the pump, the load takes more than the relief valve allows
    with the return fully open, or the accumulator is charged above all pressures at which the line is to work.

    tank_pressure  absolute [Pa]
    """
    cylinder = tables["cylinder"]
    flow = tables["pump"].displacement * tables["operation"].pump_speed.extremes[1]
    refuse_fast_points(tables["cycle"], flow / max(cylinder.area_a, cylinder.area_b))
    least, greatest = tables["operation"].load_force.extremes
    if tables["weight"] is not None:
        pull = weight_force(tables["weight"])
        least, greatest = least + pull, greatest + pull
    speed = fastest(tables["cycle"])

    def pressures(opening: float) -> WorkingPressures:
        duty = CylinderDuty(least, greatest, speed, opening)
        return working_pressures(duty, cylinder, tables["cylinder_friction"], tables["directional_valve"])

    refuse_load(pressures(1.0), tables["relief_valve"], tank_pressure)
    support = tables["supply_support"]
    supported = support.support_pressure - tank_pressure if support.support_conductance > 0.0 else 0.0
    refuse_precharge(max(*pressures(tables["flow_split"].mean_opening), supported), tables["line"], tank_pressure)


def _spool_spring(tables: Mapping[str, Any]) -> SpoolSpring:
    spring = tables["axial_spring"]
    return SpoolSpring(
        stiffness=spring.stiffness,
        preload=spring.preload - spring.stiffness * spring.rest_position,
        area=tables["axial_piston"].area_a,
        reference_pressure=tables["pilot_oil"].reference_pressure,
    )


def believed_map(tables: Mapping[str, Any]) -> FlowMap:
    """The flow map of the valve, with the relief valve as it is believed to be set."""
    pump, operation = tables["pump"], tables["operation"]
    relief = replace(tables["relief_valve"], cracking_pressure=tables["belief"].relief_pressure)
    at = valve_condition(
        pump.displacement * operation.pump_speed.base,
        density(operation.oil_temperature.base, tables["oil"]),
        operation.tank_pressure.base,
        pump,
        relief,
    )
    return flow_map_of(tables["valve"], at)
