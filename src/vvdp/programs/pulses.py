"""Programs that go by time: a cycle of points that repeats, pulses of a duty ratio."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.kinds import TIME, DutyRatio, Fraction, Frequency, Kind, Time
from vvdp.base.params import Params, field_kinds
from vvdp.base.rules import refuse, refuse_rows, refuse_together, require_positive, require_rising
from vvdp.base.select import clip, maximum, minimum, select
from vvdp.network.program import ProgramType
from vvdp.numerics.piecewise import line_through
from vvdp.programs.generic import GenericProgram, Written
from vvdp.programs.quantities import OUTPUT, Output, OutputChange, with_kinds, written_quantity

SHORTEST = 1e-9
"""Share of a period below which pulses have no width."""
NEXT = 0.999
"""Part of a period after which a count is taken as the next whole number, so that rounding does not pass an edge."""


class CycleTable(Params):
    """Points that straight lines join, or a triangle: from `lower_end` over a `stroke` and back, each way in
    `stroke_time`.

    After the last point, which is the first again, they repeat; if `repeats` is 0, the last value is held. They are
    read `preview` ahead, and with a `sample_period`, for which a value holds, in the middle of that time.
    """

    times: Annotated[tuple[float, ...], TIME] = ()
    values: Annotated[tuple[float, ...], OUTPUT] = ()
    lower_end: Output = 0.0
    stroke: OutputChange = 0.0
    stroke_time: Time = 0.0
    repeats: Fraction = 1.0
    preview: Time = 0.0
    sample_period: Time = 0.0

    def check(self) -> None:
        if self.repeats not in (0.0, 1.0):
            refuse(self, "repeats", "must be 0 or 1")
        if not self.times and not self.values:
            require_positive(self, "stroke", "stroke_time", why="give a triangle, or times and values of points")
            return
        if self.stroke or self.stroke_time:
            refuse_together(self, "stroke and stroke_time are those of a triangle; give them, or times and values")
        require_rising(self, "times")
        if len(self.times) < 2 or len(self.times) != len(self.values):
            refuse_rows(
                self, "values", f"{len(self.values)} for {len(self.times)} times; expected as many, at least two"
            )
        if self.times[0] != 0.0:
            refuse_rows(self, "times", f"begin at {self.times[0]:g} s; expected 0 s")


class Cycle(Params):
    """The points of a cycle, and how they are read; the `stroke_time` is 0 unless they are a triangle's."""

    times: Annotated[tuple[float, ...], TIME]
    values: Annotated[tuple[float, ...], OUTPUT]
    repeats: Fraction = 1.0
    preview: Time = 0.0
    sample_period: Time = 0.0
    stroke_time: Time = 0.0


class Now(NamedTuple):
    """The time."""

    time: Time


class Course(NamedTuple):
    """Value of a cycle now, and its value at time 0."""

    value: Output
    start: Output


def cycle_of(table: CycleTable) -> Cycle:
    """The points of a cycle as its step takes them; those of a triangle are its ends."""
    times, values = table.times, table.values
    if not values:
        upper = table.lower_end + table.stroke
        times, values = (0.0, table.stroke_time, 2.0 * table.stroke_time), (table.lower_end, upper, table.lower_end)
    kinds = field_kinds(type(table))
    made: type[Cycle] = with_kinds(Cycle, {OUTPUT: kinds["values"] or OUTPUT})
    rest = {key: getattr(table, key) for key in ("repeats", "preview", "sample_period", "stroke_time")}
    return made(times=times, values=values, **rest)


def cycle_value(time: float, cycle: Cycle) -> float:
    """Value of a cycle at a time [s], in the unit of its values."""
    return line_through(time + cycle.preview, cycle.times, cycle.values, cycle.repeats)


def cycle_step(t: float, memory: NamedTuple, reading: Now, settings: Cycle) -> tuple[NamedTuple, Course]:
    """Points over time, joined by straight lines, or a triangle, repeated or followed once."""
    value = cycle_value(reading.time + 0.5 * settings.sample_period, settings)
    return memory, Course(value, cycle_value(0.0, settings))


def _cycle_quantity(read: Sequence[Kind], values: Written) -> Kind:
    return written_quantity(next((values[key] for key in ("values", "lower_end", "stroke") if key in values), None))


class Pulses(Params):
    """Frequency at which pulses begin."""

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


CYCLE = GenericProgram(ProgramType(cycle_step, Now, Course(0.0, 0.0), CycleTable), _cycle_quantity, made=cycle_of)
PWM = GenericProgram(ProgramType(pwm_step, Duty, Switched(0.0), Pulses, level=pulse_count), first=_first_pulse)
