"""The outer loop of the whole machine: what stands before the cylinder's sensors, to what every drive is asked to do.

Fast signals act in the force law and in the load observer; slow ones are averages over one PWM period.

Source  ours, docs/models/displacement-control.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import (
    Count,
    Flow,
    Force,
    Fraction,
    Length,
    Number,
    Position,
    Pressure,
    Ratio,
    SignedFraction,
    Speed,
    Time,
    Velocity,
)
from vvdp.base.params import Params
from vvdp.base.select import clip
from vvdp.base.units import ATMOSPHERE
from vvdp.control.capacities import CircuitPressures, capacities, oil_force
from vvdp.control.cylinder_force import ForceRate
from vvdp.control.direction import LONG, DirectionMemory
from vvdp.control.displacement import (
    CylinderSeen,
    DisplacementDemand,
    DisplacementMemory,
    DisplacementSettings,
    displacement_start,
    displacement_step,
    idle_demand,
)
from vvdp.control.flow_gain import FlowBalance, FlowGain, FlowGainMemory, flow_gain_start, flow_gain_step
from vvdp.control.flow_map import FlowMap, duty_for_flow, flow_for_duty
from vvdp.control.flow_split import SplitMemory
from vvdp.control.pressure_modes import PressureMode
from vvdp.control.reference import Reference, ReferenceFilter, reference_at_rest, reference_step
from vvdp.estimation.load_observer import LoadMemory, LoadObserver, load_observer_start, load_observer_step
from vvdp.estimation.period_average import AverageMemory, average_start, average_step, pwm_window
from vvdp.programs.axial_stages import HOME as AT_HOME
from vvdp.programs.axial_stages import RUN as FOLLOWS
from vvdp.programs.machine.cycle import Points, cycle_position
from vvdp.programs.machine.phases import (
    CONTROL,
    EMERGENCY,
    PRECHARGE,
    MachineSequence,
    Phase,
    Progress,
    first_phase,
    next_phase,
    orders_of,
)
from vvdp.programs.machine.supervision import (
    MachineSight,
    Supervised,
    SupervisionMemory,
    supervise,
    supervision_start,
)


class MachinePlace(NamedTuple):
    """What the sensors show, and what the control of the spool said at the last sample.

    `chamber_pressure` is that at the spool, if a chamber moves it.
    """

    time: Time
    position: Position
    pressure_a: Pressure
    pressure_b: Pressure
    line_pressure: Pressure
    pump_speed: Speed
    spool_stage: Count
    spool_known: Fraction
    spool_position: Position
    spool_speed: Speed
    spool_measured: Position
    spool_reference: Position
    chamber_pressure: Pressure = ATMOSPHERE


class SpoolRange(Params):
    """How the spool's position makes a duty ratio, between which it moves, and how many PWM periods a turn has."""

    helix_length: Length
    rest_position: Position
    highest_position: Position
    sections: Count


class MachineLoop(Params):
    """What the program works with: laws, beliefs, what is followed, and how it starts and stops.

    `load_force` is the load as expected before it is estimated, `first_direction` that of the cycle's first move.
    """

    law: DisplacementSettings
    observer: LoadObserver
    reference: ReferenceFilter
    points: Points
    sequence: MachineSequence
    flow_map: FlowMap
    gain: FlowGain
    spool: SpoolRange
    load_force: Force
    first_direction: SignedFraction
    supervised: Supervised

    @property
    def command_range(self) -> dict[str, tuple[float, float]]:
        """Between which positions the spool is asked to be [m]."""
        return {"spool_position": (self.spool.rest_position, self.spool.highest_position)}


class MachineMemory(NamedTuple):
    """What is carried from sample to sample; `wanted` is the raw position, held once a stop is asked for, `begin` when
    control of the cylinder began, infinite before."""

    begin: Time
    phase: Phase
    reference: Reference
    wanted: Position
    observer: LoadMemory
    averages: AverageMemory
    law: DisplacementMemory
    gain: FlowGainMemory
    direction: SignedFraction
    opening: Fraction
    supervision: SupervisionMemory


