"""PI and PID controllers as programs: of any quantity, with limits, anti-windup and a bumpless start."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.kinds import Kind, Ratio, Time
from vvdp.base.params import Params, default_values
from vvdp.base.rules import refuse, require_less, require_positive
from vvdp.control.pid import PidGains, PidMemory, Sample, pid_start, pid_step
from vvdp.network.program import ProgramType
from vvdp.programs.generic import GenericProgram, Written
from vvdp.programs.quantities import LARGEST, Gain, Input, Output, Plain, of_gain


class Limited(Params):
    """Parameters `lowest` and `highest` of a command `value`."""

    @property
    def command_range(self) -> dict[str, tuple[float, float]]:
        """The limits; infinite unless they are given."""
        usual = default_values(type(self))
        low, high = (getattr(self, key) for key in ("lowest", "highest"))
        return {"value": (-np.inf if low == usual["lowest"] else low, np.inf if high == usual["highest"] else high)}


class Pi(Limited):
    """K, T_i, the limits of the command and its start value; a `tracking_time` of 0 clamps the integral."""

    gain: Gain
    reset_time: Time
    lowest: Output = -LARGEST
    highest: Output = LARGEST
    start: Output = 0.0
    setpoint_weight: Plain = 1.0
    tracking_time: Time = 0.0

    def check(self) -> None:
        require_positive(self, "reset_time")
        require_less(self, "lowest", "highest")


class Pid(Pi):
    """A PI controller with a derivative of the measured value, filtered with `derivative_time`/`filter_ratio`."""

    derivative_time: Time
    filter_ratio: Ratio = 10.0

    def check(self) -> None:
        require_positive(self, "derivative_time")
        if not self.filter_ratio >= 1.0:
            refuse(self, "filter_ratio", "must be at least 1; usual values are 2 to 20")


class Controlled(NamedTuple):
    """Measured value, its reference, and an addition to the command."""

    reads: Input
    reference: Input
    feedforward: Output = 0.0


class Value(NamedTuple):
    """Output of a program."""

    value: Output


def controller_start(settings: Pi) -> PidMemory:
    """Before the first sample."""
    return pid_start()


def pi_program_step(t: float, memory: PidMemory, reading: Controlled, settings: Pi) -> tuple[PidMemory, Value]:
    """PI controller with limits, anti-windup and a bumpless start; one sample at time t [s]."""
    return _sample(t, memory, reading, settings, 0.0, 0.0)


def pid_program_step(t: float, memory: PidMemory, reading: Controlled, settings: Pid) -> tuple[PidMemory, Value]:
    """PID controller with limits, anti-windup, a bumpless start and a filtered derivative; one sample at time t [s]."""
    filter_time = settings.derivative_time / settings.filter_ratio
    return _sample(t, memory, reading, settings, settings.derivative_time, filter_time)


def _sample(
    t: float, memory: PidMemory, reading: Controlled, settings: Pi, derivative_time: float, filter_time: float
) -> tuple[PidMemory, Value]:
    """One sample at time t [s] of either controller; derivative and filter time [s]."""
    gains = PidGains(
        gain=settings.gain,
        reset_time=settings.reset_time,
        derivative_time=derivative_time,
        filter_time=filter_time,
        setpoint_weight=settings.setpoint_weight,
        tracking_time=settings.tracking_time,
        lowest=settings.lowest,
        highest=settings.highest,
        start=settings.start,
    )
    sample = Sample(reading.reads, reading.reference, reading.feedforward)
    after, command = pid_step(t, memory, sample, gains)
    return after, Value(command)


def _by_gain(read: Sequence[Kind], values: Written) -> Kind:
    return of_gain(values.get("gain"), read[0])


def _controller(step: Callable[..., Any], settings: type[Pi]) -> GenericProgram:
    kind = ProgramType(step, Controlled, Value(0.0), settings, controller_start)
    return GenericProgram(kind, _by_gain, follows="gain times what is read")


PI = _controller(pi_program_step, Pi)
PID = _controller(pid_program_step, Pid)
