"""Position loops of a cylinder: velocity fed forward, a gain on the position error, flows made from both.

All follow the same reference, behind the same filter, at the same samples; the gain follows from the plant by one rule.

Source  ours, docs/circuits-compared.md
"""

from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.errors import ParameterError
from vvdp.base.kinds import (
    FLOW_COEFFICIENT,
    Area,
    Flow,
    Force,
    Fraction,
    Position,
    Pressure,
    PressureDifference,
    Ratio,
    SignedFraction,
    Time,
    Velocity,
)
from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.base.select import clip
from vvdp.control.duty_cycle import DutyCycle, cycle_point
from vvdp.control.reference import Rate, Reference, ReferenceFilter, reference_at_rest, reference_step

FLAT = 0.05
"""Share of the supply's force below which the pressure that is left over a valve is taken to be that."""
SLOW = 1e-3
"""Velocity at which a one-way pump's directional valve changes over [m/s]."""
LEAST_SUPPLY = 1e5
"""Pressure of a supply below which a throttle beside it opens no further [Pa]."""
FEWEST = 1e-12
"""A conductance below which a valve counts as none [m^3/(s Pa^0.5)]."""

Conductance = Annotated[float, FLOW_COEFFICIENT]


class LoopTable(Params):
    """The [loop] table.

    The loop is a `gain_margin` below the gain at which position and oil's spring begin to swing, is called every
    `sample_period`, and receives pressures behind a first-order filter of `pressure_rate`. A circuit that changes
    what its sides are joined to does so over `change_time`, where the pressures say so by more than `hysteresis`. A
    meter-out throttle opens to `largest_opening`, less where the supply side would fall below `supply_level`.
    """

    gain_margin: Ratio
    sample_period: Time
    pressure_rate: Rate
    change_time: Time = 0.02
    hysteresis: PressureDifference = 1e4
    largest_opening: Fraction = 0.8
    supply_level: PressureDifference = 6e5

    def check(self) -> None:
        require_positive(self, "gain_margin", "sample_period", "pressure_rate", "change_time")


class PositionLaw(Params):
    """Model of the plant in a position loop, and its table.

    `valve_conductance` is that of an edge of the valve that moves the cylinder, or of the meter-out throttle;
    `largest_flow` is that of the pump.
    """

    table: LoopTable
    position_gain: Rate
    area_a: Area
    area_b: Area
    reference_pressure: Pressure
    largest_flow: Flow
    valve_conductance: Conductance = FEWEST


class PositionLoop(PositionLaw):
    """Parameters of a position loop: its law, the cycle with its reference, the conductance of a throttle from the
    supply to the tank, the flow below which a one-way pump delivers none, and whether an overcentre pump works in an
    open circuit (1) or between both chambers (0)."""

    cycle: DutyCycle
    reference: ReferenceFilter
    bleed_conductance: Conductance = FEWEST
    lowest_flow: Flow = 0.0
    is_open_circuit: Fraction = 0.0


class CylinderReading(NamedTuple):
    """Inputs of a loop: the rod, both chambers, and what feeds them, absolute."""

    position: Position
    pressure_a: Pressure
    pressure_b: Pressure
    supply_pressure: Pressure


class Pressures(NamedTuple):
    """Of both chambers and of what feeds them, absolute."""

    a: Pressure
    b: Pressure
    supply: Pressure


class Joint(NamedTuple):
    """Side to which a circuit is joined: `side` from -1 to 1 on its way to the one that is `wanted`."""

    wanted: SignedFraction
    side: SignedFraction


class LoopMemory(NamedTuple):
    """Memory of a loop from sample to sample: its reference, filtered pressures, and how the circuit is joined."""

    reference: Reference
    pressures: Pressures
    joint: Joint


class CylinderCommand(NamedTuple):
    """Commands of a position loop: the `flow` of the supply side, the 4/3 valve, the meter-out throttle, the throttle
    that bleeds the supply, and the side to which the circuit is joined.

    Commands that a circuit does not have stay 0. `reference` is given for the record, and `force` is that of the duty
    cycle on the rod.
    """

    flow: Flow
    valve: SignedFraction
    opening: Fraction
    bleed: Fraction
    side: SignedFraction
    reference: Position
    force: Force


class Wanted(NamedTuple):
    """The velocity that a loop demands, with the force of the oil on the rod that holds its load."""

    velocity: Velocity
    force: Force


AT_REST = CylinderCommand(flow=0.0, valve=0.0, opening=0.0, bleed=0.0, side=1.0, reference=0.0, force=0.0)
"""The command before the first sample."""


