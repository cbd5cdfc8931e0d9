"""The code wheel: where its bright and dark sectors meet.

Edges are counted along the unwrapped angle. Edge number m lies at the angle of edge m mod n plus a full turn for every
n edges; a rising edge (dark to bright in the forward direction) has an even number, a falling one an odd number.

Source  ours, docs/models/encoder.md, where a function names no other.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vvdp.base.errors import ParameterError
from vvdp.base.rules import POSITIVE

TURN = 2.0 * np.pi


@dataclass(frozen=True)
class CodeWheel:
    """Angles [rad] of the edges within one turn, increasing in [0, 2 pi), rising and falling by turns."""

    edges: tuple[float, ...]

    def __post_init__(self) -> None:
        n = len(self.edges)
        if n < 2 or n % 2:
            raise ParameterError(f"a code wheel with {n} edges; bright and dark alternate, so expected an even number")
        if not (self.edges[0] >= 0.0 and self.edges[-1] < TURN and all(np.diff(self.edges) > 0.0)):
            shown = ", ".join(f"{np.degrees(edge):.4g}" for edge in self.edges)
            raise ParameterError(
                f"edges at {shown} deg; expected increasing angles of at least 0 deg and less than 360 deg"
            )

    @property
    def has_index(self) -> bool:
        """Whether a turn of the wheel by less than 2 pi would show."""
        widths = sector_widths(self)
        n = len(widths)
        return not any(np.allclose(widths, np.roll(widths, shift)) for shift in range(2, n, 2))


def equal_wheel(sectors: int, index_shift: float = 0.0) -> CodeWheel:
    """A wheel of equal sectors; `index_shift` moves the edge at angle 0's successor by that share of a sector.

    With 8 sectors and a shift of 0.25 the first two sectors are 1.25 and 0.75 of the others wide, and mark the index.
    Raises ParameterError for an odd number of sectors, or a shift outside -0.9 to 0.9.

    Source  ours, docs/models/encoder.md, after wang2017, section 3.2
    """
    if sectors < 2 or sectors % 2:
        raise ParameterError(f"{sectors} sectors; bright and dark alternate, so expected an even number from 2")
    if not abs(index_shift) <= 0.9:
        raise ParameterError(f"an index shift of {index_shift:g} sectors; expected -0.9 to 0.9")
    pitch = TURN / sectors
    return CodeWheel(tuple(pitch * (i + (index_shift if i == 1 else 0.0)) for i in range(sectors)))


def wheel_of_widths(widths: Sequence[float]) -> CodeWheel:
    """The wheel whose sectors have these `widths` in any one unit, the first one bright, beginning at angle 0.

    Raises ParameterError where a width is not positive.
    """
    if not all(width > 0.0 for width in widths):
        raise ParameterError(f"sector widths {list(widths)}: each {POSITIVE}")
    ends = np.cumsum([0.0, *widths])
    return CodeWheel(tuple(float(x) for x in TURN * ends[:-1] / ends[-1]))


def mirror_wheel(wheel: CodeWheel) -> CodeWheel:
    """The wheel as it passes backwards, mirrored about its edge 0, which stays where it is.

    Edge k becomes edge -k, at the angle 2 e - a of the edge 0 at e and itself at a. Even numbers stay even; rising
    edges pass as falling ones, so polarities have to change their sign.
    Raises ParameterError where the wheel does not begin at an edge, so that a mirrored edge would lie beyond a turn.
    """
    first = wheel.edges[0]
    return CodeWheel((first, *(2.0 * first + TURN - edge for edge in wheel.edges[:0:-1])))


def sector_widths(wheel: CodeWheel) -> tuple[float, ...]:
    """Widths of the sectors [rad], the one after edge 0 first."""
    return tuple(float(x) for x in np.diff([*wheel.edges, wheel.edges[0] + TURN]))


def edge_angle(number: float, wheel: CodeWheel) -> float:
    """Unwrapped angle of edge `number` [rad]."""
    n = len(wheel.edges)
    turns: float = np.floor(number / n)
    return TURN * turns + wheel.edges[int(number - n * turns)]


def edge_below(angle: float, wheel: CodeWheel) -> float:
    """Number of the last edge at or below an unwrapped angle [rad]."""
    n = len(wheel.edges)
    turns: float = np.floor(angle / TURN)
    rest, passed = angle - TURN * turns, -1.0
    for edge in wheel.edges:
        passed += 1.0 if rest >= edge else 0.0
    return n * turns + passed


def edge_polarity(number: float) -> float:
    """+1 for a rising edge, -1 for a falling one."""
    return 1.0 - 2.0 * (number % 2.0)


def nearest_edge(angle: float, polarity: float, wheel: CodeWheel) -> float:
    """Number of the edge of that polarity (0: of either) closest to an unwrapped angle [rad]."""
    below = edge_below(angle, wheel)
    best, distance = below, np.inf
    for i in range(4):
        number = below - 1.0 + i
        away = abs(edge_angle(number, wheel) - angle)
        if away < distance and polarity * edge_polarity(number) >= 0.0:
            best, distance = number, away
    return best
