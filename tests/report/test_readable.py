"""Figures that can be read: no series flat beside another, flags as bars."""

from types import SimpleNamespace

import numpy as np
import pytest
from tests.report.browser import running
from tests.report.test_interactive_page import write_page

from vvdp.base import kinds
from vvdp.report.plot import new_figure
from vvdp.results.chart import Chart, flag_panel
from vvdp.results.quick import is_flag, quick_panel
from vvdp.results.result import Column, Table
from vvdp.runs.charts import FLAT, run_charts, split_by_range

WAVE = np.sin(np.linspace(0.0, 6.0, 101))
"""From -0.96 to 1."""


def test_series_of_other_ranges_have_panels_of_their_own():
    """Of ranges 200, 20, 9.8, 1 and 0.02 about 0, 9.8 is below 5 % of 200, and 0.02 is below 5 % of 9.8."""
    ranges = {"a": 200.0, "b": 20.0, "c": 9.8, "d": 1.0, "e": 0.02}
    values = {key: each * np.array([-0.5, 0.5]) for key, each in ranges.items()}
    assert FLAT == 0.05
    assert split_by_range(values) == [["a", "b"], ["c", "d"]]


def test_a_level_far_away_makes_others_flat():
    """Both move by 1, at 0 and at 100: either is a hundredth of a panel with both."""
    assert split_by_range({"a": np.array([0.0, 1.0]), "b": np.array([100.0, 101.0])}) == [["a"], ["b"]]
    assert split_by_range({"a": np.array([0.0, 1.0]), "b": np.array([15.0, 16.0])}) == [["a", "b"]]


def test_what_stands_still_is_drawn_only_where_all_does():
    still = {"a": np.full(3, 5.0), "b": np.full(3, 7.0)}
    assert split_by_range(still) == [["a", "b"]]
    assert split_by_range(still | {"c": np.array([0.0, 1.0, 0.0])}) == [["c"]]
    assert split_by_range({}) == []


def test_many_names_are_divided():
    values = {f"{k}": np.array([0.0, 1.0 + k]) for k in range(13)}
    assert [len(part) for part in split_by_range(values)] == [4, 4, 5]


class TestRun:
    """The figures of a run: what is not drawn stands in the caption."""

    class _Run:
        def __init__(self, times):
            law = SimpleNamespace(type=SimpleNamespace(is_drawn=True))
            self.times, self.network, self.is_fine = times, SimpleNamespace(programs={"law": law}), True
            self.system = type("", (), {"stepping": type("", (), {"record_interval": 1e-3})()})()
            self.fine_interval, self.period = 1e-3, "period"

        def fine_from(self):
            return 0

        def detail(self):
            rows = np.arange(50, 101)
            return type("", (), {"rows": rows, "marks": np.zeros(1), "periods": 0, "interval": 1e-3})()

        fine = detail

    @pytest.fixture
    def charts(self):
        time = np.linspace(0.0, 1.0, 101)
        columns = {
            "time_s": Column(time, kinds.DURATION, "time"),
            "pressure_inlet_Pa": Column(60e5 + 50e5 * WAVE, kinds.GAUGE_PRESSURE, "inlet"),
            "pressure_line_Pa": Column(40e5 + 0.5e5 * WAVE, kinds.GAUGE_PRESSURE, "line"),
            "pressure_tank_Pa": Column(np.full(101, 2e5), kinds.GAUGE_PRESSURE, "return"),
            "pressure_case_Pa": Column(np.full(101, 1e3), kinds.GAUGE_PRESSURE, "case"),
            "command_law_opening": Column(0.5 + 0.4 * WAVE, kinds.FRACTION, "opening"),
            "command_law_saturated": Column((WAVE > 0.5) * 1.0, kinds.FRACTION, "saturated"),
        }
        return {chart.name: chart for chart in run_charts(self._Run(time), Table(title="run", columns=columns))}

    def test_flat_pressures_are_in_the_caption(self, charts):
        """98 bar, 1 bar about 40, 2 bar and 0.01 bar that do not move."""
        chart = charts["run"]
        assert [[line.label for line in panel.lines] for panel in chart.panels] == [["inlet"], ["line"]]
        assert chart.caption.endswith(" Nearly constant: return 2 bar. Zero: case.")
        assert [panel.left for panel in charts["detail"].panels] == [0.5, 0.5]

    def test_flags_have_a_panel_of_their_own(self, charts):
        opening, flags = charts["program-law"].panels
        assert [line.y for line in opening.lines] == ["command_law_opening"]
        assert flags == flag_panel("time_s", {"command_law_saturated": "saturated"}, "flags")


FLAGS = {
    "time_s": Column(np.arange(11.0), kinds.TIME, "time"),
    "on": Column(np.array([0, 0, 1, 1, 1, 0, 0, 0, 1, 0, 0.0]), kinds.FLAG, "on"),
    "off": Column(np.array([1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0.0]), kinds.FRACTION, "off"),
}
TABLES = {"t": Table(title="flags", columns=FLAGS)}
CHART = Chart(name="c", caption="", table="t", panels=(flag_panel("time_s", {"off": "off", "on": "on"}),), height=2.0)


def test_what_a_flag_is():
    assert is_flag(FLAGS["on"])
    assert not is_flag(Column(np.ones(3), kinds.FLAG, "always"))
    assert not is_flag(Column(np.array([0.0, 0.5, 1.0]), kinds.FRACTION, "share"))
    assert not is_flag(Column(np.array([0.0, 1.0]), kinds.TIME, "time"))
    assert quick_panel("t", TABLES["t"], "on") == flag_panel("time_s", {"on": "on"}, table="t")


def test_flags_are_bars_in_rows():
    """From 2 to 5 s and from 8 to 9 s in the second row of 1, of which 0.7 are filled: 1.15 to 1.85."""
    axes = new_figure(CHART, TABLES).axes[0]
    bars = [path.get_extents().extents for path in axes.collections[1].get_paths()]
    assert len(bars) == 2
    assert bars[0] == pytest.approx([2e3, 1.15, 5e3, 1.85])  # shown in ms
    assert bars[1] == pytest.approx([8e3, 1.15, 9e3, 1.85])
    assert len(axes.collections[0].get_paths()) == 1
    assert axes.get_ylim() == (0.0, 2.0)
    assert list(axes.get_yticks()) == []


def test_flags_are_the_same_bars_in_the_browser(chromium, tmp_path):
    page = write_page(tmp_path / "report.html", [CHART], TABLES)
    opened = "vvdpCharts.then((all) => new Promise((done) => { all.open('c'); setTimeout(done, 100); }))"
    record = (
        "vvdpCharts.then((all) => { const plot = all.live.get('c').plots[0]; const { scale } = plot; const bars = [];"
        "const context = { fillRect: (x, y, w, h) => bars.push("
        "[scale.toX(x), scale.toX(x + w), scale.toY(y + h), scale.toY(y)]) };"
        "for (const line of plot.content.lines) drawFlag(context, line, scale, 1); return bars; })"
    )
    with running(chromium, tmp_path / "profile") as browser:
        browser.open(page)
        browser.ask(opened)
        bars = browser.ask(record)
    wanted = [(0.0, 2e3, 0.15, 0.85), (2e3, 5e3, 1.15, 1.85), (8e3, 9e3, 1.15, 1.85)]
    assert len(bars) == 3
    for bar, expected in zip(bars, wanted, strict=True):
        assert bar == pytest.approx(expected, abs=1e-6)
