"""The axes of a map: duty ratio, load pressure, pump speed and oil temperature."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vvdp.base.display import display_unit
from vvdp.base.errors import ConfigError, Fault
from vvdp.base.kinds import DUTY_RATIO, PRESSURE_LEVEL, SPEED, TEMPERATURE, Kind
from vvdp.steady.test_stand import SetPoint, Stand

MOST_POINTS = 1_000_000
BELOW_ZERO = -1e-12
"""A duty ratio that counts as 0: what rounding leaves of it."""


@dataclass(frozen=True)
class Axes:
    """The values that a map goes through; its points are ordered with the duty ratio fastest, the temperature slowest.

    Pressures are absolute. Raises ConfigError with all that is wrong when made.
    """

    duty_ratios: tuple[float, ...]
    load_pressures: tuple[float, ...]
    pump_speeds: tuple[float, ...]
    temperatures: tuple[float, ...]

    def __post_init__(self) -> None:
        faults = [
            Fault("map", 0, name, problem)
            for name, values, allowed in (
                ("duty ratios", self.duty_ratios, _Range(DUTY_RATIO, BELOW_ZERO, 1.0 - BELOW_ZERO)),
                ("load pressures", self.load_pressures, _Range(PRESSURE_LEVEL, 0.0, np.inf)),
                ("pump speeds", self.pump_speeds, _Range(SPEED, 0.0, np.inf)),
                ("temperatures", self.temperatures, _Range(TEMPERATURE, 0.0, np.inf)),
            )
            if (problem := _axis_problem(values, allowed))
        ]
        if not faults and self.count > MOST_POINTS:
            faults = [Fault("map", 0, "", f"{self.count} points; at most {MOST_POINTS}")]
        if faults:
            raise ConfigError(faults)

    @property
    def shape(self) -> tuple[int, int, int, int]:
        """Numbers of temperatures, pump speeds, load pressures and duty ratios."""
        return len(self.temperatures), len(self.pump_speeds), len(self.load_pressures), len(self.duty_ratios)

    @property
    def count(self) -> int:
        """Number of points."""
        return int(np.prod(self.shape))

    @property
    def points(self) -> list[SetPoint]:
        """All operating points in the order of a map's columns."""
        ordered = itertools.product(self.temperatures, self.pump_speeds, self.load_pressures, self.duty_ratios)
        return [SetPoint(d, p, n, t) for t, n, p, d in ordered]


class _Range(NamedTuple):
    """Limits of the values of an axis [SI]: above `lowest`, up to `highest`."""

    kind: Kind
    lowest: float
    highest: float

    def words(self, value: float) -> str:
        """`value` [SI] as people write it."""
        unit = display_unit(self.kind)
        return f"{round(unit.from_si(value), 6) + 0.0:.6g} {unit.symbol}".rstrip()

    @property
    def expectation(self) -> str:
        """The limits, in words."""
        if np.isfinite(self.highest):
            return f"numbers from {self.words(self.lowest)} to {self.words(self.highest)}"
        return f"numbers above {self.words(self.lowest)}"


def _axis_problem(values: Sequence[float], allowed: _Range) -> str | None:
    if not values:
        return "none; expected at least one"
    if outside := [v for v in values if not (np.isfinite(v) and allowed.lowest < v <= allowed.highest)]:
        more = f" and {len(outside) - 1} more" if len(outside) > 1 else ""
        return f"{allowed.words(outside[0])}{more}; expected {allowed.expectation}"
    for before, after in itertools.pairwise(values):
        if after <= before:
            return f"{allowed.words(after)} after {allowed.words(before)}; expected increasing values"
    return None


def default_axes(stand: Stand, duties: int = 12, pressures: int = 10) -> Axes:
    """Duty ratios up to 1, load pressures up to 95 % of the relief setting; speed and temperature of the system."""
    here = stand.set_point
    rise = stand.relief_pressure - stand.tank_pressure
    shares = np.linspace(0.05, 0.95, pressures) if pressures > 1 else np.array([0.8])
    steps = np.linspace(1.0 / duties, 1.0, duties)
    return Axes(
        tuple(float(d) for d in steps),
        tuple(float(stand.tank_pressure + share * rise) for share in shares),
        (here.pump_speed,),
        (here.oil_temperature,),
    )
