"""The figures of a comparison of estimators, drawn from what was written of it."""

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from vvdp.base.display import plain
from vvdp.comparison.results import Comparison, Traced
from vvdp.report.drawing import INK, INLET, LOAD, Drawn, drawn

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLUMNS = 4
"""Panels beside each other in the figures of errors."""
BEFORE, AFTER = 0.05, 0.35
"""What is shown of a step, before it and after [s]."""
SMALLEST = 1e-3
"""Where the scales of errors begin [rad, rad/s]; what is smaller is shown by an arrow."""


class Quantity(NamedTuple):
    """What is drawn of an error: name and unit in the keys of the scores, and the unit as it is printed."""

    name: str
    unit: str
    shown: str

    def key(self, end: str = "") -> str:
        """The root mean square over all runs, or with `end` "_low" and "_high" where 90 % of the runs lie between."""
        return f"{self.name}_error_rms{end}_{self.unit}"


class Panel(NamedTuple):
    """A figure of merit for each estimator: its title and what it is measured in, the least that is shown."""

    title: str
    unit: str
    least: float
    values: Mapping[str, float]


def comparison_figures(found: Comparison) -> Iterator[Drawn]:
    """All figures that this comparison gives."""
    words = (
        "Dot: root mean square over all runs; bar: where 90 % of the runs lie, so that a dot beyond its bar tells of a "
        "few runs that went badly wrong. The scale is logarithmic and the same in all panels; an arrow stands for less "
        "than 0.001."
    )
    height = 0.55 + _rows(found) * (0.42 + 0.145 * len(found.estimators))
    for quantity in (Quantity("speed", "rad_s", "rad/s"), Quantity("angle", "rad", "rad")):
        caption = f"Error of the {quantity.name} for every estimator in every scenario. {words}"
        if quantity.name == "angle":
            caption += " Counted modulo a turn: 1.8 rad is what knowing nothing of the angle gives."
        yield drawn(f"{quantity.name}-error", caption, height, partial(_errors, found=found, quantity=quantity))
    if found.traced:
        title = found.scenarios[found.traced.scenario].title
        caption = (
            f"True speed (dark) and estimated speed (orange), one run: {title}. All estimators had the same edges."
        )
        height = 0.5 + 1.25 * -(-len(found.estimators) // 3)
        yield drawn("traces", caption, height, partial(_traces, traced=found.traced))
    panels = list(_merits(found))
    caption = "What a sample takes on one core, the whole record divided by its samples, logarithmic."
    if len(panels) > 1:
        caption = (
            f"Delay and settling time in the scenario {_stepped(found)}, and what a sample takes on one core; all "
            "logarithmic. Left is better. An arrow stands for less than the scale shows; without a dot an estimator "
            "does not settle in most runs, or lags by more than 0.2 s in one."
        )
    yield drawn(
        "delay-and-cost", caption, 0.7 + 0.16 * len(found.estimators), partial(_dots, found=found, panels=panels)
    )


def _played(found: Comparison) -> list[str]:
    return [name for name, played in found.scenarios.items() if played.runs]


def _rows(found: Comparison) -> int:
    return -(-len(_played(found)) // COLUMNS)


def _stepped(found: Comparison) -> str | None:
    """The first scenario in which the speed changes."""
    return next((name for name in _played(found) if found.scenarios[name].changes), None)


def _merits(found: Comparison) -> Iterator[Panel]:
    scenario = _stepped(found)
    if scenario is not None:
        for title, key, least in (("delay", "delay_s", 0.1), ("settling time, median", "settling_median_s", 10.0)):
            values = {name: 1e3 * found.scores[scenario, name][key].value for name in found.estimators}
            yield Panel(title, "ms", least, values)
    yield Panel("cost", "ns per sample", 1.0, {name: 1e9 * cost.value for name, cost in found.costs.items()})


def _errors(figure: "Figure", found: Comparison, quantity: Quantity) -> None:
    from matplotlib.ticker import LogLocator

    scenarios, estimators = _played(found), list(found.estimators)
    columns = min(COLUMNS, len(scenarios))
    panels = figure.subplots(_rows(found), columns, sharex=True, sharey=True, squeeze=False)
    for axes, scenario in zip(panels.flat, scenarios, strict=False):
        for place, estimator in enumerate(reversed(estimators)):
            figures = found.scores[scenario, estimator]
            middle, low, high = (figures[quantity.key(end)].value for end in ("", "_low", "_high"))
            colour = _colour(estimator, estimators)
            _dot(axes, place, middle, SMALLEST, colour)
            if middle >= SMALLEST:
                ends = np.clip([low, high], SMALLEST, None)
                axes.plot(ends, [place, place], color=colour, linewidth=3.2, alpha=0.3, solid_capstyle="round")
        axes.set_title(scenario, loc="left", pad=3.0)
        _name_rows(axes, estimators)
    largest = max(
        figures[quantity.key(end)].value for figures in found.scores.values() for end in ("", "_high")
    )  # fmt: skip
    panels[0, 0].set_xscale("log")
    panels[0, 0].xaxis.set_major_locator(LogLocator(numticks=5))
    panels[0, 0].set_xlim(SMALLEST, 2.0 * max(largest, SMALLEST))
    _label_lowest(panels, len(scenarios), f"{quantity.name} error [{quantity.shown}]")


def _dots(figure: "Figure", found: Comparison, panels: Sequence[Panel]) -> None:
    estimators = list(found.estimators)
    row = figure.subplots(1, len(panels), sharey=True, squeeze=False)[0]
    for axes, panel in zip(row, panels, strict=True):
        for place, estimator in enumerate(reversed(estimators)):
            _dot(axes, place, panel.values[estimator], panel.least, _colour(estimator, estimators))
        axes.set_xscale("log")
        axes.set_xlim(panel.least, 10.0 ** np.ceil(np.log10(1.1 * max(_finite(panel), default=10.0 * panel.least))))
        axes.xaxis.set_major_formatter(lambda value, _: plain(value))
        axes.set_title(panel.title, loc="left", pad=3.0)
        axes.set_xlabel(f"[{panel.unit}]")
        _name_rows(axes, estimators)


def _finite(panel: Panel) -> list[float]:
    return [value for value in panel.values.values() if np.isfinite(value) and value > panel.least]


def _dot(axes: "Axes", place: int, value: float, least: float, colour: str) -> None:
    """A dot, or an arrow at the edge of the scale for what is less than it shows."""
    if value < least:
        axes.plot(1.25 * least, place, "<", color=colour, markersize=4.0)
    else:
        axes.plot(value, place, "o", color=colour, markersize=3.6)


def _colour(estimator: str, estimators: Sequence[str]) -> str:
    return INLET if estimator == estimators[0] else LOAD


def _name_rows(axes: "Axes", estimators: Sequence[str]) -> None:
    axes.grid(axis="y", visible=False)
    axes.tick_params(axis="y", length=0)
    axes.set_yticks(range(len(estimators)), estimators[::-1])
    axes.set_ylim(-0.7, len(estimators) - 0.3)


def _traces(figure: "Figure", traced: Traced) -> None:
    names = list(traced.estimated)
    columns = min(3, len(names))
    panels = figure.subplots(-(-len(names) // columns), columns, sharex=True, sharey=True, squeeze=False)
    part = _shown(traced)
    time, true = traced.time[part], traced.speed[part]
    low, high = float(np.min(true)), float(np.max(true))
    room = 0.35 * max(high - low, 0.1 * high)
    for axes, name in zip(panels.flat, names, strict=False):
        axes.plot(time, traced.estimated[name][part], color=INLET, linewidth=1.1)
        axes.plot(time, true, color=INK, linewidth=1.1)
        axes.set_title(name, loc="left", pad=3.0)
        axes.set_ylim(low - room, high + room)
        axes.set_xlim(time[0], time[-1])
    for axes in panels[:, 0]:
        axes.set_ylabel("speed [rad/s]")
    _label_lowest(panels, len(names), "time [s]")


def _label_lowest(panels: Any, used: int, label: str) -> None:
    """Labels the lowest panel of each column and hides the spare ones."""
    columns = panels.shape[1]
    for spare in panels.flat[used:]:
        spare.set_visible(False)
    for k, axes in enumerate(panels.flat[:used]):
        if k + columns >= used:
            axes.set_xlabel(label)
            axes.tick_params(axis="x", labelbottom=True)


def _shown(traced: Traced) -> Any:
    """The samples around the first change of the true speed, all where it never changes."""
    moving = np.flatnonzero(np.abs(np.diff(traced.speed)) > 1e-9)
    if not moving.size:
        return slice(0, None)
    begin = traced.time[moving[0]]
    return (traced.time > begin - BEFORE) & (traced.time < begin + AFTER)