def loop_gain(viscous_friction: float, mass: float, gain_margin: float) -> float:
    """The gain of a position loop about a cylinder on oil that springs [1/s]: b/(m margin).

    A velocity that follows its command as 1/(1 + 2 z s/w + s^2/w^2) is stable under an integrating loop up to the gain
    2 z w, which is b/m whatever the oil: z = b/(2 m w).

    viscous_friction  b of the rod [N s/m]
    mass              m that it moves [kg]
    gain_margin       [1]

    >>> loop_gain(2000.0, 100.0, 2.0)
    10.0
    """
    if not viscous_friction > 0.0:
        raise ParameterError("friction.viscous_friction: 0 N s/m; without it no gain of the position keeps a margin")
    return viscous_friction / (mass * gain_margin)


def throttle_opening(velocity: float, force: float, supply: float, loop: PositionLoop) -> float:
    """Opening of a 4/3 valve with four equal edges for a velocity [1]; backward below 0.

    Extending, P_a = P_s - (A_a v/(K y))^2 and P_b = (A_b v/(K y))^2 give y = v/K root((A_a^3 + A_b^3)/(P_s A_a - F));
    retracting, P_s A_b + F stands below the root.

    velocity  v [m/s]
    force     of the oil on the rod, F [N]
    supply    P_s, gauge [Pa]
    """
    area = loop.area_a if velocity > 0.0 else loop.area_b
    left = supply * area - (force if velocity > 0.0 else -force)
    left = max(left, FLAT * supply * area, 1.0)
    cubes = loop.area_a**3 + loop.area_b**3
    return float(clip(velocity / loop.valve_conductance * np.sqrt(cubes / left), -1.0, 1.0))


def return_opening(velocity: float, force: float, loop: PositionLaw) -> float:
    """Opening of a meter-out throttle with which the supply side keeps its level [1].

    The return may rise to P_r = (P_s A_s - F)/A_r, F in the direction of the velocity: u = A_r v/(K root(P_r)).

    velocity  v [m/s]
    force     of the oil on the rod [N]
    """
    supply_area, return_area = (loop.area_a, loop.area_b) if velocity > 0.0 else (loop.area_b, loop.area_a)
    against = force if velocity > 0.0 else -force
    level = (loop.table.supply_level * supply_area - against) / return_area
    if level <= 0.0:
        return loop.table.largest_opening
    opening = return_area * abs(velocity) / (loop.valve_conductance * np.sqrt(level))
    return float(min(opening, loop.table.largest_opening))


def loop_start(settings: PositionLoop) -> LoopMemory:
    """The memory before the first sample: at rest at the beginning of the cycle."""
    level = settings.reference_pressure
    return LoopMemory(reference_at_rest(settings.cycle.positions[0]), Pressures(level, level, level), Joint(1.0, 1.0))


def next_memory(t: float, memory: LoopMemory, seen: CylinderReading, loop: PositionLoop) -> LoopMemory:
    """The memory with reference and filtered pressures a sample further, as joined before."""
    reference, share = memory.reference, 1.0
    if t > 0.0:
        raw = cycle_point(t, loop.cycle).position
        reference = reference_step(reference, raw, loop.table.sample_period, loop.reference)
        share = -float(np.expm1(-loop.table.pressure_rate * loop.table.sample_period))
    old = memory.pressures
    pressures = Pressures(
        old.a + share * (seen.pressure_a - old.a),
        old.b + share * (seen.pressure_b - old.b),
        old.supply + share * (seen.supply_pressure - old.supply),
    )
    return LoopMemory(reference, pressures, memory.joint)


def wanted_motion(memory: LoopMemory, position: float, loop: PositionLaw) -> Wanted:
    """Demanded velocity from the position error, and the oil's force from the filtered pressures.

    position  of the rod [m]
    """
    reference, pressures, level = memory.reference, memory.pressures, loop.reference_pressure
    return Wanted(
        reference.velocity + loop.position_gain * (reference.position - position),
        (pressures.a - level) * loop.area_a - (pressures.b - level) * loop.area_b,
    )


def change_side(t: float, joint: Joint, wanted: float, loop: PositionLoop) -> Joint:
    """The circuit on its way to be joined as `wanted`, from one side to the other in the change time; so from t = 0."""
    most = 2.0 * loop.table.sample_period / loop.table.change_time if t > 0.0 else 2.0
    return Joint(wanted, joint.side + float(clip(wanted - joint.side, -most, most)))


def cylinder_command(
    t: float, memory: LoopMemory, settings: PositionLoop, flow: float = 0.0, valve: float = 0.0
) -> CylinderCommand:
    """The command of a loop at `t` [s]; commands that a circuit does not have stay 0."""
    return CylinderCommand(
        flow=flow,
        valve=valve,
        opening=0.0,
        bleed=0.0,
        side=memory.joint.side,
        reference=memory.reference.position,
        force=cycle_point(t, settings.cycle).force,
    )


