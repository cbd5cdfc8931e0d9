"""Designs of which none is better in everything: the Pareto front of several quantities.

An evolutionary search (AGE-MOEA) spreads designs over the front, beginning with the optimum of each quantity alone;
then every design is moved onto the front by the gradient solver, the first quantity made as small as the others allow.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from vvdp.base.arrays import Array
from vvdp.base.errors import ConfigError, Fault
from vvdp.base.extras import require
from vvdp.base.tables import nearest
from vvdp.design.optimise import search_optima
from vvdp.design.problem import Limit, Problem
from vvdp.design.proof import Simulated
from vvdp.design.quantities import KINDS, Quantities
from vvdp.design.solver import Traced, geometry_of, valve_of

GENERATIONS = 60
ROOM = 1e-4
"""By what part the other quantities may be worse when a design is moved onto the front: the solver needs some room."""
BAND = 0.02
"""How far evolution may be off a value that is demanded exactly, as a part of it; the solver then moves it there."""
EXACT = 1e-5
"""How far a design of the front may be off such a value."""


@dataclass(frozen=True)
class Objective:
    """A quantity to be small, or large."""

    quantity: str
    large: bool

    @property
    def sign(self) -> float:
        """-1 where large is good."""
        return -1.0 if self.large else 1.0


USUAL = (
    Objective("loss_total", False),
    Objective("load_pulsation", False),
    Objective("spool_volume", False),
    Objective("pwm_frequency", True),
)


@dataclass(frozen=True)
class Front:
    """The front: variables [SI] and quantities (weighted means over the points) of each design, a row each, by the
    first objective; and those of the design as it was. `simulated` is empty where nothing was, and begins with the
    design as it was."""

    problem: Problem
    objectives: tuple[Objective, ...]
    values: tuple[dict[str, float], ...]
    quantities: tuple[dict[str, float], ...]
    before: dict[str, float]
    evaluations: int
    finished: bool
    simulated: tuple[Simulated, ...] = ()

    @property
    def rejects(self) -> tuple[int, ...]:
        """The designs that their simulation does not bear out; none where nothing was simulated."""
        return tuple(place for place, each in enumerate(self.simulated[1:]) if each.doubts)

    @property
    def front_designs(self) -> tuple[int, ...]:
        """The designs that are on the front: confirmed by simulation, or all where nothing was simulated."""
        return tuple(place for place in range(len(self.values)) if place not in self.rejects)

    @property
    def on_a_bound(self) -> tuple[int, ...]:
        """The designs on the front of which some variable lies on a bound."""
        bounds = [bound for bound in self.problem.bounds if not bound.is_fixed]
        return tuple(k for k in self.front_designs if any(b.holds(self.values[k][b.variable.name]) for b in bounds))

    def column(self, quantity: str) -> Array:
        """A quantity along the front [SI]."""
        return np.array([row[quantity] for row in self.quantities])

    @property
    def costs(self) -> Array:
        """Objectives as columns, smaller is better."""
        return np.stack([each.sign * self.column(each.quantity) for each in self.objectives], axis=1)


def objectives(minimise: Sequence[str], maximise: Sequence[str]) -> tuple[Objective, ...]:
    """The objectives that a user names; the usual four without any. Raises ConfigError with all faults."""
    if not minimise and not maximise:
        return USUAL
    faults = [
        Fault(option, 0, name, f"unknown quantity{nearest(name, list(KINDS))}")
        for option, names in (("--minimise", minimise), ("--maximise", maximise))
        for name in names
        if name not in KINDS
    ]
    both = [*minimise, *maximise]
    faults += [
        Fault("--minimise", 0, name, "is named twice") for name in sorted({n for n in both if both.count(n) > 1})
    ]
    if len(both) < 2:
        faults.append(Fault("--minimise", 0, both[0], "a front needs two objectives or more; name another"))
    if faults:
        raise ConfigError(faults)
    return (*(Objective(name, False) for name in minimise), *(Objective(name, True) for name in maximise))


def is_undominated(costs: Array) -> npt.NDArray[np.bool_]:
    """Flags of the rows of `costs` that no other row dominates, that is, is nowhere worse than and somewhere better."""
    no_worse = np.all(costs[:, None, :] <= costs[None, :, :], axis=2)
    better = np.any(costs[:, None, :] < costs[None, :, :], axis=2)
    beaten: npt.NDArray[np.bool_] = np.any(no_worse & better, axis=0)
    return ~beaten


def front(
    asked: Problem,
    wanted: Sequence[Objective] = USUAL,
    *,
    points: int = 60,
    generations: int = GENERATIONS,
    seed: int = 1,
    progress: Callable[[int, int], None] | None = None,
) -> Front:
    """The Pareto front of a problem's system within its bounds and limits; the problem's own objective plays no part.

    Ctrl-C ends the search and keeps the designs so far. Raises InfeasibleError where no design meets the limits.
    """
    require("pymoo", "opt", "a Pareto front")
    require("casadi", "opt", "a Pareto front")
    asked = replace(asked, beside=tuple(each.quantity for each in wanted))
    anchors = [_anchor(asked, each, seed) for each in wanted]
    evolution = Evolution(points, generations, seed)
    spread, evaluations, finished = _spread(asked, wanted, anchors, evolution, progress)
    found = list(anchors)
    try:
        for number, values in enumerate(spread):
            found.append(_move_onto(asked, wanted, values))
            if progress:
                progress(generations + number + 1, generations + len(spread))
    except KeyboardInterrupt:
        found, finished = [*found, *spread[len(found) - len(anchors) :]], False
    found = [values for values in found if _is_exact(asked, values)]
    rows = [_means(asked, asked.evaluate(values)) for values in found]
    costs = np.array([[each.sign * row[each.quantity] for each in wanted] for row in rows])
    kept = np.flatnonzero(is_undominated(costs))
    kept = kept[_apart(costs[kept])]
    order = kept[np.argsort(costs[kept, 0])]
    return Front(
        problem=asked,
        objectives=tuple(wanted),
        values=tuple(found[k] for k in order),
        quantities=tuple(rows[k] for k in order),
        before=_means(asked, asked.evaluate({})),
        evaluations=evaluations,
        finished=finished,
    )


def _apart(costs: Array) -> npt.NDArray[np.bool_]:
    """All rows but those that repeat an earlier one to within a thousandth of the front's extent."""
    size = np.ptp(costs, axis=0)
    close = np.max(np.abs(costs[:, None, :] - costs[None, :, :]) / np.where(size > 0.0, size, 1.0), axis=2) < 1e-3
    found: npt.NDArray[np.bool_] = ~np.any(np.tril(close, -1), axis=1)
    return found


