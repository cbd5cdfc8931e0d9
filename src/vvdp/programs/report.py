"""Contribution of a type of program to the results of a run: numbers, sentences, figures."""

from collections.abc import Iterable, Iterator, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import Kind
from vvdp.base.signal import Signal, signal_value
from vvdp.network.network import Network, ProgramPart
from vvdp.network.nodes import Source
from vvdp.results.chart import Chart
from vvdp.results.result import Table

if TYPE_CHECKING:
    from vvdp.simulation.outcome import Outcome
    from vvdp.simulation.record import Record
    from vvdp.simulation.run import Run

Quantities: TypeAlias = Mapping[str, tuple[Kind, str]]


class ProgramReport:
    """Contribution of a program, in its place in a network, to the results: nothing, unless a subclass adds more.

    A program type names its own, `ProgramType(..., report=MyReport)`. Where several programs of a circuit have the same
    keys, each key begins with the name of its program.
    """

    GROUP = ""
    """Heading of its numbers."""
    QUANTITIES: Quantities = MappingProxyType({})
    """Kind and label of its numbers, by key."""
    UNSHOWN: frozenset[str] = frozenset()
    """Keys of those that no overview shows."""
    TOGETHER: Mapping[str, tuple[str, ...]] = MappingProxyType({})
    """Keys of numbers of one kind that an overview adds up, by the label of their line."""
    HEADLINE: tuple[str, ...] = ()
    """Keys of the numbers whose ranges are reported where values have one."""

    STEADY = True
    """Whether means of a steady state are expected of a run with it."""
    LEADS = False
    """Whether its keys stand without the name of its program although other types of program have some of them."""

    def __init__(self, network: Network, name: str, sample_period: float) -> None:
        self.program = network.programs[name]
        self.period = self.program.period or sample_period

    def outcome_numbers(self, run: "Outcome", found: Mapping[str, float | bool]) -> dict[str, float]:  # noqa: ARG002
        """Its numbers of any run, recorded or not, beside those in `found`."""
        return {}

    def numbers(self, run: "Run") -> dict[str, float]:  # noqa: ARG002
        """Further numbers, of a recorded run; those that it does not show are left out."""
        return {}

    def warnings(self, found: Mapping[str, float | bool]) -> Iterator[str]:  # noqa: ARG002
        """Warnings to read before the numbers in `found` are used, a sentence each."""
        yield from ()

    def merits(self, found: Mapping[str, float | bool]) -> Iterator[str]:  # noqa: ARG002
        """Facts that the numbers in `found` confirm, a sentence each."""
        yield from ()

    def charts(self, record: "Record") -> Iterable[tuple[Chart, Table]]:  # noqa: ARG002
        """Figures, each over the columns of a table."""
        return ()

    def complete(self, chart: Chart, record: "Record") -> Chart:  # noqa: ARG002
        """A figure of any program of the circuit with what this one adds to it."""
        return chart


def origin(network: Network, source: Source | None) -> tuple[ProgramPart | None, str]:
    """The program whose command a source is, None where it is no command, and the path or field that is read."""
    head, _, field = source.partition(".") if isinstance(source, str) else ("", "", "")
    return (network.programs[head], field) if head in network.programs else (None, str(source))


def read_rows(run: "Run", source: Source, now: Array, after: Array) -> Array:
    """Values of a source that a program read in a run at the rows `now`; those of a command stand in the rows `after`
    them. Of shape (rows,)."""
    if isinstance(source, Signal):
        over: Any = run.times[now]
        values: Any = signal_value(over, source)
        return np.full(now.shape, values)
    assert isinstance(source, str)
    head, _, field = source.partition(".")
    if head in run.command._fields:
        found: Array = getattr(getattr(run.command, head), field)[after]
        return found
    rows: Array = state_rows(run, source)[now]
    return rows


def state_rows(run: "Run", path: str) -> Array:
    """A state over all rows of a run, (rows,)."""
    found: Any = run.state
    for name in path.split("."):
        found = getattr(found, name) if name in getattr(found, "_fields", ()) else found  # a pressure is its node
    rows: Array = found
    return rows
