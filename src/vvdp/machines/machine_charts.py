"""Pictures of the whole machine: course, pressures, what is asked of the drives, and under each the phase."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import DURATION, DUTY_RATIO, FLAG, FLOW, FRACTION, POSITION, PRESSURE_LEVEL, SIGNED_FRACTION, Kind
from vvdp.control.pressure_modes import PressureBounds
from vvdp.machines.machine_control import SAMPLE_PERIOD
from vvdp.machines.machine_loop import PROGRAM
from vvdp.machines.stages import CONTROL, PHASES
from vvdp.programs.displacement_charts import DIRECTION, OPENING, bound_levels, motion_panels
from vvdp.programs.tracking import SETTLED
from vvdp.results.chart import Chart, Colour, Line, Lines, Stroke, flag_panel
from vvdp.results.result import Column, Table

if TYPE_CHECKING:
    from vvdp.simulation.record import Record

TABLE = "machine"
"""Name of the table that holds what is drawn."""
Columns = dict[str, tuple[Array, Kind, str]]


def machine_columns(record: "Record") -> Columns:
    """What is drawn over time.

    A row shows what was commanded at the last sample before it: errors are those against the position at that sample.
    """
    shown = {key.partition(".")[2]: s.values for key, s in record.commands.items() if key.startswith(f"{PROGRAM}.")}
    pressures = {f"{name}_Pa": record.states[name].values for name in ("chamber_a", "chamber_b", "line")}
    return {
        "time_s": (record.times, DURATION, "time"),
        **{f"phase_{PHASES[n]}": ((shown["phase"] == n) * 1.0, FLAG, PHASES[n]) for n in phases_of(record)},
        "position_m": (record.states["rod.position"].values, POSITION, "position"),
        "wanted_m": (shown["wanted"], POSITION, "cycle"),
        "reference_m": (shown["reference"], POSITION, "filtered reference"),
        "tracking_error_m": sampled_error(
            record.times, record.states["rod.position"].values, shown["reference"], SAMPLE_PERIOD
        ),
        **{key: (values, PRESSURE_LEVEL, key[:-3].replace("_", " ")) for key, values in pressures.items()},
        "flow_m3_s": (shown["flow"], FLOW, "flow asked for"),
        "split_flow_m3_s": (shown["split_flow"], FLOW, "flow of the split"),
        "duty_ratio": (shown["duty_ratio"], DUTY_RATIO, "duty ratio asked for"),
        "opening": (shown["opening"], FRACTION, "opening of the return valve"),
        "direction": (shown["direction"], SIGNED_FRACTION, "direction"),
    }


def sampled_error(times: Array, position: Array, reference: Array, period: float) -> tuple[Array, Kind, str]:
    """Column of the error [m] against a `reference`, of the position at the last sample, one each `period` [s]."""
    sampled = period * (np.ceil(times / period - 1e-6) - 1.0)
    return np.interp(sampled, times, position) - reference, POSITION, "error against the reference"


def machine_charts(record: "Record", bounds: PressureBounds) -> Iterator[tuple[Chart, Table]]:
    """Course, pressures and actuation of a run."""
    columns = machine_columns(record)
    table = Table(title="Displacement control", columns={k: Column(*of) for k, of in columns.items()}, is_data=True)
    times, is_controlled = record.times, record.commands[f"{PROGRAM}.phase"].values == CONTROL
    begin = times[is_controlled][0] if np.any(is_controlled) else np.inf
    rows = tuple(np.flatnonzero(is_controlled & (times >= begin + SETTLED)).tolist())
    for chart in (motion_chart(rows), pressure_chart(bounds), actuation_chart()):
        yield chart, table


def phases_of(record: "Record") -> list[int]:
    """The numbers of the phases that a run goes through."""
    return sorted({int(phase) for phase in record.commands[f"{PROGRAM}.phase"].values})


def with_phases(chart: Chart, record: "Record") -> Chart:
    """A chart over time with a panel of the phases of the machine."""
    words = [PHASES[n] for n in phases_of(record)]
    panel = flag_panel("time_s", {f"phase_{word}": word for word in words}, "phase", TABLE)
    return replace(
        chart,
        caption=f"{chart.caption} With the phases of the machine.",
        panels=(*chart.panels, panel),
        height=chart.height + 1.0,
    )


def charts_with_phases(charts: Iterable[tuple[Chart, Table]], record: "Record") -> Iterator[tuple[Chart, Table]]:
    """Charts, those over time with the phases of the machine."""
    for chart, table in charts:
        is_course = all(isinstance(p, Lines) and all(line.x == "time_s" for line in p.lines) for p in chart.panels)
        yield (with_phases(chart, record) if is_course else chart), table


def motion_chart(rows: tuple[int, ...]) -> Chart:
    """Position over the whole run, and the error over these rows."""
    position = (
        Line(x="time_s", y="wanted_m", label="cycle", colour=Colour.FAINT),
        Line(x="time_s", y="position_m", label="true"),
        Line(x="time_s", y="reference_m", label="filtered reference", stroke=Stroke.DASHED),
    )
    return Chart(
        name="machine-motion",
        caption="The rod, the cycle it is to follow and that cycle as filtered; and the error against the latter once "
        "control has settled.",
        table=TABLE,
        panels=motion_panels(position, rows),
        height=4.5,
    )


def pressure_chart(bounds: PressureBounds) -> Chart:
    """Pressures of line and chambers."""
    pressures = (
        Line(x="time_s", y="chamber_a_Pa", label="chamber a", colour=Colour.INLET),
        Line(x="time_s", y="chamber_b_Pa", label="chamber b", colour=Colour.LOAD),
        Line(x="time_s", y="line_Pa", label="line", colour=Colour.GREEN, width=0.8),
    )
    return Chart(
        name="machine-pressures",
        caption="Pressures of both chambers and of the line, which change places at each reversal, between the bounds "
        "that the control guards.",
        table=TABLE,
        panels=(Lines(lines=pressures, label="pressure", levels=bound_levels(bounds)),),
        height=3.0,
    )


def actuation_chart() -> Chart:
    """What is asked of rotary valve, return valve and directional valve."""
    flows = (
        Line(x="time_s", y="flow_m3_s", label="asked for"),
        Line(x="time_s", y="split_flow_m3_s", label="of the split", stroke=Stroke.DASHED),
    )
    return Chart(
        name="machine-actuation",
        caption="What is asked of the drives: a mean flow, and the duty ratio that gives it; the opening of the return "
        "valve; the direction.",
        table=TABLE,
        panels=(
            Lines(lines=flows, label="flow"),
            Lines(lines=(Line(x="time_s", y="duty_ratio", colour=Colour.RED),)),
            OPENING,
            DIRECTION,
        ),
        height=6.0,
    )
