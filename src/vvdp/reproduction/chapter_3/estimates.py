"""Section 3.5: how fast and how closely the filter finds angle and speed of a wheel that turns steadily."""

from collections.abc import Callable

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.kinds import ANGLE_ERROR, ANGULAR_VARIANCE, COUNT, FRACTION, NUMBER, SPEED, SPEED_ERROR, TIME, Kind
from vvdp.reproduction.chapter_3 import published_filter as published
from vvdp.reproduction.chapter_3.published_filter import EVEN, IN_STEP, OUT_OF_STEP, WITH_THRESHOLD, Truth
from vvdp.reproduction.item import Item, ItemKind, Reproduction, figure_of, over
from vvdp.results.chart import Chart, Colour, Level, Line, Lines, Stroke
from vvdp.results.result import Column, Table
from vvdp.results.verdict import Statement, bound_statement, digit_statement, number_statement
from vvdp.sensing.wheel import TURN

RAD_S = SPEED_ERROR
"""A speed that the source gives in rad/s."""
ANGLE_BOUND, SPEED_BOUND, BY = 0.06, 0.3, 0.1
"""Within what [rad, rad/s] and until when [s] the errors are stated to fall."""
ENOUGH = 0.95
RANDOM = f"95 % of {published.RUNS} random runs, less two standard errors"
TRUTHS = {
    "even": (EVEN, "independent even delays"),
    "threshold": (WITH_THRESHOLD, "with threshold error"),
    "in_step": (IN_STEP, "clock in step, 25 Hz"),
    "out_of_step": (OUT_OF_STEP, "1 kHz, 24.7 Hz"),
}
TIMES = np.arange(0.0, 0.4005, 0.001)
BANDS = {"even": Colour.LOAD, "in_step": Colour.INLET}


def share_within(truth: Truth, which: int, bound: float) -> float:
    """Share of the runs whose error of angle (0) or speed (1) is within a bound at 0.1 s."""
    error = published.filtered_runs(truth).errors_at(BY, truth.speed)[which]
    return float(np.mean(np.abs(error) < bound))


def _share_statements(which: int, bound: float, source: str) -> tuple[Statement, ...]:
    slack = 2.0 * float(np.sqrt(ENOUGH * (1.0 - ENOUGH) / published.RUNS))
    return tuple(
        bound_statement(
            f"share of runs, {words}",
            share_within(truth, which, bound),
            FRACTION,
            low=ENOUGH,
            tolerance=slack,
            because=RANDOM,
            source=source,
            note="shares of all truths, and why the text's own example meets them: docs/errata.md, convergence",
        )
        for truth, words in TRUTHS.values()
    )


def _error_table(which: int, kind: Kind, unit: str) -> Table:
    """The middle and the 5 and 95 % quantiles of the size of an error over time."""
    columns: dict[str, Column] = {"time_s": Column(TIMES, TIME, "time")}
    for name, (truth, words) in TRUTHS.items():
        runs = published.filtered_runs(truth)
        errors: Array = np.abs([runs.errors_at(float(t), truth.speed)[which] for t in TIMES])
        for level, suffix in ((0.5, ""), (0.05, "_low"), (0.95, "_high")):
            columns[f"{name}{suffix}_{unit}"] = Column(np.quantile(errors, level, axis=1), kind, words)
    return Table(title="Error over time", columns=columns, axes=("time_s",), is_data=True)


def _error_chart(name: str, caption: str, unit: str, bound: float) -> Chart:
    strokes = dict.fromkeys(TRUTHS, Stroke.DASHED) | dict.fromkeys(BANDS, Stroke.SOLID)
    lines = tuple(
        Line(
            x="time_s",
            y=f"{each}_{unit}",
            label=words,
            stroke=strokes[each],
            colour=BANDS.get(each, ""),
            low=f"{each}_low_{unit}" if each in BANDS else "",
            high=f"{each}_high_{unit}" if each in BANDS else "",
        )
        for each, (_, words) in TRUTHS.items()
    )
    levels = (Level(value=bound), Level(value=BY, upright=True))
    panel = Lines(lines=lines, label="size of the error", levels=levels, low=0.0, high=4.0 * bound)
    return Chart(name=name, caption=caption, table="errors", panels=(panel,), height=3.0)


def _convergence(which: int, kind: Kind, unit: str, bound: float, name: str) -> Callable[[], Reproduction]:
    words = ("angle", "speed")[which]
    caption = (
        f"Size of the error of the {words} over {published.RUNS} random runs of the published case: the middle, and "
        "for two of the truths the band from 5 to 95 %. Dashed: the published bound and time."
    )

    def work() -> Reproduction:
        """The errors over time, and how many runs keep to the bound at 0.1 s."""
        return Reproduction(
            statements=_share_statements(which, bound, f"below {bound} {('rad', 'rad/s')[which]} within 0.1 s"),
            tables={"errors": _error_table(which, kind, unit)},
            charts=(_error_chart(name, caption, unit, bound),),
        )

    return work


