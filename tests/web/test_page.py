"""A page in a browser: it fetches nothing, shows what the command line does, and refuses what that refuses."""

import json

import pytest
from tests.report.browser import running

from vvdp import loads
from vvdp.base.errors import ConfigError
from vvdp.simulation.layout import vectors
from vvdp.systems.system import load_system, source_text
from vvdp.web.page import MOST_BYTES, web_page

SYSTEM, SETTING, SPEED = "cylinder-stops", "oil.density", "nodes.shaft.speed"
TITLE, HOSTILE = "A cylinder that lifts a weight between two end stops", "</script><script>window.hit = 1</script>"


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """The page of a short run of a system with a hostile title, and its file."""
    folder = tmp_path_factory.mktemp("page")
    file = folder / f"{SYSTEM}.toml"
    file.write_text(source_text(SYSTEM).replace(TITLE, HOSTILE), "utf-8")
    made = web_page(load_system(str(file), (), "0.5 s"))
    path = folder / "page.html"
    path.write_text(made.html, "utf-8")
    return made, path


@pytest.fixture(scope="module")
def browser(chromium, page, tmp_path_factory):
    """The page, opened."""
    with running(chromium, tmp_path_factory.mktemp("profile")) as found:
        found.open(page[1])
        yield found


def refusal(browser, values) -> str:
    return browser.ask(f"vvdp.run({json.dumps(values)}).then(() => '', (problem) => problem.message)")


def test_runs_as_the_command_line_does(browser, page):
    summary = page[0].model["summary"]
    told = "[summary, Object.keys(series), series.time_s.length]"
    found = browser.ask(f"vvdp.run({{}}).then(({{ summary, series }}) => {told})")
    shown = {key for key in summary if key != "wall_time_s"}
    assert shown <= found[0].keys()
    for key in shown:
        assert found[0][key] == pytest.approx(summary[key], rel=1e-12, abs=1e-300), key
    assert {"pressure_chamber_a_Pa", "position_rod_m", "flow_pump_m3_s"} <= set(found[1])
    assert found[2] > 1000


def test_the_file_on_the_page_is_the_system(browser):
    """Its text is that of the system with every value, the hostile title included, and loads to the same case."""
    text = browser.ask("document.querySelector('details pre').textContent")
    assert HOSTILE in text and browser.ask("window.hit === undefined")
    shown, own = loads(text), load_system(SYSTEM, (), "0.5 s")
    assert vectors(shown.case).params.tobytes() == vectors(own.case).params.tobytes()
    assert shown.stepping == own.stepping


def test_fetches_nothing(browser):
    asked = [event["request"]["url"] for event in browser.named("Network.requestWillBeSent")]
    assert asked and all(url.startswith(("file:", "blob:")) for url in asked)
    assert not browser.named("Runtime.exceptionThrown")


def test_policy_lets_no_text_run(browser):
    policy = browser.ask("document.querySelector('meta[http-equiv]').content")
    assert "'unsafe-eval'" not in policy
    assert "'wasm-unsafe-eval'" in policy
    assert "connect-src" not in policy and "default-src 'none'" in policy


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({SETTING: "NaN"}, "not a number with a unit"),
        ({SETTING: 1e9}, "outside 500 to 2000 kg/m^3 for a density"),
        ({SETTING: "870 bar"}, "write the number in kg/m^3"),
        ({"<img src=x>": 1}, "is no value of this system"),
    ],
)
def test_refuses_values_that_cannot_be(browser, values, words):
    assert words in refusal(browser, {"values": values})


def test_refuses_other_levels_and_times(browser):
    assert 'expected "exact" or "quick"' in refusal(browser, {"level": "hasOwnProperty"})
    assert "must be greater than 0" in refusal(browser, {"until": -1})


def test_a_slider_is_followed(browser):
    browser.ask(
        f"(() => {{ const place = vvdp.model.values.findIndex((each) => each.setting === '{SPEED}');"
        "const slider = document.getElementById(`slider-${place}`);"
        "slider.value = slider.max; slider.dispatchEvent(new Event('input')); })()"
    )
    browser.ask(
        "new Promise((resolve) => { const look = () => /done/.test(document.getElementById('state').textContent)"
        " ? resolve() : setTimeout(look, 20); look(); })"
    )
    line = browser.ask("document.querySelector('#setting code').textContent")
    assert line.startswith(f"vvdp run {SYSTEM} --set '{SPEED}=")
    assert browser.ask("document.querySelectorAll('#key-numbers td.moved').length") > 0
    assert browser.ask("document.getElementById('fault').hidden")
    browser.ask("document.getElementById('reset').click()")
    assert browser.ask("document.querySelectorAll('#key-numbers td.moved').length") == 0


def test_stop_keeps_what_was_reached(browser):
    found = browser.ask(
        "(() => { const run = vvdp.run({ until: 50 }); setTimeout(vvdp.stop, 100); return run; })()"
        ".then(({ summary }) => [summary.finished, summary.duration_s])"
    )
    assert found[0] is False
    assert 0.0 < found[1] < 50.0


def test_a_title_stays_a_text(browser, page):
    assert "<script>window.hit" not in page[0].html
    assert browser.ask("typeof window.hit") == "undefined"
    assert browser.ask("document.querySelector('h1').textContent") == HOSTILE


@pytest.mark.thorough
def test_a_page_that_would_be_too_large_shows_fewer_rows(page, monkeypatch):
    """First the quick level goes, then rows of the charts; a page that is still too large is refused."""
    system = load_system(SYSTEM, (), "0.5 s")
    limit = len(page[0].html) - len(page[0].model["modules"]["quick"]) - 10_000
    monkeypatch.setattr("vvdp.web.page.MOST_BYTES", limit)
    made = web_page(system)
    assert len(made.html) <= limit
    assert "quick" not in made.model["modules"]
    assert "one of 2 rows" in made.html
    monkeypatch.setattr("vvdp.web.page.MOST_BYTES", 100_000)
    with pytest.raises(ConfigError, match=r"the page has .* bytes; at most 100000"):
        web_page(system)


def test_is_small_and_counted(page):
    facts = page[0].facts
    assert facts["bytes"] == page[1].stat().st_size < MOST_BYTES
    assert 20_000 < facts["module_bytes"] < 200_000
    assert facts["level"] == "exact"
    assert facts["values"] > 30