class MachineCommand(NamedTuple):
    """What the drives are asked to do, and what is believed and wanted, to be shown.

    `direction` 1 extends the cylinder, `opening` is that of the return valve; `pump` and `energised` are 1 where motor
    and axial drive are switched on, `dump` 1 holds the dump valve closed; `follows` is 1 while the cylinder follows its
    cycle. Pressures are averages over a PWM period.
    """

    direction: SignedFraction
    opening: Fraction
    pump: Fraction
    dump: Fraction
    energised: Fraction
    follows: Fraction
    spool_position: Position
    phase: Count
    wanted: Position
    reference: Position
    reference_velocity: Velocity
    position: Position
    velocity: Velocity
    load_force: Force
    pressure_a: Pressure
    pressure_b: Pressure
    line_pressure: Pressure
    effort: ForceRate
    force_error: Force
    mode: PressureMode
    saturated: Fraction
    flow: Flow
    split_flow: Flow
    duty_ratio: Number
    map_gain: Ratio
    alarm: Count


IDLE = MachineCommand(
    direction=0.0,
    opening=0.0,
    pump=0.0,
    dump=1.0,
    energised=1.0,
    follows=0.0,
    spool_position=0.0,
    phase=first_phase().number,
    wanted=0.0,
    reference=0.0,
    reference_velocity=0.0,
    position=0.0,
    velocity=0.0,
    load_force=0.0,
    pressure_a=101325.0,
    pressure_b=101325.0,
    line_pressure=101325.0,
    effort=0.0,
    force_error=0.0,
    mode=0.0,
    saturated=0.0,
    flow=0.0,
    split_flow=0.0,
    duty_ratio=0.0,
    map_gain=1.0,
    alarm=0.0,
)
"""The command before the first sample."""


def machine_start(settings: MachineLoop) -> MachineMemory:
    """The memory before the first sample: homing, all valves closed."""
    lowest = settings.law.cylinder.lowest_position
    return MachineMemory(
        begin=np.inf,
        phase=first_phase(),
        reference=reference_at_rest(lowest),
        wanted=lowest,
        observer=load_observer_start(lowest, settings.load_force),
        averages=average_start(3),
        law=law_start(settings),
        gain=flow_gain_start(),
        direction=0.0,
        opening=0.0,
        supervision=supervision_start(),
    )


def law_start(settings: MachineLoop) -> DisplacementMemory:
    """The memory of the laws before control, the directional valve about to open the way of the cycle's first move,
    and the pump giving what the line was charged with."""
    start = displacement_start(settings.law)
    return DisplacementMemory(
        direction=DirectionMemory(settings.first_direction, LONG),
        split=SplitMemory(settings.sequence.precharge_flow, start.split.variance),
        adaptation=start.adaptation,
        saturated=start.saturated,
    )


def progress_of(place: MachinePlace, settings: MachineLoop) -> Progress:
    """What the sequence is reported; the chamber that is filled first is that of the cycle's first move."""
    supply = place.pressure_a if settings.first_direction > 0.0 else place.pressure_b
    return Progress(
        homed=1.0 if place.spool_stage > AT_HOME else 0.0,
        known=place.spool_known,
        learned=1.0 if place.spool_stage >= FOLLOWS else 0.0,
        line_pressure=place.line_pressure,
        supply=supply,
        above_stop=place.spool_position - settings.spool.rest_position,
    )


def next_followed(
    memory: MachineMemory, phase: Phase, place: MachinePlace, settings: MachineLoop
) -> tuple[float, Reference]:
    """The raw position and the reference at a sample: the cycle's while it is followed, the last one when it is held,
    and where the cylinder is in all other phases."""
    if phase.number == CONTROL:
        wanted = cycle_position(place.time - phase.since, settings.points)
    elif orders_of(phase.number).controlled > 0.0:
        wanted = memory.wanted
    else:
        return place.position, reference_at_rest(place.position)
    period = settings.law.sample_period
    return wanted, reference_step(memory.reference, wanted, period, settings.reference)


