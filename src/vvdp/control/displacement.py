"""Displacement control of a cylinder, one sample: force law, direction, split between pump and valve, pressure modes.

Source  ours, docs/models/displacement-control.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

from vvdp.base.kinds import Conductance, Flow, Force, Fraction, Position, Pressure, SignedFraction, Time, Velocity
from vvdp.base.params import Params, without_effect
from vvdp.base.rules import require_positive
from vvdp.base.select import maximum
from vvdp.control.adaptation import Adaptation, AdaptationMemory, Excitation, adaptation_start, adaptation_step
from vvdp.control.capacities import (
    Capacities,
    CircuitPressures,
    CylinderModel,
    capacities,
    oil_force,
    return_flow,
    sides,
)
from vvdp.control.cylinder_force import ForceGains, ForceRate, Motion, desired_force, total_effort
from vvdp.control.direction import DirectionMemory, DirectionSettings, direction_start, direction_step
from vvdp.control.flow_split import Authority, FlowSplit, SplitMemory, authority, split_start, split_step
from vvdp.control.pressure_modes import (
    Actuation,
    Guards,
    PressureBounds,
    PressureMode,
    Swept,
    acting_mode,
    guarded_actuation,
    guards,
    limit_actuation,
    make_up,
    swept_flows,
)
from vvdp.control.printed_modes import printed_actuation
from vvdp.control.reference import Reference


class SupplySupport(Params):
    """The pump delivers `support_conductance` times the deficit of the line to `support_pressure`, absolute; 0 is
    without."""

    support_conductance: Conductance = 0.0
    support_pressure: Annotated[Pressure, without_effect("support_conductance")] = 0.0


class DisplacementSettings(Params):
    """Parameters of the controller; it is called every `sample_period`."""

    cylinder: CylinderModel
    gains: ForceGains
    direction: DirectionSettings
    split: FlowSplit
    bounds: PressureBounds
    support: SupplySupport
    adaptation: Adaptation
    sample_period: Time

    def check(self) -> None:
        require_positive(self, "sample_period")


class CylinderSeen(NamedTuple):
    """Inputs of the controller: motion and load as estimated, pressures as measured (`fast`) and averaged over a period
    of the pulsating supply (`slow`), and the flow that the pump delivers, as far as it is known."""

    position: Position
    velocity: Velocity
    load_force: Force
    fast: CircuitPressures
    slow: CircuitPressures
    delivered_flow: Flow


class DisplacementMemory(NamedTuple):
    """Memory of the controller from sample to sample; `saturated` is that of the last demand."""

    direction: DirectionMemory
    split: SplitMemory
    adaptation: AdaptationMemory
    saturated: Fraction


class DisplacementDemand(NamedTuple):
    """Demand on the drives: `direction` of the directional valve (1 extends, 0 is closed), `opening` of the return
    valve, `flow` of the pump. The other fields show how the demand was calculated.

    `effort` is U*, `force_error` F_H - F_v, `saturated` 1 where the opening is at an end.
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
        adaptation=adaptation_start(cylinder.moving_mass, cylinder.bulk_modulus),
        saturated=0.0,
    )


def idle_demand() -> DisplacementDemand:
    """Demand while the cylinder is not controlled: valves closed, no flow."""
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
    """The direction, the effort that the force law demands in it, and the signals and capacities behind both."""

    direction: DirectionMemory
    effort: ForceRate
    excitation: Excitation
    capacity: Capacities


def wanted_effort(
    memory: DisplacementMemory, seen: CylinderSeen, reference: Reference, settings: DisplacementSettings
) -> Effort:
    """Direction and U*. The stiffness in U* depends on which chamber the line is joined to: it is that of the direction
    held so far, and after a switch that of the new one."""
    cylinder, adapted, gains, line = settings.cylinder, memory.adaptation, settings.gains, seen.slow.line_pressure
    force = oil_force(seen.fast, cylinder)
    motion = Motion(seen.position, seen.velocity, seen.load_force + adapted.load_correction, adapted.moving_mass)
    desired = desired_force(reference, motion, force, gains, cylinder)
    share = cylinder.bulk_modulus * adapted.compliance
    before = memory.direction.direction if memory.direction.direction != 0.0 else 1.0
    capacity = capacities(before, seen.position, line, cylinder)
    effort = total_effort(capacity.stiffness, desired, force, share, gains)
    direction = direction_step(memory.direction, effort, capacity.stiffness, settings.sample_period, settings.direction)
    if direction.direction != before:
        capacity = capacities(direction.direction, seen.position, line, cylinder)
        effort = total_effort(capacity.stiffness, desired, force, share, gains)
    excitation = Excitation(
        load_force=seen.load_force,
        velocity_error=desired.velocity_error,
        reference_acceleration=desired.reference_acceleration,
        force_error=force - desired.force,
        force_rate=desired.rate,
        slenderness=capacity.stiffness / cylinder.bulk_modulus,
    )
    return Effort(direction, effort, excitation, capacity)


