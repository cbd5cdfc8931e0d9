"""The workbench in Chromium: a drag, a whole run and a keystroke against `simulate`; growth and memory after many."""

import json
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from statistics import median

from tests.report.browser import Browser, running
from tests.workbench.conftest import Running, serving
from tests.workbench.steps import COMPLETE, wait_for
from tests.workbench.test_server import socket_of

from benchmarks.measure import interleaved, report, run_as_command, spread
from benchmarks.pages import private_bytes
from vvdp.simulation.run import simulate
from vvdp.systems.system import load_system, source_text
from vvdp.workbench.work import DRAFT, DRAFT_WINDOW

SYSTEM, KEY = "prototype", "operation.duty_ratio"
FIGURE, SLOWEST, RATE, WHOLE, REST, TEXT = 120.0, 240.0, 15.0, 3.0, 100.0, 60.0
"""Targets on two idle cores: ms to the figure of a draft and at most, figures per s, times `simulate`, ms, ms."""
GROWTH, SERVER, PAGE = 1.2, 300e6, 150e6
HELPERS = """
window.drawn = [];
{
  const own = receive;
  receive = (...parts) => {
    own(...parts);
    requestAnimationFrame(() => drawn.push([parts[0].kind, performance.now()]));
  };
}
window.slider = document.getElementById("value-KEY").closest(".value").querySelector("[type=range]");
window.place = (i) => { slider.value = 0.3 + 0.4 * ((i * 0.618) % 1); slider.dispatchEvent(new Event("input")); };
window.after = async (kind, begun) => {
  for (;;) {
    const found = drawn.find(([each, at]) => each === kind && at > begun);
    if (found) return found[1] - begun;
    await new Promise((next) => setTimeout(next, 1));
  }
};
window.repeat = async (count, act) => {
  const found = [];
  for (let i = 0; i < count; i++) found.push(await act(i, performance.now()));
  return found;
};
window.enter = (i) => change(state.rows.find(({ key }) => key === "KEY"), String(0.3 + 0.4 * ((i * 0.618) % 1)), false);
window.typed = (i) => {
  const text = document.getElementById("text");
  text.value = `${state.saved}# ${i}\\n`;
  text.dispatchEvent(new Event("input"));
};
""".replace("KEY", KEY)
"""Each packet that is drawn, with the time at which the next frame begins; a slider that is moved, values, text."""
CHANGES = "repeat(COUNT, (i, begun) => { place(i); return after('draft', begun); })"
WHOLES = """repeat(COUNT, async (i, begun) => {
  enter(i);
  const figure = await after("figures", begun);
  return [figure, await after("numbers", begun) - figure];
})"""
TYPED = "repeat(COUNT, (i, begun) => { typed(i); return after('drawing', begun); })"
DRAG = """(async () => {
  drawn.length = 0;
  const begun = performance.now();
  for (let i = 0; performance.now() - begun < 1000 * SECONDS; i++) {
    place(i);
    await new Promise((next) => setTimeout(next, 16));
  }
  return drawn.filter(([kind]) => kind === "draft").length / SECONDS;
})()"""


