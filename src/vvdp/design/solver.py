"""A design problem for the interior-point solver: exact derivatives by CasADi, limits and what every valve must meet.

Variables are searched in their logarithms and every limit is measured in parts of its size, so that multipliers give
elasticities: by how many per cent the objective changes when a limit or a bound moves by one per cent.
"""

import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from copy import copy
from dataclasses import dataclass
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.select import maximum
from vvdp.design.problem import TRANSITIONAL, Limit, Problem, Side
from vvdp.design.quantities import Quantities
from vvdp.design.variables import with_variables
from vvdp.valve.geometry import barrier_width, nozzle_width, pitch

FEASIBLE = 1e-6
"""Excess of a limit, as a part of it, that still counts as met."""
SNAP = 1e-7
"""Relative distance from a bound below which a variable is put there: what the solver leaves of it."""
MARGIN = 1e6
"""Scale of the excess over the relief setting [Pa]."""


@dataclass(frozen=True)
class Geometry:
    """A constraint on every valve: an excess that must not be above zero, and the numbers behind it in words."""

    words: str
    excess: Callable[[Any, Sequence[Any]], Any]
    numbers: Callable[[Any, Sequence[Any]], str]


def _fits(valve: Any, found: Sequence[Any]) -> Any:
    return found[0].transition_fraction - 1.0


def _fit_numbers(valve: Any, found: Sequence[Any]) -> str:
    width, barrier, arc = (1e3 * f(valve) for f in (nozzle_width, barrier_width, pitch))
    return f"nozzle {width:.4g} mm and barrier {barrier:.4g} mm wide in a pitch of {arc:.4g} mm"


def _seals(valve: Any, found: Sequence[Any]) -> Any:
    return 10.0 * valve.radial_clearance / barrier_width(valve) - 1.0


def _seal_numbers(valve: Any, found: Sequence[Any]) -> str:
    return f"clearance {1e6 * valve.radial_clearance:.4g} um, land {1e6 * barrier_width(valve):.4g} um"


def _stays_closed(valve: Any, found: Sequence[Any]) -> Any:
    """Bigger than zero where load and open drop reach the relief setting at any point.

    Measured with a fixed pressure: in parts of the drop a larger drop would look closer.
    """
    worst = -found[0].relief_margin / MARGIN
    for q in found[1:]:
        worst = maximum(worst, -q.relief_margin / MARGIN)
    return worst


def _closed_numbers(valve: Any, found: Sequence[Any]) -> str:
    margin = min(float(q.relief_margin) for q in found)
    return f"the open valve leaves {round(1e-5 * margin, 4) + 0.0:.4g} bar to the relief setting"


FITS = Geometry("nozzle and barrier fit into the pitch", _fits, _fit_numbers)
SEALS = Geometry("the clearance is at most a tenth of the barrier that it seals under", _seals, _seal_numbers)
STAYS_CLOSED = Geometry("the relief valve is closed while the load port is open", _stays_closed, _closed_numbers)


def geometry_of(problem: Problem) -> tuple[Geometry, ...]:
    """The demands that come from the valve itself and from the range of the formulas.

    A relief valve that a limit keeps closed is not demanded to be closed again: of two that are alike each
    multiplier would be any part of the true one.
    """
    kept_closed = any(
        limit.quantity == "relief_margin" and (limit.at_least or limit.exactly) and limit.value >= 0.0
        for limit in problem.limits
        if not limit.over_the_points
    )
    stays_closed = (STAYS_CLOSED,) if problem.quantities & TRANSITIONAL and not kept_closed else ()
    return (FITS, SEALS, *stays_closed)


