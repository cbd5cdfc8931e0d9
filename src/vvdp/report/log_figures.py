"""The figures of an estimation from a log: edges, speed, innovations, pressure over the angle, the wheel."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import fixed, number, plain
from vvdp.base.units import ATMOSPHERE
from vvdp.logs.kept import Kept
from vvdp.report.drawing import FAINT, INK, INLET, LOAD, TANK, Drawn, drawn, legend

BAR = 1e5

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

TURN = 2.0 * np.pi
RPM = TURN / 60.0
MOST_POINTS = 4000
"""Points in a line or a cloud; longer records are thinned out, or shown by their extremes."""
INVERSE = "#aab2ba"
MOST_EXAGGERATED = 10.0
"""Offsets of the wheel's edges are drawn so many times as large, at most."""


def log_figures(kept: Kept) -> Iterator[Drawn]:
    """All figures that this log gives."""
    if kept.has("excerpt/wave") and kept.size("excerpt/wave"):
        yield drawn("wave", _wave_caption(kept), 2.5, lambda figure: _wave(figure, kept))
    yield drawn("speed", _speed_caption(kept), 4.6, lambda figure: _speed(figure, kept))
    if kept.summary.get("nis_edges"):
        yield drawn("innovations", _innovation_caption(kept), 2.7, lambda figure: _innovations(figure, kept))
    if np.isfinite(kept.column("wheel/offset")).any():
        yield drawn("wheel", _wheel_caption(kept), 2.9, lambda figure: _wheel(figure, kept))
    if kept.has("folded/angle"):
        yield drawn("pressure", _pressure_caption(kept), 4.4, lambda figure: _pressure(figure, kept))


def _value(kept: Kept, key: str) -> float:
    value = kept.summary.get(key)
    return float("nan") if value is None else float(value)


# The wave


def _wave_caption(kept: Kept) -> str:
    level, band = kept.column("excerpt/level")
    how = "midway between its plateaus" if 'level = "automatic"' in kept.config else "fixed"
    return (
        f"The wave as it was recorded, over the last turns of a stretch of the log. Line: the threshold, {how}, "
        f"{plain(float(level), 4)}; band: an edge counts once the wave has left it (±{number(float(band), 3)}). Marks: "
        "edges as they were placed, rising ones up."
    )


def _wave(figure: "Figure", kept: Kept) -> None:
    axes = figure.subplots(1, 1)
    t, v = kept.column("excerpt/time"), kept.column("excerpt/wave")
    level, band = kept.column("excerpt/level")
    times, polarities = kept.column("excerpt/edge_time"), kept.column("excerpt/edge_polarity")
    origin, scale, unit = _clock(t)
    x = (t - origin) * scale
    few = t.size < 60 * max(times.size, 1)
    axes.axhspan(level - band, level + band, color="#f7dcc0", linewidth=0.0, zorder=0.5)
    axes.axhline(level, color=INLET, linewidth=1.0, label="threshold")
    axes.plot(x, v, color=LOAD, linewidth=0.9, marker="." if few else "", markersize=2.5, label="wave")
    for polarity, mark, words in ((1.0, "^", "rising edge"), (-1.0, "v", "falling edge")):
        chosen = polarities == polarity
        axes.plot((times[chosen] - origin) * scale, np.full(np.count_nonzero(chosen), level), mark, color=INK,
                  markersize=5.0, markeredgecolor="white", markeredgewidth=0.5, linestyle="", label=words,
                  zorder=4)  # fmt: skip
    axes.set_xlim(x[0], x[-1])
    unit_of_wave = kept.unit("excerpt/wave")
    axes.set_ylabel(f"wave [{unit_of_wave}]" if unit_of_wave else "wave")
    axes.set_xlabel(_time_label(origin, unit))
    legend(axes, 4)


def _clock(t: Array) -> tuple[float, float, str]:
    """Where a short stretch begins, and in what unit it is shown."""
    length = float(t[-1] - t[0])
    origin = float(np.floor(t[0] * 1e3) / 1e3)
    return (origin, 1.0, "s") if length > 2.0 else (origin, 1e3, "ms")


def _time_label(origin: float, unit: str) -> str:
    return f"time since {plain(round(origin, 3), 9)} s [{unit}]"


# The speed


