"""Supervision of the whole machine: what tells that a sensor, a valve, the spool or the power has failed.

Source  ours, docs/models/faults.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ParameterError
from vvdp.base.kinds import (
    Count,
    Fraction,
    Length,
    Position,
    Pressure,
    PressureDifference,
    SignedFraction,
    Speed,
    SpeedSignal,
    Time,
    Velocity,
)
from vvdp.base.params import Params
from vvdp.base.powers import expm1
from vvdp.base.select import maximum, minimum
from vvdp.base.signal import signal_value
from vvdp.control.capacities import CircuitPressures, CylinderModel, sides
from vvdp.control.supervision import (
    AlarmMemory,
    RepeatMemory,
    alarm_start,
    alarm_step,
    repeat_start,
    repeat_step,
)

WATCHED = (
    "position sensor out of range",
    "pressure sensor out of range",
    "position sensor frozen",
    "pressure sensor frozen",
    "optical sensor frozen",
    "position jumps",
    "line and supply chamber disagree",
    "return pressure and return flow disagree",
    "optical sensor and observer disagree",
    "spool does not go where it should",
    "spool does not turn",
    "pump has lost its speed",
)
"""What is watched, in the order of the numbers of alarms, from 1 on."""

OPENED = 0.05
"""Opening of the return valve below which its flow says nothing [1]."""
MOVING = 5e-3
"""Velocity of the cylinder below which it says nothing [m/s]."""


class Supervision(Params):
    """The [supervision] table: limits, and for how long each may be passed.

    Sensors may show `position_margin` beyond the stroke and pressures between two limits; none shows the same number
    `repeats` times. Pressures are compared from `settle_time` after a change of direction on, as means over the
    `averaging_time`; the return pressure may be off by `return_share` of itself besides. What is out of range, frozen
    or jumps is told at once, light, spool speed and pump after the `brief_time`, disagreements after the `patience`.
    """

    position_margin: Length = 5e-3
    lowest_pressure: Pressure = 0.5e5
    highest_pressure: Pressure = 150e5
    repeats: Count = 20.0
    position_jump: Length = 1e-3
    line_difference: PressureDifference = 2e5
    return_difference: PressureDifference = 3e5
    return_share: Fraction = 0.3
    settle_time: Time = 0.2
    averaging_time: Time = 0.03
    optical_difference: Length = 0.5e-3
    spool_error: Length = 3e-3
    lowest_spool_speed: Speed = 40.0
    lowest_pump_share: Fraction = 0.95
    brief_time: Time = 2.5e-3
    patience: Time = 0.03

    def check(self) -> None:
        limits = ("repeats", "position_jump", "line_difference", "return_difference", "averaging_time",
                  "optical_difference", "spool_error", "lowest_spool_speed", "lowest_pump_share")  # fmt: skip
        for name in limits:
            if not getattr(self, name) > 0.0:
                raise ParameterError(f"Supervision.{name}: 0; expected a value above 0")
        if not self.lowest_pressure < self.highest_pressure:
            raise ParameterError(
                f"Supervision.lowest_pressure: {self.lowest_pressure:g} Pa is not below the highest, "
                f"{self.highest_pressure:g} Pa"
            )


class Supervised(Params):
    """What is watched, if it `watches`, and what the machine is: its cylinder, the speed of its pump, the period of the
    samples."""

    watches: Fraction
    limits: Supervision
    cylinder: CylinderModel
    pump_speed: SpeedSignal
    sample_period: Time


class MachineSight(NamedTuple):
    """What is looked at in a sample: readings as they come, what is believed, and what was commanded before.

    `watched` is 1 while the cylinder is controlled. `expected` is the position that the load observer expected, `slow`
    are pressures averaged over a PWM period. `spool_seen` is what the optical sensor shows less the pollution that is
    believed.
    """

    time: Time
    watched: Fraction
    position: Position
    expected: Position
    velocity: Velocity
    fast: CircuitPressures
    slow: CircuitPressures
    direction: SignedFraction
    opening: Fraction
    spool_measured: Position
    spool_seen: Position
    spool_position: Position
    spool_reference: Position
    spool_speed: Speed
    pump_speed: Speed


class SupervisionMemory(NamedTuple):
    """What is carried from sample to sample: the alarm, repeated readings, since when a direction holds, and mean
    differences of pressures."""

    alarm: AlarmMemory
    repeated: RepeatMemory
    direction: SignedFraction
    since: Time
    line_off: PressureDifference
    return_off: PressureDifference


def supervision_start() -> SupervisionMemory:
    """The memory before the first sample."""
    return SupervisionMemory(alarm_start(len(WATCHED)), repeat_start(5), 0.0, 0.0, 0.0, 0.0)


class Differences(NamedTuple):
    """By how much pressures disagree with what they should be; the second against what it should be."""

    line: PressureDifference
    back: PressureDifference
    expected_back: PressureDifference


def pressure_differences(sight: MachineSight, cylinder: CylinderModel) -> Differences:
    """The line against the supply chamber, and the return pressure against (A_r v/(K_v u))^2 + P_T.

    The second is 0 where valve or cylinder hardly move.
    """
    at = sides(sight.direction, sight.slow, cylinder)
    swept = maximum(sight.direction * sight.velocity, 0.0) * at.return_area
    line = sight.slow.line_pressure - at.supply_pressure
    if sight.opening < OPENED or abs(sight.velocity) < MOVING:
        return Differences(line, 0.0, 0.0)
    expected = (swept / (cylinder.return_conductance * sight.opening)) ** 2
    return Differences(line, at.return_pressure - cylinder.tank_pressure - expected, expected)


def supervise(memory: SupervisionMemory, sight: MachineSight, settings: Supervised) -> SupervisionMemory:
    """The memory after a sample: its alarm is the number of what was told first, 0 before."""
    limits, fast = settings.limits, sight.fast
    readings = np.array((sight.position, fast.pressure_a, fast.pressure_b, fast.line_pressure, sight.spool_measured))
    repeated = repeat_step(memory.repeated, readings)
    changed = sight.direction != memory.direction
    since = sight.time if changed else memory.since
    off = Differences(0.0, 0.0, 0.0)
    if sight.direction != 0.0 and sight.time - since >= limits.settle_time:
        off = pressure_differences(sight, settings.cylinder)
    share = -expm1(-settings.sample_period / limits.averaging_time)
    line_off = memory.line_off + share * (off.line - memory.line_off)
    return_off = memory.return_off + share * (off.back - memory.return_off)
    allowed = limits.return_difference + limits.return_share * off.expected_back
    residuals = sensor_residuals(sight, repeated.repeats, settings)
    residuals[6] = abs(line_off) / limits.line_difference
    residuals[7] = abs(return_off) / allowed
    if sight.watched * settings.watches == 0.0:
        residuals[:] = 0.0
    brief, long = limits.brief_time, limits.patience
    patience = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, long, long, brief, long, brief, brief)
    told = alarm_step(memory.alarm, sight.time, residuals, patience, settings.sample_period)
    return SupervisionMemory(told, repeated, sight.direction, since, line_off, return_off)


def sensor_residuals(sight: MachineSight, repeats: Array, settings: Supervised) -> Array:
    """All residuals over their limits, those of the pressures' disagreement left at 0, in the order of `WATCHED`."""
    limits, cylinder, fast = settings.limits, settings.cylinder, sight.fast
    found = np.zeros(len(WATCHED))
    middle = 0.5 * (cylinder.lowest_position + cylinder.highest_position)
    reach = 0.5 * (cylinder.highest_position - cylinder.lowest_position) + limits.position_margin
    lowest = minimum(minimum(fast.pressure_a, fast.pressure_b), fast.line_pressure)
    highest = maximum(maximum(fast.pressure_a, fast.pressure_b), fast.line_pressure)
    found[0] = abs(sight.position - middle) / reach
    found[1] = 2.0 if lowest < limits.lowest_pressure or highest > limits.highest_pressure else 0.0
    found[2] = repeats[0] / limits.repeats
    found[3] = np.max(repeats[1:4]) / limits.repeats
    found[4] = repeats[4] / limits.repeats
    found[5] = abs(sight.position - sight.expected) / limits.position_jump
    found[8] = abs(sight.spool_seen - sight.spool_position) / limits.optical_difference
    found[9] = abs(sight.spool_position - sight.spool_reference) / limits.spool_error
    found[10] = limits.lowest_spool_speed / maximum(abs(sight.spool_speed), 1e-9)
    rated = signal_value(sight.time, settings.pump_speed)
    found[11] = limits.lowest_pump_share * rated / maximum(sight.pump_speed, 1e-9)
    return found
