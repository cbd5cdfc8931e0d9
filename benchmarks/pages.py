"""A page of a system in Chromium: runs at each level against the command line, a drag, opening, memory after drags."""

import json
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from statistics import median

from tests.report.browser import Browser, running

from benchmarks.measure import ROUNDS, interleaved, ratios, report, run_as_command, spread
from vvdp.simulation.run import simulate
from vvdp.systems.system import System, load_system
from vvdp.web.page import web_page

SYSTEMS, PLAIN = ("prototype", "displacement-control", "accumulator-charging"), "prototype"
QUICK_TARGET, EXACT_TARGET, DRAG_TARGET, OPEN_TARGET, MEMORY_TARGET = 2.5, 8.0, 0.15, 1.0, 150e6
LEVELS = {"exact": EXACT_TARGET, "quick": QUICK_TARGET}
DRAG = """
(async () => {
  const place = vvdp.model.values.findIndex((each) => !each.why_not && each.low < each.high);
  const slider = document.getElementById(`slider-${place}`), state = document.getElementById("state"), found = [];
  for (let i = 0; i < COUNT; i++) {
    const { low, high } = vvdp.model.values[place], share = 0.4 + 0.2 * ((i * 0.618) % 1);
    state.textContent = "";
    slider.value = low + share * (high - low);
    const began = performance.now();
    slider.dispatchEvent(new Event("input"));
    while (!/done|no result/.test(state.textContent)) await new Promise((next) => setTimeout(next, 1));
    found.push((performance.now() - began) / 1000);
  }
  return found;
})()
"""


@contextmanager
def opened(html: str) -> Iterator[Browser]:
    """A page in a browser of its own."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        page = Path(folder) / "page.html"
        page.write_text(html, "utf-8")
        with running("chromium", Path(folder) / "profile") as browser:
            browser.open(page)
            yield browser


def seconds(browser: Browser, level: str) -> float:
    """How long the loop of a run takes in the page [s]."""
    told = browser.ask(f"vvdp.run({json.dumps({'level': level})}).then(({{ summary }}) => summary.wall_time_s)")
    return float(told)


def against_native(system: System, html: str, name: str, rounds: int) -> None:
    """The levels of a page against the command line, in turns; the code is warm."""
    variants = {"native": lambda: simulate(system.model, system.case, system.stepping)}
    with opened(html) as browser:
        for level in LEVELS:
            for _ in range(4):
                seconds(browser, level)
        times: dict[str, list[float]] = {level: [] for level in LEVELS} | {"native": []}
        for _ in range(rounds):
            times["native"] += interleaved(variants, 1, time.perf_counter)["native"]
            for level in LEVELS:
                times[level].append(seconds(browser, level))
    for level, target in LEVELS.items():
        found = ratios(times, level, "native")
        report(f"{name}, {level} level / command line", spread(found, "times"), f"{target:g}", median(found) <= target)
        if name == f"{PLAIN}" and level == "quick":
            speed = [(system.stepping.until - system.stepping.begin) / each for each in times[level]]
            report(f"{name}, quick level, simulated s per s", spread(speed, ""), "1", median(speed) >= 1.0)


def private_bytes(browser: Browser) -> int:
    """Memory of the page's process that it shares with no other [bytes]."""
    browser.call("HeapProfiler.collectGarbage")
    found = 0
    for process in Path("/proc").glob("[0-9]*"):
        try:
            words = (process / "cmdline").read_bytes()
            if b"--type=renderer" in words and browser.profile.encode() in words:
                lines = (process / "smaps_rollup").read_text().splitlines()
                found = max(found, sum(1024 * int(line.split()[1]) for line in lines if line.startswith("Private_")))
        except OSError:
            continue
    return found


def dragging(name: str, html: str, count: int, drags: int) -> None:
    """What a drag takes from the movement of the slider to the new numbers and charts; memory after many."""
    with opened(html) as browser:
        ready = "vvdp.run({ until: vvdp.model.stepping.begin + vvdp.model.stepping.record_interval })"
        began = browser.ask(f"{ready}.then(() => performance.now() / 1000)")
        report(f"{name}, opened and ready", f"{began:.3g} s", f"{OPEN_TARGET:g} s", began <= OPEN_TARGET)
        found = browser.ask(DRAG.replace("COUNT", str(count + 5)))[5:]
        report(f"{name}, a drag", spread(found, "ms", 1e3), f"{1e3 * DRAG_TARGET:g} ms", median(found) <= DRAG_TARGET)
        for _ in range(drags // 50):
            browser.ask(DRAG.replace("COUNT", "50"))
        held = private_bytes(browser)
        shown = f"{held / 1e6:.4g} MB after {drags} drags"
        report(f"{name}, memory of the page's process", shown, f"{MEMORY_TARGET / 1e6:g} MB", held <= MEMORY_TARGET)


def main(short: bool) -> None:
    """Exact by the browser's instruction and in software, quick, each beside the command line; then what a reader waits for."""
    rounds, count, drags = (1, 3, 50) if short else (ROUNDS, 25, 1000)
    for name in SYSTEMS[2:] if short else SYSTEMS:
        system = load_system(name, (), "0.1 s" if short else "0.5 s")
        html = web_page(system).html
        against_native(system, html, name, rounds)
        software = html.replace("const isFused = vvdpIsFused()", "const isFused = false")
        assert software != html
        against_native(system, software, f"{name}, in software", rounds)
        dragging(name, html, count, drags)


if __name__ == "__main__":
    run_as_command(main)
