"""The figures of the estimate as data, each with the tables that it draws: the speed and the innovations."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import display_unit, number, plain, with_unit
from vvdp.base.kinds import ANGLE, COUNT, DURATION, FREQUENCY, RATIO, SPEED, Kind
from vvdp.numerics.kalman import chance_band
from vvdp.offline.charts import Excerpt, Figure, data_table, short_clock
from vvdp.offline.sums import Sums
from vvdp.results.chart import Chart, Colour, Line, Lines, Stroke
from vvdp.results.result import Table
from vvdp.sensing.wheel import TURN

MOST_POINTS, MOST_DOTS = 3000, 1000
"""Rows of a table that is only drawn, as a line or as dots; of longer records every n-th row."""
AT_ONCE = 1_000_000
"""Rows of result.h5 that are searched at once."""
UNUSUAL = 3.0
"""Ends of axes leave out where a deviation is so many times the usual one: the first moments of a piece."""
LEAST_DENSITY = 1e-4
PALE = "#aab2ba"


@dataclass(frozen=True)
class Stretch:
    """A part of one piece of the record that is seen closely."""

    begin: float
    end: float
    piece: float


class SectorSpeeds(NamedTuple):
    """When the spool passed from an edge to the next, and the speed [rad/s] that follows from it alone."""

    begins: Array
    ends: Array
    speeds: Array


def speed_figure(file: Any, sums: Sums) -> Figure:
    """The speed over the whole record, from the rows and edges of result.h5."""
    rows = slice(None, None, -(-file["time"].shape[0] // MOST_POINTS))
    t, speed, deviation, piece = (file[name][rows] for name in ("time", "speed", "speed_deviation", "piece"))
    edges = file["edges/time"].shape[0]
    sectors = _sector_speeds(file, range(0, edges, -(-edges // MOST_DOTS)))
    breaks = np.flatnonzero(np.diff(piece)) + 1
    parted = [np.insert(values, breaks, np.nan) for values in (speed, deviation)]
    tables = {
        "speed-course": _course("time_s", (np.insert(t, breaks, t[breaks]), DURATION, "time"), *parted),
        "speed-sectors": _sector_table("time_s", (sectors.ends, DURATION, "time"), sectors.speeds),
    }
    backward = " Time runs backwards in this log: pieces of it lie over one another." if sums.backward else ""
    caption = (
        f"Speed of the spool over the whole log; mean {with_unit(sums.speed.mean, SPEED, 5)}, standard deviation "
        f"{with_unit(sums.speed.deviation, SPEED, 3)}. Dark: the estimate; band: plus and minus two of its standard "
        "deviations. Grey: each sector over the time that it took, which noise of the edges alone spreads widely. "
        f"Gaps: without edges there is no estimate.{backward}"
    )
    lines = _speed_lines("time_s", "speed-sectors", Stroke.POINTS)
    low, high = _ends(speed, deviation, sectors.speeds)
    panel = Lines(lines=lines, label="speed", low=low, high=high)
    return Figure(Chart(name="speed", caption=caption, table="speed-course", panels=(panel,), height=2.7), tables)


def speed_detail(file: Any, stretch: Stretch, sections: int) -> Figure:
    """The speed over a stretch of some turns, of a spool with so many PWM periods per revolution."""
    clock = short_clock(stretch.begin, stretch.end)
    rows = _rows_within(file, "", stretch)
    t, speed, deviation = (file[name][rows] for name in ("time", "speed", "speed_deviation"))
    edges = _rows_within(file, "edges/", stretch)
    sectors = _sector_speeds(file, range(edges.start, edges.stop))
    smoothed = file["smoothed_speed"][rows] if "smoothed_speed" in file else None
    steps = np.append(sectors.begins, sectors.ends[-1:])
    tables = {
        "detail-course": _course("since_s", clock.column(t), speed, deviation, smoothed),
        "detail-sectors": _sector_table("since_s", clock.column(steps), np.append(sectors.speeds, sectors.speeds[-1:])),
    }
    lines = _speed_lines("since_s", "detail-sectors", Stroke.STEPS)
    if smoothed is not None:
        lines += (
            Line(
                x="since_s",
                y="smoothed_speed_rad_s",
                label="smoothed",
                colour=Colour.INLET,
                stroke=Stroke.DASHED,
            ),
        )
    dashed = "" if smoothed is None else " Dashed: smoothed, given the edges before and after."
    thousand = 1000.0 * display_unit(SPEED).scale
    caption = (
        "Speed over some turns. Grey: each sector over the time that it took. Dark: the estimate; band: plus and minus "
        f"two of its standard deviations.{dashed} "
        f"{with_unit(thousand, SPEED)} is a PWM frequency of {with_unit(thousand * sections / TURN, FREQUENCY)}."
    )
    low, high = _ends(speed, deviation, sectors.speeds)
    panel = Lines(lines=lines, label="speed", low=low, high=high)
    chart = Chart(name="speed-detail", caption=caption, table="detail-course", panels=(panel,), height=2.7)
    return Figure(chart, tables)


def _course(
    key: str, times: tuple[Array, Kind, str], speed: Array, deviation: Array, smoothed: Array | None = None
) -> Table:
    columns = {
        key: times,
        "speed_rad_s": (speed, SPEED, "speed"),
        "speed_low_rad_s": (speed - 2.0 * deviation, SPEED, "speed less two deviations"),
        "speed_high_rad_s": (speed + 2.0 * deviation, SPEED, "speed and two deviations"),
    }
    if smoothed is not None:
        columns["smoothed_speed_rad_s"] = (smoothed, SPEED, "smoothed speed")
    return data_table("Estimated speed", columns)


def _sector_table(key: str, times: tuple[Array, Kind, str], speeds: Array) -> Table:
    return data_table("Speed over each sector", {key: times, "speed_rad_s": (speeds, SPEED, "speed")})


def _speed_lines(x: str, sectors: str, stroke: Stroke) -> tuple[Line, ...]:
    estimate = Line(
        x=x,
        y="speed_rad_s",
        label="estimate, ± 2 deviations",
        colour=Colour.LOAD,
        low="speed_low_rad_s",
        high="speed_high_rad_s",
    )
    return Line(x=x, y="speed_rad_s", label="single sectors", colour=PALE, stroke=stroke, table=sectors), estimate


def _sector_speeds(file: Any, edges: range) -> SectorSpeeds:
    """The speed between each of the `edges` of result.h5 and the one after it; those left out that are not known."""
    last = file["edges/time"].shape[0] - 1
    first = slice(edges.start, min(edges.stop, last), edges.step)
    second = slice(edges.start + 1, min(edges.stop, last) + 1, edges.step)
    names = ("time", "angle", "piece")
    (begins, angles, pieces), (ends, later, others) = (
        [file[f"edges/{name}"][rows] for name in names] for rows in (first, second)
    )
    sound = (ends > begins) & np.isfinite(later - angles) & (pieces == others)
    speeds = (later - angles)[sound] / (ends - begins)[sound]
    return SectorSpeeds(begins[sound], ends[sound], speeds)


def _ends(speed: Array, deviation: Array, sectors: Array) -> tuple[float, float]:
    """Ends of an axis [rad/s] that hold the estimate with its band and most of the speeds over single sectors."""
    known = np.isfinite(speed)
    known &= deviation <= UNUSUAL * (float(np.median(deviation[known])) if known.any() else 0.0)
    parts = [speed[known] - 2.5 * deviation[known], speed[known] + 2.5 * deviation[known]]
    parts += [np.quantile(sectors, [0.02, 0.98])] if sectors.size else []
    every = np.concatenate(parts)
    if not every.size:
        return 0.0, 1.0
    low, high = float(np.min(every)), float(np.max(every))
    room = 0.06 * (high - low) + 1e-7
    return low - room, high + room


def seen_stretch(file: Any, excerpt: Excerpt | None, sectors: int) -> Stretch:
    """The turns that are seen closely: those of the excerpt, or some half way through the record."""
    count = file["edges/time"].shape[0]
    if excerpt is not None and excerpt.edges.times.size > 1:
        times = excerpt.edges.times
        piece = file["edges/piece"][_edge_at(file, float(times[times.size // 2]))]
        return Stretch(float(times[0]), float(times[-1]), float(piece))
    middle = count // 2
    around = slice(max(0, middle - 4 * sectors), middle + 4 * sectors)
    times, pieces = file["edges/time"][around], file["edges/piece"][around]
    piece = pieces[middle - around.start]
    own = times[pieces == piece]
    end = max(own.size // 2, min(own.size, 4 * sectors))
    return Stretch(float(own[max(0, end - 3 * sectors)]), float(own[end - 1]), float(piece))


def _portions(count: int) -> Iterator[slice]:
    return (slice(begin, min(begin + AT_ONCE, count)) for begin in range(0, count, AT_ONCE))


def _edge_at(file: Any, time: float) -> int:
    """The edge nearest to a time."""
    nearest, place = np.inf, 0
    for rows in _portions(file["edges/time"].shape[0]):
        far = np.abs(file["edges/time"][rows] - time)
        if np.min(far) < nearest:
            nearest, place = float(np.min(far)), rows.start + int(np.argmin(far))
    return place


def _rows_within(file: Any, group: str, stretch: Stretch) -> slice:
    """The rows of `time` and `piece` in a group of result.h5 that lie in a stretch."""
    first, last = 0, -1
    for rows in _portions(file[f"{group}time"].shape[0]):
        times, pieces = file[f"{group}time"][rows], file[f"{group}piece"][rows]
        inside = np.flatnonzero((times >= stretch.begin) & (times <= stretch.end) & (pieces == stretch.piece))
        if inside.size:
            first, last = (first if last >= 0 else rows.start + int(inside[0])), rows.start + int(inside[-1])
    return slice(first, last + 1)


# The innovations


def innovation_figure(file: Any, sums: Sums) -> Figure:
    """By how much edges differ from what was expected, over time, and how often by how much."""
    rows = slice(None, None, -(-file["edges/time"].shape[0] // MOST_DOTS))
    names = ("time", "innovation", "innovation_deviation", "settled")
    t, nu, deviation, settled = (file[f"edges/{name}"][rows] for name in names)
    shown = (settled > 0.0) & np.isfinite(nu)
    t, nu, deviation = t[shown], nu[shown], deviation[shown]
    tables = {"innovation-course": _innovation_table(t, nu, deviation), "innovation-squares": _square_table(sums)}
    usual = 2.0 * float(np.nanmedian(deviation)) if nu.size else 1.0
    reach = 1.3 * max(usual, float(np.quantile(np.abs(nu), 0.999)) if nu.size else 0.0)
    low, high = chance_band(sums.nis.count)
    caption = (
        "By how much each edge differed from what was expected (left), and how the squares of that over the expected "
        "variance are distributed (right; orange: by chance alone, if the settings fit; the last step holds all from "
        f"{plain(float(sums.bins[-2]))} on). The mean of the squares is {number(sums.nis.mean, 3)}; "
        f"{number(low, 3)} to {number(high, 3)} would be chance over {plain(sums.nis.count)} edges."
    )
    chart = Chart(
        name="innovations",
        caption=caption,
        table="innovation-course",
        panels=(_innovation_panel(reach), _square_panel()),
        side_by_side=True,
        height=2.8,
    )
    return Figure(chart, tables)


def _innovation_table(times: Array, innovations: Array, deviation: Array) -> Table:
    columns = {
        "time_s": (times, DURATION, "time"),
        "innovation_rad": (innovations, ANGLE, "innovation"),
        "expected_rad": (np.zeros(times.size), ANGLE, "expected innovation"),
        "low_rad": (-2.0 * deviation, ANGLE, "two expected deviations less"),
        "high_rad": (2.0 * deviation, ANGLE, "two expected deviations more"),
    }
    return data_table("Innovations", columns)


def _innovation_panel(reach: float) -> Lines:
    return Lines(
        lines=(
            Line(
                x="time_s",
                y="expected_rad",
                label="± 2 expected deviations",
                colour=Colour.INLET,
                width=0.6,
                low="low_rad",
                high="high_rad",
            ),
            Line(x="time_s", y="innovation_rad", label="innovation", colour=Colour.LOAD, stroke=Stroke.POINTS),
        ),
        label="innovation",
        low=-reach,
        high=reach,
        height=1.6,
    )


def _square_panel() -> Lines:
    return Lines(
        lines=(
            Line(x="square", y="density", label="edges", colour=Colour.LOAD, stroke=Stroke.STEPS),
            Line(x="square", y="expected_density", label="chance", colour=Colour.INLET, stroke=Stroke.STEPS),
        ),
        label="density",
        low=LEAST_DENSITY,
        y_log=True,
        table="innovation-squares",
    )


def _square_table(sums: Sums) -> Table:
    """How many squared normalised innovations lie between bounds, and by chance; the last bin is open."""
    shares = np.diff([math.erf(math.sqrt(0.5 * bound)) for bound in sums.bins[:-1]], append=1.0)
    widths, total = np.diff(sums.bins), max(float(np.sum(sums.histogram)), 1.0)
    density = sums.histogram / total / widths
    columns = {
        "square": (sums.bins, RATIO, "squared normalised innovation"),
        "edges": (np.append(sums.histogram, np.nan), COUNT, "edges"),
        "density": (_close_steps(np.where(density > 0.0, density, np.nan)), RATIO, "density"),
        "expected_density": (_close_steps(shares / widths), RATIO, "density by chance"),
    }
    return data_table("Squares of normalised innovations", columns)


def _close_steps(values: Array) -> Array:
    """Values of steps, with the last one again where it ends."""
    return np.append(values, values[-1:])
