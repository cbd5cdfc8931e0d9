"""The page as a person uses it: values dragged, text typed, runs compared, by mouse and by keyboard."""

import contextlib
import re
import threading
import time
from http.client import HTTPException

import pytest
from tests.workbench.conftest import serving
from tests.workbench.steps import COMPLETE, DUTY, enter, middle, wait_for

from vvdp.systems.system import source_text

pytestmark = pytest.mark.heavy


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
    first = "[...document.querySelector('#compared tbody tr').children].map((e) => e.textContent)"
    assert page.ask(first) == ["operation.duty_ratio", "as in the file", page.ask(f"{DUTY}.value")]
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
    assert page.ask("getComputedStyle(document.getElementById('listings')).fontStyle") == "italic"


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


def hover(page, part):
    """The pointer over the symbol of a part."""
    x, y = middle(page, f"document.querySelector('#diagram [data-part={part}]')")
    page.mouse("mouseMoved", x, y)
    return x, y


def test_the_diagram_has_mean_values_curves_and_tables(page):
    assert page.ask("document.querySelector('[data-mean=pressure_mean_inlet_Pa]').textContent") == page.ask(
        "`mean ${(state.runs[0].result.pressure_mean_inlet_Pa / 1e5).toPrecision(4).replace(/0+$/, '')} bar`"
    )
    x, y = hover(page, "pump")
    wait_for(page, "!document.getElementById('peek').hidden")
    assert page.ask("document.querySelectorAll('#peek polyline').length") == 1
    assert "lpm" in page.ask("document.getElementById('peek').textContent")
    page.click(x, y)
    shown = "[...document.querySelectorAll('.value')].filter((e) => e.checkVisibility()).map((e) => e.dataset.key)"
    keys = page.ask(shown)
    assert keys and all(key.startswith("pump.") for key in keys)
    assert page.ask("document.getElementById('peek').hidden")
    page.ask("document.querySelector('#diagram [data-part=coupling][tabindex]').focus()")
    page.press("Enter")
    assert page.ask("document.getElementById('filter').value") == "coupling"
    page.ask(
        "(() => { const f = document.getElementById('filter'); f.value = ''; f.dispatchEvent(new Event('input')); })()"
    )
    assert len(page.ask(shown)) == page.ask("state.rows.length")


def test_a_draft_shows_pressures_and_no_other_number(page):
    enter(page, f"{DUTY}.closest('.value').querySelector('[type=range]')", 0.45)
    wait_for(page, "document.body.classList.contains('is-draft')")
    means = (
        "Object.fromEntries([...document.querySelectorAll('[data-mean]')].map((e) => [e.dataset.mean, e.textContent]))"
    )
    for key, words in page.ask(means).items():
        assert ("bar" in words) == key.startswith("pressure"), (key, words)


def test_a_measured_channel_lies_over_the_scope_of_its_unit(page):
    page.ask("document.getElementById('measured').open = true")
    wait_for(page, "document.getElementById('channel').options.length === 3")
    page.ask("document.getElementById('lay').click()")
    lines = "live.get('cycle-time').chart.plots.map((plot) => plot.content.lines.map((line) => line.label))"
    wait_for(page, f"{lines}[0].length === 3")
    assert [len(each) for each in page.ask(lines)] == [3, 4, 2]
    last = "live.get('cycle-time').chart.plots[0].content.lines.at(-1)"
    assert page.ask(f"[{last}.label, {last}.y[1], {last}.x[1]]") == ["p_in (measured)", pytest.approx(62.0), 0.9001]
    enter(page, "document.querySelector('#laid input')", 0.5, "change")
    assert page.ask(f"{last}.x[1]") == pytest.approx(0.5001)
    enter(page, "document.getElementById('channel')", "x", "change")
    assert page.ask("document.getElementById('unit').checkVisibility()")
    page.ask("document.querySelector('#laid button').click()")
    assert [len(each) for each in page.ask(lines)] == [2, 4, 2]


def test_a_series_is_added_by_name_to_a_scope_of_its_own(page):
    lines = "live.get('series')?.chart.plots.map((plot) => plot.content.lines.map((line) => line.label))"
    for name in ("inlet_pressure", "pump_flow"):
        page.ask("document.getElementById('series').focus()")
        page.call("Input.insertText", text=name)
        page.press("Enter")
        wait_for(page, f"live.has('series') && {lines}.flat().length === added.names.length")
    assert page.ask(lines) == [["inlet"], ["pump"]]
    slider = f"{DUTY}.closest('.value').querySelector('[type=range]')"
    enter(page, slider, 0.4, "input")
    wait_for(page, "document.body.classList.contains('is-draft')")
    enter(page, slider, 0.4, "change")
    wait_for(page, f"{COMPLETE} && state.runs.length === 2")
    page.ask("document.querySelector('#runs input').click()")
    assert page.ask(lines) == [["inlet", "inlet (run 1)"], ["pump", "pump (run 1)"]]
    enter(page, "document.getElementById('series')", "nonsense", "change")
    assert "no series of this run" in page.ask("document.getElementById('series-fault').textContent")
    for _ in range(2):
        page.ask("document.querySelector('#series-added button').click()")
    wait_for(page, "!live.has('series')")


