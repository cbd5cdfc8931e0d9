"""The three operations that Python floats, arrays, compiled code and CasADi do not share already.

`vvdp.simulation.compiled` replaces `select` by a plain conditional in compiled code.
"""

from typing import Any, cast

import numpy as np


def select(condition: Any, a: float, b: float) -> float:
    """`a` where `condition` holds, else `b`. Both are evaluated, so both must be finite."""
    if type(condition).__module__.startswith("casadi"):
        import casadi

        chosen: Any = casadi.if_else(condition, a, b)
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
