"""The figures of a run of a test rig of the rotary valve, as data."""

from collections.abc import Iterator

import numpy as np

from vvdp.base.display import percent, with_unit
from vvdp.base.kinds import FREQUENCY
from vvdp.evaluation.bench import RotaryBench
from vvdp.programs.estimate_report import SETTLED, UNITS, of_what
from vvdp.results.chart import Chart, Colour, Level, Line, Lines, Stroke
from vvdp.results.result import Table
from vvdp.runs.charts import SERIES, detail_words, upright, whole_words
from vvdp.runs.run import RecordedRun

CYCLE, SPECTRUM = "cycle", "amplitudes"
"""Names of the tables beside that of the series."""
CYCLE_CHART, SPECTRUM_CHART = "cycle-angle", "spectrum"
"""Names of the charts that they are for."""
SHOWN = 0.99
"""Share of the errors and of their bands to which the scale of their figure is fitted."""


def bench_charts(run: RecordedRun, bench: RotaryBench, series: Table, more: dict[str, Table]) -> Iterator[Chart]:
    """The course of a run: last periods over time and angle, whole run, speed, estimate, spectrum."""
    part = run.detail()
    ends = (float(run.times[part.rows[0]]), float(run.times[part.rows[-1]]))
    caption = f"Pressures, flows and open areas over time. {detail_words(run, part)}"
    panels = cycle_panels("time_s", upright(part.marks), ends)
    yield Chart(name="cycle-time", caption=caption, table=SERIES, panels=panels, height=4.45)
    if CYCLE in more:
        caption = (
            "The same over the spool's angle within a PWM period; periods lie on top of each other where the run "
            "repeats itself. Load and tank port are open in turn."
        )
        panels = cycle_panels("angle_rad")
        yield Chart(name=CYCLE_CHART, caption=caption, table=CYCLE, panels=panels, height=4.45)
    yield _whole(run)
    yield _speed(run, bench)
    if bench.watch:
        yield _estimate(run, bench, series)
    if SPECTRUM in more:
        yield _spectrum(more[SPECTRUM])


def cycle_panels(
    x: str, levels: tuple[Level, ...] = (), ends: tuple[float | None, float | None] = (None, None)
) -> tuple[Lines, ...]:
    """Pressures, flows and open areas of a bench over a column, seen between two values of it [SI]."""

    def line(y: str, colour: Colour, stroke: Stroke = Stroke.SOLID, width: float = 1.3) -> Line:
        return Line(x=x, y=y, colour=colour, stroke=stroke, width=width)

    pressures = (line("inlet_pressure_Pa", Colour.INLET), line("load_pressure_Pa", Colour.LOAD, width=1.7))
    flows = (
        line("pump_flow_m3_s", Colour.FAINT, width=2.4),
        line("load_flow_m3_s", Colour.LOAD),
        line("tank_flow_m3_s", Colour.TANK),
        line("relief_flow_m3_s", Colour.RELIEF),
    )
    areas = (line("load_port_m2", Colour.LOAD), line("tank_port_m2", Colour.TANK))
    return tuple(
        Lines(lines=lines, label=label, levels=levels, left=ends[0], right=ends[1], height=height)
        for lines, label, height in ((pressures, "pressure", 1.15), (flows, "flow", 1.15), (areas, "open area", 0.8))
    )


def _whole(run: RecordedRun) -> Chart:
    ends = (run.numbers[f"pressure_{end}_inlet_Pa"] for end in ("min", "max"))
    low, high = (with_unit(end.value, end.kind) for end in ends)
    pressures = [
        Line(x="time_s", y="inlet_pressure_Pa", colour=Colour.INLET, width=0.5),
        Line(x="time_s", y="load_pressure_Pa", colour=Colour.LOAD),
    ]
    flow = "load_flow_m3_s"
    if run.record.mark_times.size > 1:
        pressures.append(Line(x="time_s", y="inlet_pressure_mean_Pa", colour=Colour.INK, stroke=Stroke.DASHED))
        flow = "load_flow_mean_m3_s"
    caption = f"{whole_words(run)} Over every step of the run the inlet pressure went from {low} to {high}."
    panels = (
        Lines(lines=tuple(pressures), label="pressure", height=1.4),
        Lines(lines=(Line(x="time_s", y=flow, colour=Colour.LOAD),), label="load flow"),
    )
    return Chart(name="run", caption=caption, table=SERIES, panels=panels, height=3.2)


