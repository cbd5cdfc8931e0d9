"""A figure of what a user names: charts and single series of a result, over one axis."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeAlias

import numpy as np

from vvdp.base.display import key_suffix, with_unit
from vvdp.base.errors import ConfigError, Fault, unusable
from vvdp.base.files import write_whole
from vvdp.base.kinds import TIME
from vvdp.base.manifest import open_directory
from vvdp.base.tables import suggestion
from vvdp.report.drawing import image
from vvdp.report.plot import fill_figure
from vvdp.results.chart import Chart, Lines, Panel
from vvdp.results.quick import drawable, quick_panel, stacked_chart
from vvdp.results.result import Result
from vvdp.results.store import is_result, read_result
from vvdp.runs.result import run_result
from vvdp.runs.run import open_run
from vvdp.runs.tables import record_table
from vvdp.runs.untold import untold_result
from vvdp.simulation.results import read_results
from vvdp.systems.own_modules import UntrustedModuleError

Ends: TypeAlias = tuple[float | None, float | None]
FORMS = (".png", ".svg", ".pdf")


def open_drawable(place: Path, trust: str = "") -> Result:
    """The result in a directory; of a run with all that it recorded, and nothing else where its circuit needs code that
    may not be run. `trust` is a module that may be. Raises ConfigError where there is no result.
    """
    directory = open_directory(place)
    if is_result(place):
        return read_result(directory)
    try:
        run = open_run(directory, trust)
    except UntrustedModuleError as problem:
        return untold_result(read_results(directory), str(problem))
    result = run_result(run)
    return replace(result, tables=dict(result.tables) | {"record": record_table(run.record)})


def series_names(result: Result) -> dict[str, tuple[str, str]]:
    """Table and column of every series that can be drawn, by its name: that of the column, without unit."""
    found: dict[str, tuple[str, str]] = {}
    for name, table in result.tables.items():
        for key in drawable(table):
            kind = table.columns[key].kind
            found.setdefault(key.removesuffix(key_suffix(kind)) if kind else key, (name, key))
    return found


def chosen_chart(result: Result, names: Sequence[str], ends: Ends = (None, None)) -> Chart:
    """The chart of all `names`, one panel below the other over one axis, from one of the `ends` [SI] to the other.

    Raises ConfigError for names of nothing that can be drawn, and for charts that have another axis than the first.
    """
    found = {name: _panels(result, name) for name in names}
    faults = [
        Fault("plot", 0, name, f"unknown{_suggestion(result, name)}") for name, panels in found.items() if not panels
    ]
    if faults:
        raise ConfigError(faults)
    if len(found) == 1 and names[0] in result.charts and ends == (None, None):
        return result.charts[names[0]]
    panels: list[Lines] = []
    for name, each in found.items():
        for panel in each:
            if not isinstance(panel, Lines) or (panels and panel.lines[0].x != panels[0].lines[0].x):
                raise unusable("plot", f"{name} has no time axis in common with the others; draw it alone")
            panels.append(panel)
    left, right = _common_ends(result, panels, ends)
    panels = [replace(panel, left=left, right=right) for panel in panels]
    return stacked_chart("-".join(found), ", ".join(found), panels)


def _common_ends(result: Result, panels: Sequence[Lines], ends: Ends) -> tuple[float, float]:
    """Ends of the axis [SI]: those asked for, else those of a panel that has some, else those of the first series.

    Raises ConfigError where nothing lies between those asked for.
    """
    first = panels[0]
    x = result.tables[first.table][first.lines[0].x]
    own = next(((p.left, p.right) for p in panels if p.left is not None), (None, None))
    usual = (float(np.nanmin(x)), float(np.nanmax(x)))
    left, right = (next(end for end in ends if end is not None) for ends in zip(ends, own, usual, strict=True))
    if ends != (None, None) and not (left < right and left < usual[1] and right > usual[0]):
        low, high = (with_unit(end, TIME) for end in usual)
        raise unusable(
            "plot", f"{with_unit(left, TIME)} to {with_unit(right, TIME)}; the result is from {low} to {high}"
        )
    return left, right


def _panels(result: Result, name: str) -> tuple[Panel, ...]:
    """The panels of a chart, or that of a series, with their tables; none where there is neither."""
    if chart := result.charts.get(name):
        return tuple(replace(panel, table=panel.table or chart.table) for panel in chart.panels)
    series = series_names(result)
    by_key = {key: (table, key) for table, key in series.values()}
    if name not in series and name not in by_key:
        return ()
    table, key = series.get(name) or by_key[name]
    words = next(short for short, place in series.items() if place == (table, key)).replace("_", " ").replace(".", ", ")
    return (replace(quick_panel(table, result.tables[table], key), label=words),)


def _suggestion(result: Result, name: str) -> str:
    known = [*result.charts, *series_names(result)]
    return suggestion(name, known) or "; `vvdp plot DIR --list` or `run.names` shows all names"


def series_labels(result: Result) -> Iterator[tuple[str, str, str]]:
    """Name, table and label of every series that can be drawn."""
    for name, (table, key) in series_names(result).items():
        yield name, table, result.tables[table].columns[key].label


def check_form(path: Path) -> str:
    """The form that the ending of a file asks for. Raises ConfigError where figures are not written in it."""
    if path.suffix.lower() not in FORMS:
        raise unusable(path, f"expected a name that ends with {', '.join(FORMS[:-1])} or {FORMS[-1]}")
    return path.suffix.lower().removeprefix(".")


def write_figure(path: Path, chart: Chart, result: Result) -> None:
    """Writes a chart over the tables of its result in the form that the ending of `path` asks for.

    Raises ConfigError for another ending, WriteError where the file cannot be written.
    """
    form = check_form(path)
    write_whole(path, image(chart.name, chart.height, lambda figure: fill_figure(figure, chart, result.tables), form))
