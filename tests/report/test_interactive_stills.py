"""The still figures behind live charts: light, and true where only a part of a long run is shown."""

import re

import numpy as np
import pytest
from matplotlib.figure import Figure

from vvdp.base import kinds
from vvdp.report.drawing import _short_path
from vvdp.report.html import inline_svg, share_letters
from vvdp.report.plot import draw_chart, fill_figure
from vvdp.results.chart import Chart, Line, Lines, Stroke
from vvdp.results.result import Column, Table

ROWS = 200_000


@pytest.fixture(scope="module")
def table():
    """A pressure of 10 bar with a swing of 1 bar in the middle millisecond, and 300 bar at the start."""
    time = np.linspace(0.0, 1.0, ROWS)
    load = 10e5 + 1e5 * np.sin(2e5 * np.pi * time) * ((time > 0.5) & (time < 0.501))
    load[:10] = 300e5
    noise = np.random.default_rng(3).normal(size=ROWS)
    columns = {
        "time_s": Column(time, kinds.DURATION, "time"),
        "load_Pa": Column(load, kinds.PRESSURE_DIFFERENCE, "load"),
        "noise_Pa": Column(1e5 * noise, kinds.PRESSURE_DIFFERENCE, "noise"),
        "walk_Pa": Column(1e3 * np.cumsum(noise), kinds.PRESSURE_DIFFERENCE, "walk"),
    }
    return Table(title="course", columns=columns)


def axes_of(chart, table):
    figure = Figure()
    fill_figure(figure, chart, {"run": table})
    return figure.axes[0]


def chart_of(line, **ends):
    return Chart(name="course", caption="", table="run", panels=(Lines(lines=(line,), **ends),))


def test_points_are_spent_where_they_are_seen(table):
    """100 swings in a thousandth of the run, each of two rows in five: all of them are drawn."""
    axes = axes_of(chart_of(Line(x="time_s", y="load_Pa"), left=0.5, right=0.501), table)
    x, y = (np.asarray(values) for values in axes.lines[0].get_data())
    is_seen = (table["time_s"] > 0.5) & (table["time_s"] < 0.501)
    assert np.count_nonzero(is_seen) == np.count_nonzero((x > 0.5) & (x < 0.501))
    assert axes.get_ylim()[1] < 12.0  # what is not seen does not set the scale
    assert y.max() == pytest.approx(table["load_Pa"][is_seen].max() / 1e5)


@pytest.mark.parametrize("stroke", [Stroke.STEMS, Stroke.POINTS, Stroke.MARKED])
def test_first_and_last_mark_are_whole(table, stroke):
    short = Table(title="", columns={key: Column(c.values[:20], c.kind, c.label) for key, c in table.columns.items()})
    left, right = axes_of(chart_of(Line(x="time_s", y="noise_Pa", stroke=stroke)), short).get_xlim()
    assert left < short["time_s"][0]
    assert right > short["time_s"][-1]


@pytest.mark.parametrize(("key", "least", "most"), [("walk_Pa", 5_000, 8_000), ("noise_Pa", 2_000, 3_500)])
def test_a_long_run_is_a_light_picture(table, key, least, most):
    """Lowest and highest of each of 400 parts, each step with one place (".6-79.1"): about 8 bytes a point.

    Of noise a band with two sides, of which a point is 2.6 points of 451 wide: 347 points.
    """
    svg = draw_chart(chart_of(Line(x="time_s", y=key)), {"run": table}).svg
    assert len(svg) < 40_000
    paths = re.findall(r'\bd="([^"]*)"', svg)
    assert least < max(len(path) for path in paths) < most
    assert not re.search(r"\.\d{3}", " ".join(paths))


def test_steps_of_a_short_path_add_up_to_its_points():
    """By hand, in tenths: 100, 200; 100, 200; 101, 200; 5, 2. A curve keeps hundredths, and a line after it goes on."""
    short = _short_path(
        "M 10 20 L 10.04 20.04 L 10.08 19.98 L 0.5 0.2 C 1.234 2.345 3 4 5.55 6.66 L 6 7 z M 0 0 L 0 3.5"
    )
    assert short == "M10 20l0 0 .1 0-9.6-19.8C1.23 2.35 3 4 5.55 6.66l.4 .3zM0 0l0 3.5"


def test_letters_are_drawn_once_on_a_page(table):
    """The same figure twice: the second takes all its letters from the first, and every letter is there."""
    svg = draw_chart(chart_of(Line(x="time_s", y="noise_Pa")), {"run": table}).svg
    one, two = (inline_svg(svg, name) for name in ("one", "two"))
    page = share_letters(one + two)
    shapes, used = (set(re.findall(rf'<{what}="#?(DejaVuSans[^"]+)"', page)) for what in ("path id", "use href"))
    assert shapes == used
    assert len(re.findall(r'<path id="DejaVuSans', page)) == len(shapes) > 10
    assert page.count("<use href") == (one + two).count("<use xlink:href=") - page.count("<use xlink:href=")