class MachineView(NamedTuple):
    """What is known at a sample, before the laws are asked."""

    phase: Phase
    wanted: Position
    reference: Reference
    observer: LoadMemory
    averages: AverageMemory
    supervision: SupervisionMemory
    seen: CylinderSeen


def machine_sight(
    memory: MachineMemory, place: MachinePlace, slow: CircuitPressures, velocity: float, settings: MachineLoop
) -> MachineSight:
    """What the supervision looks at.

    slow      pressures averaged over a PWM period [Pa]
    velocity  as believed [m/s]
    """
    period = settings.law.sample_period
    return MachineSight(
        time=place.time,
        watched=1.0 if memory.phase.number == CONTROL else 0.0,
        position=place.position,
        expected=memory.observer.position + period * memory.observer.velocity,
        velocity=velocity,
        fast=CircuitPressures(place.pressure_a, place.pressure_b, place.line_pressure),
        slow=slow,
        direction=memory.direction,
        opening=memory.opening,
        spool_measured=place.spool_measured,
        spool_position=place.spool_position,
        spool_reference=place.spool_reference,
        spool_speed=place.spool_speed,
        chamber_pressure=place.chamber_pressure if settings.supervised.spring.stiffness > 0.0 else np.nan,
        pump_speed=place.pump_speed,
    )


def machine_view(memory: MachineMemory, place: MachinePlace, settings: MachineLoop) -> MachineView:
    """What is known after a sample: phase, reference, motion and load, raw and averaged pressures."""
    fast = CircuitPressures(place.pressure_a, place.pressure_b, place.line_pressure)
    observer = load_observer_step(
        memory.observer, place.position, oil_force(fast, settings.law.cylinder), settings.observer
    )
    window = pwm_window(place.spool_speed, settings.spool.sections, settings.law.sample_period)
    averages, means = average_step(memory.averages, np.array(fast), window)
    slow = CircuitPressures(means[0], means[1], means[2])
    supervision = supervise(
        memory.supervision, machine_sight(memory, place, slow, observer.velocity, settings), settings.supervised
    )
    phase = next_phase(memory.phase, place.time, progress_of(place, settings), settings.sequence)
    if supervision.alarm.alarm > 0.0 and phase.number != EMERGENCY:
        phase = Phase(EMERGENCY, place.time)
    wanted, reference = next_followed(memory, phase, place, settings)
    opened = flow_for_duty(place.spool_position / settings.spool.helix_length, slow.line_pressure, settings.flow_map)
    return MachineView(
        phase=phase,
        wanted=wanted,
        reference=reference,
        observer=observer,
        averages=averages,
        supervision=supervision,
        seen=CylinderSeen(
            position=observer.position,
            velocity=observer.velocity,
            load_force=observer.load_force,
            fast=fast,
            slow=slow,
            delivered_flow=memory.gain.gain * opened,
        ),
    )


def controlled_demand(
    memory: MachineMemory, view: MachineView, settings: MachineLoop
) -> tuple[DisplacementMemory, DisplacementDemand]:
    """What the laws ask for while the cylinder is controlled; else valves closed, and no flow."""
    if orders_of(view.phase.number).controlled > 0.0:
        return displacement_step(memory.law, view.seen, view.reference, settings.law)
    return law_start(settings), idle_demand()


def learned_gain(memory: MachineMemory, view: MachineView, direction: float, settings: MachineLoop) -> FlowGainMemory:
    """The gain of the flow map a sample later; it rests while the cylinder is not controlled or its valve moves.

    direction  that is asked for now [1]
    """
    cylinder, seen = settings.law.cylinder, view.seen
    is_fed = direction != 0.0 and direction == memory.direction
    side = direction if is_fed else 1.0
    area = cylinder.area_a if side > 0.0 else cylinder.area_b
    H = capacities(side, seen.position, seen.slow.line_pressure, cylinder).supply_gain
    balance = FlowBalance(
        mapped=seen.delivered_flow / memory.gain.gain,
        swept=side * area * seen.velocity,
        pressure=seen.slow.line_pressure,
        capacity=area / abs(H),
        rests=1.0 if is_fed else 0.0,
    )
    return flow_gain_step(memory.gain, balance, settings.law.sample_period, settings.gain)


