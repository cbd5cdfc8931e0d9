"""The figures of test rigs and maps, drawn from what a rig has left."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import plain
from vvdp.report.drawing import FAINT, INK, INLET, LOAD, RELIEF, TANK, Drawn, drawn, legend
from vvdp.rigs.conditions import CELSIUS, RPM
from vvdp.rigs.result import RigResult, Sheet

BAR = 1e5
LPM = 1e-3 / 60.0

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_MAPS = 6
"""Pairs of pump speed and temperature that get a figure of their own."""
MOST_LINES = 6
SHOWN_BACKWARDS = 0.1
"""Of the pump flow: no more is shown of a flow that comes back from the load."""
EDGE = 0.07
"""Of the width and height of a picture: closer to its edge no label stands."""
LEVELS = np.arange(0.0, 1.01, 0.1)
COLOURS = (LOAD, INLET, TANK, "#7a4fa3", "#2f7f4f", RELIEF)
EFFICIENCIES = (
    ("volumetric_efficiency", "volumetric"),
    ("hydromechanical_efficiency", "hydromechanical"),
    ("overall_efficiency", "overall"),
)


def rig_figures(result: RigResult) -> Iterator[Drawn]:
    """All figures that this result gives."""
    yield from FIGURES[result.rig](result)


def shades(count: int) -> list[Any]:
    """`count` shades of one colour, light to dark: for lines in an order."""
    from matplotlib.colors import LinearSegmentedColormap

    ramp = LinearSegmentedColormap.from_list("shades", ["#a9cce4", TANK, "#2f6ea3", LOAD, "#061d38"])
    return [ramp(x) for x in np.linspace(0.0, 1.0, max(count, 2))][:count] if count > 1 else [LOAD]


def chosen(count: int, most: int = MOST_LINES) -> Array:
    """Places of at most `most` of `count` values, the ends among them."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(int))


def line_legend(axes: "Axes", title: str) -> None:
    """A legend beside the axes, in the order of the lines."""
    axes.legend(loc="center left", bbox_to_anchor=(1.02, 0.5), title=title, alignment="left")


class _Grid:
    """A sheet over temperature, pump speed, load pressure and duty ratio."""

    def __init__(self, sheet: Sheet) -> None:
        self.sheet = sheet
        names = ("oil_temperature_K", "pump_speed_rad_s", "load_pressure_Pa", "duty_ratio")
        self.axes = [np.unique(sheet[name]) for name in names]
        self.shape = tuple(axis.size for axis in self.axes)

    def __getitem__(self, name: str) -> Array:
        return np.asarray(self.sheet[name], float).reshape(self.shape)

    @property
    def pairs(self) -> list[tuple[int, int]]:
        """Places of temperature and pump speed."""
        return [(i, k) for i in range(self.shape[0]) for k in range(self.shape[1])]

    def words(self, i: int, k: int) -> str:
        """Temperature and pump speed."""
        return f"{plain(self.axes[0][i] - CELSIUS, 4)} °C, {plain(self.axes[1][k] / RPM, 4)} rpm"


def _map(result: RigResult) -> Iterator[Drawn]:
    grid = _Grid(result.sheets["map"])
    rated = result.numbers["motor_rated_power_W"]
    pairs = [grid.pairs[place] for place in chosen(len(grid.pairs), MOST_MAPS)]
    for number, (i, k) in enumerate(pairs, 1):
        ending = f"-{number}" if len(pairs) > 1 else ""
        words = f" At {grid.words(i, k)}." if len(grid.pairs) > 1 else ""
        caption = (
            f"Delivered flow and input power over the duty ratio, a line for each load pressure. Dotted: the derived "
            f"flow, duty ratio times pump flow; dashed: the rated power of the motor, where it lies in the "
            f"picture.{_backwards(grid, i, k)}{words}"
        )
        yield drawn(f"flow{ending}", caption, 2.9, partial(_flow, grid=grid, i=i, k=k, rated=rated / 1e3))
        if grid.shape[2] > 1 and grid.shape[3] > 1:
            caption = (
                "Efficiencies over duty ratio and load pressure. Hatched: the input power exceeds the rated power of "
                f"the motor; grey: no result.{words}"
            )
            yield drawn(f"efficiency{ending}", caption, 2.75, partial(_efficiencies, grid=grid, i=i, k=k, rated=rated))
        else:
            caption = f"Efficiencies. Hollow: the input power exceeds the rated power of the motor.{words}"
            yield drawn(f"efficiency{ending}", caption, 2.75, partial(_efficiency_lines, grid=grid, i=i, k=k))
    if len(grid.pairs) > 1:
        caption = "Overall efficiency over the duty ratio at the middle load pressure, by pump speed and temperature."
        yield drawn("conditions", caption, 2.7, lambda f: _by_condition(f, grid))


