"""A report whose values are sliders: its numbers follow a run in the browser; errors are those of the command line."""

from pathlib import Path
from urllib.parse import quote

import pytest
from tests.report.browser import running

from vvdp.base.display import with_unit
from vvdp.base.errors import VvdpError
from vvdp.base.files import result_directory
from vvdp.base.kinds import FLOW
from vvdp.report.report import write_report
from vvdp.results.cells import row_unit
from vvdp.runs.result import loss_listings, number_listings, run_result
from vvdp.runs.simulate import run_system, save_run
from vvdp.simulation.run import simulate
from vvdp.systems.system import load_system
from vvdp.web.followed import GIVEN, PUT_IN, followed_cells
from vvdp.web.live import live_page

FILE = str(Path(__file__).with_name("starved.toml"))
AREA, DENSITY, SPEED = "components.inlet.area", "oil.density", "nodes.shaft.speed"
COMMAND = "vvdp run starved.toml"


def written(folder, dress=None):
    run = run_system(load_system(FILE))
    with result_directory(folder) as place:
        save_run(place, run)
        write_report(place, run, dress=dress)
    return run


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """The directory of a run whose report is live, and the run."""
    folder = tmp_path_factory.mktemp("live") / "run"
    return folder, written(folder, lambda run, page: live_page(run, page, COMMAND))


@pytest.fixture(scope="module")
def browser(chromium, report, tmp_path_factory):
    with running(chromium, tmp_path_factory.mktemp("profile")) as found:
        found.open(report[0] / "report.html")
        yield found


def put(browser, setting, text):
    """Types a value in the parameter table, and waits for what comes of it: the state of the run, and its fault."""
    return browser.ask(
        f"""(async () => {{
        const place = vvdp.model.values.findIndex((each) => each.setting === "{setting}");
        const field = document.querySelector(`.value[data-place="${{place}}"] input[type="text"]`);
        const state = document.getElementById("state");
        state.textContent = "";
        document.getElementById("fault").textContent = "";
        field.value = "{text}";
        field.dispatchEvent(new Event("change"));
        while (!/done|no result/.test(state.textContent)) await new Promise((next) => setTimeout(next, 10));
        return [state.textContent, document.getElementById("fault").textContent];
        }})()"""
    )


def reset(browser):
    browser.ask("document.getElementById('reset').click()")


def refused(setting, text) -> str:
    """What the command line says to a value."""
    with pytest.raises(VvdpError) as problem:
        load_system(FILE, [f'{setting}="{text}"'])
    return str(problem.value).splitlines()[0].removeprefix("--set: ")


@pytest.mark.parametrize(
    ("number", "unit"),
    [("NaN", "kg/m^3"), ("1e9", "kg/m^3"), ("-3", "kg/m^3"), ("1e400", "kg/m^3"), ("x<b>", "kg/m^3")],
)
def test_a_value_that_cannot_be_is_refused_as_on_the_command_line(browser, number, unit):
    state, fault = put(browser, DENSITY, number)
    assert state == "no result"
    assert fault == refused(DENSITY, f"{number} {unit}")
    reset(browser)


def test_a_run_that_stops_itself_says_what_the_command_line_says_and_the_page_goes_on(browser):
    state, fault = put(browser, AREA, "1")
    assert state == "no result"
    starved = load_system(FILE, [f'{AREA}="1 mm^2"'])
    with pytest.raises(VvdpError, match="has fallen below 0 Pa absolute") as problem:
        simulate(starved.model, starved.case, starved.stepping)
    assert fault == str(problem.value)
    state, fault = put(browser, AREA, "150")
    assert state.startswith("done") and not fault
    reset(browser)


def opened(browser, report, address):
    """Opens the report at an address, and waits for what comes of it."""
    browser.open(Path("/"))
    browser.visit(f"{(report[0] / 'report.html').as_uri()}#{address}")
    return browser.ask(
        """(async () => {
        const [state, fault, line] = ["state", "fault", "setting"].map((name) => document.getElementById(name));
        while (!/done|no result/.test(state.textContent) && fault.hidden)
          await new Promise((next) => setTimeout(next, 10));
        const changed = document.querySelectorAll(".value.changed").length;
        return [state.textContent, fault.textContent, line.textContent, changed];
        })()"""
    )


def test_the_address_repeats_what_was_set(browser, report):
    put(browser, DENSITY, "870")
    put(browser, SPEED, "450")
    address = browser.ask("location.hash").removeprefix("#")
    assert address == f"{DENSITY}=870&{SPEED}=450"
    reset(browser)
    assert browser.ask("location.hash") in ("", "#")
    state, fault, line, changed = opened(browser, report, f"{address}&until=0.4")
    assert state.startswith("done") and not fault and changed == 2
    assert f'{SPEED}="450 rpm"' in line and '--until "0.4 s"' in line
    assert browser.ask("vvdp.run({}).then(() => location.hash)").endswith("until=0.4")


@pytest.mark.parametrize(
    ("address", "words"),
    [
        (f"{DENSITY}=1e9", "is outside 500 to 2000 kg/m^3 for a density"),
        (f"{SPEED}=NaN", "is not a number with a unit"),
        ("__proto__=1", "__proto__ is no value of this system"),
        (f"{DENSITY}=870&<b>x</b>=1", "<b>x</b> is no value of this system"),
        ("until=-2", "must be greater than 0"),
    ],
)
def test_an_address_with_what_cannot_be_is_refused(browser, report, address, words):
    _, fault, _, _ = opened(browser, report, quote(address, safe="=&"))
    assert words in fault
    assert browser.ask("document.querySelectorAll('#fault *').length") == 0
    reset(browser)
    state, fault = put(browser, DENSITY, "870")
    assert state.startswith("done") and not fault
    reset(browser)


