"""Position loops of a cylinder as programs: a duty cycle behind a filter, followed by valves, a pump or both.

Source  ours, docs/circuits-compared.md
"""

from collections.abc import Callable
from typing import Any

from vvdp.base.kinds import Area, Flow, Fraction, Mass, Position, Pressure, ViscousFriction
from vvdp.base.params import field_names, field_values
from vvdp.base.rules import require_positive
from vvdp.base.units import ATMOSPHERE
from vvdp.control.duty_cycle import DutyCycle, refuse_fast_cycle, refuse_long_cycle
from vvdp.control.reference import ReferenceFilter
from vvdp.network.program import ProgramType
from vvdp.programs.generic import GenericProgram
from vvdp.programs.position_loop import (
    AT_REST,
    FEWEST,
    Conductance,
    CylinderReading,
    LoopTable,
    PositionLoop,
    loop_gain,
    loop_start,
    one_way_step,
    overcentre_step,
    throttle_step,
)
from vvdp.programs.report import ProgramReport


class CylinderLoop(DutyCycle, ReferenceFilter, LoopTable):
    """A duty cycle with its filter and the loop that follows it; pump and cylinder as the loop assumes them."""

    area_a: Area
    area_b: Area
    viscous_friction: ViscousFriction
    moving_mass: Mass
    lowest_position: Position
    highest_position: Position
    largest_flow: Flow
    tank_pressure: Pressure = ATMOSPHERE

    def check(self) -> None:
        require_positive(
            self, "viscous_friction", "moving_mass", why="without them no gain of the position has a margin"
        )
        position_loop(self)


class ValveLoop(CylinderLoop):
    """The same at a valve: `valve_conductance` is that of an edge of the valve that moves the cylinder, or of the
    throttle in its return."""

    valve_conductance: Conductance

    def check(self) -> None:
        require_positive(self, "valve_conductance")


class OneWayLoop(ValveLoop):
    """The same with a pump whose least flow is `lowest_flow`; a fixed one is bled off through a throttle of
    `bleed_conductance`."""

    bleed_conductance: Conductance = FEWEST
    lowest_flow: Flow = 0.0


class OvercentreLoop(CylinderLoop):
    """The same with an overcentre pump: between both chambers, or, if `is_open_circuit` is 1, between the tank and the
    chamber that carries the load."""

    is_open_circuit: Fraction = 0.0


def position_loop(table: CylinderLoop) -> PositionLoop:
    """The settings of a loop as its step takes them. Raises ParameterError for a cycle that it cannot follow."""
    cycle = DutyCycle(**field_values(DutyCycle, table))
    refuse_long_cycle(cycle, table.lowest_position, table.highest_position)
    refuse_fast_cycle(cycle, table.largest_flow / max(table.area_a, table.area_b))
    same = {name: getattr(table, name) for name in field_names(PositionLoop) if name in field_names(type(table))}
    return PositionLoop(
        cycle=cycle,
        reference=ReferenceFilter(filter_rate=table.filter_rate),
        table=LoopTable(**field_values(LoopTable, table)),
        position_gain=loop_gain(table.viscous_friction, table.moving_mass, table.gain_margin),
        reference_pressure=table.tank_pressure,
        **same,
    )


class RoundReport(ProgramReport):
    """Of a program that goes through rounds of a cycle: means are those of a round, never steady."""

    STEADY = False


def _position_loop(step: Callable[..., Any], table: type[CylinderLoop]) -> GenericProgram:
    kind = ProgramType(step, CylinderReading, AT_REST, table, loop_start, report=RoundReport)
    return GenericProgram(kind, made=position_loop)


THROTTLE_POSITION_LOOP = _position_loop(throttle_step, ValveLoop)
ONE_WAY_POSITION_LOOP = _position_loop(one_way_step, OneWayLoop)
OVERCENTRE_POSITION_LOOP = _position_loop(overcentre_step, OvercentreLoop)
