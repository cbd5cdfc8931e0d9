"""The figures of any circuit's run, as data over its table of series."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple, TypeAlias

import numpy as np

from vvdp.base.arrays import Array, Rows
from vvdp.base.display import with_unit
from vvdp.base.kinds import FLOW, GAUGE_PRESSURE, NUMBER
from vvdp.results.chart import Bars, Chart, Colour, Level, Line, Lines, Panel, Stroke, flag_panel
from vvdp.results.quick import is_flag
from vvdp.results.result import Column, Table
from vvdp.runs.run import Detail, RecordedRun
from vvdp.sensing.encoder import FOR_GOOD
from vvdp.systems.faults import NamedFault

Groups: TypeAlias = Iterable[tuple[str, list[str]]]
"""Labels of panels and the columns that they show."""
SERIES = "series"
"""Name of the table that holds what is recorded."""
MOTIONS = ("speed", "position", "velocity")
"""What the names of columns of motions begin with."""
MOST_NAMED, MOST_PANELS = 6, 2
"""Lines of a panel, whose names stand above it, and sets of series of one quantity, by their range."""
FLAT = 0.05
"""Share of the height of a panel below which a series is flat beside another."""
STILL = 1e-3
"""Share of the largest value of a quantity below which a series counts as constant."""
Slice: TypeAlias = slice | Rows
"""Rows of a series."""


def run_charts(run: RecordedRun, series: Table) -> Iterator[Chart]:
    """Pressures and flows over the last periods and over the whole run, then everything that moves."""
    if run.times.size < 2:
        return
    part = run.detail() if run.detail().periods else run.fine()
    ends = (float(run.times[part.rows[0]]), float(run.times[part.rows[-1]]))
    groups = _pressures(series)
    if (shown := _moving_panels(series, groups, part.rows)).panels:
        seen = tuple(replace(panel, left=ends[0], right=ends[1]) for panel in shown.panels)
        yield _chart("detail", detail_words(run, part) + shown.flat, seen)
    if (shown := _moving_panels(series, groups)).panels:
        yield _chart("run", whole_words(run) + shown.flat, shown.panels)
    moved = [(what, [key for key in series.columns if key.startswith(f"{what}_")]) for what in MOTIONS]
    if (shown := _moving_panels(series, moved)).panels:
        yield _chart("motion", "Shafts and rods over the whole run." + shown.flat, shown.panels)
    for name, program in run.network.programs.items():
        yield from _program_chart(name, series) if program.type.is_drawn else ()


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
    if (shown := _moving_panels(series, groups)).panels:
        yield _chart(f"program-{program.replace('_', '-')}", words + shown.flat, shown.panels)


class MovingPanels(NamedTuple):
    """Panels, and in words the series that would be flat in them."""

    panels: tuple[Lines, ...]
    flat: str


def _moving_panels(series: Table, groups: Groups, rows: Slice = slice(None)) -> MovingPanels:
    """Panels of groups of series that move in these rows, flags in a panel of their own below."""
    panels: list[Lines] = []
    flat: list[str] = []
    zero: list[str] = []
    flags: dict[str, str] = {}
    for label, keys in groups:
        flags |= {key: series.columns[key].label for key in keys if is_flag(series.columns[key])}
        values = {key: np.asarray(series[key][rows], float) for key in keys if key not in flags}
        parts = split_by_range(values)
        panels += (_panel(series, label, part) for part in parts)
        drawn = {key for part in parts for key in part}
        least = STILL * max((float(abs(each).max()) for each in values.values()), default=0.0)
        for key in (key for key in values if key not in drawn):
            column, is_zero = series.columns[key], float(abs(values[key]).max()) <= least
            (zero if is_zero else flat).append(column.label if is_zero else _in_words(column, values[key]))
    if flags:
        panels.append(flag_panel("time_s", flags, "flags"))
    words = (f" {what}: {'; '.join(names)}." for what, names in (("Nearly constant", flat), ("Zero", zero)) if names)
    return MovingPanels(tuple(panels), "".join(words))


def _panel(series: Table, label: str, keys: Iterable[str]) -> Lines:
    return Lines(lines=tuple(Line(x="time_s", y=key, label=series.columns[key].label) for key in keys), label=label)


def _in_words(column: Column, values: Array) -> str:
    """The label of a series with its lowest and highest value, or with one where they do not differ in print."""
    kind = column.kind or NUMBER
    low, high = (with_unit(float(end), kind, 3) for end in (values.min(), values.max()))
    return f"{column.label} {low}" if low == high else f"{column.label} {low} to {high}"


def split_by_range(values: Mapping[str, Array]) -> list[list[str]]:
    """Series that one panel can show, in at most two sets; what would be flat in both is in none.

    A series is flat where its range is below `FLAT` of the ends of its panel, or below `STILL` of the largest value of
    all; where all are still, they are one set. Sets of more than `MOST_NAMED` are divided.
    """
    ends = {key: (float(each.min()), float(each.max())) for key, each in values.items()}
    still = STILL * max((max(-low, high) for low, high in ends.values()), default=0.0)
    rest = sorted(ends, key=lambda key: ends[key][0] - ends[key][1])
    rest = [key for key in rest if ends[key][1] - ends[key][0] > still]
    if not rest:
        return list(_equal_parts(list(values)))
    parts: list[list[str]] = []
    while rest and len(parts) < MOST_PANELS:
        part = [rest[0]]
        for key in rest[1:]:
            together = [ends[each] for each in (*part, key)]
            room = max(high for _, high in together) - min(low for low, _ in together)
            if all(high - low >= FLAT * room for low, high in together):
                part.append(key)
        rest = [key for key in rest if key not in part]
        parts.append([key for key in values if key in part])
    return [each for part in parts for each in _equal_parts(part)]


def _equal_parts(part: list[str]) -> Iterator[list[str]]:
    """A set in as few parts of one size as have at most `MOST_NAMED`; nothing of an empty one."""
    count = -(-len(part) // MOST_NAMED)
    for place in range(count):
        yield part[place * len(part) // count : (place + 1) * len(part) // count]


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
