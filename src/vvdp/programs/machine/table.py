"""The control of a whole machine by name: its values as a file gives them, and its programs.

Source  ours, docs/models/displacement-control.md
"""

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

from vvdp.base.errors import ParameterError
from vvdp.base.kinds import (
    Count,
    Force,
    Length,
    Position,
    Pressure,
    PressureDifference,
    PressureSignal,
    SpeedSignal,
    TemperatureSignal,
    Time,
)
from vvdp.base.params import Params, field_names
from vvdp.control.adaptation import Adaptation
from vvdp.control.capacities import CylinderBelief, CylinderEnds, CylinderModel, LineBelief, cylinder_model
from vvdp.control.cylinder_force import ForceGains
from vvdp.control.direction import DirectionSettings
from vvdp.control.displacement import DisplacementSettings, SupplySupport
from vvdp.control.flow_gain import FlowGain
from vvdp.control.flow_map import FlowMap
from vvdp.control.flow_split import FlowSplit
from vvdp.control.pressure_modes import PressureBounds
from vvdp.control.reference import Rate, ReferenceFilter
from vvdp.estimation.load_observer import LoadObserver
from vvdp.fluid.oil import Oil, density
from vvdp.hydraulics.pump import Pump
from vvdp.hydraulics.relief_valve import LoadReliefValve, ReliefValve
from vvdp.network.program import ProgramType
from vvdp.programs.generic import GenericProgram
from vvdp.programs.machine.checks import refuse_machine
from vvdp.programs.machine.common_loop import CommonLoop, common_law, common_start, common_step
from vvdp.programs.machine.cycle import OwnCycle, Triangle, first_direction, points_of, refuse_fast_points
from vvdp.programs.machine.flow_table import flow_map_of, valve_condition
from vvdp.programs.machine.loop import IDLE, MachineLoop, MachinePlace, SpoolRange, machine_start, machine_step
from vvdp.programs.machine.phases import MachineSequence
from vvdp.programs.machine.report import MachineReport
from vvdp.programs.machine.supervision import NO_SPRING, SpoolSpring, Supervised, Supervision
from vvdp.programs.position_loop import LoopTable
from vvdp.sensing.instrument import Instrument, ideal_instrument
from vvdp.valve.rotary import RotaryValve

HIGHEST_DUTY = 1.3
"""Duty ratio at which the spool's stroke ends: all flow goes to the line, free of transitions."""


class MachineBelief(CylinderBelief, LineBelief):
    """Cylinder, line, load and relief valve as the controller models them, right or wrong.

    Oil volumes are those of the chambers with their hoses at position 0; `return_conductance` is K_v of the return
    valve, fully open; `relief_pressure` is the cracking pressure in the flow map.
    """

    load_force: Force
    relief_pressure: Pressure


class LoadObserverTable(Params):
    """Rates at which the three errors of the load observer decay, and the reported load follows."""

    observer_rate: Rate
    load_rate: Rate


class CylinderSensors(Params):
    """Noise of the sensors at the cylinder, as a deviation, and its first seed."""

    position_noise: Length = 0.0
    pressure_noise: PressureDifference = 0.0
    seed: Count = 0.0


class KnownSpring(SpoolSpring):
    """The spring of the spool, its preload where the spool is at `rest_position`."""

    rest_position: Position = 0.0


class KnownUnit(Params):
    """The pump unit from which the flow map follows, and between which positions its spool moves."""

    valve: RotaryValve
    pump: Pump
    relief_valve: ReliefValve | LoadReliefValve
    oil: Oil
    oil_temperature: TemperatureSignal
    rated_speed: SpeedSignal
    tank_pressure: PressureSignal
    lowest_spool_position: Position
    highest_spool_position: Position


class MachineTable(KnownUnit, CylinderEnds):
    """The cycle, the laws with their models, the sensors and the stages; it is called every `sample_period`.

    Without `supervision` nothing is monitored, without a `spring` no chamber moves the spool. With a `loop` the
    position loop of the rival circuits leads the cylinder in place of the laws.
    """

    cycle: Triangle | OwnCycle
    reference: ReferenceFilter
    gains: ForceGains
    direction: DirectionSettings
    flow_split: FlowSplit
    pressure_bounds: PressureBounds
    supply_support: SupplySupport = SupplySupport()
    flow_gain: FlowGain
    adaptation: Adaptation = Adaptation()
    belief: MachineBelief
    load_observer: LoadObserverTable
    cylinder_sensors: CylinderSensors = CylinderSensors()
    machine_sequence: MachineSequence
    supervision: Supervision | None = None
    spring: KnownSpring | None = None
    loop: LoopTable | None = None
    sample_period: Time

    def check(self) -> None:
        try:
            machine_loop(self)
        except ParameterError as problem:
            key = str(problem).partition(":")[0]
            owner = f"{type(self).__name__}." if key in field_names(type(self)) else ""
            raise ParameterError(f"{owner}{problem}") from None


