"""Displacement control of a cylinder, one sample: force law, direction, split between pump and valve, pressure modes.

Source  ours, docs/models/displacement-control.md, where a function names no other.
"""

from typing import NamedTuple

from vvdp.base.errors import ParameterError
from vvdp.base.kinds import Conductance, Flow, Force, Fraction, Position, Pressure, SignedFraction, Time, Velocity
from vvdp.base.params import Params
from vvdp.base.select import maximum
from vvdp.control.adaptation import Adaptation, AdaptationMemory
from vvdp.control.capacities import CircuitPressures, CylinderModel, capacities, oil_force, return_flow, sides
from vvdp.control.cylinder_force import DesiredForce, ForceGains, ForceRate, Motion, desired_force, total_effort
from vvdp.control.direction import DirectionMemory, DirectionSettings, direction_start, direction_step
from vvdp.control.flow_split import FlowSplit, SplitMemory, authority, split_start, split_step
from vvdp.control.pressure_modes import (
    Guards,
    PressureBounds,
    PressureMode,
    acting_mode,
    guarded_actuation,
    guards,
    limit_actuation,
    make_up,
    swept_flows,
)
from vvdp.control.reference import Reference


class SupplySupport(Params):
    """The pump gives `support_conductance` times what the line lacks to `support_pressure`, absolute; 0 is without."""

    support_conductance: Conductance = 0.0
    support_pressure: Pressure = 0.0


class DisplacementSettings(Params):
    """What the controller works with; it is called every `sample_period`."""

    cylinder: CylinderModel
    gains: ForceGains
    direction: DirectionSettings
    split: FlowSplit
    bounds: PressureBounds
    support: SupplySupport
    adaptation: Adaptation
    sample_period: Time

    def check(self) -> None:
        if not self.sample_period > 0.0:
            raise ParameterError("DisplacementSettings.sample_period: 0 s; expected a time above 0")


class CylinderSeen(NamedTuple):
    """What the controller sees: motion and load as believed, pressures as they are (`fast`) and averaged over a
    period of the pulsating supply (`slow`), and the flow that the pump delivers, as far as is known."""

    position: Position
    velocity: Velocity
    load_force: Force
    fast: CircuitPressures
    slow: CircuitPressures
    delivered_flow: Flow


class DisplacementMemory(NamedTuple):
    """What the controller carries from sample to sample; `saturated` is that of the last demand."""

    direction: DirectionMemory
    split: SplitMemory
    adaptation: AdaptationMemory
    saturated: Fraction


class DisplacementDemand(NamedTuple):
    """What is asked of the drives: `direction` of the directional valve (1 extends, 0 is closed), `opening` of the
    return valve, `flow` of the pump. The rest tells how it came about.

    `effort` is U*, `force_error` F_H - F_v, `saturated` 1 where flow and opening do not give the effort.
    """

    direction: SignedFraction
    opening: Fraction
    flow: Flow
    effort: ForceRate
    force_error: Force
    mode: PressureMode
    guards: Guards
    saturated: Fraction
    split_flow: Flow


def displacement_start(settings: DisplacementSettings) -> DisplacementMemory:
    """The memory before the first sample."""
    cylinder = settings.cylinder
    return DisplacementMemory(
        direction=direction_start(),
        split=split_start(),
        adaptation=AdaptationMemory(0.0, cylinder.moving_mass, 1.0 / cylinder.bulk_modulus),
        saturated=0.0,
    )


def idle_demand() -> DisplacementDemand:
    """What is asked while the cylinder is not controlled: valves closed, no flow."""
    return DisplacementDemand(
        direction=0.0,
        opening=0.0,
        flow=0.0,
        effort=0.0,
        force_error=0.0,
        mode=0.0,
        guards=Guards(0.0, 0.0, 0.0, 0.0),
        saturated=0.0,
        split_flow=0.0,
    )


class Effort(NamedTuple):
    """The direction, and what the force law asks for in it."""

    direction: DirectionMemory
    effort: ForceRate
    force_error: Force
    desired: DesiredForce


def wanted_effort(
    memory: DisplacementMemory, seen: CylinderSeen, reference: Reference, settings: DisplacementSettings
) -> Effort:
    """Direction and U*. The stiffness in U* depends on which chamber the line is joined to: it is that of the direction
    held so far, and after a switch that of the new one."""
    cylinder, adapted = settings.cylinder, memory.adaptation
    force = oil_force(seen.fast, cylinder)
    load = seen.load_force + adapted.load_correction
    motion = Motion(seen.position, seen.velocity, load, adapted.moving_mass)
    desired = desired_force(reference, motion, force, settings.gains, cylinder)
    share = cylinder.bulk_modulus * adapted.compliance
    before = memory.direction.direction if memory.direction.direction != 0.0 else 1.0
    S = capacities(before, seen.position, seen.slow.line_pressure, cylinder).stiffness
    effort = total_effort(S, desired, force, share, settings.gains)
    direction = direction_step(memory.direction, effort, S, settings.sample_period, settings.direction)
    if direction.direction != before:
        S = capacities(direction.direction, seen.position, seen.slow.line_pressure, cylinder).stiffness
        effort = total_effort(S, desired, force, share, settings.gains)
    return Effort(direction, effort, force - desired.force, desired)


def displacement_step(
    memory: DisplacementMemory, seen: CylinderSeen, reference: Reference, settings: DisplacementSettings
) -> tuple[DisplacementMemory, DisplacementDemand]:
    """One sample: memory and demand; the direction is 1 or -1.

    Raw pressures act in the force law, averaged ones in split, modes and capacities.

    Source  wang2017, eqs. 6.19 to 6.41, corrected: docs/errata.md
    """
    cylinder, split, bounds = settings.cylinder, settings.split, settings.bounds
    wanted = wanted_effort(memory, seen, reference, settings)
    u_d, effort = wanted.direction.direction, wanted.effort
    at = sides(u_d, seen.slow, cylinder)
    capacity = capacities(u_d, seen.position, seen.slow.line_pressure, cylinder)
    means = authority(capacity, return_flow(at.return_pressure, split.least_return_flow, cylinder))
    needed = maximum(u_d * at.supply_area * reference.velocity, 0.0)
    expected = split.expected_flow + split.feeds_forward * (needed - split.expected_flow)
    shared = split_step(memory.split, effort, expected, means, settings.sample_period, split)
    lack = maximum(settings.support.support_pressure - seen.slow.line_pressure, 0.0)
    flow = shared.flow + settings.support.support_conductance * lack
    acting = guards(at, bounds)
    asked = guarded_actuation(effort, flow, swept_flows(u_d, seen.velocity, at), acting, means, bounds)
    limited = limit_actuation(effort, asked, means, split.largest_flow)
    delivered = limited.flow + split.uses_delivered_flow * (seen.delivered_flow - limited.flow)
    opening = make_up(limited, delivered, acting, means)
    saturated = 1.0 if opening <= 0.0 or opening >= 1.0 else 0.0
    after = DisplacementMemory(wanted.direction, shared, memory.adaptation, saturated)
    return after, DisplacementDemand(
        direction=u_d,
        opening=opening,
        flow=limited.flow,
        effort=effort,
        force_error=wanted.force_error,
        mode=acting_mode(acting),
        guards=acting,
        saturated=saturated,
        split_flow=shared.flow,
    )
