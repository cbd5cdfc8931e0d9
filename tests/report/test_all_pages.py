"""The page of every verb in a real browser: silent, alive, within its window, numbered, printed."""

import base64
import re
import shlex

import numpy as np
import pytest
from tests.report.axe import serious
from tests.report.browser import running

from vvdp.cli.main import main

PAGES = {
    "run": "run prototype --until 0.3s",
    "run of another circuit": "run buck-converter --until 0.1s",
    "map": "map prototype --analytic",
    "rig pressure-drop": "rig pressure-drop prototype",
    "rig derived-capacity": "rig derived-capacity prototype-constant-load --duty 0.4 1 2",
    "design optimum": "design optimum prototype --starts 1 --no-simulation",
    "design temperature": "design temperature prototype",
    "design tolerance": "design tolerance prototype --samples 16 --runs 16",
    "estimate": "estimate log.csv --wave photodiode --pressure inlet",
    "compare estimators": "compare estimators --seeds 2 --scenario constant --estimator m-over-t",
    "compare runs": "compare runs one two",
}
LIMITS = {"prototype": (6, 1.0e6), "displacement-control": (12, 2.2e6)}
"""Most printed pages and bytes of the report of a system's whole run."""
SLOW_PAGES = {
    "simulated map": 'map prototype-constant-load --duty 0.3 0.9 3 --pressure "60 bar" "80 bar" 2',
    "rig step": "rig step prototype-constant-load",
    "rig ripple": "rig ripple prototype",
    "rig pump": 'rig pump prototype --duty 0.3 0.9 3 --pressure "60 bar" "60 bar" 1 --speed "1800 rpm"',
    "rig claims": "rig claims prototype",
    "geometry": "geometry prototype --fineness 10 --frames 2",
    "design pareto": "design pareto prototype --points 8 --generations 2",
}
PAPER = 680
"""Pixels of the width of A4 less its margins."""
TOO_WIDE = """[...document.body.querySelectorAll('*')].filter((each) => {
  const box = each.getBoundingClientRect();
  for (let one = each; one; one = one.parentElement)
    if (one !== document.documentElement && getComputedStyle(one).overflowX !== 'visible' && one !== each) return false;
  return box.width && box.right > document.documentElement.clientWidth + 1;
}).map((each) => `${each.localName}.${each.getAttribute('class') || ''} ${each.textContent.slice(0, 30)}`)"""
NARROW = """[...document.querySelectorAll('.live-plot .u-over')].map((each) => each.clientWidth)
  .filter((width) => width < 180)"""
SMALL = """[...document.querySelectorAll('figure[id^=figure-circuit] svg text')].filter((each) => {
  const scale = each.ownerSVGElement.getScreenCTM().a;
  return parseFloat(getComputedStyle(each).fontSize) * scale < 8.99;
}).map((each) => each.textContent)"""
FINE_PRINT = """[...document.body.querySelectorAll('*')].filter((each) => each.checkVisibility()
  && !each.closest('svg, .live, .solids') && [...each.childNodes].some((one) => one.nodeType === 3 && one.data.trim())
  && parseFloat(getComputedStyle(each).fontSize) < 8.99).map((each) => each.outerHTML.slice(0, 80))"""
SCROLLS = "document.documentElement.scrollWidth - document.documentElement.clientWidth"


@pytest.fixture(scope="module")
def browser(chromium, tmp_path_factory):
    with running(chromium, tmp_path_factory.mktemp("browser") / "profile") as found:
        yield found


def call(line):
    with pytest.raises(SystemExit) as ended:
        main(shlex.split(line))
    assert not ended.value.code, line


@pytest.fixture
def write_page(tmp_path, monkeypatch):
    """Runs a command in an empty folder, beside a log and, where it compares them, two runs; gives the page."""
    monkeypatch.chdir(tmp_path)
    time = np.arange(0.0, 1.5, 2e-4)
    angle = 0.3 + 2.0 * np.pi * 24.7 * time
    light = 0.4 + 3.0 * np.clip(0.5 + 1.6 * np.sin(4.0 * angle), 0.0, 1.0)
    inlet = np.clip(50.0 + 300.0 * np.sin(3.0 * angle), 5.0, 100.0)
    log = np.column_stack([time, light, inlet])
    np.savetxt("log.csv", log, "%.9g", ",", header="time [s],photodiode [V],inlet [bar]", comments="")

    def write(line):
        if line.startswith("compare runs"):
            for name, duty in (("one", 0.4), ("two", 0.6)):
                call(f"run prototype --until 0.1s --no-report --set operation.duty_ratio={duty} --out {name}")
        call(f"{line} --out out")
        return tmp_path / "out" / "report.html"

    return write


def resize(browser, width):
    browser.call("Emulation.setDeviceMetricsOverride", width=width, height=1200, deviceScaleFactor=1, mobile=False)