def _means(asked: Problem, found: Sequence[Quantities]) -> dict[str, float]:
    return {name: float(asked.mean(found, name)) for name in KINDS}


def _anchor(asked: Problem, objective: Objective, seed: int) -> dict[str, float]:
    """The optimum of one objective alone; Ctrl-C ends it, as there is no front without all of these."""
    signed = replace(asked, objective=objective.quantity, sign=objective.sign)
    search = search_optima(signed, starts=3, seed=seed, globally=False)
    if not search.finished:
        raise KeyboardInterrupt
    return search.best.traced.values(search.best.x)


@dataclass(frozen=True)
class Evolution:
    """How many designs evolve for how long, from which seed."""

    points: int
    generations: int
    seed: int


def _spread(
    asked: Problem,
    wanted: Sequence[Objective],
    anchors: Sequence[dict[str, float]],
    evolution: Evolution,
    progress: Callable[[int, int], None] | None,
) -> tuple[list[dict[str, float]], int, bool]:
    """Designs spread over the front, as far as evolution has brought them, how many were looked at, and whether it
    came to its end."""
    from pymoo.algorithms.moo.age import AGEMOEA

    points, bounds = evolution.points, asked.bounds
    low, high = _box(asked)
    rng = np.random.default_rng(evolution.seed)
    first = rng.uniform(low, high, (points, len(bounds)))
    known = [*anchors, asked.start]
    for k, design in enumerate(known[:points]):
        first[k] = np.log([design[b.variable.name] for b in bounds])
    algorithm = AGEMOEA(pop_size=points, sampling=first)
    algorithm.setup(
        _evolution_problem(asked, wanted), termination=("n_gen", evolution.generations), seed=evolution.seed
    )
    best, finished, done = None, True, 0
    try:
        while algorithm.has_next():
            algorithm.next()
            done += 1
            best = algorithm.opt
            if progress:
                progress(done, evolution.generations + points)
    except KeyboardInterrupt:
        finished = False
    fine = [] if best is None else [each.X for each in best if each.CV[0] <= 0.0]
    columns = _columns(asked, np.array(fine).reshape(-1, len(bounds)))
    return [{name: float(c[k]) for name, c in columns.items()} for k in range(len(fine))], done * points, finished


