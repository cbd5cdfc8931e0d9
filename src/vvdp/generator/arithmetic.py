"""Operations on floats that no processor has, in the language itself: `//`, `%`, NumPy's minimum and sinc."""

import math

import numpy as np


def floor_remainder(a: float, b: float) -> float:
    """`a % b`, which has the sign of `b`; not a number where `b` is 0."""
    rest: float = np.fmod(a, b)
    if rest == 0.0:
        return math.copysign(0.0, b)
    return rest + b if (b < 0.0) != (rest < 0.0) else rest


def floor_quotient(a: float, b: float) -> float:
    """`a // b`, the floor of the exact quotient; infinite, or not a number, where `b` is 0."""
    if b == 0.0:
        return a / b
    rest = np.fmod(a, b)
    share = (a - rest) / b
    if rest != 0.0 and (b < 0.0) != (rest < 0.0):
        share = share - 1.0
    if share == 0.0:
        return math.copysign(0.0, a / b)
    below: float = np.floor(share)
    return below + 1.0 if share - below > 0.5 else below


def smaller(a: float, b: float) -> float:
    """NumPy's minimum of two numbers: not a number where either is none."""
    return a if a < b or a != a else b


def larger(a: float, b: float) -> float:
    """NumPy's maximum of two numbers: not a number where either is none."""
    return a if a > b or a != a else b


def sinc(x: float) -> float:
    """`sin(pi x) / (pi x)`, 1 at 0."""
    y = np.pi * x
    return 1.0 if y == 0.0 else np.sin(y) / y
