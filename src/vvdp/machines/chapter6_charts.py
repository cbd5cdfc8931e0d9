"""Pictures of a cylinder under displacement control: its motion, its pressures, what is asked of the drives."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import DURATION, FLOW, FRACTION, POSITION, PRESSURE_LEVEL, SIGNED_FRACTION, Kind
from vvdp.control.pressure_modes import PRESSURE_MODE, PressureBounds
from vvdp.machines.chapter6_loop import PROGRAM
from vvdp.machines.tracking import SETTLED
from vvdp.results.chart import Chart, Colour, Level, Line, Lines, Stroke
from vvdp.results.result import Column, Table

if TYPE_CHECKING:
    from vvdp.simulation.record import Record

TABLE = "displacement"
"""Name of the table that holds what is drawn."""
OPENING = Lines(lines=(Line(x="time_s", y="opening", colour=Colour.GREEN),), low=0.0, high=1.05)
"""Panel of the return valve."""
DIRECTION = Lines(
    lines=(Line(x="time_s", y="direction", stroke=Stroke.STEPS, colour=Colour.PURPLE),), low=-1.2, high=1.2, height=0.4
)
"""Panel of the directional valve."""


def sampled_error(record: "Record", reference: Array, period: float) -> tuple[Array, Kind, str]:
    """Column of the error [m] against a `reference`, of the position at the last sample, one each `period` [s]."""
    sampled = period * (np.ceil(record.times / period - 1e-6) - 1.0)
    position = np.interp(sampled, record.times, record.states["rod.position"].values)
    return position - reference, POSITION, "error against the reference"


def displacement_columns(record: "Record", period: float) -> dict[str, tuple[Array, Kind, str]]:
    """What is drawn over time; the control acts every `period` [s].

    A row shows what was commanded at the last sample before it: errors are those against the position at that sample.
    """
    shown = {key: record.commands[f"{PROGRAM}.{key}"].values for key in ("reference", "opening", "flow", "mode")}
    return {
        "time_s": (record.times, DURATION, "time"),
        "position_m": (record.states["rod.position"].values, POSITION, "position"),
        "reference_m": (shown["reference"], POSITION, "filtered reference"),
        "tracking_error_m": sampled_error(record, shown["reference"], period),
        "pressure_a_Pa": (record.states["chamber_a"].values, PRESSURE_LEVEL, "chamber a"),
        "pressure_b_Pa": (record.states["chamber_b"].values, PRESSURE_LEVEL, "chamber b"),
        "pump_flow_m3_s": (record.states["pump.flow"].values, FLOW, "flow of the pump"),
        "asked_flow_m3_s": (shown["flow"], FLOW, "flow asked of the pump"),
        "opening": (shown["opening"], FRACTION, "opening of the return valve"),
        "direction": (record.commands[f"{PROGRAM}.direction"].values, SIGNED_FRACTION, "direction"),
        "mode": (shown["mode"], PRESSURE_MODE, "pressure mode"),
    }


def displacement_charts(record: "Record", bounds: PressureBounds, period: float) -> Iterator[tuple[Chart, Table]]:
    """Course and actuation of a run with its error, the pressures within their bounds, and the modes."""
    columns = {key: Column(*of) for key, of in displacement_columns(record, period).items()}
    table = Table(title="Displacement control", columns=columns, is_data=True)
    begin = float(record.times[0])
    settled = begin + SETTLED if record.times[-1] > begin + SETTLED else begin
    yield motion_chart(tuple(np.flatnonzero(record.times > settled).tolist())), table
    yield pressure_chart(bounds), table
    yield actuation_chart(), table


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
        table=TABLE,
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


def actuation_chart() -> Chart:
    """What is asked of pump, return valve and directional valve."""
    flows = (
        Line(x="time_s", y="asked_flow_m3_s", label="asked", colour=Colour.FAINT),
        Line(x="time_s", y="pump_flow_m3_s", label="given"),
    )
    return Chart(
        name="displacement-actuation",
        caption="The flow of the pump, slow; the opening of the return valve, fast; and the direction.",
        table=TABLE,
        panels=(Lines(lines=flows, label="flow of the pump"), OPENING, DIRECTION),
        height=5.5,
    )
