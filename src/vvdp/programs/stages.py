"""Programs for the sequence of a machine: comparator, sequence of stages, supervision.

Source  ours, docs/programs.md
"""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.kinds import COUNT, TIME, Count, Fraction, Kind, Number, Time
from vvdp.base.params import Params
from vvdp.base.rules import refuse_rows, require_less
from vvdp.control.supervision import AlarmMemory, alarm_start, alarm_step
from vvdp.network.program import ProgramType
from vvdp.programs.controllers import Value
from vvdp.programs.filters import Read
from vvdp.programs.generic import GenericProgram, Written
from vvdp.programs.quantities import (
    LARGEST,
    OUTPUT,
    PLAIN,
    Fourth,
    Input,
    Output,
    Plain,
    Second,
    Third,
    written_quantity,
)

ROUNDING = 1e-9
"""Tolerance by which a time counts as reached earlier, since sample times are rounded [s]."""
CONDITIONS = 4
"""Inputs of a sequence."""
YES = 0.5
"""Above this a condition holds."""


class Levels(Params):
    """Switches to 1 at `on_level` and back to 0 at `off_level`, which may lie below or above; each has to be reached
    for `hold_time` without a break."""

    on_level: Input
    off_level: Input
    hold_time: Time = 0.0


class LevelMemory(NamedTuple):
    """The last output, and since when the other level is reached [s]; -1 while it is not."""

    value: Fraction
    since: Number


def level_start(settings: Levels) -> LevelMemory:
    """Off."""
    return LevelMemory(0.0, -1.0)


def comparator_step(t: float, memory: LevelMemory, reading: Read, settings: Levels) -> tuple[LevelMemory, Value]:
    """1 from one level on until another is reached, else 0; at time t [s], begins with 0."""
    on, off = settings.on_level, settings.off_level
    sign = 1.0 if on >= off else -1.0
    turns = sign * (reading.reads - on) >= 0.0
    if memory.value > YES:
        turns = sign * (reading.reads - off) <= 0.0 and not turns
    since = -1.0
    if turns:
        since = memory.since if memory.since >= 0.0 else t
    value = memory.value
    if turns and t - since >= settings.hold_time - ROUNDING:
        value, since = 1.0 - value, -1.0
    return LevelMemory(value, since), Value(value)


class Conditions(NamedTuple):
    """Conditions that end the first four stages, each where it is above 0.5; `emergency` leads to the last stage for
    good."""

    first: Plain = 0.0
    second: Plain = 0.0
    third: Plain = 0.0
    fourth: Plain = 0.0
    emergency: Plain = 0.0


class Stages(Params):
    """The value of each stage, and how long each lasts at most; without a time limit for the last one that stays,
    with one the first stage follows it.

    `after_time_limit` are the numbers of the stages to which the time limits lead, the next ones where it is left out;
    the first stage is 1.
    """

    values: Annotated[tuple[float, ...], OUTPUT]
    time_limits: Annotated[tuple[float, ...], TIME]
    after_time_limit: Annotated[tuple[float, ...], COUNT] = ()

    def check(self) -> None:
        stages, limits, after = len(self.values), len(self.time_limits), self.after_time_limit
        if stages < 2 or limits not in (stages - 1, stages):
            few = max(stages, 2)
            expected = f"expected {few - 1} (the last stage stays) or {few} (the first one follows it)"
            refuse_rows(self, "time_limits", f"{limits} for {stages} values; {expected}")
        if after and len(after) != limits:
            refuse_rows(self, "after_time_limit", f"{len(after)} for {limits} time_limits; expected one for each")
        if not all(each in range(1, stages + 1) for each in after):
            refuse_rows(self, "after_time_limit", f"{[*after]}; expected numbers of stages, 1 to {stages}")


class StageMemory(NamedTuple):
    """Number of the stage and since when [s], how many ended by their time limit, 1 after an emergency, and whether
    there was a sample (1)."""

    stage: Count
    since: Number
    timed_out: Count
    stopped: Fraction
    begun: Fraction


class StageCommand(NamedTuple):
    """The value of the stage, its number from 1 on, for how long it lasts, and how many ended by their time limit."""

    value: Output
    stage: Count = 1.0
    time: Time = 0.0
    timed_out: Count = 0.0


def stage_start(settings: Stages) -> StageMemory:
    """The memory in the first stage."""
    return StageMemory(stage=1.0, since=0.0, timed_out=0.0, stopped=0.0, begun=0.0)