def _backwards(grid: _Grid, i: int, k: int) -> str:
    """What the caption says where a load above the relief setting sends flow back: it is not drawn to its end."""
    flow, pump_flow = (known(grid[name][i, k]) for name in ("delivered_flow_m3_s", "mean_pump_flow_m3_s"))
    if not flow.size or flow.min() >= -SHOWN_BACKWARDS * pump_flow.max():
        return ""
    least = plain(flow.min() / LPM, 3)
    return f" A load above the relief setting drives oil backwards, down to {least} lpm; the picture ends before."


def known(values: Array) -> Array:
    """Those of the values that there are."""
    found: Array = values[np.isfinite(values)]
    return found


def _flow(figure: "Figure", grid: _Grid, i: int, k: int, rated: float) -> None:
    flows, powers = figure.subplots(1, 2)
    duty, pressures = grid.axes[3], grid.axes[2]
    places = chosen(pressures.size)
    for place, colour in zip(places, shades(places.size), strict=True):
        label = f"{plain(pressures[place] / BAR, 4)}"
        style: dict[str, Any] = {"color": colour, "label": label, "marker": "." if duty.size < 30 else None}
        flows.plot(duty, grid["delivered_flow_m3_s"][i, k, place] / LPM, markersize=4.0, **style)
        powers.plot(duty, grid["input_power_W"][i, k, place] / 1e3, markersize=4.0, **style)
    pump_flow = known(grid["mean_pump_flow_m3_s"][i, k]) / LPM
    if pump_flow.size:
        flows.plot(duty, duty * pump_flow.max(), color=INK, linestyle=":", linewidth=1.0)
        flows.set_ylim(bottom=max(flows.get_ylim()[0], -SHOWN_BACKWARDS * pump_flow.max()))
    flows.set_ylabel("delivered flow [lpm]")
    powers.set_ylabel("input power [kW]")
    top = powers.get_ylim()[1]
    if rated < 1.5 * top:
        powers.axhline(rated, color=INLET, linestyle="--", linewidth=1.2)
    powers.set_ylim(bottom=0.0)
    for axes in (flows, powers):
        axes.set_xlabel("duty ratio")
        axes.set_xlim(min(0.0, duty[0]), duty[-1])
    line_legend(powers, "load [bar]")


def _pale(count: int) -> list[Any]:
    """Colours from pale to dark, none so dark that a label on it cannot be read."""
    from matplotlib import colormaps

    return [colormaps["YlGnBu"](x) for x in np.linspace(0.02, 0.72, count)]


def _efficiencies(figure: "Figure", grid: _Grid, i: int, k: int, rated: float) -> None:
    panels = figure.subplots(1, 3, sharex=True, sharey=True)
    duty, pressure = grid.axes[3], grid.axes[2] / BAR
    for axes, (name, title) in zip(panels, EFFICIENCIES, strict=True):
        values = np.ma.masked_invalid(grid[name][i, k])
        axes.set_facecolor("#e3e5e8")
        axes.grid(visible=False)
        filled = axes.contourf(duty, pressure, values, levels=LEVELS, colors=_pale(LEVELS.size - 1), extend="max")
        lines = axes.contour(duty, pressure, values, levels=LEVELS[1:-1], colors=INK, linewidths=0.5)
        labels = axes.clabel(lines, levels=LEVELS[2:-1:2], fmt=lambda value: f"{100.0 * value:.0f}", fontsize=6.5)
        for label in labels:
            place = axes.transAxes.inverted().transform(axes.transData.transform(label.get_position()))
            if np.any(place < EDGE) or np.any(place > 1.0 - EDGE):
                label.set_visible(False)
        works = np.isfinite(grid["overall_efficiency"][i, k])
        excess = np.ma.masked_invalid(np.where(works, grid["input_power_W"][i, k] / rated - 1.0, np.nan))
        if (excess > 0.0).any() and (excess < 0.0).any():
            hatched = axes.contourf(duty, pressure, excess, levels=[0.0, 1e9], colors="none", hatches=["////"])
            hatched.set_edgecolor("#ffffffb0")
            axes.contour(duty, pressure, excess, levels=[0.0], colors=INLET, linewidths=1.3)
        axes.set_title(f"{title} [%]", loc="left", pad=4.0)
        axes.set_xlabel("duty ratio")
    panels[0].set_ylabel("load pressure [bar]")
    bar = figure.colorbar(filled, ax=panels, shrink=0.95, pad=0.015, ticks=LEVELS[::2])
    bar.ax.set_yticklabels([f"{100.0 * level:.0f}" for level in LEVELS[::2]])
    bar.outline.set_visible(False)


