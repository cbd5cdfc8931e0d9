"""`vvdp estimate` over the campaign's records as logs; `python -m tests.campaign.log_campaign` prints what comes of
it."""

import sys
from collections import Counter
from collections.abc import Iterable, Sequence
from enum import Enum
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import h5py
import numpy as np
from tests.campaign.cases import CLASSES, INDEX_SHIFT, RATE, UNTIL, Case, case, shows_index
from tests.campaign.filter_campaign import SETTLED, independent, settings_of, true_motion
from tests.campaign.generator import TURN, rising, sampled
from tests.campaign.scoring import Errors, Traces, errors, pool, wrong_by_a_factor

from vvdp.offline.config import FILTER_KINDS, Option, load_estimation
from vvdp.offline.estimate import estimate, open_for_estimate
from vvdp.results.result import Grade

PIECE_ROWS = 250
"""Rows at the begin of a piece by which it is known where its count began."""


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
        time = file["time"][:]
        part = (time >= SETTLED) & (time < UNTIL)
        pieces = file["piece"][:][part]
        estimated, deviations = (
            np.column_stack([file[f"{name}{more}"][:][part] for name in ("angle", "speed")])
            for more in ("", "_deviation")
        )
    true = true_motion(of, time[part], directed=bool(np.nanmin(estimated[:, 1]) < -0.5 * of.usual))
    pitch = TURN / of.wheel.meant.size
    for piece in np.unique(pieces):  # after a pause the count begins anew, from an edge that is chosen
        here = (pieces == piece) & np.isfinite(estimated[:, 0])
        begin = (estimated[here] - true[here])[:PIECE_ROWS, 0]
        estimated[here, 0] -= pitch * np.round(np.median(begin) / pitch) if begin.size else 0.0
    traces = Traces(time=time[part], estimated=estimated, true=true, deviations=deviations)
    interval = 1.0 / RATE if logging is Logging.COUNTS else 0.0
    return Logged(
        case=of,
        logging=logging,
        errors=errors(traces, pitch, independent(of, wanted.filter, interval), of.sudden),
        wrong=wrong_by_a_factor(traces, of.usual, of.sudden),
        warnings=tuple(each.title for each in found.findings if each.grade is not Grade.PLAIN),
    )


def one(name: str, seed: int, *, told: bool = True) -> Logged:
    """Record `seed` of a class as a log of the sort that its seed draws; a counter is read often enough."""
    of = case(name, seed)
    hidden = of.crowded or (of.indexed and not shows_index(of.wheel.meant.size, of.usual, 1.0 / RATE))
    counts = Logging.ALL if hidden and name != "crowded" else Logging.COUNTS
    with TemporaryDirectory() as folder:
        return run(of, (Logging.BOTH, Logging.ALL, counts)[seed % 3], Path(folder), told=told)


def pooled_row(name: str, ran: Sequence[Logged]) -> str:
    """A line of the table."""
    h = pool([each.errors for each in ran])
    wrong = [each for each in ran if each.wrong]
    first = Counter(each.warnings[0] for each in ran if each.warnings)
    unsaid = sum(not each.warnings for each in wrong)
    return (
        f"{name:9} {h.speed_coverage:6.3f} {h.angle_coverage:6.3f} {h.speed_nees:9.3g} {h.angle_nees:9.3g} "
        f"{h.low:5.2f} {h.high:4.2f} {h.still_coverage:6.3f} {len(wrong):6} {unsaid:6}"
        f"  {'; '.join(f'{title} {count}' for title, count in first.items())}"
    )


def table(records: int, names: Iterable[str]) -> str:
    """What each class comes to over so many records."""
    heading = (
        "          coverage      NEES                band      still  wrong factor\n"
        "class      speed  angle     speed     angle  from   to  cover.  speeds unsaid  first warnings"
    )
    rows = [pooled_row(name, [one(name, seed) for seed in range(records)]) for name in names]
    return "\n".join([heading, *rows])


if __name__ == "__main__":
    print(table(int(sys.argv[1]) if len(sys.argv) > 1 else 6, sys.argv[2:] or CLASSES))
