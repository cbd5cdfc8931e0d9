"""The three operations that Python floats, arrays, compiled code and CasADi do not share already.

`vvdp.simulation.link` replaces `select` by a plain conditional in compiled code.
"""

from typing import Any

import numpy as np


def select(condition: Any, a: Any, b: Any) -> Any:
    """`a` where `condition` holds, else `b`. Both are evaluated, so both must be finite."""
    if type(condition).__module__.startswith("casadi"):
        import casadi

        return casadi.if_else(condition, a, b)
    return np.where(condition, a, b) if np.ndim(condition) else (a if condition else b)


def minimum(a: Any, b: Any) -> Any:
    """The smaller of `a` and `b`."""
    return select(a < b, a, b)


def maximum(a: Any, b: Any) -> Any:
    """The larger of `a` and `b`."""
    return select(a > b, a, b)


def clip(value: Any, low: Any, high: Any) -> Any:
    """`value`, held between `low` and `high`."""
    return minimum(maximum(value, low), high)
