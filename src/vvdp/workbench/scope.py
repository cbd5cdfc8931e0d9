"""The scope of a page's own: any recorded series, added by name, over the time of the run."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from vvdp.report.chosen import series_names
from vvdp.report.shown import column_unit
from vvdp.results.chart import Chart, Lines
from vvdp.results.quick import TIME, abscissa, quick_panel, stacked_chart
from vvdp.results.result import Result, Table
from vvdp.runs.run import RecordedRun
from vvdp.runs.tables import record_table

NAME = "series"
"""The name of the scope among the charts."""
RECORD = "record"


def listed_series(run: RecordedRun, tables: Mapping[str, Table]) -> list[tuple[str, str]]:
    """Name and label of each series over time that a scope can show."""
    every = _every(run, tables)
    return [(name, every[table].columns[key].label) for name, (table, key) in _series_places(every).items()]


def own_scope(
    run: RecordedRun, tables: Mapping[str, Table], names: Sequence[str]
) -> tuple[list[Chart], dict[str, Table]]:
    """The scope of the series `names` with the tables that it draws; names of nothing recorded are left out.

    Series of one unit share a panel. It shows what the report shows first: the last periods.
    """
    every = _every(run, tables)
    known = _series_places(every)
    panels: dict[str, Lines] = {}
    for table, key in dict.fromkeys(known[name] for name in names if name in known):
        column = every[table].columns[key]
        unit = column_unit(column).symbol
        panel = panels.get(unit, Lines(lines=(), label=column.kind.name if column.kind else ""))
        lines = (replace(line, table=table) for line in quick_panel(table, every[table], key).lines)
        panels[unit] = replace(panel, lines=(*panel.lines, *lines))
    if not panels:
        return [], every
    left, right = run.times[run.detail().rows[[0, -1]]]
    shown = [
        replace(panel, left=float(left), right=float(right), table=panel.lines[0].table) for panel in panels.values()
    ]
    return [stacked_chart(NAME, "Series added by name.", shown)], every


def _every(run: RecordedRun, tables: Mapping[str, Table]) -> dict[str, Table]:
    return {**tables, RECORD: record_table(run.record)}


def _series_places(tables: Mapping[str, Table]) -> dict[str, tuple[str, str]]:
    """Table and column of each series over time, by its name."""
    over_time = {name for name, table in tables.items() if abscissa(table) == TIME}
    found = series_names(Result(verb="run", title="", system="", tables=tables))
    return {name: place for name, place in found.items() if place[0] in over_time}
