"""The figures of design studies, drawn from the numbers that were written of them."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from vvdp.base.display import number, plain, unit_symbol
from vvdp.base.units import ATMOSPHERE, in_unit
from vvdp.design.quantities import KINDS
from vvdp.design.variables import VARIABLES
from vvdp.report.drawing import FAINT, INK, INLET, LOAD, RELIEF, TANK, Drawn, drawn

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DROPS = (
    ("pressure_drop_nozzle", "nozzles", LOAD),
    ("pressure_drop_centre_section", "centre section", TANK),
    ("pressure_drop_outlet_turbine", "outlet turbine", INLET),
)
LOSSES = (
    ("loss_full_open", "fully open", LOAD),
    ("loss_transition", "transition", INLET),
    ("loss_leakage", "leakage", TANK),
    ("loss_compressibility", "compressibility", RELIEF),
    ("spool_drive_power", "spool's motor", "#7a4fa3"),
)


PALE = "#cbe2f0"
SIGNS = {"<=": "at most", ">=": "at least", "=": "at"}


def words(name: str) -> str:
    """The name of a quantity in plain words."""
    return name.replace("_", " ").replace("pwm", "PWM").replace("reynolds", "Reynolds").replace("taylor", "Taylor")


def in_shown(value: Any, name: str) -> tuple[Any, str]:
    """A quantity [SI] in the unit that people read, and that unit."""
    kind = KINDS[name] if name in KINDS else VARIABLES[name].kind
    unit = kind.shown
    return np.asarray(value, float) * in_unit(1.0, kind, unit), unit_symbol(unit)


def optimum_figures(found: Mapping[str, Any]) -> Iterator[Drawn]:
    """All figures of an optimum."""
    caption = (
        "Before and at the optimum. Left: pressure drop of the fully open valve. Right: analytic losses; the "
        "mark is the total loss of the simulation at the first operating point."
    )
    yield drawn("losses", caption, 2.7, lambda f: _losses(f, found))
    caption = (
        "Where the variables lie between their bounds, on a logarithmic scale: grey before, orange at the optimum. A "
        "ring marks a bound that holds the optimum."
    )
    yield drawn("variables", caption, 0.75 + 0.33 * len(found["variables"]), lambda f: _variables(f, found))
    if found["moved"]:
        caption = (
            f"The least {words(found['objective'])} when one demand or bound is moved and all else stays. The dot is "
            "the optimum above; a line ends where no design is left."
        )
        rows = -(-len(found["moved"]) // 2)
        yield drawn("bounds", caption, 0.35 + 2.0 * rows, lambda f: _moved(f, found))


def _losses(figure: "Figure", found: Mapping[str, Any]) -> None:
    left, right = figure.subplots(1, 2, gridspec_kw={"width_ratios": (1, 1.5)})
    stages = (found["mean_before"], found["mean_after"])
    _stacked(left, stages, DROPS, "_Pa", 1e-5)
    left.set_ylabel("pressure drop [bar]")
    shown = [each for each in LOSSES if any(stage[f"{each[0]}_W"] for stage in stages)]
    _stacked(right, stages, shown, "_W", 1.0)
    right.set_ylabel("loss [W]")
    simulated = {each["design"]: each.get("loss_total_W") for each in found["simulated"] if each["point"] == 0}
    if len(found["points"]) == 1:
        for place, design in enumerate(("before", "after")):
            if simulated.get(design):
                label = "simulated" if design == "before" else None
                right.plot(
                    place, simulated[design], "D", color="white", markeredgecolor=INK, markersize=5.5, label=label
                )
    for axes in (left, right):
        axes.legend(*axes.get_legend_handles_labels(), loc="upper left", bbox_to_anchor=(1.0, 1.0), handlelength=1.0)


def _stacked(axes: "Axes", stages: Any, parts: Any, ending: str, scale: float) -> None:
    base = np.zeros(2)
    for name, label, colour in parts:
        heights = np.array([scale * stage[f"{name}{ending}"] for stage in stages])
        axes.bar((0, 1), heights, 0.55, bottom=base, color=colour, label=label, edgecolor="white", linewidth=0.6)
        base = base + heights
    for place, height in enumerate(base):
        axes.annotate(
            number(float(height), 4), (place, height), (0, 8), textcoords="offset points", ha="center", va="bottom"
        )
    axes.set_xticks((0, 1), ("before", "optimum"))
    axes.set_xlim(-0.6, 1.6)
    axes.set_ylim(0.0, 1.18 * float(np.max(base)))
    axes.grid(axis="x", visible=False)


def _variables(figure: "Figure", found: Mapping[str, Any]) -> None:
    axes = figure.subplots()
    rows = found["variables"]
    active = {each["text"] for each in found["active"]}
    for place, each in enumerate(reversed(rows)):
        low, high, before, after = (each[k] for k in ("low", "high", "before", "after"))
        span = np.log(high / low) if high > low else 1.0
        share = [float(np.log(x / low) / span) if high > low else 0.5 for x in (before, after)]
        axes.plot((0, 1), (place, place), color=FAINT, linewidth=4.0, solid_capstyle="round", zorder=1)
        axes.annotate("", (share[1], place), (share[0], place), arrowprops={"arrowstyle": "-", "color": RELIEF})
        axes.plot(share[0], place, "o", color=RELIEF, markersize=5.0, zorder=3)
        held = any(text.startswith(each["name"] + " ") for text in active)
        if held:
            axes.plot(share[1], place, "o", color="none", markeredgecolor=INK, markersize=10.0, zorder=3)
        axes.plot(share[1], place, "o", color=INLET, markersize=6.0, zorder=4)
        for x, end, where in ((-0.03, low, "right"), (1.03, high, "left")):
            axes.annotate(_amount(end, each["name"]), (x, place), ha=where, va="center", color=INK)
        label = _amount(after, each["name"])
        above: Any = {"textcoords": "offset points", "ha": "center", "va": "bottom", "color": INLET}
        axes.annotate(label, (share[1], place), (0, 7), **above)
    axes.set_yticks(range(len(rows)), [each["words"] for each in reversed(rows)])
    axes.set_ylim(-0.6, len(rows) - 0.2)
    axes.set_xlim(-0.28, 1.28)
    axes.set_xticks([])
    axes.grid(visible=False)
    axes.tick_params(axis="y", length=0)
    for side in ("left", "bottom"):
        axes.spines[side].set_visible(False)


def _amount(value: float, name: str) -> str:
    shown, unit = in_shown(value, name)
    if name == "relief_pressure":
        shown = shown - ATMOSPHERE / 1e5
    return f"{plain(float(shown), 4)} {unit}".strip()


def _moved(figure: "Figure", found: Mapping[str, Any]) -> None:
    rows = found["moved"]
    panels = figure.subplots(-(-len(rows) // 2), 2, sharey=True, squeeze=False)
    for axes, each in zip(panels.flat, rows, strict=False):
        name, _, told = each["text"].partition(" ")
        x, unit = in_shown(each["values"], name)
        if name == "relief_pressure":
            x = x - ATMOSPHERE / 1e5
        known = [np.nan if y is None else y for y in each["objectives"]]
        y, of = in_shown(known, found["objective"])
        axes.plot(x, y, color=LOAD)
        best = in_shown(found["objective_after"], found["objective"])[0]
        axes.plot(x[each["at"]], best, "o", color=INLET, markersize=5.0)
        axes.set_xlabel(f"{words(name)} {SIGNS[told.split(' ')[0]]} [{unit or '1'}]")
    for spare in panels.flat[len(rows) :]:
        spare.set_visible(False)
    for row in panels:
        row[0].set_ylabel(f"{words(found['objective'])} [{of or '1'}]")


# Tolerances


def tolerance_figures(found: Mapping[str, Any]) -> Iterator[Drawn]:
    """All figures of a tolerance study."""
    caption = (
        "How the outputs spread. Dark line: nominal; shaded: the middle 95 %. The spreads of the inputs are taken as "
        "independent."
    )
    yield drawn("distributions", caption, 2.2, lambda f: _distributions(f, found))
    caption = (
        "Share of the variance of each output that an input explains by itself (dark) and together with all others "
        "(light); bars: 95 % confidence. Where the two are alike, inputs act independently."
    )
    height = 0.75 + 0.34 * len(found["spreads"])
    yield drawn("indices", caption, height, lambda f: _indices(f, found))


def _distributions(figure: "Figure", found: Mapping[str, Any]) -> None:
    panels = figure.subplots(1, len(found["scatter"]))
    for axes, (name, each) in zip(panels, found["scatter"].items(), strict=True):
        edges, unit = in_shown(found["bins"][name]["edges"], name)
        counts = np.array(found["bins"][name]["counts"])
        axes.stairs(counts, edges, fill=True, color=TANK)
        low, high = (float(in_shown(each["percentiles"][p], name)[0]) for p in ("2.5", "97.5"))
        axes.axvspan(low, high, color=FAINT, alpha=0.45, zorder=0, linewidth=0.0)
        axes.axvline(float(in_shown(each["nominal"], name)[0]), color=INK, linewidth=1.2)
        axes.set_xlabel(f"{words(name)} [{unit or '1'}]")
        axes.set_title(f"95 %: {plain(low, 4)} to {plain(high, 4)} {unit}".strip(), loc="left")
        axes.set_yticks([])
        axes.grid(visible=False)
        axes.spines["left"].set_visible(False)


def _indices(figure: "Figure", found: Mapping[str, Any]) -> None:
    rows = list(reversed(found["spreads"]))
    panels = figure.subplots(1, len(found["scatter"]), sharey=True)
    places = np.arange(len(rows))
    for axes, (name, each) in zip(panels, found["scatter"].items(), strict=True):
        for shares, errors, offset, colour, label in (
            (each["alone"], each["alone_error"], 0.19, LOAD, "alone"),
            (each["whole"], each["whole_error"], -0.19, TANK, "with others"),
        ):
            values = [max(shares[row["name"]], 0.0) for row in rows]
            spans = [errors[row["name"]] for row in rows]
            axes.barh(
                places + offset, values, 0.34, xerr=spans, color=colour, label=label,
                error_kw={"ecolor": RELIEF, "elinewidth": 0.8},
            )  # fmt: skip
        axes.set_title(words(name), loc="left")
        axes.set_xlim(0.0, 1.05)
        axes.set_xlabel("share of the variance")
        axes.grid(axis="y", visible=False)
        axes.tick_params(axis="y", length=0)
    panels[0].set_yticks(places, [row["words"] for row in rows])
    panels[-1].legend(loc="lower right", handlelength=1.0)


# Oil temperature


def temperature_figures(found: Mapping[str, Any]) -> Iterator[Drawn]:
    """All figures of a study over the oil's temperature."""
    caption = (
        "From cold to hot oil: PWM frequency, analytic losses (stacked) and what the spool and its clearance do. "
        "The dashed line marks 40 °C."
    )
    yield drawn("temperature", caption, 4.5, lambda f: _over_temperature(f, found))
    caption = "Where the model holds (light) and where it is in doubt (orange), over the temperature of the oil."
    yield drawn("range", caption, 0.6 + 0.27 * len(found["checks"]), lambda f: _range(f, found))


