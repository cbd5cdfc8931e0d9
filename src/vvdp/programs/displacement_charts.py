"""Charts of a cylinder under displacement control: its motion, its pressures, the commands of the drives."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import DURATION, FLOW, FRACTION, POSITION, PRESSURE_LEVEL, SIGNED_FRACTION, Kind
from vvdp.control.pressure_modes import PRESSURE_MODE, PressureBounds
from vvdp.network.nodes import Source
from vvdp.programs.tracking import SETTLED
from vvdp.results.chart import Chart, Colour, Level, Line, Lines, Stroke
from vvdp.results.result import Column, Table

if TYPE_CHECKING:
    from vvdp.simulation.record import Record

TABLE = "displacement"
"""Name of the table of the inputs and commands of a law."""
OPENING = Lines(lines=(Line(x="time_s", y="opening", colour=Colour.GREEN),), low=0.0, high=1.05)
"""Panel of the return valve."""
DIRECTION = Lines(
    lines=(Line(x="time_s", y="direction", stroke=Stroke.STEPS, colour=Colour.PURPLE),), low=-1.2, high=1.2, height=0.4
)
"""Panel of the directional valve."""


def columns_over_time(record: "Record", sources: Mapping[str, Source]) -> dict[str, Array]:
    """Recorded values of these sources, states and commands alike, by name; sources without a record are left out."""
    known = {**record.states, **record.commands}
    paths = {name: str(source) for name, source in sources.items()}
    nodes = {name: path if path in known else path.removesuffix(".pressure") for name, path in paths.items()}
    return {name: known[path].values for name, path in nodes.items() if path in known}


def table_over_time(record: "Record", columns: Mapping[str, tuple[Array, Kind, str]]) -> Table:
    """Table of the drawn columns over time."""
    every = {"time_s": (record.times, DURATION, "time"), **columns}
    shown = {key: Column(*column) for key, column in every.items()}
    return Table(title="Displacement control", columns=shown, is_data=True)


def motion_charts(record: "Record", sources: Mapping[str, Source]) -> Iterator[tuple[Chart, Table]]:
    """Course of a run with its error; nothing without the `position`, `reference` and `error` among the sources.

    A row shows the command of the last sample before it: errors are those against the position at that sample.
    """
    words = {"position": "position", "reference": "filtered reference", "error": "error against the reference"}
    keys = {"position": "position_m", "reference": "reference_m", "error": "tracking_error_m"}
    shown = columns_over_time(record, {name: sources[name] for name in words})
    counted = columns_over_time(record, {name: sources[name] for name in sources if name == "counted"})
    if shown.keys() == words.keys():
        controlled = np.flatnonzero(counted.get("counted", np.ones(record.times.size)))
        begin = float(record.times[controlled[0] if controlled.size else 0])
        settled = begin + SETTLED if record.times[-1] > begin + SETTLED else begin
        rows = tuple(np.flatnonzero(record.times > settled).tolist())
        columns = {keys[name]: (values, POSITION, words[name]) for name, values in shown.items()}
        yield motion_chart(rows), table_over_time(record, columns)


def law_charts(
    record: "Record", sources: Mapping[str, Source], bounds: PressureBounds
) -> Iterator[tuple[Chart, Table]]:
    """The pressures that a law reads within their bounds, with the mode, and its commands to the drives.

    sources  of pressures, commands and, where it is known, the delivered flow
    """
    kinds = {
        "pressure_a": ("pressure_a_Pa", PRESSURE_LEVEL, "chamber a"),
        "pressure_b": ("pressure_b_Pa", PRESSURE_LEVEL, "chamber b"),
        "delivered_flow": ("pump_flow_m3_s", FLOW, "flow of the pump"),
        "flow": ("asked_flow_m3_s", FLOW, "flow asked of the pump"),
        "opening": ("opening", FRACTION, "opening of the return valve"),
        "direction": ("direction", SIGNED_FRACTION, "direction"),
        "mode": ("mode", PRESSURE_MODE, "pressure mode"),
    }
    shown = columns_over_time(record, {key: source for key, source in sources.items() if key in kinds})
    table = table_over_time(record, {kinds[key][0]: (of, *kinds[key][1:]) for key, of in shown.items()})
    if {"pressure_a", "pressure_b"} <= shown.keys():
        yield pressure_chart(bounds), table
    yield actuation_chart(is_flow_known="delivered_flow" in shown), table


def motion_panels(position: tuple[Line, ...], rows: tuple[int, ...]) -> tuple[Lines, Lines]:
    """Panels of these lines of a position, and of its error over these rows."""
    error = Line(x="time_s", y="tracking_error_m", rows=rows)
    return Lines(lines=position, label="position"), Lines(lines=(error,), label="error")


def motion_chart(rows: tuple[int, ...]) -> Chart:
    """Position over the whole run, and the error over these rows."""
    position = (
        Line(x="time_s", y="position_m", label="true"),
        Line(x="time_s", y="reference_m", label="filtered reference", stroke=Stroke.DASHED),
    )
    return Chart(
        name="displacement-motion",
        caption="The rod and its filtered reference, and the error between them once control has settled: it lies "
        "where the cylinder turns round and its pressures change places.",
        table="tracking",
        panels=motion_panels(position, rows),
        height=4.5,
    )


def bound_levels(bounds: PressureBounds) -> tuple[Level, Level]:
    """Levels of the bounds of a pressure."""
    return (
        Level(value=bounds.highest_pressure, label="upper bound"),
        Level(value=bounds.lowest_pressure, label="lower bound"),
    )


def pressure_chart(bounds: PressureBounds) -> Chart:
    """Pressures of both chambers, and the mode that they make."""
    pressures = (
        Line(x="time_s", y="pressure_a_Pa", label="chamber a"),
        Line(x="time_s", y="pressure_b_Pa", label="chamber b"),
    )
    return Chart(
        name="displacement-pressures",
        caption="Pressures of both chambers between their bounds, and the pressure mode: 1 none near, 2 supply low, "
        "3 return low, 4 supply high, 5 return high, half a mode more within the band before a bound.",
        table=TABLE,
        panels=(
            Lines(lines=pressures, label="pressure", levels=bound_levels(bounds)),
            Lines(lines=(Line(x="time_s", y="mode", stroke=Stroke.STEPS),), low=0.5, high=6.0, height=0.5),
        ),
        height=4.5,
    )


def actuation_chart(*, is_flow_known: bool) -> Chart:
    """Commands of pump, return valve and directional valve, and the flow that the pump delivers, if it is known."""
    flows = (
        Line(x="time_s", y="asked_flow_m3_s", label="asked", colour=Colour.FAINT),
        Line(x="time_s", y="pump_flow_m3_s", label="given"),
    )[: 2 if is_flow_known else 1]
    return Chart(
        name="displacement-actuation",
        caption="The flow of the pump, slow; the opening of the return valve, fast; and the direction.",
        table=TABLE,
        panels=(Lines(lines=flows, label="flow of the pump"), OPENING, DIRECTION),
        height=5.5,
    )