def _efficiency_lines(figure: "Figure", grid: _Grid, i: int, k: int) -> None:
    axes = figure.subplots(1, 1)
    over_duty = grid.shape[3] > 1
    x = grid.axes[3] if over_duty else grid.axes[2] / BAR
    heavy = np.nan_to_num(grid["motor_overloaded"][i, k]).ravel() > 0.0
    for (name, title), colour in zip(EFFICIENCIES, (LOAD, TANK, INLET), strict=True):
        values = 100.0 * grid[name][i, k].ravel()
        axes.plot(x, values, color=colour, label=title)
        axes.plot(x[~heavy], values[~heavy], "o", color=colour, markersize=3.6)
        axes.plot(x[heavy], values[heavy], "o", markerfacecolor="white", markeredgecolor=colour, markersize=3.6)
    axes.set_ylabel("efficiency [%]")
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("duty ratio" if over_duty else "load pressure [bar]")
    legend(axes, 3)


def _by_condition(figure: "Figure", grid: _Grid) -> None:
    axes = figure.subplots(1, 1)
    middle = grid.shape[2] // 2
    styles = ("-", "--", ":", "-.")
    speeds = shades(grid.shape[1])
    for i, k in grid.pairs:
        values = 100.0 * grid["overall_efficiency"][i, k, middle]
        axes.plot(
            grid.axes[3], values, color=speeds[k], linestyle=styles[i % len(styles)], marker=".", markersize=4.0,
            label=grid.words(i, k),
        )  # fmt: skip
    axes.set_xlabel("duty ratio")
    axes.set_ylabel(f"overall efficiency at {plain(grid.axes[2][middle] / BAR, 4)} bar [%]")
    axes.set_ylim(bottom=0.0)
    line_legend(axes, "")


def _pressure_drop(result: RigResult) -> Iterator[Drawn]:
    sheet = result.sheets["pressure-drop"]
    caption = "Left: the open valve and its sections in series. Right: the whole valve at fixed open fractions."
    yield drawn("pressure-drop", caption, 2.9, lambda figure: _drops(figure, sheet))


def _drops(figure: "Figure", sheet: Sheet) -> None:
    sections, openings = figure.subplots(1, 2)
    temperatures, fractions = np.unique(sheet["oil_temperature_K"]), np.unique(sheet["opening"])[::-1]
    opened = (sheet["opening"] == fractions[0]) & (sheet["oil_temperature_K"] == temperatures[0])
    flow = sheet["flow_m3_s"] / LPM
    for name, words, colour in (
        ("total", "whole valve", INK),
        ("nozzle", "nozzles", INLET),
        ("outlet_turbine", "outlet turbine", TANK),
        ("centre_section", "centre section", LOAD),
    ):
        sections.plot(flow[opened], sheet[f"pressure_drop_{name}_Pa"][opened] / BAR, color=colour, label=words)
    legend(sections, 2)
    styles = ("-", "--", ":", "-.")
    for fraction, colour in zip(fractions, shades(fractions.size)[::-1], strict=True):
        for k, temperature in enumerate(temperatures):
            part = (sheet["opening"] == fraction) & (sheet["oil_temperature_K"] == temperature)
            words = plain(fraction, 3) + (f" at {plain(temperature - CELSIUS, 4)} °C" if temperatures.size > 1 else "")
            openings.plot(
                flow[part],
                sheet["pressure_drop_total_Pa"][part] / BAR,
                color=colour,
                linestyle=styles[k % 4],
                label=words,
            )
    line_legend(openings, "open fraction")
    for axes in (sections, openings):
        axes.set_xlabel("flow [lpm]")
        axes.set_xlim(0.0, flow.max())
        axes.set_ylim(bottom=0.0)
    sections.set_ylabel("pressure drop [bar]")


