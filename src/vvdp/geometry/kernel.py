"""Operations of a maker of solids, so that one description of the valve becomes facets as well as exact surfaces."""

from collections.abc import Callable, Sequence
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Placed = Callable[[Floats, Floats, Floats], Floats]
"""Where the nodes (a, b, c) of the unit cube go; points in rows [m]."""


class Solid(Protocol):
    """A body that can be joined to, cut by and intersected with others of its kind, and put elsewhere."""

    def __add__(self: "S", other: "S", /) -> "S": ...

    def __sub__(self: "S", other: "S", /) -> "S": ...

    def __and__(self: "S", other: "S", /) -> "S": ...

    def rotate(self: "S", angle: float) -> "S":
        """Turned about the axis [rad]."""

    def translate(self: "S", z: float) -> "S":
        """Moved along the axis [m]."""

    def mirror(self: "S", z: float = 0.0) -> "S":
        """Mirrored at the plane at `z` [m]."""


S = TypeVar("S", bound=Solid)
Made = TypeVar("Made", bound=Solid, covariant=True)


class Kernel(Protocol[Made]):
    """Makes the primitives that everything is composed of. Their surfaces belong to `patch`, whatever is cut later."""

    def cylinder(self, patch: str, radius: float, low: float, high: float, /) -> Made:
        """A cylinder about the axis."""

    def radial_cylinder(self, patch: str, radius: float, angle: float, near: float, far: float, z: float, /) -> Made:
        """A cylinder whose axis is the ray at `angle`, from `near` to `far`."""

    def ring(self, patch: str, centre_radius: float, radius: float, z: float, /) -> Made:
        """A torus about the axis, its centre line at `z`."""

    def bent_rod(self, patch: str, centre_radius: float, radius: float, begin: float, end: float, /) -> Made:
        """An arc of a torus about the axis, in the plane z = 0, with a hemisphere at either end."""

    def mapped_box(self, patch: str, placed: Placed, lengths: Sequence[float], /) -> Made:
        """The unit cube with every point moved to where `placed` puts it.

        `lengths` are those of its edges along a, b and c [m], for facets; 0 stands for edges that stay whole.
        """


def union(parts: Sequence[S]) -> S:
    """All parts in one."""
    whole = parts[0]
    for part in parts[1:]:
        whole = whole + part
    return whole


def around(part: S, count: float) -> S:
    """`count` copies of a part, evenly spread about the axis, in one."""
    return union([part.rotate(2.0 * np.pi * number / count) for number in range(round(count))])
