"""Parts that make the charts of a page live: their data, packed, and the scripts that draw them in a browser.

The page stays one file that works from a disk without network. Printed, or where scripts do not run, it shows the
still figures. Numbers are packed in the unit in which they are shown:

    exact    up to 512 rows: as they are
    runs     even steps: start, step and count of each stretch, within 1e-6 of a step
    blocks   1024 rows each: whole steps of 1/16382 of the block's range, so the error is at most 3.1e-5 of that range;
             a curve may be zoomed 80 times before a step is a pixel of a panel 200 pixels high
"""

import base64
import hashlib
import json
import zlib
from collections.abc import Iterable, Mapping
from functools import cache
from importlib import resources
from typing import Any, Protocol

import numpy as np

from vvdp.base.arrays import Array
from vvdp.report.plot import field_colours, field_grid, field_steps
from vvdp.report.plot_lines import FLAG_HEIGHT
from vvdp.report.shown import axis_label, column_unit, line_columns, line_label, line_looks, shown_values
from vvdp.results.chart import Bars, Chart, Dots, Field, Line, Lines, Stroke
from vvdp.results.result import Column, Table

EXACT_ROWS = 512
BLOCK = 1024
LEVELS = 16382
GAP = 65535
"""The code of a value that is not finite."""
SCRIPTS = (
    "uPlot.iife.min.js",
    "unpack.js",
    "format.js",
    "lines.js",
    "ripple.js",
    "contents.js",
    "plot.js",
    "charts.js",
)
VIEWER = "solids.js"
"""Turns solids; only in pages that have some."""
MOTION = "motion.js"
"""Common parts of diagrams in motion; only in pages that have some."""
STYLES = ("uPlot.min.css", "charts.css")


def live_head(own: Iterable[str] = (), allowed: str = "") -> str:
    """For the head of a page: the styles of live charts, and a policy that forbids the network and any other script.

    own      texts of further scripts that may run
    allowed  further directives of the policy, and sources of scripts before a semicolon
    """
    texts = (*map(asset, (*SCRIPTS, VIEWER)), *own)
    hashes = " ".join(f"'sha256-{base64.b64encode(hashlib.sha256(each.encode()).digest()).decode()}'" for each in texts)
    policy = (
        f"default-src 'none'; script-src {hashes}{allowed}; style-src 'unsafe-inline'; img-src data:; "
        "base-uri 'none'; form-action 'none'"
    )
    style = "".join(asset(name) for name in STYLES)
    return f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n<style>\n{style}</style>'


def live_body(charts: Iterable[Chart], tables: Mapping[str, Table], stride: int = 1) -> str:
    """For the end of the body: data and scripts; nothing where no chart can be live.

    A chart becomes live in the element `figure-NAME` of the page, in place of the SVG there. Of long columns every
    `stride`-th row is shown.
    """
    drawable = [chart for chart in charts if is_live(chart)]
    if not drawable:
        return ""
    scripts = "".join(f"<script>{asset(name)}</script>\n" for name in SCRIPTS)
    data = interactive_data(drawable, tables, stride)
    return f'<script type="application/json" id="chart-data">{data}</script>\n{scripts}'


def is_live(chart: Chart) -> bool:
    """Whether a chart can be looked into: bars and dots are as good still, and so are many small panels."""
    return not chart.columns and not any(isinstance(panel, Bars | Dots) for panel in chart.panels)


def interactive_data(charts: Iterable[Chart], tables: Mapping[str, Table], stride: int = 1) -> str:
    """The data of live charts as JSON that can stand in a page; the same charts give the same text."""
    columns = Columns(stride)
    return page_text([described_chart(chart, tables, columns) for chart in charts], columns)


