"""A chart as a printed figure: SVG for the page, PNG for other documents; drawn again it has the same bytes."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import DisplayUnit, plain
from vvdp.report.drawing import STYLE, Drawn, draw_figure, empty_figure
from vvdp.report.plot_lines import RIPPLE, draw_flag, draw_line, printed_point, rows_in_view
from vvdp.report.shown import ORDER, axis_label, column_unit, line_columns, line_label, line_looks, shown_values
from vvdp.results.chart import Bars, Chart, Colour, Dots, Field, Level, Lines, Panel, Stroke
from vvdp.results.result import Table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WITH_MARKS = (Stroke.POINTS, Stroke.MARKED, Stroke.STEMS)
"""Strokes that would be cut in half at the edge of a panel."""
MOST_ABOVE = 6
"""Names of lines that stand above a panel; more stand beside it."""
CLOSE_CYCLES = "A band with a line in it: cycles too close to be drawn, from lowest to highest, and their mean."
BESIDE = 4
"""Names of bars that stand beside each other above a panel."""
LEFT, RIGHT, BELOW, ABOVE, GAP, LETTER = 0.72, 0.12, 0.42, 0.2, 0.08, 0.062
"""Room beside, below and above stacked panels, between them, and for a letter of a bar's name [inch]."""
LETTERS, STROKE_LETTERS = 105, 7
"""Letters of the names of lines that stand in one row above panels across the page; a line's stroke is as wide as 7."""
ROW, NAMED = 1.25, 0.17
"""Height of a row of panels on paper, with the words at its axes, and of a row of names above it [inch]."""
MOST_TICKS = 5
"""Steps between numbers at an axis of x of panels in rows, which are as narrow."""
MOST_LETTERS = 24
"""Letters in a line of the words at an axis of y that is as short as panels in rows have it."""
IN_PAIRS = (2, 4)
"""Panels of which two stand in a row on paper; of other numbers three do."""
EDGE = 0.07
"""Of the width and height of a picture: closer to its edge no label of a contour stands."""


def draw_chart(chart: Chart, tables: Mapping[str, Table]) -> Drawn:
    """The printed figure of a chart over the tables of its result; its caption explains bands of close cycles."""
    has_ripple: list[bool] = []

    def fill(figure: "Figure") -> None:
        fill_figure(figure, chart, tables)
        has_ripple.append(bool(figure.findobj(lambda each: each.get_gid() == RIPPLE)))

    drawn = draw_figure(chart.name, chart.caption, chart.height, fill)
    return replace(drawn, caption=f"{chart.caption} {CLOSE_CYCLES}".strip()) if has_ripple[0] else drawn


