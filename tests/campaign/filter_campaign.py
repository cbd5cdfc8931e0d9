"""The event filter over the campaign's records; `python -m tests.campaign.filter_campaign` prints what comes of it."""

import sys
from dataclasses import fields, replace
from functools import cache

import numpy as np
from tests.campaign.cases import CLASSES, RATE, UNTIL, Case, case
from tests.campaign.generator import TURN, sampled
from tests.campaign.scoring import Errors, errors, independent_edges, pool, wrong_by_a_factor

from vvdp.estimation.event_filter import EventFilter, event_filter, event_filter_estimator
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import CodeWheel, equal_wheel
from vvdp.simulation.replay import Replay

SETTLED = 1.0


class Outcome:
    """What a record came to: errors over deviations, whether its speed was wrong by a factor, and its traces."""

    def __init__(self, of: Case, told: EventFilter, rows: np.ndarray, shown: np.ndarray, columns: tuple[str, ...]):
        self.case = of
        named = dict(zip(columns, shown.T, strict=True))
        time, motion = rows[:, 0], of.motion
        true = np.column_stack(
            [np.interp(time, motion.time, x) for x in (motion.angle[0] + motion.turned, np.abs(motion.speed))]
        )
        part = time >= SETTLED
        self.time, self.true = time, true
        self.estimated = np.column_stack([named["angle"], named["speed"]])
        self.deviations = np.column_stack([named["angle_deviation"], named["speed_deviation"]])
        self.missed = float(named["missed_edges"][-1])
        q, n = told.acceleration_density, of.wheel.meant.size
        interval = 0.0 if of.stamped else 1.0 / RATE
        R = told.edge_variance + (of.usual * interval) ** 2 / 12.0
        late = of.seen.times[of.seen.times > SETTLED]
        free = independent_edges(late, q, R)
        self.errors: Errors = errors(self.estimated[part], true[part], self.deviations[part], TURN / n, free)
        self.wrong = wrong_by_a_factor(time[part], self.estimated[part, 1], true[part, 1], of.usual)


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


@cache
def compiled(sectors: int) -> Replay:
    """The filter, compiled; for each number of sectors its own shape of the memory, and the same text."""
    example = event_filter_estimator(event_filter(equal_wheel(sectors)))
    return Replay(example.step, example.memory, Reading(0.0, 0.0, 0.0, 0.0, 0.0), example.settings)


def run(of: Case) -> Outcome:
    """The event filter over one record; it knows nothing of angle and speed at first."""
    told = settings_of(of)
    phase = float(np.random.default_rng([of.seed, 7]).random())
    rows = sampled(of.seen, UNTIL, RATE, phase, stamped=of.stamped, told=of.told)
    replay = compiled(of.wheel.meant.size)
    shown = replay(event_filter_estimator(told).memory, rows, told).shown
    return Outcome(of, told, rows, shown, replay.columns)


def table(records: int, names: list[str]) -> str:
    """Coverage and NEES of each class over so many records."""
    lines = [
        f"{'class':10} {'speed cov':>9} {'angle cov':>9} {'speed NEES':>10} {'angle NEES':>10} "
        f"{'band':>13} {'speed rms':>9} {'worst record: speed cov, angle cov'}   wrong by a factor"
    ]
    for name in names:
        ran = [run(case(name, seed)) for seed in range(records)]
        h = pool([each.errors for each in ran])
        worst = [
            min(
                (float(np.mean(np.abs(z) <= 2.0)), each.case.seed)
                for each, z in ((r, r.errors._asdict()[key]) for r in ran)
            )
            for key in ("speed", "angle")
        ]
        rms = np.sqrt(
            np.mean([np.mean((r.estimated[r.time > SETTLED, 1] - r.true[r.time > SETTLED, 1]) ** 2) for r in ran])
        )
        lines.append(
            f"{name:10} {h.speed_coverage:9.3f} {h.angle_coverage:9.3f} {h.speed_nees:10.3g} {h.angle_nees:10.3g} "
            f"{h.low:5.2f} to {h.high:4.2f} {rms:9.3f} {worst[0][0]:8.2f} (#{worst[0][1]}), {worst[1][0]:.2f} (#{worst[1][1]})"
            f"  {sum(each.wrong for each in ran)} of {records}"
        )
    return "\n".join(lines)


if __name__ == "__main__":
    records = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    print(table(records, sys.argv[2:] or list(CLASSES)))
