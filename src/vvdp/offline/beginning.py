"""What the first edges of a log say before it is estimated: of the wheel, of the clock, of how well they are seen."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.estimation.event_settings import EventFilter, event_filter
from vvdp.offline.alignment import VAGUE, usual_steps
from vvdp.offline.config import Estimation, Stamps, Wave
from vvdp.offline.edges import Edges, no_edges
from vvdp.offline.hypotheses import LOOKED_AT, TURNS, Verdict, judge
from vvdp.offline.likelihood import time_resolution
from vvdp.sensing.wheel import TURN, CodeWheel

STRETCHES = 3
"""Of so many stretches of the length that is looked at, the steadiest is taken."""
FINE = 1e-3
"""Ticks below this share of the time between edges do not matter."""
PACE = 155.0
"""Speed of the spool to which the usual settings of the filter belong [rad/s]: wang2017, section 3.5."""
SLOW, STILL = 4.0, 1e6
"""From so many times slower on, the usual settings are brought to the pace of the log, and no spool is slower than the
second; assumed."""
FEWEST = 3
"""Edges of which times say anything."""


class Beginning(NamedTuple):
    """What the wheel is taken for; the tick in which edge times are written [s], 0 where it does not matter; the part
    of a sector to which edges are known [1], 0 where they are known well."""

    verdict: Verdict
    tick: float
    blur: float
    period: float = 0.0
    """The usual time of a sector [s], 0 where it is not known."""


def edges_looked_at(wheel: CodeWheel) -> int:
    """How many edges at the beginning of a log are looked at, at most."""
    return STRETCHES * min(2 * TURNS * len(wheel.edges), LOOKED_AT)


def beginning(clocks: Sequence[Edges], wanted: Estimation) -> Beginning:
    """What the first edges say, those up to each end of a clock by themselves."""
    edges = max(clocks, key=lambda each: each.times.size) if clocks else None
    if edges is None or edges.times.size < FEWEST:
        return Beginning(judge(no_edges(), wanted.wheel), 0.0, 0.0)
    usual = usual_steps(np.diff(edges.times) / edges.counts[1:])
    tick = clock_tick(edges.times, float(np.median(usual))) if isinstance(wanted.source, Stamps) else 0.0
    seen = edges._replace(intervals=np.fmax(edges.intervals, tick))
    blur = float(np.median(seen.intervals[1:] / usual))
    verdict = judge(seen if blur < VAGUE else no_edges(), wanted.wheel)
    return Beginning(verdict, tick, blur if blur > VAGUE else 0.0, float(np.median(usual)))


def at_pace(settings: EventFilter, period: float) -> EventFilter:
    """The settings for a wheel whose sector takes `period` [s]; those that are not as usual stay as they are.

    What is usual belongs to a spool at `PACE`. For one that is slower the unit of time is longer; but drive and
    friction are as strong, so within a sector the speed may change by as much as itself.
    """
    usual, pitch = event_filter(settings.wheel), TURN / len(settings.wheel.edges)
    if not SLOW * pitch < period * PACE < STILL * pitch:
        return settings
    pace = pitch / period
    slower = PACE / pace
    brought = {
        "acceleration_density": usual.acceleration_density / slower**3,
        "manoeuvre_density": min(usual.manoeuvre_density, pace * pace / period),
        "speed_variance": usual.speed_variance / slower**2,
        "association_speed_deviation": usual.association_speed_deviation / slower,
        "lowest_speed": usual.lowest_speed / slower,
        "stop_rate": usual.stop_rate / slower,
    }
    kept = {name: value for name, value in brought.items() if getattr(settings, name) == getattr(usual, name)}
    return replace(settings, **kept)  # type: ignore[arg-type]


def clock_tick(times: Array, usual: float) -> float:
    """The tick of the clock that edge times come from [s], as far as the times show; 0 where it is so fine, against the
    `usual` time between edges [s], that it does not matter.

    All times are whole multiples of a power of ten; where the steps between them have a larger measure in common, and
    are not all alike, that is the tick.
    """
    digit = time_resolution(times)
    if not FINE * FINE * usual < digit < usual:
        return 0.0
    steps = np.unique(np.round(np.diff(times) / digit)).astype(int)
    common = float(np.gcd.reduce(steps)) * digit if steps.size > 1 else digit
    tick = common if common < 0.5 * usual else digit
    return tick if FINE * usual < tick < 0.5 * usual else 0.0


def apply_verdict(wanted: Estimation, verdict: Verdict) -> Estimation:
    """The estimation with the wheel that the log speaks for, and with the polarities that it has then."""
    wheel, settings = verdict.wheel, wanted.filter
    if wheel != settings.wheel:
        turns = settings.index_turns if wheel.has_index else 0.0
        wanted = replace(wanted, filter=replace(settings, wheel=wheel, index_turns=turns))
    if verdict.likeliest.polarity > 0.0:
        return wanted
    match wanted.source:
        case Wave(comparator=comparator) as wave:
            flipped = replace(comparator, inverted=not comparator.inverted)
            return replace(wanted, source=replace(wave, comparator=flipped))
        case Stamps(channel=rising, falling=falling):
            return replace(wanted, source=Stamps(falling, rising))
        case _:
            return wanted
