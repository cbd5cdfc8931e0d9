"""Programs that pass on what they read, slower or within limits: low-pass, rate limit, limit, reference."""

from typing import NamedTuple

from vvdp.base.kinds import Fraction, Number, Time
from vvdp.base.params import Params
from vvdp.base.powers import expm1
from vvdp.base.rules import require_less, require_positive
from vvdp.base.select import clip
from vvdp.control.reference import Reference, ReferenceFilter, reference_at_rest, reference_step
from vvdp.network.program import ProgramType
from vvdp.programs.controllers import Limited, Value
from vvdp.programs.generic import GenericProgram
from vvdp.programs.quantities import LARGEST, Input, Output, OutputRate, SecondRate, ThirdRate


class Read(NamedTuple):
    """What is read."""

    reads: Input


class LastValue(NamedTuple):
    """The value that was given last and when, and whether there was a sample (1)."""

    value: Number
    time: Number
    begun: Fraction


def last_value_start(settings: Params) -> LastValue:
    """Before the first sample."""
    return LastValue(0.0, 0.0, 0.0)


class LowPass(Params):
    """T of 1/(T s + 1)."""

    time_constant: Time

    def check(self) -> None:
        require_positive(self, "time_constant")


def low_pass_step(t: float, memory: LastValue, reading: Read, settings: LowPass) -> tuple[LastValue, Value]:
    """First-order low-pass filter; at time t [s], exact for an input that is held, begins at the first sample."""
    value = reading.reads
    if memory.begun > 0.5:
        value = memory.value - expm1((memory.time - t) / settings.time_constant) * (reading.reads - memory.value)
    return LastValue(value, t, 1.0), Value(value)


class Rate(NamedTuple):
    """What a program gives: a rate."""

    rate: OutputRate


class SlopeMemory(NamedTuple):
    """What was read last and when, the rate then, and whether there was a sample (1)."""

    reads: Number
    time: Number
    rate: Number
    begun: Fraction


def slope_start(settings: LowPass) -> SlopeMemory:
    """Before the first sample."""
    return SlopeMemory(reads=0.0, time=0.0, rate=0.0, begun=0.0)


def slope_step(t: float, memory: SlopeMemory, reading: Read, settings: LowPass) -> tuple[SlopeMemory, Rate]:
    """Rate of what is read, behind a first-order filter; from sample to sample, at time t [s], 0 at the first."""
    rate = 0.0
    if memory.begun > 0.5:
        slope = (reading.reads - memory.reads) / (t - memory.time)
        rate = memory.rate - expm1((memory.time - t) / settings.time_constant) * (slope - memory.rate)
    return SlopeMemory(reads=reading.reads, time=t, rate=rate, begun=1.0), Rate(rate)


class RateLimit(Params):
    """How fast the command may rise and fall, both above 0."""

    rise: OutputRate
    fall: OutputRate

    def check(self) -> None:
        require_positive(self, "rise", "fall")


def rate_limit_step(t: float, memory: LastValue, reading: Read, settings: RateLimit) -> tuple[LastValue, Value]:
    """What is read, with limited rates of rise and fall; at time t [s], begins at the first sample."""
    value = reading.reads
    if memory.begun > 0.5:
        interval = t - memory.time
        value = clip(value, memory.value - settings.fall * interval, memory.value + settings.rise * interval)
    return LastValue(value, t, 1.0), Value(value)


class Limits(Limited):
    """Between which values the command stays."""

    lowest: Output = -LARGEST
    highest: Output = LARGEST

    def check(self) -> None:
        require_less(self, "lowest", "highest")


def limit_step(t: float, memory: NamedTuple, reading: Read, settings: Limits) -> tuple[NamedTuple, Value]:
    """What is read, held between limits."""
    return memory, Value(clip(reading.reads, settings.lowest, settings.highest))


class Led(NamedTuple):
    """What is read; while `released` is 0 the reference stands still at `rest`."""

    reads: Input
    released: Fraction = 1.0
    rest: Input = 0.0


class LedReference(ReferenceFilter):
    """The filter; with `leads` 1 what is read counts from the sample before on, and the reference moves a sample
    earlier than for an input that is held from now on."""

    leads: Fraction = 0.0


class Smooth(NamedTuple):
    """A smooth reference with its first three derivatives."""

    value: Output
    rate: OutputRate
    second_derivative: SecondRate
    third_derivative: ThirdRate


class SmoothMemory(NamedTuple):
    """The reference at the last sample, what was read then and when, and whether there was a sample (1)."""

    reference: Reference
    reads: Number
    time: Number
    begun: Fraction


def smooth_start(settings: LedReference) -> SmoothMemory:
    """Before the first sample."""
    return SmoothMemory(reference=reference_at_rest(0.0), reads=0.0, time=0.0, begun=0.0)


def smooth_step(t: float, memory: SmoothMemory, reading: Led, settings: LedReference) -> tuple[SmoothMemory, Smooth]:
    """What is read, smoothed by four equal poles, with its derivatives; at time t [s], exact for a held input."""
    found = reference_at_rest(reading.reads if reading.released > 0.5 else reading.rest)
    if memory.begun > 0.5 and reading.released > 0.5:
        held = reading.reads if settings.leads > 0.5 else memory.reads
        found = reference_step(memory.reference, held, t - memory.time, settings)
    after = SmoothMemory(reference=found, reads=reading.reads, time=t, begun=1.0)
    return after, Smooth(found.position, found.velocity, found.acceleration, found.jerk)


DERIVATIVE = GenericProgram(ProgramType(slope_step, Read, Rate(0.0), LowPass, slope_start))
LOW_PASS = GenericProgram(ProgramType(low_pass_step, Read, Value(0.0), LowPass, last_value_start))
RATE_LIMIT = GenericProgram(ProgramType(rate_limit_step, Read, Value(0.0), RateLimit, last_value_start))
LIMIT = GenericProgram(ProgramType(limit_step, Read, Value(0.0), Limits))
REFERENCE = GenericProgram(ProgramType(smooth_step, Led, Smooth(0.0, 0.0, 0.0, 0.0), LedReference, smooth_start))