def _over_temperature(figure: "Figure", found: Mapping[str, Any]) -> None:
    t = np.array(found["temperatures"]) - 273.15
    c = {name: np.array(column, float) for name, column in found["columns"].items()}
    (speed, loss), (gap, oil) = figure.subplots(2, 2, sharex=True)
    speed.plot(t, c["pwm_frequency"], color=LOAD, label="fully open")
    speed.plot(t, c["pwm_frequency_averaged"], color=INLET, label="averaged")
    speed.set_ylabel("PWM frequency [Hz]")
    _above(speed)
    base = np.zeros_like(t)
    for name, label, colour in LOSSES:
        if np.any(c[name] > 0.0):
            loss.fill_between(t, base, base + c[name], color=colour, label=label, linewidth=0.0)
            base = base + c[name]
    loss.set_ylabel("loss [W]")
    _above(loss)
    loss.set_ylim(0.0)
    gap.plot(t, c["carried_temperature_rise"], color=INLET, label="leaking oil, at most")
    gap.plot(t, c["sheared_temperature_rise"], color=LOAD, label="film, by its shear")
    gap.set_yscale("log")
    gap.set_ylabel("warming [K]")
    _above(gap)
    oil.plot(t, c["nozzle_reynolds_number"], color=LOAD, label="Reynolds number")
    oil.plot(t, c["bearing_capacity"] / c["radial_force"], color=INLET, label="bearing over jet force")
    oil.set_yscale("log")
    oil.set_ylabel("[1]")
    _above(oil)
    for axes in (speed, loss, gap, oil):
        axes.axvline(40.0, color=RELIEF, linewidth=0.8, linestyle=(0, (4, 3)))
        axes.set_xlim(t[0], t[-1])
    for axes in (gap, oil):
        axes.set_xlabel("oil temperature [°C]")


