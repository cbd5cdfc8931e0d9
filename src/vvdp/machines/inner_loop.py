"""The axial drives as the machine's inner loop: another program shows the position and whether they are energised.

Source  ours, docs/models/displacement-control.md
"""

from typing import NamedTuple

from vvdp.base.kinds import Angle, Fraction, Position, Pressure, Speed, Time
from vvdp.programs.axial_loop import STOP, AxialCommand, AxialPlace, Stage
from vvdp.programs.chamber_loop import WatchedLoop, WatchedMemory, passive_axial_step
from vvdp.programs.gerotor_loop import (
    GerotorMemory,
    GerotorPlace,
    WatchedGerotor,
    WatchedGerotorMemory,
    gerotor_axial_step,
)
from vvdp.programs.spool_encoder import watched_phase
from vvdp.sensing.encoder import Shaft


class LedPlace(NamedTuple):
    """What stands before the sensors of a chamber drive, the position that is wanted, and whether it is energised."""

    time: Time
    angle: Angle
    speed: Speed
    position: Position
    pressure: Pressure
    wanted: Position
    energised: Fraction


class LedGerotorPlace(NamedTuple):
    """The same of a gerotor drive."""

    time: Time
    angle: Angle
    speed: Speed
    position: Position
    wanted: Position
    energised: Fraction


def led_step(
    t: float, memory: WatchedMemory, place: LedPlace, settings: WatchedLoop
) -> tuple[WatchedMemory, AxialCommand]:
    """Program: the passivity law holds the position that another program wants, until it takes the energy away."""
    watch, phase = watched_phase(t, memory.watch, Shaft(place.time, place.angle, place.speed), settings.watch)
    before = memory.loop
    loop = before._replace(stage=_stage(before.stage, place.energised, place.time))
    seen = AxialPlace(place.time, place.angle, place.speed, place.position, place.pressure)
    loop, command = passive_axial_step(loop, seen, phase, place.wanted, settings.loop)
    return WatchedMemory(watch, loop), command


def led_gerotor_step(
    t: float, memory: WatchedGerotorMemory, place: LedGerotorPlace, settings: WatchedGerotor
) -> tuple[WatchedGerotorMemory, AxialCommand]:
    """Program: the same of a gerotor drive."""
    watch, phase = watched_phase(t, memory.watch, Shaft(place.time, place.angle, place.speed), settings.watch)
    before = memory.loop.drive
    drive = before._replace(stage=_stage(before.stage, place.energised, place.time))
    seen = GerotorPlace(place.time, place.angle, place.speed, place.position)
    memory_then = GerotorMemory(drive, memory.loop.observer)
    loop, command = gerotor_axial_step(memory_then, seen, phase, place.wanted, settings.loop)
    return WatchedGerotorMemory(watch, loop), command


def _stage(stage: Stage, energised: float, time: float) -> Stage:
    return stage if energised > 0.0 or stage.number == STOP else Stage(STOP, time, stage.held)
