"""What a notebook shows: a live chart of a run, and a slider whose curves follow."""

import html
import re

import pytest
from tests.report.browser import running

import vvdp
from vvdp.base.errors import ConfigError

KEY = "components.valve.duty_ratio"


@pytest.fixture(scope="module")
def system():
    return vvdp.load("buck-converter")


@pytest.fixture(scope="module")
def slider(system):
    return vvdp.slider(system, KEY, "0.3", 0.7, count=3, until="0.1 s")


@pytest.fixture(scope="module")
def browser(chromium, tmp_path_factory):
    with running(chromium, tmp_path_factory.mktemp("profile")) as found:
        yield found


def opened(browser, shown, folder):
    """The page in the frame of what a notebook shows, opened by itself."""
    (page,) = re.findall(r'<iframe[^>]* srcdoc="([^"]*)"', shown)
    assert 'sandbox="allow-scripts"' in shown
    (folder / "frame.html").write_text(html.unescape(page), "utf-8")
    browser.open(folder / "frame.html")
    browser.ask("vvdpNotebook.then(() => true)")
    assert not browser.named("Runtime.exceptionThrown")
    assert [each["entry"]["text"] for each in browser.named("Log.entryAdded")] == []


def test_each_place_is_a_whole_run(system, slider):
    assert slider.values == pytest.approx((0.3, 0.5, 0.7))
    alone = system.with_values(**{"components.valve": {"duty_ratio": 0.3}}).run(until="0.1 s")
    assert slider.runs[0].summary["flow_mean_tube_m3_s"] == alone.summary["flow_mean_tube_m3_s"]
    flows = [run.summary["flow_mean_tube_m3_s"] for run in slider.runs]
    assert flows == sorted(flows)  # more supply, more flow to the load


def test_the_chart_follows_the_slider(browser, slider, tmp_path):
    opened(browser, slider._repr_html_(), tmp_path)
    line = "vvdpNotebook.then((chart) => Math.max(...chart.plots[1].content.lines[0].y))"
    move = "(() => { const e = document.querySelector('input'); e.value = 0; e.dispatchEvent(new Event('input')); })()"
    assert browser.ask("document.querySelector('output').textContent") == "0.5"
    before = browser.ask(line)
    browser.ask(move)
    assert browser.ask("document.querySelector('output').textContent") == "0.3"
    assert browser.ask(line) != before
    assert browser.ask("document.querySelector('label').textContent").startswith(KEY)


def test_a_run_shows_its_chart_and_its_numbers(browser, slider, tmp_path):
    shown = slider.runs[0]._repr_html_()
    assert "Losses by component" in shown
    opened(browser, shown, tmp_path)
    assert browser.ask("document.querySelectorAll('canvas').length") == 2
    assert browser.ask("document.querySelector('input')") is None


@pytest.mark.parametrize(
    ("key", "ends", "words"),
    [
        ("components.valve.duty_ration", (), "did you mean 'components.valve.duty_ratio'"),
        ("components.check_valve.cracking_pressure", (), "no number that a slider could move"),
        (KEY, ("3 bar", "4 bar"), "3 bar"),
        (KEY, (5.0, 6.0), "no value can be run"),
    ],
)
def test_what_no_slider_can_move(system, key, ends, words):
    with pytest.raises((ConfigError, vvdp.VvdpError), match=re.escape(words)):
        vvdp.slider(system, key, *ends, count=2, until="0.05 s")


def test_values_that_are_refused_are_left_out_and_named(system, capsys):
    found = vvdp.slider(system, KEY, 0.5, 2.5, count=2, until="0.05 s")
    assert re.findall(r"run (\d) of 2", capsys.readouterr().err) == ["1", "2"]
    assert found.values == (0.5,)
    assert "duty_ratio" in found.left_out[0] and "Left out" in found._repr_html_()