@contextmanager
def opened() -> Iterator[tuple[Running, Browser]]:
    """A workbench with the system in a file, and its page after the first run."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        path = Path(folder, "pump.toml")
        path.write_text(source_text(SYSTEM), "utf-8")
        with serving(path) as server, running(shutil.which("chromium") or "chromium", Path(folder, "profile")) as page:
            page.call("Emulation.setDeviceMetricsOverride", width=1400, height=950, deviceScaleFactor=1, mobile=False)
            page.visit(server.url)
            wait_for(page, COMPLETE)
            page.ask(f"{HELPERS}; 0")
            yield server, page


def simulated(until: float, rounds: int) -> float:
    """The median time [ms] of `simulate` for a share of the run, recorded as a draft is, or for all of it."""
    system = load_system(SYSTEM)
    stepping = system.stepping
    if until < stepping.until:
        stepping = replace(stepping, until=until, average_from=0.5 * until, window=DRAFT_WINDOW * until)
    variants = {"simulate": lambda: simulate(system.model, system.case, stepping)}
    return 1e3 * median(interleaved(variants, rounds, time.perf_counter)["simulate"])


def waits(page: Browser, count: int) -> None:
    """What a person waits for, in ms and as a ratio to `simulate` of the same case, measured before and after."""
    until = load_system(SYSTEM).stepping.until
    page.ask(CHANGES.replace("COUNT", "5"))
    simulated(until, 3)
    before = simulated(DRAFT * until, count)
    changes = page.ask(CHANGES.replace("COUNT", str(count)))
    draft = 0.5 * (before + simulated(DRAFT * until, count))
    report("draft, change to figure", spread(changes, "ms"), f"{FIGURE:g} ms", median(changes) <= FIGURE)
    report("draft, slowest", f"{max(changes):.4g} ms", f"{SLOWEST:g} ms", max(changes) <= SLOWEST)
    report(
        "draft, change to figure over `simulate`", f"{median(changes) / draft:.3g} times {draft:.3g} ms", listed=True
    )
    rate = page.ask(DRAG.replace("SECONDS", "3" if count > 5 else "0.5"))
    report("figures per s while dragging", f"{rate:.3g}", f"{RATE:g}", rate >= RATE)
    before = simulated(until, count)
    wholes = page.ask(WHOLES.replace("COUNT", str(count)))
    whole = 0.5 * (before + simulated(until, count))
    first = [figure / whole for figure, _ in wholes]
    report("whole run, figure over `simulate`", spread(first, "times"), f"{WHOLE:g}", median(first) <= WHOLE)
    rest = [after for _, after in wholes]
    report("whole run, rest after its figure", spread(rest, "ms"), f"{REST:g} ms", median(rest) <= REST)
    typed = page.ask(TYPED.replace("COUNT", str(count)))
    report("keystroke to redrawn circuit", spread(typed, "ms"), f"{TEXT:g} ms", median(typed) <= TEXT)


def resident(server: Running) -> float:
    """Memory of the server [bytes]."""
    status = Path(f"/proc/{server.process.pid}/status").read_text()
    return 1024.0 * int(status.partition("VmRSS:")[2].split()[0])


def many(server: Running, count: int) -> None:
    """So many drafts of one tab after the other, without a page, and tabs that are closed."""
    times, held = list[float](), list[float]()
    with socket_of(server) as page:
        for n in range(count):
            began = time.perf_counter()
            setting = f"{KEY}={0.3 + 0.4 * ((n * 0.618) % 1.0):.4f}"
            page.send(
                json.dumps({"n": n, "kind": "draft", "system": SYSTEM, "set": [setting], "charts": ["cycle-time"]})
            )
            page.recv(timeout=60)
            times.append(time.perf_counter() - began)
            held.append(resident(server))
    part = max(count // 20, 1)
    first, last = (median(found) for found in (times[part : 2 * part], times[-part:]))
    report("last drafts over first ones", f"{last / first:.3g} times", f"{GROWTH:g}", last <= GROWTH * first)
    grown = held[-1] - held[count // 2]
    report("server, grown over the last half", f"{grown / 1e6:.3g} MB", "5 MB", grown < 5e6)
    for _ in range(5):
        with socket_of(server) as page:
            page.send(json.dumps({"n": 1, "kind": "whole", "system": SYSTEM, "set": []}))
            page.recv(timeout=60)
    memory = resident(server)
    words = f"{memory / 1e6:.4g} MB after {count} drafts and 5 closed tabs"
    report("server, memory", words, f"{SERVER / 1e6:g} MB", memory < SERVER)


def main(short: bool) -> None:
    """By the clock on the wall; a page that waits shares the processor with its server."""
    with opened() as (server, page):
        waits(page, 2 if short else 25)
        page.ask("document.getElementById('text').value = state.text = state.saved; 0")
        page.ask(WHOLES.replace("COUNT", "2" if short else "20"))
        runs, held = page.ask("state.runs.length"), private_bytes(page)
        report("page, memory", f"{held / 1e6:.4g} MB with {runs} runs", f"{PAGE / 1e6:g} MB", held < PAGE)
        page.visit("about:blank")
        many(server, 20 if short else 1000)


if __name__ == "__main__":
    run_as_command(main)
