"""What a system may bring along beyond others: numbers, lines on the console, warnings, figures."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from vvdp.simulation.outcome import Outcome
    from vvdp.simulation.results import Results
    from vvdp.simulation.run import Run
    from vvdp.systems.system import System

Summary = dict[str, float | bool]


class Line(NamedTuple):
    """A line of the overview that a person is shown: what it is called, and keys of the summary that are added up.

    `closed_form` are keys of an analytic result beside it; `unit` is bar, lpm, rpm, or the SI unit of the keys.
    """

    label: str
    keys: tuple[str, ...]
    unit: str
    closed_form: tuple[str, ...] = ()


class OwnFigure(NamedTuple):
    """A figure that a report shows: name of its files, words below it, height [inch], and what fills it.

    `draw` is called with an empty `matplotlib.figure.Figure` as wide as the page.
    """

    name: str
    caption: str
    height: float
    draw: Callable[[Any], None]


class Extras:
    """What a system brings along beyond others: nothing, unless a subclass says more.

    A circuit names its own with `net.extras = MyExtras`; it is made with the system.
    """

    PERIOD = "period"
    """What passes between two marks of a run."""
    OVERVIEW: tuple[Line, ...] = ()
    """The lines of the overview; where there are none, nodes and components are shown."""

    CLOSED_FORMS: tuple[str, ...] = ()
    """Keys of what `closed_forms` gives."""

    def __init__(self, system: "System") -> None:
        self.system = system
        self.tables: Mapping[str, Any] = system.tables

    def simulated(self, run: "Outcome", found: Summary) -> Summary:  # noqa: ARG002
        """Further numbers of any run, beside those in `found`."""
        return {}

    def recorded(self, run: "Run") -> Summary:  # noqa: ARG002
        """Further numbers that need the recorded rows."""
        return {}

    def closed_forms(self, found: Mapping[str, float | bool]) -> Summary:  # noqa: ARG002
        """Analytic results to stand beside the simulated ones in `found`."""
        return {}

    def warnings(self, found: Mapping[str, Any]) -> Iterator[str]:  # noqa: ARG002
        """What a person has to know before the numbers of a summary, each in one line."""
        yield from ()

    def figures(self, results: "Results") -> Iterable[OwnFigure]:  # noqa: ARG002
        """Further figures of a report."""
        return ()
