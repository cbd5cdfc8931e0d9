"""The law of a drop or torque that goes with the square of the flow, and how far it is from that."""

from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array


class SquareLaw(NamedTuple):
    """A value over the flow: c of c Q^2, and the exponent m of k Q^m."""

    coefficient: float
    exponent: float


def square_law(flows: Array, values: Array) -> SquareLaw:
    """The laws c Q^2 and k Q^m of values above zero by least squares, the power of the logarithm.

    Source  ours, docs/models/cfd.md
    """
    square = flows**2
    exponent = np.polyfit(np.log(flows), np.log(values), 1)[0] if (values > 0.0).all() else np.nan
    return SquareLaw(float(square @ values / (square @ square)), float(exponent))
