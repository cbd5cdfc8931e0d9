"""Sensitivity of the optimum to its problem: one limit or bound changed at a time, and exact gradients."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.extras import require
from vvdp.design.optimise import Optimum
from vvdp.design.problem import Limit, Problem, Side
from vvdp.design.quantities import Quantities
from vvdp.design.solver import Traced, quiet_casadi, row_of

FACTORS = tuple(float(f) for f in np.linspace(0.7, 1.4, 15))
AT = int(np.argmin(np.abs(np.array(FACTORS) - 1.0)))
"""The place of the value that a limit has."""
MOST = 4
"""How many limits and bounds are moved."""


@dataclass(frozen=True)
class LimitCurve:
    """The optimum's objective where one limit or bound takes other values [SI]; NaN where there is no design."""

    source: Limit | Side
    values: tuple[float, ...]
    objectives: tuple[float, ...]


def movable(found: Optimum) -> list[Limit | Side]:
    """Active limits and bounds of an optimum that can be moved by shares of themselves, those of largest effect
    first."""
    finite = (each.source for each in found.active if np.isfinite(each.elasticity))
    return [source for source in finite if isinstance(source, Limit | Side)][:MOST]


def limit_curves(found: Optimum, *, progress: Callable[[int, int], None] | None = None) -> list[LimitCurve]:
    """How the optimum goes with what is `movable`: each limit or bound moved by `FACTORS`, all else as it is.

    Ctrl-C ends it; the curves are then fewer.
    """
    curves: list[LimitCurve] = []
    wanted = movable(found)
    held = {b.variable.name: found.values[b.variable.name] for b in found.problem.bounds if b.variable.whole}
    try:
        traced = Traced(found.problem, held)
        for source in wanted:
            values, objectives = tuple(f * source.value for f in FACTORS), []
            for value in values:
                objectives.append(_least(traced.with_limit(source, value), found))
                if progress:
                    progress(len(curves) * len(FACTORS) + len(objectives), len(wanted) * len(FACTORS))
            curves.append(LimitCurve(source, values, tuple(objectives)))
    except KeyboardInterrupt:
        pass
    return curves


def _least(traced: Traced, found: Optimum) -> float:
    """The least objective of a variant of the problem that `found` solves; NaN where there is no design."""
    if np.any(traced.low > traced.high):
        return float("nan")
    starts = (np.clip(traced.inside(values), traced.low, traced.high) for values in (found.values, found.problem.start))
    return min((local.objective for start in starts if (local := traced.solve(start))), default=float("nan"))


def gradients(problem: Problem, values: Mapping[str, float]) -> dict[str, Array]:
    """Exact derivatives of every quantity at the first point by the logarithms of the free variables."""
    require("casadi", "opt", "a gradient")
    import casadi

    with quiet_casadi():
        x = casadi.SX.sym("x", len(problem.bounds))
        symbols = {b.variable.name: casadi.exp(x[i]) for i, b in enumerate(problem.bounds)}
        found = problem.evaluate_symbols(symbols)[0]
        at = np.log([values[b.variable.name] for b in problem.bounds])
        return {
            name: row_of(casadi.Function("g", [x], [casadi.gradient(getattr(found, name), x)])(at))
            for name in Quantities._fields
        }
