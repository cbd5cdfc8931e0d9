"""Supervision of the whole machine: what shows that a sensor, a valve, the spool or the power has failed.

Source  ours, docs/models/faults.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import (
    Area,
    Count,
    Flow,
    Force,
    Fraction,
    Length,
    Position,
    Pressure,
    PressureDifference,
    SignedFraction,
    Speed,
    SpeedSignal,
    Stiffness,
    Time,
    Velocity,
)
from vvdp.base.params import Params
from vvdp.base.powers import expm1
from vvdp.base.rules import require_less, require_positive
from vvdp.base.select import maximum
from vvdp.base.signal import signal_value
from vvdp.control.capacities import CircuitPressures, CylinderModel, capacities, return_flow, sides
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
    "spool position jumps",
    "spool position error too large",
    "spool does not turn",
    "pump has lost its speed",
    "spool position and chamber pressure disagree",
    "pressure sensor jumps",
)
"""Monitored faults, in the order of the numbers of alarms, from 1 on."""


class Supervision(Params):
    """The [supervision] table: limits, and for how long each may be passed.

    Sensors may show `position_margin` beyond the stroke and pressures between two limits; none shows the same number
    `repeats` times; readings jump no further than so in a sample. Line and supply chamber, return flow and motion,
    spring and chamber are compared as means over the `averaging_time`, the first two from `settle_time` after a change
    of direction on; the flow may be off by `return_share` of itself besides. What is out of range, frozen or jumps is
    reported at once, spool speed and pump after the `brief_time`, disagreements after the `patience`.
    """

    position_margin: Length = 5e-3
    lowest_pressure: Pressure = 0.5e5
    highest_pressure: Pressure = 150e5
    repeats: Count = 20.0
    position_jump: Length = 3e-3
    pressure_jump: PressureDifference = 7e5
    line_difference: PressureDifference = 2e5
    return_difference: Flow = 2.5 / 6e4
    return_share: Fraction = 0.1
    settle_time: Time = 0.1
    averaging_time: Time = 0.06
    optical_jump: Length = 1.8e-3
    spring_difference: Length = 3e-3
    spool_error: Length = 0.6e-3
    lowest_spool_speed: Speed = 40.0
    lowest_pump_share: Fraction = 0.95
    brief_time: Time = 8e-3
    patience: Time = 0.03

    def check(self) -> None:
        limits = (
            *(
                "repeats",
                "position_jump",
                "pressure_jump",
                "line_difference",
                "return_difference",
                "averaging_time",
                "optical_jump",
            ),
            *("spring_difference", "spool_error", "lowest_spool_speed", "lowest_pump_share"),
        )
        require_positive(self, *limits)
        require_less(self, "lowest_pressure", "highest_pressure")


class SpoolSpring(Params):
    """The spring that holds the spool against its chamber: A (P - P_0) = F_0 + k x at rest; k = 0 without one."""

    stiffness: Stiffness
    preload: Force
    area: Area
    reference_pressure: Pressure


NO_SPRING = SpoolSpring(stiffness=0.0, preload=0.0, area=1e-4, reference_pressure=101325.0)
"""Of a drive that no spring holds."""


class Supervised(Params):
    """Parameters of the supervision: whether it `watches`, its limits, and cylinder, spring, pump speed and sample
    period of the machine."""

    watches: Fraction
    limits: Supervision
    cylinder: CylinderModel
    spring: SpoolSpring
    pump_speed: SpeedSignal
    sample_period: Time


class MachineSight(NamedTuple):
    """Inputs of the supervision in a sample: measured values as they come, estimates, and the commands of the last
    sample.

    `watched` is 1 while the cylinder is controlled. `expected` is the position that the load observer expected, `slow`
    are pressures averaged over a PWM period. `spool_measured` is from the optical sensor, `chamber_pressure` that
    at the spool, nan where no chamber moves it: it is then not monitored.
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
    spool_position: Position
    spool_reference: Position
    spool_speed: Speed
    chamber_pressure: Pressure
    pump_speed: Speed


class SupervisionMemory(NamedTuple):
    """Memory from sample to sample: the alarm, repeated measured values, the time of the last change of direction,
    averaged pressures, and the mean differences of line, return flow and spring."""

    alarm: AlarmMemory
    repeated: RepeatMemory
    direction: SignedFraction
    since: Time
    slow: CircuitPressures
    line_off: PressureDifference
    flow_off: Flow
    spring_off: Position


def supervision_start() -> SupervisionMemory:
    """The memory before the first sample."""
    rest = CircuitPressures(101325.0, 101325.0, 101325.0)
    return SupervisionMemory(
        alarm=alarm_start(len(WATCHED)),
        repeated=repeat_start(6),
        direction=0.0,
        since=0.0,
        slow=rest,
        line_off=0.0,
        flow_off=0.0,
        spring_off=0.0,
    )


class Differences(NamedTuple):
    """Difference of the line's pressure from the supply chamber's, and of the return flow from the flow that the
    cylinder sweeps, which is the third field."""

    line: PressureDifference
    flow: Flow
    swept: Flow


