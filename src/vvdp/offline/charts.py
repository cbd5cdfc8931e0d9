"""The figures of an estimate as data, each with the tables that it draws: wave, speed, innovations and pressure."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import display_unit, number, plain, with_unit
from vvdp.base.kinds import ANGLE, COUNT, DURATION, FREQUENCY, NUMBER, PRESSURE_LEVEL, RATIO, SPEED, TIME, Kind
from vvdp.logs.channel import Portion
from vvdp.numerics.kalman import chance_band
from vvdp.offline.edges import Edges
from vvdp.offline.estimate_result import portions
from vvdp.offline.sums import ANGLES, BINS, Sums
from vvdp.results.chart import Chart, Colour, Level, Line, Lines, Stroke
from vvdp.results.result import Column, Table
from vvdp.sensing.wheel import TURN

LONGEST_IN_MS = 2.0
"""Longer stretches [s] are shown in seconds."""
MOST_POINTS, MOST_DOTS = 3000, 1000
"""Rows of a table that is only drawn, as a line or as dots; of longer records every n-th row."""
UNUSUAL = 3.0
"""Ends of axes leave out where a deviation is so many times the usual one: the first moments of a piece."""
LEAST_DENSITY = 1e-4
PALE = "#aab2ba"


class Excerpt(NamedTuple):
    """Some turns of the record as it was measured."""

    times: Array
    values: Array
    level: float
    band: float
    edges: Edges
    pressure: Portion | None


class Figure(NamedTuple):
    """A chart with the tables that it draws."""

    chart: Chart
    tables: Mapping[str, Table]


class Stretch(NamedTuple):
    """A part of one piece of the record that is seen closely."""

    begin: float
    end: float
    piece: float


class SectorSpeeds(NamedTuple):
    """When the spool passed from an edge to the next, and the speed [rad/s] that follows from it alone."""

    begins: Array
    ends: Array
    speeds: Array


class Clock(NamedTuple):
    """How the times of a short stretch are shown: since the last full millisecond before it."""

    origin: float
    kind: Kind

    def column(self, times: Array) -> Column:
        """The times of a table."""
        return Column(times - self.origin, self.kind, f"time since {plain(round(self.origin, 3), 9)} s")


def short_clock(begin: float, end: float) -> Clock:
    """The clock on which a stretch is shown."""
    return Clock(math.floor(begin * 1e3) / 1e3, TIME if end - begin < LONGEST_IN_MS else DURATION)


def data_table(title: str, columns: Mapping[str, Column]) -> Table:
    """A table that is only drawn."""
    return Table(title=title, columns=columns, is_data=True)


# The wave

WAVE_LINE = Line(x="since_s", y="wave", label="wave", colour=Colour.LOAD, width=0.9)
WAVE_MARKED = Line(x="since_s", y="wave", label="wave", colour=Colour.LOAD, width=0.9, stroke=Stroke.MARKED)
WAVE_EDGES = (
    Line(
        x="since_s",
        y="threshold",
        label="threshold",
        colour=Colour.INLET,
        low="threshold_low",
        high="threshold_high",
        table="wave-edges",
    ),
    Line(x="since_s", y="rising", label="rising edge", colour=Colour.INK, stroke=Stroke.POINTS, table="wave-edges"),
    Line(x="since_s", y="falling", label="falling edge", colour=Colour.RED, stroke=Stroke.POINTS, table="wave-edges"),
)


def wave_figure(excerpt: Excerpt, unit: str, *, automatic: bool) -> Figure:
    """A wave [`unit`] over some turns, with its threshold and the edges that were found."""
    clock = short_clock(float(excerpt.times[0]), float(excerpt.times[-1]))
    samples = {"since_s": clock.column(excerpt.times), "wave": Column(excerpt.values, NUMBER, "wave")}
    tables = {"wave-samples": data_table("Wave as recorded", samples), "wave-edges": _edge_table(excerpt, clock)}
    few = excerpt.times.size < 60 * max(excerpt.edges.times.size, 1)
    level, band = f"{plain(excerpt.level, 4)} {unit}".strip(), f"{plain(excerpt.band, 3)} {unit}".strip()
    caption = (
        "The wave as it was recorded, over the last revolutions of a stretch of the log. Line: the threshold, "
        f"{'midway between its plateaus' if automatic else 'fixed'}, {level}; band: an edge counts once the wave has "
        f"left it (±{band}). Dots: edges as they were placed."
    )
    lines = (WAVE_MARKED if few else WAVE_LINE, *WAVE_EDGES)
    panel = Lines(lines=lines, label=f"wave [{unit}]" if unit else "wave")
    return Figure(Chart(name="wave", caption=caption, table="wave-samples", panels=(panel,), height=2.7), tables)


def _edge_table(excerpt: Excerpt, clock: Clock) -> Table:
    """Edges and threshold, with a row at each end of the excerpt."""
    times = np.concatenate([excerpt.times[:1], excerpt.edges.times, excerpt.times[-1:]])
    polarity = np.concatenate([[0.0], excerpt.edges.polarities, [0.0]])
    level = np.full(times.size, excerpt.level)
    columns = {
        "since_s": clock.column(times),
        "threshold": Column(level, NUMBER, "threshold"),
        "threshold_low": Column(level - excerpt.band, NUMBER, "lower end of the hysteresis"),
        "threshold_high": Column(level + excerpt.band, NUMBER, "upper end of the hysteresis"),
        "rising": Column(np.where(polarity > 0.0, level, np.nan), NUMBER, "rising edge"),
        "falling": Column(np.where(polarity < 0.0, level, np.nan), NUMBER, "falling edge"),
    }
    return data_table("Threshold and edges", columns)


# The speed


def speed_figure(file: Any, sums: Sums) -> Figure:
    """The speed over the whole record, from the rows and edges of result.h5."""
    rows = slice(None, None, -(-file["time"].shape[0] // MOST_POINTS))
    t, speed, deviation, piece = (file[name][rows] for name in ("time", "speed", "speed_deviation", "piece"))
    edges = file["edges/time"].shape[0]
    sectors = _sector_speeds(file, range(0, edges, -(-edges // MOST_DOTS)))
    breaks = np.flatnonzero(np.diff(piece)) + 1
    parted = [np.insert(values, breaks, np.nan) for values in (speed, deviation)]
    times = Column(np.insert(t, breaks, t[breaks]), DURATION, "time")
    tables = {
        "speed-course": _course("time_s", times, *parted),
        "speed-sectors": _sector_table("time_s", Column(sectors.ends, DURATION, "time"), sectors.speeds),
    }
    backward = " Time runs backwards in this log: pieces of it lie over one another." if sums.tally.backward else ""
    mean, scatter = with_unit(sums.rows.speed.mean, SPEED, 5), with_unit(sums.rows.speed.deviation, SPEED, 3)
    caption = (
        f"Speed of the shaft over the whole log; mean {mean}, standard deviation {scatter}. Dark: the estimate; band: "
        "plus and minus two of its standard deviations. Grey: each sector over the time that it took, which noise of "
        f"the edges alone spreads widely. Gaps: without edges there is no estimate.{backward}"
    )
    panel = _speed_panel(_speed_lines("time_s", "speed-sectors", Stroke.POINTS), speed, deviation, sectors.speeds)
    return Figure(Chart(name="speed", caption=caption, table="speed-course", panels=(panel,), height=2.7), tables)


def speed_detail(file: Any, stretch: Stretch, sections: int) -> Figure:
    """The speed over a stretch of some revolutions; `sections` are the PWM periods in one of a valve, 0 without."""
    clock = short_clock(stretch.begin, stretch.end)
    rows, edges = _rows_within(file, "", stretch), _rows_within(file, "edges/", stretch)
    t, speed, deviation = (file[name][rows] for name in ("time", "speed", "speed_deviation"))
    sectors = _sector_speeds(file, range(edges.start, edges.stop))
    steps = clock.column(np.append(sectors.begins, sectors.ends[-1:]))
    course = _course("since_s", clock.column(t), speed, deviation)
    lines, dashed = _speed_lines("since_s", "detail-sectors", Stroke.STEPS), ""
    if "smoothed_speed" in file:
        smoothed = {"smoothed_speed_rad_s": Column(file["smoothed_speed"][rows], SPEED, "smoothed speed")}
        course = data_table("Estimated speed", {**course.columns, **smoothed})
        lines += (
            Line(x="since_s", y=next(iter(smoothed)), label="smoothed", colour=Colour.INLET, stroke=Stroke.DASHED),
        )
        dashed = " Dashed: smoothed, given the edges before and after."
    thousand = 1000.0 * display_unit(SPEED).scale
    frequency = with_unit(thousand * sections / TURN, FREQUENCY)
    of_valve = f" {with_unit(thousand, SPEED)} is a PWM frequency of {frequency}." if sections else ""
    caption = (
        "Speed over some revolutions. Grey: each sector over the time that it took. Dark: the estimate; band: plus and "
        f"minus two of its standard deviations.{dashed}{of_valve}"
    )
    panel = _speed_panel(lines, speed, deviation, sectors.speeds)
    chart = Chart(name="speed-detail", caption=caption, table="detail-course", panels=(panel,), height=2.7)
    by_sector = _sector_table("since_s", steps, np.append(sectors.speeds, sectors.speeds[-1:]))
    return Figure(chart, {"detail-course": course, "detail-sectors": by_sector})


def _course(key: str, times: Column, speed: Array, deviation: Array) -> Table:
    columns = {
        key: times,
        "speed_rad_s": Column(speed, SPEED, "speed"),
        "speed_low_rad_s": Column(speed - 2.0 * deviation, SPEED, "speed − 2σ"),
        "speed_high_rad_s": Column(speed + 2.0 * deviation, SPEED, "speed + 2σ"),
    }
    return data_table("Estimated speed", columns)


def _sector_table(key: str, times: Column, speeds: Array) -> Table:
    return data_table("Speed over each sector", {key: times, "speed_rad_s": Column(speeds, SPEED, "speed")})


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


def _speed_panel(lines: tuple[Line, ...], speed: Array, deviation: Array, sectors: Array) -> Lines:
    """A panel whose ends hold the estimate with its band and most of the speeds over single sectors [rad/s]."""
    known = np.isfinite(speed)
    known &= deviation <= UNUSUAL * (float(np.median(deviation[known])) if known.any() else 0.0)
    parts = [speed[known] - 2.5 * deviation[known], speed[known] + 2.5 * deviation[known]]
    parts += [np.quantile(sectors, [0.02, 0.98])] if sectors.size else []
    every = np.concatenate(parts)
    if not every.size:
        return Lines(lines=lines, label="speed", low=0.0, high=1.0)
    low, high = float(np.min(every)), float(np.max(every))
    room = 0.06 * (high - low) + 1e-7
    return Lines(lines=lines, label="speed", low=low - room, high=high + room)


def _sector_speeds(file: Any, edges: range) -> SectorSpeeds:
    """The speed between each of the `edges` of result.h5 and the one after it; those left out that are not known."""
    last = file["edges/time"].shape[0] - 1
    first = slice(edges.start, min(edges.stop, last), edges.step)
    second = slice(edges.start + 1, min(edges.stop, last) + 1, edges.step)
    (begins, angles, pieces), (ends, later, others) = (
        [file[f"edges/{name}"][rows] for name in ("time", "angle", "piece")] for rows in (first, second)
    )
    sound = (ends > begins) & np.isfinite(later - angles) & (pieces == others)
    speeds = (later - angles)[sound] / (ends - begins)[sound]
    return SectorSpeeds(begins[sound], ends[sound], speeds)


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


def _edge_at(file: Any, time: float) -> int:
    """The edge nearest to a time."""
    nearest, place, before = np.inf, 0, 0
    for (times,) in portions(file, "edges/", "time"):
        far = np.abs(times - time)
        if np.min(far) < nearest:
            nearest, place = float(np.min(far)), before + int(np.argmin(far))
        before += times.size
    return place


def _rows_within(file: Any, group: str, stretch: Stretch) -> slice:
    """The rows of `time` and `piece` in a group of result.h5 that lie in a stretch."""
    found, before = [0, -1], 0
    for times, pieces in portions(file, group, "time", "piece"):
        inside = np.flatnonzero((times >= stretch.begin) & (times <= stretch.end) & (pieces == stretch.piece))
        if inside.size:
            found = [found[0] if found[1] >= 0 else before + int(inside[0]), before + int(inside[-1])]
        before += times.size
    return slice(found[0], found[1] + 1)


# The innovations

INNOVATION_LINES = (
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
)
SQUARE_PANEL = Lines(
    lines=(
        Line(x="square", y="density", label="edges", colour=Colour.LOAD, stroke=Stroke.STEPS),
        Line(x="square", y="expected_density", label="chance", colour=Colour.INLET, stroke=Stroke.STEPS),
    ),
    label="density",
    low=LEAST_DENSITY,
    y_log=True,
    table="innovation-squares",
)


def innovation_figure(file: Any, sums: Sums) -> Figure:
    """By how much edges differ from what was expected, over time, and how often by how much."""
    rows = slice(None, None, -(-file["edges/time"].shape[0] // MOST_DOTS))
    names = ("time", "innovation", "innovation_deviation", "settled")
    t, nu, deviation, settled = (file[f"edges/{name}"][rows] for name in names)
    shown = (settled > 0.0) & np.isfinite(nu)
    t, nu, deviation = t[shown], nu[shown], deviation[shown]
    columns = {
        "time_s": Column(t, DURATION, "time"),
        "innovation_rad": Column(nu, ANGLE, "innovation"),
        "expected_rad": Column(np.zeros(t.size), ANGLE, "expected innovation"),
        "low_rad": Column(-2.0 * deviation, ANGLE, "two expected deviations less"),
        "high_rad": Column(2.0 * deviation, ANGLE, "two expected deviations more"),
    }
    tables = {"innovation-course": data_table("Innovations", columns), "innovation-squares": _square_table(sums)}
    usual = 2.0 * float(np.nanmedian(deviation)) if nu.size else 1.0
    reach = 1.3 * max(usual, float(np.quantile(np.abs(nu), 0.999)) if nu.size else 0.0)
    low, high = chance_band(sums.edges.nis.count)
    caption = (
        "By how much each edge differed from what was expected (left), and how the squares of that over the expected "
        "variance are distributed (right; orange: by chance alone, if the settings fit; the last step holds all from "
        f"{plain(float(BINS[-2]))} on). The mean of the squares is {number(sums.edges.nis.mean, 3)}; "
        f"{number(low, 3)} to {number(high, 3)} would be chance over {plain(sums.edges.nis.count)} edges."
    )
    panels = (Lines(lines=INNOVATION_LINES, label="innovation", low=-reach, high=reach, height=1.6), SQUARE_PANEL)
    chart = Chart(
        name="innovations", caption=caption, table="innovation-course", panels=panels, side_by_side=True, height=2.8
    )
    return Figure(chart, tables)


def _square_table(sums: Sums) -> Table:
    """How many squared normalised innovations lie between bounds, and by chance; the last bin is open."""
    shares = np.diff([math.erf(math.sqrt(0.5 * bound)) for bound in BINS[:-1]], append=1.0)
    widths, total = np.diff(BINS), max(float(np.sum(sums.edges.histogram)), 1.0)
    density = sums.edges.histogram / total / widths
    density, chance = np.where(density > 0.0, density, np.nan), shares / widths
    columns = {  # steps: the last value again where it ends
        "square": Column(BINS, RATIO, "squared normalised innovation"),
        "edges": Column(np.append(sums.edges.histogram, np.nan), COUNT, "edges"),
        "density": Column(np.append(density, density[-1:]), RATIO, "density"),
        "expected_density": Column(np.append(chance, chance[-1:]), RATIO, "expected density"),
    }
    return data_table("Squares of normalised innovations", columns)


# The pressure

PRESSURE_PANEL = Lines(lines=(Line(x="since_s", y="pressure_Pa", colour=Colour.INLET, width=0.9),))
FOLD_LINE = Line(
    x="angle_rad",
    y="pressure_Pa",
    label="mean, lowest to highest",
    colour=Colour.INLET,
    low="pressure_low_Pa",
    high="pressure_high_Pa",
)


def pressure_figure(portion: Portion) -> Figure:
    """The inlet pressure over some turns."""
    clock = short_clock(float(portion.times[0]), float(portion.times[-1]))
    pressure = Column(portion.values, PRESSURE_LEVEL, "inlet pressure")
    table = data_table("Inlet pressure as recorded", {"since_s": clock.column(portion.times), "pressure_Pa": pressure})
    caption = "Inlet pressure (gauge) over some revolutions."
    chart = Chart(name="pressure", caption=caption, table="pressure-course", panels=(PRESSURE_PANEL,), height=2.2)
    return Figure(chart, {"pressure-course": table})


def pressure_fold(sums: Sums, sections: int) -> Figure:
    """The inlet pressure over the angle within the turn."""
    angles = (np.arange(ANGLES) + 0.5) * TURN / ANGLES
    columns = {
        "angle_rad": Column(angles, ANGLE, "estimated spool angle within the turn"),
        "pressure_low_Pa": Column(sums.tally.fold.lowest, PRESSURE_LEVEL, "lowest inlet pressure"),
        "pressure_Pa": Column(sums.tally.fold.mean, PRESSURE_LEVEL, "mean inlet pressure"),
        "pressure_high_Pa": Column(sums.tally.fold.highest, PRESSURE_LEVEL, "highest inlet pressure"),
    }
    ends = (TURN * k / sections for k in range(1, sections))
    periods = tuple(Level(value=end, upright=True, colour=Colour.FAINT, stroke=Stroke.SOLID) for end in ends)
    panel = Lines(lines=(FOLD_LINE,), label="inlet pressure", levels=periods, left=0.0, right=TURN)
    ratio, duty = sums.tally.duty_ratio, ""
    if ratio.count:
        duty = (
            f" The pressure is high for {number(ratio.mean, 3)} of a PWM period, mean over {plain(ratio.count)} pulses;"
            " the spool's own duty ratio is a little less, because the pressure rises before the tank ports are closed."
        )
    caption = (
        "Inlet pressure (gauge) over the estimated angle within the turn, all samples of the log: their mean, and the "
        f"range between lowest and highest. Upright lines part the PWM periods.{duty}"
    )
    chart = Chart(name="pressure-angle", caption=caption, table="pressure-fold", panels=(panel,), height=2.6)
    return Figure(chart, {"pressure-fold": data_table("Inlet pressure over the angle", columns)})
