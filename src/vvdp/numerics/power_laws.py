"""Powers of one quantity fitted to another, such as a drop over the flow."""

from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.numerics.least_squares import Fit, fit


class DropLaws(NamedTuple):
    """Laws of a pressure drop [Pa] over flow Q [m^3/s].

    orifice   c Q^2
    two_term  a Q + b Q^2
    power     logarithm of k Q^m: coefficients log k and m
    """

    orifice: Fit
    two_term: Fit
    power: Fit


def drop_laws(flows: Array, drops: Array) -> DropLaws:
    """All laws of a drop. Raises ParameterError where fewer than three flows are there.

    Columns are scaled to 1 at the largest flow, or their squares would differ by ten orders of magnitude.
    """
    q = flows / flows.max()
    scale = np.array([1.0, 1.0]) / flows.max() ** np.array([1.0, 2.0])
    return DropLaws(
        orifice=fit([q**2], drops).scale(scale[1:]),
        two_term=fit([q, q**2], drops).scale(scale),
        power=power_law(flows, drops),
    )


def power_law(across: Array, seen: Array) -> Fit:
    """The logarithm of k x^m over `across` x: coefficients log k and m. Raises ParameterError for fewer than three."""
    return fit(power_columns(across), np.log(seen))


def power_columns(across: Array) -> list[Array]:
    """The columns of `power_law`."""
    return [np.ones_like(across), np.log(across)]
