"""One HTML file that shows a run of a system and repeats it, in the browser, for other values; nothing is fetched."""

import base64
import gzip
import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from typing import Any

import numpy as np

from vvdp.base.errors import unusable
from vvdp.evaluation.overview import warnings
from vvdp.report.html import inline_svg, row, table, text
from vvdp.report.interactive import MOTION, is_live, live_body, live_head
from vvdp.report.interactive import asset as shared_asset
from vvdp.report.page import opening
from vvdp.report.report import circuit_svg
from vvdp.results.result import Result
from vvdp.runs.result import run_result
from vvdp.runs.run import RecordedRun
from vvdp.runs.simulate import recorded_run
from vvdp.simulation.layout import held_part
from vvdp.simulation.link import quiet
from vvdp.simulation.parts import outputs_size
from vvdp.simulation.prepare import prepare
from vvdp.simulation.run import simulate
from vvdp.systems.changeable import Changeable, changeable_values
from vvdp.systems.resolved import resolved_text
from vvdp.systems.system import System
from vvdp.web.call import call
from vvdp.web.module import EXACT, QUICK, WebModules, web_modules
from vvdp.web.motion import motion
from vvdp.web.numbers import judgement, labels, summary_sums
from vvdp.web.series import followed_charts, recorded_columns, table_courses

MOST_BYTES = 1_000_000
STRIDES = (1, 2, 4, 8, 16)
"""Of how many rows the first charts show one, where all would make the page too large."""
WORKING, OWN = ("loop.js", "numbers.js", "values.js", "worker.js"), ("motion.js", "scope.js", "page.js")
"""Scripts of the worker that carries runs out, and of the page."""
PAGES = 64
"""Memory that a module has from the start, in pages of 64 KiB: its tables and its stack."""


@dataclass(frozen=True)
class WebPage:
    """The page, with what it consists of."""

    html: str
    modules: WebModules
    values: tuple[Changeable, ...]
    model: Mapping[str, object]

    @property
    def facts(self) -> dict[str, Any]:
        """Facts on the page that the command prints."""
        changeable = sum(not value.why_not for value in self.values)
        return {
            "verb": "export web", "system": self.model["name"], "bytes": len(self.html.encode()),
            "module_bytes": len(self.modules.codes[EXACT]), "values": changeable, "level": EXACT,
        }  # fmt: skip


def web_page(system: System, command: str = "", say: Callable[[str], None] = quiet) -> WebPage:
    """The page of a system, which is run once for what it shows first.

    Where it would be too large it has no quick level, and then its charts show fewer rows until it repeats the run.

    command  the line that runs the system as it is, to which the page adds what is set there
    Raises MissingExtraError without the extra `web`, RunError where the run fails, ConfigError where the page stays too
    large.
    """
    run = recorded_run(system, simulate(system.model, system.case, system.stepping, say=say))
    result = run_result(run)
    model, values, modules = shown_model(run, result, command or f"vvdp run {system.name}")
    html = ""
    for stride in STRIDES:
        html = "\n".join(_lines(run, result, model, values, stride))
        if len(html.encode()) > MOST_BYTES and QUICK in model["modules"]:
            del model["modules"][QUICK]
            html = "\n".join(_lines(run, result, model, values, stride))
        if (size := len(html.encode())) <= MOST_BYTES:
            break
    else:
        raise unusable("export web", f"the page has {size} bytes; at most {MOST_BYTES}: record less (run.window)")
    return WebPage(html, modules, values, model)


def shown_model(
    run: RecordedRun, result: Result, command: str
) -> tuple[dict[str, Any], tuple[Changeable, ...], WebModules]:
    """Data with which the scripts of a page repeat and show a run, the values that a page may change, and the modules.

    Raises MissingExtraError without the extra `web`, RunError where the system cannot be compiled.
    """
    system = run.system
    modules = web_modules(system.model, system.case)
    values = changeable_values(system, _outside_vectors)
    model = {**run_model(system, modules, values), **_shown_numbers(run, result), "command": command}
    return model, values, modules


def page_head() -> str:
    """The head of a page with its policy, which admits the scripts of `scripts_html`."""
    return live_head([_own_scripts()], " 'wasm-unsafe-eval'; worker-src blob:")


