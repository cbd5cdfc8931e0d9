"""Pictures of a controlled axial drive: where the spool should be, is, and is believed to be; what the loop stores."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import ENERGY, POSITION, PRESSURE_LEVEL, TIME, Kind
from vvdp.results.chart import Chart, Colour, Level, Line, Lines, Stroke
from vvdp.results.result import Column, Table
from vvdp.systems.axial_loop import PROGRAM, RUN, SETTLED

if TYPE_CHECKING:
    from vvdp.simulation.record import Record

TABLE = "axial"
"""Name of the table that holds what is drawn."""


def control_table(record: "Record") -> Table:
    """What is drawn of a controlled chamber drive, over time."""
    shown = {key: record.commands[f"{PROGRAM}.{key}"].values for key in SHOWN}
    true = record.states["slide.position"].values
    columns: dict[str, tuple[Array, Kind, str]] = {
        "time_s": (record.times, TIME, "time"),
        "position_m": (true, POSITION, "position"),
        "reference_m": (shown["reference"], POSITION, "reference"),
        "measured_m": (shown["measured"], POSITION, "shown by the sensor"),
        "tracking_error_m": (true - shown["reference"], POSITION, "error against the reference"),
        "estimate_error_m": (shown["position"] - true, POSITION, "error of the estimate"),
        "above_m": (2.0 * shown["position_deviation"], POSITION, "two stated deviations"),
        "below_m": (-2.0 * shown["position_deviation"], POSITION, "less two stated deviations"),
        "pressure_Pa": (record.states["pilot_chamber"].values, PRESSURE_LEVEL, "chamber"),
        "desired_Pa": (shown["desired_pressure"], PRESSURE_LEVEL, "desired"),
        "storage_J": (shown["storage"], ENERGY, "storage of the loop, as believed"),
    }
    return Table(title="Axial control", columns={k: Column(*of) for k, of in columns.items()}, is_data=True)


SHOWN = ("reference", "measured", "position", "position_deviation", "desired_pressure", "storage")
"""Fields of the program's command that are drawn."""


def control_charts(record: "Record") -> Iterator[tuple[Chart, Table]]:
    """The course of the whole run, and the errors once control has settled."""
    table = control_table(record)
    begin = record.times[record.commands[f"{PROGRAM}.stage"].values == RUN]
    start = float(begin[0]) if begin.size else float(record.times[0])
    yield course_chart((Level(value=start, label="control", upright=True),) if begin.size else ()), table
    settled = start + SETTLED if record.times[-1] > start + SETTLED else start
    yield error_chart(tuple(np.flatnonzero(record.times >= settled).tolist())), table


def course_chart(levels: tuple[Level, ...]) -> Chart:
    """Position, pressure and storage over the whole run; `levels` say when control begins."""
    position = (
        Line(x="time_s", y="measured_m", label="shown by the sensor", colour=Colour.FAINT, width=0.8),
        Line(x="time_s", y="position_m", label="true"),
        Line(x="time_s", y="reference_m", label="reference", stroke=Stroke.DASHED),
    )
    pressure = (
        Line(x="time_s", y="pressure_Pa", label="chamber"),
        Line(x="time_s", y="desired_Pa", label="desired", stroke=Stroke.DASHED),
    )
    return Chart(
        name="axial-control",
        caption="The spool along its axis: wanted, true, and as its sensor shows it; the chamber's pressure and that "
        "which would move it as wanted; what the loop stores, which falls where nothing pushes.",
        table=TABLE,
        panels=(
            Lines(lines=position, label="position", levels=levels),
            Lines(lines=pressure, label="pressure"),
            Lines(lines=(Line(x="time_s", y="storage_J"),), label="storage"),
        ),
        height=6.5,
    )


def error_chart(rows: tuple[int, ...]) -> Chart:
    """Errors over these rows."""
    of_estimate = (
        Line(x="time_s", y="estimate_error_m", rows=rows, label="error"),
        Line(x="time_s", y="above_m", rows=rows, label="two deviations either way", colour=Colour.RELIEF),
        Line(x="time_s", y="below_m", rows=rows, colour=Colour.RELIEF),
    )
    return Chart(
        name="axial-errors",
        caption="Errors once control has settled: of the spool against its reference, and of the estimate within two "
        "of its stated deviations.",
        table=TABLE,
        panels=(
            Lines(lines=(Line(x="time_s", y="tracking_error_m", rows=rows),), label="against the reference"),
            Lines(lines=of_estimate, label="of the estimate"),
        ),
        height=4.0,
    )
