"""A result directory as the report reads it: the numbers, the system they belong to, and the rows worth drawing."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vvdp.base.arrays import Array, Rows
from vvdp.base.signal import Signal
from vvdp.base.tables import Sourced, parsed_table
from vvdp.network.network import Network
from vvdp.network.nodes import HydraulicNode, OilVolume
from vvdp.simulation.results import Results, read_results
from vvdp.systems.overview import flow_ports, inside, period
from vvdp.systems.system import System, built_system

BAR = 1e5
LPM = 1e-3 / 60.0
SHOWN_PERIODS = 3
WITHOUT_MARKS = 0.05
"""Length of the detailed figures where no period was passed [s]."""

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
        """Whole periods among the rows."""
        return max(self.marks.size - 1, 0)


@dataclass(frozen=True)
class Reading:
    """A result directory with the system rebuilt from the text in it."""

    results: Results
    system: System

    @property
    def network(self) -> Network:
        """What was simulated."""
        return self.system.circuit.network

    @property
    def period(self) -> str:
        """What passes between two marks."""
        return period(self.system)

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

    def command(self, path: str) -> Array:
        """A recorded command, as "program.field", over `results.times` [SI]."""
        return self.results.commands[path].values

    @property
    def volumes(self) -> tuple[str, ...]:
        """Names of the nodes that make their own pressure, but for those inside of a pipe."""
        hidden = inside(self.network)
        nodes = self.network.nodes.items()
        return tuple(name for name, node in nodes if isinstance(node, OilVolume) and name not in hidden)

    def pressure(self, node: str) -> Array:
        """The gauge pressure of a hydraulic node over `results.times` [Pa]."""
        found = self.network.nodes[node]
        assert isinstance(found, HydraulicNode)
        absolute = self.state(node) if isinstance(found, OilVolume) else self.output(f"{node}_pressure")
        return absolute - found.oil.reference_pressure

    def flows(self) -> Iterator[tuple[str, Array]]:
        """Name and course of every recorded flow of a component [tank volumes, m^3/s]."""
        hidden = inside(self.network)
        for part in self.network.parts.values():
            for name, port in flow_ports(part).items() if part.name not in hidden else ():
                yield f"{part.name}, {port}" if port else part.name, self.output(name)
        for name, group in self.network.groups.items():
            yield name, self.output(f"{group.parts[-1]}_flow")

    def is_absolute(self, row: Sourced) -> bool:
        """Whether a pressure level was written as an absolute one."""
        entry: Any = self.system.content
        for key in (*row.table.split("."), row.key):
            entry = entry.get(key, "") if isinstance(entry, dict) else ""
        return "bara" in str(entry) or "psia" in str(entry)

    @property
    def varies(self) -> bool:
        """Whether anything prescribed changes over time."""
        return any(isinstance(r.value, Signal) and not r.value.is_constant for r in self.system.rows)

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
        """The last whole periods of the finely recorded part, three at most; a short piece without two marks."""
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
        """Means over each period of what the integral `path` adds up [SI], shape (marks - 1,)."""
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
    return Reading(results, built_system(table, str(results.meta.get("system", "")), directory))
