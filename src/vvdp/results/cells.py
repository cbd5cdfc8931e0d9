"""Cells, heads and rows of a result as text: the same on the screen and on a page."""

import math

import numpy as np

from vvdp.base.display import display_unit, number, plain
from vvdp.base.kinds import FLAG, Kind
from vvdp.results.result import Column, Row, Table

MOST_ROWS = 150
"""Rows of a table that a page shows; the file has all."""


def row_unit(row: Row) -> str:
    """The unit in which the values of a line are shown."""
    return display_unit(row.kind).symbol if row.kind else ""


def shown_cell(value: float | str | None, kind: Kind | None, digits: int = 4) -> str:
    """A value [SI] as it stands in a table, without its unit; nothing where there is none."""
    if value is None or isinstance(value, str):
        return value or ""
    if kind is FLAG:
        return "" if math.isnan(value) else "yes" if value else "no"
    shown = display_unit(kind).from_si(value) if kind else value
    whole = kind is not None and kind.name == "count" and float(shown).is_integer()
    return f"{shown:.0f}" if whole else number(float(shown), digits)


def shown_columns(each: Table) -> list[str]:
    """The columns that a user is shown: those chosen, but axes along which nothing varies."""
    keys = [key for key in each.shown or each.columns if key in each.columns]
    return [key for key in keys if key not in each.axes or each.rows < 2 or np.unique(each[key]).size > 1]


def column_head(column: Column) -> str:
    """Label and unit of a column."""
    return column.label + (display_unit(column.kind).bracketed_symbol if column.kind else "")


def table_cell(each: Table, key: str, place: int) -> str:
    """A cell of a table as people read it: what was set as it was set, what was found to four digits."""
    column = each.columns[key]
    value, kind = column.values[place], column.kind
    if kind is not None and key in each.axes:
        return plain(float(display_unit(kind).from_si(value)), 4)
    return shown_cell(str(value) if kind is None else float(value), kind)


def thinned_rows(each: Table, most: int = MOST_ROWS) -> tuple[list[int], str]:
    """Rows that are shown, at most `most`, and how they were chosen, in words.

    Where a table goes through axes, every n-th value of one of them stays, the last among them, and so whole courses.
    """
    values = {key: np.unique(each[key], return_inverse=True) for key in each.axes if key in each.columns}
    counts = {key: found.size for key, (found, _) in values.items() if found.size > 1}
    if each.rows <= most:
        return list(range(each.rows)), ""
    if int(np.prod(list(counts.values()))) != each.rows:
        return [round(x) for x in np.linspace(0, each.rows - 1, most).tolist()], ""
    every = dict.fromkeys(counts, 1)
    while np.prod([-(-counts[key] // every[key]) for key in counts]) > most:
        every[max(counts, key=lambda key: -(-counts[key] // every[key]))] += 1
    kept = np.ones(each.rows, bool)
    for key, count in counts.items():
        kept &= (count - 1 - values[key][1]) % every[key] == 0
    words = [f"1 in {step} of the values of {each.columns[key].label}" for key, step in every.items() if step > 1]
    return np.flatnonzero(kept).tolist(), f", {' and '.join(words)}"
