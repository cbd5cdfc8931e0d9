"""Powers and exponentials that compiled code calculates in place, without a call of the C library.

For everything else these are the operators and functions of NumPy; `vvdp.simulation.in_place` has their instructions.
"""

import numpy as np


def power(base: float, exponent: float) -> float:
    """`base ** exponent` [1]."""
    result: float = base**exponent
    return result


def expm1(x: float) -> float:
    """`e ** x - 1` [1], exact for small x."""
    result: float = np.expm1(x)
    return result