def opened_charts(browser, page):
    """Opens a page with all its charts; their names."""
    browser.open(page)
    browser.ask("document.querySelectorAll('details.fold').forEach((each) => { each.open = true; })")
    return browser.ask(
        "document.getElementById('chart-data') ? vvdpCharts.then((all) => {"
        " const names = JSON.parse(document.getElementById('chart-data').textContent).charts.map((each) => each.name);"
        " names.forEach((name) => all.open(name)); return names; }) : []"
    )


def check_page(browser, page):
    """Everything that holds for any page."""
    resize(browser, 1000)
    names = opened_charts(browser, page)
    live = "vvdpCharts.then((all) => [...all.live.keys()])"
    assert not names or sorted(browser.ask(live)) == sorted(names)
    figures = browser.ask("[...document.querySelectorAll('figcaption b')].map((each) => each.textContent)")
    assert figures == [f"Figure {count}." for count in range(1, len(figures) + 1)]
    links = browser.ask("[...document.querySelectorAll('nav.contents a')].map((each) => each.getAttribute('href'))")
    headings = browser.ask("[...document.querySelectorAll('section[id]')].map((each) => '#' + each.id)")
    assert links and links == headings
    assert len(set(headings)) == len(headings)
    for scheme in ("dark", "light"):
        browser.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
        assert serious(browser) == [], scheme
    for width in (1000, 600):
        resize(browser, width)
        assert browser.ask(f"new Promise((done) => setTimeout(() => done({TOO_WIDE}), 50))") == [], width
        assert browser.ask(SCROLLS) == 0, width
    assert 1 <= check_paper(browser) <= 20
    check_phone(browser, page)
    check_lead(browser, page)
    said = [each["entry"] for each in browser.named("Log.entryAdded")]
    assert [each for each in said if each["source"] != "rendering"] == []  # that is the driver, on WebGL in software
    assert browser.named("Runtime.exceptionThrown") + browser.named("Runtime.consoleAPICalled") == []
    asked = {each["request"]["url"].split(":")[0] for each in browser.named("Network.requestWillBeSent")}
    assert asked <= {"file", "data"}


def check_lead(browser, page):
    """A page opens with its lead alone: at most twelve numbers, one figure, one box; links and print open the rest."""
    resize(browser, 1000)
    browser.open(page)
    lead = "document.querySelector('body > section')"
    assert browser.ask(f"{lead}.querySelectorAll('tbody tr:not(.group)').length") <= 12
    assert browser.ask(f"{lead}.querySelectorAll('figure').length") <= 1
    assert browser.ask("document.querySelectorAll('body > .notice').length") <= 2  # the other one says what is missing
    folds = browser.ask("[...document.querySelectorAll('details.fold > section')].map((each) => each.id)")
    shown = "(each) => each.checkVisibility({ contentVisibilityAuto: true }) && each.getBoundingClientRect().height > 0"
    sections = "[...document.querySelectorAll('details.fold > section')]"
    assert not browser.ask(f"{sections}.some({shown})")
    if folds:
        browser.ask(f"location.hash = '#{folds[-1]}'")
        assert browser.ask("document.querySelectorAll('details.fold[open]').length") == 1
        browser.call("Emulation.setEmulatedMedia", media="print")
        assert browser.ask(f"{sections}.every((each) => each.getBoundingClientRect().height > 0)")
        browser.call("Emulation.setEmulatedMedia", media="")


def check_phone(browser, page):
    """At 390 px panels stand below each other, each with room for its curves, and the text of diagrams can be read."""
    resize(browser, 390)
    opened_charts(browser, page)
    assert browser.ask(NARROW) == []
    assert browser.ask(f"new Promise((done) => setTimeout(() => done({TOO_WIDE}), 50))") == []
    assert browser.ask(SCROLLS) == 0
    assert browser.ask(SMALL) == []


def check_paper(browser):
    """Nothing is cut off on A4 or too small to read, and the page prints; its sheets."""
    resize(browser, PAPER)
    browser.call("Emulation.setEmulatedMedia", media="print")
    try:
        assert browser.ask(TOO_WIDE) == []
        assert browser.ask(FINE_PRINT) == []
        printed = browser.call("Page.printToPDF", preferCSSPageSize=True)
    finally:
        browser.call("Emulation.setEmulatedMedia", media="")
    pdf = base64.b64decode(printed["data"])
    return len(re.findall(rb"/Type\s*/Page\b", pdf))


@pytest.mark.thorough
@pytest.mark.parametrize("name", PAGES)
def test_page(browser, write_page, name):
    check_page(browser, write_page(PAGES[name]))


@pytest.mark.thorough
@pytest.mark.parametrize("name", LIMITS)
def test_a_whole_run_is_few_sheets_of_paper(browser, write_page, name):
    page = write_page(f"run {name}")
    sheets, size = LIMITS[name]
    assert page.stat().st_size <= size
    opened_charts(browser, page)
    assert check_paper(browser) <= sheets


@pytest.mark.slow
@pytest.mark.parametrize("name", SLOW_PAGES)
def test_slow_page(browser, write_page, name):
    check_page(browser, write_page(SLOW_PAGES[name]))
