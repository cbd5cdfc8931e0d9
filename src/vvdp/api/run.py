"""Runs for scripts and notebooks."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, replace
from functools import cached_property
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vvdp.base.display import key_suffix
from vvdp.base.errors import RunError
from vvdp.base.extras import require
from vvdp.base.files import result_directory
from vvdp.evaluation.overview import warnings
from vvdp.results.chart import Chart
from vvdp.results.result import Result
from vvdp.runs.findings import badges
from vvdp.runs.result import run_result
from vvdp.runs.run import RecordedRun, open_run
from vvdp.runs.simulate import recorded_run, save_run
from vvdp.runs.tables import record_table, screen_listings
from vvdp.simulation.run import simulate
from vvdp.systems.options import lasting
from vvdp.systems.system import System

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure


PUBLIC = (
    "carried_on", "command", "directory", "flows", "names", "number", "numbers", "output", "plot", "pressure", "result",
    "save", "state", "summary", "system", "times", "to_pandas", "to_xarray", "warnings",
)  # fmt: skip
"""The names that `dir()` of a run shows; all others are for the package."""


@dataclass(frozen=True, eq=False, repr=False)
class Run(RecordedRun):
    """A simulated run: `summary`, `numbers`, recorded series by name, and its result with tables and charts."""

    @cached_property
    def result(self) -> Result:
        """Everything that the report shows: listings, tables, charts, findings."""
        return run_result(self)

    @cached_property
    def warnings(self) -> tuple[str, ...]:
        """Warnings to read before the numbers are used, a sentence each, the gravest first.

        It says why a number of `summary` is nan, such as an efficiency while a line still empties.
        """
        return tuple(warnings(self.system, self.summary))

    @property
    def names(self) -> tuple[str, ...]:
        """The names that `plot` takes: of charts and of series, those of `to_xarray` included."""
        from vvdp.report.chosen import series_names

        return (*self.result.charts, *series_names(self._drawable))

    @cached_property
    def _drawable(self) -> Result:
        """The result with all that is recorded as a table, as `to_xarray` calls it."""
        return replace(self.result, tables={**self.result.tables, "record": record_table(self.record)})

    def to_xarray(self) -> "xarray.Dataset":
        """All recorded series as a dataset with the dimension `time` [s]; `units` and `long_name` with each.

        Names are "states.load_line", "outputs.pump_flow" and so on. Raises MissingExtraError without xarray.
        """
        require("xarray", "notebook", "an xarray dataset")
        import xarray

        variables = {
            name: (_dimensions(name, each.values.ndim), each.values, {"units": each.unit, "long_name": each.long_name})
            for name, each in self._series()
        }
        time = ("time", self.times, {"units": "s", "long_name": "time"})
        described = {"title": self.system.title, "system": self.system.name, "vvdp": str(self.meta.get("vvdp", ""))}
        found: xarray.Dataset = xarray.Dataset(variables, coords={"time": time}, attrs=described)
        return found

    def to_pandas(self) -> "pandas.DataFrame":
        """All recorded series of one number each, over the time [s]; the names end with the SI unit."""
        import pandas

        columns = {
            name + (key_suffix(each.kind) if each.kind else ""): each.values
            for name, each in self._series()
            if each.values.ndim == 1
        }
        found: pandas.DataFrame = pandas.DataFrame(columns, index=pandas.Index(self.times, name="time_s"))
        return found

    def plot(self, *names: str) -> "Figure":
        """A figure of charts or series by name; the course of the run without names.

        `names` shows all of them. Raises ConfigError for a name that is neither, or charts without a common axis.
        """
        from vvdp.report.chosen import chosen_chart
        from vvdp.report.plot import new_figure

        result = self._drawable
        return new_figure(chosen_chart(result, names or tuple(result.charts)[:1]), result.tables)

    def carried_on(self, system: System, *, until: str | float, stop: Callable[[], bool] | None = None) -> "Run":
        """The run that goes on where this one has ended, to the time `until`, with the values of `system`.

        Time, state, commands and memories of programs go on; means and balances start again. Where this run ended on a
        sample, states are to the last bit those of a run without a break. `stop` as of `System.run`. Raises RunError
        where the circuit is another one, or this run was read from a directory.
        """
        if self.done is None:
            raise RunError("a run that was read from a directory cannot be carried on: its memories were not kept")
        text = until if isinstance(until, str) else f"{until!r} s"
        longer = system.read_from(lasting(system.table, text))
        if not longer.stepping.until > self.done.end:
            raise RunError(
                f"until: {longer.stepping.until:g} s must be greater than {self.done.end:g} s, where the run ends"
            )
        done = simulate(longer.model, longer.case, longer.stepping, continue_from=self.done, stop=stop)
        found = recorded_run(longer, done)
        return Run(**{each.name: getattr(found, each.name) for each in fields(found)})

    def save(self, directory: str | Path, *, report: bool = True, force: bool = False) -> Path:
        """Writes the run, with its report, as `vvdp run --out` does; gives the directory.

        Raises ConfigError where that exists already, without `force`.
        """
        from vvdp.report.report import write_report

        with result_directory(Path(directory), force=force) as folder:
            save_run(folder, self)
            if report:
                write_report(folder)
        return Path(directory)

    def _series(self) -> Iterator[tuple[str, Any]]:
        for group, members in self.record.groups.items():
            for path, series in members.items():
                yield f"{group}.{path}", series

    def __dir__(self) -> list[str]:
        return [*PUBLIC]

    def __repr__(self) -> str:
        place = f" in {self.directory}" if self.directory else ""
        reached = f"{self.number('duration_s'):.4g} s, {self.times.size} rows"
        words = f"<Run of {self.system.name}{place}: {reached}, {', '.join(each.words for each in badges(self))}>"
        return "\n".join((words, *(f"warning: {each}" for each in self.warnings)))

    def _repr_html_(self) -> str:
        from vvdp.report.notebook import Step, live_frame
        from vvdp.report.result_page import listing_html

        state = " · ".join(escape(badge.words) for badge in badges(self))
        chart = chart_on_view(self)
        frame = live_frame([Step("", chart, self.result.tables)]) if chart else ""
        listings = "".join(map(listing_html, screen_listings(self)))
        told = "".join(f"<p>warning: {escape(each)}</p>" for each in self.warnings)
        return f"<b>{escape(self.system.title)}</b><p>{state}</p>{told}{frame}{listings}"


def chart_on_view(run: Run) -> Chart | None:
    """The first chart of a run that can be live; None where it has none."""
    from vvdp.report.interactive import is_live

    return next(filter(is_live, run.result.charts.values()), None)


def open_directory(directory: str | Path, *, trust: str = "") -> Run | Result:
    """The content of a directory: a `Run`, or the `Result` of any other verb.

    `trust` is a module of your own, by name or file, that may be run to draw the circuit again. Raises ConfigError
    where the directory holds neither, or has changed since it was written.
    """
    from vvdp.results.store import is_result, read_result

    place = Path(directory)
    if is_result(place):
        return read_result(place)
    found = open_run(place, trust)
    return Run(**{each.name: getattr(found, each.name) for each in fields(found)})


def _dimensions(name: str, count: int) -> tuple[str, ...]:
    return ("time", *(f"{name}.{axis}" for axis in range(1, count)))
