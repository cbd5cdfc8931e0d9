"""A result on the screen: title, conditions, listings, tables, findings."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from vvdp.cli.screen import console, grid, tell, warn

if TYPE_CHECKING:
    from vvdp.cli.table import Grid
    from vvdp.results.result import Listing, Result, Table

MOST_ROWS = 30
"""Rows of a table that are printed; the file has all."""


def print_result(result: "Result", names: Sequence[str] | None = None) -> None:
    """Prints a result as a person wants it; `names` are the listings and tables to print, all but data by default."""
    from vvdp.results.result import Grade

    out = console()
    tell(": ".join(filter(None, (result.title, result.system))))
    for name, value in result.conditions.items():
        tell(f"  {name}: {value}")
    shown = [*result.listings, *(name for name, table in result.tables.items() if not table.is_data)]
    for name in shown if names is None else names:
        each = result.listings.get(name)
        out.print(listing_grid(each) if each else table_grid(name, result.tables[name]))
    for finding in result.findings:
        if finding.grade in (Grade.WARNING, Grade.BAD):
            warn(finding.text)
        else:
            tell(finding.text)


def listing_grid(listing: "Listing") -> "Grid":
    """A listing as a table of the screen."""
    from vvdp.results.cells import row_unit, shown_cell

    found = grid("quantity", *listing.heads, "unit", title=listing.title, right=listing.heads)
    for row in listing.rows:
        cells = (shown_cell(value, row.kind) for value in row.values)
        found.add_row(("  " if row.is_part else "") + row.label, *cells, row_unit(row))
    return found


def table_grid(name: str, table: "Table") -> "Grid":
    """A table of the screen, thinned where it is long."""
    from vvdp.results.cells import column_head, shown_columns, table_cell, thinned_rows

    keys = shown_columns(table)
    places, thinned = thinned_rows(table, MOST_ROWS)
    title = table.title
    if len(places) < table.rows:
        title += f" ({len(places)} of {table.rows} rows{thinned}; all are in {name}.csv)"
    heads = [column_head(table.columns[key]) for key in keys]
    right = tuple(head for head, key in zip(heads, keys, strict=True) if table.columns[key].kind)
    found = grid(*heads, title=title, right=right, keys=max(1, len([key for key in keys if key in table.axes])))
    for place in places:
        found.add_row(*(table_cell(table.columns[key], place) for key in keys))
    return found
