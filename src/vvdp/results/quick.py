"""A chart of any columns of a table, without a description of how to draw them."""

from collections.abc import Sequence

import numpy as np

from vvdp.results.chart import Chart, Line, Lines, Stroke, flag_panel
from vvdp.results.result import Column, Table

TIME = "time_s"
FEW = 60
"""Points of a line that are marked, one by one."""


def abscissa(table: Table) -> str:
    """The column that the others are drawn over: time, or the one axis; empty where there is neither."""
    if TIME in table.columns:
        return TIME
    return table.axes[0] if len(table.axes) == 1 else ""


def drawable(table: Table) -> list[str]:
    """Keys of the columns that can be drawn over the abscissa."""
    x = abscissa(table)
    return [key for key, column in table.columns.items() if x and key != x and column.kind is not None]


def is_flag(column: Column) -> bool:
    """Whether a column without unit has the values 0 and 1 and no others."""
    return column.kind is not None and column.kind.unit == "1" and set(np.unique(column.values)) == {0.0, 1.0}


def quick_panel(name: str, table: Table, key: str) -> Lines:
    """A column of the table called `name` over its abscissa."""
    if is_flag(table.columns[key]):
        return flag_panel(abscissa(table), {key: table.columns[key].label}, table=name)
    stroke = Stroke.MARKED if table.rows <= FEW else Stroke.SOLID
    return Lines(lines=(Line(x=abscissa(table), y=key, stroke=stroke),), table=name)


def stacked_chart(name: str, caption: str, panels: Sequence[Lines]) -> Chart:
    """Panels one above the other over one axis; each has a table of its own."""
    rows = sum(-(-len(panel.lines) // 4) if len(panel.lines) > 1 else 0 for panel in panels)
    height = 0.6 + 1.5 * len(panels) + 0.17 * rows
    return Chart(name=name, caption=caption, table=panels[0].table, panels=tuple(panels), height=max(height, 2.4))
