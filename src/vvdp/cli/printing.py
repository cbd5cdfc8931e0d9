"""A result on the screen: title, conditions, listings, tables, findings."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING

from vvdp.cli.screen import console, grid, print_json, tell, typed_command, warn

if TYPE_CHECKING:
    from pathlib import Path

    from vvdp.cli.table import Grid
    from vvdp.results.result import Listing, Result, Table

MOST_ROWS = 30
"""Rows of a table that are printed; the file has all."""


def print_result(result: "Result", names: Sequence[str] | None = None) -> None:
    """Prints a result as a user wants it; `names` are the listings and tables to print, all but data by default."""
    from vvdp.results.result import Grade

    out = console()
    tell(": ".join(filter(None, (result.title, result.system))))
    for name, value in result.conditions.items():
        tell(f"  {name}: {value}")
    tell("")
    shown = [*result.listings, *(name for name, table in result.tables.items() if not table.is_data)]
    for name in shown if names is None else names:
        each = result.listings.get(name)
        out.print(listing_grid(each) if each else table_grid(name, result.tables[name]))
        if each and each.note:
            tell(each.note)
    for finding in result.findings:
        if finding.grade in (Grade.WARNING, Grade.BAD):
            title = f"{finding.title}: " if finding.title else ""
            warn(" ".join(filter(None, (title + finding.text, finding.remedy))))
        else:
            tell(finding.text)


def write_with_report(folder: "Path", result: "Result", system: str, *, no_report: bool) -> bool:
    """Writes a result with its resolved `system`, and the page unless `no_report`; shows whether that is there."""
    from vvdp.cli.report import RESULT, add_report
    from vvdp.results.store import write_result

    write_result(folder, result, system, typed_command())
    return not no_report and add_report(RESULT, folder)


def show_result(
    result: "Result",
    directory: "Path",
    *,
    json: bool,
    reported: bool,
    names: Sequence[str] | None = None,
    more: Mapping[str, object] = MappingProxyType({}),
) -> None:
    """Prints a result that stands in `directory`: as one JSON object, or `names` and findings for a user.

    `names` are the listings and tables to print, all listings by default; `more` stands in the JSON object only.
    """
    if json:
        print_json({**result.flat, **more, "out": str(directory)})
        return
    print_result(result, tuple(result.listings) if names is None else names)
    tell(f"results: {directory}")
    if reported:
        tell(f"report: {directory / 'report.html'}")


def listing_grid(listing: "Listing") -> "Grid":
    """A listing as a table of the screen."""
    from vvdp.results.cells import row_unit, shown_cell

    numeric, last = [listing.heads[place] for place in listing.numeric], listing.unit_place
    heads = [*listing.heads[:last], "unit", *listing.heads[last:]]
    found = grid("quantity", *heads, title=listing.title, right=numeric, ends=len(heads) - last)
    for row in listing.rows:
        cells = [shown_cell(value, row.kind) for value in row.values]
        found.add_row(("  " if row.is_part else "") + row.label, *cells[:last], row_unit(row), *cells[last:])
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
        found.add_row(*(table_cell(table, key, place) for key in keys))
    return found
