"""Sliders are dragged to both ends by mouse and keyboard, on wide and narrow windows, light and dark."""

import re
from pathlib import Path

import pytest
from tests.report.browser import running

from vvdp.base.files import result_directory
from vvdp.report.report import write_report
from vvdp.runs.simulate import run_system, save_run
from vvdp.systems.system import load_system
from vvdp.web.live import live_page
from vvdp.web.page import web_page

FILE = str(Path(__file__).with_name("starved.toml"))
WIDTHS, SCHEMES = (1400, 390), ("light", "dark")
READABLE = 4.5
"""Least contrast of text (WCAG 2.1, level AA)."""


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """A live report and a page of one system."""
    folder = tmp_path_factory.mktemp("dragged")
    system = load_system(FILE)
    run = run_system(system)
    with result_directory(folder / "run") as place:
        save_run(place, run)
        write_report(place, run, dress=lambda run, page: live_page(run, page, f"vvdp run {FILE}"))
    (folder / "page.html").write_text(web_page(system).html, "utf-8")
    return {"report": folder / "run" / "report.html", "page": folder / "page.html"}


@pytest.fixture(scope="module")
def browser(chromium, tmp_path_factory):
    with running(chromium, tmp_path_factory.mktemp("profile")) as found:
        yield found


def shown(browser, page, width, scheme):
    """Opens a page in a window of a width and colour scheme; how many sliders it has."""
    browser.call("Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=False)
    browser.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
    browser.open(page)
    return browser.ask("vvdp.run({ until: 0.02 }).then(() => document.querySelectorAll('.value [type=range]').length)")


def slider(number):
    return f"document.querySelectorAll('.value [type=range]')[{number}]"


def forget(browser):
    browser.ask("document.getElementById('reset').click()")


def drag(browser, number, is_high):
    """Takes the knob of a slider past one end with the mouse."""
    x, y, width, at = browser.ask(
        f"(() => {{ const one = {slider(number)}; one.scrollIntoView({{ block: 'center' }});"
        "const box = one.getBoundingClientRect(), share = (one.value - one.min) / (one.max - one.min);"
        "return [box.x, box.y + box.height / 2, box.width, share]; })()"
    )
    knob = 16.0
    browser.drag((x + 0.5 * knob + at * (width - knob), y), (x + (width + 20.0 if is_high else -20.0), y))


def press(browser, number, is_high):
    """Moves a slider to one end with a key."""
    browser.ask(f"{slider(number)}.focus()")
    browser.press("End" if is_high else "Home")


def ended(browser):
    """What a page shows when all that was asked for is run: its state and its fault."""
    return browser.ask(
        "(async () => { const state = document.getElementById('state');"
        "do await new Promise((next) => setTimeout(next, 20)); while (!/done|no result/.test(state.textContent)"
        " || !document.getElementById('stop').disabled);"
        "return [state.textContent, document.getElementById('fault').textContent]; })()"
    )


def contrast(browser, selector):
    """The ratio of the luminance of text to that of what it stands on."""
    one, other = browser.ask(
        f"(() => {{ let one = document.querySelector('{selector}'); const colour = getComputedStyle(one).color;"
        "while (one && /, 0\\)$|transparent/.test(getComputedStyle(one).backgroundColor)) one = one.parentElement;"
        "return [colour, one ? getComputedStyle(one).backgroundColor : 'rgb(255, 255, 255)']; })()"
    )
    bright, dark = sorted((luminance(one), luminance(other)), reverse=True)
    return (bright + 0.05) / (dark + 0.05)


def luminance(colour):
    shares = [int(each) / 255.0 for each in re.findall(r"\d+", colour)[:3]]
    linear = [each / 12.92 if each <= 0.03928 else ((each + 0.055) / 1.055) ** 2.4 for each in shares]
    return sum(weight * each for weight, each in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def test_luminance_by_hand():
    """White has 1, black 0, and pure green the weight of green."""
    assert [luminance(f"rgb({each})") for each in ("255, 255, 255", "0, 0, 0", "0, 255, 0")] == [1.0, 0.0, 0.7152]


def goes_to_both_ends(browser, numbers):
    for number in numbers:
        for is_high in (True, False):
            for way in (drag, press):
                way(browser, number, is_high)
                state, fault = ended(browser)
                value, end = browser.ask(f"[{slider(number)}.value, {slider(number)}.{'max' if is_high else 'min'}]")
                assert float(value) == pytest.approx(float(end), rel=1e-9), (number, way)
                assert state.startswith("done") != bool(fault), (number, state, fault)
                assert not fault or fault.startswith("the run cannot go on at t = "), fault
                assert browser.ask("document.getElementById('level').textContent") == "exact"
        forget(browser)
    assert not browser.named("Runtime.exceptionThrown")


def is_readable(browser):
    assert browser.ask("document.documentElement.scrollWidth - innerWidth") <= 0
    for selector in ("h1", ".value", "#start", ".controls + noscript + .small, p.small"):
        assert contrast(browser, selector) > READABLE, selector


@pytest.mark.sampled(3)
@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("width", WIDTHS)
def test_a_slider_goes_to_both_ends(browser, pages, width, scheme):
    count = shown(browser, pages["page"], width, scheme)
    assert count > 15
    is_readable(browser)
    goes_to_both_ends(browser, [count - 1])


def test_the_sliders_of_a_report_are_there_when_it_opens(browser, pages):
    """Of all folded sections, that of the parameters stands open; the others do not."""
    count = shown(browser, pages["report"], 1000, "light")
    visible = "(each) => each.checkVisibility({ contentVisibilityAuto: true })"
    assert count > 15
    assert browser.ask(f"[...document.querySelectorAll('.value [type=range]')].every({visible})")
    assert browser.ask("[...document.querySelectorAll('details.fold[open] > section')].map((each) => each.id)") == [
        "parameters"
    ]


@pytest.mark.thorough
@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("kind", ["page", "report"])
def test_every_slider_goes_to_both_ends(browser, pages, kind, width, scheme):
    count = shown(browser, pages[kind], width, scheme)
    is_readable(browser)
    goes_to_both_ends(browser, range(count))
