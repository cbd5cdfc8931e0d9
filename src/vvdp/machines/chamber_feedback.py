"""What else a law of the chamber drive may receive than an observer's estimate: the sensor as it is, or the truth.

Both are there to be compared with. The observer runs along, and is shown, but it is not used.

Source  ours, docs/models/axial-control.md, where a function names no other.
"""

import numpy as np

from vvdp.base.params import Params
from vvdp.base.rules import require_positive
from vvdp.base.signal import signal_value
from vvdp.control.chamber import ChamberReading
from vvdp.control.reference import Rate
from vvdp.estimation.axial_filter import Phase
from vvdp.programs.axial_loop import AxialCommand, AxialPlace, turned_phase
from vvdp.programs.chamber_loop import (
    BacksteppingLoop,
    ChamberLoop,
    ChamberView,
    LoopMemory,
    PassiveLoop,
    backstepping_command,
    chamber_view,
    passive_command,
    printed_command,
)


class VelocityFilter(Params):
    """A velocity goes through a first-order filter of the `velocity_rate`, 2 pi times its frequency."""

    velocity_rate: Rate

    def check(self) -> None:
        require_positive(self, "velocity_rate")


class RawFeedback(VelocityFilter):
    """The [raw_feedback] table: the law receives the sensor's position, with its periodic error, and its filtered
    slope.
    """


def low_pass(before: float, velocity: float, settings: ChamberLoop) -> float:
    """The velocity [m/s] after a sample, from the one before it and the new one."""
    fading: float = np.exp(-settings.velocity_rate * settings.observer.sample_period)
    return velocity + fading * (before - velocity)


def raw_view(memory: LoopMemory, place: AxialPlace, phase: Phase, wanted: float, settings: ChamberLoop) -> ChamberView:
    """What is known after a sample, the law being shown what the sensor shows; at the stop the spool stands still."""
    view = chamber_view(memory, place, phase, wanted, settings)
    slope = (view.measured - memory.reading.position) / settings.observer.sample_period
    velocity = 0.0 if view.stage.held > 0.0 else low_pass(memory.reading.velocity, slope, settings)
    return view._replace(reading=ChamberReading(view.measured, velocity, place.pressure))


def turned_raw_view(t: float, memory: LoopMemory, place: AxialPlace, settings: ChamberLoop) -> ChamberView:
    """The same, the spool's angle known."""
    return raw_view(memory, place, turned_phase(place), signal_value(t, settings.wanted), settings)


def raw_passive_step(
    t: float, memory: LoopMemory, place: AxialPlace, settings: PassiveLoop
) -> tuple[LoopMemory, AxialCommand]:
    """Program: the passivity law, shown what the sensor shows; the spool's angle known."""
    return passive_command(turned_raw_view(t, memory, place, settings), settings)


def raw_printed_step(
    t: float, memory: LoopMemory, place: AxialPlace, settings: PassiveLoop
) -> tuple[LoopMemory, AxialCommand]:
    """Program: the published passivity law, shown what the sensor shows; the spool's angle known."""
    return printed_command(turned_raw_view(t, memory, place, settings), settings)


def raw_backstepping_step(
    t: float, memory: LoopMemory, place: AxialPlace, settings: BacksteppingLoop
) -> tuple[LoopMemory, AxialCommand]:
    """Program: backstepping, shown what the sensor shows; the spool's angle known."""
    return backstepping_command(turned_raw_view(t, memory, place, settings), settings)
