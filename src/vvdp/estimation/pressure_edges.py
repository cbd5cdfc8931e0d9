"""Edges of the pulsating inlet pressure: when the valve goes from tank to load, and back.

Two plateaus are followed without a model of the wave, the crossing level lies between them, and the time of a crossing
is interpolated between samples. Derived and measured in docs/models/pressure-fusion.md.

Source  ours, docs/models/pressure-fusion.md, where a function names no other.
"""

from typing import NamedTuple

from vvdp.base.kinds import Count, Fraction, Pressure, PressureDifference, Time
from vvdp.base.params import Params
from vvdp.base.rules import refuse, require_positive
from vvdp.base.select import clip, maximum, minimum

LOW_SHARE = 0.05
"""Share of all samples below the low plateau as tracked."""
HIGH_SHARE = 0.3
"""Share of the samples clear of the low plateau that lies below the high one: above the ramps, which take 10 to 20 % of
them, and below the spikes at the relief setting, which do not draw it however high they are."""
SETTLING = 4.0
"""Times `level_time` until edges are used. Until then plateaus move faster, by as much at its beginning."""


class PressureEdges(Params):
    """Parameters for finding edges in a pulsating pressure.

    `level_share` places the crossing level between the plateaus; an edge counts once the pressure is `hysteresis`
    times the swing beyond it. Where the plateaus are less than `least_swing` apart there are no edges; noise has to
    stay below it. A plateau moves by at most one swing within `level_time`; edges are reported from four times that
    after the start.
    """

    level_share: Fraction
    hysteresis: Fraction
    least_swing: PressureDifference
    level_time: Time

    def check(self) -> None:
        if not 0.0 < self.level_share < 1.0:
            refuse(self, "level_share", "must lie between 0 and 1")
        room = min(self.level_share, 1.0 - self.level_share)
        if not self.hysteresis < room:
            refuse(self, "hysteresis", f"must be less than {room:g}, or it reaches a plateau")
        require_positive(self, "least_swing", "level_time")


class PressureSample(NamedTuple):
    """The inlet pressure, absolute, at a time."""

    time: Time
    pressure: Pressure


class PressureEdgesMemory(NamedTuple):
    """The last sample, the plateaus, and the crossing that waits for its confirmation.

    `side` is where the pressure was last for certain: +1 high, -1 low, 0 unknown. `crossing_interval` 0: no crossing
    since then.
    """

    start: Time
    time: Time
    pressure: Pressure
    low: Pressure
    high: Pressure
    side: float
    crossing_time: Time
    crossing_interval: Time


class PressureReading(NamedTuple):
    """Edges in a sample of the pressure: as `Reading`, with rising meaning tank to load, and the levels.

    `pressure_edge_time` may lie a few samples back. Where `pressure_edges` is 0 the three fields after it mean
    nothing.
    """

    time: Time
    pressure_edges: Count
    pressure_edge_time: Time
    pressure_edge_interval: Time
    pressure_polarity: float
    level: Pressure
    low: Pressure
    high: Pressure


def pressure_edges() -> PressureEdges:
    """The usual settings: crossing at half the swing, 10 % hysteresis, from 5 bar of swing, plateaus within 0.1 s."""
    return PressureEdges(level_share=0.5, hysteresis=0.1, least_swing=5e5, level_time=0.1)


def pressure_edges_start(time: float, pressure: float) -> PressureEdgesMemory:
    """The memory before the sample at `time` [s], where the pressure was about `pressure`, absolute [Pa]."""
    return PressureEdgesMemory(
        start=time,
        time=time,
        pressure=pressure,
        low=pressure,
        high=pressure,
        side=0.0,
        crossing_time=time,
        crossing_interval=0.0,
    )


def followed_plateau(plateau: float, value: float, share: float, step: float) -> float:
    """A plateau after one more `value`: below it lies `share` of all values, once it has settled [unit of value].

    Up by `share` of the step where the value lies above, down by the rest of it where below; a far value moves it no
    more than a near one.
    """
    if value > plateau:
        return minimum(plateau + share * step, value)
    return maximum(plateau - (1.0 - share) * step, value)


def pressure_edges_step(
    memory: PressureEdgesMemory, sample: PressureSample, settings: PressureEdges
) -> tuple[PressureEdgesMemory, PressureReading]:
    """The memory after a sample, and the edge that it confirms, if any.

    The low plateau is a low quantile of all samples, the high one a quantile of those clear of the low one: neither
    depends on where the crossing level was, so that they cannot hold on to the spikes of a relief valve. The edge time
    is that of the crossing of the level, by linear interpolation; its interval is the sampling period times the jump
    between the two samples over the swing, at most the whole period: a jump of the whole swing hides when it happened,
    small steps do not.
    """
    t, p, before = sample.time, sample.pressure, memory.pressure
    period = t - memory.time
    age = (t - memory.start) / settings.level_time
    low, high = memory.low, memory.high
    if age < 1.0:
        low, high = minimum(low, p), maximum(high, p)
    else:
        haste = maximum(SETTLING / age, 1.0)
        step = maximum(high - low, settings.least_swing) * minimum(haste * period / settings.level_time, 1.0)
        low = followed_plateau(low, p, LOW_SHARE, step)
        if p > low + settings.least_swing:
            high = followed_plateau(high, p, HIGH_SHARE, step)
    swing = high - low
    level = low + settings.level_share * swing
    reach = settings.hysteresis * swing

    side, crossing_time, crossing_interval = memory.side, memory.crossing_time, memory.crossing_interval
    beyond = (p >= level and side < 0.0) or (p < level and side > 0.0)
    if not beyond:  # it turned back before it was past the hysteresis
        crossing_interval = 0.0
    elif crossing_interval == 0.0:
        jump = p - before
        part = clip((level - before) / jump, 0.0, 1.0) if jump * side < 0.0 else 0.5
        crossing_time = memory.time + period * part
        crossing_interval = period * minimum(abs(jump) / maximum(swing, settings.least_swing), 1.0)

    now = side
    if p > level + reach:
        now = 1.0
    elif p < level - reach:
        now = -1.0
    clear = swing >= settings.least_swing and age >= SETTLING
    edges = 1.0 if clear and now * side < 0.0 else 0.0
    reading = PressureReading(
        time=t,
        pressure_edges=edges,
        pressure_edge_time=crossing_time,
        pressure_edge_interval=crossing_interval,
        pressure_polarity=now,
        level=level,
        low=low,
        high=high,
    )
    if now != side:
        crossing_interval = 0.0
    if not clear:
        now = 0.0
    return PressureEdgesMemory(
        start=memory.start,
        time=t,
        pressure=p,
        low=low,
        high=high,
        side=now,
        crossing_time=crossing_time,
        crossing_interval=crossing_interval,
    ), reading
