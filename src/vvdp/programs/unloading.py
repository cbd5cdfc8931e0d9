"""The program of an unloading valve: a pump is unloaded above one pressure and loaded again below another.

Which of the two it is between them is a mode, not a state: it jumps, and belongs to a program that an event calls. It
commands the valve `unloading_valve`.
"""

from typing import NamedTuple

from vvdp.base.kinds import Fraction, Pressure
from vvdp.base.params import Params
from vvdp.base.rules import require_less
from vvdp.base.select import clip, select
from vvdp.network.program import ProgramType

AT_LEVEL = 1e-6
"""Share of the distance of the two pressures within which one counts as reached: an event is found to rounding only."""


class UnloadingSettings(Params):
    """Unloads from `cut_out_pressure` on and loads again below `cut_in_pressure`."""

    cut_out_pressure: Pressure
    cut_in_pressure: Pressure

    def check(self) -> None:
        require_less(self, "cut_in_pressure", "cut_out_pressure")


class UnloadingReading(NamedTuple):
    """Measured value of the program."""

    pilot_pressure: Pressure


class UnloadingMemory(NamedTuple):
    """Memory of the program: 1 while the pump is unloaded."""

    unloaded: Fraction


class UnloadingCommand(NamedTuple):
    """Command of the program: 1 while the pump is to be unloaded."""

    unloaded: Fraction


def unloading_start(settings: UnloadingSettings) -> UnloadingMemory:
    """Loaded."""
    return UnloadingMemory(0.0)


def unloading_level(reading: UnloadingReading, settings: UnloadingSettings) -> float:
    """Level of the pilot pressure [1]: 0 at cut-in and 1 at cut-out; its floor changes there and nowhere else.

    reading  pilot pressure, absolute [Pa]
    """
    low, high = settings.cut_in_pressure, settings.cut_out_pressure
    level: float = clip((reading.pilot_pressure - low) / (high - low), -0.5, 1.5)
    return level


def unloading_step(
    t: float, memory: UnloadingMemory, reading: UnloadingReading, settings: UnloadingSettings
) -> tuple[UnloadingMemory, UnloadingCommand]:
    """Unloaded from cut-out on, loaded from cut-in down, and as before in between."""
    level = unloading_level(reading, settings)
    kept = select(level <= AT_LEVEL, 0.0, memory.unloaded)
    unloaded = select(level >= 1.0 - AT_LEVEL, 1.0, kept)
    return UnloadingMemory(unloaded), UnloadingCommand(unloaded)


UNLOADING = ProgramType(
    step=unloading_step,
    reading=UnloadingReading,
    command=UnloadingCommand(0.0),
    settings=UnloadingSettings,
    start=unloading_start,
    level=unloading_level,
)