class Traced:
    """A problem as CasADi functions of the logarithms of its free variables, with the others held."""

    def __init__(self, problem: Problem, held: Mapping[str, float]) -> None:
        import casadi

        self.problem, self.held = problem, dict(held)
        self.bounds = [b for b in problem.bounds if b.variable.name not in held]
        self.geometry = geometry_of(problem)
        with quiet_casadi():
            x = casadi.SX.sym("x", len(self.bounds))
            values = {b.variable.name: casadi.exp(x[i]) for i, b in enumerate(self.bounds)} | self.held
            found = problem.evaluate_symbols(values)
            valve = valve_of(problem, values)
            objective = problem.sign * problem.mean(found, problem.objective)
            of_limits = problem.excesses(found)
            excesses = [excess for each in of_limits for excess in each]
            demands = [each.excess(valve, found) for each in self.geometry]
        self.per_limit = [len(each) for each in of_limits]
        self.x, self.objective = x, objective
        self.excesses = casadi.vertcat(*excesses, *demands)
        self.count = len(excesses) + len(demands)
        exact = np.repeat([limit.exactly for limit in problem.limits], self.per_limit).astype(bool)
        self.floors = np.concatenate([np.where(exact, 0.0, -np.inf), np.full(len(demands), -np.inf)])
        self.ceilings = np.zeros(self.count)
        start = self.inside(problem.start)
        self.scale = abs(float(casadi.Function("f", [x], [objective])(start))) or 1.0
        self.low = np.log([b.low for b in self.bounds])
        self.high = np.log([b.high for b in self.bounds])
        self.solver = casadi.nlpsol("optimum", "ipopt", self.nlp(objective / self.scale), OPTIONS)

    def nlp(self, objective: Any) -> dict[str, Any]:
        """The problem with another objective, as the solver takes it."""
        return {"x": self.x, "f": objective, "g": self.excesses}

    def inside(self, values: Mapping[str, float]) -> Array:
        """The point of the search for `values`."""
        return np.log([values[b.variable.name] for b in self.bounds])

    def with_limit(self, source: Limit | Side, value: float) -> "Traced":
        """The same with a limit or one side of a bound at `value` [SI]; nothing is traced again."""
        other = copy(self)
        if isinstance(source, Limit):
            rows = np.repeat([each is source for each in self.problem.limits], self.per_limit)
            rows = np.concatenate([rows, np.zeros(self.count - rows.size, bool)])
            other.ceilings = np.where(rows, source.excess(value), self.ceilings)
            other.floors = np.where(rows & np.isfinite(self.floors), other.ceilings, self.floors)
        else:
            place = self.bounds.index(source.bound)
            for ends in ("low", "high") if source.bound.is_fixed else ("high",) if source.upper else ("low",):
                moved = getattr(self, ends).copy()
                moved[place] = np.log(value)
                setattr(other, ends, moved)
        return other

    def values(self, x: Array) -> dict[str, float]:
        """All variables [SI] at a point of the search, those at a bound exactly there."""
        found = dict(self.held)
        for bound, low, high, log in zip(self.bounds, self.low, self.high, x, strict=True):
            inside = bound.low if log - low < SNAP else bound.high if high - log < SNAP else float(np.exp(log))
            found[bound.variable.name] = inside
        return {b.variable.name: found[b.variable.name] for b in self.problem.bounds}

    def solve(self, start: Array) -> "Local | None":
        """The local optimum from `start`; None where the solver found none that is feasible."""
        with quiet_casadi():
            answer = self.solver(x0=start, lbx=self.low, ubx=self.high, lbg=self.floors, ubg=self.ceilings)
        x, g = row_of(answer["x"]), row_of(answer["g"])
        within = np.all((g >= self.floors - FEASIBLE) & (g <= self.ceilings + FEASIBLE))
        if not (self.solver.stats()["success"] and within):
            return None
        return Local(
            traced=self,
            x=x,
            objective=self.scale * float(answer["f"]),
            of_limits=row_of(answer["lam_g"]),
            of_bounds=row_of(answer["lam_x"]),
        )


OPTIONS: Mapping[str, Any] = {
    "print_time": False,
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "ipopt.tol": 1e-9,
    "ipopt.acceptable_tol": 1e-8,
    "ipopt.bound_relax_factor": 0.0,
    "ipopt.max_iter": 500,
}


@dataclass(frozen=True)
class Local:
    """A local optimum: where, the objective [SI], and the multipliers of limits and bounds."""

    traced: Traced
    x: Array
    objective: float
    of_limits: Array
    of_bounds: Array


@contextmanager
def quiet_casadi() -> Iterator[None]:
    """CasADi announces a change in how NumPy's functions meet its symbols; what is used here is the same in both."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FutureWarning)
        yield


def row_of(matrix: Any) -> Array:
    """A matrix of CasADi as one row of numbers."""
    found: Array = matrix.full().ravel()
    return found


def valve_of(problem: Problem, values: Mapping[str, object]) -> Any:
    """The valve with the variables at `values` [SI], which may be arrays or symbols."""
    return with_variables(problem.points[0].setup, values).valve


def plain_quantities(found: Quantities) -> Quantities:
    """Quantities as plain floats."""
    return Quantities(**{name: float(value) for name, value in found._asdict().items()})
