"""Direction that a directional valve gives a cylinder: the sign of the demanded effort, with hysteresis and dwell.

Source  ours, docs/models/displacement-control.md, where a function names no other.
"""

from typing import NamedTuple

from vvdp.base.kinds import SignedFraction, Time, Velocity
from vvdp.base.params import Params
from vvdp.base.select import minimum
from vvdp.control.cylinder_force import ForceRate


class DirectionSettings(Params):
    """A direction is left where the effort reaches `hysteresis` + `hysteresis_velocity` S the other way, and after a
    `dwell` at the earliest; all three 0 give the bare sign."""

    hysteresis: ForceRate = 0.0
    hysteresis_velocity: Velocity = 0.0
    dwell: Time = 0.0


class DirectionMemory(NamedTuple):
    """The direction, 0 before the first sample, and for how long it has been held."""

    direction: SignedFraction
    held_for: Time


LONG = 1e3
"""Upper limit of `held_for` [s]."""


def direction_start() -> DirectionMemory:
    """The memory before the first sample: the sign alone decides."""
    return DirectionMemory(0.0, LONG)


def direction_step(
    memory: DirectionMemory, effort: float, stiffness: float, interval: float, settings: DirectionSettings
) -> DirectionMemory:
    """The direction, 1 or -1, and for how long it has been held.

    effort     U* [N/s]
    stiffness  S of the cylinder, which scales the hysteresis [N/m]
    interval   since the last sample [s]

    Source  wang2017, eq. 6.25; hysteresis and dwell are ours, docs/models/displacement-control.md
    """
    held_for = minimum(memory.held_for + interval, LONG)
    wanted = 1.0 if effort >= 0.0 else -1.0
    if memory.direction == 0.0:
        return DirectionMemory(wanted, LONG)
    threshold = settings.hysteresis + settings.hysteresis_velocity * stiffness
    if wanted != memory.direction and abs(effort) >= threshold and held_for >= settings.dwell:
        return DirectionMemory(wanted, 0.0)
    return DirectionMemory(memory.direction, held_for)