def differences(sight: MachineSight, before: CircuitPressures, settings: Supervised) -> Differences:
    """P_L - P_s, and K_v u sqrt(P_r - P_T) + C_r P_r' - A_r v: what leaves the return chamber and what stays in it.

    before  averaged pressures a sample earlier [Pa]
    """
    cylinder, direction = settings.cylinder, sight.direction
    at, then = sides(direction, sight.slow, cylinder), sides(direction, before, cylinder)
    flow = return_flow(at.return_pressure, 0.0, cylinder) * sight.opening
    capacity = at.return_area / abs(
        capacities(direction, sight.position, sight.slow.line_pressure, cylinder).return_gain
    )
    stays = capacity * (at.return_pressure - then.return_pressure) / settings.sample_period
    swept = direction * sight.velocity * at.return_area
    return Differences(sight.slow.line_pressure - at.supply_pressure, flow + stays - swept, abs(swept))


def spring_difference(sight: MachineSight, spring: SpoolSpring) -> float:
    """Position at which the chamber's pressure holds the spring, minus the estimated position of the spool [m]; 0
    without a spring."""
    if spring.stiffness == 0.0:
        return 0.0
    force = spring.area * (sight.chamber_pressure - spring.reference_pressure) - spring.preload
    return force / spring.stiffness - sight.spool_position


def supervise(memory: SupervisionMemory, sight: MachineSight, settings: Supervised) -> SupervisionMemory:
    """The memory after a sample: its alarm is the number of what was reported first, 0 before."""
    limits, fast = settings.limits, sight.fast
    readings = np.array(
        (
            sight.position,
            fast.pressure_a,
            fast.pressure_b,
            fast.line_pressure,
            sight.spool_measured,
            sight.chamber_pressure,
        )
    )
    repeated = repeat_step(memory.repeated, readings)
    changed = sight.direction != memory.direction
    since = sight.time if changed else memory.since
    off = Differences(0.0, 0.0, 0.0)
    if sight.direction != 0.0 and sight.time - since >= limits.settle_time:
        off = differences(sight, memory.slow, settings)
    share = -expm1(-settings.sample_period / limits.averaging_time)
    line_off = memory.line_off + share * (off.line - memory.line_off)
    flow_off = memory.flow_off + share * (off.flow - memory.flow_off)
    spring_off = memory.spring_off + share * (spring_difference(sight, settings.spring) - memory.spring_off)
    residuals = sensor_residuals(sight, memory.repeated.last, repeated.repeats, settings)
    residuals[6] = abs(line_off) / limits.line_difference
    residuals[7] = abs(flow_off) / (limits.return_difference + limits.return_share * off.swept)
    residuals[12] = abs(spring_off) / limits.spring_difference
    if sight.watched * settings.watches == 0.0:  # at rest a reading may stay the same, and the stop holds the spool
        residuals[:] = 0.0
        repeated, spring_off = RepeatMemory(repeated.last, np.zeros(len(readings))), 0.0
    told = alarm_step(memory.alarm, sight.time, residuals, patiences(limits), settings.sample_period)
    return SupervisionMemory(
        alarm=told,
        repeated=repeated,
        direction=sight.direction,
        since=since,
        slow=sight.slow,
        line_off=line_off,
        flow_off=flow_off,
        spring_off=spring_off,
    )


def patiences(limits: Supervision) -> tuple[float, ...]:
    """Time for which each limit may be exceeded [s], in the order of `WATCHED`: the time of averaging has passed
    already."""
    brief, long = limits.brief_time, limits.patience
    return (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, long, long, 0.0, long, brief, brief, long, 0.0)


def sensor_residuals(sight: MachineSight, last: Array, repeats: Array, settings: Supervised) -> Array:
    """All residuals over their limits, the mean ones left at 0, in the order of `WATCHED`.

    last     readings a sample before [SI]
    repeats  of the readings [1]
    """
    limits, cylinder, fast = settings.limits, settings.cylinder, sight.fast
    found = np.zeros(len(WATCHED))
    middle = 0.5 * (cylinder.lowest_position + cylinder.highest_position)
    reach = 0.5 * (cylinder.highest_position - cylinder.lowest_position) + limits.position_margin
    pressures, chamber = (fast.pressure_a, fast.pressure_b, fast.line_pressure), sight.chamber_pressure
    lowest, highest = min(pressures), max(pressures)
    is_outside = lowest < limits.lowest_pressure or highest > limits.highest_pressure
    is_outside = is_outside or chamber < limits.lowest_pressure or chamber > limits.highest_pressure
    found[0] = abs(sight.position - middle) / reach
    found[1] = 2.0 if is_outside else 0.0
    found[2] = repeats[0] / limits.repeats
    found[3] = maximum(np.max(repeats[1:4]), repeats[5]) / limits.repeats
    found[4] = repeats[4] / limits.repeats
    found[5] = abs(sight.position - sight.expected) / limits.position_jump
    found[8] = abs(sight.spool_measured - last[4]) / limits.optical_jump
    found[9] = abs(sight.spool_position - sight.spool_reference) / limits.spool_error
    found[10] = limits.lowest_spool_speed / maximum(abs(sight.spool_speed), 1e-9)
    changes = (fast.pressure_a - last[1], fast.pressure_b - last[2], fast.line_pressure - last[3])
    found[13] = max(max(changes), -min(changes)) / limits.pressure_jump
    rated = signal_value(sight.time, settings.pump_speed)
    found[11] = limits.lowest_pump_share * rated / maximum(sight.pump_speed, 1e-9)
    return found
