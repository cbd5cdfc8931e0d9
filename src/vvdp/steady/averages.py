"""Quasi-steady averages of many points, compiled, on all cores, and kept: what maps and tables are made of."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.conservation import NOTHING
from vvdp.simulation.link import quiet
from vvdp.simulation.replay import Replay, replay_digest
from vvdp.simulation.table_cache import kept_table, table_key
from vvdp.simulation.values import flat
from vvdp.steady.cycle_means import CycleMeans, CyclePoint, cycle_step
from vvdp.valve.rotary import RotaryValve

EXAMPLE = CyclePoint(
    duty_ratio=0.5,
    load_pressure=100e5,
    tank_pressure=1e5,
    relief_pressure=120e5,
    relief_override=0.0,
    relief_rated_flow=1e-3,
    flow=1e-4,
    pump_leakage=0.0,
    density=870.0,
    viscosity=0.04,
)
"""A row, for its shape alone: one that plain Python calculates quickly."""


def averages(
    rows: Array,
    valve: RotaryValve,
    *,
    cores: int | None = None,
    say: Callable[[str], None] = quiet,
) -> CycleMeans:
    """`cycle_means` of every row; each field is an array over the rows.

    They are kept, known by the code, the rows and the valve.

    rows  shape (points, fields of `CyclePoint`)

    Source  ours, docs/models/rotary-valve.md
    """

    def make() -> Array:
        replay = Replay(cycle_step, NOTHING, EXAMPLE, valve, say=say)
        threads = min(cores or len(os.sched_getaffinity(0)), len(rows))
        # Neighbours take alike long: deal them out in turn.
        parts = [np.arange(first, len(rows), threads) for first in range(threads)]
        with ThreadPoolExecutor(threads) as pool:
            shown = list(pool.map(lambda part: replay(NOTHING, rows[part]).shown, parts))
        found = np.empty((len(rows), shown[0].shape[1]))
        for part, some in zip(parts, shown, strict=True):
            found[part] = some
        return found

    digest = replay_digest(cycle_step, NOTHING, EXAMPLE, valve)
    columns: Any = kept_table(table_key(digest, rows, flat(valve)), make).T
    return CycleMeans(**dict(zip(CycleMeans._fields, columns, strict=True)))


def means_at(means: CycleMeans, row: int) -> CycleMeans:
    """One row of the averages of many."""
    columns: Any = means._asdict()
    return CycleMeans(**{name: float(values[row]) for name, values in columns.items()})