def figure_3_11() -> Reproduction:
    """The estimated speed of one run: it stays as it is from one edge to the next."""
    runs = published.filtered_runs(EVEN)
    speed = np.array([runs.errors_at(float(t), EVEN.speed)[1][0] + EVEN.speed for t in TIMES])
    first = TIMES <= 0.2
    changes, told = np.count_nonzero(np.diff(speed[first])), np.sum(runs.seen[:, 0] <= TIMES[first][-1])
    columns = {"time_s": Column(TIMES, TIME, "time"), "speed_rad_s": Column(speed, SPEED, "estimated speed")}
    panel = over(
        "time_s",
        "speed_rad_s",
        stroke=Stroke.STEPS,
        left=0.0,
        right=0.2,
        levels=(Level(value=EVEN.speed, label="true speed"),),
        low=150.0,
        high=165.0,
    )
    return figure_of(
        "figure-3.11",
        "Estimated speed of one run, from 50 rad/s at the start.",
        {"speed": Table(title="Speed", columns=columns, axes=("time_s",), is_data=True)},
        (
            number_statement(
                "changes of the estimated speed in 0.2 s, over edges seen",
                1.0,
                changes / told,
                tolerance=1.5 / told,
                source="it changes only when an edge is detected",
                because="an edge at either end",
            ),
        ),
        panel,
        height=2.2,
    )


def section_3_5() -> Reproduction:
    """The numbers of the simulated case, and what follows from them."""
    speed = TURN * published.TURNS
    statements = (
        digit_statement("25 Hz as speed", 157.1, speed, RAD_S, tolerance=0.05),
        digit_statement("resolution of the wheel", 0.785, published.SECTOR, ANGLE_ERROR, tolerance=5e-4),
        bound_statement(
            "time of the light's transition",
            5.0 / 8.0 * published.SECTOR / speed,
            TIME,
            high=published.LIGHT_TIME,
            inconsistency="5 mm of light on sectors of 8 mm take 5/8 of a sector's 5 ms",
            contradiction=("3.5: 1.5 ms at 25 Hz", "3.2: 5 mm of light on sectors of 8 mm"),
        ),
        bound_statement(
            "edges in 0.1 s",
            BY * speed / published.SECTOR,
            COUNT,
            low=1.0,
            source="the error of the angle is large for the first 0.1 s, as the speed is believed to be 50 rad/s",
        ),
    )
    return Reproduction(statements=(*statements, *_filter_inputs(), *_noise_statements(speed)))


def _filter_inputs() -> tuple[Statement, ...]:
    """With what the filter starts."""
    inputs = (
        ("variance of the state at the start, p", 1000.0, published.START_VARIANCE, NUMBER),
        ("process noise q [rad²/s³]", 0.25, published.DENSITY, NUMBER),
        ("believed speed at the start", 50.0, published.START_SPEED, RAD_S),
    )
    return tuple(
        number_statement(what, printed, taken, kind, share=1e-9, because="as printed")
        for what, printed, taken, kind in inputs
    )


def _noise_statements(speed: float) -> tuple[Statement, ...]:
    """Noise of an edge by the rules of section 3.3."""
    sampling, light = 0.5 * speed * published.SAMPLE, 0.5 * speed * published.LIGHT_TIME
    R, digits = published.NOISE, 5e-6
    return (
        digit_statement(
            "noise R by the rules of 3.3",
            R,
            sampling**2 / 3.0 + light**2 / 4.0,
            ANGULAR_VARIANCE,
            tolerance=digits,
            note="with a²/4 for the triangle, as printed",
        ),
        digit_statement(
            "noise R with the variance of a triangle",
            R,
            sampling**2 / 3.0 + light**2 / 6.0,
            ANGULAR_VARIANCE,
            tolerance=digits,
            inconsistency="a symmetric triangle on ±a has a²/6, not a²/4 (docs/errata.md)",
            contradiction=("3.3: a triangular density on ±a", "(3.4): a variance of a²/4"),
        ),
        digit_statement(
            "bound of the measurement noise",
            0.36,
            sampling + light,
            ANGLE_ERROR,
            tolerance=5e-3,
            inconsistency="the bounds of 3.3 with 1 ms and 1.5 ms make 0.196 rad",
            contradiction=("3.5: 0.36 rad", "3.3: the bounds of both noises, with 1 ms and 1.5 ms"),
        ),
    )


ITEMS = (
    Item(
        ItemKind.FIGURE,
        "3.9",
        "Angular position estimation error, 1 ms",
        _convergence(0, ANGLE_ERROR, "rad", ANGLE_BOUND, "figure-3.9"),
    ),
    Item(
        ItemKind.FIGURE,
        "3.10",
        "Angular velocity estimation error, 1 ms",
        _convergence(1, SPEED_ERROR, "rad_s", SPEED_BOUND, "figure-3.10"),
    ),
    Item(ItemKind.FIGURE, "3.11", "Angular velocity estimation, 1 ms", figure_3_11),
    Item(ItemKind.SECTION, "3.5", "Numbers of the simulated case", section_3_5),
)
