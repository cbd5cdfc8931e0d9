"""Result of a fit to a table: coefficients with their intervals, points, curves, and the valve's own values."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple, Protocol

from vvdp.base.display import number, readable, with_unit
from vvdp.base.kinds import PRESSURE_LEVEL, TEMPERATURE, Kind
from vvdp.base.params import field_kinds
from vvdp.fluid.oil import Oil
from vvdp.results.chart import Chart
from vvdp.results.result import Finding, Grade, Table
from vvdp.valve.rotary import RotaryValve


class Taker(Protocol):
    """Receiver of the fitted values: a valve or a component of a system, or a restriction without one."""

    @property
    def name(self) -> str:
        """The system; empty without one."""

    @property
    def conditions(self) -> dict[str, str]:
        """The basis of the fit, as text."""

    def present(self, key: str) -> float:
        """The value that a fitted one takes the place of; nan without one."""

    def place(self, key: str) -> str | None:
        """Where a system file has the value; None if it has no such value."""


class Host(NamedTuple):
    """The valve whose law is fitted, with its oil, and where it works: temperature, load and tank [SI, absolute].

    `name` is that of its system, whose file has its values in `table`.
    """

    name: str
    table: str
    valve: RotaryValve
    oil: Oil
    temperature: float
    load_pressure: float
    tank_pressure: float

    @property
    def conditions(self) -> dict[str, str]:
        """Temperature of the oil and pressure of the load, as text."""
        return {
            "oil": with_unit(self.temperature, TEMPERATURE),
            "load": with_unit(self.load_pressure, PRESSURE_LEVEL),
        }

    def present(self, key: str) -> float:
        """A value of the valve."""
        return float(getattr(self.valve, key))

    def place(self, key: str) -> str:
        """Where a system file has a value of the valve."""
        return f"{self.table}.{key}"


class Interval(NamedTuple):
    """A value and the interval that holds it with 95 %; nan where the interval has no meaning."""

    value: float
    low: float
    high: float


class Coefficient(NamedTuple):
    """A coefficient with its kind and its label."""

    interval: Interval
    kind: Kind
    label: str


@dataclass(frozen=True, kw_only=True)
class Fitted:
    """A law as fitted. `coefficients` always has `coefficient` and `exponent`; `valve` has values by keys of the valve.

    `scatter` is the root mean square of the relative distance from the law, `points` the table with what the law says.
    """

    title: str
    formula: str
    coefficients: Mapping[str, Coefficient]
    valve: Mapping[str, Coefficient]
    scatter: float
    points: Table
    curve: Table
    chart: Chart
    findings: tuple[Finding, ...] = ()


def around(value: float, half_width: float) -> Interval:
    """The interval of a coefficient as fitted."""
    return Interval(value, value - half_width, value + half_width)


def around_log(logarithm: float, half_width: float) -> Interval:
    """The interval of what was fitted as its logarithm."""
    return Interval(math.exp(logarithm), math.exp(logarithm - half_width), math.exp(logarithm + half_width))


def power_of(interval: Interval, factor: float, power: float) -> Interval:
    """The interval of factor times a power of a positive quantity, its ends in order."""
    low, high = sorted(factor * end**power if end > 0.0 else math.nan for end in interval[1:])
    return Interval(factor * interval.value**power, low, high)


def valve_value(key: str, interval: Interval, label: str) -> tuple[Coefficient, tuple[Finding, ...]]:
    """A value of the valve, moved into the range that the valve takes, and what is to be said where it had to be."""
    kind = field_kinds(RotaryValve)[key]
    assert kind is not None
    low, high = (min(max(end, kind.low), kind.high) for end in interval[1:])
    value = min(max(interval.value, kind.low), kind.high)
    if value == interval.value:
        return Coefficient(Interval(value, low, high), kind, label), ()
    said = Finding(
        title="Outside the law",
        grade=Grade.WARNING,
        text=f"The {label} of {number(interval.value, 4)} lies outside {kind.low:g} to {kind.high:g}, which the law "
        f"takes; {value:g} is written.",
        remedy="Look at the table, or take more points.",
    )
    return Coefficient(Interval(value, low, high), kind, label), (said,)


def _has_width(interval: Interval) -> bool:
    """Whether an interval is more than rounding, or a value at its end."""
    least = 1e-6 * abs(interval.value)
    return interval.high - interval.low > least and interval.low <= interval.value <= interval.high


def settings(found: Fitted, source: Path, taker: Taker) -> Iterator[str]:
    """The fitted values as settings of a system, each with its interval and origin."""
    rows = found.points.rows
    note = f"fitted to {rows} points of {readable(source.name)}".replace('"', "'").replace("\\", "/")
    for key, (interval, kind, _) in found.valve.items():
        unit = "" if kind.unit == "1" else f" {kind.unit}"
        texts = [f'"{each:.9g}{unit}"' for each in interval]
        spread = f"range=[{texts[1]}, {texts[2]}], " if _has_width(interval) else ""
        if place := taker.place(key):
            yield f'{place}={{value={texts[0]}, {spread}status="derived", note="{note}"}}'
