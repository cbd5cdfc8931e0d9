"""The figures of a map, as data."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from vvdp.base.display import with_unit
from vvdp.base.kinds import FLOW, PRESSURE_LEVEL, SPEED, TEMPERATURE
from vvdp.results.chart import Chart, Colour, Field, Level, Line, Lines, Stroke, shades
from vvdp.rigs.efficiencies import EFFICIENCIES
from vvdp.rigs.maps import PumpMap

MOST_MAPS = 6
"""Pairs of pump speed and temperature that get a figure of their own."""
MOST_LINES = 6
SHOWN_BACKWARDS = 0.1
"""Of the pump flow: no more is shown of a flow that comes back from the load."""
STEPS = tuple(0.1 * place for place in range(11))
STROKES = (Stroke.SOLID, Stroke.DASHED, Stroke.DOTTED)


class Family(NamedTuple):
    """Efficiencies that belong together: the name of their figure, their columns, and what a caption says of them."""

    name: str
    columns: tuple[str, ...]
    words: str


FAMILIES = (
    Family("efficiency", EFFICIENCIES[:3], "Efficiencies against the commanded flow"),
    Family(
        "efficiency-iso",
        EFFICIENCIES[3:],
        "Efficiencies by ISO 4409, with the flow at the outlet's pressure and the derived capacity of each setting",
    ),
)


def chosen_places(count: int, most: int = MOST_LINES) -> list[int]:
    """Places of at most `most` of `count` values, the ends among them."""
    return [int(place) for place in np.unique(np.linspace(0, count - 1, min(count, most)).round())]


def map_charts(found: PumpMap, table: str) -> Iterator[Chart]:
    """Flow, power and efficiencies of a map whose points are in `table`."""
    pairs = list(np.ndindex(found.axes.shape[:2]))
    chosen = [pairs[place] for place in chosen_places(len(pairs), MOST_MAPS)]
    for count, (i, k) in enumerate(chosen, 1):
        ending = f"-{count}" if len(chosen) > 1 else ""
        words = f" At {_where(found, i, k)}." if len(pairs) > 1 else ""
        yield _flow_chart(found, table, (i, k), ending, words)
        draw = _field_chart if min(found.axes.shape[2:]) > 1 else _line_chart
        for family in FAMILIES:
            yield draw(found, table, _rows(found, i, k), family._replace(name=f"{family.name}{ending}"), words)
    if len(pairs) > 1:
        yield _condition_chart(found, table)


def _where(found: PumpMap, i: int, k: int) -> str:
    """Temperature and pump speed."""
    return f"{with_unit(found.axes.temperatures[i], TEMPERATURE)}, {with_unit(found.axes.pump_speeds[k], SPEED)}"


def _rows(found: PumpMap, i: int, k: int, pressure: int | None = None) -> tuple[int, ...]:
    """Rows at a temperature and a pump speed, and at one load pressure or at all."""
    rows = np.arange(found.axes.count).reshape(found.axes.shape)[i, k]
    return tuple(int(row) for row in (rows if pressure is None else rows[pressure]).ravel())


def _flow_chart(found: PumpMap, table: str, pair: tuple[int, int], ending: str, words: str) -> Chart:
    axes = found.axes
    places = chosen_places(len(axes.load_pressures))

    def lines(key: str) -> tuple[Line, ...]:
        return tuple(
            Line(
                x="duty_ratio",
                y=key,
                label=with_unit(axes.load_pressures[place], PRESSURE_LEVEL),
                rows=_rows(found, *pair, place),
                colour=colour,
                stroke=Stroke.MARKED if len(axes.duty_ratios) < 30 else Stroke.SOLID,
            )
            for place, colour in zip(places, shades(len(places)), strict=True)
        )

    commanded = Line(
        x="duty_ratio",
        y="commanded_flow_m3_s",
        label="commanded flow",
        rows=_rows(found, *pair, 0),
        colour=Colour.INK,
        stroke=Stroke.DOTTED,
    )
    low, backwards = _backwards(found, pair)
    rated, power = found.stand.bench.rated_power, found.grid("input_power_W")[pair]
    near = bool(np.isfinite(power).any()) and rated < 1.5 * float(np.nanmax(power))
    levels = (Level(value=rated, colour=Colour.INLET),) if near else ()
    return Chart(
        name=f"flow{ending}",
        caption="Delivered flow and input power over the duty ratio, a line for each load pressure. Dotted: the "
        "commanded flow, duty ratio times pump flow; dashed: the rated power of the motor, where it lies in the "
        f"picture.{backwards}{words}",
        table=table,
        panels=(
            Lines(lines=(*lines("delivered_flow_m3_s"), commanded), label="delivered flow", low=low, legend="load"),
            Lines(lines=lines("input_power_W"), levels=levels, low=0.0, legend="load"),
        ),
        side_by_side=True,
        height=2.9,
    )


def _backwards(found: PumpMap, pair: tuple[int, int]) -> tuple[float | None, str]:
    """Where the picture of the flow ends below, and what the caption says of it, if the load sends much oil back."""
    flow, pump_flow = (found.grid(name)[pair] for name in ("delivered_flow_m3_s", "mean_pump_flow_m3_s"))
    if not np.isfinite(flow).any() or np.nanmin(flow) >= -SHOWN_BACKWARDS * np.nanmax(pump_flow):
        return None, ""
    least = with_unit(float(np.nanmin(flow)), FLOW, 3)
    words = f" A load above the relief setting drives oil backwards, down to {least}; the picture ends before."
    return -SHOWN_BACKWARDS * float(np.nanmax(pump_flow)), words


def _field_chart(found: PumpMap, table: str, rows: tuple[int, ...], family: Family, words: str) -> Chart:
    flags = found.columns.get("ripple_reaches_relief", np.zeros(found.axes.count))
    marks = "ripple_reaches_relief" if np.any(flags[list(rows)] > 0.0) else ""
    crosses = "; crosses: the ripple of the load pressure reaches the relief valve" if marks else ""
    return Chart(
        name=family.name,
        caption=f"{family.words}, over duty ratio and load pressure [%]. Hatched: the input power exceeds the rated "
        f"power of the motor; grey: no result{crosses}.{words}",
        table=table,
        panels=tuple(
            Field(
                x="duty_ratio",
                y="load_pressure_Pa",
                z=name,
                rows=rows,
                hatch="motor_overloaded",
                marks=marks,
                title=name.partition("_")[0],
                steps=STEPS,
            )
            for name in family.columns
        ),
        side_by_side=True,
        share=True,
        height=2.75,
    )


def _line_chart(found: PumpMap, table: str, rows: tuple[int, ...], family: Family, words: str) -> Chart:
    """Of a map with one duty ratio or one load pressure."""
    x = "duty_ratio" if len(found.axes.duty_ratios) > 1 else "load_pressure_Pa"
    colours = (Colour.LOAD, Colour.TANK, Colour.GREEN)
    lines = [
        Line(x=x, y=name, label=name.partition("_")[0], rows=rows, colour=colour, stroke=Stroke.MARKED)
        for name, colour in zip(family.columns, colours, strict=True)
    ]
    for flag, label, colour in (
        ("motor_overloaded", "above the motor's rated power", Colour.INLET),
        ("ripple_reaches_relief", "ripple reaches the relief valve", Colour.RED),
    ):
        marked = tuple(row for row in rows if flag in found.columns and found.columns[flag][row] > 0.0)
        if marked:
            points = Line(x=x, y=family.columns[-1], label=label, rows=marked, colour=colour, stroke=Stroke.POINTS)
            lines.append(points)
    return Chart(
        name=family.name,
        caption=f"{family.words}; points of the overall one that are in doubt or too much for the motor.{words}",
        table=table,
        panels=(Lines(lines=tuple(lines), label="efficiency", low=0.0),),
        height=2.75,
    )


def _condition_chart(found: PumpMap, table: str) -> Chart:
    middle = len(found.axes.load_pressures) // 2
    colours = shades(len(found.axes.pump_speeds))
    lines = (
        Line(
            x="duty_ratio",
            y="overall_efficiency",
            label=_where(found, i, k),
            rows=_rows(found, i, k, middle),
            colour=colours[k],
            stroke=STROKES[i % len(STROKES)],
        )
        for i, k in np.ndindex(found.axes.shape[:2])
    )
    pressure = with_unit(found.axes.load_pressures[middle], PRESSURE_LEVEL)
    return Chart(
        name="conditions",
        caption=f"Overall efficiency over the duty ratio at {pressure}, by oil temperature and pump speed.",
        table=table,
        panels=(Lines(lines=tuple(lines), legend="temperature, speed", low=0.0),),
        height=2.7,
    )
