"""The recorded number behind each column of a report's table of series, so that a page can draw it again."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.network.nodes import HydraulicNode
from vvdp.report.interactive import is_live
from vvdp.report.shown import column_unit
from vvdp.results.chart import Chart, Lines
from vvdp.results.result import Result, Table
from vvdp.runs.charts import SERIES
from vvdp.runs.result import recorded_series
from vvdp.runs.run import RecordedRun
from vvdp.simulation.parts import example_outputs
from vvdp.simulation.record import Series
from vvdp.simulation.values import leaves


class Recorded(NamedTuple):
    """Where a number stands in the rows of a run ("time", "state", "command", "output"), and what is taken off it."""

    rows: str
    place: int
    less: float = 0.0


def recorded_columns(run: RecordedRun, courses: Callable[[RecordedRun], Mapping[str, Array]]) -> dict[str, Recorded]:
    """The courses of a run that are a recorded number, or one above a reference; no others.

    They are made once more from a record of other numbers, no two alike: numbers that are alike in the run are
    distinguished apart.
    """
    other = _with_other_numbers(run)
    nodes = run.network.nodes.values()
    datums = [0.0, *{node.oil.reference_pressure for node in nodes if isinstance(node, HydraulicNode)}]
    known = {
        (values - less).tobytes(): Recorded(rows, place, float(less))
        for rows, place, values in _rows(other)
        for less in datums
    }
    found = {key: known.get((values - 0.0).tobytes()) for key, values in courses(other).items()}
    return {key: each for key, each in found.items() if each is not None}


def table_courses(run: RecordedRun) -> dict[str, Array]:
    """The numbers over time of a report's table of series, by column."""
    columns = recorded_series(run).columns.items()
    return {key: np.asarray(column.values, float) for key, column in columns if column.kind is not None}


def _with_other_numbers(run: RecordedRun) -> RecordedRun:
    """The run with a record in which every number but the times is another one, by chance from 1 to 2."""
    chance = np.random.default_rng(1)

    def other(group: Mapping[str, Series]) -> dict[str, Series]:
        return {path: replace(each, values=chance.uniform(1.0, 2.0, each.values.shape)) for path, each in group.items()}

    record = run.record
    states, outputs, commands = (other(group) for group in (record.states, record.outputs, record.commands))
    return replace(run, record=replace(record, states=states, outputs=outputs, commands=commands))


def _rows(run: RecordedRun) -> Iterator[tuple[str, int, Array]]:
    """Every recorded number of which there is one: of which rows, its place in them, and its course."""
    case, record = run.system.case, run.record
    yield "time", 0, run.times
    for rows, value, series in (
        ("state", case.state, record.states),
        ("output", example_outputs(run.system.model, case), record.outputs),
        ("command", case.command, record.commands),
    ):
        place = 0
        for path, leaf, _ in leaves(value):
            if path in series and not np.ndim(leaf):
                yield rows, place, series[path].values
            place += int(np.size(leaf))


def followed_charts(result: Result, known: Mapping[str, Recorded]) -> dict[str, Any]:
    """Of each live chart over the series: the columns of its lines, panel by panel, that a page can draw again."""
    table = result.tables[SERIES]
    return {
        chart.name: [_lines(panel, table, known) if isinstance(panel, Lines) else [] for panel in chart.panels]
        for chart in result.charts.values()
        if is_live(chart) and _is_over_series(chart)
    }


def _is_over_series(chart: Chart) -> bool:
    return chart.table == SERIES and all(
        isinstance(panel, Lines)
        and not panel.table
        and all(line.x == "time_s" and not line.table for line in panel.lines)
        for panel in chart.panels
    )


def _lines(panel: Lines, table: Table, known: Mapping[str, Recorded]) -> list[Any]:
    found: list[Any] = []
    for line in panel.lines:
        unit, time = (column_unit(table.columns[key]) for key in (line.y, line.x))
        scales = {"y": [unit.scale, unit.datum], "x": [time.scale, time.datum]}
        found.append({"key": line.y, **scales} if line.y in known and not line.rows else None)
    return found