def _speed(run: RecordedRun, bench: RotaryBench) -> Chart:
    analytic = ("analytic_pwm_frequency_full_open_Hz", "analytic_pwm_frequency_Hz")
    caption = "The spool's speed as PWM frequency: at each instant, and the mean of each period."
    levels: list[Level] = []
    if analytic[1] in run.summary:
        fully, averaged = (with_unit(run.number(key), FREQUENCY, 3) for key in analytic)
        caption += f" Analytic value of the fully open valve, {fully}, and averaged over the period, {averaged}."
        caption += " They are those of a spool that nothing drives but the flow." if bench.is_driven else ""
        for key, words, stroke in zip(
            analytic, ("analytic, fully open", "analytic, averaged"), (Stroke.DOTTED, Stroke.DASHED), strict=True
        ):
            levels.append(Level(value=run.number(key), label=words, colour=Colour.INLET, stroke=stroke))
    lines = [Line(x="time_s", y="pwm_frequency_Hz", label="at each instant", colour=Colour.TANK, width=0.9)]
    if run.record.mark_times.size > 1:
        lines.append(
            Line(x="time_s", y="pwm_frequency_mean_Hz", label="mean of each period", colour=Colour.LOAD, width=1.6)
        )
    panels = [Lines(lines=tuple(lines), label="PWM frequency", levels=tuple(levels), height=1.6)]
    if not bench.duty_ratio.is_constant:
        panels.append(Lines(lines=(Line(x="time_s", y="duty_ratio", colour=Colour.INK),)))
    height = 2.3 if len(panels) == 1 else 2.9
    return Chart(name="speed", caption=caption, table=SERIES, panels=tuple(panels), height=height)


def _estimate(run: RecordedRun, bench: RotaryBench, series: Table) -> Chart:
    of_speed = f"speed{of_what(bench.watch.pitch if bench.watch else 0.0)}"
    caption = (
        f"The spool as its encoder and the event-based Kalman filter see it. Top: {of_speed}, true and estimated. "
        "Middle: error of the angle, within half a turn; until the index of the code wheel is found the angle is off "
        f"by whole sectors. Bottom: error of the {of_speed}. Bands: two standard deviations, as the filter states them."
    )
    if "spool_angle_coverage" in run.summary:
        caption += f" From {SETTLED:g} s on:"
        for name, words in (("angle", " the angle"), ("speed", f"; the {of_speed}")):
            kind, unit = UNITS[name]
            error = with_unit(run.number(f"spool_{name}_error_rms_{unit}"), kind, 3)
            covered = percent(run.number(f"spool_{name}_coverage"))
            caption += f"{words} is {error} off, root mean square, {covered} of the time inside of its band"
        caption += "."
    settled = run.times >= min(SETTLED, 0.5 * run.times[-1])
    true = series["spool_speed_rad_s"][settled]
    room = max(0.5 * float(np.ptp(true)), 0.02 * float(np.abs(true).max()))
    lines = [
        Line(x="time_s", y="spool_speed_rad_s", colour=Colour.TANK, width=0.9),
        Line(x="time_s", y="estimated_speed_rad_s", colour=Colour.LOAD, width=1.1),
    ]
    if "spool_speed_mean_rad_s" in series.columns:
        lines.insert(1, Line(x="time_s", y="spool_speed_mean_rad_s", colour=Colour.INK, stroke=Stroke.DASHED))
    speeds = Lines(
        lines=tuple(lines),
        label="speed",
        low=float(true.min()) - room,  # the search at the start would flatten all that follows
        high=float(true.max()) + room,
        height=1.3,
    )
    panels = [speeds, *(_error(series, name, settled) for name in UNITS)]
    if run.number("standstill_time_s") > 0.0:
        standstill = Line(x="time_s", y="standstill", colour=Colour.INK, width=0.9)
        panels.append(Lines(lines=(standstill,), label="standstill", low=0.0, high=1.0, height=0.7))
        caption += " Below: how probable it is by the estimate that the spool stands."
    return Chart(name="estimate", caption=caption, table=SERIES, panels=tuple(panels), height=1.6 + 0.9 * len(panels))


def _error(series: Table, name: str, settled: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> Lines:
    unit = UNITS[name][1]
    error, low, high = f"{name}_error_{unit}", f"{name}_band_low_{unit}", f"{name}_band_high_{unit}"
    reach = 2.4 * max(float(np.quantile(np.abs(series[key][settled]), SHOWN)) for key in (error, high))
    lines = (Line(x="time_s", y=error, colour=Colour.LOAD, width=0.8, low=low, high=high),)
    return Lines(lines=lines, label=f"{name} error", low=-reach, high=reach)


def _spectrum(table: Table) -> Chart:
    whole = np.flatnonzero(table["order"] == 1.0)
    base = float(table["frequency_Hz"][whole[0]])
    apart = with_unit(float(table["frequency_Hz"][0]), FREQUENCY, 3)
    caption = (
        f"Amplitudes over whole PWM periods, without a window: lines {apart} apart. Dotted: multiples of the PWM "
        "frequency. Lines far below the first of them are slow change, not ripple."
    )
    line = Line(x="frequency_Hz", y="amplitude_Pa", stroke=Stroke.STEMS, colour=Colour.LOAD, width=1.4)
    multiples = upright(base * k for k in range(1, round(float(table["order"][-1])) + 1))
    panel = Lines(lines=(line,), levels=multiples, low=0.0, left=0.0)
    return Chart(name=SPECTRUM_CHART, caption=caption, table=SPECTRUM, panels=(panel,), height=2.4)