def cells(browser, kind):
    return browser.ask(f"[...document.querySelectorAll('[data-listing] {kind}')].map((each) => each.textContent)")


def test_what_is_run_unchanged_moves_no_number(browser):
    put(browser, DENSITY, "870")
    assert cells(browser, ".moved")
    state, _ = put(browser, DENSITY, browser.ask(f"vvdp.model.values.find((v) => v.setting === '{DENSITY}').number"))
    assert state.startswith("done")
    assert len(cells(browser, ".now")) > 12
    assert not cells(browser, ".moved")
    reset(browser)
    assert not cells(browser, ".now")


def test_numbers_losses_and_diagram_are_those_of_the_command_line(browser):
    put(browser, SPEED, "450")
    other = run_system(load_system(FILE, [f'{SPEED}="450 rpm"']))
    told = browser.ask(
        "Object.entries(vvdp.model.cells).flatMap(([name, cells]) => {"
        " const rows = document.querySelectorAll(`[data-listing='${name}'] tbody tr:not(.group)`);"
        " return cells.map(([row, at, key, , unit]) => [key, unit.scale, unit.datum,"
        " rows[row].cells[1 + at].querySelector('.now')?.textContent]); })"
    )
    found = {key: (scale, datum, float(text)) for key, scale, datum, text in told if text and key in other.summary}
    assert {"flow_mean_pump_m3_s", "loss_inlet_W", "pressure_min_suction_Pa"} <= found.keys()
    for key, (scale, datum, value) in found.items():
        assert value == pytest.approx((other.summary[key] - datum) / scale, rel=5e-4, abs=5e-10), key
    flow = with_unit(other.summary["flow_mean_pump_m3_s"], FLOW)
    lines = browser.ask("[...document.querySelectorAll('#figure-circuit tspan.moved')].map((each) => each.textContent)")
    assert any(flow in line for line in lines)
    command = browser.ask("document.querySelector('#setting code').textContent")
    assert command == f"{COMMAND} --set '{SPEED}=\"450 rpm\"'"
    reset(browser)


def test_every_chart_over_time_follows(browser):
    names = browser.ask("Object.keys(vvdp.model.charts)")
    assert names
    put(browser, SPEED, "450")
    labels = browser.ask(
        "vvdpCharts.then((page) => Object.keys(vvdp.model.charts).map((name) =>"
        " page.live.get(name).described.panels.flatMap((panel) => panel.lines.map((line) => line.label))))"
    )
    for lines in labels:
        assert len(lines) == 2 * sum(line.endswith(", as computed") for line in lines)
    reset(browser)


def test_a_page_without_the_module_is_as_before(report, tmp_path):
    written(tmp_path / "plain")
    plain = (tmp_path / "plain" / "report.html").read_text("utf-8")
    live = (report[0] / "report.html").read_text("utf-8")
    assert "wasm" not in plain and 'type="range"' not in plain and "data-listing" not in plain
    assert "'wasm-unsafe-eval'" in live and live.count('type="range"') > 15
    assert len(live) - len(plain) < 230_000  # the module, its scripts and the sliders


def test_each_cell_shows_the_number_of_its_key():
    run = run_system(load_system("prototype-constant-load", ['run.window="0.05 s"'], "0.1 s"))
    listings = number_listings(run) | loss_listings(run)
    found = followed_cells(run, run_result(run))
    assert {"overview", "nodes", "losses_by_component"} <= found.keys()
    assert sum(map(len, found.values())) > 60
    for name, cells in found.items():
        for place, at, key, value, unit in cells:
            line = listings[name].rows[place]
            assert value == line.values[at]
            assert unit["symbol"] == row_unit(line)
            assert key in (PUT_IN, GIVEN) or value == pytest.approx(run.summary[key], rel=1e-9, abs=1e-6), key


def test_every_slider_goes_to_both_ends(browser):
    found = browser.ask(
        """(async () => {
        const state = document.getElementById("state"), fault = document.getElementById("fault"), found = [];
        for (const slider of document.querySelectorAll(".value input[type=range]"))
          for (const end of [slider.min, slider.max]) {
            state.textContent = "";
            slider.value = end;
            slider.dispatchEvent(new Event("input"));
            while (!/done|no result/.test(state.textContent)) await new Promise((next) => setTimeout(next, 5));
            found.push([slider.getAttribute("aria-label"), end, /done/.test(state.textContent), fault.textContent]);
            document.getElementById("reset").click();
          }
        return found;
        })()"""
    )
    assert len(found) > 30
    assert sum(is_done for _, _, is_done, _ in found) > 0.8 * len(found)
    for label, end, is_done, fault in found:
        assert is_done != bool(fault), (label, end)
        assert is_done or fault.startswith("the run cannot go on at t = "), (label, end, fault)
    assert not browser.named("Runtime.exceptionThrown")


def test_an_interrupted_run_has_a_plain_report(report, tmp_path):
    heard = []
    run = report[1]
    unfinished = type(run)(run.system, run.record, {**run.summary, "finished": False}, run.meta)
    assert live_page(unfinished, "page", COMMAND, heard.append) == "page"
    assert heard == ["interrupted; the report is not interactive"]
