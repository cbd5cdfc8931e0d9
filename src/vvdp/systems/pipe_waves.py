"""Whether the pieces of a pipe are short enough for its waves: how smooth the pressure along it is."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import RATIO
from vvdp.components.pipes import LAYERED_PIPE, PIPE
from vvdp.network.assembly import Group
from vvdp.simulation.run import Run
from vvdp.simulation.values import leaves
from vvdp.systems.bound import Bound
from vvdp.systems.extras import LoadedSystem

ROUGHEST = 0.03
"""Roughness up to which the highest and the lowest pressure of a lossless line are within 3 % of the highest."""


def roughness(pressures: Array, damping: float = 0.0) -> float:
    """How rough the pressure along a pipe is at worst, over the highest pressure [1].

    That is its fourth difference from piece to piece, which long waves nearly lack, and the shortest have 16 times. Of
    fewer than five pieces it is the whole swing. Damping d takes about d n/2 times the second difference from a wave on
    its way over n pieces, which counts as well. docs/models/components.md tells what it does to the extremes.

    pressures  absolute, in every piece at every time, shape (times, pieces) [Pa]
    damping    of the pipe [1]
    """
    swing = pressures - pressures.mean(axis=0)
    pieces = pressures.shape[1]
    if pieces < 5:
        return float(np.abs(swing).max() / pressures.max())
    taken = 0.5 * damping * pieces * np.abs(np.diff(swing, 2, axis=1)).max()
    return float(max(np.abs(np.diff(swing, 4, axis=1)).max(), taken) / pressures.max())


def pipes(system: LoadedSystem) -> Mapping[str, Group]:
    """The pipes in pieces of a system, by name."""
    groups = system.circuit.network.groups
    return {name: group for name, group in groups.items() if group.assembly in (PIPE, LAYERED_PIPE)}


def wave_numbers(system: LoadedSystem, run: Run) -> dict[str, float]:
    """The roughness of each pipe of a recorded run, by key."""
    places = {path: place for place, (path, _, _) in enumerate(leaves(run.case.state))}
    return {
        f"wave_roughness_{name}": roughness(
            run.states[:, [places[node] for node in pipe.nodes]], getattr(pipe.values, "damping", 0.0)
        )
        for name, pipe in pipes(system).items()
    }


def wave_bounds(found: Mapping[str, Any]) -> Iterator[Bound]:
    """The bounds of the roughness of the pipes of which a run tells it."""
    for key in found:
        if key.startswith("wave_roughness_"):
            name = key.removeprefix("wave_roughness_").replace("_", " ")
            yield Bound(
                label=f"roughness of the waves in {name}",
                kind=RATIO,
                low=float(found[key]),
                high=float(found[key]),
                most=ROUGHEST,
                otherwise="waves shorter than its pieces swing from one to the next, and neither its highest nor its "
                "lowest pressure is to be trusted; give it more pieces, or its ends slower changes. With `damping` "
                "nothing swings, and `--check` shows what more pieces change",
            )
