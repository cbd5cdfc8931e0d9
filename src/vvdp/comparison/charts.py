"""The figures of a comparison of estimators, as data over its tables."""

from collections.abc import Iterator

import numpy as np

from vvdp.comparison.results import Comparison, Traced
from vvdp.comparison.score_tables import SCORES, ErrorFigure, Figures, error_chart, scenario_rows
from vvdp.results.chart import Chart, Colour, Dots, Line, Lines
from vvdp.results.result import Table

BEFORE, AFTER = 0.05, 0.35
"""What is shown of a step, before it and after [s]."""
SMALLEST = 1e-3
"""Where the scales of errors begin [rad, rad/s]."""


def comparison_charts(found: Comparison, figures: Figures, scores: Table) -> Iterator[Chart]:
    """All figures that a comparison gives."""
    for quantity, unit in (("speed", "rad_s"), ("angle", "rad")):
        key = f"{quantity}_error_rms_{unit}"
        error = ErrorFigure(key, figures.kinds[key][1], SMALLEST, 0.0)
        yield error_chart(found, scores, figures, error, (f"{quantity}-error", _error_caption(quantity)))
    if found.traced:
        yield _traces(found, found.traced)
    if found.first_step:
        yield _delays(found, scores)
    words = "What a sample takes on one core, the whole record divided by its samples, logarithmic."
    cost = Dots(names="name", value="cost_s", least=1e-9, title="cost")
    height = 0.7 + 0.16 * len(found.contenders)
    yield Chart(name="cost", caption=words, table="estimators", panels=(cost,), columns=1, height=height)


def _error_caption(quantity: str) -> str:
    caption = (
        f"Error of the {quantity} for every estimator in every scenario. Dot: root mean square over all runs; bar: "
        "where 90 % of the runs lie, so that a dot beyond its bar reports a few runs that went badly wrong. The scale "
        "is logarithmic and the same in all panels; an arrow stands for less than 0.001."
    )
    if quantity == "angle":
        caption += " Counted modulo a turn: 1.8 rad is what knowing nothing of the angle gives."
    return caption


def _delays(found: Comparison, table: Table) -> Chart:
    rows = scenario_rows(table, str(found.first_step))
    panels = tuple(
        Dots(names="estimator", value=key, least=least, title=title, rows=rows)
        for title, key, least in (("delay", "delay_s", 1e-4), ("settling time, median", "settling_median_s", 1e-2))
    )
    caption = (
        f"Delay and settling time in the scenario {found.first_step}, logarithmic. Left is better. Without a dot an "
        "estimator does not settle in most runs, or lags by more than 0.2 s in one."
    )
    height = 0.7 + 0.16 * len(found.contenders)
    return Chart(name="delay", caption=caption, table=SCORES, panels=panels, columns=2, height=height)


def _traces(found: Comparison, traced: Traced) -> Chart:
    """True and estimated speed, each estimator in a panel, around the first change of the true speed."""
    left, right = float(traced.time[0]), float(traced.time[-1])
    moving = np.flatnonzero(np.abs(np.diff(traced.speed)) > 1e-9)
    if moving.size:
        left, right = float(traced.time[moving[0]]) - BEFORE, float(traced.time[moving[0]]) + AFTER
    true = traced.speed[(traced.time > left) & (traced.time < right)]
    low, high = float(np.min(true)), float(np.max(true))
    room = 0.35 * max(high - low, 0.1 * high)
    panels = tuple(
        Lines(
            lines=(
                Line(x="time_s", y=f"{name}_speed_rad_s", label="estimated", colour=Colour.INLET),
                Line(x="time_s", y="true_speed_rad_s", label="true", colour=Colour.INK),
            ),
            title=name, left=left, right=right, low=low - room, high=high + room,
        )
        for name in traced.estimated
    )  # fmt: skip
    caption = f"True and estimated speed, one run: {found.scenarios[traced.scenario].title}. All had the same edges."
    height = 0.7 + 1.25 * -(-len(panels) // 3)
    return Chart(name="speeds", caption=caption, table="traces", panels=panels, columns=3, share=True, height=height)
