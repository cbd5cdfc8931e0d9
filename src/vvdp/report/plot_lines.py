"""A line of a printed figure: its points, its band, and bands in place of cycles that are too close."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from vvdp.base.arrays import Array, Rows
from vvdp.report.ripple import ripple
from vvdp.report.shown import column_unit, line_label, shown_values
from vvdp.results.chart import Line, Lines, Stroke
from vvdp.results.result import Table

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST_POINTS = 800
"""Points of a printed line; of more, the lowest and highest of each part are drawn.

A panel is 6.26 inches wide at most, and a line 1.3 points: 347 lines beside each other fill it, so 400 parts show all.
"""
PANEL = 6.26
"""Width of a panel as wide as the page [inch]."""
JOINED = (Stroke.SOLID, Stroke.DASHED, Stroke.DOTTED)
CLOSEST = 2.0
"""Widths of a line within which the two strokes of a cycle leave no gap."""
FLAG_HEIGHT = 0.7
"""Height of the bar of a flag in a row of 1."""
RIPPLE = "ripple"
"""Identifier of a band of cycles that are too close to be drawn."""


def kept_places(x: Array, y: Array, most: int = MOST_POINTS) -> Rows:
    """Places of at most about `most` points of a line that looks the same: lowest and highest in each stretch of x.

    Stretches are of one length, however densely they are recorded. Where x runs back, points count instead. A gap of y
    stays a gap.
    """
    if y.size <= most:
        return np.arange(y.size)
    runs_on = bool(np.all(np.diff(x) >= 0.0)) and x[-1] > x[0]  # False for nan too
    along = (x - x[0]) / (x[-1] - x[0]) if runs_on else np.linspace(0.0, 1.0, y.size)
    begins = np.unique((along * (most // 2)).astype(int).clip(max=most // 2 - 1), return_index=True)[1]
    sizes = np.diff(np.append(begins, y.size))
    kept = [np.zeros(1, int), np.full(1, y.size - 1), np.flatnonzero(np.isnan(y))]
    for sign in (1.0, -1.0):
        filled = np.where(np.isfinite(y), sign * y, np.inf)
        least = np.repeat(np.fmin.reduceat(filled, begins), sizes)
        places = np.flatnonzero(filled == least)
        stretch = np.repeat(np.arange(begins.size), sizes)[places]
        kept.append(places[np.unique(stretch, return_index=True)[1]])
    return np.unique(np.concatenate(kept))


def rows_in_view(panel: Lines, line: Line, table: Table) -> slice:
    """The rows of a line between the given ends of x and one beyond each, so that points are not spent outside."""
    x = np.asarray(table[line.x], float)
    if line.rows or np.any(np.diff(x) < 0.0) or np.any(np.isnan(x)):
        return slice(None)
    first = 0 if panel.left is None else max(int(np.searchsorted(x, panel.left)) - 1, 0)
    last = x.size if panel.right is None else int(np.searchsorted(x, panel.right, "right")) + 1
    return slice(first, last)


def draw_line(axes: "Axes", line: Line, of: tuple[Table, slice], look: tuple[str, Stroke], point: float) -> None:
    """Draws a line through rows of a table; `point` is as far as x runs along a printed point, 1/72 inch."""
    (table, rows), (colour, stroke) = of, look
    x, y = (shown_values(table, key, line.rows)[rows] for key in (line.x, line.y))
    label, most = line_label(line, table), MOST_POINTS // _abreast(axes)
    style: dict[str, Any] = {"color": colour, "linewidth": line.width, "label": label}
    if line.low:
        low, high = (shown_values(table, key, line.rows)[rows] for key in (line.low, line.high))
        _fill_band(axes, x, (low, high), colour)
    elif stroke in JOINED and (close := ripple(x, y, CLOSEST * line.width * point)):
        _fill_band(axes, close.x, (close.low, close.high), colour).set_gid(RIPPLE)
        axes.plot(close.x, close.mean, linestyle=stroke, **{**style, "label": None})
        y = close.rest
    if stroke is Stroke.STEMS:
        axes.vlines(x, 0.0, y, color=colour, linewidth=line.width, label=label)
        return
    kept = kept_places(x, y, most)
    x, y = x[kept], y[kept]
    if stroke is Stroke.POINTS:
        axes.plot(x, y, linestyle="none", marker="o", markersize=3.2, **style)
    elif stroke is Stroke.MARKED:
        axes.plot(x, y, marker="o", markersize=3.0, **style)
    elif stroke is Stroke.STEPS:
        axes.plot(x, y, drawstyle="steps-post", **style)
    else:
        axes.plot(x, y, linestyle=stroke, **style)


def draw_flag(axes: "Axes", line: Line, table: Table, colour: str, row: int) -> None:
    """Draws a bar in a row, counted from below, while a flag is 1."""
    x, y = (shown_values(table, key, line.rows) for key in (line.x, line.y))
    kept = kept_places(x, y)
    x, changes = x[kept], np.diff(y[kept] == 1.0, prepend=False, append=False)
    begins, ends = x[np.flatnonzero(changes)[::2]], x[np.flatnonzero(changes)[1::2].clip(max=x.size - 1)]
    place = (row + 0.5 - 0.5 * FLAG_HEIGHT, FLAG_HEIGHT)
    bars = list(zip(begins, ends - begins, strict=True))
    axes.broken_barh(bars, place, facecolor=colour, linewidth=0.0, label=line_label(line, table))


def _fill_band(axes: "Axes", x: Array, ends: tuple[Array, Array], colour: str) -> Any:
    """A pale band between two lines."""
    low, high = ends
    most = MOST_POINTS // _abreast(axes)
    kept = np.union1d(kept_places(x, low, most), kept_places(x, high, most))
    return axes.fill_between(x[kept], low[kept], high[kept], facecolor=colour, alpha=0.25, linewidth=0.0)


def _abreast(axes: "Axes") -> int:
    """How many panels stand in a row with this one."""
    spec = axes.get_subplotspec()
    return spec.get_gridspec().ncols if spec else 1


def printed_point(axes: "Axes", panel: Lines, owners: Sequence[Table]) -> float:
    """How far x runs along a printed point, as shown; 0 on a logarithmic scale, or without rows."""
    columns = [(own.columns[line.x], own[line.x]) for line, own in zip(panel.lines, owners, strict=True)]
    if not all(x.size for _, x in columns):
        return 0.0
    left = min(float(np.nanmin(x)) for _, x in columns) if panel.left is None else panel.left
    right = max(float(np.nanmax(x)) for _, x in columns) if panel.right is None else panel.right
    scale = column_unit(columns[0][0]).scale
    return 0.0 if panel.x_log else (right - left) * _abreast(axes) / (72.0 * PANEL) / scale
