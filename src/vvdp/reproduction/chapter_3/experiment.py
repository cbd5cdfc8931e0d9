"""Section 3.6: the filter on the running valve, and the step of the pump's flow."""

from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np

import vvdp
from vvdp.base.arrays import Array
from vvdp.base.kinds import ANGLE, COUNT, DURATION, FLOW, GAUGE_PRESSURE, RATIO, SPEED, TIME
from vvdp.base.units import ATMOSPHERE
from vvdp.comparison.estimators import Contender, contenders
from vvdp.comparison.results import Comparison
from vvdp.comparison.scenarios import FAST_FLOW, LPM, SECTORS, SLOW_FLOW, flow_step, scenarios
from vvdp.comparison.trials import compare
from vvdp.reproduction.drawings import circuit_drawing
from vvdp.reproduction.item import Item, ItemKind, Reproduction, figure_of, over
from vvdp.results.chart import Chart, Colour, Line, Lines
from vvdp.results.result import Column, Table
from vvdp.results.verdict import bound_statement, digit_statement, number_statement
from vvdp.runs.run import RecordedRun
from vvdp.sensing.wheel import TURN

REVOLUTIONS, SECTIONS = 11, 3.0
SEEDS = 60
MOST_TIME = 0.1
"""Within which the filter is stated to follow a step [s]."""
PUMP, PUMP_SPEED, PUMP_FLOW = 22.8e-6, 1800.0 / 60.0, 40.0 * LPM
RUN = {"until": "0.75 s", "window": "0.5 s", "window_interval": "0.1 ms"}


def figure_3_12() -> Reproduction:
    """The apparatus: the circuit that stands for it."""
    return circuit_drawing("apparatus", "figure-3.12", "prototype")


@cache
def prototype_run() -> RecordedRun:
    """The prototype with its encoder and filter, finely recorded over the last half second."""
    return vvdp.load("prototype", run=RUN).run()


def estimated_turns() -> Table:
    """Time, estimated angle and inlet pressure of the last eleven turns."""
    run = prototype_run()
    samples = np.flatnonzero(np.diff(run.memory("encoder.time"), prepend=-1.0) > 0.0)
    estimate = np.interp(run.times, run.times[samples], run.command("estimate.angle")[samples])
    shown = estimate >= estimate[-1] - REVOLUTIONS * TURN
    time, angle = run.times[shown], estimate[shown]
    columns = {
        "time_s": Column(time - time[0], TIME, "time"),
        "turned_rad": Column(angle - angle[0], ANGLE, "estimated angle"),
        "angle_rad": Column(np.mod(angle - angle[0], TURN), ANGLE, "estimated angle within a turn"),
        "inlet_Pa": Column(run.state("inlet")[shown] - ATMOSPHERE, GAUGE_PRESSURE, "inlet pressure"),
    }
    return Table(title="Inlet pressure", columns=columns, is_data=True)


def _turns(table: Table) -> Iterator[Line]:
    """A line for each turn."""
    turn = np.floor_divide(table["turned_rad"], TURN)
    for number in np.unique(turn):
        rows = tuple(np.flatnonzero(turn == number).tolist())
        yield Line(x="angle_rad", y="inlet_Pa", width=0.6, rows=rows, colour=Colour.LOAD)


def rises(angle: Array, pressure: Array) -> Array:
    """Angles at which a pressure rises through its middle [rad]."""
    middle = 0.5 * (pressure.min() + pressure.max())
    at = np.flatnonzero((pressure[1:] > middle) & (pressure[:-1] <= middle))
    share = (middle - pressure[at]) / (pressure[at + 1] - pressure[at])
    found: Array = angle[at] + share * (angle[at + 1] - angle[at])
    return found