def _above(axes: "Axes") -> None:
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.02), ncols=2, handlelength=1.0, columnspacing=1.0)


def _range(figure: "Figure", found: Mapping[str, Any]) -> None:
    axes = figure.subplots()
    t = np.array(found["temperatures"]) - 273.15
    half = 0.5 * (t[1] - t[0])
    rows = list(reversed(found["checks"]))
    for place, each in enumerate(rows):
        for x, bad in zip(t, each["outside"], strict=True):
            colour = INLET if bad else PALE
            axes.barh(place, 2.0 * half, 0.62, left=x - half, color=colour, edgecolor=colour, linewidth=0.5)
    axes.set_yticks(range(len(rows)), [_short(each["words"]) for each in rows])
    axes.set_xlim(t[0] - half, t[-1] + half)
    axes.set_xlabel("oil temperature [°C]")
    axes.grid(visible=False)
    axes.tick_params(axis="y", length=0)


def _short(told: str) -> str:
    return (
        told.partition(", if ")[0].replace("cavitation number of the nozzles", "cavitation").replace(" while the", ",")
    )


# Pareto front


def front_figures(found: Mapping[str, Any]) -> Iterator[Drawn]:
    """All figures of a Pareto front."""
    names = [each["quantity"] for each in found["objectives"]]
    first = words(names[0])
    caption = (
        f"The designs of the front, two objectives at a time; the colour is the {first}. The diamond is the design as "
        "it was. No design is better than another in every objective. Hollow: in doubt by simulation."
    )
    count = len(names) - 1
    yield drawn("front", caption, 3.2 if count == 1 else 0.6 + 1.85 * count, lambda f: _front(f, found, names))
    caption = (
        f"The variables along the front, over the {first}; lines: the bounds. Where designs of alike {first} differ, "
        "the other objectives decide."
    )
    rows = -(-len(found["bounds"]) // 3)
    yield drawn("front-variables", caption, 0.4 + 1.6 * rows, lambda f: _front_variables(f, found, names[0]))


def _columns(found: Mapping[str, Any], name: str) -> tuple[Any, str]:
    part = "quantities" if name in KINDS else "values"
    return in_shown([each[part][name] for each in found["designs"]], name)


def _doubted(found: Mapping[str, Any]) -> npt.NDArray[np.bool_]:
    """Of each design whether its simulation contradicts the closed form; none where nothing was simulated."""
    simulated = found["simulated"][1:]  # the first is the system as it was
    return np.array([bool(each["doubts"]) for each in simulated] or [False] * len(found["designs"]))


def _front(figure: "Figure", found: Mapping[str, Any], names: list[str]) -> None:
    count = len(names) - 1
    panels = figure.subplots(count, count, squeeze=False, sharex="col", sharey="row")
    colour, unit = _columns(found, names[0])
    doubted = _doubted(found)
    shown: Any = None
    for i in range(count):
        for j in range(count):
            axes = panels[i, j]
            if j > i:
                axes.set_visible(False)
                continue
            (x, x_unit), (y, y_unit) = (_columns(found, names[k]) for k in (j, i + 1))
            shown = axes.scatter(x, y, c=colour, cmap="viridis", s=13, linewidths=0.0)
            axes.scatter(np.asarray(x)[doubted], np.asarray(y)[doubted], s=3, color="white", linewidths=0.0)
            before = [float(in_shown(found["before"][names[k]], names[k])[0]) for k in (j, i + 1)]
            axes.plot(*before, "D", color="white", markeredgecolor=INK, markersize=5.0)
            if i == count - 1:
                axes.set_xlabel(f"{words(names[j])} [{x_unit or '1'}]")
            if j == 0:
                axes.set_ylabel(f"{words(names[i + 1])} [{y_unit or '1'}]")
    figure.colorbar(shown, ax=panels, label=f"{words(names[0])} [{unit or '1'}]", shrink=0.7, pad=0.02)


def _front_variables(figure: "Figure", found: Mapping[str, Any], first: str) -> None:
    rows = -(-len(found["bounds"]) // 3)
    panels = figure.subplots(rows, 3, squeeze=False, sharex=True)
    x, unit = _columns(found, first)
    for axes, each in zip(panels.flat, found["bounds"], strict=False):
        y, y_unit = _columns(found, each["name"])
        shift = ATMOSPHERE / 1e5 if each["name"] == "relief_pressure" else 0.0
        axes.plot(x, y - shift, "o", color=LOAD, markersize=3.0)
        for end in ("low", "high"):
            axes.axhline(float(in_shown(each[end], each["name"])[0]) - shift, color=INLET, linewidth=0.8)
        axes.set_title(f"{each['words']} [{y_unit or '1'}]", loc="left")
    last = len(found["bounds"])
    for spare in panels.flat[last:]:
        spare.set_visible(False)
    for k, axes in enumerate(panels.flat[:last]):
        if k + 3 >= last:
            axes.set_xlabel(f"{words(first)} [{unit or '1'}]")
            axes.tick_params(axis="x", labelbottom=True)
