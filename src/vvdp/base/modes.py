"""Where a law stands among its modes: a number whose floor is the mode, and changes where a step of a run must end."""

from vvdp.base.select import clip

REACH = 0.99
"""How far from a boundary its distance still counts."""


def side(distance: float) -> float:
    """Below 1 before a boundary and 1 or more behind it: of two modes, 0 and 1, the one that holds.

    distance  from the boundary, negative before it; well below 1 where the boundary is near [1]

    >>> side(-0.25), side(0.25)
    (0.75, 1.25)
    """
    return 1.0 + clip(distance, -REACH, REACH)


def between(value: float) -> float:
    """Of three modes the one that holds: 0 below the value 0, 1 up to the value 1, 2 from there on.

    value  of whatever is clipped to 0 to 1 [1]

    >>> between(-0.5), between(0.25), between(1.5)
    (0.5, 1.25, 2.5)
    """
    return 1.0 + clip(value, -REACH, 1.0 + REACH)