def _ripple(result: RigResult) -> Iterator[Drawn]:
    caption = (
        "Peak-to-peak ripple of the load pressure over duty ratio, PWM frequency (spool driven by a motor) and gas "
        "volume of the accumulator. Dashed: the estimate q (1 - q/Q) / (f C)."
    )
    yield drawn("ripple", caption, 2.6, lambda figure: _ripples(figure, result))
    caption = "One period at the system's set point, and the harmonics of the pressures there."
    yield drawn("spectrum", caption, 2.6, lambda figure: _harmonics(figure, result))


def _ripples(figure: "Figure", result: RigResult) -> None:
    panels = figure.subplots(1, 3, sharey=False)
    for axes, (name, column, scale, words) in zip(
        panels,
        (
            ("duty", "duty_ratio", 1.0, "duty ratio"),
            ("frequency", "pwm_frequency_Hz", 1.0, "PWM frequency [Hz]"),
            ("accumulator", "gas_volume_m3", 1e-6, "gas volume [cm³]"),
        ),
        strict=True,
    ):
        _estimated_and_simulated(axes, result.sheets[name], column, scale, words)
    panels[0].set_ylabel("load pressure, peak to peak [bar]")
    legend(panels[0], 2)


def _estimated_and_simulated(axes: "Axes", sheet: Sheet, column: str, scale: float, words: str) -> None:
    """The load's ripple over `column`, which is shown in units of `scale`."""
    x = sheet[column] / scale
    axes.plot(x, sheet["estimated_ripple_Pa"] / BAR, color=FAINT, linestyle="--", linewidth=1.8, label="estimate")
    axes.plot(x, sheet["load_ripple_Pa"] / BAR, color=LOAD, marker="o", markersize=3.2, label="simulated")
    axes.set_xlabel(words)
    axes.set_xlim(left=0.0)
    axes.set_ylim(bottom=0.0)


def _harmonics(figure: "Figure", result: RigResult) -> None:
    wave, lines = result.sheets["waveform"], result.sheets["spectrum"]
    course, pressures = figure.subplots(1, 2)
    course.plot(1e3 * wave["time_s"], wave["load_pressure_swing_Pa"] / BAR, color=LOAD, label="load pressure less mean")
    course.set_ylabel("load pressure [bar]")
    course.set_xlabel("time [ms]")
    course.set_xlim(0.0, 1e3 * wave["time_s"][-1])
    order = lines["harmonic"]
    for name, colour, words, shift in (
        ("inlet_pressure_Pa", INLET, "inlet", -0.2),
        ("load_pressure_Pa", LOAD, "load", 0.2),
    ):
        pressures.bar(order + shift, lines[name] / BAR, 0.4, color=colour, label=words)
    pressures.set_yscale("log")
    pressures.set_xlabel("harmonic of the PWM frequency")
    pressures.set_ylabel("amplitude [bar]")
    pressures.set_xticks([1, *range(5, int(order[-1]) + 1, 5)])
    legend(pressures, 2)


def _step(result: RigResult) -> Iterator[Drawn]:
    caption = (
        "Delivered flow after a step of the duty ratio, averaged over the last PWM period; band: all phases of the "
        "step within a PWM period."
    )
    if "load_flow_m3_s" in result.sheets["step_up"].columns:
        caption += (
            " Dashed: flow through the load, behind the load line, as it is at each instant; where the load pressure "
            "is below the precharge the accumulator takes nothing in, and this flow shows the switching."
        )
    yield drawn("step", caption, 2.6, lambda figure: _steps(figure, result))
    caption = (
        "Gain and phase of the delivered flow over a sinusoidal duty ratio, relative to the static gain; dotted: half "
        "the PWM frequency, beyond which no frequency can be told from its mirror image. Near a third of the PWM "
        "frequency, left out, the second harmonic of the flow folds back upon the frequency itself."
    )
    yield drawn("frequency-response", caption, 3.2, lambda figure: _bode(figure, result))


