"""Whether a steady run has settled: by moving means of what it is run for, and by the balance of its flows."""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import RunError

LARGEST_IMBALANCE = 1e-3
"""Of the flow: above it no run has settled."""


class History(NamedTuple):
    """A run over its iterations: the monitored value, as a drop [Pa] or a torque [N m]; what leaves by each patch.

    Flows are in m^3/s, negative where oil enters.
    """

    iterations: Array
    value: Array
    flows: Mapping[str, Array]


class Judgement(NamedTuple):
    """How a run stands.

    value      mean over the last window
    spread     highest less lowest value in it
    change     from the mean over the window before to this one, over this one; infinite where there is none
    imbalance  what leaves less what enters, mean over the window, over what enters; 0 where nothing flows in or out
    """

    iteration: int
    value: float
    spread: float
    change: float
    imbalance: float

    def has_settled(self, tolerance: float) -> bool:
        """Whether the value changes by less than `tolerance` from window to window, and the flows balance."""
        return self.change < tolerance and self.imbalance < LARGEST_IMBALANCE


def judge(history: History, since: int, window: int) -> Judgement | None:
    """How a run stands by its last `window` iterations; those up to `since` had other schemes and do not count."""
    value = history.value[history.iterations > since]
    last, before = value[-window:], value[-2 * window : -window]
    if not len(last):
        return None
    mean = float(last.mean())
    change = abs(1.0 - float(before.mean()) / mean) if len(before) == window and mean != 0.0 else np.inf
    return Judgement(
        iteration=int(history.iterations[-1]),
        value=mean,
        spread=float(np.ptp(last)),
        change=float(change),
        imbalance=_imbalance([flow[-window:] for flow in history.flows.values()]),
    )


def until_settled(history: History, since: int, window: int, tolerance: float) -> History:
    """A run up to where it had first settled, all of it where it has not.

    What is found is then the same at whatever time the run is looked at, and however far the solver has gone on.
    """
    first = int(np.searchsorted(history.iterations, since, side="right"))
    for end in range(first + 2 * window, len(history.iterations) + 1):
        here = _first_rows(history, end)
        found = judge(here, since, window)
        if found and found.has_settled(tolerance):
            return here
    return history


def _first_rows(history: History, rows: int) -> History:
    flows = {patch: flow[:rows] for patch, flow in history.flows.items()}
    return History(history.iterations[:rows], history.value[:rows], flows)


def _imbalance(flows: list[Array]) -> float:
    if not flows:
        return 0.0
    total = np.sum(flows, axis=0)
    entering = -np.sum([np.clip(flow, None, 0.0) for flow in flows], axis=0)
    return float(np.mean(abs(total)) / np.mean(entering))


def require_sane(history: History, largest: float, log: Path) -> None:
    """Raises RunError, which names the `log`, where a run diverges: its value is no number, or over `largest`."""
    wild = ~(abs(history.value) < largest)
    if wild.any():
        place = int(np.argmax(wild))
        raise RunError(
            f"the run diverged: at iteration {history.iterations[place]:g} the monitored value is "
            f"{history.value[place]:.3g}, and {largest:.3g} would be too much; see {log}"
        )