def figure_3_13() -> Reproduction:
    """The inlet pressure over eleven turns, over time and over the estimated angle: three waves a turn."""
    table = estimated_turns()
    at = rises(table["turned_rad"], table["inlet_Pa"])
    spread = float(np.sqrt(-2.0 * np.log(abs(np.mean(np.exp(1j * SECTIONS * at)))))) / TURN
    over_time = (Line(x="time_s", y="inlet_Pa", width=0.6),)
    panels = tuple(Lines(lines=lines, label="inlet pressure") for lines in (over_time, tuple(_turns(table))))
    chart = Chart(
        name="figure-3.13",
        caption="Inlet pressure over eleven turns of the simulated prototype, over time and over the estimated angle.",
        table="pressure",
        panels=panels,
        side_by_side=True,
        height=2.6,
    )
    statements = (
        number_statement(
            "waves of the inlet pressure in a turn",
            SECTIONS,
            at.size / REVOLUTIONS,
            COUNT,
            tolerance=1.0 / REVOLUTIONS,
            because="a wave at an end of the record",
            source="three repetitive patterns",
        ),
        bound_statement(
            "scatter of the waves' rises over the estimated angle, over a wave",
            spread,
            RATIO,
            high=0.1,
            source="nearly periodic over the estimated angle",
            because="a tenth of a wave (ours)",
        ),
    )
    return Reproduction(statements=statements, tables={"pressure": table}, charts=(chart,))


def followers() -> tuple[Contender, ...]:
    """The filter as it is shipped, and with the published density alone."""
    known = {each.name: each for each in contenders()}
    return known["event-filter"], known["no-manoeuvres"]


@cache
def step_comparison() -> Comparison:
    """Both over the step of the flow from 26.7 to 40 lpm."""
    step = next(each for each in scenarios() if each.name == "step")
    return compare([step], followers(), SEEDS)


def figure_3_14() -> Reproduction:
    """The step of the spool's speed, and when the filter has followed."""
    found = step_comparison()
    trace: Any = found.traced
    after = (trace.time > 0.9) & (trace.time < 1.6)
    columns = {"time_s": Column(trace.time[after], TIME, "time"), "true_rad_s": _speed(trace.speed[after], "true")}
    for name, title in (("event-filter", "as built"), ("no-manoeuvres", "as published")):
        columns[f"{name.replace('-', '_')}_rad_s"] = _speed(trace.estimated[name][after], title)
    edge = TURN / SECTORS / float(trace.speed[after][0])
    statements = tuple(
        bound_statement(
            f"5 % settling, median of {SEEDS} runs, {words}",
            float(found.scores["step", name]["settling_median_s"].value),
            DURATION,
            high=MOST_TIME,
            tolerance=edge,
            because="one edge of the slow wheel",
            note=note,
        )
        for name, words, note in (
            ("no-manoeuvres", "q = 0.25 rad²/s³", "the q of 3.5; the text names none for this experiment"),
            ("event-filter", "as built", "q rises for a few edges where the edges say that the speed changes"),
        )
    )
    return figure_of(
        "figure-3.14",
        "Speed of the spool when the pump's flow steps from 26.7 to 40 lpm at 1 s, and its estimates.",
        {"speed": Table(title="Speed", columns=columns, axes=("time_s",), is_data=True)},
        statements,
        over(*columns, label="speed"),
    )


def _speed(values: Any, label: str) -> Column:
    return Column(values, SPEED, label)


def section_3_6() -> Reproduction:
    """Flows and speeds of the experiment."""
    lag = flow_step(0.0)
    flow = PUMP * PUMP_SPEED
    return Reproduction(
        statements=(
            digit_statement(
                "flow of 22.8 cc at 1800 rpm",
                PUMP_FLOW,
                flow,
                FLOW,
                tolerance=0.5 * LPM,
                note="both hold with a volumetric efficiency of 97.5 %, which is not printed",
            ),
            digit_statement(
                "flow at 40 Hz of the drive", SLOW_FLOW, 40.0 / 60.0 * FAST_FLOW, FLOW, tolerance=0.05 * LPM
            ),
            bound_statement(
                "time constant of the spool",
                lag.time_constant,
                DURATION,
                high=MOST_TIME,
                source="a transition in less than 0.1 s",
            ),
        ),
    )


ITEMS = (
    Item(ItemKind.FIGURE, "3.12", "Experimental apparatus of the VVDP", figure_3_12),
    Item(ItemKind.FIGURE, "3.13", "Event-based Kalman filter, experimental results", figure_3_13),
    Item(ItemKind.FIGURE, "3.14", "Transition response to a step change in angular velocity", figure_3_14),
    Item(ItemKind.SECTION, "3.6", "Flows and times of the experiment", section_3_6),
)
