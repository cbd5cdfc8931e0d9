"""Where on the wheel a record begins: which edge its first one is, and how fast the wheel turns then.

Every possible first edge makes a different angle of each edge; the right one lies on the smoothest course. Each stretch
of two turns is asked by itself, so that an answer can be confirmed.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.offline.edges import NEIGHBOURS, Chosen, Edges, rank_filter
from vvdp.sensing.wheel import TURN, CodeWheel, mirror_wheel, sector_widths

CLEAR = 10.0
"""Logarithm of the likelihood ratio from which on the best first edge is found, whatever single stretches say."""
STRETCH = 2
"""Turns in a stretch."""
STRETCHES = 8
AGREEING = 0.75
"""Share of the stretches that have to name the same first edge."""
CLEARLY = 0.5
"""Where there is only one stretch, its best course has less than this share of the squares of the second best."""
RATHER = 0.75
REFINEMENTS = 5
STARTING = 1.3
"""Times between the first edges that are longer by this factor than what is usual there are those of a wheel that
starts."""
MOST_SECTORS = 1e12
"""Between two edges; times of edges that are further apart are damaged."""
VAGUE = 0.3
"""An edge known within more than this share of a sector's time does not show whether others were missed."""


class Alignment(NamedTuple):
    """The number (0 to n - 1) of the first edge, the speed there [rad/s], whether the index was found, and the squares
    that it leaves of the angles beside smooth courses [rad^2]; infinite where nothing was compared."""

    number: int
    speed: float
    index_found: bool
    squares: float = np.inf


def edges_needed(wheel: CodeWheel) -> int:
    """How many edges an alignment looks at, at most."""
    return len(wheel.edges) * STRETCH * (STRETCHES if wheel.has_index else 1) + 1


def alignment(edges: Edges, wheel: CodeWheel) -> Alignment:
    """The alignment of a record that begins with `edges`, two at least.

    Without an index, or where none shows, the first edge is number 0, or 1 if it falls.
    """
    n = len(wheel.edges)
    steps = sectors_passed(edges, gap_in_sectors(wheel))
    numbers = np.concatenate([[0.0], np.cumsum(steps)])
    speed = first_speed(edges.times, numbers, n)
    plain = 1 if edges.polarities[0] < 0.0 else 0
    known = edges.polarities[0] != 0.0
    if wheel.has_index and known and n == 2:  # of two sectors the polarity shows which
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
    likelier = 0.5 * edges.times.size * np.log(max(second, 1e-300) / max(float(total[best]), 1e-300))
    agreeing = votes >= AGREEING or likelier > CLEAR
    found = bool(agreeing if len(squares) > 1 else total[best] < CLEARLY * second)
    return Alignment(int(candidates[best]) if found else plain, speed, found, float(total[best]))


class Start(NamedTuple):
    """Which way the wheel turns at the beginning of a piece (1 or -1), and its alignment as it is met that way."""

    direction: float
    alignment: Alignment


def start(edges: Edges, wheel: CodeWheel, direction: float) -> Start:
    """The start of a piece on a wheel that turned in a `direction` before: the other one where its index is clearly
    likelier and leaves less than `RATHER` of the squares."""
    kept = alignment(edges_as_met(edges, direction), wheel_as_met(wheel, direction))
    if not wheel.has_index:
        return Start(direction, kept)
    other = alignment(edges_as_met(edges, -direction), wheel_as_met(wheel, -direction))
    likelier = other.index_found and kept.squares > other.squares * np.exp(2.0 * CLEAR / edges.times.size)
    turned = likelier and other.squares < RATHER * kept.squares
    return Start(-direction, other) if turned else Start(direction, kept)


def edges_as_met(edges: Edges, direction: float) -> Edges:
    """The edges with the polarities that they have on the wheel as it is met; backwards, rising ones fall."""
    return edges._replace(polarities=direction * edges.polarities)


def wheel_as_met(wheel: CodeWheel, direction: float) -> CodeWheel:
    """The wheel as it is met: mirrored backwards."""
    return wheel if direction > 0.0 else mirror_wheel(wheel)


def first_speed(times: Array, numbers: Array, sectors: int) -> float:
    """The mean speed over the first turn [rad/s], or from the first two times that differ where a turn is faster than
    that; 0 where no times differ."""
    later = np.flatnonzero(times > times[0])
    if not later.size:
        return 0.0
    end = max(int(np.flatnonzero(numbers <= max(sectors, 2))[-1]), int(later[0]))
    return float(TURN / sectors * numbers[end] / (times[end] - times[0]))


def gap_in_sectors(wheel: CodeWheel) -> float:
    """How many usual sectors fit into the widest one, as where a tooth was left out; 1 for a wheel of like sectors."""
    widths = np.array(sector_widths(wheel))
    found = float(np.round(np.max(widths) / np.median(widths)))
    return max(found, 1.0)


def sectors_passed(edges: Edges, gap: float, neighbours: int = NEIGHBOURS) -> Array:
    """How many sectors lie between each edge and the one before it: as counted, or more where the time and the
    polarity say that edges are missing; a time that makes the `gap` of the wheel is one sector. Times that are only
    known to a part of a sector say nothing, nor do those of a wheel that starts from rest."""
    times = np.diff(edges.times)
    counts = edges.counts[1:]
    usual = usual_steps(times / counts, neighbours)
    many = np.fmax(np.round(times / usual), 1.0)
    many = np.where(many >= gap, many - gap + 1.0, many)
    signs = edges.polarities[1:] * edges.polarities[:-1]
    wrong = (signs != 0.0) & ((np.mod(many, 2.0) == 0.0) != (signs > 0.0))
    # The neighbour of the right parity, on the side of the time that was measured.
    many = np.where(wrong, np.where((times / usual > many) | (many == 1.0), many + 1.0, many - 1.0), many)
    vague = edges.intervals[1:] > VAGUE * usual
    starting = np.logical_and.accumulate(times > STARTING * usual * counts)
    many = np.where(starting, np.where(signs > 0.0, 2.0, 1.0), many)
    plain = (counts > 1.0) | ((signs == 0.0) & (vague | (times < 1.6 * usual)))
    found: Array = np.where(plain, counts, many)
    return found


def usual_steps(steps: Array, neighbours: int = NEIGHBOURS) -> Array:
    """The time that a sector takes around each of the times between edges [s].

    First the lower quartile of the neighbours, so that missed edges do not pass for the rule; then, again and again,
    the time of the nearest of them over the sectors that it makes.
    """
    least = max(float(np.max(steps, initial=0.0)) / MOST_SECTORS, 1e-300)
    size = min(neighbours, steps.size)
    begin = np.clip(np.arange(steps.size) - size // 2, 0, steps.size - size)
    usual = np.fmax(rank_filter(steps, size, size // 4)[begin], least)
    size = min(NEIGHBOURS, steps.size)
    begin = np.clip(np.arange(steps.size) - size // 2, 0, steps.size - size)
    passed = np.concatenate([[0.0], np.cumsum(steps)])
    for _ in range(REFINEMENTS):
        sectors = np.concatenate([[0.0], np.cumsum(np.fmax(np.round(steps / usual), 1.0))])
        usual = np.fmax((passed[begin + size] - passed[begin]) / (sectors[begin + size] - sectors[begin]), least)
    return usual


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
