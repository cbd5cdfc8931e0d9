"""The three operations that Python floats, arrays, symbols and compiled code do not share already.

A condition between symbols brings its own method `select`; CasADi's, which has none, is known by name.
`vvdp.simulation.dialect` replaces `select` by a plain conditional in compiled code.
"""

from typing import Any, cast

import numpy as np


def select(condition: Any, a: float, b: float) -> float:
    """`a` where `condition` holds, else `b`. Both are evaluated, so both must be finite."""
    if hasattr(condition, "select"):
        chosen: Any = condition.select(a, b)
    elif type(condition).__module__.startswith("casadi"):
        import casadi

        chosen = casadi.if_else(condition, a, b)
    elif np.ndim(condition):
        chosen = np.where(condition, a, b)
    else:
        chosen = a if condition else b
    return cast(float, chosen)


def minimum(a: float, b: float) -> float:
    """The smaller of `a` and `b`."""
    return select(a < b, a, b)


def maximum(a: float, b: float) -> float:
    """The larger of `a` and `b`."""
    return select(a > b, a, b)


def clip(value: float, low: float, high: float) -> float:
    """`value`, held between `low` and `high`."""
    return minimum(maximum(value, low), high)
