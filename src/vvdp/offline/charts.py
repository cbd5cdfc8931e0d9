"""The figures of what was recorded, as data, each with the tables that it draws: the wave and the pressure."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import number, plain
from vvdp.base.kinds import ANGLE, DURATION, NUMBER, PRESSURE_LEVEL, TIME, Kind
from vvdp.logs.channel import Portion
from vvdp.offline.edges import Edges
from vvdp.offline.sums import ANGLES, Sums
from vvdp.results.chart import Chart, Colour, Level, Line, Lines, Stroke
from vvdp.results.result import Column, Table
from vvdp.sensing.wheel import TURN

LONGEST_IN_MS = 2.0
"""Longer stretches [s] are shown in seconds."""


@dataclass(frozen=True)
class Excerpt:
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


def data_table(title: str, columns: Mapping[str, tuple[Any, Kind, str]]) -> Table:
    """A table that is only drawn: values, kind and label under each key."""
    found = {key: Column(np.asarray(values, float), kind, label) for key, (values, kind, label) in columns.items()}
    return Table(title=title, columns=found, is_data=True)


class Clock(NamedTuple):
    """How the times of a short stretch are shown: since the last full millisecond before it."""

    origin: float
    kind: Kind

    def column(self, times: Array) -> tuple[Array, Kind, str]:
        """Values, kind and label of the times of a table."""
        return times - self.origin, self.kind, f"time since {plain(round(self.origin, 3), 9)} s"


def short_clock(begin: float, end: float) -> Clock:
    """The clock on which a stretch is shown."""
    return Clock(math.floor(begin * 1e3) / 1e3, TIME if end - begin < LONGEST_IN_MS else DURATION)


# The wave


def wave_figure(excerpt: Excerpt, unit: str, *, automatic: bool) -> Figure:
    """A wave [`unit`] over some turns, with its threshold and the edges that were found."""
    clock = short_clock(float(excerpt.times[0]), float(excerpt.times[-1]))
    samples = {"since_s": clock.column(excerpt.times), "wave": (excerpt.values, NUMBER, "wave")}
    tables = {"wave-samples": data_table("Wave as recorded", samples), "wave-edges": _edge_table(excerpt, clock)}
    few = excerpt.times.size < 60 * max(excerpt.edges.times.size, 1)
    threshold = Line(
        x="since_s",
        y="threshold",
        label="threshold",
        colour=Colour.INLET,
        low="threshold_low",
        high="threshold_high",
        table="wave-edges",
    )
    stroke = Stroke.MARKED if few else Stroke.SOLID
    wave = Line(x="since_s", y="wave", label="wave", colour=Colour.LOAD, stroke=stroke, width=0.9)
    marks = (
        Line(x="since_s", y=key, label=f"{key} edge", colour=colour, stroke=Stroke.POINTS, table="wave-edges")
        for key, colour in (("rising", Colour.INK), ("falling", Colour.RED))
    )
    how = "midway between its plateaus" if automatic else "fixed"
    caption = (
        "The wave as it was recorded, over the last turns of a stretch of the log. Line: the threshold, "
        f"{how}, {in_channel_unit(excerpt.level, unit)}; band: an edge counts once the wave has left it "
        f"(±{in_channel_unit(excerpt.band, unit, 3)}). Dots: edges as they were placed."
    )
    panel = Lines(lines=(wave, threshold, *marks), label=f"wave [{unit}]" if unit else "wave")
    return Figure(Chart(name="wave", caption=caption, table="wave-samples", panels=(panel,), height=2.7), tables)


def _edge_table(excerpt: Excerpt, clock: Clock) -> Table:
    """Edges and threshold, with a row at each end of the excerpt."""
    times = np.concatenate([excerpt.times[:1], excerpt.edges.times, excerpt.times[-1:]])
    polarity = np.concatenate([[0.0], excerpt.edges.polarities, [0.0]])
    level = np.full(times.size, excerpt.level)
    columns = {
        "since_s": clock.column(times),
        "threshold": (level, NUMBER, "threshold"),
        "threshold_low": (level - excerpt.band, NUMBER, "lower end of the hysteresis"),
        "threshold_high": (level + excerpt.band, NUMBER, "upper end of the hysteresis"),
        "rising": (np.where(polarity > 0.0, level, np.nan), NUMBER, "rising edge"),
        "falling": (np.where(polarity < 0.0, level, np.nan), NUMBER, "falling edge"),
    }
    return data_table("Threshold and edges", columns)


def in_channel_unit(value: float, unit: str, digits: int = 4) -> str:
    """A value in the unit of a channel of the log, as in a sentence."""
    return f"{plain(value, digits)} {unit}".strip()


# The pressure


def pressure_figure(portion: Portion) -> Figure:
    """The inlet pressure over some turns."""
    clock = short_clock(float(portion.times[0]), float(portion.times[-1]))
    columns = {
        "since_s": clock.column(portion.times),
        "pressure_Pa": (portion.values, PRESSURE_LEVEL, "inlet pressure"),
    }
    panel = Lines(lines=(Line(x="since_s", y="pressure_Pa", colour=Colour.INLET, width=0.9),))
    caption = "Inlet pressure (gauge) over some turns."
    chart = Chart(name="pressure", caption=caption, table="pressure-course", panels=(panel,), height=2.2)
    return Figure(chart, {"pressure-course": data_table("Inlet pressure as recorded", columns)})


def pressure_fold(sums: Sums, sections: int) -> Figure:
    """The inlet pressure over the angle within the turn."""
    columns = {
        "angle_rad": ((np.arange(ANGLES) + 0.5) * TURN / ANGLES, ANGLE, "estimated spool angle within the turn"),
        "pressure_low_Pa": (sums.folded_low, PRESSURE_LEVEL, "lowest inlet pressure"),
        "pressure_Pa": (sums.folded_mean, PRESSURE_LEVEL, "mean inlet pressure"),
        "pressure_high_Pa": (sums.folded_high, PRESSURE_LEVEL, "highest inlet pressure"),
    }
    mean = Line(
        x="angle_rad",
        y="pressure_Pa",
        label="mean, lowest to highest",
        colour=Colour.INLET,
        low="pressure_low_Pa",
        high="pressure_high_Pa",
    )
    periods = tuple(
        Level(value=TURN * k / sections, upright=True, colour=Colour.FAINT, stroke=Stroke.SOLID)
        for k in range(1, sections)
    )
    panel = Lines(lines=(mean,), label="inlet pressure", levels=periods, left=0.0, right=TURN)
    duty = ""
    if sums.duty_ratio.count:
        duty = (
            f" The pressure is high for {number(sums.duty_ratio.mean, 3)} of a PWM period, mean over "
            f"{plain(sums.duty_ratio.count)} pulses; the spool's own duty ratio is a little less, because the pressure "
            "rises before the tank ports are shut."
        )
    caption = (
        "Inlet pressure (gauge) over the estimated angle within the turn, all samples of the log: their mean, and the "
        f"range between lowest and highest. Upright lines part the PWM periods.{duty}"
    )
    chart = Chart(name="pressure-angle", caption=caption, table="pressure-fold", panels=(panel,), height=2.6)
    return Figure(chart, {"pressure-fold": data_table("Inlet pressure over the angle", columns)})
