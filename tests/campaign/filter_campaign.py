"""The event filter over the campaign's records; `python -m tests.campaign.filter_campaign` prints what comes of it."""

import sys
from collections.abc import Iterable, Sequence
from dataclasses import fields, replace
from functools import cache
from typing import NamedTuple

import numpy as np
from tests.campaign.cases import CLASSES, RATE, UNTIL, Case, case
from tests.campaign.generator import TURN, sampled
from tests.campaign.scoring import Errors, Traces, coverage, errors, independent_edges, pool, stands, wrong_by_a_factor

from vvdp.base.kinds import Fraction
from vvdp.estimation.estimator import Estimate
from vvdp.estimation.event_filter import event_filter_estimator, event_filter_step
from vvdp.estimation.event_memory import EventFilterMemory
from vvdp.estimation.event_settings import EventFilter, event_filter
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import CodeWheel, equal_wheel
from vvdp.simulation.replay import Replay

SETTLED = 1.0
"""Errors count from here on [s]."""


class Outcome(NamedTuple):
    """What a record came to, from `SETTLED` on."""

    case: Case
    traces: Traces
    errors: Errors
    wrong: bool
    standstill: np.ndarray

    @property
    def speed_error(self) -> float:
        """Root mean square [rad/s]."""
        off = self.traces.estimated[:, 1] - self.traces.true[:, 1]
        return float(np.sqrt(np.nanmean(off**2)))


def settings_of(of: Case) -> EventFilter:
    """What the filter is told of a record: the wheel as it was meant, the noise and the ripple as large as they are."""
    wheel = CodeWheel(tuple(of.wheel.meant.tolist()))
    plain = event_filter(wheel)
    wanted = {
        "acceleration_density": of.density,
        "edge_variance": of.edge_variance,
        "ripple_order": of.ripple_order,
        "ripple_variance": of.ripple_variance,
    }
    known = {each.name for each in fields(plain)}
    return replace(plain, **{name: value for name, value in wanted.items() if name in known})


class Watched(NamedTuple):
    """What the filter shows, and whether it has found the index."""

    estimate: Estimate
    found: Fraction


def watched_step(
    memory: EventFilterMemory, reading: Reading, settings: EventFilter
) -> tuple[EventFilterMemory, Watched]:
    """The filter's step."""
    memory, estimate = event_filter_step(memory, reading, settings)
    return memory, Watched(estimate, memory.search.found)


@cache
def compiled(sectors: int) -> Replay:
    """The filter, compiled; for each number of sectors its own shape of the memory, and the same text."""
    example = event_filter_estimator(event_filter(equal_wheel(sectors)))
    return Replay(watched_step, example.memory, Reading(0.0, 0.0, 0.0, 0.0, 0.0), example.settings)


def true_motion(of: Case, time: np.ndarray, *, directed: bool = False) -> np.ndarray:
    """Columns: the angle turned through, from where the wheel stood at first, and the speed; or both with direction."""
    motion = of.motion
    undirected = motion.angle[0] + motion.turned, np.abs(motion.speed)
    columns = (motion.angle, motion.speed) if directed else undirected
    return np.column_stack([np.interp(time, motion.time, each) for each in columns])


def independent(of: Case, told: EventFilter, interval: float) -> float:
    """How many of a record's errors are independent, where edges are known to an `interval` [s]."""
    R = told.edge_variance + (of.usual * interval) ** 2 / 12.0
    return independent_edges(of.seen.times[of.seen.times > SETTLED], told.acceleration_density, R)


def run(of: Case) -> Outcome:
    """The event filter over one record; it knows nothing of angle and speed at first."""
    told = settings_of(of)
    phase = float(np.random.default_rng([of.seed, 7]).random())
    rows = sampled(of.seen, UNTIL, RATE, phase, stamped=of.stamped, told=of.told)
    replay = compiled(of.wheel.meant.size)
    shown = replay(event_filter_estimator(told).memory, rows, told).shown[rows[:, 0] >= SETTLED]
    named = {path.rpartition(".")[2]: column for path, column in zip(replay.columns, shown.T, strict=True)}
    time = rows[rows[:, 0] >= SETTLED, 0]
    traces = Traces(
        time=time,
        estimated=np.column_stack([named["angle"], named["speed"]]),
        true=true_motion(of, time),
        deviations=np.column_stack([named["angle_deviation"], named["speed_deviation"]]),
    )
    name_edges(traces, named["found"], TURN / of.wheel.meant.size)
    return Outcome(
        case=of,
        traces=traces,
        errors=errors(
            traces, TURN / of.wheel.meant.size, independent(of, told, 0.0 if of.stamped else 1.0 / RATE), of.sudden
        ),
        wrong=wrong_by_a_factor(traces, of.usual, of.sudden),
        standstill=named["standstill"],
    )


def name_edges(traces: Traces, found: np.ndarray, pitch: float) -> None:
    """Count the angle before the index was `found` as after it: until then it is relative."""
    since = int(np.argmax(found > 0.0))
    if since > 0:
        off = (traces.estimated - traces.true)[since - 1 : since + 1, 0]
        traces.estimated[:since, 0] += pitch * np.round((off[1] - off[0]) / pitch)


def told_within(each: Outcome) -> float:
    """Time from rest until a standstill is likelier than not [s]; NaN where nothing stops, infinite if never told."""
    rest = np.flatnonzero((each.traces.true[:, 1] == 0.0) & stands(each.traces))
    if not rest.size:
        return np.nan
    begin = each.traces.time[rest[0]] - 0.1
    sure = each.traces.time[(each.standstill > 0.5) & (each.traces.time >= begin)]
    return float(sure[0] - begin) if sure.size else np.inf


def pooled_row(name: str, ran: Sequence[Outcome]) -> str:
    """A line of the table."""
    h = pool([each.errors for each in ran])
    worst_speed, worst_angle = (
        min((coverage(getattr(each.errors, which)), each.case.seed) for each in ran) for which in ("speed", "angle")
    )
    told = [told_within(each) for each in ran]
    known = [1e3 * each for each in told if not np.isnan(each)]
    return (
        f"{name:9} {h.speed_coverage:6.3f} {h.angle_coverage:6.3f} {h.speed_nees:9.3g} {h.angle_nees:9.3g} "
        f"{h.low:5.2f} {h.high:4.2f} {np.sqrt(np.mean([each.speed_error**2 for each in ran])):8.3f} "
        f"{worst_speed[0]:6.2f} #{worst_speed[1]:<3} {worst_angle[0]:6.2f} #{worst_angle[1]:<3} "
        f"{sum(each.wrong for each in ran):6} "
        f"{h.still_coverage:6.3f} {np.median(known) if known else np.nan:8.0f}"
    )


def table(records: int, names: Iterable[str]) -> str:
    """What each class comes to over so many records."""
    heading = (
        "          coverage      NEES                band       speed rms  worst record's coverage wrong  standing\n"
        "class      speed  angle     speed     angle  from   to  [rad/s]  speed       angle     factor  cover. after ms"
    )
    rows = [pooled_row(name, [run(case(name, seed)) for seed in range(records)]) for name in names]
    return "\n".join([heading, *rows])


if __name__ == "__main__":
    print(table(int(sys.argv[1]) if len(sys.argv) > 1 else 20, sys.argv[2:] or CLASSES))
