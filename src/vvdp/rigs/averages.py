"""Quasi-steady averages of many points, compiled, on all cores, and kept: what maps and tables are made of."""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.books import NOTHING, Nothing
from vvdp.rigs.cycle import CyclePoint, cycle_step, searched_instant
from vvdp.simulation.kept import kept_table, table_key
from vvdp.simulation.link import quiet
from vvdp.simulation.replay import Replay, Step, replay_digest
from vvdp.simulation.values import flat
from vvdp.valve.branch import branch_law
from vvdp.valve.flow_map import ANGLES, CycleMean
from vvdp.valve.geometry import port_shape, shape_openings
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
    return _swept(cycle_step, rows, valve, cores, cache, say)


def flow_map(
    duty_ratios: Sequence[float],
    load_pressures: Sequence[float],
    relief_pressure: float,
    relief_override: float,
    tank_pressure: float,
    flow: float,
    density: float,
    valve: RotaryValve,
    *,
    cores: int | None = None,
    cache: Path | None = None,
    say: Callable[[str], None] = quiet,
) -> CycleMean:
    """`quasi_steady_mean` at every load pressure and duty ratio, arrays of shape (pressures, duty ratios) [as there].

    The arguments are those of `quasi_steady_mean`, with several duty ratios and load pressures.

    Source  ours, docs/models/rotary-valve.md
    """
    rest = (tank_pressure, relief_pressure, relief_override, flow, 0.0, density, 1.0)  # the viscosity moves no oil
    rows = np.array([(d, p, *rest) for p in load_pressures for d in duty_ratios], float)
    found: Any = _swept(mean_step, rows, valve, cores, cache, say).T.reshape(-1, len(load_pressures), len(duty_ratios))
    return CycleMean(*found)


def mean_step(memory: Nothing, point: CyclePoint, valve: RotaryValve) -> tuple[Nothing, CycleMean]:
    """`quasi_steady_mean` in the form in which a record of points is run through, compiled.

    Every angle is solved by itself: the flow there is within 1e-12 of the pump's (`cycle.CLOSE`) or the pressure within
    1e-12 of the highest, where the search over all angles at once halves its interval 50 times, to 1e-15 of it.

    Source  ours, docs/models/rotary-valve.md
    """
    law, shape = branch_law(point.density, valve), port_shape(valve)
    load_flow, tank_flow, relief_flow, inlet, alike = 0.0, 0.0, 0.0, 0.0, 1.0
    position = point.duty_ratio * shape.helix_length
    openings = shape_openings(np.pi / shape.sections * 0.5 / ANGLES, position, shape)
    for i in range(1, ANGLES + 1):
        following = shape_openings(np.pi / shape.sections * (i + 0.5) / ANGLES, position, shape)
        if i < ANGLES and following.load == openings.load and following.tank == openings.tank:
            alike += 1.0  # as while a port is fully open
            continue
        now = searched_instant(openings, point, law)
        load_flow += alike * now.load.flow
        tank_flow += alike * now.tank.flow
        relief_flow += alike * now.passed
        inlet += alike * now.inlet_pressure
        openings, alike = following, 1.0
    load_flow, inlet = load_flow / ANGLES, inlet / ANGLES
    loss = point.flow * (inlet - point.tank_pressure) - load_flow * (point.load_pressure - point.tank_pressure)
    return memory, CycleMean(load_flow, tank_flow / ANGLES, relief_flow / ANGLES, inlet, loss)


def _swept(
    step: Step,
    rows: Array,
    valve: RotaryValve,
    cores: int | None,
    cache: Path | None,
    say: Callable[[str], None],
) -> Array:
    """What `step` shows at every row, kept by its code, the rows and the valve."""
    example = CyclePoint(*(float(x) for x in rows[0]))

    def make() -> Array:
        replay = Replay(step, NOTHING, example, valve, cache=cache, say=say)
        threads = min(cores or len(os.sched_getaffinity(0)), len(rows))
        # Neighbours take alike long: deal them out in turn.
        parts = [np.arange(first, len(rows), threads) for first in range(threads)]
        with ThreadPoolExecutor(threads) as pool:
            shown = list(pool.map(lambda part: replay(NOTHING, rows[part]).shown, parts))
        found = np.empty((len(rows), shown[0].shape[1]))
        for part, some in zip(parts, shown, strict=True):
            found[part] = some
        return found

    digest = replay_digest(step, NOTHING, example, valve)
    return kept_table(table_key(digest, rows, flat(valve)), make, cache)
