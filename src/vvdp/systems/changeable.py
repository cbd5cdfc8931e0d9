"""Values of a system that may be changed without reading it again, and how each reaches the vectors of a case.

The case is built again with other values of an entry, and it is looked which numbers of its vectors change, and whether
they follow the value by one operation that gives the same bits in a browser. A value that does anything else is
reported with the reason, and stays as it is.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import display_unit, unit_symbol
from vvdp.base.errors import VvdpError
from vvdp.base.kinds import PRESSURE_LEVEL, Kind
from vvdp.base.tables import Sourced
from vvdp.base.units import line_to_si, parse
from vvdp.systems.probing import Found, Probe, Probing
from vvdp.systems.system import System

VECTORS = ("y", "command", "memory", "params")
"""The vectors of a case as the loop names them, in the order of `layout.Vectors`."""
SAMPLES = 41
"""Numbers with which the conversion of a unit is tried."""
PROBES = (0.93, 1.0, 1.11)
"""By what a value is multiplied to see what follows it."""
LEAST, MOST = 0.2, 3.0
"""Ends of a slider where a file gives no range, as multiples of its value."""
OTHERWISE = "what follows from it is not one product or sum"
OPERATIONS: Mapping[str, Callable[[float, float], float]] = {
    "+": lambda x, c: x + c,
    "*": lambda x, c: x * c,
    "/": lambda x, c: x / c,
    "over": lambda x, c: c / x,
}
"""Operations on a value and a constant that a browser calculates with the same bits."""


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
    probing = Probing(system, fixed)
    rows = [row for row in system.rows if np.isfinite(row.nominal) and row.table != "run"]
    ranges = [_ranges(row) for row in rows]
    probing.build_inner(first for each in ranges if (first := next(filter(_is_usable(probing), each), None)))
    return tuple(_changeable(row, each, probing) for row, each in zip(rows, ranges, strict=True))


def _ranges(row: Sourced) -> list[tuple[Probe, ...]]:
    """Sets of trial values of a parameter: its whole range, and values near to it if the ends contradict other
    values."""
    number, (low, high) = as_written(row.nominal, row.kind), _ends(row)
    near = tuple(float(f"{number * factor:.12g}") for factor in PROBES) if number else ()
    inside = tuple(sorted({*(x for x in near if low <= x <= high), number}))
    middle = float(f"{0.4 * low + 0.6 * high:.4g}")
    tried = [tuple(sorted({low, *inside, middle, high})), inside]
    return [tuple(Probe(row, x) for x in each) for each in tried if len(each) >= 3 and low <= number <= high]


def _is_usable(probing: Probing) -> Callable[[tuple[Probe, ...]], bool]:
    """Whether the circuit can be built at both ends of a range, and what follows at the first one may be followed."""

    def usable(probes: tuple[Probe, ...]) -> bool:
        ends = (probing.find(probes[at]) for at in (0, -1))
        return not next(ends).why_not and not _departs(probes, probing) and not next(ends).why_not

    return usable


def _departs(probes: Sequence[Probe], probing: Probing) -> bool:
    """Whether the number of the file and the first end of a range alone show that no single operation leads to both."""
    two = [probes[0], *(probe for probe in probes if probe.is_written)]
    found = [probing.find(probe) for probe in two]
    return len(two) == 2 and not found[0].why_not and _followers(two, found, probing) is None


def _changeable(row: Sourced, ranges: Sequence[tuple[Probe, ...]], probing: Probing) -> Changeable:
    """A value with what follows it, over the first of its ranges over which that is known."""
    number, (low, high) = as_written(row.nominal, row.kind), _ends(row)
    why = "its range is empty"
    for each in ranges:
        made = Changeable(row, row.kind.display_unit, number, each[0].number, each[-1].number)
        if each is not ranges[-1] and not _is_usable(probing)(each):
            continue
        try:
            return _with_followers(made, each, probing)
        except ValueError as problem:
            why = str(problem)
    return Changeable(row, row.kind.display_unit, number, low, high, why_not=why)


def _with_followers(made: Changeable, probes: Sequence[Probe], probing: Probing) -> Changeable:
    """The value with what follows it. Raises ValueError with the reason where it cannot be changed so."""
    steps = conversion(made.row.kind, made.unit, [probe.number for probe in probes])
    if steps is None:
        raise ValueError("its unit is not read by one operation")
    if _departs(probes, probing):
        raise ValueError(OTHERWISE)
    found = [probing.view(probe) for probe in probes]
    if wrong := [each for each in found if each.why_not]:
        raise ValueError(min(wrong, key=lambda each: each.stage).why_not)
    followers = _followers(probes, found, probing)
    if followers is None and _followers((probes[0], probes[-1]), (found[0], found[-1]), probing) is not None:
        followers = _followers(probes, [probing.find(probe) for probe in probes], probing)
    if followers is None:
        raise ValueError(OTHERWISE)
    if not followers:
        raise ValueError("nothing that is simulated follows it")
    return replace(made, steps=steps, followers=followers)


def _followers(probes: Sequence[Probe], found: Sequence[Found], probing: Probing) -> tuple[Follower, ...] | None:
    """Numbers that follow a value; None if one does so by no single operation."""
    numbers: Array = np.stack([each.numbers for each in found])
    values = [probe.si for probe in probes]
    followers = list[Follower]()
    for at in np.flatnonzero((numbers != probing.numbers).any(axis=0) & probing.counted):
        operation = operation_of(values, numbers[:, at].tolist())
        if operation is None:
            return None
        vector, place = probing.place(int(at))
        followers.append(Follower(VECTORS[vector], place, *operation))
    return tuple(followers)


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


def as_written(value: float, kind: Kind) -> float:
    """A value [SI] in the unit in which it is written, of 12 digits."""
    unit = display_unit(kind)
    return float(f"{unit.from_si(value):.12g}")


def _ends(row: Sourced) -> tuple[float, float]:
    """Ends of the slider of a value, within what its quantity may be."""
    kind = row.kind
    number = as_written(row.nominal, kind)
    if row.range is not None:
        low, high = (as_written(end, kind) for end in row.range)
    elif number:
        low, high = sorted((LEAST * number, MOST * number))
    elif kind.name == PRESSURE_LEVEL.name:
        low, high = 0.0, kind.scale / display_unit(kind).scale
    else:
        low, high = 0.0, as_written(min(kind.high, max(kind.scale, 1e-9)), kind)
    least, most = sorted((as_written(kind.low, kind), as_written(kind.high, kind)))
    return float(f"{max(low, least):.4g}"), float(f"{min(high, most):.4g}")
