"""Optimum of a problem: exact gradients by CasADi, an interior-point solver from many starts, and a global check.

Variables are searched in their logarithms and every limit is measured in parts of its size, so that multipliers give
elasticities: by how many per cent the objective changes when a limit or a bound moves by one per cent.
"""

import itertools
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import VvdpError
from vvdp.base.extras import require
from vvdp.design.problem import TRANSITIONAL, Bound, Limit, Problem
from vvdp.design.quantities import Quantities
from vvdp.valve.geometry import barrier_width

FEASIBLE = 1e-6
"""Excess of a limit, as a part of it, that still counts as met."""
SAME = 1e-6
"""Relative difference of two optima below which they are one."""
ACTIVE = 1e-4
"""Elasticity from which on a limit or a bound counts as active."""
SNAP = 1e-7
"""Relative distance from a bound below which a variable is put there: what the solver leaves of it."""
MARGIN = 1e6
"""What a lack of room to the relief setting is measured with [Pa]."""
WIDER = 100.0
"""By what factor a bound is moved to see whether it is in the way."""


class InfeasibleError(VvdpError):
    """No design meets all that is asked for; the message says what is in each other's way."""


@dataclass(frozen=True)
class Holding:
    """A limit or bound that holds the optimum back. `elasticity`: relative change of the objective over that of the
    limit, NaN for a limit of zero; `sensitivity`: change of the objective over that of the limit [SI over SI]."""

    text: str
    kind: str
    elasticity: float
    sensitivity: float


@dataclass(frozen=True)
class Optimum:
    """The best design that was found, what holds it there, and how sure one may be of it.

    `converged` of `starts` random starts ended in a feasible optimum, `agreeing` of them in this one, the others in
    `worse_optima`.
    `global_objective` is the best that the global search found by itself, None where there was none.
    """

    problem: Problem
    values: Mapping[str, float]
    objective: float
    before: tuple[Quantities, ...]
    after: tuple[Quantities, ...]
    holding: tuple[Holding, ...]
    starts: int
    converged: int
    agreeing: int
    worse_optima: tuple[float, ...]
    global_objective: float | None
    global_evaluations: int
    finished: bool


@dataclass(frozen=True)
class Geometry:
    """What any valve has to meet, whoever asks: an excess that must not be above zero, and how to tell of it."""

    words: str
    excess: Callable[[Any, Sequence[Any]], Any]
    told: Callable[[Any, Sequence[Any]], str]


def _fits(valve: Any, found: Sequence[Any]) -> Any:
    return found[0].transition_fraction - 1.0


def _fits_told(valve: Any, found: Sequence[Any]) -> str:
    from vvdp.valve.geometry import nozzle_width, pitch

    width, barrier, arc = (1e3 * f(valve) for f in (nozzle_width, barrier_width, pitch))
    return f"nozzle {width:.4g} mm and barrier {barrier:.4g} mm wide in a pitch of {arc:.4g} mm"


def _seals(valve: Any, found: Sequence[Any]) -> Any:
    return 10.0 * valve.radial_clearance / barrier_width(valve) - 1.0


def _seals_told(valve: Any, found: Sequence[Any]) -> str:
    return f"clearance {1e6 * valve.radial_clearance:.4g} um, land {1e6 * barrier_width(valve):.4g} um"


def _stays_shut(valve: Any, found: Sequence[Any]) -> Any:
    """Bigger than zero where load and open drop reach the relief setting at any point.

    Measured with a fixed pressure: in parts of the drop a larger drop would look closer.
    """
    worst = -found[0].relief_margin / MARGIN
    for q in found[1:]:
        worst = _larger(worst, -q.relief_margin / MARGIN)
    return worst


def _larger(a: Any, b: Any) -> Any:
    from vvdp.base.select import maximum

    return maximum(a, b)


def _stays_shut_told(valve: Any, found: Sequence[Any]) -> str:
    margin = min(float(q.relief_margin) for q in found)
    return f"the open valve leaves {round(1e-5 * margin, 4) + 0.0:.4g} bar to the relief setting"


FITS = Geometry("nozzle and barrier fit into the pitch", _fits, _fits_told)
SEALS = Geometry("the clearance is at most a tenth of the barrier that it seals under", _seals, _seals_told)
STAYS_SHUT = Geometry("the relief valve is shut while the load port is open", _stays_shut, _stays_shut_told)


