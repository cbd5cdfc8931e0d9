"""PI and PID controllers of any quantity: filtered derivative, limits, anti-windup, bumpless start.

Source  astrom2021, sections 11.4 and 11.5 (back-calculation, setpoint weight, filtered derivative), sampled backwards
"""

from typing import NamedTuple

from vvdp.base.kinds import Fraction, Number, Time
from vvdp.base.select import clip, minimum


class PidGains(NamedTuple):
    """Parameters of a controller: u = K (b r - y) + integral of K/T_i (r - y) - K T_d filtered dy/dt + feedforward.

    gain             K [unit of u per unit of y]
    reset_time       T_i [s]
    derivative_time  T_d, 0 without a derivative [s]
    filter_time      of the first-order filter of the derivative [s]
    setpoint_weight  b [1]
    tracking_time    of the back-calculation, 0: the integral is clamped instead [s]
    lowest, highest  limits of u
    start            u at the first sample
    """

    gain: Number
    reset_time: Time
    derivative_time: Time
    filter_time: Time
    setpoint_weight: Number
    tracking_time: Time
    lowest: Number
    highest: Number
    start: Number


class PidMemory(NamedTuple):
    """The integral and derivative terms, what was measured last and when, and whether there was a sample (1)."""

    integral: Number
    derivative: Number
    measured: Number
    time: Number
    begun: Fraction


class Sample(NamedTuple):
    """Inputs of a controller: y, r and a feedforward."""

    measured: float
    reference: float
    feedforward: float


def pid_start() -> PidMemory:
    """The memory before the first sample."""
    return PidMemory(0.0, 0.0, 0.0, 0.0, 0.0)


def pid_step(t: float, memory: PidMemory, sample: Sample, gains: PidGains) -> tuple[PidMemory, float]:
    """The memory and the command u of a sample at time t [s].

    The first command is `start`, held between the limits. Later the integral stands still where the command is at a
    limit and the error drives it beyond (clamping), or is led back by the excess over the limit (back-calculation).
    """
    y, error = sample.measured, sample.reference - sample.measured
    proportional = gains.gain * (gains.setpoint_weight * sample.reference - y) + sample.feedforward
    if memory.begun < 0.5:
        first = clip(gains.start, gains.lowest, gains.highest)
        return PidMemory(first - proportional, 0.0, y, t, 1.0), first
    interval = t - memory.time
    derivative = 0.0
    if gains.derivative_time > 0.0:
        fast = gains.gain * gains.derivative_time * (y - memory.measured)
        derivative = (gains.filter_time * memory.derivative - fast) / (gains.filter_time + interval)
    grown = memory.integral + gains.gain * interval / gains.reset_time * error
    asked = proportional + grown + derivative
    command = clip(asked, gains.lowest, gains.highest)
    if gains.tracking_time > 0.0:
        grown = grown + minimum(interval / gains.tracking_time, 1.0) * (command - asked)
    elif gains.gain * error * (asked - command) > 0.0:
        grown = memory.integral
        command = clip(proportional + grown + derivative, gains.lowest, gains.highest)
    return PidMemory(grown, derivative, y, t, 1.0), command
