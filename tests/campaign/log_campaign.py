"""`vvdp estimate` over the campaign's records as logs; `python -m tests.campaign.log_campaign` prints what comes of it."""

import sys
from enum import Enum
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import h5py
import numpy as np
from tests.campaign.cases import CLASSES, INDEX_SHIFT, RATE, UNTIL, Case, case
from tests.campaign.filter_campaign import SETTLED, settings_of
from tests.campaign.generator import TURN, rising, sampled
from tests.campaign.scoring import Errors, errors, independent_edges, pool, wrong_by_a_factor

from vvdp.logs.config import FILTER_KINDS, Option, load_estimation
from vvdp.logs.estimate import estimate, open_for_estimate
from vvdp.results.result import Grade


class Logging(Enum):
    """What a log holds of the edges."""

    BOTH = "edge times in two columns, rising and falling"
    ALL = "edge times in one column"
    COUNTS = "a counter at 1 kHz"
    RISING = "edge times of one polarity in one column"


class Logged(NamedTuple):
    """What an estimation of a record came to."""

    case: Case
    logging: Logging
    errors: Errors
    wrong: bool
    estimated_share: float
    warnings: tuple[str, ...]


def columns(of: Case, logging: Logging) -> dict[str, np.ndarray]:
    """The channels of a log; of edge times, one column each."""
    match logging:
        case Logging.BOTH:
            up = of.seen.polarities > 0.0
            return {"edge": of.seen.times[up], "falling": of.seen.times[~up]}
        case Logging.ALL:
            return {"edge": of.seen.times}
        case Logging.RISING:
            return {"edge": rising(of.seen).times}
        case Logging.COUNTS:
            rows = sampled(of.seen, UNTIL, RATE, 0.5, stamped=False, told=False)
            return {"time": rows[:, 0], "count": np.cumsum(rows[:, 1])}


def options_of(of: Case, logging: Logging, told: bool) -> list[Option]:
    """The options of the command; `told` of noise and ripple, as a fit would be."""
    values: dict[str, object] = {"sensor.sectors": of.wheel.meant.size}
    if of.indexed:
        values["sensor.index_shift"] = INDEX_SHIFT
    values["sensor.counts" if logging is Logging.COUNTS else "sensor.edges"] = (
        "count" if logging is Logging.COUNTS else "edge"
    )
    if logging is Logging.BOTH:
        values["sensor.falling"] = "falling"
    settings = settings_of(of)
    names = ("acceleration_density", "edge_variance", "ripple_order", "ripple_variance")
    for name in names if told else ():
        if name in FILTER_KINDS:
            values[f"filter.{name}"] = f"{getattr(settings, name)!r} {FILTER_KINDS[name].unit}".removesuffix(" 1")
    return [Option(key, f"--{key}", value) for key, value in values.items()]


def run(of: Case, logging: Logging, folder: Path, *, told: bool = True) -> Logged:
    """A record written as a log, and estimated."""
    path = folder / "log.h5"
    with h5py.File(path, "w") as file:
        for name, values in columns(of, logging).items():
            file[name] = values
            file[name].attrs["units"] = "" if name == "count" else "s"
    wanted = load_estimation(None, options_of(of, logging, told))
    with open_for_estimate(path, wanted) as log:
        found = estimate(log, wanted, folder)
    with h5py.File(folder / "result.h5") as file:
        names = ("time", "angle", "speed", "angle_deviation", "speed_deviation")
        time, angle, speed, angle_deviation, speed_deviation = (file[name][:] for name in names)
    part = (time >= SETTLED) & (time < UNTIL)
    motion = of.motion
    true = np.column_stack(
        [np.interp(time, motion.time, x) for x in (motion.turned, np.abs(motion.speed))],
    )[part]
    estimated = np.column_stack([angle, speed])[part]
    estimated[:, 0] += motion.angle[0] * -1.0
    deviations = np.column_stack([angle_deviation, speed_deviation])[part]
    interval = 1.0 / RATE if logging is Logging.COUNTS else 0.0
    R = wanted.filter.edge_variance + (of.usual * interval) ** 2 / 12.0
    late = of.seen.times[of.seen.times > SETTLED]
    free = independent_edges(late, wanted.filter.acceleration_density, R)
    rows = np.isfinite(speed[part])
    return Logged(
        case=of,
        logging=logging,
        errors=errors(estimated, true, deviations, TURN / of.wheel.meant.size, free),
        wrong=wrong_by_a_factor(time[part][rows], estimated[rows, 1], true[rows, 1], of.usual),
        estimated_share=float(np.mean(rows)),
        warnings=tuple(each.title for each in found.findings if each.grade is not Grade.PLAIN),
    )


def one(name: str, seed: int, *, told: bool = True) -> Logged:
    """Record `seed` of a class as a log of the sort that its seed draws."""
    logging = (Logging.BOTH, Logging.ALL, Logging.COUNTS)[seed % 3]
    with TemporaryDirectory() as folder:
        return run(case(name, seed), logging, Path(folder), told=told)


def table(records: int, names: list[str]) -> str:
    """Coverage and NEES of each class over so many records."""
    lines = [
        f"{'class':10} {'speed cov':>9} {'angle cov':>9} {'speed NEES':>10} {'angle NEES':>10} {'band':>13} "
        f"{'wrong (of these unsaid)':>24}  first warnings"
    ]
    for name in names:
        ran = [one(name, seed) for seed in range(records)]
        h = pool([each.errors for each in ran])
        wrong = [each for each in ran if each.wrong]
        first = sorted({each.warnings[0] for each in ran if each.warnings})
        lines.append(
            f"{name:10} {h.speed_coverage:9.3f} {h.angle_coverage:9.3f} {h.speed_nees:10.3g} {h.angle_nees:10.3g} "
            f"{h.low:5.2f} to {h.high:4.2f} {len(wrong):12} ({sum(not each.warnings for each in wrong)}) of {records}  "
            f"{'; '.join(first)}"
        )
    return "\n".join(lines)


if __name__ == "__main__":
    print(table(int(sys.argv[1]) if len(sys.argv) > 1 else 6, sys.argv[2:] or list(CLASSES)))
