"""What the numbers of a run are worked out from, whether it ran alone or in a batch."""

from dataclasses import dataclass

import numpy as np

from vvdp.base.arrays import Array
from vvdp.simulation.model import Case, Model
from vvdp.simulation.run import Run

SETTLED = 1e-3
"""Change of the mean rate of marks between the halves of the averaging window above which a run is not settled."""


@dataclass(frozen=True)
class Window:
    """The part of a run over which means are taken: whole periods between marks where there are any."""

    begin: float
    end: float
    first: Array  # (n,) the state at `begin`
    last: Array  # (n,)
    periods: int
    settled: bool


@dataclass(frozen=True)
class Outcome:
    """The states and counts that a summary needs; vectors are in the order of the state."""

    model: Model
    case: Case
    window: Window
    final: Array  # (n,)
    low: Array  # (n,) over every step, the books left out
    high: Array  # (n,)
    end: float
    steps: int
    rejected: int
    evaluations: int
    stiff: bool
    seconds: float
    finished: bool
    remarks: tuple[str, ...] = ()


def outcome(run: Run, average_from: float) -> Outcome:
    """The outcome of a run that was recorded, with means from `average_from` [s] on."""
    return Outcome(
        model=run.model,
        case=run.case,
        window=averaging_window(run, average_from),
        final=run.final,
        low=run.low,
        high=run.high,
        end=run.end,
        steps=run.steps,
        rejected=run.rejected,
        evaluations=run.evaluations,
        stiff=run.stiff,
        seconds=run.seconds,
        finished=run.finished,
        remarks=run.remarks,
    )


def averaging_window(run: Run, average_from: float) -> Window:
    """From the first mark after `average_from` [s] to the last; without two marks, the plain time.

    A run that was stopped before `average_from` is averaged over its second half.
    """
    begin = average_from if run.end > average_from else 0.5 * (run.stepping.begin + run.end)
    inside = np.flatnonzero(run.mark_times >= begin)
    if inside.size < 2:
        row = min(int(np.searchsorted(run.times, begin)), run.times.size - 1)
        return Window(
            begin=float(run.times[row]), end=run.end, first=run.states[row], last=run.final, periods=0, settled=False
        )
    first, middle, last = (int(inside[place]) for place in (0, (inside.size - 1) // 2, inside.size - 1))
    times = float(run.mark_times[first]), float(run.mark_times[middle]), float(run.mark_times[last])
    return marked_window(times, run.mark_states[first], run.mark_states[last], inside.size)


def marked_window(times: tuple[float, float, float], first: Array, last: Array, marks: int) -> Window:
    """The window between the first and the last of at least two `marks`, at `times` of first, middle and last [s]."""
    begin, middle, end = times
    early_periods = (marks - 1) // 2
    early = early_periods / (middle - begin) if early_periods else np.nan
    late = (marks - 1 - early_periods) / (end - middle)
    settled = bool(abs(late / early - 1.0) < SETTLED)
    return Window(begin=begin, end=end, first=first, last=last, periods=marks - 1, settled=settled)
