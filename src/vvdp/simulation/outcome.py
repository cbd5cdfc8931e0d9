"""What the numbers of a run are worked out from, whether it ran alone or in a batch."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from vvdp.base.arrays import Array
from vvdp.base.kinds import DURATION
from vvdp.simulation.model import Case, Model
from vvdp.simulation.run import Run
from vvdp.simulation.values import leaves

SETTLED = 1e-3
"""Share of a mean that may still be missing from it in a settled run."""
SMALL = 0.1
"""A mean below this share of the largest of its unit is judged as if it were as large as that."""
SLOWEST = 0.9
"""Ratio of two changes from third to third from which on what is still to come is judged as if it were this."""


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
    """The states and counts that a summary needs; vectors are in the order of the state.

    `memory` is what each program remembers at the end, by its name.
    """

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
    memory: Mapping[str, Any] = field(default_factory=dict)


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
        memory=run.final_memory,
    )


def averaging_window(run: Run, average_from: float) -> Window:
    """From the first mark after `average_from` [s] to the last; without two marks, the plain time.

    A run that was stopped before `average_from` is averaged over its second half.
    """
    begin = average_from if run.end > average_from else 0.5 * (run.stepping.begin + run.end)
    inside = np.flatnonzero(run.mark_times >= begin)
    if inside.size >= 2:
        kept = inside[kept_marks(inside.size)]
        return marked_window(run.case, run.mark_times[kept], run.mark_states[kept], inside.size)
    row = min(int(np.searchsorted(run.times, begin)), run.times.size - 1)
    rows = np.searchsorted(run.times, run.times[row] + (run.end - run.times[row]) * np.array([0.0, 1.0, 2.0]) / 3.0)
    rows = rows.clip(max=run.times.size - 1)
    times, states = np.append(run.times[rows], run.end), np.vstack([run.states[rows], run.final])
    return Window(
        begin=float(times[0]),
        end=run.end,
        first=states[0],
        last=run.final,
        periods=0,
        settled=is_settled(run.case, times, states),
    )


def kept_marks(marks: int) -> npt.NDArray[np.int64]:
    """Which of `marks` in a window are kept, shape (5,): the first, and three spans of whole periods to the last."""
    last = max(marks - 1, 0)
    third = last // 3
    return np.array([0, last - 3 * third, last - 2 * third, last - third, last])


def marked_window(case: Case, times: Array, states: Array, marks: int) -> Window:
    """The window between the first and the last of at least two `marks`, of which those of `kept_marks` are given.

    times, states  at these, shape (5,) [s] and (5, n)
    """
    return Window(
        begin=float(times[0]),
        end=float(times[-1]),
        first=states[0],
        last=states[-1],
        periods=marks - 1,
        settled=marks > 3 and is_paced(times[1:]) and is_settled(case, times[1:], states[1:]),
    )


def is_settled(case: Case, times: Array, states: Array) -> bool:
    """Whether what the means over three spans of equal length still change by is below `SETTLED` of each mean.

    Means are those of every state that accumulates: pressures, flows, powers, speeds; shares of the time are left out,
    which may jump.
    What is left to come is extrapolated as that of a first-order lag, docs/keys.md.

    times, states  at the ends of the spans, shape (4,) [s] and (4, n)
    """
    spans = np.diff(times)
    if not (spans > 0.0).all():
        return False
    kinds = [kind for _, _, kind in leaves(case.state)]
    units = [kind.unit if kind and kind.accumulates and kind is not DURATION else "" for kind in kinds]
    kept = [place for place, unit in enumerate(units) if unit]
    means = np.diff(states[:, kept], axis=0) / spans[:, np.newaxis]
    size, of = np.abs(means.mean(axis=0)), np.array([units[place] for place in kept])
    for unit in set(of):
        size[of == unit] = size[of == unit].clip(min=SMALL * size[of == unit].max())
    drift, steady = remaining_change(means), SETTLED * size
    return bool((drift <= steady).all())


def is_paced(times: Array) -> bool:
    """Whether the rate at which marks follow each other has settled, between four of as many periods each [s]."""
    spans = np.diff(times)[:, np.newaxis]
    return bool((spans > 0.0).all() and remaining_change(1.0 / spans)[0] <= SETTLED / spans.mean())


def remaining_change(means: Array) -> Array:
    """By how much a mean over three spans would still change if it were taken for ever, shape (n,).

    Of a first-order lag the means of spans of equal length make a geometric series: their changes d_1 and d_2 have the
    ratio r of the decay over a span, and d_2 r/(1 - r) is still to come behind the last span.

    means  of the three spans, shape (3, n)
    """
    first, second = np.diff(means, axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.clip(np.where(first != 0.0, second / first, SLOWEST), 0.0, SLOWEST)
    left: Array = means[2] + second * ratio / (1.0 - ratio) - means.mean(axis=0)
    return np.abs(left)
