"""Charts of the whole machine: pressures, commands of the drives, and the phase under each."""

from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

from vvdp.base.kinds import DUTY_RATIO, FLAG, FLOW, FRACTION, POSITION, PRESSURE_LEVEL, SIGNED_FRACTION
from vvdp.control.pressure_modes import PressureBounds
from vvdp.network.network import ProgramPart
from vvdp.programs.displacement_charts import (
    DIRECTION,
    OPENING,
    bound_levels,
    columns_over_time,
    table_over_time,
)
from vvdp.programs.machine.phases import PHASES
from vvdp.results.chart import Chart, Colour, Line, Lines, Stroke, flag_panel
from vvdp.results.result import Table

if TYPE_CHECKING:
    from vvdp.simulation.record import Record

TABLE = "machine"
"""Name of the table behind the charts."""
PRESSURES = {"pressure_a": "chamber a", "pressure_b": "chamber b", "line_pressure": "line"}
COMMANDS = {
    "wanted": ("wanted_m", POSITION, "cycle"),
    "flow": ("flow_m3_s", FLOW, "flow asked for"),
    "split_flow": ("split_flow_m3_s", FLOW, "flow of the split"),
    "duty_ratio": ("duty_ratio", DUTY_RATIO, "duty ratio asked for"),
    "opening": ("opening", FRACTION, "opening of the return valve"),
    "direction": ("direction", SIGNED_FRACTION, "direction"),
}


def machine_charts(record: "Record", program: ProgramPart, bounds: PressureBounds) -> Iterator[tuple[Chart, Table]]:
    """Pressures and actuation of a run."""
    pressures = columns_over_time(record, {name: program.reads[name] for name in PRESSURES})
    commands = columns_over_time(record, {name: f"{program.name}.{name}" for name in (*COMMANDS, "phase")})
    phase = commands.pop("phase")
    columns = {
        **{f"phase_{PHASES[n]}": ((phase == n) * 1.0, FLAG, PHASES[n]) for n in phases_of(record, program.name)},
        **{f"{name}_Pa": (values, PRESSURE_LEVEL, PRESSURES[name]) for name, values in pressures.items()},
        **{COMMANDS[name][0]: (values, *COMMANDS[name][1:]) for name, values in commands.items()},
    }
    table = table_over_time(record, columns)
    for chart in (pressure_chart(bounds), actuation_chart()):
        yield chart, table


def phases_of(record: "Record", name: str) -> list[int]:
    """The numbers of the phases that a run goes through, by the program of this name."""
    return sorted({int(phase) for phase in record.commands[f"{name}.phase"].values})


def with_phases(chart: Chart, record: "Record", name: str) -> Chart:
    """A chart over time with a panel of the phases of the machine that the program of this name leads; another one as
    it is."""
    if not all(isinstance(p, Lines) and all(line.x == "time_s" for line in p.lines) for p in chart.panels):
        return chart
    words = [PHASES[n] for n in phases_of(record, name)]
    panel = flag_panel("time_s", {f"phase_{word}": word for word in words}, "phase", TABLE)
    return replace(
        chart,
        caption=f"{chart.caption} With the phases of the machine.",
        panels=(*chart.panels, panel),
        height=chart.height + 1.0,
    )


def pressure_chart(bounds: PressureBounds) -> Chart:
    """Pressures of line and chambers."""
    pressures = (
        Line(x="time_s", y="pressure_a_Pa", label="chamber a", colour=Colour.INLET),
        Line(x="time_s", y="pressure_b_Pa", label="chamber b", colour=Colour.LOAD),
        Line(x="time_s", y="line_pressure_Pa", label="line", colour=Colour.GREEN, width=0.8),
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
    """Commands of rotary valve, return valve and directional valve, and the cycle that leads to them."""
    flows = (
        Line(x="time_s", y="flow_m3_s", label="asked for"),
        Line(x="time_s", y="split_flow_m3_s", label="of the split", stroke=Stroke.DASHED),
    )
    return Chart(
        name="machine-actuation",
        caption="The cycle; what is asked of the drives: a mean flow, and the duty ratio that gives it; the opening of "
        "the return valve; the direction.",
        table=TABLE,
        panels=(
            Lines(lines=(Line(x="time_s", y="wanted_m", colour=Colour.FAINT),), height=0.6),
            Lines(lines=flows, label="flow"),
            Lines(lines=(Line(x="time_s", y="duty_ratio", colour=Colour.RED),)),
            OPENING,
            DIRECTION,
        ),
        height=7.0,
    )