def sequence_step(
    t: float, memory: StageMemory, reading: Conditions, settings: Stages
) -> tuple[StageMemory, StageCommand]:
    """Stages one after the other, each until its condition or its time limit; at time t [s], one change at a sample."""
    stages, limits = len(settings.values), len(settings.time_limits)
    since = memory.since if memory.begun > YES else t
    stage, timed_out, stopped = memory.stage, memory.timed_out, memory.stopped
    if reading.emergency > YES and stopped < YES:
        stage, since, stopped = float(stages), t, 1.0
    elif stage <= limits and stopped < YES:
        place = int(stage) - 1
        following = stage + 1.0 if stage < stages else 1.0
        if _condition(place, reading) > YES:
            stage, since = following, t
        elif t - since >= settings.time_limits[place] - ROUNDING:
            stage = settings.after_time_limit[place] if len(settings.after_time_limit) > 0 else following
            since, timed_out = t, timed_out + 1.0
    after = StageMemory(stage=stage, since=since, timed_out=timed_out, stopped=stopped, begun=1.0)
    value = settings.values[int(stage) - 1]
    return after, StageCommand(value=value, stage=stage, time=t - since, timed_out=timed_out)


def _condition(place: int, reading: Conditions) -> float:
    if place == 0:
        return reading.first
    if place == 1:
        return reading.second
    if place == 2:
        return reading.third
    return reading.fourth if place < CONDITIONS else 0.0


def _stage_quantity(read: Sequence[Kind], values: Written) -> Kind:
    return written_quantity(values.get("values"))


class Watched(NamedTuple):
    """Supervised values."""

    first: Input
    second: Second = 0.0
    third: Third = 0.0
    fourth: Fourth = 0.0


class Bounds(Params):
    """Limits of each reading, and the time for which it may be beyond."""

    first_lowest: Input = -LARGEST
    first_highest: Input = LARGEST
    first_patience: Time = 0.0
    second_lowest: Second = -LARGEST
    second_highest: Second = LARGEST
    second_patience: Time = 0.0
    third_lowest: Third = -LARGEST
    third_highest: Third = LARGEST
    third_patience: Time = 0.0
    fourth_lowest: Fourth = -LARGEST
    fourth_highest: Fourth = LARGEST
    fourth_patience: Time = 0.0

    def check(self) -> None:
        for each in Watched._fields:
            require_less(self, f"{each}_lowest", f"{each}_highest")


class WatchMemory(NamedTuple):
    """The alarm, when the last sample was [s], and whether there was one (1)."""

    alarms: AlarmMemory
    time: Number
    begun: Fraction


class Alarm(NamedTuple):
    """Number of the reading that was the first to be beyond its limits for too long, 0 for none, and when."""

    alarm: Count
    time: Time


def watch_start(settings: Bounds) -> WatchMemory:
    """No alarm."""
    return WatchMemory(alarm_start(len(Watched._fields)), 0.0, 0.0)


def supervision_step(t: float, memory: WatchMemory, reading: Watched, settings: Bounds) -> tuple[WatchMemory, Alarm]:
    """The first of up to four readings that is beyond its limits for too long; at time t [s], the alarm stays."""
    s = settings
    residuals = np.array(
        [
            _residual(reading.first, s.first_lowest, s.first_highest),
            _residual(reading.second, s.second_lowest, s.second_highest),
            _residual(reading.third, s.third_lowest, s.third_highest),
            _residual(reading.fourth, s.fourth_lowest, s.fourth_highest),
        ]
    )
    patience = (s.first_patience, s.second_patience, s.third_patience, s.fourth_patience)
    interval = t - memory.time if memory.begun > YES else 0.0
    found = alarm_step(memory.alarms, t, residuals, patience, interval)
    return WatchMemory(found, t, 1.0), Alarm(found.alarm, found.time)


def _residual(value: float, lowest: float, highest: float) -> float:
    """2 beyond the limits and for a value that is not a number, else 0."""
    return 0.0 if lowest <= value <= highest else 2.0


def _plain(read: Sequence[Kind], values: Written) -> Kind:
    return PLAIN


COMPARATOR = GenericProgram(ProgramType(comparator_step, Read, Value(0.0), Levels, level_start), _plain)
SEQUENCE = GenericProgram(
    ProgramType(sequence_step, Conditions, StageCommand(0.0), Stages, stage_start), _stage_quantity
)
SUPERVISION = GenericProgram(ProgramType(supervision_step, Watched, Alarm(0.0, 0.0), Bounds, watch_start), _plain)
