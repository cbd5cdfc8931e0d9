"""Pictures of a controlled axial drive: where the spool should be, is, and is believed to be; what the loop stores."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import ANGLE, DURATION, ENERGY, POSITION, PRESSURE_LEVEL, SIGNED_FRACTION, Kind
from vvdp.programs.axial_stages import RUN, SETTLED
from vvdp.results.chart import Chart, Colour, Level, Line, Lines, Stroke
from vvdp.results.result import Column, Table

if TYPE_CHECKING:
    from vvdp.simulation.record import Record

TABLE = "axial"
"""Name of the table that holds what is drawn."""


TURN = 2.0 * np.pi
Columns = dict[str, tuple[Array, Kind, str]]


class DrivePaths(NamedTuple):
    """Where a record has what is drawn of an axial drive: true position, and of its control the reference, what the
    sensor shows, the estimate with its deviation and the periodic sensor error, the spool's angle, the stage."""

    spool: str
    reference: str
    measured: str
    position: str
    position_deviation: str
    pollution: str
    spool_angle: str
    stage: str


class ChamberPaths(NamedTuple):
    """The same of a chamber: its pressure, the desired one, and what the loop stores."""

    pressure: str
    desired_pressure: str
    storage: str


def values_over_time(record: "Record", path: str) -> Array:
    """A command or a state over time, by its path; the state of a volume, or of a driven shaft, is its node."""
    known = {**record.states, **record.commands}
    return known[path if path in known else path.rpartition(".")[0]].values


def motion_columns(record: "Record", paths: DrivePaths, period: float) -> Columns:
    """Where the spool should be, is and is believed to be, over time.

    A row shows what was commanded at the last sample before it: errors are those against the position at that sample,
    of which there is one every `period` [s].
    """
    shown = {word: values_over_time(record, path) for word, path in paths._asdict().items()}
    true = shown["spool"]
    sampled = np.interp(period * (np.ceil(record.times / period - 1e-6) - 1.0), record.times, true)
    return {
        "time_s": (record.times, DURATION, "time"),
        "position_m": (true, POSITION, "position"),
        "reference_m": (shown["reference"], POSITION, "reference"),
        "measured_m": (shown["measured"], POSITION, "shown by the sensor"),
        "tracking_error_m": (sampled - shown["reference"], POSITION, "error against the reference"),
        "estimate_error_m": (shown["position"] - sampled, POSITION, "error of the estimate"),
        "above_m": (2.0 * shown["position_deviation"], POSITION, "two stated standard deviations"),
        "below_m": (-2.0 * shown["position_deviation"], POSITION, "less two stated standard deviations"),
        "sensor_error_m": (shown["measured"] - sampled, POSITION, "error of the sensor"),
        "pollution_m": (shown["pollution"], POSITION, "periodic sensor error that is believed"),
        "turned_rad": (np.mod(shown["spool_angle"], TURN), ANGLE, "angle of the spool within its turn"),
    }


def chamber_charts(
    record: "Record", paths: DrivePaths, chamber: ChamberPaths, period: float
) -> Iterator[tuple[Chart, Table]]:
    """The course of the run of a chamber drive, its errors once control has settled, and the periodic sensor error
    over a turn; the observer samples every `period` [s]."""
    stored = values_over_time(record, chamber.storage)
    columns = motion_columns(record, paths, period) | {
        "pressure_Pa": (values_over_time(record, chamber.pressure), PRESSURE_LEVEL, "chamber"),
        "desired_Pa": (values_over_time(record, chamber.desired_pressure), PRESSURE_LEVEL, "desired"),
        "storage_J": (stored, ENERGY, "storage of the loop, as believed"),
    }
    pressure = (
        Line(x="time_s", y="pressure_Pa", label="chamber"),
        Line(x="time_s", y="desired_Pa", label="desired", stroke=Stroke.DASHED),
    )
    storage = Line(x="time_s", y="storage_J", rows=tuple(np.flatnonzero(stored > 0.0).tolist()))
    panels = (Lines(lines=pressure, label="pressure"), Lines(lines=(storage,), label="storage", y_log=True))
    told = "; the chamber's pressure and that which would move it as wanted; what the loop stores, which falls where "
    yield from drive_charts(record, paths, columns, panels, told + "nothing pushes")


def command_charts(record: "Record", paths: DrivePaths, command: str, period: float) -> Iterator[tuple[Chart, Table]]:
    """The same of any drive, with its command by its path."""
    columns = motion_columns(record, paths, period) | {
        "command": (values_over_time(record, command), SIGNED_FRACTION, "command"),
    }
    panels = (Lines(lines=(Line(x="time_s", y="command"),), label="command"),)
    yield from drive_charts(record, paths, columns, panels, "; the pump's command")


def drive_charts(
    record: "Record", paths: DrivePaths, columns: Columns, panels: tuple[Lines, ...], told: str
) -> Iterator[tuple[Chart, Table]]:
    """Course and errors of a drive; `panels` of its own come below the position, `told` goes on its caption."""
    table = Table(title="Axial control", columns={k: Column(*of) for k, of in columns.items()}, is_data=True)
    begin = record.times[values_over_time(record, paths.stage) == RUN]
    start = float(begin[0]) if begin.size else float(record.times[0])
    levels = (Level(value=start, label="control", upright=True),) if begin.size else ()
    yield course_chart(levels, panels, told), table
    settled = start + SETTLED if record.times[-1] > start + SETTLED else start
    yield error_chart(tuple(np.flatnonzero(record.times >= settled).tolist())), table
    if rows := last_turn(values_over_time(record, paths.spool_angle)):
        yield pollution_chart(rows), table


def last_turn(angles: Array) -> tuple[int, ...]:
    """A row for each sample of the last whole turn of the spool, from its angle [rad]; none before one is over."""
    turns = np.floor(angles / TURN)
    is_new = np.diff(angles, prepend=angles[0]) != 0.0
    rows = np.flatnonzero((turns == turns[-1] - 1.0) & is_new)
    return tuple(rows.tolist()) if turns[-1] >= 2.0 else ()


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
    of_estimate = Line(x="time_s", y="estimate_error_m", rows=rows, low="below_m", high="above_m")
    return Chart(
        name="axial-errors",
        caption="Errors once control has settled: of the spool against its reference, and of the estimate within two "
        "of its stated standard deviations.",
        table=TABLE,
        panels=(
            Lines(lines=(Line(x="time_s", y="tracking_error_m", rows=rows),), label="against the reference"),
            Lines(lines=(of_estimate,), label="of the estimate"),
        ),
        height=4.0,
    )


def pollution_chart(rows: tuple[int, ...]) -> Chart:
    """What the sensor is off by, and what is believed of it, over the turn of these rows."""
    lines = (
        Line(x="turned_rad", y="sensor_error_m", rows=rows, label="error of the sensor", colour=Colour.TANK),
        Line(x="turned_rad", y="pollution_m", rows=rows, label="believed", stroke=Stroke.DASHED),
    )
    return Chart(
        name="axial-pollution",
        caption="The periodic sensor error of the axial sensor over the last whole turn of the spool: as it is, with "
        "the sensor's "
        "noise, and as the observer has learned it.",
        table=TABLE,
        panels=(Lines(lines=lines, label="pollution"),),
        height=3.0,
    )
