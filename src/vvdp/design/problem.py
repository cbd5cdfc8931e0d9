"""The task of an optimisation: what to minimise, subject to what, within which bounds, at which points."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.display import value_text, with_unit
from vvdp.base.errors import ConfigError, Fault, ParameterError, unusable
from vvdp.base.kinds import FLOW, PRESSURE_LEVEL
from vvdp.base.tables import nearest, read_table, refuse_unknown, with_settings
from vvdp.base.units import parse
from vvdp.design.quantities import KINDS, LABELS, Quantities, Setup, quantities, setup
from vvdp.design.variables import VARIABLES, Variable, value_in, with_variables
from vvdp.evaluation.bench import rotary_bench
from vvdp.fluid.oil import Oil
from vvdp.systems.system import System
from vvdp.valve.rotary import RotaryValve

_STATEMENT = re.compile(r"\s*(\w+)\s*(>=|<=|=|≥|≤)\s*(.+?)\s*\Z")
_SIGNS = {"≥": ">=", "≤": "<="}


@dataclass(frozen=True)
class Limit:
    """A quantity that must be at least, at most, or `exactly` a value [SI], at every operating point, or on average.

    `usual` where it was not asked for.
    """

    quantity: str
    at_least: bool
    value: float
    over_the_points: bool = False
    usual: bool = False
    exactly: bool = False

    def __str__(self) -> str:
        """As a user types it."""
        return self._statement(self.quantity, (">=", "<="), value_text(self.value, KINDS[self.quantity]))

    @property
    def words(self) -> str:
        """As people read it."""
        amount = with_unit(self.value, KINDS[self.quantity], 6)
        return self._statement(LABELS[self.quantity], "≥≤", amount)

    @property
    def words_with_origin(self) -> str:
        """The same, and whether it is a usual one."""
        return self.words + (" (usual limit)" if self.usual else "")

    def _statement(self, name: str, signs: Sequence[str], amount: str) -> str:
        mean = " on average" if self.over_the_points else ""
        sign = "=" if self.exactly else signs[0] if self.at_least else signs[1]
        return f"{name} {sign} {amount}{mean}"

    @property
    def measure(self) -> float:
        """Scale of an excess over the limit [SI]."""
        return abs(self.value) or SMALLEST[self.quantity]

    def excess(self, found: Any) -> Any:
        """How far `evaluate` violates the limit, as a part of it; negative within, or below where it is exact."""
        share = (found - self.value) / self.measure
        return -share if self.at_least else share

    @property
    def sides(self) -> "tuple[Limit, ...]":
        """The limit, or where it is exact both sides of it."""
        if not self.exactly:
            return (self,)
        return tuple(replace(self, at_least=at_least, exactly=False) for at_least in (True, False))


SMALLEST = {name: kind.scale for name, kind in KINDS.items()}
"""Scale of the excess over a limit of zero, by quantity."""


@dataclass(frozen=True)
class Bound:
    """Between which values [SI] a variable may lie, and which of the two was asked for."""

    variable: Variable
    low: float
    high: float
    low_given: bool = False
    high_given: bool = False

    @property
    def is_fixed(self) -> bool:
        """Whether there is nothing to choose."""
        return self.low == self.high

    @property
    def sides(self) -> "tuple[Side, Side]":
        """Upper and lower side."""
        return Side(self, True), Side(self, False)

    def holds(self, value: float) -> bool:
        """Whether a value [SI] lies on one of its sides."""
        return any(abs(value - end) <= ON_BOUND * abs(end) for end in (self.low, self.high))


ON_BOUND = 2e-3
"""How close to a bound a variable lies on it, as a part of it."""


class Side(NamedTuple):
    """One side of a bound."""

    bound: Bound
    upper: bool

    def __str__(self) -> str:
        """As a user types it."""
        sign = "=" if self.bound.is_fixed else "<=" if self.upper else ">="
        return f"{self.bound.variable.name} {sign} {value_text(self.value, self.bound.variable.kind)}"

    @property
    def words(self) -> str:
        """As people read it."""
        sign = "=" if self.bound.is_fixed else "≤" if self.upper else "≥"
        return f"{self.bound.variable.label} {sign} {with_unit(self.value, self.bound.variable.kind, 6)}"

    @property
    def value(self) -> float:
        """Where it is [SI]."""
        return self.bound.high if self.upper else self.bound.low

    @property
    def is_given(self) -> bool:
        """Whether it was asked for."""
        return self.bound.is_fixed or (self.bound.high_given if self.upper else self.bound.low_given)


@dataclass(frozen=True)
class Point:
    """An operating point with its weight, and the system as it stands there."""

    weight: float
    system: System
    setup: Setup


@lru_cache(maxsize=100)
def _traced_quantities(at: Setup, names: tuple[str, ...]) -> Any:
    """The quantities as a CasADi function of the variables `names`, traced once for all questions."""
    import casadi

    x = casadi.SX.sym("x", len(names))
    found = quantities(with_variables(at, {name: x[i] for i, name in enumerate(names)}))
    return casadi.Function("quantities", [x], [casadi.vertcat(*found)])


def _symbolic_quantities(at: Setup, values: Mapping[str, Any]) -> Quantities:
    """The quantities with the variables at `values`, CasADi symbols and numbers together."""
    if not isinstance(at.valve, RotaryValve) or not isinstance(at.oil, Oil):  # a loose copy, which may have symbols
        return quantities(with_variables(at, values))
    import casadi

    row = casadi.vertsplit(_traced_quantities(at, tuple(values))(casadi.vertcat(*values.values())))
    return Quantities(**dict(zip(Quantities._fields, row, strict=True)))


@dataclass(frozen=True)
class Problem:
    """Problem of optimisation: the objective that is minimised (its weighted mean over the points, negative with sign
    -1), limits, bounds, and points. `beside` are quantities that are shown beside the objective."""

    system: System
    objective: str
    limits: tuple[Limit, ...]
    bounds: tuple[Bound, ...]
    points: tuple[Point, ...]
    sign: float = 1.0
    beside: tuple[str, ...] = ()

    @property
    def quantities(self) -> frozenset[str]:
        """All quantities that the question names."""
        return frozenset((self.objective, *self.beside, *(limit.quantity for limit in self.limits)))

    @property
    def start(self) -> dict[str, float]:
        """The variables as they are in the system, moved into the bounds."""
        at = self.points[0].setup
        return {b.variable.name: float(np.clip(value_in(at, b.variable.name), b.low, b.high)) for b in self.bounds}

    @property
    def one_sided(self) -> "Problem":
        """The same with two sides for each limit that is exact."""
        return replace(self, limits=tuple(side for limit in self.limits for side in limit.sides))

    def evaluate(self, values: Mapping[str, object]) -> list[Quantities]:
        """The quantities at every point with the variables at `values` [SI]."""
        return [quantities(with_variables(point.setup, values)) for point in self.points]

    def evaluate_symbols(self, values: Mapping[str, Any]) -> list[Quantities]:
        """The same for CasADi symbols and numbers together."""
        return [_symbolic_quantities(point.setup, values) for point in self.points]

    def excesses(self, found: Sequence[Quantities]) -> list[list[Any]]:
        """How far each limit is exceeded, at every point or in the mean over them."""
        return [
            [limit.excess(self.mean(found, limit.quantity))]
            if limit.over_the_points
            else [limit.excess(getattr(q, limit.quantity)) for q in found]
            for limit in self.limits
        ]

    def mean(self, found: Sequence[Quantities], name: str) -> Any:
        """The weighted mean of a quantity over the points."""
        total = sum(point.weight for point in self.points)
        return sum(p.weight / total * getattr(q, name) for p, q in zip(self.points, found, strict=True))


def problem(
    system: System,
    minimise: str,
    subject_to: Iterable[str] = (),
    bounds: Iterable[str] = (),
    cycle: Path | None = None,
    *,
    beside: Iterable[str] = (),
) -> Problem:
    """The problem that a user has put into words; see docs/design.md. Raises ConfigError with all that is wrong."""
    faults: list[Fault] = []
    if minimise not in KINDS:
        faults.append(Fault("--minimise", 0, minimise, f"unknown quantity{nearest(minimise, list(KINDS))}"))
    limits = [limit for text in subject_to for limit in _limits(text, faults)]
    at = setup(system)
    found = _bounds(bounds, at, faults)
    points = (Point(1.0, system, at),) if cycle is None else _points(cycle, system, faults)
    _check_variables(system, found, faults)
    if not faults:
        faults += [fault for point in points for fault in _unusable_points(point)]
    asked = Problem(
        system=system,
        objective=minimise,
        limits=tuple(limits),
        bounds=found,
        points=points,
        beside=tuple(beside),
    )
    if not faults and asked.quantities & TRANSITIONAL:
        faults += [fault for point in points for fault in (*_never_switching(point), *_soft_switching_faults(point))]
    if faults:
        raise ConfigError(faults)
    return asked


TRANSITIONAL = frozenset(("loss_transition", "loss_total", "efficiency", "load_flow", "relief_margin", "input_power"))
"""Quantities that contain the closed form of the transition loss, which needs the relief valve closed while a port is
open."""
RIPPLE = frozenset(("pwm_frequency", "load_pulsation"))
"""Quantities that limit the ripple behind the load port."""


MOST_TRANSITION = 0.5
"""Of a PWM period: a transition that takes longer leaves no duty ratio at which both ports open fully."""


def with_usual_limits(asked: Problem, *, front: bool = False) -> Problem:
    """`asked` with what is usually demanded of a valve added, each where the question limits nothing of that sort.

    The PWM frequency is at least that of the system as it is: a slower valve loses less in closed form, which takes the
    load pressure as steady, but its ripple grows. Of a `front`, a transition takes at most half a PWM period, or what
    it took before, the relief valve stays closed while a port is open, and the pump needs no more than the power of its
    motor, or what it needed before. Names in the objectives of a front do not bound them.
    """
    before, mean = asked.evaluate({}), len(asked.points) > 1
    named = frozenset(limit.quantity for limit in asked.limits) if front else asked.quantities
    more = []
    frequency = float(asked.mean(before, "pwm_frequency"))
    if not named & RIPPLE and frequency > 0.0:
        more.append(Limit("pwm_frequency", at_least=True, value=frequency, over_the_points=mean, usual=True))
    if front and "transition_fraction" not in named:
        now = max(float(q.transition_fraction) for q in before)
        most = max(MOST_TRANSITION, now)
        more.append(Limit("transition_fraction", at_least=False, value=most, usual=True))
    if front and "relief_margin" not in named:
        more.append(Limit("relief_margin", at_least=True, value=0.0, usual=True))
    if front and "input_power" not in named:
        rated = rotary_bench(asked.system, "design").rated_power
        now = max(float(q.input_power) for q in before)
        more.append(Limit("input_power", at_least=False, value=max(rated, now), usual=True))
    return replace(asked, limits=(*asked.limits, *more))


def _never_switching(point: Point) -> list[Fault]:
    d = point.setup.duty_ratio
    if 0.0 < d < 1.0:
        return []
    message = (
        f"{d:g}: the valve never switches, and the analytic transition loss does not hold; minimise for "
        "example pressure_drop_total, or take a value between 0 and 1"
    )
    return [Fault(point.system.name, 0, "operation.duty_ratio", message)]


def _soft_switching_faults(point: Point) -> list[Fault]:
    if not rotary_bench(point.system, "design").is_softened:
        return []
    message = "a valve that is switched softly has no transition loss in closed form; minimise pressure_drop_total"
    return [Fault(point.system.name, 0, "bypass", message)]


def require_flow(system: System) -> None:
    """Raises ConfigError where the pump delivers nothing, or the load is not above the tank."""
    if faults := _unusable_points(Point(1.0, system, setup(system))):
        raise ConfigError(faults)


def _check_variables(system: System, bounds: Sequence[Bound], faults: list[Fault]) -> None:
    names = {bound.variable.name for bound in bounds}
    if "helix_length" in names and rotary_bench(system, "design").is_placed:
        message = "would change the duty ratio: give operation.duty_ratio instead of operation.axial_position"
        faults.append(Fault("--bound", 0, "helix_length", message))


def _unusable_points(point: Point) -> list[Fault]:
    at, place = point.setup, point.system.name
    if not at.flow > 0.0:
        message = f"no equilibrium speed: the pump delivers {with_unit(at.flow, FLOW)}"
        return [Fault(place, 0, "operation.pump_speed", message)]
    if not at.load_pressure > at.tank_pressure:
        load, tank = (with_unit(p, PRESSURE_LEVEL) for p in (at.load_pressure, at.tank_pressure))
        return [Fault(place, 0, "load", f"the load at {load} must be greater than the tank at {tank}")]
    return []


def _statement(option: str, text: str, faults: list[Fault]) -> tuple[str, str, str] | None:
    match = _STATEMENT.match(text)
    if not match:
        faults.append(
            Fault(option, 0, text, 'expected a name, a sign and a value, for example "pwm_frequency >= 72 Hz"')
        )
        return None
    return match[1], _SIGNS.get(match[2], match[2]), match[3]


def _limits(text: str, faults: list[Fault]) -> list[Limit]:
    option = "--subject-to"
    told = _statement(option, text, faults)
    if told is None:
        return []
    name, sign, number = told
    if name not in KINDS:
        other = "; it is a variable, use --bound" if name in VARIABLES else nearest(name, list(KINDS))
        faults.append(Fault(option, 0, name, f"unknown quantity{other}"))
        return []
    try:
        value = parse(number, KINDS[name])
    except ParameterError as problem:
        faults.append(Fault(option, 0, name, str(problem)))
        return []
    return [Limit(name, sign == ">=", value, exactly=sign == "=")]


def _bounds(texts: Iterable[str], at: Setup, faults: list[Fault]) -> tuple[Bound, ...]:
    given: dict[str, dict[str, float]] = {}
    for text in texts:
        _read_bound(text, at, given, faults)
    wanted = [each for name, each in VARIABLES.items() if each.usual or name in given]
    bounds = [_bound(each, given.get(each.name, {}), value_in(at, each.name), faults) for each in wanted]
    return tuple(bound for bound in bounds if bound is not None)


def _read_bound(text: str, at: Setup, given: dict[str, dict[str, float]], faults: list[Fault]) -> None:
    """Adds the ends that one statement gives to those of its variable."""
    told = _statement(BOUND, text, faults)
    if told is None:
        return
    name, sign, number = told
    message = _why_not(name, number, at)
    if not message:
        try:
            value = parse(number, VARIABLES[name].kind)
        except ParameterError as problem:
            message = str(problem)
    if message:
        faults.append(Fault(BOUND, 0, name, message))
        return
    for end, own in (("low", ">="), ("high", "<=")):
        if sign in ("=", own):
            given.setdefault(name, {})[end] = value


BOUND = "--bound"


def _why_not(name: str, number: str, at: Setup) -> str:
    """The objection to a bound of a variable; empty where there is none."""
    if name not in VARIABLES:
        other = "; it is a result, use --subject-to" if name in KINDS else nearest(name, list(VARIABLES))
        return f"unknown variable{other}"
    if name == "lap_ratio" and number.startswith("-"):
        return f"{number}: a negative lap beyond the barrier, which would be {number} nozzle widths wide"
    if name == "spool_motor_speed" and not at.coupling > 0.0:
        return "has no effect: the spool spins by itself; give spool_drive.coupling a value above 0 N*m*s"
    return ""


def _bound(variable: Variable, sides: Mapping[str, float], now: float, faults: list[Fault]) -> Bound | None:
    """The bounds of a variable that is `now` [SI], from those that were given and the usual ones; None with a fault."""
    name, kind = variable.name, variable.kind
    usual_low, usual_high = (
        float(np.clip(factor * now, kind.low, kind.high)) for factor in (variable.lowest, variable.highest)
    )
    low = sides.get("low", min(usual_low, sides.get("high", np.inf)))
    high = sides.get("high", max(usual_high, sides.get("low", 0.0)))
    message = ""
    if variable.whole:
        low, high = np.ceil(low - 1e-9), np.floor(high + 1e-9)
        if not low <= high:
            between = " to ".join(f"{value:g}" for value in dict.fromkeys(sides.values()))
            message = f"{between}; expected whole numbers, and there is none between"
    ends = " to ".join(value_text(float(end), kind) for end in (low, high))
    if not message and not low > 0.0:
        message = f"{ends}: both ends must be greater than 0"
    elif not message and not low <= high:
        message = f"{ends} leaves nothing between"
    if message:
        faults.append(Fault(BOUND, 0, name, message))
        return None
    return Bound(variable, float(low), float(high), low_given="low" in sides, high_given="high" in sides)


def _points(path: Path, system: System, faults: list[Fault]) -> tuple[Point, ...]:
    """The operating points of a file."""
    found = []
    for weight, settings in cycle_points(path, system, faults):
        there = system.read_from(with_settings(system.table, [f"{key}={value}" for key, value in settings.items()]))
        found.append(Point(weight, there, setup(there)))
    return tuple(found)


def cycle_points(path: Path, system: System, faults: list[Fault]) -> list[tuple[float, dict[str, Any]]]:
    """The operating points of a file: `[[points]]`, each a weight and the values that the system has there."""
    table = read_table(path)
    rows = table.content.get("points")
    if not isinstance(rows, list) or not rows or not all(isinstance(row, Mapping) for row in rows):
        raise unusable(path, 'has no operating points; expected tables [[points]] with weight and "table.key" = value')
    refuse_unknown(table.content, ("points",), "", table, faults)
    found = []
    for number, row in enumerate(rows, 1):
        place, settings, weight = f"{path}: point {number}", dict[str, Any](), row.get("weight", 1.0)
        if isinstance(weight, bool) or not isinstance(weight, int | float) or not 0.0 < weight < np.inf:
            faults.append(Fault(place, 0, "weight", f"{weight!r} must be a number greater than 0"))
            continue
        for key, value in _dotted_key(row).items():
            if key.startswith("valve.") or "." not in key:
                faults.append(
                    Fault(place, 0, key, "is no setting of an operating point; a point has one valve with the others")
                )
            else:
                settings[key] = value
        try:
            system.read_from(with_settings(system.table, [f"{key}={value}" for key, value in settings.items()]))
        except ConfigError as problem:
            faults += [Fault(place, 0, fault.key, fault.message) for fault in problem.faults]
            continue
        found.append((float(weight), settings))
    return found


def _dotted_key(row: Mapping[str, object]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, value in row.items():
        if isinstance(value, Mapping):
            found |= {f"{key}.{inner}": content for inner, content in value.items()}
        elif key != "weight":
            found[key] = value
    return found