def paper_chart(chart: Chart, tables: Mapping[str, Table]) -> Chart:
    """A chart as it is printed: panels of lines over one axis of x in rows of two or three.

    Panels with their names beside them need the whole width and stay one above the other.
    """
    count = len(chart.panels)
    lines = [panel for panel in chart.panels if isinstance(panel, Lines) and not _is_beside(panel) and not panel.equal]
    is_stack = not chart.side_by_side and not chart.columns
    if len(lines) < count or not is_stack or len({panel.lines[0].x for panel in lines}) > 1:
        return chart
    columns = min(count, 2 if count in IN_PAIRS else 3)
    names = [_names(panel, tables[panel.table or chart.table]) for panel in lines]
    rows = [-(-len(each) // _names_abreast(each, columns)) for each in names]
    named = sum(max(rows[begin : begin + columns]) for begin in range(0, count, columns))
    height = BELOW + ROW * -(-count // columns) + NAMED * named
    return replace(chart, columns=columns, one_x=True, height=height)


def _names_abreast(names: Sequence[str], columns: int) -> int:
    """How many names of lines stand beside each other above a panel, of which `columns` stand in a row."""
    longest = max(map(len, names), default=0) + STROKE_LETTERS
    return max(1, min(len(names), LETTERS // columns // longest))


def new_figure(chart: Chart, tables: Mapping[str, Table]) -> "Figure":
    """A chart as a Matplotlib figure of its own, for a notebook or to change and save."""
    import matplotlib as mpl

    style: Any = STYLE
    with mpl.rc_context(style):
        figure = empty_figure(chart.height)
        fill_figure(figure, chart, tables)
    return figure


def fill_figure(figure: "Figure", chart: Chart, tables: Mapping[str, Table]) -> None:
    """Draws a chart into a Matplotlib figure."""
    count, heights = len(chart.panels), [panel.height for panel in chart.panels]
    if chart.columns:
        _fill_rows(figure, chart, tables)
        return
    if chart.side_by_side:
        one_scale = chart.share and all(not isinstance(panel, Bars) or panel.base is None for panel in chart.panels)
        grid = figure.subplots(1, count, squeeze=False, sharex=one_scale, sharey=chart.share, width_ratios=heights)[0]
    else:
        grid = figure.subplots(count, 1, squeeze=False, sharex=count > 1, height_ratios=heights)[:, 0]
    common = _has_common_legend(chart, tables)
    for place, (axes, panel) in enumerate(zip(grid, chart.panels, strict=True)):
        _draw_panel(axes, panel, tables[panel.table or chart.table], tables)
        if isinstance(panel, Lines) and not common and _names(panel, tables[panel.table or chart.table]):
            _legend(axes, panel, columns=2 if chart.side_by_side else 4)
        if not chart.side_by_side and place < count - 1:
            axes.set_xlabel("")
        if chart.side_by_side and chart.share and place:
            axes.set_ylabel("")
    if common:
        _common_legend(figure, grid, chart.panels)
    elif not chart.side_by_side and not any(_is_beside(panel) for panel in chart.panels):
        _stack(figure, grid, chart, tables)
    elif not chart.side_by_side:
        figure.align_ylabels()


def _fill_rows(figure: "Figure", chart: Chart, tables: Mapping[str, Table]) -> None:
    """Small panels in rows; those with a panel below or to the left leave the words at their axes to it."""
    count = len(chart.panels)
    columns = min(chart.columns, count)
    rows = -(-count // columns)
    grid = figure.subplots(rows, columns, squeeze=False, sharex=chart.share or chart.one_x, sharey=chart.share)
    common = _has_common_legend(chart, tables)
    for place, (axes, panel) in enumerate(zip(grid.flat, chart.panels, strict=False)):
        table = tables[panel.table or chart.table]
        _draw_panel(axes, panel, table, tables)
        axes.set_ylabel("" if place % columns and chart.share else fill(axes.get_ylabel(), MOST_LETTERS))
        if place + columns < count and (chart.share or chart.one_x):
            axes.set_xlabel("")
        else:
            axes.tick_params(axis="x", labelbottom=True)
        if isinstance(panel, Lines) and not panel.x_log:
            axes.locator_params(axis="x", nbins=MOST_TICKS)
        if chart.one_x and not common and isinstance(panel, Lines) and (names := _names(panel, table)):
            _legend(axes, panel, columns=_names_abreast(names, columns))
    for axes in grid.flat[count:]:
        axes.set_visible(False)
    if common:
        _common_legend(figure, list(grid.flat[:count]), chart.panels)


def _stack(figure: "Figure", grid: Sequence["Axes"], chart: Chart, tables: Mapping[str, Table]) -> None:
    """Places panels one above the other by known sizes [inch]; measuring each text would take half of the time."""
    width, height = figure.get_size_inches()
    named = [_named_rows(p, tables[p.table or chart.table]) for p in chart.panels]
    longest = max(
        (len(str(n)) for p in chart.panels if isinstance(p, Bars) for n in tables[p.table or chart.table][p.names]),
        default=0,
    )
    left = max(LEFT, 0.15 + LETTER * longest)
    above = [ABOVE * max(each, bool(panel.title)) + GAP for each, panel in zip(named, chart.panels, strict=True)]
    free = height - BELOW - sum(above)
    top, heights = height, sum(panel.height for panel in chart.panels)
    figure.set_layout_engine("none")
    for axes, panel, room in zip(grid, chart.panels, above, strict=True):
        tall = free * panel.height / heights
        top -= room + tall
        axes.set_position((left / width, top / height, (width - left - RIGHT) / width, tall / height))
        axes.yaxis.set_label_coords(-0.8 * left / (width - left - RIGHT), 0.5)


def _named_rows(panel: Panel, table: Table) -> int:
    """Rows that the names of lines and bars take above a panel."""
    if isinstance(panel, Lines):
        names = _names(panel, table)
        levels = {level.label for level in panel.levels if level.label} if names else set()
        return -(-(len(names) + len(levels)) // 4)
    return -(-len(panel.values) // BESIDE) if isinstance(panel, Bars) and panel.stacked else 1


def _is_beside(panel: Panel) -> bool:
    """Whether the names of the lines stand beside a panel."""
    return isinstance(panel, Lines) and (bool(panel.legend) or len(panel.lines) > MOST_ABOVE)


def _draw_panel(axes: "Axes", panel: Panel, table: Table, tables: Mapping[str, Table]) -> None:
    if isinstance(panel, Lines):
        _draw_lines(axes, panel, table, tables)
    elif isinstance(panel, Bars) and panel.stacked:
        _draw_stacked_bars(axes, panel, table)
    elif isinstance(panel, Bars):
        _draw_bars(axes, panel, table)
    elif isinstance(panel, Dots):
        _draw_dots(axes, panel, table)
    else:
        _draw_field(axes, panel, table)
    if panel.title:
        axes.set_title(panel.title, loc="right" if isinstance(panel, Lines) else "left", pad=4.0)


def _names(panel: Lines, table: Table) -> tuple[str, ...]:
    names = tuple(line_label(line, table) for line in panel.lines)
    first = panel.lines[0]
    if names == (panel.label or ("" if first.table else table.columns[first.y].label),) and not panel.legend:
        return ()  # the axis has the name already
    return names if len(set(names)) > 1 or panel.legend or any(line.label for line in panel.lines) else ()


def _has_common_legend(chart: Chart, tables: Mapping[str, Table]) -> bool:
    """Whether one legend serves all panels: each names its lines, and one of them has the names of all."""
    names = [
        set(_names(panel, tables[panel.table or chart.table])) if isinstance(panel, Lines) else set()
        for panel in chart.panels
    ]
    return len(names) > 1 and all(names) and max(names, key=len) == set.union(*names)


def _common_legend(figure: "Figure", grid: Sequence["Axes"], panels: Sequence[Panel]) -> None:
    found = {label: line for axes in grid for line, label in zip(*axes.get_legend_handles_labels(), strict=True)}
    title = next((panel.legend for panel in panels if isinstance(panel, Lines) and panel.legend), None)
    if title or len(found) > MOST_ABOVE:
        place: dict[str, Any] = {"loc": "outside right center", "title": title, "alignment": "left"}
    else:
        place = {"loc": "outside upper left", "ncols": 4}
    figure.legend(list(found.values()), list(found), **place)


def _draw_lines(axes: "Axes", panel: Lines, table: Table, tables: Mapping[str, Table]) -> None:
    owners = [tables[line.table] if line.table else table for line in panel.lines]
    point = printed_point(axes, panel, owners)
    for row, (line, own, look) in enumerate(zip(panel.lines, owners, line_looks(panel), strict=True)):
        if line.stroke is Stroke.FLAG:
            draw_flag(axes, line, own, look[0], row)
            axes.set_yticks([])
        else:
            draw_line(axes, line, (own, rows_in_view(panel, line, own)), look, point)
    y = line_columns(panel, table, tables)
    x = (tables[panel.lines[0].table] if panel.lines[0].table else table).columns[panel.lines[0].x]
    for level in panel.levels:
        _draw_level(axes, level, column_unit(x if level.upright else y[0]))
    axes.set_xlabel(axis_label([x], panel.x_label))
    axes.set_ylabel(axis_label(y, panel.label))
    if panel.x_log:
        _log_scale(axes)
    if panel.y_log:
        axes.set_yscale("log")
    _set_ends(axes.set_xlim, (panel.left, panel.right), column_unit(x))
    _set_ends(axes.set_ylim, (panel.low, panel.high), column_unit(y[0]))
    if panel.left is None and panel.right is None and not panel.x_log:
        axes.margins(x=0.02 if any(line.stroke in WITH_MARKS for line in panel.lines) else 0.0)
    if panel.equal:
        axes.set_aspect("equal", adjustable="datalim")


def _log_scale(axes: "Axes") -> None:
    """A logarithmic scale of x with plain numbers at 1, 2, 5, 10 ..."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axes.set_xscale("log")
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: plain(value, 3)))
    axes.xaxis.set_minor_formatter(NullFormatter())


def _draw_level(axes: "Axes", level: Level, unit: DisplayUnit) -> None:
    draw = axes.axvline if level.upright else axes.axhline
    draw(
        unit.from_si(level.value), color=level.colour, linestyle=level.stroke, linewidth=0.9, label=level.label or None
    )


ROOM = 0.05
"""Share of the longest bar from which on a part of it has room for its value."""


def _set_ends(set_ends: Any, ends: Iterable[float | None], unit: DisplayUnit) -> None:
    given = [None if end is None else unit.from_si(end) for end in ends]
    if given != [None, None]:
        set_ends(*given)


def _legend(axes: "Axes", panel: Lines, columns: int) -> None:
    if _is_beside(panel):
        axes.legend(loc="center left", bbox_to_anchor=(1.02, 0.5), title=panel.legend or None, alignment="left")
    else:
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.02), ncols=columns)


def _draw_bars(axes: "Axes", panel: Bars, table: Table) -> None:
    rows = list(panel.rows) or list(range(table.rows))
    names = [str(table[panel.names][row]) for row in rows][::-1]
    over = panel.base is not None
    base = column_unit(table.columns[panel.values[0]]).from_si(panel.base or 0.0)
    width = 0.72 if over else 0.72 / len(panel.values)
    for place, key in enumerate(panel.values):
        values = shown_values(table, key)[rows][::-1]
        shift = 0.0 if over else (0.5 * (len(panel.values) - 1) - place) * width
        label = panel.labels[place] if panel.labels else table.columns[key].label
        colour = panel.colours[place] if panel.colours else ORDER[place % len(ORDER)]
        bars = axes.barh(
            np.arange(len(rows)) + shift, np.nan_to_num(values - base), 0.9 * width, base, color=colour, label=label
        )
        least = 0.02 * np.ptp(np.nan_to_num([shown_values(table, each)[rows] for each in panel.values], nan=base))
        told = np.isfinite(values) & ((not over) | (np.abs(values - base) > least))
        dust = 1e-3 * np.max(np.abs(values), initial=0.0, where=np.isfinite(values))
        shown = np.where(np.abs(values) < dust, 0.0, values)
        texts = [plain(value, 3) if is_told else "" for value, is_told in zip(shown, told, strict=True)]
        if panel.texts and len(panel.values) == 1:
            texts = [str(table[panel.texts][row]) for row in rows][::-1]
        axes.bar_label(bars, texts, padding=3, fontsize=7.0, color=Colour.INK)
    if over:
        axes.axvline(base, color=Colour.INK, linewidth=0.9)
    _finish_bars(axes, panel, names, axis_label([table.columns[key] for key in panel.values], panel.label))


def _draw_stacked_bars(axes: "Axes", panel: Bars, table: Table) -> None:
    """Bars that follow one another, each with its value if there is room for it."""
    rows = list(panel.rows) or list(range(table.rows))
    names = [str(table[panel.names][row]) for row in rows][::-1]
    parts = [np.clip(np.nan_to_num(shown_values(table, key)[rows][::-1]), 0.0, None) for key in panel.values]
    ends = np.sum(parts, axis=0)
    done = np.zeros(len(rows))
    for place, (key, values) in enumerate(zip(panel.values, parts, strict=True)):
        label = panel.labels[place] if panel.labels else table.columns[key].label
        colour = panel.colours[place] if panel.colours else ORDER[place % len(ORDER)]
        bars = axes.barh(np.arange(len(rows)), values, 0.65, done, color=colour, label=label)
        texts = [plain(value, 3) if value > ROOM * np.max(ends) else "" for value in values]
        axes.bar_label(bars, texts, label_type="center", fontsize=6.75, color=_ink_on(colour))
        done = done + values
    for place, (end, row) in enumerate(zip(ends, rows[::-1], strict=True)):
        words = str(table[panel.texts][row]) if panel.texts else plain(end, 3)
        axes.annotate(words, (end, place), (3, 0), textcoords="offset points", va="center", fontsize=7.0)
    _finish_bars(axes, panel, names, axis_label([table.columns[key] for key in panel.values], panel.label))


def _ink_on(colour: str) -> str:
    """Black or white, whichever is easier to read on a colour."""
    red, green, blue = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
    return Colour.INK if 0.3 * red + 0.59 * green + 0.11 * blue > 130.0 else "#ffffff"


def _finish_bars(axes: "Axes", panel: Bars, names: Sequence[str], label: str) -> None:
    """Names, ends and legend of a panel of bars."""
    axes.set_yticks(range(len(names)), names)
    axes.set_xlabel(label)
    axes.grid(axis="y", visible=False)
    axes.tick_params(axis="y", length=0)
    spans = [each.dataLim for each in axes.get_shared_x_axes().get_siblings(axes)]
    low, high = min(span.x0 for span in spans), max(span.x1 for span in spans)
    if panel.base is None:
        room = 1.5 if panel.stacked else 1.3
        axes.set_xlim(room * min(low, 0.0), room * max(high, 1e-12))
    else:
        room = 0.6 * (high - low)
        axes.set_xlim(low - room, high + room)
        axes.locator_params(axis="x", nbins=3)
    spec = axes.get_subplotspec()
    is_shared = len(axes.get_shared_y_axes().get_siblings(axes)) > 1
    if len(panel.values) > 1 and is_shared and (spec is None or spec.is_first_col()):
        axes.figure.legend(loc="outside upper right", ncols=2, handlelength=1.0)
    elif len(panel.values) > 1 and not is_shared:
        above = 1.12 if panel.title else 1.0
        columns = BESIDE if panel.stacked else 2
        axes.legend(loc="lower left", bbox_to_anchor=(0.0, above), ncols=columns, handlelength=1.0)


def _draw_dots(axes: "Axes", panel: Dots, table: Table) -> None:
    rows = list(panel.rows) or list(range(table.rows))
    column = table.columns[panel.value]
    least = float(column_unit(column).from_si(panel.least))
    values = shown_values(table, panel.value)[rows]
    highest = float(np.max(values[np.isfinite(values)], initial=10.0 * least))
    for place, (row, value) in enumerate(zip(reversed(rows), values[::-1], strict=True)):
        if value < least:
            axes.plot(1.25 * least, place, "<", color=Colour.LOAD, markersize=4.0)
            continue
        axes.plot(value, place, "o", color=Colour.LOAD, markersize=3.6)
        if panel.low:
            ends = [max(float(shown_values(table, key)[row]), least) for key in (panel.low, panel.high)]
            axes.plot(ends, [place, place], color=Colour.LOAD, linewidth=3.2, alpha=0.3, solid_capstyle="round")
            highest = max(highest, *ends)
    axes.set_xscale("log")
    axes.set_xlim(least, max(axes.get_xlim()[1] if axes.get_xlim()[0] == least else 0.0, 2.0 * highest))
    axes.xaxis.set_major_formatter(lambda value, _: plain(value, 3))
    axes.set_yticks(range(len(rows)), [str(table[panel.names][row]) for row in reversed(rows)])
    axes.set_ylim(-0.7, len(rows) - 0.3)
    axes.set_xlabel(axis_label([column]))
    axes.grid(axis="y", visible=False)
    axes.tick_params(axis="y", length=0)


def _draw_field(axes: "Axes", panel: Field, table: Table) -> None:
    x, y, z = field_grid(panel, table, panel.z)
    steps = field_steps(panel, table)
    axes.set_facecolor("#e3e5e8")
    axes.grid(visible=False)
    values = np.ma.masked_invalid(z)
    axes.contourf(x, y, values, levels=steps, colors=field_colours(len(steps) - 1), extend="max")
    lines = axes.contour(x, y, values, levels=steps[1:-1], colors=Colour.INK, linewidths=0.5)
    for label in axes.clabel(lines, levels=steps[2:-1:2], fmt=lambda value: plain(value, 3), fontsize=6.75):
        place = axes.transAxes.inverted().transform(axes.transData.transform(label.get_position()))
        label.set_visible(not (np.any(place < EDGE) or np.any(place > 1.0 - EDGE)))
    if panel.hatch:
        heavy = np.nan_to_num(field_grid(panel, table, panel.hatch)[2])
        if heavy.min() <= 0.0 < heavy.max():
            hatched = axes.contourf(x, y, heavy, levels=[0.5, 1e9], colors="none", hatches=["////"])
            hatched.set_edgecolor("#ffffffb0")
            axes.contour(x, y, heavy, levels=[0.5], colors=Colour.INLET, linewidths=1.3)
    if panel.marks:
        x, y, marked = field_grid(panel, table, panel.marks)
        j, i = np.nonzero(np.nan_to_num(marked) > 0.0)
        axes.scatter(x[i], y[j], marker="x", s=10.0, color=Colour.RED, linewidths=0.9, clip_on=False, zorder=3)
    axes.set_xlabel(axis_label([table.columns[panel.x]]))
    axes.set_ylabel(axis_label([table.columns[panel.y]]))


def field_steps(panel: Field, table: Table) -> list[float]:
    """Levels of the contours, as shown."""
    if panel.steps:
        return [float(column_unit(table.columns[panel.z]).from_si(step)) for step in panel.steps]
    z = shown_values(table, panel.z, panel.rows)
    return [float(step) for step in np.linspace(np.nanmin(z), np.nanmax(z), 11)]


def field_colours(count: int) -> list[str]:
    """Colours between the contours, pale to dark."""
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    return [to_hex(colormaps["YlGnBu"](share)) for share in np.linspace(0.02, 0.72, count)]


def field_grid(panel: Field, table: Table, key: str) -> tuple[Array, Array, Array]:
    """The values of x and y, and `key` over them (rows of y), all as shown; nan where the table has no row."""
    x, y, z = (shown_values(table, name, panel.rows) for name in (panel.x, panel.y, key))
    (across, i), (up, j) = (np.unique(values, return_inverse=True) for values in (x, y))
    grid = np.full((up.size, across.size), np.nan)
    grid[j, i] = z
    return across, up, grid
