"""An instrument for any quantity: from a value at a sample to the number that a program reads.

Lag, offset, noise, resolution and range, in this order, and three faults. Derived in docs/models/instrument.md.

Source  ours, docs/models/instrument.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.kinds import Count, Fraction, Kind, Time
from vvdp.base.params import Params
from vvdp.base.rules import refuse, require_less
from vvdp.numerics.random import Random, normal, random_start

MEASURED = Kind("measured value", "SI", -1e12, 1e12, "1e5 SI", units=("SI",))
Measured = Annotated[float, MEASURED]
"""A value in the SI unit of whatever quantity an instrument measures."""


class Instrument(Params):
    """Errors of an instrument; each one is switched off by 0, and all values are in the SI unit of the measured value.

    It follows the value with the time constant `lag`, adds `offset` and noise of the standard deviation `noise`, drawn
    again for each sample, rounds to a multiple of `resolution` and is limited to `range_low` to `range_high`. From
    `bias_begin` to `bias_end` it adds `bias` as well; its reading stays constant from `freeze_begin` to `freeze_end`,
    and is `dropout_reading` from `dropout_begin` to `dropout_end`.
    """

    range_low: Measured
    range_high: Measured
    resolution: Measured
    lag: Time
    offset: Measured
    noise: Measured
    freeze_begin: Time
    freeze_end: Time
    dropout_begin: Time
    dropout_end: Time
    dropout_reading: Measured
    bias_begin: Time
    bias_end: Time
    bias: Measured
    seed: Count

    def check(self) -> None:
        require_less(self, "range_low", "range_high")
        span = self.range_high - self.range_low
        if not 0.0 <= self.resolution <= span:
            refuse(self, "resolution", f"must lie between 0 and the range, {span:g}")
        if self.noise < 0.0:
            refuse(self, "noise", "must be at least 0")
        for fault in ("freeze", "dropout", "bias"):
            begin, end = getattr(self, f"{fault}_begin"), getattr(self, f"{fault}_end")
            if end < begin:
                refuse(self, f"{fault}_end", f"must be at least {fault}_begin, {begin:g} s")


class InstrumentMemory(NamedTuple):
    """Memory of an instrument between two samples: `saturated` counts the readings that its range has cut off."""

    started: Fraction
    time: Time
    value: Measured
    followed: Measured
    shown: Measured
    saturated: Count
    random: Random


def ideal_instrument(low: float, high: float) -> Instrument:
    """An instrument without errors, from `low` to `high`; the others are made from it by a change."""
    return Instrument(
        range_low=low, range_high=high, resolution=0.0, lag=0.0, offset=0.0, noise=0.0,
        freeze_begin=0.0, freeze_end=0.0, dropout_begin=0.0, dropout_end=0.0,
        dropout_reading=low, bias_begin=0.0, bias_end=0.0, bias=0.0, seed=0.0,
    )  # fmt: skip


def instrument_start(settings: Instrument) -> InstrumentMemory:
    """Memory before the first sample; equal seeds give equal noise."""
    return InstrumentMemory(
        started=0.0,
        time=0.0,
        value=0.0,
        followed=0.0,
        shown=settings.range_low,
        saturated=0.0,
        random=random_start(settings.seed),
    )


def instrument_step(
    memory: InstrumentMemory, t: float, value: float, settings: Instrument
) -> tuple[InstrumentMemory, float]:
    """Memory and reading after a sample, in the unit of the value.

    t      time of the sample [s]
    value  true value
    """
    followed = value
    if memory.started > 0.0:
        followed = lagged_value(memory.followed, memory.value, value, t - memory.time, settings.lag)
    random, reading, saturated = memory.random, followed + settings.offset, memory.saturated
    if t >= settings.bias_begin and t < settings.bias_end:
        reading += settings.bias
    if settings.noise > 0.0:
        random, z = normal(random)
        reading += settings.noise * z
    if settings.resolution > 0.0:
        reading = np.floor(reading / settings.resolution + 0.5) * settings.resolution
    if reading < settings.range_low:
        reading, saturated = settings.range_low, saturated + 1.0
    elif reading > settings.range_high:
        reading, saturated = settings.range_high, saturated + 1.0
    if t >= settings.freeze_begin and t < settings.freeze_end and memory.started > 0.0:
        reading, saturated = memory.shown, memory.saturated
    if t >= settings.dropout_begin and t < settings.dropout_end:
        reading, saturated = settings.dropout_reading, memory.saturated
    return InstrumentMemory(
        started=1.0, time=t, value=value, followed=followed, shown=reading, saturated=saturated, random=random
    ), reading


def lagged_value(followed: float, before: float, value: float, interval: float, lag: float) -> float:
    """Response of a first-order lag to a value, an interval later: exact where the value went along a straight line.

    v + s tau (e^(-h/tau) - 1) + (y - v_0) e^(-h/tau), s = (v - v_0)/h the slope; the value itself without a lag.

    followed  y before, in the unit of the value
    before    v_0, the value before
    value     v, now
    interval  h between the two [s]
    lag       tau [s]
    """
    if lag <= 0.0 or interval <= 0.0:
        return value if lag <= 0.0 else followed
    decay = np.expm1(-interval / lag)
    behind: float = (value - before) * lag / interval * decay + (followed - before) * (1.0 + decay)
    return value + behind
