"""Basis of the numbers of a run, whether it ran alone or in a batch."""

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


def outcome(run: Run) -> Outcome:
    """The outcome of a run that was recorded."""
    return Outcome(
        model=run.model,
        case=run.case,
        window=averaging_window(run),
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


def averaging_window(run: Run) -> Window:
    """Whole periods between the marks from `average_from` on; without two of them, the plain time."""
    inside = np.flatnonzero(run.mark_times >= run.stepping.means_from(run.end))
    if inside.size >= 2:
        kept = inside[kept_marks(inside.size)]
        return marked_window(run.case, run.mark_times[kept], run.mark_states[kept], inside.size)
    if not run.span_times.size:
        return Window(
            begin=run.stepping.begin, end=run.end, first=run.initial, last=run.final, periods=0, settled=False
        )
    begun = 4 if run.finished else 1  # the spans of a run that was stopped are not of equal length
    return plain_window(run.case, run.span_times[:begun], run.span_states[:begun], run.end, run.final)


def plain_window(case: Case, times: Array, states: Array, end: float, final: Array) -> Window:
    """The window to the `end` [s] of a run.

    times, states  where its spans begin, shape (4,) [s] and (4, n); the first alone where they do not show that it has
                   settled
    """
    ends, reached = np.append(times[1:], end), np.vstack([states[1:], final])
    return Window(
        begin=float(times[0]),
        end=end,
        first=states[0],
        last=final,
        periods=0,
        settled=ends.size == 4 and is_settled(case, ends, reached),
    )


def kept_marks(marks: int) -> npt.NDArray[np.int64]:
    """Places of the marks that are kept of `marks` in a window, shape (5,): the first, and three spans of whole periods
    to the last."""
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
    """By how much a mean over three spans would still change if it were taken indefinitely, shape (n,).

    Of a first-order lag the means of spans of equal length make a geometric series: their changes d_1 and d_2 have the
    ratio r of the decay over a span, and d_2 r/(1 - r) is still to come behind the last span.

    means  of the three spans, shape (3, n)
    """
    first, second = np.diff(means, axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.clip(np.where(first != 0.0, second / first, SLOWEST), 0.0, SLOWEST)
    left: Array = means[2] + second * ratio / (1.0 - ratio) - means.mean(axis=0)
    return np.abs(left)
