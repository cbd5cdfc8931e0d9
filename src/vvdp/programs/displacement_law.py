"""Displacement control of a cylinder as a program: from a reference and measured values to valves and flow.

Source  ours, docs/models/displacement-control.md
"""

from typing import NamedTuple, TypeVar

from vvdp.base.kinds import (
    Compliance,
    Flow,
    Force,
    Fraction,
    Mass,
    Position,
    Pressure,
    SignedFraction,
    Time,
    Velocity,
    Volume,
)
from vvdp.base.params import Params, field_values
from vvdp.base.units import ATMOSPHERE
from vvdp.control.adaptation import Adaptation
from vvdp.control.capacities import (
    CircuitPressures,
    CylinderBelief,
    CylinderEnds,
    LineBelief,
    cylinder_model,
)
from vvdp.control.cylinder_force import ForceGains, ForceRate
from vvdp.control.direction import DirectionSettings
from vvdp.control.displacement import (
    CylinderSeen,
    DisplacementMemory,
    DisplacementSettings,
    SupplySupport,
    displacement_start,
    displacement_step,
    idle_demand,
)
from vvdp.control.flow_split import FlowSplit
from vvdp.control.pressure_modes import PressureBounds, PressureMode
from vvdp.control.reference import Jerk, Reference, SignedAcceleration
from vvdp.hydraulics.volume import GasExponent, GasPressure
from vvdp.network.program import ProgramType
from vvdp.programs.displacement_reach import refuse_out_of_reach
from vvdp.programs.displacement_report import DisplacementReport
from vvdp.programs.generic import GenericProgram


class KnownCylinder(CylinderBelief, CylinderEnds, LineBelief):
    """Controller model of cylinder, load, line and return valve; oil volumes at position 0, hoses included."""

    tank_pressure: Pressure = ATMOSPHERE
    line_volume: Volume = 0.0
    hose_compliance: Compliance = 0.0
    gas_volume: Volume = 0.0
    precharge_pressure: GasPressure = 0.0
    gas_exponent: GasExponent = 1.3


class DisplacementTable(
    KnownCylinder, ForceGains, DirectionSettings, FlowSplit, PressureBounds, SupplySupport, Adaptation
):
    """Gains and limits of the law, and its model of the cylinder; it is called every `sample_period`.

    `uses_delivered_flow` 1 needs `delivered_flow`: the return valve then compensates flow that the pump does not
    deliver.
    """

    uses_delivered_flow: Fraction = 0.0
    sample_period: Time

    def check(self) -> None:
        displacement_settings(self)


def displacement_settings(table: DisplacementTable) -> DisplacementSettings:
    """The settings of the law as its step takes them. Raises ParameterError."""
    return DisplacementSettings(
        cylinder=cylinder_model(table, table, table, table.tank_pressure),
        gains=_part(ForceGains, table),
        direction=_part(DirectionSettings, table),
        split=_part(FlowSplit, table),
        bounds=_part(PressureBounds, table),
        support=_part(SupplySupport, table),
        adaptation=_part(Adaptation, table),
        sample_period=table.sample_period,
    )


Part = TypeVar("Part", bound=Params)


def _part(cls: type[Part], table: Params) -> Part:
    """The values of a class that stand in a table."""
    return cls(**field_values(cls, table))


class CylinderTask(NamedTuple):
    """The reference with its derivatives, the estimated motion of the rod, and the measured pressures, absolute.

    `mean_...` are pressures averaged over a period of a pulsating supply; at 0 bara the measured one counts. While
    `released` is 0 all valves are closed and the commanded flow is 0.
    """

    reference: Position
    reference_velocity: Velocity
    reference_acceleration: SignedAcceleration
    reference_jerk: Jerk
    position: Position
    velocity: Velocity
    load_force: Force
    pressure_a: Pressure
    pressure_b: Pressure
    line_pressure: Pressure
    mean_pressure_a: Pressure = 0.0
    mean_pressure_b: Pressure = 0.0
    mean_line_pressure: Pressure = 0.0
    delivered_flow: Flow = 0.0
    released: Fraction = 1.0


class CylinderCommand(NamedTuple):
    """Command of the directional valve (1 extends), opening of the return valve, flow of the pump.

    The other fields show how they were calculated: U* as `effort`, F_H - F_v, the number of the pressure mode, 1 while
    the opening is at an end, the flow of the split before any limit, load and mass of the controller model as adapted.
    """

    direction: SignedFraction
    opening: Fraction
    flow: Flow
    effort: ForceRate
    force_error: Force
    mode: PressureMode
    saturated: Fraction
    split_flow: Flow
    load_force: Force
    moving_mass: Mass


def displacement_program_step(
    t: float, memory: DisplacementMemory, reading: CylinderTask, settings: DisplacementSettings
) -> tuple[DisplacementMemory, CylinderCommand]:
    """Displacement control of a cylinder by pump, return valve and directional valve together."""
    demand = idle_demand()
    if reading.released > 0.5:
        seen, reference = read_task(reading)
        memory, demand = displacement_step(memory, seen, reference, settings)
    else:
        memory = displacement_start(settings)
    return memory, CylinderCommand(
        direction=demand.direction,
        opening=demand.opening,
        flow=demand.flow,
        effort=demand.effort,
        force_error=demand.force_error,
        mode=demand.mode,
        saturated=demand.saturated,
        split_flow=demand.split_flow,
        load_force=reading.load_force + memory.adaptation.load_correction,
        moving_mass=memory.adaptation.moving_mass,
    )


def read_task(reading: CylinderTask) -> tuple[CylinderSeen, Reference]:
    """Inputs of the law: pressures as measured and averaged, motion and load, and the reference."""
    r = reading
    fast = CircuitPressures(r.pressure_a, r.pressure_b, r.line_pressure)
    slow = CircuitPressures(
        r.mean_pressure_a if r.mean_pressure_a > 0.0 else r.pressure_a,
        r.mean_pressure_b if r.mean_pressure_b > 0.0 else r.pressure_b,
        r.mean_line_pressure if r.mean_line_pressure > 0.0 else r.line_pressure,
    )
    seen = CylinderSeen(
        position=r.position,
        velocity=r.velocity,
        load_force=r.load_force,
        fast=fast,
        slow=slow,
        delivered_flow=r.delivered_flow,
    )
    reference = Reference(
        position=r.reference,
        velocity=r.reference_velocity,
        acceleration=r.reference_acceleration,
        jerk=r.reference_jerk,
    )
    return seen, reference


IDLE = CylinderCommand(
    direction=0.0,
    opening=0.0,
    flow=0.0,
    effort=0.0,
    force_error=0.0,
    mode=0.0,
    saturated=0.0,
    split_flow=0.0,
    load_force=0.0,
    moving_mass=0.0,
)


DISPLACEMENT_CONTROL = GenericProgram(
    ProgramType(
        displacement_program_step,
        CylinderTask,
        IDLE,
        DisplacementTable,
        displacement_start,
        report=DisplacementReport,
        refuse=refuse_out_of_reach,
    ),
    made=displacement_settings,
)
