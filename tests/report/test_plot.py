"""Printed figures: what several panels have in common, and room for what stands around them."""

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from vvdp.base import kinds
from vvdp.report.plot import new_figure, paper_chart
from vvdp.results.chart import Bars, Chart, Line, Lines
from vvdp.results.result import Column, Table

NAMES = "abcde"


@pytest.fixture
def parts():
    values = {"small": np.array([0.0, 0.1, 0.2]), "large": np.array([0.3, 0.5, 0.9])}
    columns = {"part": Column(np.array(["x", "y", "z"]), None, "part")}
    columns |= {key: Column(column, kinds.EFFICIENCY, key) for key, column in values.items()}
    return {"parts": Table(title="parts", columns=columns)}


def test_bars_that_share_their_names_have_one_scale_and_one_legend(parts):
    """The longest bar of all panels, 90 %, and 0.3 of it for what is written behind."""
    panels = tuple(Bars(names="part", values=(key, key), title=key, label="share") for key in ("large", "small"))
    chart = Chart(name="c", caption="", table="parts", panels=panels, side_by_side=True, share=True)
    figure = new_figure(chart, parts)
    left, right = figure.axes
    assert left.get_xlim() == right.get_xlim() == pytest.approx((0.0, 117.0))
    assert len(figure.legends) == 1
    assert left.get_legend() is right.get_legend() is None
    assert left.get_xlabel() == "share [%]"


def test_bars_from_a_base_lie_over_each_other_around_it(parts):
    """From 0.1: the first part reaches down to 0 and up to 0.3. Each panel has a scale of its own."""
    panel = Bars(names="part", values=("small", "large"), base=0.1)
    other = Bars(names="part", values=("large", "large"), base=0.2)
    chart = Chart(name="c", caption="", table="parts", panels=(panel, other), side_by_side=True, share=True)
    left, right = new_figure(chart, parts).axes
    first, second = (container[-1] for container in left.containers)
    assert (first.get_x(), first.get_width()) == pytest.approx((10.0, -10.0))
    assert (second.get_x(), second.get_width()) == pytest.approx((10.0, 20.0))
    assert first.get_y() == second.get_y()
    assert left.get_xlim() != right.get_xlim()


def test_a_legend_of_two_rows_is_inside_the_figure():
    x = np.arange(3.0)
    columns = {"time_s": Column(x, kinds.DURATION, "time")}
    columns |= {f"{name}_W": Column(x + k, kinds.MEAN_POWER, name) for k, name in enumerate(NAMES)}
    lines = tuple(Line(x="time_s", y=f"{name}_W") for name in NAMES)
    chart = Chart(name="c", caption="", table="t", panels=(Lines(lines=lines),), height=2.0)
    figure = new_figure(chart, {"t": Table(title="t", columns=columns)})
    FigureCanvasAgg(figure).draw()
    assert figure.axes[0].get_legend().get_window_extent().y1 <= figure.bbox.y1


def test_numbers_at_an_axis_are_those_of_the_line():
    """Of a flow of 20 lpm that changes by its last digits; not what is left of it beside an offset."""
    columns = {
        "time_s": Column(np.linspace(0.0, 1.0, 50), kinds.TIME, "time"),
        "flow_m3_s": Column(20.0 / 60e3 * (1.0 - 1e-6 * np.linspace(1.0, 0.0, 50)), kinds.FLOW, "flow"),
    }
    panel = Lines(lines=(Line(x="time_s", y="flow_m3_s"),), label="flow")
    chart = Chart(name="flow", caption="A flow.", table="record", panels=(panel,))
    figure = new_figure(chart, {"record": Table(title="Record", columns=columns)})
    FigureCanvasAgg(figure).draw()
    (axes,) = figure.axes
    assert axes.yaxis.get_offset_text().get_text() == ""
    assert all(19.9 < float(label.get_text()) < 20.1 for label in axes.get_yticklabels())


def table_of(names):
    columns = {"time_s": Column(np.arange(3.0), kinds.DURATION, "time")}
    columns |= {f"{name}_W": Column(np.arange(3.0) + k, kinds.MEAN_POWER, name) for k, name in enumerate(names)}
    return {"t": Table(title="t", columns=columns)}


def stack(count, **more):
    panels = tuple(Lines(lines=(Line(x="time_s", y=f"{name}_W"),), **more) for name in NAMES[:count])
    return Chart(name="c", caption="", table="t", panels=panels, height=1.5 * count)


@pytest.mark.parametrize(("count", "columns", "rows"), [(1, 1, 1), (2, 2, 1), (3, 3, 1), (4, 2, 2), (5, 3, 2)])
def test_panels_stand_beside_each_other_on_paper(count, columns, rows):
    """A row is 1.25 inches high, the words below all of them 0.42."""
    chart = paper_chart(stack(count), table_of(NAMES))
    assert (chart.columns, chart.height) == (columns, pytest.approx(0.42 + 1.25 * rows))
    figure = new_figure(chart, table_of(NAMES))
    FigureCanvasAgg(figure).draw()
    tops = {round(axes.get_position().y1, 3) for axes in figure.axes if axes.get_visible()}
    assert len(tops) == rows
    named = [axes.get_xlabel() != "" for axes in figure.axes[:count]]
    assert named == [place + columns >= count for place in range(count)]


def test_panels_with_names_beside_them_stay_one_above_the_other():
    chart = stack(3, legend="part")
    assert paper_chart(chart, table_of(NAMES)) is chart