class SpoolDemand(NamedTuple):
    """The mean flow that is asked for, and what lets it through: duty ratio, position of the spool, gain of the map."""

    flow: Flow
    duty_ratio: Number
    position: Position
    map_gain: Ratio


def spool_demand(flow: float, view: MachineView, gain: float, settings: MachineLoop) -> SpoolDemand:
    """Where the spool should be: at rest while no flow may come, else as map and gain have it.

    flow  that the laws ask for [m^3/s]
    gain  of the flow map [1]
    """
    spool, number = settings.spool, view.phase.number
    if number == PRECHARGE:
        flow = settings.sequence.precharge_flow
    elif orders_of(number).controlled == 0.0:
        return SpoolDemand(0.0, spool.rest_position / spool.helix_length, spool.rest_position, gain)
    duty = duty_for_flow(flow / gain, view.seen.slow.line_pressure, settings.flow_map)
    position = clip(duty * spool.helix_length, spool.rest_position, spool.highest_position)
    return SpoolDemand(flow, duty, position, gain)


def machine_step(
    t: float,
    memory: MachineMemory,
    place: MachinePlace,
    settings: MachineLoop,
) -> tuple[MachineMemory, MachineCommand]:
    """Control of a whole machine: its stages and alarms, displacement control of its cylinder, and the position of the
    spool that gives the flow which this takes."""
    view = machine_view(memory, place, settings)
    law, demand = controlled_demand(memory, view, settings)
    return carried_out(memory, view, law, demand, settings)


def carried_out(
    memory: MachineMemory,
    view: MachineView,
    law: DisplacementMemory,
    demand: DisplacementDemand,
    settings: MachineLoop,
) -> tuple[MachineMemory, MachineCommand]:
    """Memory and command after a sample in which a position loop has asked for a `demand`; `law` is its memory."""
    gain = learned_gain(memory, view, demand.direction, settings)
    spool = spool_demand(demand.flow, view, gain.gain, settings)
    after = MachineMemory(
        begin=min(memory.begin, view.phase.since) if view.phase.number == CONTROL else memory.begin,
        phase=view.phase,
        reference=view.reference,
        wanted=view.wanted,
        observer=view.observer,
        averages=view.averages,
        law=law,
        gain=gain,
        direction=demand.direction,
        opening=demand.opening,
        supervision=view.supervision,
    )
    return after, shown_command(view, demand, spool)


def shown_command(view: MachineView, demand: DisplacementDemand, spool: SpoolDemand) -> MachineCommand:
    """The command of a sample, with what is believed and wanted."""
    orders = orders_of(view.phase.number)
    seen, slow, reference = view.seen, view.seen.slow, view.reference
    return MachineCommand(
        direction=demand.direction,
        opening=demand.opening,
        pump=orders.pump,
        dump=orders.energised,
        energised=orders.energised,
        follows=1.0 if view.phase.number == CONTROL else 0.0,
        spool_position=spool.position,
        phase=view.phase.number,
        wanted=view.wanted,
        reference=reference.position,
        reference_velocity=reference.velocity,
        position=seen.position,
        velocity=seen.velocity,
        load_force=seen.load_force,
        pressure_a=slow.pressure_a,
        pressure_b=slow.pressure_b,
        line_pressure=slow.line_pressure,
        effort=demand.effort,
        force_error=demand.force_error,
        mode=demand.mode,
        saturated=demand.saturated,
        flow=spool.flow,
        split_flow=demand.split_flow,
        duty_ratio=spool.duty_ratio,
        map_gain=spool.map_gain,
        alarm=view.supervision.alarm.alarm,
    )
