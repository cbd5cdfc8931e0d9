"""A run with the system it belongs to: the same in memory as read back from its directory."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from vvdp.base.arrays import Array, Rows
from vvdp.base.errors import ConfigError, Fault, UnknownKeyError
from vvdp.base.manifest import Directory, open_directory
from vvdp.base.tables import nearest, suggestion
from vvdp.evaluation.overview import flow_ports, inside, period
from vvdp.evaluation.quantities import summary_numbers
from vvdp.network.network import Network
from vvdp.network.nodes import HydraulicNode, Junction, OilVolume
from vvdp.results.result import Number
from vvdp.simulation.record import Record
from vvdp.simulation.results import read_results
from vvdp.simulation.run import Run
from vvdp.systems.system import System, saved_system

T = TypeVar("T")
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


def _member(known: Mapping[str, T], name: str, what: str) -> T:
    """A member by its name. Raises ConfigError, with what was perhaps meant, if there is none."""
    if name not in known:
        raise ConfigError([Fault("run", 0, name, f"unknown {what}{nearest(name, known)}")])
    return known[name]


class NamedNumbers(dict[str, float | bool]):
    """The numbers of a summary by key."""

    def __missing__(self, key: str) -> float:
        """Raises UnknownKeyError, with the nearest keys."""
        near = suggestion(key, self, most=3) or "; docs/keys.md describes all keys"
        raise UnknownKeyError([Fault("run.summary", 0, key, f"unknown key{near}")])


@dataclass(frozen=True, eq=False)
class RecordedRun:
    """A record with its system, its summary and where it comes from; `directory` is None for one in memory."""

    system: System
    record: Record = field(repr=False)
    summary: Mapping[str, float | bool] = field(repr=False)
    meta: Mapping[str, Any] = field(repr=False)
    directory: Path | None = None
    done: Run | None = field(default=None, repr=False)
    """The simulation itself, of which the record is what is kept; None of a run that was read back."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "summary", NamedNumbers(self.summary))

    @property
    def network(self) -> Network:
        """The network that was simulated."""
        return self.system.circuit.network

    @property
    def times(self) -> Array:
        """Times of the recorded rows [s]."""
        return self.record.times

    @cached_property
    def numbers(self) -> Mapping[str, Number]:
        """The values of the summary with kind and label."""
        return summary_numbers(self.system, {key: v for key, v in self.summary.items() if isinstance(v, int | float)})

    @property
    def period(self) -> str:
        """The word for the interval between two marks."""
        return period(self.system)

    def number(self, key: str) -> float:
        """A value of the summary; nan where it has none."""
        value = self.summary.get(key)
        return np.nan if value is None else float(value)

    def has(self, key: str) -> bool:
        """Whether a flag of the summary is set."""
        return bool(self.summary.get(key, False))

    def state(self, path: str) -> Array:
        """A recorded state over `times` [SI]."""
        return _member(self.record.states, path, "state").values

    def output(self, name: str) -> Array:
        """A recorded output over `times` [SI]."""
        return _member(self.record.outputs, name, "output").values

    def command(self, path: str) -> Array:
        """A recorded command, as "program.field", over `times` [SI]."""
        return _member(self.record.commands, path, "command").values

    def memory(self, path: str) -> Array:
        """Values that a program remembered, as "program.field", over `times` [SI]."""
        return self.record.memory[path].values

    @property
    def volumes(self) -> tuple[str, ...]:
        """Names of the nodes that make their own pressure, but for those inside of a pipe."""
        hidden = inside(self.network)
        nodes = self.network.nodes.items()
        return tuple(name for name, node in nodes if isinstance(node, OilVolume | Junction) and name not in hidden)

    def pressure(self, node: str) -> Array:
        """The gauge pressure of a hydraulic node over `times` [Pa]."""
        found = _member({k: v for k, v in self.network.nodes.items() if isinstance(v, HydraulicNode)}, node, "node")
        absolute = self.state(node) if isinstance(found, OilVolume) else self.output(f"{node}_pressure")
        return absolute - found.oil.reference_pressure

    def flows(self) -> Iterator[tuple[str, str, Array]]:
        """Component, port where it has several, and course of every recorded flow [tank volumes, m^3/s]."""
        hidden = inside(self.network)
        for part in self.network.parts.values():
            for name, port in flow_ports(part).items() if part.name not in hidden else ():
                yield part.name, port, self.output(name)
        for name, group in self.network.groups.items():
            yield name, "", self.output(f"{group.parts[-1]}_flow")

    def fine_from(self) -> int:
        """Row from which on the run is recorded finely; 0 where it nowhere is."""
        coarse = np.flatnonzero(np.diff(self.times) > UNSTEADY * self.system.stepping.window_interval)
        begin = int(coarse[-1]) + 1 if coarse.size else 0
        return begin if begin < self.times.size - 2 else 0

    @property
    def is_fine(self) -> bool:
        """Whether a part of the run is recorded at the window's interval."""
        return self.fine_interval <= UNSTEADY * self.system.stepping.window_interval

    @property
    def fine_interval(self) -> float:
        """Usual interval between the rows of the finely recorded part [s]."""
        steps = np.diff(self.times[self.fine_from() :])
        return float(np.median(steps)) if steps.size else self.system.stepping.record_interval

    def fine(self) -> Detail:
        """The finely recorded part, from its first mark to its last; all of it without two marks."""
        return self._between(None)

    def detail(self) -> Detail:
        """The last whole periods of the finely recorded part, three at most; a short piece without two marks."""
        return self._between(SHOWN_PERIODS)

    def _between(self, periods: int | None) -> Detail:
        t, begin = self.times, self.fine_from()
        marks = self.record.mark_times
        marks = marks[(marks >= t[begin]) & (marks <= t[-1])]
        if marks.size >= 2:
            marks = marks if periods is None else marks[-(periods + 1) :]
            rows = np.flatnonzero((t >= marks[0]) & (t <= marks[-1]))
        else:
            length = np.inf if periods is None else WITHOUT_MARKS
            rows = np.flatnonzero(t >= max(t[begin], t[-1] - length))
        return Detail(rows, marks, self.fine_interval)


def open_run(place: Path | Directory, trust: str = "") -> RecordedRun:
    """The run in a result directory; `trust` is a module, by name or file, that may be run to draw its circuit.

    Raises ConfigError where there is no run, or it has changed, or the system in it cannot be read;
    UntrustedModuleError where it needs code that may not be run.
    """
    directory = open_directory(place)
    results = read_results(directory)
    system = saved_system(directory, str(results.meta.get("system", "")), results.meta.get("module"), trust)
    return RecordedRun(system, results.record, results.summary, results.meta, directory.path)