def geometry_of(problem: Problem) -> tuple[Geometry, ...]:
    """The demands that come from the valve itself and from the range of the formulas.

    A relief valve that a limit keeps shut is not demanded to be shut again: of two that are alike each multiplier would
    be any part of the true one.
    """
    kept_shut = any(
        limit.quantity == "relief_margin" and (limit.at_least or limit.exactly) and limit.value >= 0.0
        for limit in problem.limits
        if not limit.over_the_points
    )
    stays_shut = (STAYS_SHUT,) if problem.quantities & TRANSITIONAL and not kept_shut else ()
    return (FITS, SEALS, *stays_shut)


class Traced:
    """A problem as CasADi functions of the logarithms of its free variables, with the others held."""

    def __init__(self, problem: Problem, held: Mapping[str, float]) -> None:
        import casadi

        self.problem, self.held = problem, dict(held)
        self.bounds = [b for b in problem.bounds if b.variable.name not in held]
        self.geometry = geometry_of(problem)
        with _quiet():
            x = casadi.SX.sym("x", len(self.bounds))
            values = {b.variable.name: casadi.exp(x[i]) for i, b in enumerate(self.bounds)} | self.held
            found = problem.found(values)
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
        start = self.inside(problem.start)
        self.scale = abs(float(casadi.Function("f", [x], [objective])(start))) or 1.0
        self.low = np.log([b.low for b in self.bounds])
        self.high = np.log([b.high for b in self.bounds])
        self.solver = casadi.nlpsol("optimum", "ipopt", self._problem(objective / self.scale), _OPTIONS)

    def _problem(self, objective: Any) -> dict[str, Any]:
        return {"x": self.x, "f": objective, "g": self.excesses}

    def inside(self, values: Mapping[str, float]) -> Array:
        """The point of the search for `values`."""
        return np.log([values[b.variable.name] for b in self.bounds])

    def values(self, x: Array) -> dict[str, float]:
        """All variables [SI] at a point of the search, those at a bound exactly there."""
        found = dict(self.held)
        for bound, low, high, log in zip(self.bounds, self.low, self.high, x, strict=True):
            inside = bound.low if log - low < SNAP else bound.high if high - log < SNAP else float(np.exp(log))
            found[bound.variable.name] = inside
        return {b.variable.name: found[b.variable.name] for b in self.problem.bounds}

    def solved(self, start: Array) -> "_Local | None":
        """The local optimum from `start`; None where the solver found none that is feasible."""
        with _quiet():
            answer = self.solver(x0=start, lbx=self.low, ubx=self.high, lbg=self.floors, ubg=0.0)
        x, g = _row(answer["x"]), _row(answer["g"])
        fine = self.solver.stats()["success"] and np.all((g >= self.floors - FEASIBLE) & (g <= FEASIBLE))
        if not fine:
            return None
        return _Local(self, x, self.scale * float(answer["f"]), _row(answer["lam_g"]), _row(answer["lam_x"]))


@dataclass(frozen=True)
class _Local:
    traced: Traced
    x: Array
    objective: float
    of_limits: Array
    of_bounds: Array


_OPTIONS: Mapping[str, Any] = {
    "print_time": False,
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "ipopt.tol": 1e-9,
    "ipopt.acceptable_tol": 1e-8,
    "ipopt.bound_relax_factor": 0.0,
    "ipopt.max_iter": 500,
}