def _speed_caption(kept: Kept) -> str:
    mean, deviation = _value(kept, "spool_speed_mean_rad_s") / RPM, _value(kept, "spool_speed_std_rad_s") / RPM
    more = ""
    if kept.has("smoothed_speed"):
        more = " Dashed: smoothed, given the edges before and after."
    if kept.summary.get("backward_times"):
        more += " Time runs backwards in this log: pieces of it lie over one another."
    return (
        f"Speed of the spool; mean {fixed(mean, 1)} rpm, standard deviation {number(deviation, 3)} rpm. Above: the "
        "whole log. Below: some turns of it. Dark: the estimate; band: plus and minus two of its standard deviations. "
        "Grey (dots; below also steps): one sector over the time that it took, which noise of the edges alone spreads "
        f"widely.{more} Gaps: "
        "without edges nothing is said."
    )


def _speed(figure: "Figure", kept: Kept) -> None:
    whole, part = figure.subplots(2, 1)
    rows = kept.size("time")
    step = max(1, rows // MOST_POINTS)
    t, speed, deviation, piece = (
        kept.column(name, slice(None, None, step)) for name in ("time", "speed", "speed_deviation", "piece")
    )
    edge_time, edge_speed, edge_piece = _inverse_times(kept)
    thinned = slice(None, None, max(1, edge_time.size // MOST_POINTS))
    whole.set_ylim(*_limits(speed, deviation, edge_speed))
    whole.plot(edge_time[thinned], edge_speed[thinned], ".", color=INVERSE, markersize=5.0, markeredgewidth=0.0,
               rasterized=True, zorder=2.5)  # fmt: skip
    _band(whole, *_parted(np.flatnonzero(np.diff(piece)) + 1, t, speed, deviation))
    whole.set_xlabel("time [s]")
    origin, scale, begin, end, number_of_piece = _zoomed(kept)
    t, speed, deviation = _between(kept, begin, end, number_of_piece)
    inside = (edge_time >= begin) & (edge_time <= end) & (edge_piece == number_of_piece)
    part.set_ylim(*_limits(speed, deviation, edge_speed[inside]))
    x = (t - origin) * scale
    ends, speeds = (edge_time[inside] - origin) * scale, edge_speed[inside]
    part.step(ends, speeds, where="pre", color=INVERSE, linewidth=1.0, zorder=2.5)
    # The dots lie over all, to be seen also where every sector took as long as the estimate says.
    part.plot(ends, speeds, ".", color=INVERSE, markersize=5.0, markeredgewidth=0.0, zorder=5)
    part.plot([], [], ".-", color=INVERSE, markersize=5.0, markeredgewidth=0.0, linewidth=1.0, label="inverse time")
    _band(part, x, speed, deviation)
    if kept.has("smoothed_speed"):
        smoothed = _between(kept, begin, end, number_of_piece, "smoothed_speed")[1]
        part.plot(x, smoothed / RPM, "--", color=INLET, linewidth=1.4, label="smoothed", zorder=4)
    part.set_xlabel(_time_label(origin, "ms" if scale == 1e3 else "s"))
    for axes in (whole, part):
        axes.set_ylabel("speed [rpm]")
        axes.margins(x=0.0)
        _in_hertz(axes, kept)
    part.set_xlim((begin - origin) * scale, (end - origin) * scale)
    handles, labels = part.get_legend_handles_labels()
    whole.legend(handles, labels, loc="lower left", bbox_to_anchor=(0.0, 1.02), ncols=len(handles))
    figure.align_ylabels()


def _band(axes: "Axes", x: Array, speed: Array, deviation: Array) -> None:
    axes.fill_between(x, (speed - 2.0 * deviation) / RPM, (speed + 2.0 * deviation) / RPM, color=TANK, alpha=0.45,
                      linewidth=0.0, label="± 2 deviations", zorder=2)  # fmt: skip
    axes.plot(x, speed / RPM, color=LOAD, linewidth=1.2, label="estimate", zorder=3)


def _in_hertz(axes: "Axes", kept: Kept) -> None:
    per_rpm = _value(kept, "pwm_frequency_mean_Hz") / (_value(kept, "spool_speed_mean_rad_s") / RPM)
    if not np.isfinite(per_rpm) or per_rpm <= 0.0:
        return
    both: Any = (lambda n: n * per_rpm, lambda f: f / per_rpm)
    right = axes.secondary_yaxis("right", functions=both)
    right.set_ylabel("PWM frequency [Hz]")
    right.spines["right"].set_visible(True)


def _limits(speed: Array, deviation: Array, inverse: Array) -> tuple[float, float]:
    """Bounds in rpm that hold the estimate with its band, but for the first moments of a piece, and most of the
    inverse times."""
    known = np.isfinite(speed)
    known &= deviation <= 3.0 * (float(np.median(deviation[known])) if known.any() else 0.0)
    parts = [(speed[known] - 2.5 * deviation[known]) / RPM, (speed[known] + 2.5 * deviation[known]) / RPM]
    if inverse.size:
        parts.append(np.quantile(inverse, [0.02, 0.98]))
    every = np.concatenate(parts)
    if not every.size:
        return 0.0, 1.0
    low, high = float(np.min(every)), float(np.max(every))
    room = 0.06 * (high - low) + 1e-6
    return low - room, high + room


def _parted(breaks: "NDArray[np.int64]", *columns: Array) -> list[Array]:
    """Columns with a NaN before each of the rows `breaks`, where a line ends."""
    return [np.insert(column, breaks, np.nan) for column in columns]


def _between(kept: Kept, begin: float, end: float, piece: float, name: str = "speed") -> tuple[Array, Array, Array]:
    """Time, a column and the deviation of the speed in a stretch of one piece."""
    times = kept.column("time")
    inside = np.flatnonzero((times >= begin) & (times <= end) & (kept.column("piece") == piece))
    if not inside.size:
        return np.empty(0), np.empty(0), np.empty(0)
    rows = slice(int(inside[0]), int(inside[-1]) + 1)
    step = max(1, (rows.stop - rows.start) // MOST_POINTS)
    chosen = slice(rows.start, rows.stop, step)
    return times[chosen], kept.column(name, chosen), kept.column("speed_deviation", chosen)


def _inverse_times(kept: Kept) -> tuple[Array, Array, Array]:
    """When each sector ended, the speed [rpm] that its time says, and the piece."""
    times, numbers, pieces = (kept.column(f"edges/{name}") for name in ("time", "angle", "piece"))
    steps, angles = np.diff(times), np.diff(numbers)
    sound = (steps > 0.0) & np.isfinite(angles) & (np.diff(pieces) == 0.0)
    return times[1:][sound], angles[sound] / steps[sound] / RPM, pieces[1:][sound]


def _zoomed(kept: Kept) -> tuple[float, float, float, float, float]:
    """A stretch of some turns, that of the excerpt, or one half way: its origin and scale, begin, end, and piece."""
    every, pieces = kept.column("edges/time"), kept.column("edges/piece")
    if kept.has("excerpt/edge_time") and kept.size("excerpt/edge_time") > 1:
        times = kept.column("excerpt/edge_time")
        piece = pieces[np.argmin(np.abs(every - times[times.size // 2]))]
    else:
        sectors = int(kept.summary["sectors"])
        piece = pieces[every.size // 2]
        own = every[pieces == piece]
        end = max(own.size // 2, min(own.size, 4 * sectors))
        times = own[max(0, end - 3 * sectors) : end]
    origin, scale, _ = _clock(times)
    return origin, scale, float(times[0]), float(times[-1]), float(piece)


# The innovations


def _innovation_caption(kept: Kept) -> str:
    low, high = (number(_value(kept, f"nis_{end}"), 3) for end in ("low", "high"))
    return (
        "By how much each edge differed from what was expected (left; lines: plus and minus two expected deviations), "
        "and the squares of these differences over what was expected (right; line: what chance makes of them if the "
        f"settings fit; hatched: all from {plain(float(kept.column('innovations/bins')[-2]))} on). The mean of the "
        f"squares is {number(_value(kept, 'nis_mean'), 3)}; {low} to {high} would be chance over "
        f"{plain(_value(kept, 'nis_edges'))} edges."
    )


def _innovations(figure: "Figure", kept: Kept) -> None:
    left, right = figure.subplots(1, 2, width_ratios=[1.7, 1.0])
    step = slice(None, None, max(1, kept.size("edges/time") // MOST_POINTS))
    t, nu, deviation, settled, piece = (
        kept.column(f"edges/{name}", step)
        for name in ("time", "innovation", "innovation_deviation", "settled", "piece")
    )
    shown = (settled > 0.0) & np.isfinite(nu)
    t, nu, deviation, piece = t[shown], nu[shown], deviation[shown], piece[shown]
    breaks = np.flatnonzero(np.diff(piece)) + 1
    left.plot(t, nu, ".", color=LOAD, markersize=2.0, rasterized=True, label="innovation")
    t, deviation = _parted(breaks, t, deviation)
    left.plot(t, 2.0 * deviation, color=INLET, linewidth=0.9, label="± 2 deviations")
    left.plot(t, -2.0 * deviation, color=INLET, linewidth=0.9)
    usual = 2.0 * float(np.nanmedian(deviation)) if deviation.size else 1.0
    far = float(np.quantile(np.abs(nu), 0.999)) if nu.size else 0.0
    reach = 1.3 * max(usual, far)
    left.set_ylim(-reach, reach)
    left.set_ylabel("innovation [rad]")
    left.set_xlabel("time [s]")
    left.margins(x=0.01)
    legend(left, 2)
    counts, bins = kept.column("innovations/histogram"), kept.column("innovations/bins")
    density = counts / max(float(np.sum(counts)), 1.0) / np.diff(bins)
    right.bar(bins[:-1], density, width=np.diff(bins), align="edge", color=TANK, edgecolor="white", linewidth=0.3,
              label="edges")  # fmt: skip
    right.bar(bins[-2], density[-1], width=bins[-1] - bins[-2], align="edge", color="white", edgecolor=INK,
              hatch="//////", linewidth=0.5)  # fmt: skip
    right.plot(*_chance(bins), color=INK, linewidth=1.0, label="chance")
    right.set_yscale("log")
    right.set_ylim(1e-4, 1.5 * max(float(np.max(density, initial=0.0)), 1.0))
    right.set_xlim(0.0, float(bins[-1]))
    right.set_xlabel("squared normalised innovation [1]")
    right.set_xticks([0.0, 2.0, 4.0, 6.0, float(0.5 * (bins[-2] + bins[-1]))], ["0", "2", "4", "6", "all\nabove"])
    right.set_ylabel("density [1]")
    legend(right, 2)


def _chance(bins: Array) -> tuple[Array, Array]:
    """Density of the square of one normal variable."""
    x = np.linspace(0.05, float(bins[-1]), 300)
    return x, np.exp(-0.5 * x) / np.sqrt(TURN * x)


# The wheel


def _wheel_caption(kept: Kept) -> str:
    return (
        "By how much each edge of the wheel lies further on than it should, mean over all turns; bars: two standard "
        "errors; their mean is zero, since no angle is known from outside. Rising edges (even) and falling ones (odd) "
        "apart: a threshold that is off. One "
        "wave over the turn: an eccentric wheel. One edge alone: dirt, a damaged sector, or an index. On the left the "
        "wheel, bright sectors white, with the offsets enlarged as said there; those within their error are left out."
    )


def _wheel(figure: "Figure", kept: Kept) -> None:
    left, right = figure.subplots(1, 2, width_ratios=[1.0, 1.9])
    offsets, errors = kept.column("wheel/offset"), kept.column("wheel/offset_deviation")
    n = offsets.size
    places = _places(kept, n)
    _disc(left, places, offsets, errors)
    x = np.arange(n)
    even = x % 2 == 0
    known = bool(np.any(kept.column("edges/polarity") != 0.0))
    names = ("rising", "falling") if known else ("even", "odd")
    for chosen, colour, words in ((even, LOAD, names[0]), (~even, INLET, names[1])):
        right.bar(x[chosen], 1e3 * offsets[chosen], color=colour, width=0.62, label=words)
    right.errorbar(
        x, 1e3 * offsets, yerr=2e3 * np.nan_to_num(errors), fmt="none", ecolor=INK, elinewidth=0.9, capsize=2
    )
    right.axhline(0.0, color="#6b747d", linewidth=0.7)
    if n <= 32:
        right.set_xticks(x)
    right.set_xlabel("edge of the wheel")
    right.set_ylabel("offset [mrad]")
    right.grid(axis="x", visible=False)
    top = 1.15e3 * float(np.nanmax(np.abs(offsets) + 2.0 * np.nan_to_num(errors)))
    right.set_ylim(-max(top, 1.0), max(top, 1.0))
    legend(right, 2)


def _places(kept: Kept, n: int) -> Array:
    """Angles of the wheel's edges, from the edges as they were placed."""
    sector, angle = kept.column("edges/sector"), kept.column("edges/angle")
    known = np.isfinite(sector)
    places = np.arange(n) * TURN / n
    places[sector[known].astype(int)] = np.mod(angle[known] + 1e-9, TURN)
    return places


def _disc(axes: "Axes", places: Array, offsets: Array, errors: Array) -> None:
    """The wheel as it is seen: bright sectors white, dark ones grey; where each edge should be, and in the colours of
    the bars where it is, if that is sure."""
    from matplotlib.patches import Wedge

    n = places.size
    ends = np.degrees(np.append(places, places[0] + TURN))
    for i in range(n):
        colour = "white" if i % 2 == 0 else "#c9ced4"
        axes.add_patch(Wedge((0.0, 0.0), 1.0, ends[i], ends[i + 1], width=0.42, facecolor=colour, edgecolor="none"))
    for radius in (0.58, 1.0):
        circle = np.linspace(0.0, TURN, 200)
        axes.plot(radius * np.cos(circle), radius * np.sin(circle), color="#6b747d", linewidth=0.7)
    sure = np.abs(np.nan_to_num(offsets)) > 2.0 * np.nan_to_num(errors, nan=np.inf)
    grown = enlargement(offsets[sure], n)
    for i, place in enumerate(places):
        marks = [(place, "#6b747d", 0.7)]
        if sure[i]:
            marks.append((place + grown * offsets[i], LOAD if i % 2 == 0 else INLET, 1.6))
        for angle, colour, width in marks:
            c, s = np.cos(angle), np.sin(angle)
            axes.plot([0.58 * c, c], [0.58 * s, s], color=colour, linewidth=width, solid_capstyle="butt")
    if n <= 32:
        for i, place in enumerate(places):
            axes.text(1.14 * np.cos(place), 1.14 * np.sin(place), str(i), ha="center", va="center", fontsize=7.0)
    words = f"offsets\n\u00d7 {number(grown, 2)}" if sure.any() else "offsets\nwithin\ntheir errors"
    axes.text(0.0, 0.0, words, ha="center", va="center", fontsize=7.0, color=INK)
    axes.set_aspect("equal")
    axes.set_xlim(-1.28, 1.28)
    axes.set_ylim(-1.28, 1.28)
    axes.axis("off")


def enlargement(offsets: Array, sectors: int) -> float:
    """How many times as large the offsets [rad] are drawn: a quarter of a sector, but not more than is plain to see."""
    largest = float(np.max(np.abs(offsets), initial=0.0))
    return min(0.25 * TURN / sectors / largest, MOST_EXAGGERATED) if largest > 0.0 else 1.0


# The pressure


def _pressure_caption(kept: Kept) -> str:
    duty = ""
    if np.isfinite(_value(kept, "duty_ratio_mean")):
        duty = (
            f" The wave is up for {number(_value(kept, 'duty_ratio_mean'), 3)} of a PWM period, mean over "
            f"{plain(_value(kept, 'pressure_pulses'))} pulses; the spool's own duty ratio is a little less, because "
            "the pressure rises before the tank ports are shut."
        )
    return (
        "Inlet pressure (gauge). Above: over time, some turns. Below: all samples of the log over the estimated angle "
        f"within the turn, their mean and the range between lowest and highest.{duty}"
    )


def _pressure(figure: "Figure", kept: Kept) -> None:
    over_time, folded = figure.subplots(2, 1)
    if kept.has("excerpt/pressure") and kept.size("excerpt/pressure") > 1:
        t, p = kept.column("excerpt/pressure_time"), kept.column("excerpt/pressure")
        origin, scale, unit = _clock(t)
        over_time.plot((t - origin) * scale, (p - ATMOSPHERE) / BAR, color=INLET, linewidth=0.9)
        over_time.set_xlim((t[0] - origin) * scale, (t[-1] - origin) * scale)
        over_time.set_xlabel(_time_label(origin, unit))
    else:
        over_time.set_xlabel("time [ms]")
    angle = np.degrees(kept.column("folded/angle"))
    low, mean, high = ((kept.column(f"folded/{name}") - ATMOSPHERE) / BAR for name in ("low", "mean", "high"))
    folded.fill_between(angle, low, high, color="#f7dcc0", linewidth=0.0, label="lowest to highest")
    folded.plot(angle, mean, color=INLET, linewidth=1.4, label="mean")
    folded.set_xlim(0.0, 360.0)
    folded.set_xticks(np.arange(0, 361, 30))
    folded.set_xlabel("estimated spool angle within the turn [°]")
    sections = _sections(kept)
    for k in range(1, sections):
        folded.axvline(360.0 * k / sections, color=FAINT, linewidth=1.0, zorder=0.5)
    for axes in (over_time, folded):
        axes.set_ylabel("pressure [bar]")
    legend(folded, 2)
    figure.align_ylabels()


def _sections(kept: Kept) -> int:
    ratio = _value(kept, "pwm_frequency_mean_Hz") * TURN / _value(kept, "spool_speed_mean_rad_s")
    return round(ratio) if np.isfinite(ratio) else 1
