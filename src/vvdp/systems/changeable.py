"""Values of a system that may be changed without reading it again, and how each reaches the vectors of a case.

The case is built again with other values of an entry, and it is looked which numbers of its vectors change, and whether
they follow the value by one operation that gives the same bits in a browser. A value that does anything else is
reported with the reason, and stays as it is.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import display_unit, unit_symbol
from vvdp.base.errors import VvdpError
from vvdp.base.kinds import PRESSURE_LEVEL, Kind
from vvdp.base.tables import Sourced, with_settings
from vvdp.base.units import line_to_si, parse
from vvdp.simulation.layout import held_part, vectors
from vvdp.systems.system import System

VECTORS = ("y", "command", "memory", "params")
"""The vectors of a case as the loop names them, in the order of `layout.Vectors`."""
SAMPLES = 41
"""Numbers with which the conversion of a unit is tried."""
PROBES = (0.93, 1.0, 1.11)
"""By what a value is multiplied to see what follows it."""
LEAST, MOST = 0.2, 3.0
"""Ends of a slider where a file gives no range, as multiples of its value."""
OPERATIONS: Mapping[str, Callable[[float, float], float]] = {
    "+": lambda x, c: x + c,
    "*": lambda x, c: x * c,
    "/": lambda x, c: x / c,
    "over": lambda x, c: c / x,
}
"""What a browser calculates with the same bits: of a value and a constant."""


@dataclass(frozen=True)
class Follower:
    """A number of a vector that follows a value `x` [SI] by an operation with a constant."""

    vector: str
    place: int
    operation: str
    constant: float


@dataclass(frozen=True)
class Changeable:
    """A value with the ends of its slider, in the unit in which it is written; `why_not` where it cannot be changed.

    `steps` bring a number in that unit to SI, as files are read.
    """

    row: Sourced
    unit: str
    number: float
    low: float
    high: float
    steps: tuple[tuple[str, float], ...] = ()
    followers: tuple[Follower, ...] = ()
    why_not: str = ""

    @property
    def flat(self) -> dict[str, Any]:
        """As JSON has it."""
        kind, row = self.row.kind, self.row
        return {
            "setting": row.setting, "label": row.key.replace("_", " "), "table": row.table.replace("_", " "),
            "unit": self.unit, "symbol": unit_symbol(self.unit), "number": self.number, "low": self.low,
            "high": self.high, "steps": self.steps, "why_not": self.why_not, "status": row.status,
            "source": row.source, "where": row.where, "note": row.remark, "kind": kind.with_article,
            "example": kind.example, "least": kind.low, "most": kind.high, "si": "" if kind.unit == "1" else kind.unit,
            "followers": [[f.vector, f.place, f.operation, f.constant] for f in self.followers],
        }  # fmt: skip


def changeable_values(system: System, fixed: Callable[[System], object]) -> tuple[Changeable, ...]:
    """The values of a system that are one number each; `fixed` gives what a page cannot calculate again."""
    base, before = vectors(system.case), fixed(system)
    found = []
    for row in system.rows:
        if np.isfinite(row.nominal) and row.table != "run":
            found.append(_changeable(system, row, (base, before), fixed))
    return tuple(found)


def _changeable(system: System, row: Sourced, base: Any, fixed: Callable[[System], object]) -> Changeable:
    """A value with a slider over its whole range, or over what is near to it where the ends contradict others."""
    number, (low, high) = _as_written(row.nominal, row.kind), _ends(row)
    near = tuple(float(f"{number * factor:.12g}") for factor in PROBES) if number else ()
    inside = tuple(sorted({*(x for x in near if low <= x <= high), number}))
    why = "its range is empty"
    middle = float(f"{0.4 * low + 0.6 * high:.4g}")
    for probes in (tuple(sorted({low, *inside, middle, high})), inside):
        if len(probes) < 3 or not low <= number <= high:
            continue
        made = Changeable(row, row.kind.display_unit, number, probes[0], probes[-1])
        try:
            return _with_followers(system, made, probes, base, fixed)
        except (VvdpError, ValueError) as problem:
            why = str(problem).splitlines()[0].removeprefix("--set: ")[:160]
    return Changeable(row, row.kind.display_unit, number, low, high, why_not=why)


def _with_followers(
    system: System, made: Changeable, probes: Sequence[float], base: Any, fixed: Callable[[System], object]
) -> Changeable:
    """The value with what follows it. Raises ValueError, or what a system raises, where it cannot be changed so."""
    steps = conversion(made.row.kind, made.unit, probes)
    if steps is None:
        raise ValueError("its unit is not read by one operation")
    cases = [_with_value(system, made.row, probe, made.unit) for probe in probes]
    if any(fixed(each) != base[1] for each in cases):
        raise ValueError("it changes the circuit itself, or from what numbers are counted")
    rows = [vectors(each.case) for each in cases]
    if any(a.shape != b.shape for each in rows for a, b in zip(each, base[0], strict=True)):
        raise ValueError("it changes how many numbers the circuit has")
    held = held_part(system.case)
    values = [parse(f"{probe!r} {made.unit}".rstrip(), made.row.kind) for probe in probes]
    followers = list(_followers(base[0], rows, values, held))
    if not followers:
        raise ValueError("nothing that is simulated follows it")
    if None in followers:
        raise ValueError("what follows from it is not one product or sum")
    return replace(made, steps=steps, followers=tuple(each for each in followers if each is not None))


def _followers(base: Any, rows: Sequence[Any], values: Sequence[float], held: slice) -> Iterator[Follower | None]:
    """What follows a value, None for what does so by no single operation. What is held is calculated by the module."""
    for name, place in zip(VECTORS, range(len(VECTORS)), strict=True):
        probed: Array = np.stack([each[place] for each in rows])
        changed = (probed != base[place]).any(axis=0)
        if name == "command":
            changed[held] = False
        for at in np.flatnonzero(changed):
            found = operation_of(values, probed[:, at].tolist())
            yield None if found is None else Follower(name, int(at), *found)


def operation_of(values: Sequence[float], numbers: Sequence[float]) -> tuple[str, float] | None:
    """The operation and constant by which `numbers` follow `values`, to the last bit."""
    middle = (len(values) + 1) // 2
    x, y = values[middle], numbers[middle]
    candidates = [("+", 0.0), ("*", -1.0), ("+", y - x)]
    if x != 0.0 and y != 0.0:
        nearest = [("*", y / x), ("/", x / y)] + ([("over", y * x)] if all(values) else [])
        candidates += [*nearest, ("*", float(f"{y / x:.12g}")), ("/", float(f"{x / y:.12g}"))]
        candidates += [(op, float(np.nextafter(c, way))) for op, c in nearest for way in (-np.inf, np.inf)]
    for operation, constant in candidates:
        work = OPERATIONS[operation]
        if all(work(v, constant) == n for v, n in zip(values, numbers, strict=True)):
            return operation, constant
    return None


def conversion(kind: Kind, unit: str, samples: Sequence[float]) -> tuple[tuple[str, float], ...] | None:
    """One or two operations that bring a number in `unit` to SI as files are read; None where there are none."""
    zero, one = _in_si(0.0, unit, kind), _in_si(1.0, unit, kind)
    factor, offset = one - zero, zero
    tried = np.linspace(min(samples), max(samples), SAMPLES).tolist()
    factors = [("*", factor), ("*", float(f"{factor:.12g}"))]
    if factor:
        factors += [("*", _in_si(1.0, unit, kind, difference=True)), ("/", float(f"{1.0 / factor:.12g}"))]
    for first in factors:
        steps = (first, ("+", offset)) if offset else (first,)
        if all(_follow(steps, x) == _in_si(x, unit, kind) for x in tried):
            return steps
    return None


def _follow(steps: Sequence[tuple[str, float]], x: float) -> float:
    for operation, constant in steps:
        x = OPERATIONS[operation](x, constant)
    return x


def _in_si(number: float, unit: str, kind: Kind, *, difference: bool = False) -> float:
    factor, offset = line_to_si(unit, kind)
    if difference:
        return factor
    try:
        return parse(f"{number!r} {unit}".rstrip(), kind)
    except VvdpError:
        return number * factor + offset


def _as_written(value: float, kind: Kind) -> float:
    """A value [SI] in the unit in which it is written, of 12 digits."""
    unit = display_unit(kind)
    return float(f"{unit.from_si(value):.12g}")


def _ends(row: Sourced) -> tuple[float, float]:
    """Ends of the slider of a value, within what its quantity may be."""
    kind = row.kind
    number = _as_written(row.nominal, kind)
    if row.range is not None:
        low, high = (_as_written(end, kind) for end in row.range)
    elif number:
        low, high = sorted((LEAST * number, MOST * number))
    elif kind.name == PRESSURE_LEVEL.name:
        low, high = 0.0, kind.scale / display_unit(kind).scale
    else:
        low, high = 0.0, _as_written(min(kind.high, max(kind.scale, 1e-9)), kind)
    least, most = sorted((_as_written(kind.low, kind), _as_written(kind.high, kind)))
    return float(f"{max(low, least):.4g}"), float(f"{min(high, most):.4g}")


def _with_value(system: System, row: Sourced, number: float, unit: str) -> System:
    text = f'{row.setting}="{number!r} {unit}"' if unit else f"{row.setting}={number!r}"
    return system.read_from(with_settings(system.table, [text]))
