"""Pictures of a controlled axial drive: where the spool should be, is, and is believed to be; what the loop stores."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import ENERGY, POSITION, PRESSURE_LEVEL, SIGNED_FRACTION, TIME, Kind
from vvdp.results.chart import Chart, Colour, Level, Line, Lines, Stroke
from vvdp.results.result import Column, Table
from vvdp.systems.axial_loop import PROGRAM, RUN, SETTLED

if TYPE_CHECKING:
    from vvdp.simulation.record import Record

TABLE = "axial"
"""Name of the table that holds what is drawn."""


Columns = dict[str, tuple[Array, Kind, str]]


def motion_columns(record: "Record", spool: str) -> Columns:
    """Where the spool should be, is and is believed to be, over time; `spool` is the path of its position."""
    words = ("reference", "measured", "position", "position_deviation")
    shown = {key: record.commands[f"{PROGRAM}.{key}"].values for key in words}
    true = record.states[spool].values
    return {
        "time_s": (record.times, TIME, "time"),
        "position_m": (true, POSITION, "position"),
        "reference_m": (shown["reference"], POSITION, "reference"),
        "measured_m": (shown["measured"], POSITION, "shown by the sensor"),
        "tracking_error_m": (true - shown["reference"], POSITION, "error against the reference"),
        "estimate_error_m": (shown["position"] - true, POSITION, "error of the estimate"),
        "above_m": (2.0 * shown["position_deviation"], POSITION, "two stated deviations"),
        "below_m": (-2.0 * shown["position_deviation"], POSITION, "less two stated deviations"),
    }


def control_charts(record: "Record") -> Iterator[tuple[Chart, Table]]:
    """The course of the whole run of a chamber drive, and the errors once control has settled."""
    columns = motion_columns(record, "slide.position") | {
        "pressure_Pa": (record.states["pilot_chamber"].values, PRESSURE_LEVEL, "chamber"),
        "desired_Pa": (record.commands[f"{PROGRAM}.desired_pressure"].values, PRESSURE_LEVEL, "desired"),
        "storage_J": (record.commands[f"{PROGRAM}.storage"].values, ENERGY, "storage of the loop, as believed"),
    }
    pressure = (
        Line(x="time_s", y="pressure_Pa", label="chamber"),
        Line(x="time_s", y="desired_Pa", label="desired", stroke=Stroke.DASHED),
    )
    panels = (Lines(lines=pressure, label="pressure"), Lines(lines=(Line(x="time_s", y="storage_J"),), label="storage"))
    told = "; the chamber's pressure and that which would move it as wanted; what the loop stores, which falls where "
    yield from drive_charts(record, columns, panels, told + "nothing pushes")


def gerotor_charts(record: "Record") -> Iterator[tuple[Chart, Table]]:
    """The same of a gerotor drive."""
    columns = motion_columns(record, "gerotor.position") | {
        "command": (record.commands[f"{PROGRAM}.drive"].values, SIGNED_FRACTION, "command"),
    }
    panels = (Lines(lines=(Line(x="time_s", y="command"),), label="command"),)
    yield from drive_charts(record, columns, panels, "; the pump's command")


def drive_charts(
    record: "Record", columns: Columns, panels: tuple[Lines, ...], told: str
) -> Iterator[tuple[Chart, Table]]:
    """Course and errors of a drive; `panels` of its own come below the position, `told` goes on its caption."""
    table = Table(title="Axial control", columns={k: Column(*of) for k, of in columns.items()}, is_data=True)
    begin = record.times[record.commands[f"{PROGRAM}.stage"].values == RUN]
    start = float(begin[0]) if begin.size else float(record.times[0])
    levels = (Level(value=start, label="control", upright=True),) if begin.size else ()
    yield course_chart(levels, panels, told), table
    settled = start + SETTLED if record.times[-1] > start + SETTLED else start
    yield error_chart(tuple(np.flatnonzero(record.times >= settled).tolist())), table


def course_chart(levels: tuple[Level, ...], panels: tuple[Lines, ...], told: str) -> Chart:
    """Position and further panels over the whole run; `levels` say when control begins."""
    position = (
        Line(x="time_s", y="measured_m", label="shown by the sensor", colour=Colour.FAINT, width=0.8),
        Line(x="time_s", y="position_m", label="true"),
        Line(x="time_s", y="reference_m", label="reference", stroke=Stroke.DASHED),
    )
    return Chart(
        name="axial-control",
        caption=f"The spool along its axis: wanted, true, and as its sensor shows it{told}.",
        table=TABLE,
        panels=(Lines(lines=position, label="position", levels=levels), *panels),
        height=2.5 + 2.0 * len(panels),
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
