"""The page as a person uses it: values dragged, text typed, runs compared, by mouse and by keyboard."""

import time

import pytest
from tests.report.browser import running


def wait_for(page, expression, patience=30.0):
    """Waits until a JavaScript expression is true."""
    ends = time.monotonic() + patience
    while not page.ask(expression):
        assert time.monotonic() < ends, (expression, page.ask("document.getElementById('state').textContent"))
        time.sleep(0.03)


COMPLETE = "document.getElementById('state')?.textContent === 'run complete'"
DUTY = "document.getElementById('value-operation.duty_ratio')"


@pytest.fixture(scope="module")
def browser(chromium, tmp_path_factory):
    with running(chromium, tmp_path_factory.mktemp("profile")) as page:
        yield page


@pytest.fixture
def page(browser, server):
    browser.call("Emulation.setDeviceMetricsOverride", width=1400, height=950, deviceScaleFactor=1, mobile=False)
    browser.visit(server.url)
    wait_for(browser, COMPLETE)
    yield browser
    assert not browser.named("Runtime.exceptionThrown")
    assert [
        each["entry"]["text"] for each in browser.named("Log.entryAdded") if each["entry"]["level"] == "error"
    ] == []
    hosts = {
        each["request"]["url"].split("/")[2]
        for each in browser.named("Network.requestWillBeSent")
        if each["request"]["url"][:4] == "http"
    }
    assert hosts == {f"127.0.0.1:{server.port}"}


def middle(page, expression):
    box = "const b = e.getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2];"
    return page.ask(f"(() => {{ const e = {expression}; e.scrollIntoView({{block: 'center'}}); {box} }})()")


def test_a_drag_makes_drafts_and_its_release_a_whole_run(page):
    slider = f"{DUTY}.closest('.value').querySelector('[type=range]')"
    _, y = middle(page, slider)
    place = "b.x + 8 + (b.width - 16) * (e.value - e.min) / (e.max - e.min)"
    at = page.ask(f"(() => {{ const e = {slider}, b = e.getBoundingClientRect(); return {place}; }})()")
    page.mouse("mouseMoved", at, y)
    page.mouse("mousePressed", at, y, button="left", clickCount=1)
    for i in range(1, 5):
        page.mouse("mouseMoved", at - 4 * i, y, button="left", buttons=1)
    wait_for(page, "document.body.classList.contains('is-draft')")
    assert page.ask("getComputedStyle(document.getElementById('listings')).visibility") == "hidden"
    assert page.ask("getComputedStyle(document.getElementById('draft')).visibility") == "visible"
    page.mouse("mouseReleased", at - 16, y, button="left", clickCount=1)
    wait_for(page, f"{COMPLETE} && !document.body.classList.contains('is-draft')")
    value = page.ask(f"{DUTY}.value")
    assert float(value) != 0.5
    assert f"operation.duty_ratio={value}" in page.ask("document.getElementById('line').textContent")
    page.ask("document.getElementById('undo').click()")
    wait_for(page, f"{COMPLETE} && !document.getElementById('line').textContent.includes('duty')")
    assert page.ask(f"{DUTY}.value") == "0.5"


def test_by_keyboard_alone_a_value_is_moved_and_two_runs_are_compared(page):
    page.ask(f"{DUTY}.closest('.value').querySelector('[type=range]').focus()")
    page.press("ArrowRight")
    wait_for(page, f"state.runs.length === 2 && {COMPLETE}")
    assert page.ask("state.runs[0].result.efficiency !== state.runs[1].result.efficiency")
    for box in (0, 1):
        page.ask(f"document.querySelectorAll('#runs input')[{box}].focus()")
        page.press(" ")
    assert page.ask("document.querySelectorAll('#compared tbody tr').length") > 10
    assert "nan" not in page.ask("document.getElementById('compared').textContent").lower()
    assert page.ask("[...live.values()][0].chart.plots[0].content.lines.length") == 4  # two of each run


def test_a_change_is_written_into_the_text_with_its_origin(page):
    page.ask(f"{DUTY}.value = '0.4'; {DUTY}.dispatchEvent(new Event('change'))")
    wait_for(page, f"{COMPLETE} && document.getElementById('line').textContent.includes('0.4')")
    before = page.ask("state.text.split('\\n')")
    page.ask("document.getElementById('write').click()")
    after = page.ask("state.text.split('\\n')")
    changed = [(a, b) for a, b in zip(before, after, strict=True) if a != b]
    assert len(changed) == 1 and '"0.4"' in changed[0][1]
    assert page.ask("state.changes.size") == 0
    wait_for(page, COMPLETE)


def test_a_typed_mistake_is_shown_at_its_line_and_a_good_line_redraws(page):
    page.ask("document.getElementById('tab-text').click()")
    type_in = (
        "(() => {{ const t = document.getElementById('text'); t.value = {}; t.dispatchEvent(new Event('input')); }})()"
    )
    page.ask(type_in.format("state.saved + '\\n[pump2]\\nspeed = 3\\n'"))
    wait_for(page, "!document.getElementById('faults').hidden")
    line = page.ask("Number(document.querySelector('#numbers-of-lines b').textContent)")
    assert line > page.ask("state.saved.split('\\n').length") - 1
    page.ask(type_in.format("state.saved.replace(/title = .*/, 'title = \"<img src=x onerror=alert(1)>\"')"))
    wait_for(page, "document.getElementById('faults').hidden && document.title.startsWith('<img')")
    assert page.ask("document.querySelectorAll('img').length") == 0
    assert page.ask("getComputedStyle(document.getElementById('listings')).opacity") == "0.35"


@pytest.mark.parametrize("width", [1400, 390])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nothing_is_cut_off_or_too_small(page, width, scheme):
    page.call("Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=False)
    page.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
    wait_for(page, "document.querySelector('.live-plot canvas')?.getBoundingClientRect().width > 200")
    assert page.ask("document.documentElement.scrollWidth <= innerWidth")
    assert page.ask(
        "[...document.querySelectorAll('section, .live-panel')].every((e) => e.getBoundingClientRect().width > 90)"
    )
    texts = "[...document.querySelectorAll('body *')].filter((e) => !e.closest('svg, option') && e.textContent.trim())"
    sizes = f"{texts}.map((e) => parseFloat(getComputedStyle(e).fontSize))"
    assert page.ask(f"Math.min(...{sizes})") >= 9
    dark = "parseInt(/\\d+/.exec(getComputedStyle(document.body).backgroundColor)[0]) < 60"
    assert page.ask(dark) == (scheme == "dark")


def test_a_column_folds(page):
    page.ask("document.querySelector('#file .fold').click()")
    assert page.ask("document.querySelector('#file').getBoundingClientRect().width") < 150
    assert page.ask("document.querySelector('#scopes').getBoundingClientRect().width") > 500
