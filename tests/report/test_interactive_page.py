"""Live charts as a person uses them: a real browser, dragged, clicked, typed into and printed."""

import numpy as np
import pytest
from tests.report.browser import running

from vvdp.base import kinds
from vvdp.report.drawing import Drawn
from vvdp.report.html import figure
from vvdp.report.interactive import live_body, live_head
from vvdp.report.page import opening
from vvdp.report.plot import draw_chart
from vvdp.results.chart import Bars, Chart, Field, Level, Line, Lines, Stroke
from vvdp.results.result import Column, Table

ROWS = 30_000
RNG = np.random.default_rng(5)


def run_table(rows):
    """A pressure that is switched at 62 Hz, with noise, at uneven times; a flow with a gap."""
    time = np.cumsum(RNG.uniform(0.2, 1.8, rows))
    time = (time - time[0]) / (time[-1] - time[0])
    load = 1e5 * (60.0 + 10.0 * np.sign(np.sin(2.0 * np.pi * 62.0 * time)) + RNG.normal(0.0, 0.3, rows))
    flow = 1e-4 * (3.0 + np.sin(2.0 * np.pi * 5.0 * time))
    flow[rows // 10 : rows // 8] = np.nan
    columns = {
        "time_s": Column(time, kinds.TIME, "time"),
        "load_Pa": Column(load, kinds.PRESSURE_LEVEL, "load"),
        "inlet_Pa": Column(load + 3e5, kinds.PRESSURE_LEVEL, "inlet"),
        "low_Pa": Column(load - 2e5, kinds.PRESSURE_LEVEL, "low"),
        "high_Pa": Column(load + 2e5, kinds.PRESSURE_LEVEL, "high"),
        "flow_m3_s": Column(flow, kinds.FLOW, "flow"),
    }
    return Table(title="course", columns=columns)


def map_table():
    """A plane, so that values between the points are known."""
    duty, load = (each.ravel() for each in np.meshgrid(np.linspace(0.0, 1.0, 6), np.linspace(20e5, 120e5, 5)))
    columns = {
        "duty_ratio": Column(duty, kinds.DUTY_RATIO, "duty ratio"),
        "load_Pa": Column(load + 101325.0, kinds.PRESSURE_LEVEL, "load"),
        "share": Column(0.2 + 0.5 * duty + 0.02 * load / 1e5 / 10.0, kinds.FRACTION, "share"),
    }
    return Table(title="map", columns=columns)


def harmonics_table():
    order = np.arange(1, 9)
    columns = {
        "frequency_Hz": Column(62.0 * order, kinds.FREQUENCY, "frequency"),
        "amplitude_Pa": Column(4e5 / order**2, kinds.PRESSURE_DIFFERENCE, "amplitude"),
        "name": Column(np.array([f"harmonic {each}" for each in order]), None, "name"),
    }
    return Table(title="harmonics", columns=columns)


def circle_table():
    angle = np.linspace(0.0, 2.0 * np.pi, 61)
    columns = {
        "across_m": Column(0.010 * np.cos(angle), kinds.LENGTH, "across"),
        "up_m": Column(0.010 * np.sin(angle), kinds.LENGTH, "up"),
    }
    return Table(title="circle", columns=columns)


PRESSURES = Lines(
    lines=(
        Line(x="time_s", y="inlet_Pa"),
        Line(x="time_s", y="load_Pa", low="low_Pa", high="high_Pa"),
    ),
    label="pressure",
    left=0.8,
    right=1.0,
    levels=(Level(value=80e5, label="relief"),),
)
FLOWS = Lines(lines=(Line(x="time_s", y="flow_m3_s", stroke=Stroke.STEPS),), left=0.8, right=1.0)
CHARTS = (
    Chart(name="course", caption="", table="run", panels=(PRESSURES, FLOWS), height=4.0),
    Chart(name="flow", caption="", table="run", panels=(Lines(lines=(Line(x="time_s", y="flow_m3_s"),)),), height=2.0),
    Chart(name="map", caption="", table="map", panels=(Field(x="duty_ratio", y="load_Pa", z="share"),)),
    Chart(
        name="harmonics",
        caption="",
        table="harmonics",
        side_by_side=True,
        panels=(
            Lines(lines=(Line(x="frequency_Hz", y="amplitude_Pa", stroke=Stroke.STEMS),)),
            Lines(lines=(Line(x="frequency_Hz", y="amplitude_Pa", stroke=Stroke.MARKED),), x_log=True, y_log=True),
        ),
    ),
    Chart(
        name="circle",
        caption="",
        table="circle",
        panels=(Lines(lines=(Line(x="across_m", y="up_m"),), equal=True),),
    ),
    Chart(name="bars", caption="", table="harmonics", panels=(Bars(names="name", values=("amplitude_Pa",)),)),
)
LIVE = [chart.name for chart in CHARTS if chart.name != "bars"]
TABLES = {"run": run_table(ROWS), "map": map_table(), "harmonics": harmonics_table(), "circle": circle_table()}


def write_page(path, charts, tables, more="", draw=draw_chart):
    figures = (figure(draw(chart, tables).svg, chart.name, i, chart.caption) for i, chart in enumerate(charts))
    head = opening("Charts").replace("</head>", f"{live_head()}\n</head>")
    path.write_text("\n".join([head, *figures, more, live_body(charts, tables), "</body>\n</html>"]), "utf-8")
    return path


@pytest.fixture(scope="module")
def browser(chromium, tmp_path_factory):
    with running(chromium, tmp_path_factory.mktemp("browser") / "profile") as found:
        yield found


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    intruder = "<script>window.intruded = true</script>"
    return write_page(tmp_path_factory.mktemp("page") / "report.html", CHARTS, TABLES, intruder)


@pytest.fixture
def charts(browser, page):
    """The browser with the page open and all its charts live, seen from the top."""
    browser.open(page)
    browser.ask(f"vvdpCharts.then((all) => {{ for (const name of {LIVE}) all.open(name); }})")
    browser.ask("scrollTo(0, 0)")
    return browser


def plot(chart, place, what):
    return f"vvdpCharts.then((all) => {{ const plot = all.live.get('{chart}').plots[{place}]; return {what}; }})"


def drawn(browser, chart, place, what):
    """What a panel says of itself once it is drawn again."""
    return browser.ask(plot(chart, place, f"new Promise((done) => setTimeout(() => done({what})))"))


ENDS = "[plot.frame.scales.y.min, plot.frame.scales.y.max]"


def view(browser, chart, place=0):
    return browser.ask(plot(chart, place, "plot.view"))


def spot(browser, chart, across, down=0.5, place=0):
    """A point of the window, by shares of the width and height of a panel's axes."""
    browser.ask(plot(chart, place, "plot.frame.over.scrollIntoView({block: 'center'})"))
    edges = "(({left, top, width, height}) => [left, top, width, height])(plot.frame.over.getBoundingClientRect())"
    left, top, width, height = browser.ask(plot(chart, place, edges))
    return left + across * width, top + down * height


def readout(browser):
    """The cells of the table below the panels, by the first word of each row."""
    rows = browser.ask(
        "[...document.querySelectorAll('#figure-course .live-readout tbody tr')]"
        ".map((row) => [...row.children].map((cell) => cell.textContent))"
    )
    return {row[0]: [_number(cell) for cell in row[1:]] for row in rows}


def _number(text):
    word = text.split(" ")[0].replace("\u2212", "-")
    return np.nan if word == "\u2013" else float(word)


def test_numbers_arrive(charts):
    """Through the packing and the unpacking of the page: within a half step of a block's range."""
    for key, x_y in (("time_s", "x"), ("load_Pa", "y")):
        found = np.array(charts.ask(plot("course", 0, f"Array.from(plot.content.lines[1].{x_y})")))
        wanted = TABLES["run"][key]
        wanted = 1e3 * wanted if key == "time_s" else (wanted - 101325.0) / 1e5
        for block in range(0, ROWS, 1024):
            part = slice(block, block + 1024)
            assert np.max(abs(found[part] - wanted[part])) <= 0.51 / 16382 * np.ptp(wanted[part])


def test_opens_with_the_view_of_the_still_figure_and_holds_the_whole_run(charts):
    assert view(charts, "course") == pytest.approx([800.0, 1000.0])
    assert charts.ask(plot("course", 0, "plot.extent")) == pytest.approx([0.0, 1000.0], abs=1e-3)


def test_dragging_zooms_all_that_is_over_the_same_time(charts):
    charts.drag(spot(charts, "course", 0.25), spot(charts, "course", 0.75))
    for name, place in (("course", 0), ("course", 1), ("flow", 0)):
        assert view(charts, name, place) == pytest.approx([850.0, 950.0], abs=0.5)
    assert view(charts, "harmonics")[1] > 400.0  # another quantity along x
    assert charts.ask(plot("course", 0, "plot.chart.cursors.A")) is None  # a drag is no click


def test_a_chart_that_is_opened_later_shows_what_the_others_show(browser, page):
    browser.open(page)
    browser.ask("vvdpCharts.then((all) => { all.open('course').plots[0].zoom(300, 400); })")
    browser.ask("vvdpCharts.then((all) => { all.live.delete('flow'); all.open('flow'); })")
    assert view(browser, "flow") == pytest.approx([300.0, 400.0])


def test_ends_of_y_follow_what_is_seen(charts):
    time, load = TABLES["run"]["time_s"], TABLES["run"]["high_Pa"]
    charts.ask(plot("course", 0, "plot.zoom(500, 502)"))
    is_seen = (time >= 0.5) & (time <= 0.502)
    low, high = drawn(charts, "course", 0, ENDS)
    top = (max(load[is_seen].max(), TABLES["run"]["inlet_Pa"][is_seen].max()) - 101325.0) / 1e5
    assert low < top <= high < top + 1.0


def test_double_click_resets_and_sets_no_cursor(charts):
    charts.ask(plot("course", 0, "plot.zoom(100, 200)"))
    charts.click(*spot(charts, "course", 0.5), times=2)
    assert view(charts, "course") == pytest.approx([800.0, 1000.0])
    assert view(charts, "flow") == pytest.approx([0.0, 1000.0], abs=1e-3)
    assert charts.ask(plot("course", 0, "plot.chart.cursors.A")) is None


def test_wheel_zooms_about_the_pointer_once_a_panel_is_in_use(charts):
    point = spot(charts, "course", 0.25)
    charts.mouse("mouseWheel", *point, deltaX=0, deltaY=-300)
    assert view(charts, "course") == pytest.approx([800.0, 1000.0])  # else no one could scroll past a chart
    charts.click(*spot(charts, "course", 0.25))
    charts.mouse("mouseWheel", *spot(charts, "course", 0.25), deltaX=0, deltaY=-300)
    left, right = view(charts, "course")
    assert right - left < 150.0
    assert left + 0.25 * (right - left) == pytest.approx(850.0, abs=0.5)


def test_shift_and_drag_moves(charts):
    charts.drag(spot(charts, "course", 0.2), spot(charts, "course", 0.7), modifiers=8)
    assert view(charts, "course") == pytest.approx([700.0, 900.0], abs=1.0)


def test_cursors_read_both_values_and_their_difference(charts):
    charts.click(*spot(charts, "course", 0.3))
    charts.click(*spot(charts, "course", 0.6))
    found = readout(charts)
    time = TABLES["run"]["time_s"]
    at = np.array(charts.ask(plot("course", 0, "[plot.chart.cursors.A.x, plot.chart.cursors.B.x]")))
    assert at == pytest.approx([860.0, 920.0], abs=0.5)
    assert found["time"] == pytest.approx([*at, at[1] - at[0]], abs=0.11)
    assert found["1 / (B \u2212 A)"] == pytest.approx([1e3 / (at[1] - at[0])], rel=1e-4)
    for label, key in (("load", "load_Pa"), ("inlet", "inlet_Pa")):
        a, b = (np.interp(at / 1e3, time, TABLES["run"][key]) - 101325.0) / 1e5
        assert found[label] == pytest.approx([a, b, b - a], abs=2e-3)
    held = TABLES["run"]["flow_m3_s"][np.searchsorted(time, at / 1e3, "right") - 1] * 6e4  # steps hold the last value
    assert found["flow"][:2] == pytest.approx(held, abs=2e-3)


def test_a_gap_has_no_value(charts):
    charts.ask(plot("course", 1, "plot.chart.place(plot, 110, 0)"))
    assert np.isnan(readout(charts)["flow"][0])


def test_values_under_the_pointer_in_all_panels(charts):
    charts.mouse("mouseMoved", *spot(charts, "course", 0.4))
    shown = charts.ask("[...document.querySelectorAll('#figure-course .live-value')].map((each) => each.textContent)")
    load = (np.interp(0.88, TABLES["run"]["time_s"], TABLES["run"]["load_Pa"]) - 101325.0) / 1e5
    assert _number(shown[1]) == pytest.approx(load, abs=1.5)
    assert [text.split(" ")[1] for text in shown] == ["bar", "bar", "lpm"]


def test_lines_are_switched_on_and_off(charts):
    charts.ask(plot("course", 0, "plot.zoom(500, 504)"))
    before = drawn(charts, "course", 0, ENDS)
    charts.ask("document.querySelector('#figure-course .live-legend button').click()")
    assert charts.ask("document.querySelector('#figure-course .live-legend button').ariaPressed") == "false"
    assert drawn(charts, "course", 0, ENDS)[1] < before[1] - 0.5
    charts.ask("document.querySelector('#figure-course .live-legend button').click()")
    assert drawn(charts, "course", 0, ENDS) == pytest.approx(before)


def test_keys_do_what_the_mouse_does(charts):
    charts.ask(plot("course", 0, "plot.frame.over.focus()"))
    for key in ("ArrowRight", "a", "ArrowRight", "ArrowRight", "b", "+"):
        charts.press(key)
    width = charts.ask(plot("course", 0, "plot.frame.over.clientWidth"))
    at = charts.ask(plot("course", 0, "[plot.chart.cursors.A.x, plot.chart.cursors.B.x]"))
    assert at[1] - at[0] == pytest.approx(200.0 * 20.0 / width, rel=0.02)
    assert view(charts, "course") == pytest.approx([850.0, 950.0], abs=0.5)
    charts.press("0")
    charts.press("Escape")
    assert view(charts, "course") == pytest.approx([800.0, 1000.0])
    assert charts.ask(plot("course", 0, "plot.chart.cursors.A")) is None


def test_every_button_has_a_name(charts):
    names = charts.ask(
        "[...document.querySelectorAll('.live button')].map((each) => each.ariaLabel || each.textContent)"
    )
    assert len(names) > 20
    assert all(names)


def test_a_map_has_values_under_the_pointer(charts):
    charts.mouse("mouseMoved", *spot(charts, "map", 0.37, 0.25))
    duty, load = charts.ask(plot("map", 0, "plot.pointed"))
    assert (duty, load) == pytest.approx((0.37, 95.0), abs=1.0)
    shown = charts.ask("document.querySelector('#figure-map .live-value').textContent")
    assert _number(shown) == pytest.approx(0.2 + 0.5 * duty + 0.02 * load / 10.0, abs=1e-4)


def test_a_map_zooms_both_ways(charts):
    charts.drag(spot(charts, "map", 0.5, 0.0), spot(charts, "map", 0.98, 0.5))
    low, high = drawn(charts, "map", 0, ENDS)
    assert view(charts, "map") == pytest.approx([0.5, 0.98], abs=0.01)
    assert (low, high) == pytest.approx((70.0, 120.0), abs=1.0)


def test_a_point_under_the_pointer_says_where_it_is(charts):
    """Stems and points have no value between them: the nearest is shown, with its place."""
    charts.mouse("mouseMoved", *spot(charts, "harmonics", 0.45))
    near = charts.ask(plot("harmonics", 0, "plot.pointed[0]"))
    order = round(near / 62.0)
    shown = charts.ask("document.querySelector('#figure-harmonics .live-value').textContent")
    assert _number(shown) == pytest.approx(4.0 / order**2, rel=1e-4)
    assert _number(shown.partition(" at ")[2]) == pytest.approx(62.0 * order, abs=0.1)


def test_a_circle_stays_round(charts):
    """A unit of x is as long as one of y, and the whole circle is seen."""
    lengths = "['x', 'y'].map((key) => Math.abs(plot.frame.valToPos(10, key) - plot.frame.valToPos(0, key)))"
    across, up = drawn(charts, "circle", 0, lengths)
    assert across == pytest.approx(up, rel=0.01)
    low, high = drawn(charts, "circle", 0, ENDS)
    assert low <= -10.0 < 10.0 <= high


def test_nothing_is_lost_between_pixels(charts):
    """Of all rows few are drawn, and the highest and lowest of every part of the screen are among them."""
    walk = "(({ lines: [, line] }, rows) => (line.walk(line.y, plot.scale, (row) => rows.push(row)), rows))"
    charts.ask(plot("course", 0, "plot.zoom(...plot.extent)"))
    rows = drawn(charts, "course", 0, f"{walk}(plot.content, [])")
    width = charts.ask(plot("course", 0, "plot.frame.over.clientWidth"))
    assert len(rows) < min(10 * width, 0.5 * ROWS)
    assert rows == sorted(rows)
    time, load = TABLES["run"]["time_s"], TABLES["run"]["load_Pa"]
    kept = np.zeros(ROWS, bool)
    kept[rows] = True
    for begin in np.linspace(0.0, 0.99, 50):
        part = (time >= begin) & (time <= begin + 0.01)
        assert load[part & kept].max() >= load[part].max() - 50.0  # 7.7e-6 of the range
        assert load[part & kept].min() <= load[part].min() + 50.0


def test_network_is_forbidden_and_nothing_asks_for_it(browser, page):
    browser.open(page)
    browser.ask("vvdpCharts.then((all) => { all.open('course'); })")
    assert [each["request"]["url"] for each in browser.named("Network.requestWillBeSent")] == [page.as_uri()]
    said = [each["entry"]["text"] for each in browser.named("Log.entryAdded")]
    assert len(said) == 1  # the script that the test put there, and that alone
    assert "script-src" in said[0]
    assert browser.ask("window.intruded") is None
    assert browser.ask("fetch('data:,x').then(() => 'got', () => 'refused')") == "refused"


CHILDREN = "[...each.children].filter((one) => one.checkVisibility()).map((one) => one.localName)"
DISPLAYED = f"[...document.querySelectorAll('figure')].map((each) => {CHILDREN})"


def test_still_figures_without_scripts(browser, page):
    browser.call("Emulation.setScriptExecutionDisabled", value=True)
    try:
        browser.open(page)
        assert browser.ask(DISPLAYED) == [["svg", "figcaption"]] * 6
    finally:
        browser.call("Emulation.setScriptExecutionDisabled", value=False)


def test_live_on_screen_and_still_on_paper(charts):
    assert charts.ask(DISPLAYED) == [["div", "figcaption"]] * 5 + [["svg", "figcaption"]]
    charts.call("Emulation.setEmulatedMedia", media="print")
    try:
        assert charts.ask(DISPLAYED) == [["svg", "figcaption"]] * 6
    finally:
        charts.call("Emulation.setEmulatedMedia", media="")


def blank(chart, tables):
    return Drawn(chart.name, chart.caption, '<svg viewBox="0 0 700 400"></svg>')


@pytest.mark.thorough
def test_million_points_open_and_zoom_without_lag(browser, tmp_path):
    """A second and 16 ms on a machine that does nothing else; here tests share it."""
    page = write_page(tmp_path / "long.html", CHARTS[:1], {"run": run_table(1_000_000)}, draw=blank)
    browser.open(page)
    browser.ask("vvdpCharts.then((all) => { all.open('course'); })")
    opened = browser.ask("performance.getEntriesByName('course')[0].startTime")
    zoom = """(async () => {
      const seconds = [];
      for (let i = 0; i < 60; i++) {
        const half = 500 * 0.9 ** i;
        const begin = performance.now();
        plot.zoom(500 - half, 500 + half);
        await null;
        plot.frame.ctx.getImageData(0, 0, 1, 1);
        seconds.push(performance.now() - begin);
      }
      return seconds.sort((a, b) => a - b);
    })()"""
    times = browser.ask(plot("course", 0, zoom))
    print(f"opened in {opened:.0f} ms, redrawn in {times[30]:.1f} ms (median), {times[-1]:.1f} ms (slowest)")
    assert opened < 5000.0
    assert times[30] < 100.0
