"""Number of each edge of the wheel, given by the index: one sector wider, one narrower than the others.

Over the last turn of edges a straight line, theta = omega t + b, is fitted for each way in which the wheel could be
turned; the one with the least sum of squares fits the widths of the sectors. Times are kept by the number of the edge
modulo a turn, so that missed edges leave gaps and nothing else.

Source  ours, docs/models/event-filter.md, where a function names no other.
"""

from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import NUMBER, TIME, Count, Fraction, Number
from vvdp.base.select import clip, maximum, minimum
from vvdp.sensing.wheel import CodeWheel, edge_angle

ONE_TURN = 8.0
"""Most that a single turn may say for or against a hypothesis, in logarithms of the likelihood ratio [1]."""

CERTAIN = 16.0
"""Evidence, in the same measure, at which a numbering once found is given up: 1e-7 by chance [1]."""


CONFIRMED = 3.0
"""Logarithm of the likelihood ratio in favour of the present numbers with which a revolution confirms them [1]."""


class IndexMemory(NamedTuple):
    """Edges of the last revolution, and the evidence of all revolutions.

    `verdict` is the shift of the numbers, in edges, by the last revolution, `turns` the number of revolutions in a row
    with this verdict, `found` 1 once they are enough. `evidence` for each shift is gathered only from then on.
    """

    numbers: Annotated[Array, NUMBER]
    times: Annotated[Array, TIME]
    evidence: Annotated[Array, NUMBER]
    turn_start: Number
    verdict: Number
    turns: Count
    found: Fraction


class Shift(NamedTuple):
    """The memory after an edge, the number to be added to the numbers of all edges, mostly 0, and 1 if a revolution
    that has just ended clearly confirms the present numbers."""

    memory: IndexMemory
    edges: float
    confirmed: Fraction


def index_start(wheel: CodeWheel) -> IndexMemory:
    """Memory before the first edge."""
    n = len(wheel.edges)
    return IndexMemory(
        numbers=np.full(n, -np.inf),
        times=np.zeros(n),
        evidence=np.zeros(n),
        turn_start=-np.inf,
        verdict=0.0,
        turns=0.0,
        found=0.0,
    )


def index_again(memory: IndexMemory) -> IndexMemory:
    """The memory of a wheel that starts again: numbers once found are kept unless new turns speak against them."""
    m, n = memory, memory.numbers.size
    return IndexMemory(
        numbers=np.full(n, -np.inf),
        times=m.times,
        evidence=np.zeros(n),
        turn_start=-np.inf,
        verdict=0.0,
        turns=0.0,
        found=m.found,
    )


def shift_of(hypothesis: float, edges: float) -> float:
    """Edges by which hypothesis 0, 1, 2, ... of a wheel with `edges` edges shifts the numbers, the shortest way."""
    return hypothesis - edges if hypothesis > 0.5 * edges else hypothesis


def squares_about_line(numbers: Array, times: Array, shift: float, wheel: CodeWheel) -> float:
    """Sum of squares [rad^2] of the edges numbered `numbers` + `shift` about the straight line through their times.

    Numbers of -inf are left out.

    times  [s]
    """
    n, t_mean, y_mean = 0.0, 0.0, 0.0
    for i in range(numbers.size):
        if numbers[i] > -np.inf:
            n += 1.0
            t_mean += times[i]
            y_mean += edge_angle(numbers[i] + shift, wheel)
    t_mean, y_mean = t_mean / n, y_mean / n
    tt, ty, yy = 0.0, 0.0, 0.0
    for i in range(numbers.size):
        if numbers[i] > -np.inf:
            t, y = times[i] - t_mean, edge_angle(numbers[i] + shift, wheel) - y_mean
            tt, ty, yy = tt + t * t, ty + t * y, yy + y * y
    return yy - ty * ty / tt


def index_after_edge(
    memory: IndexMemory, number: float, time: float, polarity: float, variance: float, needed: float, wheel: CodeWheel
) -> Shift:
    """Memory, and the shift of all numbers, after the edge taken for `number` passed at `time` [s].

    The numbers are found when `needed` turns in a row agree; after that they are watched: a shift must gather
    evidence, sum of (SSE_0 - SSE_s) / (2 sigma^2) over the turns (a cumulative sum that does not fall below 0).
    sigma^2 is `variance` [rad^2] or, if larger, the residual variance about the best line, so that a revolution at
    changing speed has little weight. With a known polarity numbers can only be off by pairs.
    """
    n = memory.numbers.size
    numbers, times = np.empty(n), np.empty(n)
    present = 1.0
    for i in range(n):
        kept = memory.numbers[i] > number - n
        numbers[i] = memory.numbers[i] if kept else -np.inf
        times[i] = memory.times[i]
        present += 1.0 if kept else 0.0
    slot = int(number - n * np.floor(number / n))
    numbers[slot], times[slot] = number, time
    start = memory.turn_start if memory.turn_start > -np.inf else number
    if number - start < n or present < 4.0:
        waiting = memory._replace(numbers=numbers, times=times, turn_start=start)
        return Shift(waiting, 0.0, 0.0)

    step = 1 if polarity == 0.0 else 2
    squares = np.full(n, np.inf)
    for k in range(0, n, step):
        squares[k] = squares_about_line(numbers, times, shift_of(k, n), wheel)
    best, others = 0, np.inf
    for k in range(0, n, step):
        best = k if squares[k] < squares[best] else best
        others = minimum(others, squares[k]) if k > 0 else others
    sigma2 = maximum(variance, squares[best] / (present - 2.0))
    evidence = np.zeros(n)
    strongest = 0
    for k in range(0, n, step):
        said = clip((squares[0] - squares[k]) / (2.0 * sigma2), -ONE_TURN, ONE_TURN)
        evidence[k] = maximum(memory.evidence[k] + said, 0.0) * memory.found
        strongest = k if evidence[k] > evidence[strongest] else strongest

    confirmed = 1.0 if memory.found > 0.0 and others - squares[0] > 2.0 * sigma2 * CONFIRMED else 0.0
    verdict = shift_of(best, n)
    turns = memory.turns + 1.0 if verdict == memory.verdict else 1.0
    shift = 0.0
    found = memory.found
    if found == 0.0 and turns >= needed:
        found, shift = 1.0, verdict
    elif evidence[strongest] > CERTAIN:
        shift = shift_of(strongest, n)
    if shift != 0.0:
        verdict = 0.0
        numbers = numbers + shift
        evidence = np.zeros(n)
    return Shift(
        IndexMemory(
            numbers=numbers,
            times=times,
            evidence=evidence,
            turn_start=number + shift,
            verdict=verdict,
            turns=turns,
            found=found,
        ),
        shift,
        confirmed,
    )
