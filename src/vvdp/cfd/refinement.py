"""Error of the finest of three grids of one family: observed order, extrapolation, convergence index."""

import math
from typing import NamedTuple

from vvdp.base.errors import ParameterError

SAFETY = 1.25
"""Factor of the convergence index for three grids."""
LEAST_RATIO = 1.1
"""Of one cell size to the next finer one; the index wants 1.3."""
HIGHEST_ORDER, LOWEST_ORDER = 2.0, 1.0
"""Of the schemes: values that close up sooner have met by chance, and of values that drift apart no more is known."""
ITERATIONS = 200


class GridConvergence(NamedTuple):
    """Of values on three grids.

    order         observed, nan where the values do not say, as where they drift apart
    extrapolated  value for cells of no size; nan where there is no order
    band          half-width of the band round the finest value that should hold the exact one, over that value
    is_monotone   whether the values move one way; else order and band say little, and the spread says more
    spread        largest less smallest value, over the finest
    """

    order: float
    extrapolated: float
    band: float
    is_monotone: bool
    spread: float


def grid_convergence(sizes: tuple[float, float, float], values: tuple[float, float, float]) -> GridConvergence:
    """Convergence of values on grids whose cells have these sizes, the finest first.

    With r21 = h2/h1, r32 = h3/h2, e = differences and s = sign(e32/e21) the order p obeys
    p = (ln|e32/e21| + ln((r21^p - s)/(r32^p - s))) / ln r21. The band takes a p above 2, the schemes' order, as 2, and
    as 1 where there is none. Raises ParameterError where sizes are out of order.

    Source  celik2008
    """
    (h1, h2, h3), (f1, f2, f3) = sizes, values
    r21, r32 = h2 / h1, h3 / h2
    if not min(r21, r32) > LEAST_RATIO:
        raise ParameterError(
            f"grids differ by {r21:.3g} and {r32:.3g}; expected the finest first, each {LEAST_RATIO} apart"
        )
    e21, e32 = f2 - f1, f3 - f2
    spread = (max(values) - min(values)) / abs(f1)
    if e21 == 0.0:
        return GridConvergence(math.nan, f1, 0.0, True, spread)
    order = _order(r21, r32, e32 / e21) if e32 else 0.0
    gain = r21 ** min(order or LOWEST_ORDER, HIGHEST_ORDER) - 1.0
    extrapolated = f1 - e21 / gain if order else math.nan
    return GridConvergence(order or math.nan, extrapolated, SAFETY * abs(e21 / f1) / gain, e32 / e21 >= 0.0, spread)


def _order(r21: float, r32: float, ratio: float) -> float:
    """The order by repeated substitution; 0 where the finer grids differ more than the coarser ones."""
    sign, order = math.copysign(1.0, ratio), 1.0
    for _ in range(ITERATIONS):
        above, below = r21**order - sign, r32**order - sign
        if not above / below > 0.0:
            return 0.0
        found = (math.log(abs(ratio)) + math.log(above / below)) / math.log(r21)
        if found <= 0.0:
            return 0.0
        if abs(found - order) < 1e-12:
            break
        order = 0.5 * (found + order)
    return order