def test_many_changes_leave_nothing_waiting(page):
    """200 changes in 3 s: fewer drafts than changes, and the last figure is that of the last value."""
    slider = f"{DUTY}.closest('.value').querySelector('[type=range]')"
    page.ask(
        f"""new Promise((done) => {{ let n = 0; const timer = setInterval(() => {{
        const e = {slider}; e.value = 0.3 + 0.001 * n; e.dispatchEvent(new Event('input'));
        if (++n === 200) {{ clearInterval(timer); e.dispatchEvent(new Event('change')); done(); }} }}, 15); }})"""
    )
    wait_for(page, f"{COMPLETE} && state.answered === state.asked && !document.body.classList.contains('is-draft')")
    assert "--set operation.duty_ratio=0.499" in page.ask("document.getElementById('line').textContent")
    assert page.ask("state.runs.at(-1).words") == "operation.duty_ratio=0.499"


def test_a_lost_server_is_told_and_found_again(browser, tmp_path):
    (tmp_path / "pump.toml").write_text(source_text("prototype"))
    with serving(tmp_path / "pump.toml") as first:
        browser.visit("about:blank")
        browser.visit(first.url)
        wait_for(browser, COMPLETE)
        browser.ask(f"{DUTY}.value = '0.4'; {DUTY}.dispatchEvent(new Event('change'))")
        wait_for(browser, f"{COMPLETE} && state.runs.length === 2")
        first.process.kill()
        first.process.wait()
    wait_for(browser, "document.getElementById('state').textContent.includes('server lost')")
    assert browser.ask("document.querySelectorAll('.live-plot canvas').length") >= 3
    assert browser.ask("document.querySelectorAll('#listings td').length") > 10
    with serving(tmp_path / "pump.toml", "--port", str(first.port)) as second:
        other = browser.call("Target.createTarget", url=second.url, background=True)  # its cookie is for both
        wait_for(browser, f"{COMPLETE} && state.answered === state.asked")
        assert "duty_ratio=0.4" in browser.ask("document.getElementById('line').textContent")
        assert browser.ask("state.runs.length") == 2
        browser.call("Target.closeTarget", targetId=other["targetId"])
    assert not browser.named("Runtime.exceptionThrown")
    browser.visit("about:blank")


DISK = "document.getElementById('disk')"


def typed_before(browser, words):
    change = f"e.value = '{words}' + e.value; e.dispatchEvent(new Event('input'));"
    browser.ask(f"(e => {{ {change} }})(document.getElementById('text'))")


def test_a_file_that_changes_on_disk_is_taken_over_or_told(browser, tmp_path):
    """Loaded where nothing is unsaved; else the reader chooses, and nothing is overwritten without a word."""
    file = tmp_path / "pump.toml"
    text = source_text("prototype")
    file.write_text(text)
    with serving(file) as server:
        browser.visit("about:blank")
        browser.visit(server.url)
        wait_for(browser, COMPLETE)
        file.write_text(text.replace('duty_ratio = { value = "0.5"', 'duty_ratio = { value = "0.3"'))
        wait_for(browser, f"{DUTY}.value === '0.3' && {COMPLETE}")
        assert browser.ask(f"{DISK}.hidden && state.text === state.saved")

        typed_before(browser, "# mine\\n")
        file.write_text("# theirs\n" + text)
        wait_for(browser, f"!{DISK}.hidden")
        assert browser.ask("state.text.startsWith('# mine')")
        browser.ask("document.getElementById('save').click()")
        wait_for(browser, "document.getElementById('faults').textContent.includes('has changed on the disk')")
        assert file.read_text().startswith("# theirs")
        browser.ask("document.getElementById('disk-keep').click()")
        browser.ask("document.getElementById('save').click()")
        wait_for(browser, "document.getElementById('state').textContent === 'saved'")
        assert file.read_text().startswith("# mine")

        typed_before(browser, "# more\\n")
        file.write_text("# last\n" + text)
        wait_for(browser, f"!{DISK}.hidden")
        browser.ask("document.getElementById('disk-load').click()")
        wait_for(browser, COMPLETE)
        assert browser.ask("state.text").startswith("# last") and browser.ask("state.saved === state.text")
        browser.ask("document.getElementById('undo').click()")
        assert browser.ask("state.text").startswith("# more")
    assert not browser.named("Runtime.exceptionThrown")
    browser.visit("about:blank")