def _box(asked: Problem) -> tuple[Array, Array]:
    """Lower and upper ends of the search, logarithms."""
    low, high = (np.log([getattr(b, end) for b in asked.bounds]) for end in ("low", "high"))
    return low, high


def _columns(asked: Problem, x: Array) -> dict[str, Any]:
    """Columns of variables for rows of the search."""
    columns = np.exp(np.clip(x, *_box(asked)))
    return {
        b.variable.name: np.rint(columns[:, k]) if b.variable.whole else columns[:, k]
        for k, b in enumerate(asked.bounds)
    }


def _evolution_problem(asked: Problem, wanted: Sequence[Objective]) -> Any:
    """The problem as pymoo takes it."""
    from pymoo.core.problem import Problem as Evolved

    low, high = _box(asked)
    demands, sided = geometry_of(asked), _with_bands(asked)
    count = sum(1 if each.over_the_points else len(asked.points) for each in sided.limits) + len(demands)

    class Designs(Evolved):  # type: ignore[misc]
        def __init__(self) -> None:
            super().__init__(n_var=len(asked.bounds), n_obj=len(wanted), n_ieq_constr=count, xl=low, xu=high)

        def _evaluate(self, x: Array, out: dict[str, Any], *_: Any, **__: Any) -> None:
            values = _columns(asked, x)
            with np.errstate(all="ignore"):
                found = asked.evaluate(values)
                valve = valve_of(asked, values)
                excess = [excess for each in sided.excesses(found) for excess in each]
                excess += [each.excess(valve, found) for each in demands]
                costs = [each.sign * asked.mean(found, each.quantity) for each in wanted]
            out["F"] = np.stack([np.nan_to_num(np.broadcast_to(c, len(x)), nan=1e12) for c in costs], axis=1)
            out["G"] = np.stack([np.nan_to_num(np.broadcast_to(e, len(x)), nan=1e3) for e in excess], axis=1)

    return Designs()


def _with_bands(asked: Problem) -> Problem:
    """`asked` with a band in place of each limit that is exact, as evolution would never meet it."""
    limits = []
    for limit in asked.limits:
        room = BAND * limit.measure if limit.exactly else 0.0
        limits += [replace(side, value=side.value + (-room if side.at_least else room)) for side in limit.sides]
    return replace(asked, limits=tuple(limits))


def _is_exact(asked: Problem, values: dict[str, float]) -> bool:
    """Whether a design meets the limits that are exact."""
    pairs = zip(asked.limits, asked.excesses(asked.evaluate(values)), strict=True)
    return all(abs(excess) <= EXACT for limit, excesses in pairs if limit.exactly for excess in excesses)


def _move_onto(asked: Problem, wanted: Sequence[Objective], values: dict[str, float]) -> dict[str, float]:
    """The design at which the first objective is least while no other gets worse; `values` where that fails."""
    at = _means(asked, asked.evaluate(values))
    ceilings = []
    for each in wanted[1:]:
        worst = at[each.quantity] + each.sign * ROOM * abs(at[each.quantity])
        ceilings.append(Limit(each.quantity, at_least=each.large, value=worst, over_the_points=True))
    bounds_held = {b.variable.name: values[b.variable.name] for b in asked.bounds if b.variable.whole}
    question = replace(asked, objective=wanted[0].quantity, sign=wanted[0].sign, limits=(*asked.limits, *ceilings))
    traced = Traced(question, bounds_held)
    local = traced.solve(np.clip(traced.inside(values), traced.low, traced.high))
    if local is None:
        return values
    moved = traced.values(local.x)
    new = _means(asked, asked.evaluate(moved))
    gained = wanted[0].sign * (new[wanted[0].quantity] - at[wanted[0].quantity]) <= 0.0
    return moved if gained or not _is_exact(asked, values) else values
