"""Additions of a system: numbers, lines on the console, warnings, figures."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from vvdp.base.kinds import Kind
from vvdp.results.chart import Chart
from vvdp.results.result import Table
from vvdp.systems.bound import Bound

if TYPE_CHECKING:
    from vvdp.base.tables import Sourced
    from vvdp.geometry.shape import ValveShape
    from vvdp.network.build import Circuit
    from vvdp.simulation.model import Case, Model
    from vvdp.simulation.outcome import Outcome
    from vvdp.simulation.record import Record
    from vvdp.simulation.run import Run
    from vvdp.systems.faults import NamedFault

Summary = dict[str, float | bool]


class Line(NamedTuple):
    """A line of the overview that a user is shown: what it is called, and keys of the summary that are added up.

    `closed_form` are keys of an analytic result beside it; lines of one `group` stand together.
    """

    label: str
    keys: tuple[str, ...]
    kind: Kind
    closed_form: tuple[str, ...] = ()
    group: str = ""


class LoadedSystem(Protocol):
    """Interface of a system (`systems.system.System`) for extras, bounds and messages, on which it is built."""

    @property
    def name(self) -> str:
        """Name of its file."""

    @property
    def circuit(self) -> "Circuit":
        """Its network and the functions written from it."""

    @property
    def case(self) -> "Case":
        """The values that the circuit starts from."""

    @property
    def model(self) -> "Model":
        """The plain functions of the circuit."""

    @property
    def tables(self) -> Mapping[str, Any]:
        """Values of the tables of its file."""

    @property
    def shape(self) -> "ValveShape | None":
        """The valve as a solid; None where the file has no table [geometry]."""

    @property
    def extras(self) -> "Extras | None":
        """The additions of the system; None where there are none."""

    @property
    def faults(self) -> "Sequence[NamedFault]":
        """What fails in the circuit."""

    @property
    def rows(self) -> "Sequence[Sourced]":
        """Its values, and where each comes from."""


class Extras:
    """Additions of a system: none, unless a subclass says more.

    A circuit names its own with `net.extras = MyExtras`; it is made with the system.
    """

    PERIOD = "period"
    """Word for the interval between two marks of a run."""
    STEADY = True
    """Whether a user expects means of a steady state from a run."""
    OVERVIEW: tuple[Line, ...] = ()
    """The lines of the overview; where there are none, nodes and components are shown."""
    IS_ALL = True
    """Whether these lines are all that a user is shown; else they stand below nodes and components."""
    OVERVIEW_NOTE = ""
    """Notes on these lines, in sentences."""

    HEADLINE: tuple[str, ...] = ()
    """Keys of the numbers whose ranges are reported where values have one; without, pressures and speeds."""

    QUANTITIES: Mapping[str, tuple[Kind, str]] = {}
    """Kind and label of the numbers that it adds to a summary, by key."""

    CLOSED_FORMS: tuple[str, ...] = ()
    """Keys of what `closed_forms` gives."""

    def __init__(self, system: "LoadedSystem", tables: "Mapping[str, Any] | None" = None) -> None:
        self.system = system
        self.tables: Mapping[str, Any] = system.tables if tables is None else tables

    def simulation_numbers(self, run: "Outcome", found: Summary) -> Summary:  # noqa: ARG002
        """Further numbers of any run, beside those in `found`."""
        return {}

    def record_numbers(self, run: "Run") -> Summary:  # noqa: ARG002
        """Further numbers that need the recorded rows."""
        return {}

    def closed_forms(self, found: Mapping[str, float | bool]) -> Summary:  # noqa: ARG002
        """Analytic results to stand beside the simulated ones in `found`."""
        return {}

    def warnings(self, found: Mapping[str, float | bool]) -> Iterator[str]:  # noqa: ARG002
        """Warnings to read before the numbers of a summary, each in one line."""
        yield from ()

    def merits(self, found: Mapping[str, float | bool]) -> Iterator[str]:  # noqa: ARG002
        """Merits that the numbers of a summary show, each in one line."""
        yield from ()

    def bounds(self, found: Mapping[str, float | bool]) -> Iterator[Bound]:  # noqa: ARG002
        """What must lie within its bounds for the laws of its components to hold, at what a run has `found`."""
        yield from ()

    def charts(self, record: "Record") -> Iterable[tuple[Chart, Table]]:  # noqa: ARG002
        """Further figures of a report, each over the columns of a table."""
        return ()