@pytest.mark.thorough
def test_saving_is_whole_or_not_at_all(tmp_path):
    """A server that is killed while a text is saved, again and again, leaves the old text or the new one."""
    file = tmp_path / "pump.toml"
    old, new = (f"# {word}\n" + source_text("prototype") for word in ("old", "new"))
    found = set()
    for number in range(6):
        file.write_text(old)
        with serving(file) as server:
            body = {"system": "pump.toml", "text": new, "before": old}
            asking = threading.Thread(target=suppressed, args=(server.ask, "POST", "/api/save", body), daemon=True)
            asking.start()
            time.sleep(0.002 * number)
            server.process.kill()
            server.process.wait()
            asking.join()
        found.add(file.read_text())
    assert found <= {old, new}


def suppressed(call, *arguments):
    with contextlib.suppress(OSError, HTTPException, ValueError):
        call(*arguments)


TEACH = "document.getElementById('teach')"


def test_the_teach_view_shows_an_instant_of_the_period(page):
    page.ask("document.getElementById('open-teach').click()")
    wait_for(page, f"{TEACH}.open && document.getElementById('play').textContent === 'Pause'")
    before = page.ask("teach.clock.share")
    wait_for(page, f"teach.clock.share !== {before}")
    page.ask("document.getElementById('play').click()")
    seen = []
    for place in (0.0, 0.45, 0.6):
        enter(page, "document.getElementById('instant')", place)
        words = page.ask("[...document.querySelectorAll('.port title')].map((e) => e.textContent).join()")
        holes = page.ask("[...document.querySelectorAll('.port-hole')].map((e) => +e.getAttribute('r'))")
        inlet = page.ask("document.querySelector('#teach-diagram [data-node=inlet]').style.color")
        said = page.ask("document.getElementById('teach-pressures').textContent")
        pressure = float(re.search(r"inlet ([\d.]+) bar", said)[1])
        exact = page.ask("valueAt(teach.course.times, teach.course.nodes.inlet, teach.clock.time)")
        assert pressure == pytest.approx(exact, abs=0.06)
        seen.append((words, tuple(holes), inlet))
    assert len({each[2] for each in seen}) > 1 and len({each[1] for each in seen}) > 1
    assert seen[0][0].startswith("valve, load: 100 % open,valve, tank: 0 % open")
    assert page.ask("document.querySelectorAll('#teach-values input').length") == 4
    page.call("Input.dispatchKeyEvent", type="rawKeyDown", key="Escape", code="Escape", windowsVirtualKeyCode=27)
    wait_for(page, f"!{TEACH}.open && !teach.clock.isRunning")


def test_a_slider_of_the_teach_view_moves_the_value(page):
    page.ask("document.getElementById('open-teach').click()")
    before = page.ask("[...teach.course.nodes.inlet].join()")
    page.ask("document.querySelector('#teach-values input').focus()")
    page.press("ArrowRight")
    wait_for(page, f"{COMPLETE} && state.runs.length === 2")
    assert page.ask("[...teach.course.nodes.inlet].join()") != before
    assert float(page.ask(f"{DUTY}.value")) > 0.5
    page.ask("document.getElementById('close-teach').click()")


def test_with_less_motion_nothing_moves_by_itself(page):
    page.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-reduced-motion", "value": "reduce"}])
    page.ask("document.getElementById('open-teach').click()")
    assert page.ask("document.getElementById('play').textContent") == "Play"
    assert page.ask("[...document.querySelectorAll('.flow-marks')].every((e) => e.style.display === 'none')")
    share = page.ask("teach.clock.share")
    time.sleep(0.3)
    assert page.ask("teach.clock.share") == share
    page.ask("document.getElementById('play').click()")
    places = set()
    for _ in range(40):
        places.add(round(12 * page.ask("teach.clock.share"), 6))
        time.sleep(0.03)
    assert len(places) > 2 and all(place == int(place) for place in places)
    page.ask("document.getElementById('close-teach').click()")


def test_a_column_folds(page):
    """To its side where columns stand side by side, to its head where they lie below each other."""
    page.ask("document.querySelector('#file .fold').click()")
    assert page.ask("(b => Math.min(b.width, b.height))(document.querySelector('#file').getBoundingClientRect())") < 150
    share = "document.querySelector('#scopes').getBoundingClientRect().width / Math.min(innerWidth, 1000)"
    assert page.ask(share) > 0.5
