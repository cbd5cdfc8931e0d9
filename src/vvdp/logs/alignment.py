"""Where on the wheel a record begins: which edge its first one is, and how fast the wheel turns then.

Every possible first edge makes a different angle of each edge; the right one lies on the smoothest course. Each stretch
of two turns is asked by itself, so that an answer can be confirmed.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.logs.edges import Chosen, Edges
from vvdp.sensing.wheel import TURN, CodeWheel

STRETCH = 2
"""Turns in a stretch."""
STRETCHES = 8
AGREEING = 0.75
"""Share of the stretches that have to name the same first edge."""
CLEARLY = 0.5
"""Where there is only one stretch, its best course has less than this share of the squares of the second best."""


class Alignment(NamedTuple):
    """The number (0 to n - 1) of the first edge, the speed there [rad/s], and whether the index was found."""

    number: int
    speed: float
    index_found: bool


def edges_needed(wheel: CodeWheel) -> int:
    """How many edges an alignment looks at, at most."""
    return len(wheel.edges) * STRETCH * (STRETCHES if wheel.has_index else 1) + 1


def alignment(edges: Edges, wheel: CodeWheel) -> Alignment:
    """The alignment of a record that begins with `edges`, two at least.

    Without an index, or where none shows, the first edge is number 0, or 1 if it falls.
    """
    n = len(wheel.edges)
    steps = sectors_passed(edges)
    numbers = np.concatenate([[0.0], np.cumsum(steps)])
    speed = first_speed(edges.times, numbers, n)
    plain = 1 if edges.polarities[0] < 0.0 else 0
    known = edges.polarities[0] != 0.0
    if wheel.has_index and known and n == 2:  # of two sectors the polarity tells which
        return Alignment(plain, speed, True)
    if not wheel.has_index or numbers[-1] < STRETCH * n:
        return Alignment(plain, speed, False)
    candidates = np.arange(plain, n, 2) if known else np.arange(n)
    squares = np.array(list(_squares(edges.times, numbers, candidates, wheel)))
    if not squares.size:  # with several edges at once, no stretch has as many of them as a turn
        return Alignment(plain, speed, False)
    total = np.sum(squares, axis=0)
    best = int(np.argmin(total))
    second = float(np.min(np.delete(total, best)))
    votes = float(np.mean(np.argmin(squares, axis=1) == best))
    found = votes >= AGREEING if len(squares) > 1 else total[best] < CLEARLY * second
    if not found:
        return Alignment(plain, speed, False)
    return Alignment(int(candidates[best]), speed, True)


def first_speed(times: Array, numbers: Array, sectors: int) -> float:
    """The mean speed over the first turn [rad/s], or from the first two times that differ where a turn is faster than
    that; 0 where no times differ."""
    later = np.flatnonzero(times > times[0])
    if not later.size:
        return 0.0
    end = max(int(np.flatnonzero(numbers <= max(sectors, 2))[-1]), int(later[0]))
    return float(TURN / sectors * numbers[end] / (times[end] - times[0]))


def sectors_passed(edges: Edges) -> Array:
    """How many sectors lie between each edge and the one before it: as counted, or more where the time and the
    polarity say that edges are missing."""
    times = np.diff(edges.times)
    counts = edges.counts[1:]
    usual = float(np.median(times / counts))
    many = np.fmax(np.round(times / max(usual, 1e-300)), 1.0)
    signs = edges.polarities[1:] * edges.polarities[:-1]
    wrong = (signs != 0.0) & ((np.mod(many, 2.0) == 0.0) != (signs > 0.0))
    # The neighbour of the right parity, on the side of the time that was measured.
    many = np.where(wrong, np.where((times / max(usual, 1e-300) > many) | (many == 1.0), many + 1.0, many - 1.0), many)
    found: Array = np.where((counts > 1.0) | ((signs == 0.0) & (times < 1.6 * usual)), counts, many)
    return found


def _squares(times: Array, numbers: Array, candidates: Chosen, wheel: CodeWheel) -> Iterator[Array]:
    """Of each stretch, what is left of the angles beside a parabola, for each candidate [rad^2]."""
    n = len(wheel.edges)
    base = np.array(wheel.edges)
    for k in range(int(numbers[-1]) // (STRETCH * n)):
        inside = np.flatnonzero((numbers >= k * STRETCH * n) & (numbers < (k + 1) * STRETCH * n))
        if inside.size < n:
            continue
        own = numbers[inside][:, None] + candidates[None, :]
        angles = TURN * np.floor(own / n) + base[np.mod(own, n).astype(int)]
        t = times[inside] - times[inside[0]]
        span = max(float(t[-1]), 1e-300)
        courses = np.stack([np.ones_like(t), t / span, (t / span) ** 2], axis=1)
        left = angles - courses @ np.linalg.lstsq(courses, angles, rcond=None)[0]
        yield np.sum(left * left, axis=0)
