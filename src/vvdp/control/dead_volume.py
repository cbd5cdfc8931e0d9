"""The volume of a chamber at position 0, learned from the pressure error that a wrong one causes.

Source  ours, docs/models/passivity-control.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

from vvdp.base.kinds import Kind, Pressure, Time, Volume
from vvdp.base.params import Params
from vvdp.base.rules import require_less
from vvdp.base.select import clip
from vvdp.control.chamber import ChamberDrive, DesiredPressure
from vvdp.fluid.mixture import density_rise

VOLUME_GAIN = Kind("adaptation gain of a volume", "m^3/Pa", 0.0, 1e-3, "1e-6 m^3/Pa")

VolumeGain = Annotated[float, VOLUME_GAIN]


class VolumeLearning(Params):
    """The gain with which a volume is learned, 0 for none, its bounds, and the `pause` after a command at an end."""

    volume_gain: VolumeGain = 0.0
    lowest_volume: Volume = 1e-6
    highest_volume: Volume = 1e-3
    pause: Time = 0.3

    def check(self) -> None:
        require_less(self, "lowest_volume", "highest_volume")


class LearnedVolume(NamedTuple):
    """The volume at position 0 as learned, when, and since when the command is not at an end."""

    oil_volume: Volume
    time: Time
    free_since: Time


def volume_step(
    memory: LearnedVolume,
    time: float,
    desired: DesiredPressure,
    pressure: Pressure,
    settings: VolumeLearning,
    drive: ChamberDrive,
) -> LearnedVolume:
    """The volume at a later `time` [s]: V_0' = -g (e^g(P, P_d) - 1) P_d1', held within its bounds.

    P_d1' is the part of the rate that follows from the reference alone: noise of the pressure moves nothing at rest.

    pressure  of the chamber, absolute [Pa]

    Source  wang2017, section 7.3, which asks for it; the law is ours, docs/models/passivity-control.md
    """
    after = LearnedVolume(memory.oil_volume, time, memory.free_since)
    if not settings.volume_gain > 0.0 or time - memory.free_since < settings.pause:
        return after
    rate = -settings.volume_gain * density_rise(pressure, desired.pressure, drive.oil) * desired.known_rate
    moved = memory.oil_volume + (time - memory.time) * rate
    return after._replace(oil_volume=clip(moved, settings.lowest_volume, settings.highest_volume))
