"""The loop of the gerotor drive with the other observers: lumped filter, signal generator, and basis in time.

Source  ours, docs/models/gerotor-control.md, where a function names no other.
"""

from typing import NamedTuple

from vvdp.base.signal import signal_value
from vvdp.estimation.noise_clock import ClockedGerotor, ClockedMemory, clocked_gerotor_start, clocked_gerotor_step
from vvdp.estimation.signal_generator import (
    GeneratorMemory,
    GeneratorObserver,
    LumpedMemory,
    LumpedObserver,
    generator_observer_step,
    generator_start,
    lumped_observer_step,
)
from vvdp.programs.axial_loop import AxialCommand, turned_phase
from vvdp.programs.gerotor_loop import (
    DriveMemory,
    GerotorControl,
    GerotorPlace,
    GerotorView,
    drive_start,
    gerotor_view,
    position_command,
)


class LumpedLoop(GerotorControl):
    """The loop with the lumped filter."""

    observer: LumpedObserver


class GeneratorLoop(GerotorControl):
    """The loop with the signal generator."""

    observer: GeneratorObserver


class ClockedLoop(GerotorControl):
    """The loop with a basis in time."""

    observer: ClockedGerotor


class LumpedLoopMemory(NamedTuple):
    """What loop and observer carry from sample to sample."""

    drive: DriveMemory
    observer: LumpedMemory


class GeneratorLoopMemory(NamedTuple):
    """What loop and observer carry from sample to sample."""

    drive: DriveMemory
    observer: GeneratorMemory


class ClockedLoopMemory(NamedTuple):
    """What loop and observer carry from sample to sample."""

    drive: DriveMemory
    observer: ClockedMemory


def lumped_loop_start(settings: LumpedLoop) -> LumpedLoopMemory:
    """The memory before the first sample."""
    return LumpedLoopMemory(drive_start(settings), LumpedMemory(settings.stop_position, 0.0))


def generator_loop_start(settings: GeneratorLoop) -> GeneratorLoopMemory:
    """The memory before the first sample."""
    return GeneratorLoopMemory(drive_start(settings), generator_start(settings.observer, settings.stop_position))


def clocked_loop_start(settings: ClockedLoop) -> ClockedLoopMemory:
    """The memory before the first sample."""
    return ClockedLoopMemory(drive_start(settings), clocked_gerotor_start(settings.observer, settings.stop_position))


def view_turned(t: float, memory: DriveMemory, place: GerotorPlace, settings: GerotorControl) -> GerotorView:
    """What is known at a sample, the spool's angle with it; `t` [s]."""
    return gerotor_view(memory, place, turned_phase(place), signal_value(t, settings.wanted), settings)


def lumped_step(
    t: float, memory: LumpedLoopMemory, place: GerotorPlace, settings: LumpedLoop
) -> tuple[LumpedLoopMemory, AxialCommand]:
    """Program: the lumped filter tells the position."""
    view = view_turned(t, memory.drive, place, settings)
    observer, estimate = lumped_observer_step(memory.observer, view.seen, settings.observer)
    drive, command = position_command(view, estimate, settings)
    return LumpedLoopMemory(drive, observer), command


def generator_step(
    t: float, memory: GeneratorLoopMemory, place: GerotorPlace, settings: GeneratorLoop
) -> tuple[GeneratorLoopMemory, AxialCommand]:
    """Program: the signal generator tells the position."""
    view = view_turned(t, memory.drive, place, settings)
    observer, estimate = generator_observer_step(memory.observer, view.seen, settings.observer)
    drive, command = position_command(view, estimate, settings)
    return GeneratorLoopMemory(drive, observer), command


def clocked_step(
    t: float, memory: ClockedLoopMemory, place: GerotorPlace, settings: ClockedLoop
) -> tuple[ClockedLoopMemory, AxialCommand]:
    """Program: the periodic Kalman filter with a basis in time tells the position."""
    view = view_turned(t, memory.drive, place, settings)
    observer, estimate = clocked_gerotor_step(memory.observer, view.seen, settings.observer)
    drive, command = position_command(view, estimate, settings)
    return ClockedLoopMemory(drive, observer), command
