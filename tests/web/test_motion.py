"""Diagrams that move: which number moves which line, and what a reader sees of it."""

import numpy as np
import pytest
from tests.report.browser import running

from vvdp.runs.simulate import run_system
from vvdp.systems.system import load_system, shipped_systems
from vvdp.web.motion import motion
from vvdp.web.page import web_page
from vvdp.web.series import recorded_columns, table_courses

SYSTEM = "hydrostatic-transmission"


@pytest.fixture(scope="module")
def run():
    return run_system(load_system(SYSTEM))


def test_flows_of_lines_are_those_of_the_run_and_none_is_lost_at_a_junction(run):
    _, figures = motion(run)
    means = {f"flow {name} {port}".strip(): float(values[-1]) for name, port, values in run.flows()}
    wires, largest = figures["circuit"]["wires"], max(map(abs, means.values()))
    counted = 0
    for rail in figures["circuit"]["rails"]:
        flows = [wires[at] for _, at in rail["joints"]]
        if all(wire["flow"] for wire in flows):
            counted += 1
            assert abs(sum(wire["sign"] * means[wire["flow"]] for wire in flows)) < 1e-3 * largest
    assert counted >= 2


def test_flow_leaves_a_pump_at_its_outlet(run):
    _, figures = motion(run)
    nodes = {"high": 1, "low": -1}
    found = {w["pressure"].split()[1]: w["sign"] for w in figures["circuit"]["wires"] if w["flow"] == "flow pump"}
    assert found == nodes


@pytest.mark.parametrize(("name", "zeros"), [("accumulator-charging", 2), ("prototype", 0)])
def test_numbers_that_are_alike_are_told_apart(name, zeros):
    run = run_system(load_system(name, ['run.window="0.05 s"'], "0.1 s"))
    known, courses = recorded_columns(run, table_courses), table_courses(run)
    assert len(known) > 7
    assert len({(each.rows, each.place) for each in known.values()}) == len(known)
    alike = {values.tobytes() for values in courses.values() if not values.any()}
    assert sum(values.tobytes() in alike for values in courses.values()) >= zeros
    relief = next(key for key in known if "relief" in key)
    assert np.array_equal(courses[relief], run.record.outputs["relief_valve_flow"].values)


@pytest.mark.thorough
@pytest.mark.parametrize("name", sorted(shipped_systems()))
def test_every_diagram_has_pressures_and_lines(name):
    run = run_system(load_system(name, (), "0.05 s"))
    known, figures = motion(run)
    for drawn in figures.values():
        for wire in drawn["wires"]:
            assert wire["flow"] is None or wire["flow"] in known
            assert wire["sign"] in (-1, 0, 1)
        assert all(key in known for *_, key in (*drawn["turning"], *drawn["sliding"]))


@pytest.fixture(scope="module")
def browser(chromium, tmp_path_factory):
    folder = tmp_path_factory.mktemp("motion")
    (folder / "page.html").write_text(web_page(load_system(SYSTEM, (), "2 s")).html, "utf-8")
    with running(chromium, folder / "profile") as found:
        found.page = folder / "page.html"
        found.open(found.page)
        yield found


SEEN = (
    "(() => { const of = (what, name) => [...document.querySelectorAll(`#figure-circuit ${what}`)]"
    ".map((each) => each.getAttribute(name)); return { colours: of('.moving polyline', 'stroke'),"
    " dashes: of('.moving polyline', 'stroke-dashoffset'), gates: of('.gate', 'd'), turned: of('.turning', 'cx'),"
    " hidden: of('.moving', 'display'), button: document.querySelector('.motion .play').textContent,"
    " clock: document.querySelector('.motion output').textContent }; })()"
)


def clicked(browser):
    """Presses the button that starts the animation, and waits until the diagram shows something."""
    return browser.ask(
        "(async () => { document.querySelector('.motion .play').click();"
        " const clock = document.querySelector('.motion output');"
        " while (!clock.textContent) await new Promise((next) => setTimeout(next, 20));"
        f" }})().then(() => {SEEN})"
    )


def later(browser):
    return browser.ask(f"new Promise((next) => setTimeout(next, 400)).then(() => {SEEN})")


def at(browser, time):
    browser.ask(
        "(() => { const reach = document.querySelector('.motion input');"
        f" reach.value = {time}; reach.dispatchEvent(new Event('input')); }})()"
    )
    return browser.ask(SEEN)


def preferring(browser, motion):
    browser.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-reduced-motion", "value": motion}])
    browser.open(browser.page)


def test_lines_are_coloured_and_move(browser):
    preferring(browser, "no-preference")
    assert set(browser.ask(SEEN)["hidden"]) == {"none"}
    first = clicked(browser)
    second = later(browser)
    assert first["button"] == second["button"] == "Pause"
    assert first["clock"] != second["clock"]
    assert first["dashes"] != second["dashes"]
    assert first["turned"] != second["turned"]
    ends = at(browser, 2.0)
    assert ends["button"] == "Animate"
    assert len({each for each in ends["colours"] if each.startswith("rgb")}) >= 3
    assert later(browser)["dashes"] == ends["dashes"]


def test_ports_close(browser):
    closed, opened = at(browser, 0.0)["gates"], at(browser, 1.9)["gates"]
    assert all("V 0.00" in each for each in closed)
    assert any("V 0.00" in each for each in opened) and any("V 0.00" not in each for each in opened)


def test_who_prefers_reduced_motion_sees_a_still(browser):
    preferring(browser, "reduce")
    assert browser.ask(SEEN)["button"] == "Show pressures"
    first = clicked(browser)
    second = later(browser)
    assert first["dashes"] == second["dashes"] and first["clock"] == second["clock"]
    assert browser.ask("document.querySelector('.motion .play').hidden")
    assert at(browser, 1.5)["clock"] == "t = 1.5 s"
    assert not browser.named("Runtime.exceptionThrown")


def test_a_diagram_follows_what_is_set(browser):
    preferring(browser, "reduce")
    clicked(browser)
    before = at(browser, 1.9)["turned"]
    browser.ask(
        "(async () => { const setting = 'components.pump.displacement', state = document.getElementById('state');"
        " const place = vvdp.model.values.findIndex((each) => each.setting === setting);"
        " const slider = document.getElementById(`slider-${place}`); slider.value = slider.max;"
        " slider.dispatchEvent(new Event('input'));"
        " while (!/done/.test(state.textContent)) await new Promise((next) => setTimeout(next, 20)); })()"
    )
    assert at(browser, 1.9)["turned"] != before
