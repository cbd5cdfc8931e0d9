"""The control of the chamber drive: sensor, observer, reference and law, one after the other at every sample.

`chamber_view` takes a sample in, a law says which flow is wanted, `chamber_command` makes it the valve's; the steps of
the programs, one for each law, are these three in a row.

Source  ours, docs/models/axial-control.md, where a function names no other.
"""

from typing import NamedTuple

from vvdp.base.kinds import PositionSignal
from vvdp.base.params import Params
from vvdp.base.signal import signal_value
from vvdp.control.backstepping import BacksteppingGains, backstepping_law
from vvdp.control.chamber import ChamberDrive, ChamberFlow, ChamberReading, PositionGains
from vvdp.control.orifice import valve_command
from vvdp.control.passivity import PassivityGains, passivity_law, printed_passivity_law
from vvdp.control.reference import Rate, Reference, ReferenceFilter, reference_at_rest
from vvdp.control.storage import loop_balance
from vvdp.estimation.axial_filter import AxialEstimate, AxialMemory, Phase
from vvdp.estimation.chamber_observer import ChamberObserver
from vvdp.programs.axial_loop import (
    RUN,
    AxialCommand,
    AxialPlace,
    AxialSequence,
    Demand,
    Observed,
    Stage,
    Target,
    next_reference,
    show,
    turned_phase,
)
from vvdp.programs.chamber_observer import ChamberBelief, ChamberSight, first_belief, look
from vvdp.sensing.axial_sensor import AxialSensor, SpoolPlace, axial_sensor_start, axial_sensor_step
from vvdp.sensing.instrument import InstrumentMemory


class ChamberLoop(Params):
    """Settings of the control of a chamber drive; `wanted` is the position [m].

    A velocity that no observer gives goes through a first-order filter of the `velocity_rate`.
    """

    sensor: AxialSensor
    observer: ChamberObserver
    drive: ChamberDrive
    reference: ReferenceFilter
    sequence: AxialSequence
    wanted: PositionSignal
    velocity_rate: Rate = 1e6


class PassiveLoop(ChamberLoop):
    """The loop with a passivity law."""

    gains: PassivityGains


class BacksteppingLoop(ChamberLoop):
    """The loop with backstepping."""

    gains: BacksteppingGains


class LoopMemory(NamedTuple):
    """Memory of the loop from sample to sample; `reading` is what its law received last."""

    sensor: InstrumentMemory
    observer: AxialMemory
    reference: Reference
    stage: Stage
    reading: ChamberReading


class ChamberView(NamedTuple):
    """What is known at a sample, before a law is asked."""

    sensor: InstrumentMemory
    observer: AxialMemory
    reference: Reference
    stage: Stage
    estimate: AxialEstimate
    reading: ChamberReading
    phase: Phase
    measured: float
    margin: float


def chamber_loop_start(settings: ChamberLoop) -> LoopMemory:
    """The memory before the first sample: homing, the spool about at its stop."""
    stop, belief = settings.observer.stop_position, first_belief(settings.observer)
    return LoopMemory(
        sensor=axial_sensor_start(settings.sensor),
        observer=belief.filter,
        reference=reference_at_rest(stop),
        stage=belief.stage,
        reading=ChamberReading(stop, 0.0, settings.drive.oil.reference_pressure),
    )


def chamber_view(
    memory: LoopMemory, place: AxialPlace, phase: Phase, wanted: float, settings: ChamberLoop
) -> ChamberView:
    """What is known after a sample: stage, estimate and reference.

    phase   of the periodic sensor error, as the spool's angle is known
    wanted  position [m]
    """
    observer, stop = settings.observer, settings.observer.stop_position
    sensor, signal = axial_sensor_step(
        memory.sensor, SpoolPlace(place.time, place.position, place.angle), settings.sensor
    )
    belief = ChamberBelief(memory.observer, memory.stage)
    found = look(belief, ChamberSight(signal, phase, place.pressure), observer, settings.sequence)
    stage, estimate, period = found.belief.stage, found.estimate, observer.sample_period
    return ChamberView(
        sensor=sensor,
        observer=found.belief.filter,
        reference=next_reference(memory.reference, stage, Target(wanted, stop), period, settings.reference),
        stage=stage,
        estimate=estimate,
        reading=ChamberReading(estimate.position, estimate.velocity, place.pressure),
        phase=phase,
        measured=signal.position,
        margin=found.margin,
    )


def chamber_command(
    view: ChamberView, wanted: ChamberFlow, gains: PositionGains, settings: ChamberLoop
) -> tuple[LoopMemory, AxialCommand]:
    """Memory and command: the valve's that gives the flow a law asks for; in other stages it empties the chamber."""
    drive, pressure = settings.drive, view.reading.pressure
    command, storage = -1.0, 0.0
    if view.stage.number == RUN:
        command = valve_command(wanted.flow, pressure, drive.valve)
        storage = loop_balance(wanted.flow, view.reference, view.reading, gains, drive).storage
    observed = Observed(view.phase, view.measured, view.margin)
    demand = Demand(wanted.flow, wanted.desired.pressure, storage)
    memory = LoopMemory(
        sensor=view.sensor,
        observer=view.observer,
        reference=view.reference,
        stage=view.stage,
        reading=view.reading,
    )
    return memory, show(command, view.stage, view.reference, observed, view.estimate, demand)


def passive_command(view: ChamberView, settings: PassiveLoop) -> tuple[LoopMemory, AxialCommand]:
    """What the passivity law commands of what is known."""
    flow = passivity_law(view.reference, view.reading, settings.gains, settings.drive)
    return chamber_command(view, flow, settings.gains, settings)


def printed_command(view: ChamberView, settings: PassiveLoop) -> tuple[LoopMemory, AxialCommand]:
    """The same with the published, approximate feedforward."""
    flow = printed_passivity_law(view.reference, view.reading, settings.gains, settings.drive)
    return chamber_command(view, flow, settings.gains, settings)


def backstepping_command(view: ChamberView, settings: BacksteppingLoop) -> tuple[LoopMemory, AxialCommand]:
    """The same with backstepping."""
    flow = backstepping_law(view.reference, view.reading, settings.gains, settings.drive)
    return chamber_command(view, flow, settings.gains, settings)


def turned_view(t: float, memory: LoopMemory, place: AxialPlace, settings: ChamberLoop) -> ChamberView:
    """What is known after a sample, the spool's angle known."""
    return chamber_view(memory, place, turned_phase(place), signal_value(t, settings.wanted), settings)


def passive_step(
    t: float, memory: LoopMemory, place: AxialPlace, settings: PassiveLoop
) -> tuple[LoopMemory, AxialCommand]:
    """Program: the passivity law, the spool's angle known."""
    return passive_command(turned_view(t, memory, place, settings), settings)


def printed_step(
    t: float, memory: LoopMemory, place: AxialPlace, settings: PassiveLoop
) -> tuple[LoopMemory, AxialCommand]:
    """Program: the published passivity law, the spool's angle known."""
    return printed_command(turned_view(t, memory, place, settings), settings)


def backstepping_step(
    t: float, memory: LoopMemory, place: AxialPlace, settings: BacksteppingLoop
) -> tuple[LoopMemory, AxialCommand]:
    """Program: backstepping, the spool's angle known."""
    return backstepping_command(turned_view(t, memory, place, settings), settings)