def _steps(figure: "Figure", result: RigResult) -> None:
    panels = figure.subplots(1, 2, sharey=True)
    for axes, name in zip(panels, ("step_up", "step_down"), strict=True):
        sheet = result.sheets[name]
        t = 1e3 * sheet["time_s"]
        low, high = (sheet[f"delivered_flow_{end}_m3_s"] / LPM for end in ("lowest", "highest"))
        axes.fill_between(t, low, high, color=TANK, alpha=0.45, linewidth=0.0)
        axes.plot(t, sheet["delivered_flow_m3_s"] / LPM, color=LOAD, label="delivered")
        if "load_flow_m3_s" in sheet.columns:
            axes.plot(t, sheet["load_flow_m3_s"] / LPM, color=INLET, linestyle="--", label="through the load")
        axes.axvline(0.0, color=INK, linewidth=0.7, linestyle=(0, (1, 2)))
        axes.set_xlim(t[0], t[-1])
        axes.set_xlabel("time after the step [ms]")
    panels[0].set_ylabel("flow [lpm]")
    legend(panels[0], 2)


def _bode(figure: "Figure", result: RigResult) -> None:
    gains, phases = figure.subplots(2, 1, sharex=True)
    sheet = result.sheets["frequency"]
    f = sheet["frequency_Hz"]
    for name, colour, words, style in (
        ("delivered_flow", LOAD, "delivered", "-"),
        ("load_flow", INLET, "through the load", "--"),
    ):
        if f"{name}_gain" in sheet.columns:
            marked: dict[str, Any] = {"color": colour, "linestyle": style, "marker": "o", "markersize": 3.0}
            gains.plot(f, 20.0 * np.log10(sheet[f"{name}_gain"]), label=words, **marked)
            phases.plot(f, np.degrees(sheet[f"{name}_phase_rad"]), **marked)
    low, high = gains.get_ylim()
    gains.set_ylim(min(low, -6.0), max(high, 3.0))
    low, high = phases.get_ylim()
    phases.set_ylim(min(low, -45.0), max(high, 15.0))
    for axes in (gains, phases):
        axes.axvline(0.5 * result.numbers["pwm_frequency_Hz"], color=INK, linewidth=0.9, linestyle=":")
        axes.set_xscale("log")
    gains.set_ylabel("gain [dB]")
    phases.set_ylabel("phase [°]")
    phases.set_xlabel("frequency [Hz]")
    from matplotlib.ticker import FuncFormatter

    phases.xaxis.set_major_formatter(FuncFormatter(lambda value, _: plain(value, 3)))
    legend(gains, 2)


def _pump(result: RigResult) -> Iterator[Drawn]:
    yield from _map(replace(result, sheets={"map": result.sheets["steady"]}))
    if "frequency" in result.sheets:
        yield from _step(result)


def _claims(result: RigResult) -> Iterator[Drawn]:
    caption = (
        "Power lost at three load pressures by the PWM valve, by metering at the relief setting and by bleeding off at "
        "load pressure without any further drop, the least that throttling can lose."
    )
    yield drawn("throttling", caption, 2.7, lambda figure: _throttling(figure, result.sheets["throttling"]))
    if "driving" in result.sheets:
        caption = (
            "Left: PWM frequency of a self-spinning spool, and the best one of a driven spool whose load ripple is no "
            "larger than that of the self-spinning one at the largest flow. Middle: ripple. Right: power that drives "
            "the spool at fixed PWM frequencies; below zero the flow drives the motor."
        )
        yield drawn("driving", caption, 2.7, lambda figure: _driving(figure, result))
    caption = "Power that moves the spool; the linear ones spend their kinetic energy twice in each period."
    yield drawn("actuation", caption, 2.6, lambda figure: _actuation(figure, result.sheets["actuation"]))
    if "ripple_frequency" in result.sheets:
        caption = "Ripple of the load pressure over PWM frequency and gas volume. Dashed: the estimate."
        yield drawn("ripple", caption, 2.5, lambda figure: _ripple_laws(figure, result))