def machine_loop(table: MachineTable) -> MachineLoop:
    """The values with which the program works. Raises ParameterError where the cycle leaves the cylinder or is too
    fast, and where the spool does not reach its highest duty ratio."""
    period, tank = table.sample_period, table.tank_pressure.extremes[1]
    model = cylinder_model(table.belief, table, table.belief, tank)
    given = table.pump.displacement * table.rated_speed.extremes[1]
    refuse_cycle(table.cycle, table, min(given, table.flow_split.largest_flow))
    return MachineLoop(
        law=DisplacementSettings(
            cylinder=model,
            gains=table.gains,
            direction=table.direction,
            split=table.flow_split,
            bounds=table.pressure_bounds,
            support=table.supply_support,
            adaptation=table.adaptation,
            sample_period=period,
        ),
        observer=LoadObserver(
            moving_mass=model.moving_mass,
            viscous_friction=model.viscous_friction,
            observer_rate=table.load_observer.observer_rate,
            load_rate=table.load_observer.load_rate,
            sample_period=period,
        ),
        reference=table.reference,
        points=points_of(table.cycle),
        sequence=table.machine_sequence,
        flow_map=believed_map(table),
        gain=table.flow_gain,
        spool=spool_range(table),
        load_force=table.belief.load_force,
        first_direction=first_direction(table.cycle),
        supervised=supervision_of(table, model),
    )


def supervision_of(table: MachineTable, model: CylinderModel) -> Supervised:
    """Parameters of the supervision of this table."""
    spring = NO_SPRING
    if table.spring is not None:
        at_rest = table.spring.preload - table.spring.stiffness * table.spring.rest_position
        spring = SpoolSpring(
            stiffness=table.spring.stiffness,
            preload=at_rest,
            area=table.spring.area,
            reference_pressure=table.spring.reference_pressure,
        )
    return Supervised(
        watches=0.0 if table.supervision is None else 1.0,
        limits=table.supervision or Supervision(),
        cylinder=model,
        spring=spring,
        pump_speed=table.rated_speed,
        sample_period=table.sample_period,
    )


def spool_range(unit: KnownUnit) -> SpoolRange:
    """Limits of the spool's position, and the helix over which it becomes a duty ratio. Raises ParameterError if the
    stroke ends below the highest duty ratio."""
    length = unit.valve.helix_length
    highest, end = HIGHEST_DUTY * length, unit.highest_spool_position
    if highest > end:
        raise ParameterError(
            f"highest_spool_position: {1e3 * end:.4g} mm; the stroke ends below {1e3 * highest:.4g} mm, "
            f"where the duty ratio is {HIGHEST_DUTY:g} and all flow goes to the line"
        )
    return SpoolRange(
        helix_length=length,
        rest_position=unit.lowest_spool_position,
        highest_position=highest,
        sections=unit.valve.sections,
    )


def believed_map(table: MachineTable) -> FlowMap:
    """The flow map of the valve, with the relief valve of the controller model."""
    relief = replace(table.relief_valve, cracking_pressure=table.belief.relief_pressure)
    at = valve_condition(
        table.pump.displacement * table.rated_speed.base,
        density(table.oil_temperature.base, table.oil),
        table.tank_pressure.base,
        table.pump,
        relief,
    )
    return flow_map_of(table.valve, at)


def refuse_cycle(cycle: Triangle | OwnCycle, cylinder: CylinderEnds, largest_flow: float) -> None:
    """Raises ParameterError where a cycle leaves the cylinder's stroke or is faster than the pump, with its row.

    largest_flow  of the pump [m^3/s]
    """
    positions = points_of(cycle).positions
    low, high = min(positions), max(positions)
    if low < cylinder.lowest_position or high > cylinder.highest_position:
        raise ParameterError(
            f"cycle: {1e3 * low:.4g} to {1e3 * high:.4g} mm are asked for; the cylinder goes from "
            f"{1e3 * cylinder.lowest_position:.4g} to {1e3 * cylinder.highest_position:.4g} mm"
        )
    refuse_fast_points(cycle, largest_flow / max(cylinder.area_a, cylinder.area_b))


def machine_settings(table: MachineTable) -> MachineLoop | CommonLoop:
    """The values with which the program works, by its laws or by the position loop of the rival circuits."""
    machine = machine_loop(table)
    return machine if table.loop is None else CommonLoop(machine=machine, law=common_law(machine, table.loop))


def program_of(settings: MachineLoop | CommonLoop) -> ProgramType:
    """The program that works with these values."""
    if isinstance(settings, MachineLoop):
        return CONTROL
    return replace(CONTROL, step=common_step, settings=CommonLoop, start=common_start)


def cylinder_instruments(table: MachineTable) -> Mapping[str, Instrument]:
    """Sensors between the cylinder and the program, by the field that each measures."""
    sensors = table.cylinder_sensors
    position, pressure = ideal_instrument(-10.0, 10.0), ideal_instrument(0.0, 1e8)
    found = {"position": replace(position, noise=sensors.position_noise, seed=sensors.seed)}
    for number, name in enumerate(("pressure_a", "pressure_b", "line_pressure"), 1):
        found[name] = replace(pressure, noise=sensors.pressure_noise, seed=sensors.seed + number)
    return MappingProxyType(found)


CONTROL = ProgramType(
    machine_step,
    MachinePlace,
    IDLE,
    MachineTable,
    machine_start,
    report=MachineReport,
    instruments=cylinder_instruments,
    refuse=refuse_machine,
)
MACHINE_CONTROL = GenericProgram(CONTROL, made=machine_settings, suited=program_of)
