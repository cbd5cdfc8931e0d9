"""The edges of a code wheel: where each lies, as a table and as a figure."""

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import number
from vvdp.base.kinds import ANGLE, COUNT, EFFICIENCY, FRACTION, RATIO
from vvdp.offline.charts import PALE, Figure, data_table
from vvdp.offline.noise_fit import Explained
from vvdp.offline.sums import Sums
from vvdp.results.chart import Chart, Colour, Line, Lines, Stroke
from vvdp.results.result import Column, Table
from vvdp.sensing.wheel import TURN, CodeWheel

TABLE, DRAWING, RIPPLES = "wheel-edges", "wheel-drawing", "ripples"
MOST_EXAGGERATED = 10.0
"""Offsets of edges are drawn so many times as large, at most."""
INNER, OUTER = 0.58, 1.0
"""Radii of the ring of sectors, as drawn."""
LEAST_SHOWN = 1e-3
"""The axis of the offsets reaches at least so far [rad]."""
KINDS = ("wheel", "even", "odd")
EXPECTED = Line(
    x="edge",
    y="expected_rad",
    label="± 2 standard errors",
    colour=Colour.RELIEF,
    width=0.6,
    low="low_rad",
    high="high_rad",
)


def wheel_table(sums: Sums, *, polarity_known: bool) -> Table:
    """By how much each edge lies further on than the wheel has it, with its standard error."""
    offsets, errors, place = sums.edges.offsets, sums.edges.offset_deviations, np.arange(sums.tally.sectors)
    names = ("rising", "falling") if polarity_known else ("even", "odd")
    reach = 2.0 * np.nan_to_num(errors)
    columns = {
        "edge": Column(place.astype(float), COUNT, "edge of the wheel"),
        "side": Column(np.array([names[i % 2] for i in place]), None, "side"),
        "edges": Column(sums.edges.counts, COUNT, "edges seen"),
        "offset_rad": Column(offsets, ANGLE, "offset"),
        "offset_error_rad": Column(errors, ANGLE, "standard error"),
        "offset_of_sector": Column(offsets * sums.tally.sectors / TURN, EFFICIENCY, "offset, of a sector"),
        "expected_rad": Column(np.zeros(sums.tally.sectors), ANGLE, "expected offset"),
        "low_rad": Column(-reach, ANGLE, "two standard errors less"),
        "high_rad": Column(reach, ANGLE, "two standard errors more"),
    }
    return Table(title="Edges of the wheel", columns=columns, shown=tuple(columns)[:6])


def ripple_table(told: Explained | None) -> Table:
    """The ripples of the speed that fit the edges alike, in the order of their orders; empty if none was found."""
    found = told.candidates if told is not None and told.ripple is not None else ()
    by_order = sorted(found, key=lambda each: each.ripple.order)
    columns = {
        "order": Column(np.array([float(each.ripple.order) for each in by_order]), COUNT, "ripples per turn"),
        "amplitude": Column(np.array([each.ripple.amplitude for each in by_order]), RATIO, "amplitude over the speed"),
        "probability": Column(np.array([each.chance for each in by_order]), FRACTION, "probability"),
    }
    return Table(title="Ripples that fit the edges", columns=columns)


def wheel_figure(table: Table, wheel: CodeWheel) -> Figure:
    """The wheel as it is seen with the offsets of its edges, and the offsets one by one."""
    offsets, reach = table["offset_rad"], table["high_rad"]
    grown = enlargement(offsets[np.abs(np.nan_to_num(offsets)) > reach], table.rows)
    sure = bool(np.any(np.abs(np.nan_to_num(offsets)) > reach))
    drawn = (
        f"enlarged {number(grown, 2)} times; those within their errors are left out"
        if sure
        else "all within their errors and left out"
    )
    caption = (
        "By how much each edge of the wheel lies further on than it should (right), mean over all revolutions; band: "
        "two standard errors. The mean of all is zero, since no angle is known from outside. Rising (even) and falling "
        "edges apart: the threshold is off. One wave over the turn: the wheel is eccentric. One edge alone: dirt, a "
        f"damaged sector, or an index. Left: the wheel, with dark sectors hatched and the offsets {drawn}."
    )
    panels = (_ring_panel(table), _offset_panel(table))
    chart = Chart(name="wheel", caption=caption, table=TABLE, panels=panels, side_by_side=True, height=3.0)
    return Figure(chart, {TABLE: table, DRAWING: _drawing(table, wheel, grown)})


def _ring_panel(table: Table) -> Lines:
    lines = (
        Line(x="across", y="wheel", label="wheel", colour=PALE, width=0.8),
        Line(x="across", y="even", label=table["side"][0], colour=Colour.LOAD, width=1.6),
        Line(x="across", y="odd", label=table["side"][1], colour=Colour.INLET, width=1.6),
    )
    return Lines(lines=lines, equal=True, table=DRAWING)


def _offset_panel(table: Table) -> Lines:
    offsets, reach = table["offset_rad"], table["high_rad"]
    top = 1.15 * max(float(np.nanmax(np.abs(offsets) + reach)), LEAST_SHOWN / 1.15)
    bars = (
        Line(
            x="edge",
            y="offset_rad",
            label=table["side"][first],
            rows=tuple(range(first, table.rows, 2)),
            colour=colour,
            stroke=Stroke.STEMS,
            width=max(1.0, min(9.0, 120.0 / table.rows)),
        )
        for first, colour in ((0, Colour.LOAD), (1, Colour.INLET))
    )
    right = table.rows - 0.4
    return Lines(lines=(*bars, EXPECTED), label="offset", low=-top, high=top, left=-0.6, right=right, height=1.9)


def enlargement(offsets: Array, sectors: int) -> float:
    """How many times as large the offsets [rad] are drawn: a quarter of a sector, but not more than is plain to see."""
    largest = float(np.max(np.abs(offsets), initial=0.0))
    return min(0.25 * TURN / sectors / largest, MOST_EXAGGERATED) if largest > 0.0 else 1.0


def _drawing(table: Table, wheel: CodeWheel, grown: float) -> Table:
    """Points of the wheel with its dark sectors hatched, and of the edges whose offset is sure."""
    places = np.asarray(wheel.edges)
    ends = np.append(places, places[0] + TURN)
    offsets = np.nan_to_num(table["offset_rad"])
    sure = np.abs(offsets) > table["high_rad"]
    strokes = [("wheel", radius * _on_circle(np.linspace(0.0, TURN, 121))) for radius in (INNER, OUTER)]
    for i, place in enumerate(places):
        hatched = np.linspace(ends[i], ends[i + 1], max(4, 160 // places.size))[1:-1] if i % 2 else ()
        strokes += [("wheel", _spoke(angle)) for angle in (place, *hatched)]
    strokes += [("odd" if i % 2 else "even", _spoke(places[i] + grown * offsets[i])) for i in np.flatnonzero(sure)]
    strokes.sort(key=lambda stroke: KINDS.index(stroke[0]))
    across = np.concatenate([np.append(points[0], np.nan) for _, points in strokes])
    columns = {"across": Column(across, RATIO, "across")}
    for key in KINDS:
        up = [
            np.append(points[1] if own == key else np.full(points.shape[1], np.nan), np.nan) for own, points in strokes
        ]
        columns[key] = Column(np.concatenate(up), RATIO, "up")
    return data_table("The wheel as drawn", columns)


def _on_circle(angles: Array) -> Array:
    found: Array = np.array([np.cos(angles), np.sin(angles)])
    return found


def _spoke(angle: float) -> Array:
    found: Array = _on_circle(np.array([angle, angle])) * np.array([INNER, OUTER])
    return found
