"""The figures of a report on a test bench of the rotary valve. Drawn again they have the same bytes."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from vvdp.base.arrays import Array, Rows
from vvdp.base.signal import signal_value
from vvdp.numerics.spectrum import amplitude_spectrum
from vvdp.report.bench_losses import causes, components
from vvdp.report.drawing import FAINT, INK, INLET, LOAD, RELIEF, TANK, Drawn, drawn, legend
from vvdp.report.reading import BAR, LPM, Detail, Reading
from vvdp.report.wording import fixed, number, percent, plain
from vvdp.systems.bench import BenchSeries, RotaryBench
from vvdp.systems.spool_encoder import SETTLED, estimate_errors

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHORTEST_SPECTRUM = 64
"""Fewest samples from which a spectrum is drawn."""


@dataclass(frozen=True)
class BenchReading:
    """A result directory of a bench, with what the bench says of it."""

    reading: Reading
    bench: RotaryBench

    @cached_property
    def series(self) -> BenchSeries:
        """What the bench does over `results.times`."""
        return self.bench.series(self.reading.state, self.reading.output)

    @cached_property
    def inlet(self) -> Array:
        """Gauge inlet pressure [bar]."""
        return (self.series.inlet_pressure - self.bench.reference) / BAR

    @cached_property
    def load(self) -> Array:
        """Gauge load pressure [bar]."""
        return (self.series.load_pressure - self.bench.reference) / BAR


def course(reading: Reading, bench: RotaryBench) -> Iterator[Drawn]:
    """The figures of the course of a run."""
    seen = BenchReading(reading, bench)
    detail = reading.detail()
    what = _detail_words(reading, detail)
    yield drawn("cycle-time", f"Pressures, flows and open areas over time. {what}", 4.45, _cycle(seen, detail, False))
    if detail.periods:
        caption = (
            f"The same over the spool's angle within a PWM period; the last {_periods(detail.periods)} lie on top of "
            "each other where the run repeats itself. Load and tank port are open in turn."
        )
        yield drawn("cycle-angle", caption, 4.45, _cycle(seen, detail, True))
    yield drawn("run", _run_caption(reading), 3.2, lambda figure: _run(figure, seen))
    yield drawn("speed", _speed_caption(seen), _speed_height(bench), lambda figure: _speed(figure, seen))
    if bench.is_watched:
        yield drawn("estimate", _estimate_caption(reading), 4.3, lambda figure: _estimate(figure, seen))
    ripple = _ripple(seen)
    if ripple is not None:
        yield drawn("spectrum", ripple[2], 2.4, lambda figure: _spectrum(figure, reading, ripple[0], ripple[1]))


def losses(reading: Reading) -> Iterator[Drawn]:
    """The figure of the losses by component and by cause."""
    yield drawn("losses", _loss_caption(reading), 3.0, lambda figure: _losses(figure, reading))


def _periods(count: int) -> str:
    return "PWM period" if count == 1 else f"{count} PWM periods"


def _detail_words(reading: Reading, detail: Detail) -> str:
    interval = f"{plain(1e6 * detail.interval, 4)} µs"
    if detail.periods >= 3:
        words = "The last three whole PWM periods of the run"
    elif detail.periods:
        words = f"Only {_periods(detail.periods)} passed in the finely recorded part of the run; shown is what there is"
    else:
        words = "No whole PWM period passed in the finely recorded part of the run; shown is its last piece"
    coarse = "" if reading.is_fine else "; the run ended before its finely recorded part, so details are missing"
    return f"{words}, recorded every {interval}{coarse}."


def _cycle(seen: BenchReading, detail: Detail, over_angle: bool) -> Callable[["Figure"], None]:
    rows, series, valve = detail.rows, seen.series, seen.bench.valve
    pitch = 360.0 / valve.sections
    x = 1e3 * seen.reading.results.times[rows]
    breaks: Rows = np.zeros(0, int)
    if over_angle:
        x = np.mod(np.degrees(series.spool_angle[rows]), pitch)
        breaks = np.flatnonzero(np.abs(np.diff(x)) > 0.5 * pitch) + 1

    def line(axes: "Axes", values: Array, colour: str, style: str, name: str, width: float = 1.3) -> None:
        apart = np.insert(values[rows], breaks, np.nan)
        axes.plot(np.insert(x, breaks, np.nan), apart, color=colour, linestyle=style, linewidth=width, label=name)

    def draw(figure: "Figure") -> None:
        pressures, flows, areas = figure.subplots(3, 1, sharex=True, height_ratios=[1.15, 1.15, 0.8])
        line(pressures, seen.inlet, INLET, "-", "inlet")
        line(pressures, seen.load, LOAD, "-", "load", 1.7)
        pressures.set_ylabel("pressure [bar]")
        pressures.set_ylim(bottom=min(0.0, pressures.get_ylim()[0]))
        legend(pressures, 2)
        for flow, colour, style, words, width in (
            (series.pump_flow, FAINT, "-", "pump", 2.4),
            (series.load_flow, LOAD, "-", "to load", 1.3),
            (series.tank_flow, TANK, "-", "to tank", 1.3),
            (series.relief_flow, RELIEF, "--", "relief valve", 1.3),
        ):
            line(flows, flow / LPM, colour, style, words, width)
        flows.set_ylabel("flow [lpm]")
        legend(flows, 4)
        area = 1e6 * valve.nozzle_area
        line(areas, area * series.load_opening, LOAD, "-", "load port")
        line(areas, area * series.tank_opening, TANK, "-", "tank port")
        areas.set_ylabel("open area [mm²]")
        areas.set_xlabel("spool angle within the PWM period [°]" if over_angle else "time [ms]")
        legend(areas, 2)
        if over_angle:
            areas.set_xlim(0.0, pitch)
            areas.set_xticks(np.linspace(0.0, pitch, 9))
        else:
            areas.set_xlim(x[0], x[-1])
            for axes in (pressures, flows, areas):
                for mark in detail.marks:
                    axes.axvline(1e3 * mark, color="#9aa3ac", linewidth=0.7, linestyle=(0, (1, 2)), zorder=0.5)
        figure.align_ylabels()

    return draw


def _run_caption(reading: Reading) -> str:
    t, begin = reading.results.times, reading.fine_from()
    low, high = (fixed(reading.number(f"pressure_{end}_inlet_Pa") / BAR, 1) for end in ("min", "max"))
    between = "within each PWM period" if reading.results.mark_times.size >= 2 else "within each sixtieth of the run"
    first = reading.system.stepping.record_interval if begin or not reading.is_fine else reading.fine_interval
    coarse = f"{plain(1e3 * first, 4)} ms"
    fine = (
        f" and every {plain(1e6 * reading.fine_interval, 4)} µs from {plain(float(t[begin]), 4)} s on" if begin else ""
    )
    mean = "Load flow: mean of each PWM period." if reading.results.mark_times.size >= 2 else "Load flow: as recorded."
    return (
        f"The whole run. Band: smallest and largest recorded inlet pressure {between}. Rows are recorded every "
        f"{coarse}{fine}, so peaks between them are not in the band; over every step of the run the inlet pressure "
        f"went from {low} to {high} bar. {mean}"
    )


def _run(figure: "Figure", seen: BenchReading) -> None:
    reading, bench = seen.reading, seen.bench
    pressures, flows = figure.subplots(2, 1, sharex=True, height_ratios=[1.4, 1.0])
    t, marks = reading.results.times, reading.results.mark_times
    middle, low, high = reading.period_extremes(seen.inlet)
    pressures.fill_between(
        middle, low, high, facecolor="#f7dcc0", edgecolor="#efbd8c", linewidth=0.8, label="inlet, band"
    )
    if marks.size >= 2:
        centre = 0.5 * (marks[:-1] + marks[1:])
        inlet = reading.period_means(bench.INLET_TOTAL) - bench.reference
        pressures.plot(centre, inlet / BAR, color=INLET, linestyle="--", label="inlet, mean of each period")
        flows.plot(centre, reading.period_means(bench.LOAD_FLOW_TOTAL) / LPM, color=LOAD, marker=".", markersize=3.0)
    else:
        flows.plot(t, seen.series.load_flow / LPM, color=LOAD)
    pressures.plot(t, seen.load, color=LOAD, linewidth=1.1, label="load")
    pressures.set_ylabel("pressure [bar]")
    pressures.set_ylim(bottom=min(0.0, float(np.min(low))))
    flows.set_ylabel("load flow [lpm]")
    bottom, top = flows.get_ylim()
    flows.set_ylim(min(0.0, bottom), top + 0.12 * (top - min(0.0, bottom)))
    flows.set_xlabel("time [s]")
    flows.set_xlim(t[0], t[-1])
    legend(pressures, 3)
    figure.align_ylabels()


def _speed_caption(seen: BenchReading) -> str:
    reading = seen.reading
    words = "The spool's speed as PWM frequency (scale on the left) and in rpm (scale on the right)."
    if "analytic_pwm_frequency_Hz" in reading.results.summary:
        both = [number(reading.number(f"analytic_pwm_frequency_{end}"), 3) for end in ("full_open_Hz", "Hz")]
        words += (
            f" Lines: analytic value of the fully open valve, {both[0]} Hz, and averaged over the period, {both[1]} Hz."
        )
        if seen.bench.is_driven:
            words += " They are those of a spool that nothing drives but the flow."
    return words


def _speed_height(bench: RotaryBench) -> float:
    return 2.3 if bench.duty_ratio.is_constant else 2.9


def _speed(figure: "Figure", seen: BenchReading) -> None:
    reading, bench = seen.reading, seen.bench
    steady = bench.duty_ratio.is_constant
    panels = [figure.subplots(1, 1)] if steady else list(figure.subplots(2, 1, sharex=True, height_ratios=[1.6, 1.0]))
    axes, t, marks = panels[0], reading.results.times, reading.results.mark_times
    sections = bench.valve.sections
    axes.plot(
        t,
        seen.series.spool_speed * sections / (2 * np.pi),
        color=TANK,
        linewidth=0.9,
        label="at each instant",
    )
    if marks.size >= 2:
        axes.plot(
            0.5 * (marks[:-1] + marks[1:]), 1.0 / np.diff(marks), color=LOAD, linewidth=1.6, label="mean of each period"
        )
    for key, style, name in (
        ("full_open_Hz", (0, (1, 1.5)), "analytic, fully open"),
        ("Hz", "--", "analytic, averaged"),
    ):
        if (value := reading.number(f"analytic_pwm_frequency_{key}")) == value:
            axes.axhline(value, color=INLET, linestyle=style, linewidth=1.2, label=name)
    axes.set_ylabel("PWM frequency [Hz]")
    in_rpm: Any = (lambda f: 60.0 * f / sections, lambda n: n * sections / 60.0)
    rpm = axes.secondary_yaxis("right", functions=in_rpm)
    rpm.set_ylabel("spool speed [rpm]")
    rpm.spines["right"].set_visible(True)
    legend(axes, 4)
    if not steady:
        panels[1].plot(t, _duty_ratios(bench, t), color=INK)
        panels[1].set_ylabel("duty ratio [1]")
        panels[1].margins(y=0.15)
    panels[-1].set_xlabel("time [s]")
    panels[-1].set_xlim(t[0], t[-1])
    figure.align_ylabels(panels)


def _estimate_caption(reading: Reading) -> str:
    words = (
        "The spool as its encoder and the event-based Kalman filter see it. Top: speed, true and estimated. Middle: "
        "error of the angle, within half a turn; until the index of the code wheel is found the angle is off by whole "
        "sectors. Bottom: error of the speed. Bands: two standard deviations, as the filter states them; it takes the "
        "acceleration as noise, so the speed's ripple within each PWM period lies outside."
    )
    if "spool_angle_error_rms_rad" in reading.results.summary:
        angle, speed = (reading.number(f"spool_{what}") for what in ("angle_error_rms_rad", "speed_error_rms_rad_s"))
        words += f" Root mean square from 0.5 s on: {number(angle, 3)} rad and {number(speed, 3)} rad/s."
    return words


def _estimate(figure: "Figure", seen: BenchReading) -> None:
    speeds, angles, errors = figure.subplots(3, 1, sharex=True, height_ratios=[1.3, 1.0, 1.0])
    t, shown = seen.reading.results.times, seen.bench.estimate(seen.reading.command)
    speed = seen.series.spool_speed
    angle_error, speed_error = estimate_errors(t, seen.series.spool_angle, speed, shown)
    speeds.plot(t, speed, color=TANK, linewidth=0.9, label="true")
    speeds.plot(t, shown["speed"], color=LOAD, linewidth=1.1, label="estimated")
    speeds.set_ylabel("speed [rad/s]")
    settled = t >= min(SETTLED, 0.5 * t[-1])
    low, high = float(np.min(speed[settled])), float(np.max(speed[settled]))
    room = max(1.5 * (high - low), 0.02 * abs(high))
    speeds.set_ylim(low - room, high + room)  # the search at the start would flatten all that follows
    legend(speeds, 2)
    for axes, error, deviation, label in (
        (angles, angle_error, shown["angle_deviation"], "angle error [rad]"),
        (errors, speed_error, shown["speed_deviation"], "speed error [rad/s]"),
    ):
        reach = 1.2 * max(float(np.max(np.abs(error[settled]))), float(np.max(2.0 * deviation[settled])))
        axes.fill_between(t, -2.0 * deviation, 2.0 * deviation, facecolor="#f7dcc0", edgecolor="none")
        axes.plot(t, error, color=LOAD, linewidth=0.8)
        axes.axhline(0.0, color=INK, linewidth=0.6)
        axes.set_ylabel(label)
        axes.set_ylim(-2.0 * reach, 2.0 * reach)
    errors.set_xlabel("time [s]")
    errors.set_xlim(t[0], t[-1])
    figure.align_ylabels()


def _duty_ratios(bench: RotaryBench, times: Array) -> Array:
    return np.array([signal_value(float(t), bench.duty_ratio) for t in times])


def _loss_caption(reading: Reading) -> str:
    words = "Mean losses over the averaging window. Left: where the simulated power is lost."
    if any(np.isfinite(c.analytic) for c in causes(reading)):
        return words + " Right: by cause, beside the analytic formulas."
    return words + " Right: by cause; there is no analytic value at this operating point."


def _losses(figure: "Figure", reading: Reading) -> None:
    left, right = figure.subplots(1, 2, width_ratios=[1.0, 1.0])
    power = reading.number("input_power_W") + reading.number("spool_motor_power_W")
    parts = sorted((c for c in components(reading) if c.simulated > 0.0), key=lambda c: c.simulated)
    _bars(left, [c.name for c in parts], [c.simulated for c in parts], [0.0] * len(parts), 0.62, LOAD, "", power)
    left.set_title("by component, simulated", loc="left")
    shared = [c for c in causes(reading) if c.simulated > 0.0 or c.analytic > 0.0][::-1]
    names = [c.name for c in shared]
    compared = any(np.isfinite(c.analytic) for c in shared)
    shift = 0.19 if compared else 0.0
    _bars(right, names, [c.simulated for c in shared], [shift] * len(shared), 0.34, LOAD, "simulated", power)
    if compared:
        _bars(right, names, [c.analytic for c in shared], [-shift] * len(shared), 0.34, INLET, "analytic", power)
    right.set_title("by cause", loc="left")
    for axes in (left, right):
        axes.set_xlabel("loss [W]")
        axes.grid(axis="y", visible=False)
        axes.tick_params(axis="y", length=0)
        axes.set_xlim(0.0, 1.42 * max(axes.get_xlim()[1] / 1.05, 1e-3))
    if compared:
        right.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, handlelength=1.0, columnspacing=1.2)


def _bars(
    axes: "Axes",
    names: Sequence[str],
    powers: Sequence[float],
    shift: Sequence[float],
    height: float,
    colour: str,
    label: str,
    whole: float,
) -> None:
    places = np.arange(len(names)) + np.asarray(shift)
    bars = axes.barh(places, np.nan_to_num(powers), height=height, color=colour, label=label)
    shown = [f"{fixed(p, 0 if p >= 100 else 1)} W" + (f", {percent(p / whole)}" if whole > 0 else "") for p in powers]
    axes.bar_label(
        bars,
        [s if np.isfinite(p) else "" for s, p in zip(shown, powers, strict=True)],
        padding=3,
        fontsize=7.0,
        color=INK,
    )
    axes.set_yticks(range(len(names)), names)


def _ripple(seen: BenchReading) -> tuple[Array, Array, str] | None:
    """Frequencies and amplitudes [Hz, bar] of the load pressure, or the inlet's where the load is held; a caption."""
    reading = seen.reading
    part = reading.fine()
    if part.rows.size < SHORTEST_SPECTRUM or not reading.is_fine:
        return None
    pressure, name = (seen.load, "load") if seen.bench.makes_pressure else (seen.inlet, "inlet")
    t = reading.results.times[part.rows]
    samples = int((t[-1] - t[0]) / part.interval)
    even = t[0] + part.interval * np.arange(samples)
    found = amplitude_spectrum(np.interp(even, t, pressure[part.rows]), part.interval)
    over = f"{_periods(part.periods)}" if part.periods else "the finely recorded part"
    words = (
        f"Amplitudes of the {name} pressure over {over} ({fixed(1e3 * (t[-1] - t[0]), 0)} ms, Hann window, lines "
        f"{number(float(found.frequencies[1]), 3)} Hz apart)."
    )
    if part.periods:
        words += (
            " Dotted: multiples of the PWM frequency; the numbers are the amplitudes there. Lines far below the first"
        )
        words += " of them are slow change, not ripple."
    return found.frequencies, found.amplitudes, words