def _throttling(figure: "Figure", sheet: Sheet) -> None:
    levels = np.unique(sheet["load_pressure_Pa"])
    panels = figure.subplots(1, levels.size, sharey=True, squeeze=False)[0]
    for axes, level in zip(panels, levels, strict=True):
        part = sheet["load_pressure_Pa"] == level
        x = sheet["delivered_flow_m3_s"][part] / LPM
        for name, colour, style, words in (
            ("metered", RELIEF, "--", "metered"),
            ("bled_off", TANK, "-.", "bled off"),
            ("switched", INLET, "-", "PWM valve"),
        ):
            y = sheet[f"loss_{name}_W"][part] / 1e3
            axes.plot(x, y, color=colour, linestyle=style, marker="o", markersize=2.8, label=words)
        axes.set_title(f"load {plain(level / BAR, 4)} bar", loc="right", pad=3.0)
        axes.set_xlabel("delivered flow [lpm]")
        axes.set_xlim(left=0.0)
        axes.set_ylim(bottom=0.0)
    panels[0].set_ylabel("power lost [kW]")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper left", ncols=3)


def _driving(figure: "Figure", result: RigResult) -> None:
    best, grid = result.sheets["best"], result.sheets["driving"]
    speeds, swings, powers = figure.subplots(1, 3)
    flow = best["pump_flow_m3_s"] / LPM
    speeds.plot(flow, best["self_pwm_frequency_Hz"], color=LOAD, marker="o", markersize=3.0, label="self-spinning")
    speeds.plot(flow, best["best_pwm_frequency_Hz"], color=INLET, marker="o", markersize=3.0, label="driven, best")
    speeds.set_ylabel("PWM frequency [Hz]")
    swings.plot(flow, best["self_ripple_Pa"] / BAR, color=LOAD, marker="o", markersize=3.0)
    swings.axhline(result.numbers["ripple_limit_Pa"] / BAR, color=INLET, linewidth=1.2)
    swings.set_ylabel("load, peak to peak [bar]")
    frequencies = np.unique(grid["pwm_frequency_Hz"])
    places = chosen(frequencies.size, 5)
    for place, colour in zip(places, shades(places.size), strict=True):
        part = grid["pwm_frequency_Hz"] == frequencies[place]
        words = f"{plain(frequencies[place], 3)} Hz"
        powers.plot(grid["pump_flow_m3_s"][part] / LPM, grid["drive_power_W"][part], color=colour, label=words)
    powers.axhline(0.0, color=INK, linewidth=0.7)
    powers.set_ylabel("drive power [W]")
    legend(speeds, 1)
    line_legend(powers, "")
    for axes in (speeds, swings, powers):
        axes.set_xlabel("pump flow [lpm]")
    for axes in (speeds, swings):
        axes.set_ylim(bottom=0.0)


def _actuation(figure: "Figure", sheet: Sheet) -> None:
    axes = figure.subplots(1, 1)
    f = sheet["pwm_frequency_Hz"]
    for name, colour, style, words in (
        ("rotary", LOAD, "-", "rotary, f²"),
        ("linear_same", INLET, "-", "linear, same spool and ports, f³"),
        ("linear_light", INLET, "--", "linear, light spool and annular port, f³"),
    ):
        axes.loglog(f, sheet[f"{name}_power_W"], color=colour, linestyle=style, label=words)
    axes.set_xlabel("PWM frequency [Hz]")
    axes.set_ylabel("power [W]")
    _plain_scale(axes)
    axes.set_xlim(f[0], f[-1])
    line_legend(axes, "")


def _plain_scale(axes: "Axes") -> None:
    """Plain numbers on a logarithmic scale of frequencies."""
    from matplotlib.ticker import FuncFormatter, NullFormatter

    axes.set_xticks([5, 10, 20, 50, 100, 200])
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: plain(value, 3)))
    axes.xaxis.set_minor_formatter(NullFormatter())


def _ripple_laws(figure: "Figure", result: RigResult) -> None:
    panels = figure.subplots(1, 2)
    for axes, name, column, scale, words in (
        (panels[0], "ripple_frequency", "pwm_frequency_Hz", 1.0, "PWM frequency [Hz]"),
        (panels[1], "ripple_volume", "gas_volume_m3", 1e-6, "gas volume [cm³]"),
    ):
        _estimated_and_simulated(axes, result.sheets[name], column, scale, words)
    panels[0].set_ylabel("load, peak to peak [bar]")
    legend(panels[0], 2)


FIGURES: Mapping[str, Callable[[RigResult], Iterator[Drawn]]] = {
    "map": _map,
    "pressure-drop": _pressure_drop,
    "ripple": _ripple,
    "step": _step,
    "pump": _pump,
    "claims": _claims,
}
"""How the result of each rig is drawn."""