@contextmanager
def _quiet() -> Iterator[None]:
    """CasADi announces a change in how NumPy's functions meet its symbols; what is used here is the same in both."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FutureWarning)
        yield


def _row(matrix: Any) -> Array:
    found: Array = matrix.full().ravel()
    return found


def valve_of(problem: Problem, values: Mapping[str, Any]) -> Any:
    """The valve of a problem with its variables at `values` [SI], arrays or symbols."""
    from vvdp.design.variables import changed

    return changed(problem.points[0].setup, values).valve


def optimised(
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
    search = searched(problem, starts=starts, seed=seed, globally=globally, progress=progress)
    best = search.best
    if abs(best.objective) <= SAME * best.traced.scale:
        name = problem.objective
        raise VvdpError(
            f"the least {name} comes to zero: any change is infinitely large against it, so nothing can be said of the "
            f'optimum; minimise something else, and demand what you need of it with --subject-to "{name} <= ..."'
        )
    values = best.traced.values(best.x)
    after = tuple(_plain(q) for q in problem.found(values))
    converged = search.converged
    far = [local.objective for local in converged if local.objective - best.objective > SAME * abs(best.objective)]
    return Optimum(
        problem,
        values,
        float(problem.mean(after, problem.objective)),
        tuple(problem.found({})),
        after,
        tuple(_holding(problem, best)),
        search.started,
        len(converged),
        len(converged) - len(far),
        tuple(sorted({float(f"{objective:.6g}") for objective in far})),
        search.lowest if np.isfinite(search.lowest) else None,
        search.evaluations,
        search.finished,
    )


def searched(
    problem: Problem,
    *,
    starts: int,
    seed: int,
    globally: bool,
    progress: Callable[[int, int], None] | None = None,
) -> "_Search":
    """All that `optimised` finds on its way. Raises InfeasibleError where no design meets all."""
    require("casadi", "opt", "an optimum")
    whole = [b for b in problem.bounds if b.variable.whole]
    choices = [
        dict(zip((b.variable.name for b in whole), map(float, numbers), strict=True))
        for numbers in itertools.product(*(range(round(b.low), round(b.high) + 1) for b in whole))
    ]
    search = _Search(problem, starts, seed, globally, len(choices), progress)
    try:
        for held in choices:
            search.look(held)
    except KeyboardInterrupt:
        if not search.found:
            raise
        search.finished = False
    if not search.found:
        asked = problem.one_sided
        closest = min(choices, key=lambda held: _Elastic(asked, held).least()[0])
        raise InfeasibleError(conflict(asked, closest))
    return search


class _Search:
    """What a search has found so far, whole numbers held at one choice after another."""

    def __init__(
        self,
        problem: Problem,
        starts: int,
        seed: int,
        globally: bool,
        choices: int,
        progress: Callable[[int, int], None] | None,
    ) -> None:
        self.problem, self.starts, self.seed, self.globally, self.progress = problem, starts, seed, globally, progress
        self.rng = np.random.default_rng(seed)
        self.rounds, self.done, self.started, self.evaluations = choices * (starts + 1), 0, 0, 0
        self.found: list[_Local] = []
        self.converged: list[_Local] = []
        self.lowest, self.finished = np.inf, True

    @property
    def best(self) -> "_Local":
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
            x, value, count = _searched(self.problem.one_sided, traced, self.seed)
            self.evaluations += count
            self.lowest = min(self.lowest, value)
            if (local := traced.solved(x)) is not None:
                self.found.append(local)

    def _solve(self, traced: Traced, point: Array) -> "_Local | None":
        local = traced.solved(point)
        if local is not None:
            self.found.append(local)
        self.done += 1
        if self.progress:
            self.progress(self.done, self.rounds)
        return local


def _plain(found: Quantities) -> Quantities:
    return Quantities(*(float(value) for value in found))


def _searched(problem: Problem, traced: Traced, seed: int) -> tuple[Array, float, int]:
    """The best point of a differential evolution, the objective there (inf where not feasible), and evaluations.

    It works on the formulas in plain numbers, whole generations at once, and knows nothing of the other solver.
    """
    from scipy.optimize import differential_evolution

    count = 0

    def judged(x: Array) -> tuple[Array, Array]:
        nonlocal count
        columns = x.reshape(len(traced.bounds), -1)
        count += columns.shape[1]
        values: dict[str, Any] = dict(traced.held)
        for bound, column in zip(traced.bounds, columns, strict=True):
            values[bound.variable.name] = np.exp(column)
        with np.errstate(all="ignore"):
            found = problem.found(values)
            valve = valve_of(problem, values)
            excess = [excess for each in problem.excesses(found) for excess in each]
            excess += [each.excess(valve, found) for each in traced.geometry]
            objective = problem.sign * problem.mean(found, problem.objective) / traced.scale
        violation = sum(
            np.clip(np.nan_to_num(np.broadcast_to(e, columns.shape[1]), nan=1e3), 0.0, None) for e in excess
        )
        return np.broadcast_to(np.nan_to_num(objective, nan=1e3), columns.shape[1]), violation

    def penalised(x: Array) -> Any:
        objective, violation = judged(x)
        total = objective + 20.0 * violation
        return total if x.ndim > 1 else float(total[0])

    box: Any = list(zip(traced.low, traced.high, strict=True))
    answer = differential_evolution(
        penalised, box, rng=seed, popsize=15, maxiter=300, tol=1e-8,
        polish=False, vectorized=True, updating="deferred", init="sobol",
    )  # fmt: skip
    objective, violation = judged(answer.x)
    value = traced.scale * float(objective[0]) if violation[0] <= 1e-3 else np.inf
    return answer.x, value, count


def _holding(problem: Problem, local: _Local) -> list[Holding]:
    """What is active at a local optimum. The multiplier of a limit, over all points, is what the relative objective
    changes by when the limit moves outwards by its measure."""
    relative = local.traced.scale / local.objective
    found = []
    ends = np.cumsum(local.traced.per_limit, dtype=int)
    for limit, count, end in zip(problem.limits, local.traced.per_limit, ends, strict=True):
        multiplier = float(np.sum(local.of_limits[end - count : end])) * relative
        if abs(multiplier) > ACTIVE:
            # raising an upper limit by its measure lowers the excess by 1
            sensitivity = (multiplier if limit.at_least else -multiplier) * local.objective / limit.measure
            elasticity = sensitivity * limit.value / local.objective if limit.value else np.nan
            kind = "usual limit" if limit.usual else "limit"
            found.append(Holding(str(limit), kind, elasticity, sensitivity))
    for k, each in enumerate(local.traced.geometry):
        multiplier = float(local.of_limits[sum(local.traced.per_limit) + k]) * relative
        if abs(multiplier) > ACTIVE:
            found.append(Holding(each.words, "geometry", np.nan, np.nan))
    for bound, multiplier in zip(local.traced.bounds, local.of_bounds, strict=True):
        elasticity = -float(multiplier) * relative
        if abs(elasticity) > ACTIVE:
            upper = bool(multiplier > 0.0)
            value = bound.high if upper else bound.low
            given = bound.fixed or (bound.high_given if upper else bound.low_given)
            kind = "bound" if given else "usual bound"
            found.append(Holding(bound.side(upper), kind, elasticity, elasticity * local.objective / value))
    for bound in problem.bounds:
        if (
            bound.variable.whole
            and not bound.fixed
            and local.traced.held[bound.variable.name] in (bound.low, bound.high)
        ):
            upper = local.traced.held[bound.variable.name] == bound.high
            found.append(Holding(bound.side(upper), "bound of a whole number", np.nan, np.nan))
    return sorted(found, key=lambda each: -abs(each.elasticity) if np.isfinite(each.elasticity) else 0.0)


# What the optimum would be if a limit were another


@dataclass(frozen=True)
class Moved:
    """The optimum's objective where one limit or bound takes other values [SI]; NaN where there is no design.

    `at` is the place of the value that it has.
    """

    text: str
    at: int
    values: tuple[float, ...]
    objectives: tuple[float, ...]


FACTORS = tuple(float(f) for f in np.linspace(0.7, 1.4, 15))
_AT = int(np.argmin(np.abs(np.array(FACTORS) - 1.0)))
MOST = 4
"""How many limits and bounds are moved."""


def movable(found: Optimum) -> list[Holding]:
    """What holds an optimum most, the most at first, of all that can be moved by parts of itself."""
    return [each for each in found.holding if np.isfinite(each.elasticity)][:MOST]


def moved(found: Optimum, *, progress: Callable[[int, int], None] | None = None) -> list[Moved]:
    """How the optimum goes with what is `movable`: each limit or bound moved by `FACTORS`, all else as it is.

    Ctrl-C ends it; the rows are then fewer.
    """
    rows: list[Moved] = []
    wanted = movable(found)
    try:
        for each in wanted:
            value, variants = _variants(found.problem, each)
            objectives = []
            for variant in variants:
                objectives.append(_least_from(found, variant))
                if progress:
                    progress(len(rows) * len(FACTORS) + len(objectives), len(wanted) * len(FACTORS))
            rows.append(Moved(each.text, _AT, tuple(f * value for f in FACTORS), tuple(objectives)))
    except KeyboardInterrupt:
        pass
    return rows


def _variants(problem: Problem, holding: Holding) -> tuple[float, list[Problem]]:
    """The value of a limit or bound [SI], and the problem with it moved by each of `FACTORS`."""
    limit = next((k for k, one in enumerate(problem.limits) if str(one) == holding.text), None)
    if limit is not None:
        value = problem.limits[limit].value
        return value, [_with_limit(problem, limit, f * value) for f in FACTORS]
    k, upper = next(
        (k, upper) for k, b in enumerate(problem.bounds) for upper in (True, False) if b.side(upper) == holding.text
    )
    value = problem.bounds[k].high if upper else problem.bounds[k].low
    return value, [_with_side(problem, k, upper, f * value) for f in FACTORS]


def _least_from(found: Optimum, variant: Problem) -> float:
    """The least objective of a `variant` of a solved problem; NaN where there is no design."""
    if any(bound.low > bound.high for bound in variant.bounds):
        return float("nan")
    held = {b.variable.name: found.values[b.variable.name] for b in variant.bounds if b.variable.whole}
    traced = Traced(variant, held)
    start = np.clip(traced.inside(found.values), traced.low, traced.high)
    ends = [local.objective for point in (start, traced.inside(variant.start)) if (local := traced.solved(point))]
    return min(ends, default=float("nan"))


def _with_limit(problem: Problem, number: int, value: float) -> Problem:
    limits = list(problem.limits)
    limits[number] = replace(limits[number], value=value)
    return replace(problem, limits=tuple(limits))


def _with_side(problem: Problem, number: int, upper: bool, value: float) -> Problem:
    bounds = list(problem.bounds)
    bound = bounds[number]
    low, high = (value, value) if bound.fixed else (bound.low, value) if upper else (value, bound.high)
    bounds[number] = replace(bound, low=low, high=high)
    return replace(problem, bounds=tuple(bounds))


# What fights with what


class _Elastic:
    """A problem in which limits and demands may be exceeded, at a price: its least total excess."""

    def __init__(self, problem: Problem, held: Mapping[str, float]) -> None:
        import casadi

        self.traced = traced = Traced(problem, held)
        n, m = len(traced.bounds), traced.count
        with _quiet():
            slack = casadi.SX.sym("s", m)
            nlp = {
                "x": casadi.vertcat(traced.x, slack),
                "f": casadi.sum1(slack) + 1e-9 * casadi.sumsqr(traced.x),
                "g": traced.excesses - slack,
            }
            self.solver = casadi.nlpsol("elastic", "ipopt", nlp, _OPTIONS)
        self.n, self.m = n, m

    def least(self, starts: int = 6, seed: int = 1) -> tuple[float, Array, Array]:
        """The least total excess that was found, where, and the excesses there."""
        traced, rng = self.traced, np.random.default_rng(seed)
        points = [traced.inside({**traced.problem.start, **traced.held})]
        points += [rng.uniform(traced.low, traced.high) for _ in range(starts)]
        best: tuple[float, Array, Array] = (np.inf, points[0], np.full(self.m, np.inf))
        for point in points:
            with _quiet():
                answer = self.solver(
                    x0=np.concatenate([point, np.ones(self.m)]),
                    lbx=np.concatenate([traced.low, np.zeros(self.m)]),
                    ubx=np.concatenate([traced.high, np.full(self.m, np.inf)]),
                    lbg=-np.inf,
                    ubg=0.0,
                )
            whole = _row(answer["x"])
            total = float(np.sum(whole[self.n :]))
            if self.solver.stats()["success"] and total < best[0]:
                best = total, whole[: self.n], whole[self.n :]
            if best[0] <= FEASIBLE:
                break
        return best


def conflict(problem: Problem, held: Mapping[str, float]) -> str:
    """Which limits and bounds cannot be met together, none of which may be left out of the list, with numbers.

    Limits have one side, whole numbers are `held`. Each limit and bound is left out in turn; where the rest is still in
    conflict, it is left out for good (deletion filter).
    """
    excess, _, _ = _Elastic(problem, held).least()
    if excess <= FEASIBLE:
        return "the solver found no optimum, though there are designs that meet all limits; try more --starts"
    sides = [(bound, upper) for bound in problem.bounds for upper in (True, False) if bound.variable.name not in held]
    usual_first = sorted(problem.limits, key=lambda limit: not limit.usual)
    candidates: list[Limit | tuple[Bound, bool]] = [*usual_first, *sides]
    kept = list(candidates)
    for item in candidates:
        rest = [other for other in kept if other is not item]
        if _Elastic(_with_only(problem, rest), held).least(starts=3)[0] > FEASIBLE:
            kept = rest
    lines = ["no design meets all of these together:"]
    for item in kept:
        if isinstance(item, Limit):
            usual = f" (a usual limit; {WITHOUT_USUAL} leaves it out)" if item.usual else ""
            lines.append(f"  {item}{_reach(problem, kept, item, held)}{usual}")
        else:
            bound, upper = item
            given = bound.fixed or (bound.high_given if upper else bound.low_given)
            lines.append(f"  {bound.side(upper)}{'' if given else ' (the usual bound; another may be given)'}")
    for bound in problem.bounds:
        if bound.variable.whole and not bound.fixed:
            name, closest_by = bound.variable.name, held[bound.variable.name]
            lines.append(f"  {name} from {bound.low:g} to {bound.high:g}: numbers are for {closest_by:g}, the closest")
    fighting = replace(problem, limits=tuple(item for item in kept if isinstance(item, Limit)))
    closest = _Elastic(fighting, held)
    values = closest.traced.values(closest.least()[1])
    found = [_plain(q) for q in problem.found(values)]
    valve = valve_of(problem, values)
    for each in closest.traced.geometry:
        if each.excess(valve, found) > -1e-4:
            lines.append(f"  {each.words} (closest: {each.told(valve, found)})")
    return "\n".join(lines)


def _with_only(problem: Problem, kept: Sequence[Limit | tuple[Bound, bool]]) -> Problem:
    limits = tuple(limit for limit in problem.limits if any(limit is item for item in kept))
    sides = {(item[0].variable.name, item[1]) for item in kept if isinstance(item, tuple)}
    bounds = tuple(
        replace(
            b,
            low=b.low if (b.variable.name, False) in sides or b.variable.whole else b.low / WIDER,
            high=b.high if (b.variable.name, True) in sides or b.variable.whole else b.high * WIDER,
        )
        for b in problem.bounds
    )
    return replace(problem, limits=limits, bounds=bounds)


WITHOUT_USUAL = "--no-usual-limits"
"""The option that takes the usual limits away."""


def _reach(problem: Problem, kept: Sequence[Limit | tuple[Bound, bool]], item: Limit, held: Mapping[str, float]) -> str:
    """How far the quantity of a limit gets within everything else that was asked for; where that is in conflict by
    itself, within what fights with the limit."""
    for others in (problem.limits, kept):
        limits = tuple(other for other in others if isinstance(other, Limit) and other is not item)
        reached = _furthest(replace(problem, limits=limits), item, held)
        if reached is not None:
            break
    else:
        return ""
    number = str(replace(item, value=reached)).rpartition("= ")[2]
    return f" (all else allows {number} at {'most' if item.at_least else 'least'})"


def _furthest(problem: Problem, item: Limit, held: Mapping[str, float]) -> float | None:
    """The furthest value of a limit's quantity that the rest of a problem allows."""
    import casadi

    traced = Traced(problem, held)
    with _quiet():
        values = {b.variable.name: casadi.exp(traced.x[i]) for i, b in enumerate(traced.bounds)} | traced.held
        at_points = problem.found(values)
        if item.over_the_points:
            quantity = [problem.mean(at_points, item.quantity)]
        else:
            quantity = [getattr(q, item.quantity) for q in at_points]
        worst = quantity[0]
        for other in quantity[1:]:
            worst = casadi.fmin(worst, other) if item.at_least else casadi.fmax(worst, other)
        scale = item.measure
        nlp = traced._problem((-1.0 if item.at_least else 1.0) * worst / scale)
        solver = casadi.nlpsol("furthest", "ipopt", nlp, _OPTIONS)
    found = []
    rng = np.random.default_rng(2)
    start = traced.inside({**problem.start, **held})
    excess, allowed, _ = _Elastic(problem, held).least()
    if excess > FEASIBLE:
        return None
    for point in [start, allowed, *(rng.uniform(traced.low, traced.high) for _ in range(4))]:
        with _quiet():
            answer = solver(x0=point, lbx=traced.low, ubx=traced.high, lbg=-np.inf, ubg=0.0)
        if solver.stats()["success"]:
            found.append(scale * float(answer["f"]) * (-1.0 if item.at_least else 1.0))
    return (max(found) if item.at_least else min(found)) if found else None


def gradients(problem: Problem, values: Mapping[str, float]) -> dict[str, Array]:
    """Exact derivatives of every quantity at the first point by the logarithms of the free variables."""
    require("casadi", "opt", "a gradient")
    import casadi

    with _quiet():
        x = casadi.SX.sym("x", len(problem.bounds))
        symbols = {b.variable.name: casadi.exp(x[i]) for i, b in enumerate(problem.bounds)}
        found = problem.found(symbols)[0]
        at = np.log([values[b.variable.name] for b in problem.bounds])
        return {
            name: _row(casadi.Function("g", [x], [casadi.gradient(getattr(found, name), x)])(at))
            for name in Quantities._fields
        }