def _spectrum(figure: "Figure", reading: Reading, frequencies: Array, amplitudes: Array) -> None:
    axes = figure.subplots(1, 1)
    part = reading.fine()
    base = part.periods / (part.marks[-1] - part.marks[0]) if part.periods else 0.0
    highest = min(float(frequencies[-1]), 10.6 * base if base else 1000.0)
    inside = (frequencies <= highest) & (frequencies > 0.0)
    top = float(np.max(amplitudes[inside], initial=1e-9))
    axes.vlines(frequencies[inside], 0.0, amplitudes[inside], color=LOAD, linewidth=1.4)
    axes.set_ylim(0.0, 1.16 * top)
    axes.set_xlim(0.0, highest)
    for k in range(1, int(highest / base) + 1 if base else 0):
        axes.axvline(k * base, color="#9aa3ac", linewidth=0.8, linestyle=(0, (1, 2)), zorder=0.5)
        size = float(np.max(amplitudes[np.abs(frequencies - k * base) <= 1.5 * frequencies[1]], initial=0.0))
        axes.annotate(
            number(size, 2), (k * base, size), (0, 3), textcoords="offset points", ha="center", fontsize=7.0, color=INK,
            bbox={"boxstyle": "square,pad=0.1", "facecolor": "white", "edgecolor": "none"},
        )  # fmt: skip
    axes.set_xlabel("frequency [Hz]")
    axes.set_ylabel("amplitude [bar]")
