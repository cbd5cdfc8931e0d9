"""A cylinder with a metering edge of its own at every port of the cylinder, at a pump that matches the load's pressure.

The edges are proportional valves, or digital flow control units: on/off valves in parallel, of which a code opens some.
Into the supply side an edge meters the flow, out of the return side it holds the supply side at its level, by the law
of all meter-out throttles. The pump receives the pressure of the chamber that is fed, and holds a margin above it.

Source  ours, docs/circuits-compared.md
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import Count, Force, Fraction, Number, Position, Pressure
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.control.duty_cycle import cycle_point
from vvdp.network.program import ProgramType
from vvdp.programs.generic import GenericProgram
from vvdp.programs.position_loop import (
    Conductance,
    CylinderReading,
    Joint,
    LoopMemory,
    PositionLoop,
    loop_start,
    next_memory,
    one_way_actuation,
    wanted_motion,
)
from vvdp.programs.position_loops import CylinderLoop, RoundReport, position_loop

LEAST_DROP = 1e5
"""Drop over an edge below which its loop calculates with this one [Pa]."""


class EdgeLoop(Params):
    """A position loop with four edges. An edge passes its `step` times its command, which is `highest` at most: of a
    proportional valve its conductance times an opening, of a unit that of its smallest valve times a code."""

    loop: PositionLoop
    supply_step: Conductance
    return_step: Conductance
    highest: Count
    is_coded: Fraction


class EdgeCommand(NamedTuple):
    """Commands: each edge, and the absolute pressure of the chamber that is fed; `reference` is given for the record,
    and `force` is that of the duty cycle on the rod."""

    supply_a: Number
    supply_b: Number
    return_a: Number
    return_b: Number
    load_pressure: Pressure
    reference: Position
    force: Force


class Sides(NamedTuple):
    """Areas and loads of a cylinder that moves to one side: areas of supply and return [m^2], force against the motion
    [N], pressures of the feed and of the chamber that is fed, gauge [Pa]."""

    supply_area: float
    return_area: float
    force: float
    feed: float
    fed: float


class Edges(NamedTuple):
    """Commands of the edge into the supply side and of that out of the return side."""

    into: Number
    out: Number


def edge_speed(into: float, out: float, sides: Sides) -> float:
    """The steady speed of a rod between two edges [m/s]; 0 where one is closed or the load is too much.

    P_s = P - (A_s v/K_i)^2 and P_r = (A_r v/K_o)^2 hold P_s A_s - P_r A_r = F at
    v = root((P A_s - F)/(A_s^3/K_i^2 + A_r^3/K_o^2)).

    into, out  conductances K_i and K_o [m^3/(s Pa^0.5)]
    """
    left = sides.feed * sides.supply_area - sides.force
    if into <= 0.0 or out <= 0.0 or left <= 0.0:
        return 0.0
    return float(np.sqrt(left / (sides.supply_area**3 / into**2 + sides.return_area**3 / out**2)))


def metered_edges(flow: float, opening: float, sides: Sides, settings: EdgeLoop) -> Edges:
    """Commands for a flow, each between 0 and the highest: K_i = Q/root(P - P_s) into the supply side.

    A chamber whose pressure exceeds that of its feed is closed, so that nothing falls back.

    flow     into the supply side [m^3/s]
    opening  of the return by the law of meter-out throttles [1]
    """
    drop, highest = sides.feed - sides.fed, settings.highest
    into = flow / (settings.supply_step * np.sqrt(max(drop, LEAST_DROP))) if drop > 0.0 else 0.0
    out = opening * settings.loop.valve_conductance / settings.return_step
    return Edges(float(min(into, highest)), float(min(out, highest)))


def best_codes(speed: float, edges: Edges, sides: Sides, settings: EdgeLoop) -> Edges:
    """The codes next to two commands whose steady speed is closest to `speed` [m/s]."""
    best, least = Edges(np.floor(edges.into), np.floor(edges.out)), np.inf
    for more_in in (0.0, 1.0):
        for more_out in (0.0, 1.0):
            codes = Edges(
                min(float(np.floor(edges.into)) + more_in, settings.highest),
                min(float(np.floor(edges.out)) + more_out, settings.highest),
            )
            found = edge_speed(codes.into * settings.supply_step, codes.out * settings.return_step, sides)
            if abs(found - speed) < least:
                best, least = codes, abs(found - speed)
    return best


def edge_step(
    t: float, memory: LoopMemory, seen: CylinderReading, settings: EdgeLoop
) -> tuple[LoopMemory, EdgeCommand]:
    """Position loop of a cylinder with a metering edge at every port: proportional valves, or digital flow control
    units, which get the pair of codes whose speed is closest."""
    kept, sides, flow, opening = edge_demand(t, memory, seen, settings)
    edges = metered_edges(flow, opening, sides, settings)
    if settings.is_coded > 0.5:
        edges = best_codes(flow / sides.supply_area, edges, sides, settings)
    return kept, edge_command(t, kept, edges, seen, settings)


class EdgeDemand(NamedTuple):
    """Memory after a sample, areas and loads of the cylinder, and the demand: flow and opening of the return."""

    memory: LoopMemory
    sides: Sides
    flow: float
    opening: float


def edge_demand(t: float, memory: LoopMemory, seen: CylinderReading, settings: EdgeLoop) -> EdgeDemand:
    """Commands of the edges at a sample, as `one_way_step`."""
    loop = settings.loop
    kept = next_memory(t, memory, seen, loop)
    found = one_way_actuation(kept, seen.position, loop)
    force, level, is_out = wanted_motion(kept, seen.position, loop).force, loop.reference_pressure, found.side > 0.0
    sides = Sides(
        supply_area=loop.area_a if is_out else loop.area_b,
        return_area=loop.area_b if is_out else loop.area_a,
        force=found.side * force,
        feed=kept.pressures.supply - level,
        fed=(kept.pressures.a if is_out else kept.pressures.b) - level,
    )
    joined = LoopMemory(kept.reference, kept.pressures, Joint(found.side, found.side))
    return EdgeDemand(joined, sides, found.flow, found.opening)


def edge_command(t: float, memory: LoopMemory, edges: Edges, seen: CylinderReading, settings: EdgeLoop) -> EdgeCommand:
    """The command of each edge: those of the other side are closed."""
    out = 1.0 if memory.joint.side > 0.0 else 0.0
    return EdgeCommand(
        supply_a=out * edges.into,
        supply_b=(1.0 - out) * edges.into,
        return_a=(1.0 - out) * edges.out,
        return_b=out * edges.out,
        load_pressure=seen.pressure_a if out > 0.0 else seen.pressure_b,
        reference=memory.reference.position,
        force=cycle_point(t, settings.loop.cycle).force,
    )


def edge_start(settings: EdgeLoop) -> LoopMemory:
    """The memory before the first sample: at rest at the beginning of the cycle."""
    return loop_start(settings.loop)


AT_REST = EdgeCommand(
    supply_a=0.0, supply_b=0.0, return_a=0.0, return_b=0.0, load_pressure=101325.0, reference=0.0, force=0.0
)
"""The command before the first sample."""


class EdgeTable(CylinderLoop):
    """As `CylinderLoop`, with four edges between pump, chambers and tank: an edge passes its step times its command.

    `supply_step` and `return_step` are the conductances of proportional valves, whose command is at most 1, or, with
    `is_coded` 1, those of the smallest valves of digital flow control units, whose command is a code.
    """

    supply_step: Conductance
    return_step: Conductance
    highest: Count = 1.0
    is_coded: Fraction = 0.0

    def check(self) -> None:
        require_positive(self, "supply_step", "return_step", "highest")


def edge_loop(table: EdgeTable) -> EdgeLoop:
    """The settings of the loop as its step takes them. Raises ParameterError for a cycle that it cannot follow."""
    return EdgeLoop(
        loop=replace(position_loop(table), valve_conductance=table.highest * table.return_step),
        supply_step=table.supply_step,
        return_step=table.return_step,
        highest=table.highest,
        is_coded=table.is_coded,
    )


EDGE_POSITION_LOOP = GenericProgram(
    ProgramType(edge_step, CylinderReading, AT_REST, EdgeTable, edge_start, report=RoundReport), made=edge_loop
)
