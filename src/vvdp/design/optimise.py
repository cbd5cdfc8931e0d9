"""Optimum of a problem: an interior-point solver from many starts, and a global check that knows no gradients."""

import itertools
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import VvdpError
from vvdp.base.extras import require
from vvdp.design.infeasibility import Elastic, InfeasibleError, infeasibility
from vvdp.design.problem import Limit, Problem, Side
from vvdp.design.quantities import Quantities
from vvdp.design.solver import Geometry, Local, Traced, plain_quantities, valve_of

SAME = 1e-6
"""Relative difference of two optima below which they are one."""
ACTIVE = 1e-4
"""Elasticity from which on a limit or a bound counts as active."""


@dataclass(frozen=True)
class Active:
    """A limit, bound or constraint that holds the optimum back.

    `elasticity`: relative change of the objective over that of the limit, NaN for a limit of zero; `sensitivity`:
    change of the objective over that of the limit [SI over SI].
    """

    source: Limit | Side | Geometry
    kind: str
    elasticity: float
    sensitivity: float

    @property
    def words(self) -> str:
        """The limit, bound or constraint in words."""
        return self.source.words


@dataclass(frozen=True)
class Optimum:
    """The best design that was found, its active limits, and numbers on how certain it is.

    `converged` of `starts` random starts ended in a feasible optimum, `agreeing` of them in this one, the others in
    `worse_optima`.
    `global_objective` is the best that the global search found by itself, None where there was none.
    """

    problem: Problem
    values: Mapping[str, float]
    objective: float
    before: tuple[Quantities, ...]
    after: tuple[Quantities, ...]
    active: tuple[Active, ...]
    starts: int
    converged: int
    agreeing: int
    worse_optima: tuple[float, ...]
    global_objective: float | None
    global_evaluations: int
    finished: bool


def optimise(
    problem: Problem,
    *,
    starts: int = 20,
    seed: int = 1,
    globally: bool = True,
    progress: Callable[[int, int], None] | None = None,
) -> Optimum:
    """The best design within the bounds that meets all limits.

    From the design as it is and from `starts` random ones, each solved to a local optimum; then, `globally`, a search
    by differential evolution, whose best point is solved in turn. Raises InfeasibleError where no design meets all,
    VvdpError where the objective comes to zero.
    Ctrl-C ends the search and keeps the best so far; the optimum then says that it is not `finished`.
    """
    search = search_optima(problem, starts=starts, seed=seed, globally=globally, progress=progress)
    best = search.best
    if abs(best.objective) <= SAME * best.traced.scale:
        name = problem.objective
        raise VvdpError(
            f"the least {name} comes to zero: any change is infinitely large against it, so nothing can be said of the "
            f'optimum; minimise something else, and demand what you need of it with --subject-to "{name} <= ..."'
        )
    values = best.traced.values(best.x)
    after = tuple(plain_quantities(q) for q in problem.evaluate(values))
    converged = search.converged
    far = [local.objective for local in converged if local.objective - best.objective > SAME * abs(best.objective)]
    return Optimum(
        problem=problem,
        values=values,
        objective=float(problem.mean(after, problem.objective)),
        before=tuple(problem.evaluate({})),
        after=after,
        active=tuple(sorted(_active(problem, best), key=_grip)),
        starts=search.started,
        converged=len(converged),
        agreeing=len(converged) - len(far),
        worse_optima=tuple(sorted({float(f"{objective:.6g}") for objective in far})),
        global_objective=search.lowest if np.isfinite(search.lowest) else None,
        global_evaluations=search.evaluations,
        finished=search.finished,
    )


def search_optima(
    problem: Problem,
    *,
    starts: int,
    seed: int,
    globally: bool,
    progress: Callable[[int, int], None] | None = None,
) -> "Search":
    """All that `optimise` finds on its way. Raises InfeasibleError where no design meets all."""
    require("casadi", "opt", "an optimum")
    whole = [b for b in problem.bounds if b.variable.whole]
    choices = [
        dict(zip((b.variable.name for b in whole), map(float, numbers), strict=True))
        for numbers in itertools.product(*(range(round(b.low), round(b.high) + 1) for b in whole))
    ]
    search = Search(problem, starts, seed, globally=globally, progress=progress)
    search.rounds *= len(choices)
    try:
        for held in choices:
            search.look(held)
    except KeyboardInterrupt:
        if not search.found:
            raise
        search.finished = False
    if not search.found:
        asked = problem.one_sided
        closest = min(choices, key=lambda held: Elastic(asked, held).least()[0])
        raise InfeasibleError(infeasibility(asked, closest))
    return search


