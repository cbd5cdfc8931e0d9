"""The control of chapter 6, sample by sample: reference and displacement control of a cylinder that is measured.

Source  ours, docs/models/displacement-chapter6.md, where a function names no other.
"""

from typing import NamedTuple

from vvdp.base.kinds import Flow, Force, Fraction, Mass, Position, Pressure, SignedFraction, Time, Velocity
from vvdp.base.params import Params
from vvdp.control.capacities import CircuitPressures
from vvdp.control.cylinder_force import ForceRate
from vvdp.control.displacement import (
    CylinderSeen,
    DisplacementMemory,
    DisplacementSettings,
    displacement_start,
    displacement_step,
)
from vvdp.control.pressure_modes import PressureMode
from vvdp.control.reference import Reference, ReferenceFilter, reference_at_rest, reference_step
from vvdp.machines.tracking import Actuated, Followed, Tracking, tracking_start, tracking_step
from vvdp.programs.machine.cycle import Points, cycle_position

PROGRAM = "control"
"""Name of the program."""


class CylinderPlace(NamedTuple):
    """What is measured: motion of the rod, pressures of the chambers, and the flow that the pump gives."""

    time: Time
    position: Position
    velocity: Velocity
    pressure_a: Pressure
    pressure_b: Pressure
    flow: Flow


class Chapter6Loop(Params):
    """What the control works with; `load_force` is the load as believed."""

    control: DisplacementSettings
    cycle: Points
    reference: ReferenceFilter
    load_force: Force


class Chapter6Memory(NamedTuple):
    """What the control carries from sample to sample."""

    control: DisplacementMemory
    reference: Reference
    tracking: Tracking


class Chapter6Command(NamedTuple):
    """What is asked of directional valve, return valve and pump, and to be shown: the filtered `reference`, U* as
    `effort`, F_H - F_v, the pressure mode, load and mass as believed."""

    direction: SignedFraction
    opening: Fraction
    flow: Flow
    reference: Position
    reference_velocity: Velocity
    effort: ForceRate
    force_error: Force
    mode: PressureMode
    saturated: Fraction
    load_force: Force
    moving_mass: Mass


AT_REST = Chapter6Command(
    direction=0.0,
    opening=0.0,
    flow=0.0,
    reference=0.0,
    reference_velocity=0.0,
    effort=0.0,
    force_error=0.0,
    mode=0.0,
    saturated=0.0,
    load_force=0.0,
    moving_mass=0.0,
)
"""The command before the first sample."""


def chapter6_start(settings: Chapter6Loop) -> Chapter6Memory:
    """The memory before the first sample: the reference rests where its cycle begins."""
    first = reference_at_rest(cycle_position(0.0, settings.cycle))
    return Chapter6Memory(displacement_start(settings.control), first, tracking_start())


def chapter6_step(
    t: float, memory: Chapter6Memory, place: CylinderPlace, settings: Chapter6Loop
) -> tuple[Chapter6Memory, Chapter6Command]:
    """Program: one sample of the control, which ends at the tally of how well it does."""
    control, cylinder = settings.control, settings.control.cylinder
    reference = memory.reference
    pressures = CircuitPressures(place.pressure_a, place.pressure_b, cylinder.reference_pressure)
    seen = CylinderSeen(
        position=place.position,
        velocity=place.velocity,
        load_force=settings.load_force,
        fast=pressures,
        slow=pressures,
        delivered_flow=place.flow,
    )
    after, demand = displacement_step(memory.control, seen, reference, control)
    followed = Followed(
        time=place.time,
        error=place.position - reference.position,
        least_pressure=min(place.pressure_a, place.pressure_b) - cylinder.tank_pressure,
    )
    wanted = cycle_position(t + 0.5 * control.sample_period, settings.cycle)
    ahead = reference_step(reference, wanted, control.sample_period, settings.reference)
    command = Chapter6Command(
        direction=demand.direction,
        opening=demand.opening,
        flow=demand.flow,
        reference=reference.position,
        reference_velocity=reference.velocity,
        effort=demand.effort,
        force_error=demand.force_error,
        mode=demand.mode,
        saturated=demand.saturated,
        load_force=settings.load_force + after.adaptation.load_correction,
        moving_mass=after.adaptation.moving_mass,
    )
    done = Actuated(demand.direction, demand.opening, demand.mode, demand.saturated)
    return Chapter6Memory(after, ahead, tracking_step(memory.tracking, followed, done)), command
