"""Functions of the processor and of the C library, which CPython and machine code both call."""

import ctypes
import math
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from vvdp.base.errors import RunError


class Failure(RunError):
    """Error that generated code was written to raise, or that a check of it found: file, line and reason."""


C_LIBRARY = {
    "acos": 1, "acosh": 1, "asin": 1, "asinh": 1, "atan": 1, "atan2": 2, "atanh": 1, "cbrt": 1, "cos": 1, "cosh": 1,
    "erf": 1, "erfc": 1, "exp": 1, "exp2": 1, "expm1": 1, "fmod": 2, "hypot": 2, "log": 1, "log10": 1, "log1p": 1,
    "log2": 1, "nextafter": 2, "pow": 2, "sin": 1, "sinh": 1, "tan": 1, "tanh": 1, "tgamma": 1, "lgamma": 1,
}  # fmt: skip
"""Functions of the C library that code may call, and how many floats they take."""

EXACT: dict[str, tuple[int, Callable[..., Any]]] = {
    "sqrt": (1, np.sqrt),
    "floor": (1, np.floor),
    "ceil": (1, np.ceil),
    "trunc": (1, np.trunc),
    "rint": (1, np.rint),
    "fabs": (1, np.absolute),
    "copysign": (2, np.copysign),
}
"""Functions that LLVM has, which are the same everywhere: their floats, and what calculates them in plain Python."""

FITS = {"fits+": "sadd", "fits-": "ssub", "fits*": "smul", "fits<<": "", "fits>>": ""}
"""Whether an operation on whole numbers stays within 64 bits, for checked code."""


@cache
def c_function(name: str) -> Callable[..., float]:
    """A function of the C library of this process."""
    function = getattr(ctypes.CDLL(None), name)
    function.restype = ctypes.c_double
    function.argtypes = [ctypes.c_double] * C_LIBRARY[name]
    return lambda *numbers: np.float64(function(*numbers))


def is_within_64_bits(value: int) -> bool:
    """Whether a whole number has at most 64 bits."""
    return -(2**63) <= value < 2**63


def cut(value: float) -> int:
    """A float as a whole number of 64 bits: cut towards zero, held at the ends of the range, 0 where it is none."""
    if math.isnan(value):
        return 0
    return int(max(-(2.0**63), min(float(np.nextafter(2.0**63, 0.0)), value))) if value < 2.0**63 else 2**63 - 1
