"""Effect of uncertain values, as a table and a picture: a bar for each value that has a range, the longest first."""

import re
import textwrap
from collections.abc import Mapping
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from vvdp.base.display import display_unit, key_suffix
from vvdp.base.kinds import Kind
from vvdp.base.tables import Sourced
from vvdp.evaluation.ranges import Ranges, range_text
from vvdp.results.cells import shown_cell
from vvdp.results.chart import Bars, Chart, Colour
from vvdp.results.result import Column, Listing, Result, Row, Section, Table

Known: TypeAlias = Mapping[str, tuple[Kind, str]]
"""Kind and label of numbers by key."""
RANGES, RESTS_ON, SPANS, ENDS = "ranges", "rests-on", "spans", "ends"
"""Names of the table, the chart and the listings."""
ALONE = "one value at a time, all others as they are"
MOST_BARS, LEAST_BAR, WIDEST_WORDS = 14, 0.05, 13
"""Values in the picture at most; the least share of the longest bar of a panel; letters in a line below it."""
WORDS = (
    "Each value was put to both ends of its range, alone; two values that lie elsewhere at once may move a number "
    "further."
)
CAPTION = (
    "What the results depend on: how far each number moves where one value lies at either end of its range, all others "
    "as they are. The upright line is the system as it is."
)


def result_with_ranges(result: Result, ranges: Ranges, known: Known, before: str) -> Result:
    """The result with the ranges of its numbers: listing, table, picture, and their section ahead of that `before`."""
    if not ranges.rows:
        return result
    charts = {RESTS_ON: range_chart(ranges, known)} if any(map(ranges.moves, ranges.nominal)) else {}
    section = Section(title="What the results depend on", words=(WORDS,), shows=(SPANS, *charts, ENDS))
    place = next((at for at, each in enumerate(result.sections) if each.title == before), len(result.sections))
    return replace(
        result,
        listings={**result.listings, SPANS: range_listing(ranges, known), ENDS: end_listing(ranges, known)},
        tables={**result.tables, RANGES: range_table(ranges, known)},
        charts={**result.charts, **charts},
        sections=(*result.sections[:place], section, *result.sections[place:]),
    )


def range_table(ranges: Ranges, known: Known) -> Table:
    """Every value that has a range, and each number at both of its ends; `known` has kind and label of the numbers."""
    columns = {
        "value": Column(np.array([value_words(row) for row in ranges.rows]), None, "value"),
        "setting": Column(np.array([row.setting for row in ranges.rows]), None, "setting"),
        "range": Column(np.array([range_text(row) for row in ranges.rows]), None, "range"),
        "status": Column(np.array([row.status for row in ranges.rows]), None, "status"),
        "bar": Column(np.array([f"{value_words(row)}\n{range_text(row)}" for row in ranges.rows]), None, "value"),
    }
    for key in ranges.nominal:
        ends, (kind, label) = ranges.ends[key], known[key]
        for place, end in enumerate(("low", "high")):
            columns[_column(key, kind, end)] = Column(ends[:, place], kind, f"{label}, {end} end")
    return Table(title="What the results depend on", columns=columns, is_data=True)


def end_listing(ranges: Ranges, known: Known) -> Listing:
    """Every value that has a range, and each number at its lower and at its upper end, as people read it."""
    rows = []
    for place, row in enumerate(ranges.rows):
        pairs = ((known[key][0], ranges.ends[key][place]) for key in ranges.nominal)
        cells = (" / ".join(shown_cell(float(value), kind) for value in pair) for kind, pair in pairs)
        rows.append(Row(value_words(row), None, (range_text(row), *cells)))
    heads = tuple(label + display_unit(kind).bracketed_symbol for kind, label in map(known.__getitem__, ranges.nominal))
    note = "Each number at the lower / at the upper end of the range."
    return Listing(title="At both ends", heads=("range", *heads), rows=tuple(rows), note=note)


def range_chart(ranges: Ranges, known: Known) -> Chart:
    """A panel of bars for each number that rests on anything, over the table of `range_table`; values in one order."""
    keys = [key for key in ranges.nominal if ranges.moves(key)]
    shares = np.max([ranges.widths(key) / np.max(ranges.widths(key)) for key in keys], axis=0)
    order = [int(place) for place in np.argsort(-shares, kind="stable") if shares[place] > LEAST_BAR][:MOST_BARS]
    panels = tuple(
        Bars(
            names="bar",
            values=tuple(_column(key, known[key][0], end) for end in ("low", "high")),
            labels=("at the lower end", "at the upper end"),
            colours=(Colour.TANK, Colour.LOAD),
            label=textwrap.fill(known[key][1], WIDEST_WORDS),
            rows=tuple(order),
            base=ranges.nominal[key],
        )
        for key in keys
    )
    height = 1.1 + 0.265 * len(order)
    return Chart(
        name=RESTS_ON, caption=CAPTION, table=RANGES, panels=panels, side_by_side=True, share=True, height=height
    )


def range_listing(ranges: Ranges, known: Known) -> Listing:
    """The lowest and the highest of each number, and the value that moves it furthest."""
    rows = []
    for key, value in ranges.nominal.items():
        most = ranges.rows[int(np.argmax(ranges.widths(key)))]
        through = f"{value_words(most)}, {range_text(most)}" if ranges.moves(key) else ""
        rows.append(Row(known[key][1], known[key][0], (value, *ranges.span(key), through)))
    count = len(ranges.rows)
    title = f"Over the ranges of {count} values, {ALONE}" if count > 1 else "Over the range of one value"
    return Listing(
        title=title, heads=("as it is", "lowest", "highest", "mostly by"), rows=tuple(rows), note=_left_out(ranges)
    )


def _left_out(ranges: Ranges) -> str:
    reasons: dict[str, list[str]] = {}
    for setting, why in ranges.left_out.items():
        reasons.setdefault(why, []).append(setting)
    return " ".join(f"Not varied: {', '.join(settings)} ({why})." for why, settings in reasons.items())


def value_words(row: Sourced) -> str:
    """A user's words for a value: its key, and the table that it stands in."""
    name = re.sub(r"^(viscosity)_(\d+)$", r"\1 at \2 °C", row.key)
    return f"{name} of the {row.table.rpartition('.')[2]}".replace("_", " ")


def _column(key: str, kind: Kind, end: str) -> str:
    suffix = key_suffix(kind)
    return f"{key.removesuffix(suffix)}_{end}{suffix}"
