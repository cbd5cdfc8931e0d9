"""Why no design meets all that is asked for: an irreducible infeasible set, with the best attainable value of each.

None of the limits and bounds of such a set may be left out: without any one of them there is a design.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import reduce
from typing import Any, TypeAlias

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import value_text
from vvdp.base.errors import VvdpError
from vvdp.design.problem import Limit, Problem, Side
from vvdp.design.quantities import KINDS
from vvdp.design.solver import FEASIBLE, OPTIONS, Traced, plain_quantities, quiet_casadi, row_of, valve_of

WIDER = 100.0
"""Factor by which a bound is widened to see whether it is in the way."""
WITHOUT_USUAL = "--no-usual-limits"
"""The option that takes the usual limits away."""


class InfeasibleError(VvdpError):
    """No design meets all that is asked for; the message says what is in each other's way."""


class Elastic:
    """A problem in which limits and demands may be exceeded, at a price: its least total excess."""

    def __init__(self, problem: Problem, held: Mapping[str, float]) -> None:
        import casadi

        self.traced = traced = Traced(problem, held)
        n, m = len(traced.bounds), traced.count
        with quiet_casadi():
            slack = casadi.SX.sym("s", m)
            nlp = {
                "x": casadi.vertcat(traced.x, slack),
                "f": casadi.sum1(slack) + 1e-9 * casadi.sumsqr(traced.x),
                "g": traced.excesses - slack,
            }
            self.solver = casadi.nlpsol("elastic", "ipopt", nlp, OPTIONS)
        self.n, self.m = n, m

    def least(self, starts: int = 6, seed: int = 1) -> tuple[float, Array, Array]:
        """The least total excess that was found, where, and the excesses there."""
        traced, rng = self.traced, np.random.default_rng(seed)
        points = [traced.inside({**traced.problem.start, **traced.held})]
        points += [rng.uniform(traced.low, traced.high) for _ in range(starts)]
        best: tuple[float, Array, Array] = (np.inf, points[0], np.full(self.m, np.inf))
        for point in points:
            with quiet_casadi():
                answer = self.solver(
                    x0=np.concatenate([point, np.ones(self.m)]),
                    lbx=np.concatenate([traced.low, np.zeros(self.m)]),
                    ubx=np.concatenate([traced.high, np.full(self.m, np.inf)]),
                    lbg=-np.inf,
                    ubg=0.0,
                )
            whole = row_of(answer["x"])
            total = float(np.sum(whole[self.n :]))
            if self.solver.stats()["success"] and total < best[0]:
                best = total, whole[: self.n], whole[self.n :]
            if best[0] <= FEASIBLE:
                break
        return best


Item: TypeAlias = Limit | Side
"""Constraint that can be left out of a problem."""


def infeasibility(problem: Problem, held: Mapping[str, float]) -> str:
    """An irreducible infeasible set of limits and bounds in words, with the best attainable value of each limit.

    Limits have one side, whole numbers are `held`.
    """
    if Elastic(problem, held).least()[0] <= FEASIBLE:
        return "the solver found no optimum, though there are designs that meet all limits; try more --starts"
    kept = _irreducible_set(problem, held)
    lines = ["no design meets all of these together:"]
    lines += [f"  {_item_words(problem, kept, item, held)}" for item in kept]
    for bound in problem.bounds:
        if bound.variable.whole and not bound.is_fixed:
            name, closest = bound.variable.name, held[bound.variable.name]
            lines.append(f"  {name} from {bound.low:g} to {bound.high:g}: numbers are for {closest:g}, the closest")
    return "\n".join([*lines, *_constraints_in_the_way(problem, kept, held)])


def _irreducible_set(problem: Problem, held: Mapping[str, float]) -> list[Item]:
    """The deletion filter: each limit and bound is left out in turn, for good where the rest is infeasible still."""
    free = [bound for bound in problem.bounds if bound.variable.name not in held]
    usual_first = sorted(problem.limits, key=lambda limit: not limit.usual)
    candidates: list[Item] = [*usual_first, *(side for bound in free for side in bound.sides)]
    kept = list(candidates)
    for item in candidates:
        rest = [other for other in kept if other is not item]
        if Elastic(_with_only(problem, rest), held).least(starts=3)[0] > FEASIBLE:
            kept = rest
    return kept


