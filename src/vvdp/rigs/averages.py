"""The quasi-steady averages of many points, compiled and on all cores."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from vvdp.base.books import NOTHING
from vvdp.numerics.tableaus import Array
from vvdp.rigs.cycle import CyclePoint, cycle_step
from vvdp.simulation.link import quiet
from vvdp.simulation.replay import Replay
from vvdp.valve.rotary import RotaryValve


def averages(
    rows: Array,
    valve: RotaryValve,
    *,
    cores: int | None = None,
    cache: Path | None = None,
    say: Callable[[str], None] = quiet,
) -> Array:
    """`cycle_means` of every row, shape (points, fields of `CycleMeans`).

    rows  shape (points, fields of `CyclePoint`)

    Source  ours, docs/models/rotary-valve.md
    """
    example = CyclePoint(*(float(x) for x in rows[0]))
    replay = Replay(cycle_step, NOTHING, example, valve, cache=cache, say=say)
    threads = min(cores or len(os.sched_getaffinity(0)), len(rows))
    # Neighbours take alike long: deal them out in turn.
    parts = [np.arange(first, len(rows), threads) for first in range(threads)]
    with ThreadPoolExecutor(threads) as pool:
        shown = list(pool.map(lambda part: replay(NOTHING, rows[part]).shown, parts))
    found = np.empty((len(rows), shown[0].shape[1]))
    for part, some in zip(parts, shown, strict=True):
        found[part] = some
    return found