def page_text(described: list[dict[str, Any]], columns: "Columns") -> str:
    """Described charts with their columns as JSON that can stand in a page."""
    packed = base64.b64encode(zlib.compress(bytes(columns.content), 6)).decode()
    page = {"charts": described, "columns": columns.described, "bytes": packed}
    return json.dumps(page, ensure_ascii=False, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


class Placed(Protocol):
    """Receiver of the columns of charts."""

    def place(self, values: Array) -> int:
        """The place of a column in the list."""


class Columns:
    """The packed columns of a page, each once; of those with more than `EXACT_ROWS` every `stride`-th row."""

    def __init__(self, stride: int = 1) -> None:
        self.stride = stride
        self.content = bytearray()
        self.described: list[dict[str, Any]] = []
        self._known: dict[tuple[str, int], int] = {}

    def place(self, values: Array) -> int:
        """The place of a column in the list; it is packed where it is not there yet."""
        found = np.ascontiguousarray(values, "<f8")
        key = (hashlib.sha256(found.tobytes()).hexdigest(), found.size)
        if key not in self._known:
            self._known[key] = len(self.described)
            is_long = found.size > EXACT_ROWS
            shown = found[:: self.stride] if is_long else found
            description, packed = pack_column(shown, EXACT_ROWS // self.stride if is_long else EXACT_ROWS)
            self.described.append({"at": len(self.content), "count": shown.size, **description})
            self.content += packed + bytes(-len(packed) % 8)
        return self._known[key]


def pack_column(values: Array, exact_rows: int = EXACT_ROWS) -> tuple[dict[str, Any], bytes]:
    """How a column is packed, and its bytes; one of `exact_rows` or fewer as it is."""
    if values.size <= exact_rows:
        return {"form": "exact"}, values.astype("<f8").tobytes()
    if (runs := _even_runs(values)) is not None:
        return {"form": "runs", "parts": len(runs)}, runs.astype("<f8").tobytes()
    return _pack_blocks(values)


def _even_runs(values: Array) -> Array | None:
    """Start, step and count of the stretches of even steps, a row each; None where there are many."""
    if not np.all(np.isfinite(values)):
        return None
    steps = np.diff(values)
    changes = np.flatnonzero(abs(np.diff(steps)) > 1e-6 * abs(steps[1:])) + 2
    if 64 * changes.size > values.size:
        return None
    edges = np.array([0, *changes, values.size])
    counts = np.diff(edges)
    begins, lasts = values[edges[:-1]], values[edges[1:] - 1]
    means = (lasts - begins) / np.clip(counts - 1, 1, None)
    within = np.arange(values.size) - np.repeat(edges[:-1], counts)
    error = abs(np.repeat(begins, counts) + within * np.repeat(means, counts) - values)
    if np.any(error > 1e-6 * np.median(abs(steps))):
        return None
    return np.column_stack([begins, means, counts])


def _pack_blocks(values: Array) -> tuple[dict[str, Any], bytes]:
    """Whole steps of each block's range, as differences; low bytes before high bytes, since alike packs better."""
    finite = np.isfinite(values)
    parts = -(-values.size // BLOCK)
    padded = np.full(parts * BLOCK, np.nan)
    padded[: values.size][finite] = values[finite]
    blocks = padded.reshape(parts, BLOCK)
    is_known = np.isfinite(blocks)
    low = np.where(is_known, blocks, np.inf).min(axis=1)
    high = np.where(is_known, blocks, -np.inf).max(axis=1)
    low, high = np.where(is_known.any(axis=1), (low, high), 0.0)
    step = (high - low) / LEVELS
    counts = np.rint((blocks - low[:, None]) / np.where(step > 0.0, step, 1.0)[:, None])
    codes = np.where(is_known, counts, GAP).astype(np.int64).ravel()[: values.size]
    changes = np.diff(codes, prepend=0) % 65536
    scales = np.column_stack([low, step]).astype("<f8").tobytes()
    halves = (changes % 256).astype(np.uint8).tobytes() + (changes // 256).astype(np.uint8).tobytes()
    return {"form": "blocks", "parts": parts, "block": BLOCK}, scales + halves


def described_chart(chart: Chart, tables: Mapping[str, Table], columns: Placed) -> dict[str, Any]:
    """A chart as `LiveChart` of the page takes it."""
    panels = []
    for panel in chart.panels:
        table = tables[panel.table or chart.table]
        if isinstance(panel, Lines):
            panels.append(_describe_lines(panel, table, tables, columns))
        elif isinstance(panel, Field):
            panels.append(_describe_field(panel, table, columns))
    return {
        "name": chart.name,
        "sideBySide": chart.side_by_side,
        "share": chart.share,
        "panels": panels,
    }


def _describe_lines(panel: Lines, table: Table, tables: Mapping[str, Table], columns: Placed) -> dict[str, Any]:
    y = line_columns(panel, table, tables)
    x = (tables[panel.lines[0].table] if panel.lines[0].table else table).columns[panel.lines[0].x]
    levels = [
        {
            "value": float(column_unit(x if level.upright else y[0]).from_si(level.value)),
            "label": level.label,
            "upright": level.upright,
            "colour": level.colour,
            "stroke": level.stroke,
        }
        for level in panel.levels
    ]
    return {
        "kind": "lines",
        "title": panel.title,
        "height": panel.height,
        "equal": panel.equal,
        "legend": panel.legend,
        "link": panel.lines[0].x,
        "x": _describe_axis([x], panel.x_label, (panel.left, panel.right), is_log=panel.x_log),
        "y": _describe_axis(y, panel.label, (panel.low, panel.high), is_log=panel.y_log),
        "lines": [
            _describe_line(line, look, tables[line.table] if line.table else table, columns) | _row(line, row)
            for row, (line, look) in enumerate(zip(panel.lines, line_looks(panel), strict=True))
        ],
        "levels": levels,
    }


def _row(line: Line, row: int) -> dict[str, float]:
    """Lower and upper edge of the bar of a flag."""
    return (
        {"foot": row + 0.5 - 0.5 * FLAG_HEIGHT, "top": row + 0.5 + 0.5 * FLAG_HEIGHT}
        if line.stroke is Stroke.FLAG
        else {}
    )


def _describe_axis(
    axis: list[Column], label: str = "", ends: tuple[float | None, float | None] = (None, None), *, is_log: bool = False
) -> dict[str, Any]:
    unit, words = column_unit(axis[0]), axis_label(axis, label)
    low, high = (None if end is None else float(unit.from_si(end)) for end in ends)
    name = words.removesuffix(unit.bracketed_symbol)
    return {"label": words, "name": name, "unit": unit.symbol, "low": low, "high": high, "log": is_log}


def _describe_line(line: Line, look: tuple[str, Stroke], table: Table, columns: Placed) -> dict[str, Any]:
    found = {
        "label": line_label(line, table),
        "unit": column_unit(table.columns[line.y]).symbol,
        "colour": look[0],
        "stroke": look[1],
        "width": line.width,
    }
    keys = {"x": line.x, "y": line.y} | ({"low": line.low, "high": line.high} if line.low else {})
    return found | {name: columns.place(shown_values(table, key, line.rows)) for name, key in keys.items()}


def _describe_field(panel: Field, table: Table, columns: Placed) -> dict[str, Any]:
    x, y, z = field_grid(panel, table, panel.z)
    steps = field_steps(panel, table)
    found = {
        "kind": "field",
        "title": panel.title,
        "height": panel.height,
        "x": _describe_axis([table.columns[panel.x]]),
        "y": _describe_axis([table.columns[panel.y]]),
        "z": _describe_axis([table.columns[panel.z]]),
        "steps": steps,
        "colours": field_colours(len(steps) - 1),
        "grid": [columns.place(values) for values in (x, y, z.ravel())],
    }
    for name, key in (("hatch", panel.hatch), ("marks", panel.marks)):
        if key:
            found[name] = columns.place(np.nan_to_num(field_grid(panel, table, key)[2]).ravel())
    return found


@cache
def asset(name: str) -> str:
    """The text of a script or style that stands in pages."""
    return resources.files("vvdp.report").joinpath("assets", name).read_text("utf-8")
