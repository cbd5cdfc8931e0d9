"""Programs that go by time: a cycle of points that repeats, pulses of a duty ratio."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.kinds import TIME, DutyRatio, Fraction, Frequency, Kind, Time
from vvdp.base.params import Params
from vvdp.base.rules import refuse_rows, require_positive, require_rising
from vvdp.base.select import clip, maximum, minimum, select
from vvdp.network.program import ProgramType
from vvdp.numerics.piecewise import piecewise_linear
from vvdp.programs.controllers import Value
from vvdp.programs.generic import GenericProgram, Written
from vvdp.programs.quantities import OUTPUT, written_quantity

SHORTEST = 1e-9
"""Share of a period below which pulses have no width."""
NEXT = 0.999
"""How near to the next whole number a count comes before its edge: rounding is not to carry it over."""


class Points(Params):
    """Points that straight lines join; after the last one, which is the first again, they repeat."""

    times: Annotated[tuple[float, ...], TIME]
    values: Annotated[tuple[float, ...], OUTPUT]

    def check(self) -> None:
        require_rising(self, "times")
        if len(self.times) < 2 or len(self.times) != len(self.values):
            refuse_rows(
                self, "values", f"{len(self.values)} for {len(self.times)} times; expected as many, at least two"
            )
        if self.times[0] != 0.0:
            refuse_rows(self, "times", f"begin at {self.times[0]:g} s; expected 0 s")


class Now(NamedTuple):
    """The time."""

    time: Time


def cycle_step(t: float, memory: NamedTuple, reading: Now, settings: Points) -> tuple[NamedTuple, Value]:
    """Points over time, joined by straight lines and repeated."""
    period = settings.times[len(settings.times) - 1]
    within = reading.time - period * np.floor(reading.time / period)
    return memory, Value(piecewise_linear(within, settings.times, settings.values))


def _cycle_quantity(read: Sequence[Kind], values: Written) -> Kind:
    return written_quantity(values.get("values"))


class Pulses(Params):
    """How often a second a pulse begins."""

    frequency: Frequency

    def check(self) -> None:
        require_positive(self, "frequency")


class Duty(NamedTuple):
    """The duty ratio that is to be kept."""

    time: Time
    reads: DutyRatio


class Switched(NamedTuple):
    """The command of a switching valve: 1 within a pulse, else 0."""

    value: Fraction


def pulse_count(reading: Duty, settings: Pulses) -> float:
    """Twice the periods since t = 0; odd from the end of the pulse on. Its floor changes at each edge [1]."""
    share, periods = clip(reading.reads, 0.0, 1.0), reading.time * settings.frequency
    whole = np.floor(periods)
    within = periods - whole
    rising = within / maximum(share, SHORTEST)
    falling = 1.0 + (within - share) / maximum(1.0 - share, SHORTEST)
    count: float = 2.0 * whole + select(within < share, minimum(rising, NEXT), minimum(falling, 1.0 + NEXT))
    return count


def pulse_command(reading: Duty, settings: Pulses) -> float:
    """1 within a pulse, else 0 [1]."""
    count = np.floor(pulse_count(reading, settings))
    command: float = 1.0 - (count - 2.0 * np.floor(count / 2.0))
    return command


def pwm_step(t: float, memory: NamedTuple, reading: Duty, settings: Pulses) -> tuple[NamedTuple, Switched]:
    """Pulses of a duty ratio; a duty ratio that changes within a period acts at once."""
    return memory, Switched(pulse_command(reading, settings))


def _first_pulse(settings: Pulses, reading: Duty) -> Switched:
    return Switched(pulse_command(reading, settings))


CYCLE = GenericProgram(ProgramType(cycle_step, Now, Value(0.0), Points), _cycle_quantity)
PWM = GenericProgram(ProgramType(pwm_step, Duty, Switched(0.0), Pulses, level=pulse_count), first=_first_pulse)
