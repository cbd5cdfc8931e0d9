"""Two restrictions one after the other, with so little oil between them that it needs no volume of its own."""

import numpy as np

from vvdp.base.select import select
from vvdp.hydraulics.flow import signed_root


def series_conductance(first: float, second: float) -> float:
    """Conductance of two restrictions in series [m^3/(s Pa^0.5)]: K1 K2/sqrt(K1^2 + K2^2), 0 where either is closed.

    first, second  conductances K1 and K2 of the root law, 0 or greater [m^3/(s Pa^0.5)]

    Source  merritt1967, ch. 3 (root law); ours, docs/models/components.md
    """
    total = first * first + second * second
    either_open = total > 0.0
    conductance: float = select(either_open, first * second / np.sqrt(select(either_open, total, 1.0)), 0.0)
    return conductance


def first_share(first: float, second: float) -> float:
    """Share of the whole drop that lies over the first of two restrictions in series [1]: K2^2/(K1^2 + K2^2).

    One half where both are closed.

    first, second  conductances K1 and K2, 0 or greater [m^3/(s Pa^0.5)]

    Source  merritt1967, ch. 3 (root law); ours, docs/models/components.md
    """
    total = first * first + second * second
    either_open = total > 0.0
    share: float = select(either_open, second * second / select(either_open, total, 1.0), 0.5)
    return share


def series_flow(pressure_drop: float, first: float, second: float, transition_pressure: float) -> float:
    """Volume flow through two restrictions in series [m^3/s], signed like the drop.

    The transition to the straight line is one of the whole drop, so that two equal restrictions pass 1/sqrt(2) of the
    flow of one at every drop.

    pressure_drop        over both, first-named side less the second [Pa]
    first, second        conductances, 0 or greater [m^3/(s Pa^0.5)]
    transition_pressure  greater than zero [Pa]

    Source  merritt1967, ch. 3 (root law); ours, docs/models/components.md
    Error   as that of `signed_root`

    >>> print(round(series_flow(100e5, 1e-7, 1e-7, 1e3) / (1e-7 * 100e5**0.5), 4))
    0.7071
    """
    return series_conductance(first, second) * signed_root(pressure_drop, transition_pressure)
