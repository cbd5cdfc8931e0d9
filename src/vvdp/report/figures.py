"""The figures of any circuit's report. Each is drawn from a result directory alone, again with the same bytes."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.network.nodes import DrivenShaft, Rod, Shaft
from vvdp.report.drawing import INK, INLET, LOAD, RELIEF, TANK, Drawn, drawn, legend
from vvdp.report.reading import BAR, LPM, Reading
from vvdp.report.wording import fixed, percent, plain
from vvdp.systems.overview import loss_lines, power_lines

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

RPM = 2.0 * np.pi / 60.0
COLOURS = (LOAD, INLET, TANK, RELIEF, "#2f7d4f", "#a3180c", "#8a6bbf", "#b9a13c")
STYLES = ("-", "--", ":")
MOST_LINES = len(COLOURS) * len(STYLES)
"""Most lines of one picture."""


class Course(NamedTuple):
    """A line of a picture: its name and values over the rows of the run."""

    name: str
    values: Array


def detail(reading: Reading) -> Iterator[Drawn]:
    """Pressures of the volumes and flows of the components over the last periods or the finely recorded part."""
    part = reading.detail() if reading.detail().periods else reading.fine()
    t = 1e3 * reading.results.times[part.rows]
    panels = _pressures_and_flows(reading, part.rows)
    if t.size < 2 or not panels:
        return
    count = part.periods
    periods = reading.period if count == 1 else f"{count} {reading.period}s"
    words = f"The last {periods}" if count else "The end of the run"
    words += f", recorded every {plain(1e6 * part.interval, 4)} µs: pressures of all volumes, flows of all components."
    yield drawn("detail", words + _left_out(reading), _height(panels), lambda f: _lines(f, t, "time [ms]", panels))


def whole(reading: Reading) -> Iterator[Drawn]:
    """The same over the whole run."""
    t = reading.results.times
    panels = _pressures_and_flows(reading, np.arange(t.size))
    if t.size < 2 or not panels:
        return
    interval = plain(1e3 * reading.system.stepping.record_interval, 4)
    words = f"The whole run, recorded every {interval} ms"
    begin = reading.fine_from()
    words += f" and finely from {plain(float(t[begin]), 4)} s on" if begin else ""
    words += "; peaks between the records are not seen here but in the table of nodes."
    yield drawn("run", words, _height(panels), lambda f: _lines(f, t, "time [s]", panels))


def motion(reading: Reading) -> Iterator[Drawn]:
    """Shafts, rods and the commands of programs over the whole run."""
    t = reading.results.times
    panels = list(_motions(reading))
    if t.size < 2 or not panels:
        return
    words = "Shafts, rods and the commands of programs over the whole run."
    yield drawn("motion", words, _height(panels), lambda f: _lines(f, t, "time [s]", panels))


def losses(reading: Reading) -> Iterator[Drawn]:
    """What each component turns to heat."""
    found = [(line.component, line.loss) for line in loss_lines(reading.system, reading.results.summary)]
    parts = sorted((each for each in found if each[1] > 0.0), key=lambda each: each[1])
    if not parts:
        return
    powers = (power for _, power in power_lines(reading.system, reading.results.summary))
    put_in = sum(power for power in powers if power > 0.0)
    words = "Mean power turned to heat by each component over the averaging window; shares are of the power put in."
    yield drawn("losses", words, 0.9 + 0.24 * len(parts), lambda f: _bars(f, parts, put_in))


def _pressures_and_flows(reading: Reading, rows: "np.ndarray[tuple[int], np.dtype[np.intp]]") -> list["Panel"]:
    pressures = [Course(_said(name), reading.pressure(name)[rows] / BAR) for name in reading.volumes]
    flows = [Course(_said(name), values[rows] / LPM) for name, values in reading.flows()]
    flows = [course for course in flows if np.any(course.values != 0.0)]
    return [Panel(label, courses[:MOST_LINES]) for label, courses in
            (("pressure [bar]", pressures), ("flow [lpm]", flows)) if courses]  # fmt: skip


class Panel(NamedTuple):
    """One set of axes: its label and lines."""

    label: str
    courses: Sequence[Course]


def _left_out(reading: Reading) -> str:
    count = max(len(reading.volumes), len(list(reading.flows()))) - MOST_LINES
    return f" Only the first {MOST_LINES} of each are shown." if count > 0 else ""


def _motions(reading: Reading) -> Iterator[Panel]:
    nodes = reading.network.nodes
    shafts = [name for name, node in nodes.items() if isinstance(node, Shaft)]
    rods = [name for name, node in nodes.items() if isinstance(node, Rod)]
    for label, scale, path, names in (
        ("speed [rpm]", RPM, "speed", shafts),
        ("position [mm]", 1e-3, "position", rods),
        ("velocity [m/s]", 1.0, "velocity", rods),
    ):
        if names:
            yield Panel(label, [Course(_said(name), reading.state(f"{name}.{path}") / scale) for name in names])
    turned = [name for name, node in nodes.items() if isinstance(node, DrivenShaft) and name in reading.results.states]
    t = reading.results.times
    moving = [(name, np.gradient(reading.state(name), t) / RPM) for name in turned if t.size > 2]
    changing = [Course(_said(n), speed) for n, speed in moving if np.ptp(speed) > 1e-6 * (1.0 + np.max(np.abs(speed)))]
    if changing:
        yield Panel("driven speed [rpm]", changing)
    for program in reading.network.programs:
        series = {path: each for path, each in reading.results.commands.items() if path.startswith(f"{program}.")}
        for unit in dict.fromkeys(each.unit for each in series.values()):
            courses = [
                Course(_said(path.partition(".")[2]), each.values)
                for path, each in series.items()
                if each.unit == unit and each.values.ndim == 1
            ]
            if courses:
                yield Panel(f"{_said(program)} [{unit}]", courses[:MOST_LINES])


def _said(name: str) -> str:
    return name.replace("_", " ")


def _height(panels: Sequence[Panel]) -> float:
    rows = sum(-(-len(panel.courses) // 5) for panel in panels)
    return 0.5 + 1.45 * len(panels) + 0.17 * rows


def _lines(figure: "Figure", x: Array, label: str, panels: Sequence[Panel]) -> None:
    """One set of axes for each panel, one below the other."""
    several = np.atleast_1d(figure.subplots(len(panels), 1, sharex=True))
    for axes, panel in zip(several, panels, strict=True):
        for number, course in enumerate(panel.courses):
            colour, style = COLOURS[number % len(COLOURS)], STYLES[number // len(COLOURS)]
            axes.plot(x, course.values, color=colour, linestyle=style, linewidth=1.2, label=course.name)
        axes.set_ylabel(panel.label)
        axes.margins(y=0.08)
        legend(axes, 5)
    several[-1].set_xlabel(label)
    several[-1].set_xlim(x[0], x[-1])
    figure.align_ylabels()


def _bars(figure: "Figure", parts: Sequence[tuple[str, float]], whole: float) -> None:
    axes: Axes = figure.subplots(1, 1)
    bars = axes.barh(range(len(parts)), [power for _, power in parts], height=0.62, color=LOAD)
    said = [
        f"{fixed(power, 0 if power >= 100 else 1)} W" + (f", {percent(power / whole)}" if whole > 0.0 else "")
        for _, power in parts
    ]
    axes.bar_label(bars, said, padding=3, fontsize=7.0, color=INK)
    axes.set_yticks(range(len(parts)), [_said(name) for name, _ in parts])
    axes.set_xlabel("loss [W]")
    axes.grid(axis="y", visible=False)
    axes.tick_params(axis="y", length=0)
    axes.set_xlim(0.0, 1.25 * max(power for _, power in parts))