class Shared(NamedTuple):
    """Values of a sample before the pressure modes apply: effort, split, authority of the drives, and the chambers.

    `flow` is that of the split with the support of the supply.
    """

    wanted: Effort
    split: SplitMemory
    flow: Flow
    authority: Authority
    swept: Swept
    acting: Guards


def share_effort(
    memory: DisplacementMemory, seen: CylinderSeen, reference: Reference, settings: DisplacementSettings
) -> Shared:
    """The effort and how the split shares it.

    Raw pressures act in the force law, averaged ones in split, modes and capacities.
    """
    split, support = settings.split, settings.support
    wanted = wanted_effort(memory, seen, reference, settings)
    u_d = wanted.direction.direction
    at = sides(u_d, seen.slow, settings.cylinder)
    full_return = return_flow(at.return_pressure, split.least_return_flow, settings.cylinder)
    means = authority(wanted.capacity, full_return)
    needed = maximum(u_d * at.supply_area * reference.velocity, 0.0)
    expected = split.expected_flow + split.feeds_forward * (needed - split.expected_flow)
    shared = split_step(memory.split, wanted.effort, expected, means, settings.sample_period, split)
    lack = maximum(support.support_pressure - seen.slow.line_pressure, 0.0)
    return Shared(
        wanted=wanted,
        split=shared,
        flow=shared.flow + support.support_conductance * lack,
        authority=means,
        swept=swept_flows(u_d, seen.velocity, at),
        acting=guards(at, settings.bounds),
    )


def learn(memory: DisplacementMemory, wanted: Effort, settings: DisplacementSettings) -> AdaptationMemory:
    """Adapted parameters after this sample; unchanged while the opening is at an end or just after a switch."""
    if memory.saturated > 0.0 or wanted.direction.held_for < settings.adaptation.pause:
        return memory.adaptation
    return adaptation_step(memory.adaptation, wanted.excitation, settings.sample_period, settings.adaptation)


def meet_limits(
    memory: DisplacementMemory, delivered: float, shared: Shared, asked: Actuation, settings: DisplacementSettings
) -> tuple[DisplacementMemory, DisplacementDemand]:
    """Memory and demand: the demand of the modes, within the limits of pump and valve.

    delivered  flow of the pump, as far as is known [m^3/s]
    """
    wanted, split = shared.wanted, settings.split
    limited = limit_actuation(wanted.effort, asked, shared.authority, split.largest_flow)
    missing = split.uses_delivered_flow * (limited.flow - delivered)
    opening = make_up(limited.opening, missing, shared.acting, shared.authority)
    saturated = 1.0 if opening <= 0.0 or opening >= 1.0 else 0.0
    after = DisplacementMemory(wanted.direction, shared.split, learn(memory, wanted, settings), saturated)
    return after, DisplacementDemand(
        direction=wanted.direction.direction,
        opening=opening,
        flow=limited.flow,
        effort=wanted.effort,
        force_error=wanted.excitation.force_error,
        mode=acting_mode(shared.acting),
        guards=shared.acting,
        saturated=saturated,
        split_flow=shared.split.flow,
    )


def displacement_step(
    memory: DisplacementMemory, seen: CylinderSeen, reference: Reference, settings: DisplacementSettings
) -> tuple[DisplacementMemory, DisplacementDemand]:
    """One sample: memory and demand; the direction is 1 or -1.

    Source  wang2017, eqs. 6.19 to 6.41, corrected: docs/errata.md
    """
    s = share_effort(memory, seen, reference, settings)
    asked = guarded_actuation(s.wanted.effort, s.flow, s.swept, s.acting, s.authority, settings.bounds)
    return meet_limits(memory, seen.delivered_flow, s, asked, settings)


def printed_displacement_step(
    memory: DisplacementMemory, seen: CylinderSeen, reference: Reference, settings: DisplacementSettings
) -> tuple[DisplacementMemory, DisplacementDemand]:
    """The same with the pressure modes as published, for comparison.

    Source  wang2017, eqs. 6.19 to 6.41
    """
    s = share_effort(memory, seen, reference, settings)
    asked = printed_actuation(s.wanted.effort, s.flow, s.swept, s.acting, s.authority, settings.bounds)
    return meet_limits(memory, seen.delivered_flow, s, asked, settings)
