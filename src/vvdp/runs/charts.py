"""The figures of any circuit's run, as data over its table of series."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from vvdp.base.display import with_unit
from vvdp.base.kinds import FLOW, GAUGE_PRESSURE, NUMBER
from vvdp.results.chart import Bars, Chart, Colour, Level, Line, Lines, Panel, Stroke
from vvdp.results.result import Table
from vvdp.runs.run import Detail, RecordedRun
from vvdp.sensing.encoder import FOR_GOOD
from vvdp.systems.faults import NamedFault

Groups: TypeAlias = Iterable[tuple[str, list[str]]]
"""Labels of panels and the columns that they show."""
SERIES = "series"
"""Name of the table that holds what is recorded."""
MOTIONS = ("speed", "position", "velocity")
"""What the names of columns of motions begin with."""
MOST_LINES = 24
"""Most lines of one panel."""


def run_charts(run: RecordedRun, series: Table) -> Iterator[Chart]:
    """Pressures and flows over the last periods and over the whole run, then everything that moves."""
    if run.times.size < 2:
        return
    part = run.detail() if run.detail().periods else run.fine()
    ends = (float(run.times[part.rows[0]]), float(run.times[part.rows[-1]]))
    if panels := tuple(_panels(series, _pressures(series))):
        seen = tuple(replace(panel, left=ends[0], right=ends[1]) for panel in panels)
        yield _chart("detail", detail_words(run, part), seen)
        yield _chart("run", whole_words(run), panels)
    moved = [(what, [key for key in series.columns if key.startswith(f"{what}_")]) for what in MOTIONS]
    if motion := tuple(_panels(series, moved)):
        yield _chart("motion", "Shafts and rods over the whole run.", motion)
    for program in run.network.programs:
        yield from _program_chart(program, series)


def loss_chart(table: Table, caption: str) -> Chart:
    """Bars of mean powers, largest first."""
    name, words, *values = table.columns
    rows = sorted(range(table.rows), key=lambda row: -table[values[0]][row])
    shown = tuple(row for row in rows if any(table[key][row] > 0.0 for key in values))
    bars = Bars(names=name, values=tuple(values), texts=words, rows=shown, label="mean power")
    height = 0.75 + 0.175 * len(shown) * len(values)
    return Chart(name=f"losses-{name}", caption=caption, table=f"powers-{name}", panels=(bars,), height=height)


def detail_words(run: RecordedRun, part: Detail) -> str:
    """The caption of a figure of the last periods."""
    count = part.periods
    periods = run.period if count == 1 else f"{count} {run.period}s"
    begin = f"The last {periods}" if count else "The end of the run"
    coarse = "" if run.is_fine else "; the run ended before its finely recorded part, so details are missing"
    return f"{begin}, recorded every {1e6 * part.interval:.4g} µs{coarse}."


def whole_words(run: RecordedRun) -> str:
    """The caption of a figure of the whole run."""
    begin = run.fine_from()
    words = f"The whole run, recorded every {1e3 * run.system.stepping.record_interval:.4g} ms"
    words += f" and every {1e6 * run.fine_interval:.4g} µs from {run.times[begin]:.4g} s on" if begin else ""
    return f"{words}; peaks between the records are not seen here but among the key numbers."


def _chart(name: str, caption: str, panels: tuple[Lines, ...]) -> Chart:
    rows = sum(-(-len(panel.lines) // 4) for panel in panels)
    return Chart(name=name, caption=caption, table=SERIES, panels=panels, height=0.5 + 1.45 * len(panels) + 0.17 * rows)


def _pressures(series: Table) -> list[tuple[str, list[str]]]:
    keys = series.columns.items()
    pressures = [key for key, column in keys if key.startswith("pressure_") and column.kind is GAUGE_PRESSURE]
    flows = [key for key, c in keys if key.startswith("flow_") and c.kind is FLOW and bool((c.values != 0.0).any())]
    return [("pressure", pressures), ("flow", flows)]


def _program_chart(program: str, series: Table) -> Iterator[Chart]:
    """The commands of a program, a panel for each kind; those that never change are in the caption with their value."""
    mine = {key: column for key, column in series.columns.items() if key.startswith(f"command_{program}_")}
    still = {key for key, column in mine.items() if np.all(column.values == column.values[0])}
    words = f"Commands of {program.replace('_', ' ')} over the whole run."
    if still:
        constant = (mine[key] for key in sorted(still))
        values = (f"{each.label} {with_unit(float(each.values[0]), each.kind or NUMBER)}" for each in constant)
        words += f" Constant: {', '.join(values)}."
    moving = [key for key in mine if key not in still]
    kinds = dict.fromkeys(mine[key].kind for key in moving)
    groups = (("", [key for key in moving if mine[key].kind is kind]) for kind in kinds)
    if panels := tuple(_panels(series, groups)):
        yield _chart(f"program-{program.replace('_', '-')}", words, panels)


def _panels(series: Table, groups: Groups) -> Iterator[Lines]:
    for label, keys in groups:
        lines = (Line(x="time_s", y=key, label=series.columns[key].label) for key in keys[:MOST_LINES])
        if keys:
            yield Lines(lines=tuple(lines), label=label)


def with_faults(chart: Chart, faults: Iterable[NamedFault]) -> Chart:
    """The chart with upright lines where faults begin and end, in its panels over time."""
    times = [(t, each.name.replace("_", " ")) for each in faults for t in (each.window.begin, each.window.end)]
    return replace(chart, panels=tuple(_with_times(panel, times) for panel in chart.panels))


def _with_times(panel: Panel, times: Iterable[tuple[float, str]]) -> Panel:
    if not isinstance(panel, Lines) or not any(line.x == "time_s" for line in panel.lines):
        return panel
    low, high = panel.left or 0.0, FOR_GOOD if panel.right is None else panel.right
    seen = [
        Level(value=t, label=name, upright=True, colour=Colour.RED, stroke=Stroke.DOTTED)
        for t, name in times
        if low < t < high
    ]
    return replace(panel, levels=(*panel.levels, *seen))


def upright(values: Iterable[float]) -> tuple[Level, ...]:
    """Thin upright lines, where periods begin."""
    return tuple(Level(value=float(v), upright=True, colour="#9aa3ac", stroke=Stroke.DOTTED) for v in values)
