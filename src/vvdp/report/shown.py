"""How lines and columns are called and shown, in printed figures and in live ones."""

from collections.abc import Mapping, Sequence

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import DisplayUnit, display_unit
from vvdp.results.chart import Colour, Line, Lines, Stroke
from vvdp.results.result import Column, Table

ORDER = (Colour.LOAD, Colour.INLET, Colour.TANK, Colour.RELIEF, Colour.GREEN, Colour.RED, Colour.PURPLE, Colour.OLIVE)
"""Colours of lines that have none of their own."""
STROKES = (Stroke.SOLID, Stroke.DASHED, Stroke.DOTTED)


def line_label(line: Line, table: Table) -> str:
    """Label of a line; one of another table than that of its panel has a label of its own."""
    return line.label or table.columns[line.y].label


def line_columns(panel: Lines, table: Table, tables: Mapping[str, Table]) -> list[Column]:
    """The columns of y that a panel draws."""
    return [(tables[line.table] if line.table else table).columns[line.y] for line in panel.lines]


def axis_label(columns: Sequence[Column], label: str = "") -> str:
    """Label of an axis: `label`, or the label that the columns have in common, with the unit."""
    labels = list(dict.fromkeys(column.label for column in columns))
    kind = columns[0].kind
    words = label or (labels[0] if len(labels) == 1 else kind.name if kind else "")
    return words + column_unit(columns[0]).bracketed_symbol


def line_looks(panel: Lines) -> list[tuple[str, Stroke]]:
    """Colour and stroke of each line: one without a colour takes the next that is free, once all are taken dashed."""
    own = {line.colour for line in panel.lines}
    free = [colour for colour in ORDER if colour not in own] or list(ORDER)
    looks: list[tuple[str, Stroke]] = []
    turns = iter(range(len(panel.lines)))
    for line in panel.lines:
        if line.colour:
            looks.append((line.colour, line.stroke))
            continue
        turn, place = divmod(next(turns), len(free))
        stroke = STROKES[turn % len(STROKES)] if line.stroke is Stroke.SOLID else line.stroke
        looks.append((free[place], stroke))
    return looks


def column_unit(column: Column) -> DisplayUnit:
    """The unit in which a column is shown."""
    return display_unit(column.kind) if column.kind else DisplayUnit("", 1.0, 0.0)


def shown_values(table: Table, key: str, rows: tuple[int, ...] = ()) -> Array:
    """A column in the unit in which it is shown, at `rows` or all."""
    values = np.asarray(table[key], float)
    shown: Array = column_unit(table.columns[key]).from_si(values[list(rows)] if rows else values)
    return shown
