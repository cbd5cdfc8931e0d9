"""Section 7.3: adapting the threshold, the inlet pressure as a second sensor, adapting the displacement controller."""

from functools import cache

import numpy as np

import vvdp
from vvdp.api.run import Run
from vvdp.base.kinds import ANGLE, COUNT, DURATION, FORCE, FRACTION, NUMBER, POSITION, RATIO, TIME
from vvdp.comparison.estimators import adapting_start, contenders
from vvdp.comparison.scenarios import scenarios
from vvdp.comparison.trials import compiled_encoder, compiled_loop, simulate_record
from vvdp.estimation.duty import wave_duty_ratio
from vvdp.reproduction.chapter_3.experiment import SECTIONS, estimated_turns, rises
from vvdp.reproduction.chapter_3.optics import edge_errors
from vvdp.reproduction.item import Item, ItemKind, Reproduction, figure_of, over
from vvdp.results.chart import Colour, Level, Line, Lines, Stroke
from vvdp.results.result import Column, Table
from vvdp.results.verdict import Statement, bound_statement, number_statement
from vvdp.sensing.wheel import TURN

SEED = 0
TRUE_THRESHOLD, BEGUN_AT = 0.5, 0.65
STRANGE_LOAD = {"operation": {"load_force": -2500.0}}
"""A load of which the controller believes that it is -1000 N."""


def figure_7_1() -> Reproduction:
    """The errors of the edges' times that a wrong threshold makes: they alternate and add up to nothing."""
    errors = edge_errors()
    speed = 24.7 * TURN
    times = errors["error_rad"] / speed
    columns = {
        "angle_rad": Column(errors["angle_rad"], ANGLE, "angle of the edge"),
        "error_s": Column(times, DURATION, "error of its time"),
    }
    table = Table(title="Error of each edge's time", columns=columns, axes=("angle_rad",))
    statements = (
        bound_statement(
            "sum of the errors over the sum of their sizes",
            abs(float(times.sum())) / float(np.abs(times).sum()),
            RATIO,
            high=1e-2,
            source="they add up to zero over a revolution",
            because="points of the curve",
        ),
        bound_statement(
            "neighbouring edges with errors of the same sign",
            float(np.sum(np.sign(times[1:]) == np.sign(times[:-1]))),
            COUNT,
            high=0.0,
            source="the error switches signs for every measurement",
        ),
    )
    return figure_of(
        "figure-7.1",
        "Error of each edge's time at 24.7 Hz with a threshold of 0.35 in place of 0.5.",
        {"errors": table},
        statements,
        over("angle_rad", "error_s", stroke=Stroke.STEMS),
        height=2.2,
    )


@cache
def adapted_thresholds() -> Table:
    """The threshold of the comparator over time, adapted from 0.65 on, and the error of the angle."""
    contender = next(each for each in contenders() if each.name == "adaptive-threshold")
    scenario = next(each for each in scenarios() if each.name == "threshold-bias")
    record = simulate_record(scenario, compiled_encoder(scenario), SEED)
    loop = compiled_loop(contender, scenario)
    shown = loop(adapting_start(scenario, record, contender.settings), np.column_stack(record.truth)).shown
    place = {column: k for k, column in enumerate(loop.columns)}
    columns = {
        "time_s": Column(record.truth.time, TIME, "time"),
        "threshold": Column(shown[:, place["threshold"]], FRACTION, "threshold"),
    }
    return Table(title="Threshold", columns=columns, axes=("time_s",), is_data=True)


