"""A result directory as the report reads it: the numbers, the system they belong to, and the rows worth drawing."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from vvdp.base.signal import Signal, signal_value
from vvdp.base.tables import Sourced, parsed_table
from vvdp.circuits.supply import Operation, SupplyParams
from vvdp.numerics.tableaus import Array
from vvdp.simulation.results import Results, read_results
from vvdp.systems.benches import operation
from vvdp.systems.system import System, built_system

BAR = 1e5
LPM = 1e-3 / 60.0
SHOWN_PERIODS = 3
WITHOUT_MARKS = 0.05
"""Length of the detailed figures where no PWM period was passed [s]."""

Rows: TypeAlias = np.ndarray[Any, np.dtype[np.intp]]

UNSTEADY = 1.5
"""A recorded step above this multiple of the window's interval ends the finely recorded part."""


@dataclass(frozen=True)
class Detail:
    """The rows that the detailed figures show, with the marks at their borders."""

    rows: Rows
    marks: Array  # [s]
    interval: float  # between rows [s]

    @property
    def periods(self) -> int:
        """Whole PWM periods among the rows."""
        return max(self.marks.size - 1, 0)


@dataclass(frozen=True)
class Reading:
    """A result directory with the system rebuilt from the text in it."""

    results: Results
    system: System

    @property
    def supply(self) -> SupplyParams:
        """Parameters of everything upstream of the load."""
        found: SupplyParams = self.system.case.params.supply
        return found

    @property
    def operation(self) -> Operation:
        """What was prescribed, with the duty ratio as axial position."""
        return operation(self.supply.operation, self.supply.valve.helix_length)

    @property
    def reference(self) -> float:
        """What gauge pressures count from [Pa]."""
        return self.supply.oil.reference_pressure

    @property
    def has_load_line(self) -> bool:
        """Whether the load makes its own pressure."""
        return "load_pressure" in self.results.states

    @property
    def is_watched(self) -> bool:
        """Whether encoder and filter ran along."""
        return "speed_deviation" in self.results.shown

    def number(self, key: str) -> float:
        """A value of the summary; nan where it has none."""
        return float(self.results.summary.get(key, np.nan))

    def has(self, key: str) -> bool:
        """Whether a flag of the summary is set."""
        return bool(self.results.summary.get(key, False))

    def state(self, path: str) -> Array:
        """A recorded state over `results.times` [SI]."""
        return self.results.states[path].values

    def output(self, name: str) -> Array:
        """A recorded output over `results.times` [SI]."""
        return self.results.outputs[name].values

    def row(self, table: str, key: str) -> Sourced | None:
        """A parameter with its origin; None where the system has none of this name."""
        return next((r for r in self.system.rows if (r.table, r.key) == (table, key)), None)

    def is_absolute(self, row: Sourced) -> bool:
        """Whether a pressure level was written as an absolute one."""
        entry = self.system.content.get(row.table, {}).get(row.key, "")
        return "bara" in str(entry) or "psia" in str(entry)

    @property
    def duty_ratio(self) -> Signal:
        """The axial position over the helix length."""
        x, length = self.operation.axial_position, self.supply.valve.helix_length
        return Signal(
            x.base / length,
            x.start,
            x.duration,
            tuple(c / length for c in x.change),
            tuple(a / length for a in x.amplitude),
            x.frequency,
            x.phase,
        )

    @property
    def varies(self) -> bool:
        """Whether anything prescribed changes over time."""
        return any(isinstance(r.value, Signal) and not r.value.is_constant for r in self.system.rows)

    @property
    def mean_load_pressure(self) -> float:
        """[Pa, absolute]."""
        return self.number("mean_load_pressure_Pa") + self.reference

    def start(self, signal: Signal) -> float:
        """The value that a signal begins with."""
        return float(signal_value(0.0, signal))

    def fine_from(self) -> int:
        """Row from which on the run is recorded finely; 0 where it nowhere is."""
        coarse = np.flatnonzero(np.diff(self.results.times) > UNSTEADY * self.system.stepping.window_interval)
        begin = int(coarse[-1]) + 1 if coarse.size else 0
        return begin if begin < self.results.times.size - 2 else 0

    @property
    def is_fine(self) -> bool:
        """Whether a part of the run is recorded at the window's interval."""
        return self.fine_interval <= UNSTEADY * self.system.stepping.window_interval

    @property
    def fine_interval(self) -> float:
        """Usual interval between the rows of the finely recorded part [s]."""
        steps = np.diff(self.results.times[self.fine_from() :])
        return float(np.median(steps)) if steps.size else self.system.stepping.record_interval

    def fine(self) -> Detail:
        """The finely recorded part, from its first mark to its last; all of it without two marks."""
        return self._between(None)

    def detail(self) -> Detail:
        """The last whole PWM periods of the finely recorded part, three at most; a short piece without two marks."""
        return self._between(SHOWN_PERIODS)

    def _between(self, periods: int | None) -> Detail:
        t, begin = self.results.times, self.fine_from()
        marks = self.results.mark_times
        marks = marks[(marks >= t[begin]) & (marks <= t[-1])]
        if marks.size >= 2:
            marks = marks if periods is None else marks[-(periods + 1) :]
            rows = np.flatnonzero((t >= marks[0]) & (t <= marks[-1]))
        else:
            length = np.inf if periods is None else WITHOUT_MARKS
            rows = np.flatnonzero(t >= max(t[begin], t[-1] - length))
        return Detail(rows, marks, self.fine_interval)

    def period_means(self, path: str) -> Array:
        """Means over each PWM period of what the integral `path` adds up [SI], shape (marks - 1,)."""
        integral = self.results.mark_states[path].values
        means: Array = np.diff(integral) / np.diff(self.results.mark_times)
        return means

    def period_extremes(self, values: Array) -> tuple[Array, Array, Array]:
        """Times, and smallest and largest of the recorded `values` between marks, or in 60 parts without marks.

        Both ends of each part are given, so that lines through them make steps over the whole run.
        """
        t, marks = self.results.times, self.results.mark_times
        borders = marks if marks.size >= 2 else np.linspace(t[0], t[-1], 61)
        cuts = np.unique(np.concatenate([[0], np.searchsorted(t, borders).clip(0, t.size - 1)]))
        ends = np.append(cuts[1:], t.size - 1)
        parts = np.split(values, cuts[1:])
        low, high = (np.array([extreme(part) for part in parts]) for extreme in (np.min, np.max))
        times = np.stack([t[cuts], t[ends]], axis=1).ravel()
        return times, np.repeat(low, 2), np.repeat(high, 2)


def reading(directory: Path) -> Reading:
    """The content of a result directory. Raises ConfigError where it is none, or the system in it cannot be read."""
    results = read_results(directory)
    table = parsed_table(results.system, str(directory / "system.toml"))
    return Reading(results, built_system(table, str(results.meta.get("system", ""))))