def throttle_step(
    t: float, memory: LoopMemory, seen: CylinderReading, settings: PositionLoop
) -> tuple[LoopMemory, CylinderCommand]:
    """Position loop of a cylinder at a 4/3 valve, opened for the pressures that are."""
    kept = next_memory(t, memory, seen, settings)
    wanted = wanted_motion(kept, seen.position, settings)
    supply = kept.pressures.supply - settings.reference_pressure
    valve = throttle_opening(wanted.velocity, wanted.force, supply, settings)
    return kept, cylinder_command(t, kept, settings, valve=valve)


def one_way_step(
    t: float, memory: LoopMemory, seen: CylinderReading, settings: PositionLoop
) -> tuple[LoopMemory, CylinderCommand]:
    """Position loop of a cylinder whose pump delivers flow one way: a directional valve for the sign, a meter-out
    throttle; or a throttle that bleeds the surplus flow of a fixed pump to the tank."""
    kept = next_memory(t, memory, seen, settings)
    found = one_way_actuation(kept, seen.position, settings)
    supply = kept.pressures.supply - settings.reference_pressure
    return LoopMemory(kept.reference, kept.pressures, Joint(found.side, found.side)), CylinderCommand(
        flow=found.flow if found.flow >= settings.lowest_flow else 0.0,
        valve=found.side,
        opening=found.opening,
        bleed=bleed_opening(found.flow, supply, settings) if settings.bleed_conductance > FEWEST else 0.0,
        side=found.side,
        reference=kept.reference.position,
        force=cycle_point(t, settings.cycle).force,
    )


class OneWay(NamedTuple):
    """Motion of a cylinder whose pump delivers flow one way: the `side` of its directional valve, 1 to extend, the flow
    to it, and the opening of its meter-out throttle."""

    side: SignedFraction
    flow: Flow
    opening: Fraction


def one_way_actuation(memory: LoopMemory, position: float, loop: PositionLaw) -> OneWay:
    """Side, flow and opening for the velocity that the position error demands; the side stays while this velocity is
    small.

    position  of the rod [m]
    """
    wanted = wanted_motion(memory, position, loop)
    side = memory.joint.wanted
    if abs(wanted.velocity) > SLOW:
        side = 1.0 if wanted.velocity > 0.0 else -1.0
    speed = max(side * wanted.velocity, 0.0)
    flow = min((loop.area_a if side > 0.0 else loop.area_b) * speed, loop.largest_flow)
    return OneWay(side, flow, return_opening(side * max(speed, SLOW), wanted.force, loop))


def bleed_opening(flow: float, supply: float, loop: PositionLoop) -> float:
    """Opening of a throttle beside the supply for the flow that the cylinder does not take [1]: (Q_p - Q)/(K
    root(P_s)).

    flow    Q, to the cylinder [m^3/s]
    supply  P_s, gauge [Pa]
    """
    left = max(loop.largest_flow - flow, 0.0)
    return float(min(left / (loop.bleed_conductance * np.sqrt(max(supply, LEAST_SUPPLY))), 1.0))


def overcentre_step(
    t: float, memory: LoopMemory, seen: CylinderReading, settings: PositionLoop
) -> tuple[LoopMemory, CylinderCommand]:
    """Position loop of a cylinder whose pump goes over centre: between both chambers the one with more pressure counts
    its flow; in an open circuit it works at that chamber, and the other one is joined to the tank."""
    kept = fuller_joined(t, memory, seen, settings)
    area = settings.area_a
    if kept.joint.side <= 0.0:
        area = -settings.area_b if settings.is_open_circuit > 0.5 else settings.area_b
    flow = area * wanted_motion(kept, seen.position, settings).velocity
    return kept, cylinder_command(
        t, kept, settings, flow=float(clip(flow, -settings.largest_flow, settings.largest_flow))
    )


def fuller_joined(t: float, memory: LoopMemory, seen: CylinderReading, settings: PositionLoop) -> LoopMemory:
    """The memory a sample further, the circuit on its way to the side with more pressure."""
    kept = next_memory(t, memory, seen, settings)
    side = fuller_side(kept.pressures.a - kept.pressures.b, kept.joint.wanted, settings.table)
    return LoopMemory(kept.reference, kept.pressures, change_side(t, kept.joint, side, settings))


def fuller_side(more: float, side: float, table: LoopTable) -> float:
    """The side that carries the load: 1 for chamber A, -1 for B; as before within the hysteresis.

    more  by how much the pressure at A exceeds that at B [Pa]
    side  before
    """
    return 1.0 if more > table.hysteresis else -1.0 if more < -table.hysteresis else side