def _item_words(problem: Problem, kept: Sequence[Item], item: Item, held: Mapping[str, float]) -> str:
    """One of an irreducible infeasible set as it would be typed, with what can be said of it."""
    if isinstance(item, Side):
        return f"{item}{'' if item.is_given else ' (the usual bound; another may be given)'}"
    usual = f" (a usual limit; {WITHOUT_USUAL} leaves it out)" if item.usual else ""
    return f"{item}{_attainable(problem, kept, item, held)}{usual}"


def _constraints_in_the_way(problem: Problem, kept: Sequence[Item], held: Mapping[str, float]) -> list[str]:
    """Lines on the constraints of every valve that are reached where the limits are exceeded least."""
    limits = tuple(item for item in kept if isinstance(item, Limit))
    closest = Elastic(replace(problem, limits=limits), held)
    values = closest.traced.values(closest.least()[1])
    found = [plain_quantities(q) for q in problem.evaluate(values)]
    valve = valve_of(problem, values)
    return [
        f"  {each.words} (closest: {each.numbers(valve, found)})"
        for each in closest.traced.geometry
        if each.excess(valve, found) > -1e-4
    ]


def _with_only(problem: Problem, kept: Sequence[Item]) -> Problem:
    """The problem with these limits and bounds only; other bounds are moved far out."""
    limits = tuple(limit for limit in problem.limits if any(limit is item for item in kept))
    sides = {(item.bound.variable.name, item.upper) for item in kept if isinstance(item, Side)}
    bounds = tuple(
        replace(
            b,
            low=b.low if (b.variable.name, False) in sides or b.variable.whole else b.low / WIDER,
            high=b.high if (b.variable.name, True) in sides or b.variable.whole else b.high * WIDER,
        )
        for b in problem.bounds
    )
    return replace(problem, limits=limits, bounds=bounds)


def _attainable(problem: Problem, kept: Sequence[Item], item: Limit, held: Mapping[str, float]) -> str:
    """How far the quantity of a limit gets within everything else that was asked for; where that is infeasible by
    itself, within the rest of the infeasible set."""
    for others in (problem.limits, kept):
        limits = tuple(other for other in others if isinstance(other, Limit) and other is not item)
        reached = _furthest(replace(problem, limits=limits), item, held)
        if reached is not None:
            mean = " on average" if item.over_the_points else ""
            amount = value_text(reached, KINDS[item.quantity]) + mean
            return f" (all else allows {amount} at {'most' if item.at_least else 'least'})"
    return ""


def _furthest(problem: Problem, item: Limit, held: Mapping[str, float]) -> float | None:
    """The furthest value of a limit's quantity that the rest allows [SI]; None where there is no design."""
    import casadi

    traced, sign = Traced(problem, held), -1.0 if item.at_least else 1.0
    excess, allowed, _ = Elastic(problem, held).least()
    if excess > FEASIBLE:
        return None
    with quiet_casadi():
        nlp = traced.nlp(sign * _worst(problem, item, traced) / item.measure)
        solver = casadi.nlpsol("furthest", "ipopt", nlp, OPTIONS)
    found = []
    rng = np.random.default_rng(2)
    start = traced.inside({**problem.start, **held})
    for point in [start, allowed, *(rng.uniform(traced.low, traced.high) for _ in range(4))]:
        with quiet_casadi():
            answer = solver(x0=point, lbx=traced.low, ubx=traced.high, lbg=-np.inf, ubg=0.0)
        if solver.stats()["success"]:
            found.append(item.measure * float(answer["f"]))
    return sign * min(found) if found else None


def _worst(problem: Problem, item: Limit, traced: Traced) -> Any:
    """A limit's quantity at the point where it is met worst, or its mean, as a symbol."""
    import casadi

    values = {b.variable.name: casadi.exp(traced.x[i]) for i, b in enumerate(traced.bounds)} | traced.held
    at_points = problem.evaluate_symbols(values)
    if item.over_the_points:
        return problem.mean(at_points, item.quantity)
    return reduce(casadi.fmin if item.at_least else casadi.fmax, [getattr(q, item.quantity) for q in at_points])
