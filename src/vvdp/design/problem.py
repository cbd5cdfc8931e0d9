"""What an optimisation is asked for: what to minimise, subject to what, within which bounds, at which points."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from vvdp.base.errors import ConfigError, Fault, ParameterError, unusable
from vvdp.base.kinds import PRESSURE_LEVEL, Kind
from vvdp.base.tables import nearest, read_table, with_settings
from vvdp.base.units import ATMOSPHERE, in_unit, parsed
from vvdp.design.quantities import KINDS, Quantities, Setup, quantities, setup
from vvdp.design.variables import VARIABLES, Variable, changed, value_in
from vvdp.systems.bench import rotary_bench
from vvdp.systems.system import System

_STATEMENT = re.compile(r"\s*(\w+)\s*(>=|<=|=|≥|≤)\s*(.+?)\s*\Z")
_SIGNS = {"≥": ">=", "≤": "<="}


def shown(value: float, kind: Kind, digits: int = 6) -> str:
    """A value [SI] with its unit, as people write it; a pressure level gauge."""
    if kind is PRESSURE_LEVEL:
        return f"{(value - ATMOSPHERE) / 1e5:.{digits}g} bar"
    if kind.unit in ("1", "SI"):
        return f"{value:.{digits}g}{' SI' if kind.unit == 'SI' else ''}"
    return f"{in_unit(value, kind, kind.shown):.{digits}g} {kind.shown}"


@dataclass(frozen=True)
class Limit:
    """A quantity that must be at least, at most, or `exactly` a value [SI], at every operating point, or on average.

    `usual` where nobody asked for it.
    """

    quantity: str
    at_least: bool
    value: float
    over_the_points: bool = False
    usual: bool = False
    exactly: bool = False

    def __str__(self) -> str:
        mean = " on average" if self.over_the_points else ""
        sign = "=" if self.exactly else ">=" if self.at_least else "<="
        return f"{self.quantity} {sign} {shown(self.value, KINDS[self.quantity])}{mean}"

    @property
    def measure(self) -> float:
        """What an excess is a part of [SI]."""
        return abs(self.value) or SMALLEST[self.quantity]

    def excess(self, found: Any) -> Any:
        """How far `found` violates the limit, as a part of it; negative within, or below where it is exact."""
        share = (found - self.value) / self.measure
        return -share if self.at_least else share

    @property
    def sides(self) -> "tuple[Limit, ...]":
        """The limit, or where it is exact both sides of it."""
        if not self.exactly:
            return (self,)
        return tuple(replace(self, at_least=at_least, exactly=False) for at_least in (True, False))


SMALLEST = {name: kind.scale for name, kind in KINDS.items()}
"""What a limit of zero is measured with."""


@dataclass(frozen=True)
class Bound:
    """Between which values [SI] a variable may lie, and which of the two somebody asked for."""

    variable: Variable
    low: float
    high: float
    low_given: bool = False
    high_given: bool = False

    def side(self, upper: bool) -> str:
        """One of its sides in words."""
        value = self.high if upper else self.low
        sign = "=" if self.fixed else "<=" if upper else ">="
        return f"{self.variable.name} {sign} {shown(value, self.variable.kind)}"

    @property
    def fixed(self) -> bool:
        """Whether there is nothing to choose."""
        return self.low == self.high


@dataclass(frozen=True)
class Point:
    """An operating point with its weight, and the system as it stands there."""

    weight: float
    system: System
    setup: Setup


@dataclass(frozen=True)
class Problem:
    """What is minimised (the weighted mean over the points; its negative with sign -1), subject to which limits,
    within which bounds, at which points. `beside` are quantities that are looked at beside the objective."""

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

    def found(self, values: Mapping[str, Any]) -> list[Quantities]:
        """The quantities at every point with the variables at `values` [SI]."""
        return [quantities(changed(point.setup, values)) for point in self.points]

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
    """The problem that a person has put into words; see docs/design.md. Raises ConfigError with all that is wrong."""
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
    asked = Problem(system, minimise, tuple(limits), found, points, beside=tuple(beside))
    if not faults and asked.quantities & TRANSITIONAL:
        faults += [fault for point in points for fault in _never_switching(point)]
    if faults:
        raise ConfigError(faults)
    return asked


TRANSITIONAL = frozenset(("loss_transition", "loss_total", "efficiency", "load_flow", "relief_margin", "input_power"))
"""What the closed form of the transition loss enters, which needs the relief valve shut while a port is open."""
RIPPLE = frozenset(("pwm_frequency", "load_pulsation"))
"""What tells of the ripple behind the load port."""


def with_usual_limits(asked: Problem, *, front: bool = False) -> Problem:
    """`asked` with what is usually demanded of a valve added, each where the question names nothing of that sort.

    The PWM frequency is at least that of the system as it is: a slower valve loses less in closed form, which takes the
    load pressure as steady, but its ripple grows. Of a `front`, the relief valve stays shut while a port is open, and
    the pump needs no more than the power of its motor, or what it needed before.
    """
    before, mean, named = asked.found({}), len(asked.points) > 1, asked.quantities
    more = []
    frequency = float(asked.mean(before, "pwm_frequency"))
    if not named & RIPPLE and frequency > 0.0:
        more.append(Limit("pwm_frequency", True, frequency, mean, usual=True))
    if front and "relief_margin" not in named:
        more.append(Limit("relief_margin", True, 0.0, usual=True))
    if front and "input_power" not in named:
        rated = rotary_bench(asked.system, "design").motor.rated_power
        now = max(float(q.input_power) for q in before)
        more.append(Limit("input_power", False, max(rated, now), usual=True))
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
        return [Fault(place, 0, "operation.pump_speed", f"no equilibrium speed: the pump delivers {at.flow:g} m^3/s")]
    if not at.load_pressure > at.tank_pressure:
        load, tank = (shown(p, PRESSURE_LEVEL) for p in (at.load_pressure, at.tank_pressure))
        return [Fault(place, 0, "load", f"the load at {load} is not above the tank at {tank}")]
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
        value = parsed(number, KINDS[name])
    except ParameterError as problem:
        faults.append(Fault(option, 0, name, str(problem)))
        return []
    return [Limit(name, sign == ">=", value, exactly=sign == "=")]


def _bounds(texts: Iterable[str], at: Setup, faults: list[Fault]) -> tuple[Bound, ...]:
    option = "--bound"
    given: dict[str, dict[str, float]] = {}
    for text in texts:
        told = _statement(option, text, faults)
        if told is None:
            continue
        name, sign, number = told
        if name not in VARIABLES:
            other = "; it is a result, use --subject-to" if name in KINDS else nearest(name, list(VARIABLES))
            faults.append(Fault(option, 0, name, f"unknown variable{other}"))
            continue
        if name == "lap_ratio" and number.startswith("-"):
            message = f"{number}: a negative lap beyond the barrier, which would be {number} nozzle widths wide"
            faults.append(Fault(option, 0, name, message))
            continue
        if name == "spool_motor_speed" and not at.coupling > 0.0:
            message = "has no effect: the spool spins by itself; give spool_drive.coupling a value above 0 N*m*s"
            faults.append(Fault(option, 0, name, message))
            continue
        try:
            value = parsed(number, VARIABLES[name].kind)
        except ParameterError as problem:
            faults.append(Fault(option, 0, name, str(problem)))
            continue
        for end in ("low", "high"):
            if sign == "=" or sign == {"low": ">=", "high": "<="}[end]:
                given.setdefault(name, {})[end] = value
    found = []
    for name, variable in VARIABLES.items():
        if not variable.usual and name not in given:
            continue
        sides, now = given.get(name, {}), value_in(at, name)
        usual_low, usual_high = (
            float(np.clip(factor * now, variable.kind.low, variable.kind.high))
            for factor in (variable.lowest, variable.highest)
        )
        low = sides.get("low", min(usual_low, sides.get("high", np.inf)))
        high = sides.get("high", max(usual_high, sides.get("low", 0.0)))
        if variable.whole:
            low, high = np.ceil(low - 1e-9), np.floor(high + 1e-9)
            if not low <= high:
                asked_for = " to ".join(f"{value:g}" for value in dict.fromkeys(sides.values()))
                message = f"{asked_for}; expected whole numbers, and there is none between"
                faults.append(Fault(option, 0, name, message))
                continue
        ends = f"{shown(low, variable.kind)} to {shown(high, variable.kind)}"
        if not low > 0.0:
            faults.append(Fault(option, 0, name, f"{ends}; both ends must be above zero"))
        elif not low <= high:
            faults.append(Fault(option, 0, name, f"{ends} leaves nothing between"))
        else:
            found.append(Bound(variable, float(low), float(high), "low" in sides, "high" in sides))
    return tuple(found)


def _points(path: Path, system: System, faults: list[Fault]) -> tuple[Point, ...]:
    """The operating points of a file: `[[points]]`, each a weight and the values that the system has there."""
    table = read_table(path)
    rows = table.content.get("points")
    if not isinstance(rows, list) or not rows or not all(isinstance(row, Mapping) for row in rows):
        raise unusable(path, 'has no operating points; expected tables [[points]] with weight and "table.key" = value')
    found = []
    for number, row in enumerate(rows, 1):
        place, settings, weight = f"{path}: point {number}", [], row.get("weight", 1.0)
        if isinstance(weight, bool) or not isinstance(weight, int | float) or not 0.0 < weight < np.inf:
            faults.append(Fault(place, 0, "weight", f"{weight!r}; expected a number above zero"))
            continue
        for key, value in _dotted(row).items():
            if key.startswith("valve.") or "." not in key:
                faults.append(
                    Fault(place, 0, key, "is no setting of an operating point; a point has one valve with the others")
                )
            else:
                settings.append(f"{key}={value}")
        try:
            there = system.read_from(with_settings(system.table, settings))
        except ConfigError as problem:
            faults += [Fault(place, 0, fault.key, fault.message) for fault in problem.faults]
            continue
        found.append(Point(float(weight), there, setup(there)))
    return tuple(found)


def _dotted(row: Mapping[str, Any]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, value in row.items():
        if isinstance(value, Mapping):
            found |= {f"{key}.{inner}": content for inner, content in value.items()}
        elif key != "weight":
            found[key] = value
    return found
