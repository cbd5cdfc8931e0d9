"""Calculations of the server for a page: values, diagram, drafts and whole runs."""

import math
import shlex
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

from vvdp.base import kinds
from vvdp.base.errors import ConfigError, RunError, VvdpError
from vvdp.base.kinds import Kind
from vvdp.base.tables import Sourced
from vvdp.base.units import in_unit
from vvdp.evaluation.summary import run_summary
from vvdp.report.result_page import listing_html
from vvdp.results.chart import Chart
from vvdp.results.result import Table
from vvdp.runs.result import course, run_result
from vvdp.runs.run import RecordedRun
from vvdp.runs.simulate import json_summary, recorded_run, with_closed_forms
from vvdp.runs.tables import screen_listings
from vvdp.simulation.record import record_of
from vvdp.simulation.run import Run, simulate
from vvdp.systems.system import System
from vvdp.workbench import scope
from vvdp.workbench.offer import Asked, Offer
from vvdp.workbench.packet import packet
from vvdp.workbench.schematic import course_of, drawing, mean_texts

DRAFT = 0.15
"""Length of a draft, as a share of the duration of the whole run."""
DRAFT_WINDOW = 1.0 / 3.0
"""The share of a draft that is recorded finely."""
PATIENCE = 0.3
"""A draft ends after so long [s], wherever it has come to."""
SPAN = 10.0
"""A slider without a range of its own goes from a value's tenth to so many times it."""


def faults_of(problem: VvdpError) -> list[dict[str, Any]]:
    """Faults, as the page shows them beside the line or the value."""
    if isinstance(problem, ConfigError):
        return [{"key": each.key, "line": each.line, "message": each.message} for each in problem.faults]
    return [{"key": "", "line": 0, "message": str(problem)}]


def value_rows(system: System) -> list[dict[str, Any]]:
    """The values of a system with unit, origin and the ends of a slider."""
    return [
        {
            "key": row.setting,
            "text": row.display_text,
            "status": row.status,
            "source": " ".join(filter(None, (row.source, row.where))),
            "remark": row.remark,
            **_slider(row),
        }
        for row in system.rows
    ]


def slider_ends(row: Sourced) -> tuple[float, float] | None:
    """The ends [SI] of a slider on a value: those that the file gives, or a tenth to ten times; None of no number."""
    value = row.nominal
    if not math.isfinite(value) or value == 0.0:
        return None
    low, high = row.range or sorted((value / SPAN, value * SPAN))
    return max(low, row.kind.low), min(high, row.kind.high)


def _slider(row: Sourced) -> dict[str, Any]:
    """Number, unit and ends of a value that a slider can set; nothing of others."""
    if (ends := slider_ends(row)) is None:
        return {}
    unit = _unit(row.kind)
    low, high = (_in(each, row.kind, unit) for each in ends)
    return {"number": _in(row.nominal, row.kind, unit), "unit": unit, "low": low, "high": high}


def _unit(kind: Kind) -> str:
    if kind.name == kinds.PRESSURE_LEVEL.name:
        return "bara"
    return "" if kind.unit in ("1", "SI") and kind.display_unit != "%" else kind.display_unit


def _in(value: float, kind: Kind, unit: str) -> float:
    if unit == "bara":
        return value / 1e5
    return float(f"{in_unit(value, kind, unit) if unit else value:.12g}")


def command_line(asked: Asked) -> str:
    """The line that gives the same numbers in a terminal."""
    words = ["vvdp", "run", asked.system]
    for setting in asked.settings:
        words += ["--set", setting]
    return shlex.join(words + ([] if asked.until is None else ["--until", asked.until]))


class View(NamedTuple):
    """Content of a page: names of charts (None: all), whether its diagram moves, series that were added by name."""

    charts: frozenset[str] | None = None
    moves: bool = False
    series: tuple[str, ...] = ()


def draft(system: System, before: Run | None, view: View, number: Any, say: Callable[[str], None]) -> tuple[Run, bytes]:
    """A short run that goes on from the last draft, and the packet of its figures. Raises RunError without a step."""
    length, begin = DRAFT * system.stepping.until, 0.0 if before is None else before.end
    until = begin + length
    stepping = replace(
        system.stepping, until=until, average_from=begin + 0.5 * length, window=DRAFT_WINDOW * length, begin=begin
    )
    ends = time.perf_counter() + PATIENCE
    done = simulate(
        system.model,
        system.case,
        stepping,
        continue_from=before,
        stop=lambda: time.perf_counter() > ends,
        say=say,
    )
    if not done.end > begin:
        raise RunError(f"no draft: the first step takes more than {PATIENCE:g} s; release the slider for the whole run")
    run = RecordedRun(system, record_of(done), run_summary(system, done), {})
    head = {"kind": "draft", "n": number, "rows": int(done.times.size)}
    head["means"] = mean_texts(system, run.summary, is_draft=True)
    return done, packet(head, *_scopes(run, view), course=course_of(run) if view.moves else None)


def _scopes(run: RecordedRun, view: View) -> tuple[list[Chart], dict[str, Table]]:
    """The charts of a run that are on view, with the tables that they draw."""
    charts, tables = course(run, view.charts)
    if not view.series or (view.charts is not None and scope.NAME not in view.charts):
        return charts, tables
    own, every = scope.own_scope(run, tables, view.series)
    return [*charts, *own], every


def whole(system: System, stop: Callable[[], bool], say: Callable[[str], None]) -> RecordedRun:
    """The run from the start of the file to its end, or to where `stop` ends it; its closed forms are left out yet."""
    done = simulate(system.model, system.case, system.stepping, stop=stop, say=say)
    return recorded_run(system, done, summarise=run_summary)


def figures(run: RecordedRun, view: View, number: Any) -> bytes:
    """The packet of a whole run that is shown at once: its charts."""
    head = {"kind": "figures", "n": number, "finished": run.has("finished"), "rows": int(run.times.size)}
    return packet(head, *_scopes(run, view), course=course_of(run))


def added_series(run: RecordedRun, view: View, number: Any) -> bytes:
    """The packet of the scope of series alone, of a run that was shown before."""
    return packet({"kind": "series", "n": number}, *scope.own_scope(run, course(run)[1], view.series))


def numbers(run: RecordedRun) -> dict[str, Any]:
    """Results of a whole run, with diagram and values, for people and as `vvdp run --json` has them."""
    run = with_closed_forms(run)
    result = run_result(run)
    return {
        **_circuit_packet(run.system),
        "means": mean_texts(run.system, run.summary, is_draft=False),
        "result": json_summary(run),
        "labels": {key: each.label for key, each in run.numbers.items()},
        "listings": "".join(map(listing_html, screen_listings(run))),
        "badges": [[str(each.grade), each.words] for each in result.badges],
        "findings": [[str(each.grade), each.title, each.text, each.remedy] for each in result.findings],
        "finished": run.has("finished"),
        "series": scope.listed_series(run, result.tables),
    }


def text_drawing(offer: Offer, asked: Asked) -> Mapping[str, object]:
    """The diagram and the values of a text, without running it."""
    return {"kind": "drawing", **_circuit_packet(offer.system(asked))}


def _circuit_packet(system: System) -> dict[str, Any]:
    return {"svg": drawing(system), "title": system.title, "values": value_rows(system)}