class Search:
    """State of a search so far, whole numbers held at one choice after another."""

    def __init__(
        self,
        problem: Problem,
        starts: int,
        seed: int,
        *,
        globally: bool,
        progress: Callable[[int, int], None] | None,
    ) -> None:
        self.problem, self.starts, self.seed, self.globally, self.progress = problem, starts, seed, globally, progress
        self.rng = np.random.default_rng(seed)
        self.rounds, self.done, self.started, self.evaluations = starts + 1, 0, 0, 0
        self.found: list[Local] = []
        self.converged: list[Local] = []
        self.lowest, self.finished = np.inf, True

    @property
    def best(self) -> Local:
        """The best design so far, of all that meet the limits."""
        return min(self.found, key=lambda local: local.objective)

    def look(self, held: Mapping[str, float]) -> None:
        """Local optima from the design as it is and from random ones, then the global search."""
        traced = Traced(self.problem, held)
        if not traced.bounds:
            raise InfeasibleError("every variable is fixed: nothing is left to choose")
        self._solve(traced, traced.inside({**self.problem.start, **held}))
        for _ in range(self.starts):
            local = self._solve(traced, self.rng.uniform(traced.low, traced.high))
            self.started += 1
            if local is not None:
                self.converged.append(local)
        if self.globally and self.found:
            x, value, count = _global_search(self.problem.one_sided, traced, self.seed)
            self.evaluations += count
            self.lowest = min(self.lowest, value)
            if (local := traced.solve(x)) is not None:
                self.found.append(local)

    def _solve(self, traced: Traced, point: Array) -> Local | None:
        local = traced.solve(point)
        if local is not None:
            self.found.append(local)
        self.done += 1
        if self.progress:
            self.progress(self.done, self.rounds)
        return local


def _global_search(problem: Problem, traced: Traced, seed: int) -> tuple[Array, float, int]:
    """The best point of a differential evolution, the objective there (inf where not feasible), and evaluations.

    It works on the formulas in plain numbers, whole generations at once, and knows nothing of the other solver.
    """
    from scipy.optimize import differential_evolution

    count = 0

    def penalised_costs(x: Array) -> Any:
        nonlocal count
        objective, violation = _judge(problem, traced, x)
        count += violation.size
        total = objective + 20.0 * violation
        return total if x.ndim > 1 else float(total[0])

    box: Any = list(zip(traced.low, traced.high, strict=True))
    answer = differential_evolution(
        penalised_costs, box, rng=seed, popsize=15, maxiter=300, tol=1e-8,
        polish=False, vectorized=True, updating="deferred", init="sobol",
    )  # fmt: skip
    objective, violation = _judge(problem, traced, answer.x)
    value = traced.scale * float(objective[0]) if violation[0] <= 1e-3 else np.inf
    return answer.x, value, count + 1


def _judge(problem: Problem, traced: Traced, x: Array) -> tuple[Array, Array]:
    """The objective in parts of its scale, and the sum of what limits and constraints are exceeded by, per column."""
    columns = x.reshape(len(traced.bounds), -1)
    size = columns.shape[1]
    values: dict[str, Any] = dict(traced.held)
    for bound, column in zip(traced.bounds, columns, strict=True):
        values[bound.variable.name] = np.exp(column)
    with np.errstate(all="ignore"):
        found = problem.evaluate(values)
        valve = valve_of(problem, values)
        excess = [excess for each in problem.excesses(found) for excess in each]
        excess += [each.excess(valve, found) for each in traced.geometry]
        objective = problem.sign * problem.mean(found, problem.objective) / traced.scale
    violation: Array = np.zeros(size)
    for each in excess:
        violation = violation + np.clip(np.nan_to_num(np.broadcast_to(each, size), nan=1e3), 0.0, None)
    return np.broadcast_to(np.nan_to_num(objective, nan=1e3), size), violation


def _active(problem: Problem, local: Local) -> Iterator[Active]:
    """Active limits, constraints and bounds of a local optimum. The multiplier of a limit, over all points, is the
    change of the relative objective when the limit moves outwards by its measure."""
    traced = local.traced
    relative = traced.scale / local.objective
    ends = np.cumsum(traced.per_limit, dtype=int)
    for limit, count, end in zip(problem.limits, traced.per_limit, ends, strict=True):
        multiplier = float(np.sum(local.of_limits[end - count : end])) * relative
        if abs(multiplier) > ACTIVE:
            # raising an upper limit by its measure lowers the excess by 1
            sensitivity = (multiplier if limit.at_least else -multiplier) * local.objective / limit.measure
            elasticity = sensitivity * limit.value / local.objective if limit.value else np.nan
            yield Active(limit, "usual limit" if limit.usual else "limit", elasticity, sensitivity)
    for k, each in enumerate(traced.geometry):
        multiplier = float(local.of_limits[sum(traced.per_limit) + k]) * relative
        if abs(multiplier) > ACTIVE:
            yield Active(each, "geometry", np.nan, np.nan)
    for bound, multiplier in zip(traced.bounds, local.of_bounds, strict=True):
        elasticity = -float(multiplier) * relative
        if abs(elasticity) > ACTIVE:
            side = Side(bound, upper=bool(multiplier > 0.0))
            kind = "bound" if side.is_given else "usual bound"
            yield Active(side, kind, elasticity, elasticity * local.objective / side.value)
    for bound in problem.bounds:
        if bound.variable.whole and not bound.is_fixed:
            number = traced.held[bound.variable.name]
            if number in (bound.low, bound.high):
                yield Active(Side(bound, upper=number == bound.high), "bound of a whole number", np.nan, np.nan)


def _grip(each: Active) -> float:
    """By this what holds most comes first."""
    return -abs(each.elasticity) if np.isfinite(each.elasticity) else 0.0
