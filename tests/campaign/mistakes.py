"""Logs of wheels that are not what `vvdp estimate` is told; `python -m tests.campaign.mistakes` prints what it says."""

import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import h5py
import numpy as np
from tests.campaign.cases import DENSITY, INDEX_SHIFT
from tests.campaign.generator import Passages, constant, course, disc, passages, rising, wandering

from vvdp.offline.config import Option, load_estimation
from vvdp.offline.estimate import estimate, open_for_estimate
from vvdp.results.result import Grade

UNTIL = 3.0
JITTER = 0.03
"""Of an edge, in sectors."""


class Mistake(NamedTuple):
    """A wheel, how its edges are logged, and what is said of it; without sectors, nothing is said of them."""

    sectors: int
    indexed: bool = True
    columns: str = "both"
    inverted: bool = False
    backward: bool = False
    options: tuple[tuple[str, object], ...] = (("sensor.index_shift", INDEX_SHIFT),)
    wave_rate: float = 0.0
    """0: edge times; else the level of the light at this rate [Hz]."""


MISTAKES = {
    "nothing": Mistake(8),
    "one polarity, no index": Mistake(8, False, "rising", options=()),
    "one polarity, index": Mistake(8, True, "rising"),
    "half the sectors": Mistake(16),
    "half the sectors, one column": Mistake(16, columns="all"),
    "twice the sectors": Mistake(4),
    "twice the sectors, one column": Mistake(4, columns="all"),
    "half the sectors, no index": Mistake(16, False),
    "inverted": Mistake(8, inverted=True),
    "backward": Mistake(8, backward=True),
    "inverted and backward": Mistake(8, inverted=True, backward=True),
    "wave": Mistake(8, wave_rate=1e4),
    "two samples a sector": Mistake(8, wave_rate=2.0),
    "wave sampled too slowly": Mistake(8, wave_rate=0.6),
}


class Found(NamedTuple):
    """True and estimated mean speed [rad/s], and the warnings."""

    true: float
    mean: float
    warnings: tuple[str, ...]

    @property
    def wrong(self) -> bool:
        """Whether the speed is wrong by a factor, whichever way it is said to turn."""
        return not 0.8 < abs(self.mean) / self.true < 1.25


def record(what: Mistake, seed: int) -> tuple[float, Passages]:
    """Speed [rad/s] and edges of a record."""
    rng = np.random.default_rng([seed, 11])
    w = rng.uniform(60.0, 170.0)
    wheel = disc(what.sectors, INDEX_SHIFT if what.indexed else 0.0, 0.0, rng)
    motion = course(wandering(constant(-w if what.backward else w), DENSITY, w, rng), UNTIL, rng.uniform(0.0, 6.28))
    seen = passages(motion, wheel, JITTER * 2.0 * np.pi / what.sectors, rng)
    sign = -1.0 if what.inverted else 1.0
    return float(np.mean(np.abs(motion.speed))), Passages(seen.times, sign * seen.polarities)


def channels(what: Mistake, speed: float, seen: Passages) -> dict[str, np.ndarray]:
    """The columns of a log; a wave has so many samples a sector where its rate is below 100."""
    if what.wave_rate > 0.0:
        per_sector = what.sectors * speed / (2.0 * np.pi)
        rate = what.wave_rate if what.wave_rate >= 100.0 else what.wave_rate * per_sector
        time = np.arange(int(UNTIL * rate)) / rate
        passed = np.searchsorted(seen.times, time, side="right")
        before = np.concatenate([[-seen.polarities[0]], seen.polarities])
        return {"time": time, "diode": 2.5 + 2.5 * before[passed]}
    up = seen.polarities > 0.0
    if what.columns == "both":
        return {"edge": seen.times[up], "falling": seen.times[~up]}
    return {"edge": seen.times if what.columns == "all" else rising(seen).times}


def found(what: Mistake, seed: int) -> Found:
    """What an estimation says of a record."""
    speed, seen = record(what, seed)
    options: dict[str, object] = dict(what.options)
    options |= {"sensor.wave": "diode"} if what.wave_rate > 0.0 else {"sensor.edges": "edge"}
    if what.columns == "both" and what.wave_rate == 0.0:
        options["sensor.falling"] = "falling"
    with TemporaryDirectory() as place:
        path = Path(place) / "log.h5"
        with h5py.File(path, "w") as file:
            for name, values in channels(what, speed, seen).items():
                file[name] = values
                file[name].attrs["units"] = "V" if name == "diode" else "s"
        wanted = load_estimation(None, [Option(key, f"--{key}", value) for key, value in options.items()])
        with open_for_estimate(path, wanted) as log:
            result = estimate(log, wanted, Path(place))
    warnings = tuple(f"{each.title}: {each.text}" for each in result.findings if each.grade is not Grade.PLAIN)
    return Found(speed, result.numbers["spool_speed_mean_rad_s"].value, warnings)


if __name__ == "__main__":
    for name, what in MISTAKES.items():
        for seed in range(int(sys.argv[1]) if len(sys.argv) > 1 else 1):
            came = found(what, seed)
            print(
                f"{name:30} {came.mean / came.true:6.3f} {'WRONG' if came.wrong else '     '}",
                *came.warnings,
                sep="\n   ",
            )