def scripts_html(model: Mapping[str, object]) -> str:
    """The end of a page: its model, the scripts of its worker, and its own."""
    data = json.dumps(model, ensure_ascii=False, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    working = "\n".join(map(asset, WORKING))
    return (
        f'<script type="application/json" id="model">{data}</script>\n'
        f'<script type="text/plain" id="worker">{working}</script>\n<script>{_own_scripts()}</script>'
    )


def _own_scripts() -> str:
    return "\n".join([shared_asset(MOTION), *map(asset, OWN)])


def _outside_vectors(system: System) -> Any:
    """Properties of a system that must be the same for a page to run it: all that is not in the vectors of its case."""
    programs = [(name, p.period, p.phase, p.latency, p.trigger is None) for name, p in system.model.programs.items()]
    return system.circuit.text, programs, system.stepping, summary_sums(system)


def run_model(system: System, modules: WebModules, values: Sequence[Changeable]) -> dict[str, Any]:
    """Data with which the scripts of a page run a system."""
    conditions = held_part(system.case)
    return {
        **call(system, prepare(system.model, system.case, system.stepping)),
        "modules": {name: _module_text(code) for name, code in modules.codes.items()},
        "reasons": {str(number): words for number, words in modules.reasons.items()},
        "pages": PAGES,
        "name": system.name,
        "held": [conditions.start, conditions.stop],
        "outputs": outputs_size(system.model, system.case),
        "values": [value.flat for value in values],
    }


def _module_text(code: bytes) -> str:
    return base64.b64encode(gzip.compress(code, mtime=0)).decode()


def _shown_numbers(run: RecordedRun, result: Result) -> dict[str, Any]:
    """Data with which the scripts of a page show and judge a run."""
    system, known = run.system, recorded_columns(run, table_courses)
    moving, figures = motion(run)
    return {
        "sums": summary_sums(system),
        "judgement": judgement(system, run.summary),
        "labels": {key: each for key, each in labels(system).items() if key in run.summary},
        "series": {key: list(each) for key, each in known.items()},
        "moving": {key: list(each) for key, each in moving.items()},
        "figures": figures,
        "charts": followed_charts(result, known),
        "summary": {key: _json(value) for key, value in run.summary.items()},
        "warnings": list(warnings(system, run.summary)),
    }


def _json(value: Any) -> Any:
    if isinstance(value, bool | np.bool_):
        return bool(value)
    return float(value) if np.isfinite(value) else None


def _lines(
    run: RecordedRun, result: Result, model: Mapping[str, object], values: tuple[Changeable, ...], stride: int
) -> Iterator[str]:
    yield opening(text(result.title), asset("page.css"), page_head())
    yield f"<h1>{text(result.title)}</h1>"
    yield f'<p class="facts">System <b>{text(run.system.name)}</b> &middot; {text(time.strftime("%Y-%m-%d"))}</p>'
    yield asset("controls.html")
    yield from _values(values)
    live = [chart for chart in result.charts.values() if is_live(chart)]
    yield "<h2>Course of the run</h2>"
    if stride > 1:
        yield f"<p>To keep the page small, long charts show one of {stride} rows until the run is repeated here.</p>"
    for chart in live:
        still = f'<svg viewBox="0 0 880 {95 * chart.height:.0f}" role="img" aria-label="{text(chart.name)}"></svg>'
        caption = f"<figcaption>{text(chart.caption)}</figcaption>"
        yield f'<figure id="figure-{text(chart.name)}">{still}{caption}</figure>'
    yield '<h2 id="numbers">Key numbers</h2>\n<div id="key-numbers"></div>'
    yield "<h2>Circuit</h2>"
    yield f'<figure id="figure-circuit">{inline_svg(circuit_svg(run), "circuit")}</figure>'
    yield f"<details><summary>System file</summary><pre>{text(resolved_text(run.system))}</pre></details>"
    yield live_body(live, result.tables, stride)
    yield scripts_html(model) + "\n</body>\n</html>"


def _values(values: tuple[Changeable, ...]) -> Iterator[str]:
    """The values with sliders by table, and behind them those that stay, each with the reason."""
    yield '<h2 id="values">Values</h2><div class="sliders">'
    before = ""
    for place, value in enumerate(values):
        if not value.why_not:
            if value.row.table != before:
                yield f"<h3>{text(value.row.table.replace('_', ' '))}</h3>"
                before = value.row.table
            yield _slider_row(place, value)
    yield "</div>"
    fixed = [value for value in values if value.why_not]
    if fixed:
        rows = [row([text(each.row.setting), text(each.row.display_text), text(each.why_not)]) for each in fixed]
        yield f"<details><summary>{len(fixed)} values that the page keeps</summary>"
        yield table(("value", "", "why"), rows) + "</details>"


def _slider_row(place: int, value: Changeable) -> str:
    about = value.flat
    origin = ", ".join(filter(None, (about["status"], about["source"], about["where"])))
    before = f'<label for="slider-{place}">{text(about["label"])}</label>'
    behind = f'<span class="u">{text(about["symbol"])}</span>'
    behind += f'<span class="origin" title="{text(about["note"])}">{text(origin)}</span>'
    return slider_html(place, value, before, behind)


def slider_html(place: int, value: Changeable, before: str = "", behind: str = "") -> str:
    """The slider and the number of a value, with ready HTML before and behind them."""
    label = text(value.flat["label"])
    ends = f'min="{value.low!r}" max="{value.high!r}"'
    step = f"{(value.high - value.low) / 200:.3g}"
    named = "" if before else f' aria-label="{label}"'
    return (
        f'<div class="value{"" if before else " cell"}" data-place="{place}">{before}'
        f'<input type="range" id="slider-{place}" {ends} step="any" data-step="{step}" value="{value.number!r}"{named}>'
        f'<input type="text" inputmode="decimal" value="{value.number!r}" aria-label="{label}, number">{behind}</div>'
    )


def asset(name: str) -> str:
    """The text of a script or style of a page."""
    return resources.files("vvdp.web").joinpath("assets", name).read_text("utf-8")