def figure_7_2() -> Reproduction:
    """A threshold that is fed back until it is the true one."""
    table = adapted_thresholds()
    late = table["threshold"][table["time_s"] > 1.0]
    reached = table["time_s"][np.abs(table["threshold"] - TRUE_THRESHOLD) < 0.1 * (BEGUN_AT - TRUE_THRESHOLD)]
    statements = (
        number_statement(
            "threshold after a second, begun at 0.65",
            TRUE_THRESHOLD,
            float(late.mean()),
            FRACTION,
            tolerance=0.02,
            because="0.02 (ours): noise of the light at a gain of 0.05",
            source="converges to the true threshold",
        ),
        bound_statement(
            "time within which nine tenths of the error are gone",
            float(reached[0]) if reached.size else np.inf,
            DURATION,
            high=1.0,
            source="the threshold is adapted in real time",
            because="ours",
            note="a law of vvdp: the source leaves it to further work",
        ),
    )
    lines = (Line(x="time_s", y="threshold", colour=Colour.INLET),)
    return figure_of(
        "figure-7.2",
        "Threshold of the comparator, fed back from the filter's innovations; true is 0.5.",
        {"threshold": table},
        statements,
        Lines(lines=lines, label="threshold", levels=(Level(value=TRUE_THRESHOLD),)),
        height=2.4,
    )


@cache
def learning_run(load_gain: float) -> Run:
    """The cylinder of chapter 6 under a load that its controller does not know, learned with a gain [N/m]."""
    learning = {"load_gain": f"{load_gain:g} N/m"}
    return vvdp.load("displacement-chapter6", adaptation=learning, **STRANGE_LOAD).run()


def measured_duty_ratio() -> float:
    """The duty ratio of the inlet pressure's wave over the estimated angle of eleven turns [1]."""
    table = estimated_turns()
    angle, pressure = table["turned_rad"], table["inlet_Pa"]
    up, down = rises(angle, pressure), rises(angle, -pressure)
    falls = [float(down[down > at][0]) for at in up if np.any(down > at)]
    waves = [wave_duty_ratio(at, fall, SECTIONS) for at, fall in zip(up.tolist(), falls, strict=False)]
    return float(np.mean(waves))


def _learning() -> tuple[Statement, ...]:
    """Gain of a controller that learns the load over one with a wrong load in its model."""
    plain, learned = learning_run(0.0), learning_run(4e4)
    believed = float(learned.command("control.load_force")[-1])
    return (
        bound_statement(
            "largest tracking error, load learned over load believed",
            learned.number("tracking_error_max_m") / plain.number("tracking_error_max_m"),
            RATIO,
            high=1.0,
            source="parameter adaptation can improve the controller",
        ),
        number_statement(
            "load at the end of the learning",
            -2500.0,
            believed,
            FORCE,
            share=0.05,
            because="5 % (ours): friction is known as it is, the modulus is not learned",
            source="the load of the simulation",
        ),
        bound_statement(
            "largest tracking error with the load learned",
            learned.number("tracking_error_max_m"),
            POSITION,
            high=5e-3,
            source="less than 0.5 cm (6.5)",
        ),
    )


def section_7_3() -> Reproduction:
    """Duty ratio from the inlet pressure, and the gain by adaptation."""
    duty = measured_duty_ratio()
    at = rises(estimated_turns()["turned_rad"], estimated_turns()["inlet_Pa"])
    return Reproduction(
        statements=(
            number_statement(
                "waves of the inlet pressure in a turn",
                SECTIONS,
                TURN / float(np.mean(np.diff(at))),
                NUMBER,
                tolerance=0.05,
                because="0.05 (ours): swing of the speed within a turn",
            ),
            bound_statement(
                "duty ratio of the wave less 0.5",
                duty - 0.5,
                FRACTION,
                low=-0.15,
                high=0.15,
                source="slightly different, due to the pressure dynamics",
                note="static throttling makes it, not the dynamics (docs/errata.md)",
            ),
            *_learning(),
        )
    )


ITEMS = (
    Item(ItemKind.FIGURE, "7.1", "Measurement error caused by the threshold bias", figure_7_1),
    Item(ItemKind.FIGURE, "7.2", "Threshold adaptation framework", figure_7_2),
    Item(ItemKind.SECTION, "7.3", "Sensor fusion and adaptive control", section_7_3),
)
