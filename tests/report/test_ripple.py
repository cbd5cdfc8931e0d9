"""Cycles too close to be drawn become their mean and a band, in the printed figure and in the browser alike."""

import json

import numpy as np
import pytest
from tests.report.browser import running
from tests.report.test_interactive_page import write_page

from vvdp.base import kinds
from vvdp.report.plot import CLOSE_CYCLES, draw_chart, new_figure
from vvdp.report.plot_lines import PANEL
from vvdp.report.ripple import ripple
from vvdp.results.chart import Chart, Line, Lines, Stroke
from vvdp.results.result import Column, Table

TIME = np.linspace(0.0, 1.0, 20_001)
PULSES = np.where(np.mod(200.0 * TIME, 1.0) < 0.25, 8.0, 0.0)
"""200 in a second, each for a quarter of its period: 2 in the mean."""


def test_pulses_become_their_mean():
    """Closer than 0.01 s two pulses count together: a mean of 8/4, from 0 to 8, and all of the line is replaced."""
    found = ripple(TIME, PULSES, 0.01)
    is_there = np.isfinite(found.mean)
    assert found.mean[is_there] == pytest.approx(2.0, rel=1e-9)
    assert set(found.low[is_there]) == {0.0}
    assert set(found.high[is_there]) == {8.0}
    assert (found.x[0], found.x[-1]) == (0.0, 1.0)
    assert np.count_nonzero(np.isfinite(found.rest)) == 2


def test_a_line_that_can_be_drawn_stays():
    assert ripple(TIME, PULSES, 0.004) is None  # a pulse every 0.005 s
    assert ripple(TIME, np.linspace(0.0, 5.0, TIME.size), 0.01) is None  # slow, however long
    assert ripple(TIME, np.full(TIME.size, 3.0), 0.01) is None
    assert ripple(TIME[::-1], PULSES, 0.01) is None
    assert ripple(TIME, np.where(TIME == 0.5, np.nan, PULSES), 0.01) is None


def test_only_the_part_with_close_cycles_is_replaced():
    """Pulses between 0.4 and 0.8 s, a ramp before and after: the stretches of 0.08 s inside are replaced."""
    line = np.where((TIME > 0.4) & (TIME < 0.8), PULSES, 2.0 + TIME)
    found = ripple(TIME, line, 0.01)
    replaced = TIME[np.isnan(found.rest)]
    assert 0.39 < replaced[0] < 0.49
    assert 0.71 < replaced[-1] < 0.81
    middle = (found.x > 0.5) & (found.x < 0.7)
    assert found.mean[middle] == pytest.approx(2.0, rel=1e-9)


def table_of(values):
    columns = {"time_s": Column(TIME, kinds.TIME, "time"), "line_Pa": Column(values, kinds.PRESSURE_DIFFERENCE, "line")}
    return {"run": Table(title="run", columns=columns)}


def chart_of(stroke=Stroke.SOLID, **more):
    line = Line(x="time_s", y="line_Pa", stroke=stroke)
    return Chart(name="c", caption="A line.", table="run", panels=(Lines(lines=(line,), **more),))


def test_the_limit_is_two_widths_of_the_line():
    """1.3 points twice: 2.6 points of 450.7; 200 pulses are 2.25 points apart, 100 in a view of half a second 4.5."""
    assert pytest.approx(450.7, abs=0.1) == 72.0 * PANEL
    tables = table_of(1e5 * PULSES)
    drawn = draw_chart(chart_of(), tables)
    assert drawn.caption == f"A line. {CLOSE_CYCLES}"
    assert draw_chart(chart_of(left=0.0, right=0.5), tables).caption == "A line."
    assert draw_chart(chart_of(Stroke.STEPS), tables).caption == "A line."
    mean = new_figure(chart_of(), tables).axes[0].lines[0].get_ydata()
    assert mean[np.isfinite(mean)] == pytest.approx(2.0, rel=1e-9)


@pytest.mark.parametrize("closest", [4.0, 7.5])
def test_the_browser_finds_the_same_cycles(closest, chromium, tmp_path):
    """Of pulses with noise on 1000 pixels, where every row is visited: the same places, ends and means."""
    noise = np.random.default_rng(2).normal(0.0, 0.2, TIME.size)
    values = np.where((TIME > 0.2) & (TIME < 0.7), PULSES, 3.0) + noise
    found = ripple(1e3 * TIME, values, closest)
    page = write_page(tmp_path / "report.html", [chart_of()], table_of(values))
    line = f"{{x: {json.dumps((1e3 * TIME).tolist())}, y: {json.dumps(values.tolist())}}}"
    ask = f"(() => {{ const line = {line}; return closeCycles(line, line.x.map((_, i) => i), line.x, {closest}); }})()"
    with running(chromium, tmp_path / "profile") as browser:
        browser.open(page)
        parts = browser.ask(ask)
    is_there = np.isfinite(found.mean)
    assert len(parts) == np.count_nonzero(~is_there) > 0
    for key in ("x", "low", "high", "mean"):
        theirs = [point[key] for part in parts for point in part["points"]]
        assert theirs == pytest.approx(getattr(found, key)[is_there], rel=1e-9, abs=1e-9)
    drawn = sum(part["last"] - part["first"] - 1 for part in parts)
    assert drawn == np.count_nonzero(np.isnan(found.rest))
