"""The result of a comparison of controllers: scores, what noise costs each, one run of all, charts."""

from collections.abc import Iterator, Mapping

import numpy as np

from vvdp.base.kinds import COUNT, DURATION, FRACTION, LENGTH, NUMBER, POSITION, RATIO, Kind
from vvdp.comparison.contest import Contest
from vvdp.comparison.loop_scenarios import CLEAN, USUAL
from vvdp.comparison.loop_trials import TracedLoop
from vvdp.comparison.score_tables import (
    SCORES,
    ErrorFigure,
    Figures,
    error_chart,
    error_tables,
    least_table,
    run_conditions,
    run_findings,
    run_numbers,
    scenario_tables,
    score_table,
)
from vvdp.results.chart import Bars, Chart, Line, Lines
from vvdp.results.result import Column, Result, Section, Table

MANNER = (
    "A spool is moved by the pressure of one chamber against a spring, by a valve at the chamber; an optical sensor "
    "shows its position, polluted with every turn of the spool. Every scenario is run many times, each time with other "
    "noise and another place of the periodic sensor error on the spool; in each run all controllers meet the same."
)
DEFINITIONS = (
    "Errors count from a second after the start of control on. Tracking: position minus reference, rms over all runs, "
    "worst of all. Estimate: what the observer believes less the position; with the raw sensor no one is informed "
    "it. Effort: rms of the valve's command, and of its change from sample to sample. Storage rises: "
    "samples of a run in which what the oil stores against its desired pressure rose beyond what the spool gave it, by "
    "more than a thousandth of the largest, on average. "
    "Failed: share of runs that broke off, or were off by more than 2.5 mm."
)
FIGURES: Mapping[str, tuple[Kind, str]] = {
    "tracking_error_rms_m": (LENGTH, "tracking rms"),
    "tracking_error_rms_low_m": (LENGTH, "tracking rms, exceeded by 95 % of the runs"),
    "tracking_error_rms_high_m": (LENGTH, "tracking rms, exceeded by 5 % of the runs"),
    "tracking_error_worst_m": (LENGTH, "worst"),
    "estimate_error_rms_m": (LENGTH, "estimate rms"),
    "effort_rms": (RATIO, "effort"),
    "effort_change_rms": (RATIO, "change of effort"),
    "storage_rises": (COUNT, "storage rises"),
    "failed": (FRACTION, "failed"),
}
"""Kind and label of each figure of a score."""
SHOWN = (
    "tracking_error_rms_m",
    "tracking_error_worst_m",
    "estimate_error_rms_m",
    "effort_rms",
    "effort_change_rms",
    "storage_rises",
    "failed",
)
CONTROLLERS = Figures("controller", FIGURES, SHOWN)
ERROR = ErrorFigure("tracking_error_rms_m", "Error of tracking", 1e-6, 1e-9)


def controller_result(found: Contest) -> Result:
    """The result of a comparison of controllers."""
    scores, controllers = score_table(found, CONTROLLERS), _controller_table(found)
    errors = error_tables(found, CONTROLLERS, ERROR, "tracking")
    least = least_table(found, ERROR, list(found.contenders), "With what comes within 5 % of it.")
    traces = {} if found.traced is None else {"traces": _trace_table(found.traced)}
    charts = {chart.name: chart for chart in _charts(found, scores, controllers)}
    return Result(
        verb="compare controllers",
        title="Controllers of the spool's axial position",
        system="",
        manner=MANNER,
        conditions=run_conditions(found),
        numbers=run_numbers(found),
        tables={SCORES: scores, "controllers": controllers, **errors, "least": least, **traces},
        charts=charts,
        findings=tuple(run_findings(found, "controllers with the same noise")),
        sections=(
            Section(title="Error of tracking", words=(MANNER,), shows=("conditions", *errors, "least", *charts)),
            Section(title="Scenario by scenario", words=(DEFINITIONS,), shows=(SCORES,), starts_page=True),
            Section(title="Noise and failures", shows=("controllers",)),
        ),
        seconds=found.seconds,
        finished=found.finished,
    )


def screen_tables(found: Contest, result: Result) -> dict[str, Table]:
    """The scores of each scenario that was run, in a table of its own, as a screen has room for."""
    return scenario_tables(found, result.tables[SCORES], dict.fromkeys(found.scenarios, ("controller", *SHOWN)))


def _controller_table(found: Contest) -> Table:
    """Description of each controller, its cost in noise, and where it fails.

    Noise sensitivity is by how much the change of effort is more in the usual scenario than without noise, NaN where
    not both were run.
    """
    names = list(found.contenders)
    noisy, clean = (
        np.array([_figure(found, scenario, name, "effort_change_rms") for name in names]) for scenario in (USUAL, CLEAN)
    )
    failed = [_where(found, name, "failed") for name in names]
    rising = [_where(found, name, "storage_rises") for name in names]
    columns = {
        "name": Column(np.array(names), None, "controller"),
        "title": Column(np.array([found.contenders[name] for name in names]), None, "what it is"),
        "effort_noisy": Column(noisy, RATIO, "change of effort"),
        "effort_clean": Column(clean, RATIO, "change of effort without noise"),
        "noise_sensitivity": Column(noisy - clean, NUMBER, "share due to noise"),
        "rises_in": Column(np.array(rising), None, "stored energy rises in"),
        "failed_in": Column(np.array(failed), None, "fails in"),
    }
    shown = ("name", "title", "noise_sensitivity", "rises_in", "failed_in")
    return Table(title="Noise and failures", columns=columns, shown=shown)


def _figure(found: Contest, scenario: str, name: str, key: str) -> float:
    score = found.scores.get((scenario, name))
    return np.nan if score is None else score[key].value


def _where(found: Contest, name: str, key: str) -> str:
    """The scenarios in which a figure of a controller is above 0."""
    return ", ".join(each for each in found.scenarios_run if _figure(found, each, name, key) > 0.0) or "none"


def _trace_table(traced: TracedLoop) -> Table:
    columns = {"time_s": Column(traced.time, DURATION, "time", "t")}
    columns |= {f"{name}_m": Column(each, POSITION, "position minus reference") for name, each in traced.errors.items()}
    return Table(title="Traces", columns=columns, is_data=True)


def _charts(found: Contest, scores: Table, controllers: Table) -> Iterator[Chart]:
    caption = (
        "Error of tracking for every controller in every scenario. Dot: root mean square over all runs; bar: where "
        "90 % of the runs lie. The scale is logarithmic and the same in all panels; an arrow stands for less than 1 um."
    )
    yield error_chart(found, scores, CONTROLLERS, ERROR, ("tracking-error", caption))
    if found.traced is not None:
        yield _trace_chart(found, found.traced)
    if np.isfinite(controllers["noise_sensitivity"]).all():
        bars = Bars(
            names="name",
            values=("effort_noisy", "effort_clean"),
            labels=("with noise", "without"),
            label="change of the valve's command, rms",
        )
        words = "What noise costs: by how much the valve's command changes from sample to sample, with and without it."
        height = 0.9 + 0.3 * len(found.contenders)
        yield Chart(name="noise", caption=words, table="controllers", panels=(bars,), height=height)


def _trace_chart(found: Contest, traced: TracedLoop) -> Chart:
    """The error of every controller in one run, once it has settled."""
    rows = tuple(int(row) for row in np.flatnonzero(traced.time >= traced.time[0] + 1.0))
    panels = tuple(Lines(lines=(Line(x="time_s", y=f"{name}_m", rows=rows),), title=name) for name in traced.errors)
    title = found.scenarios[traced.scenario].title
    caption = f"Position minus reference in one run: {title}. All met the same noise."
    height = 0.7 + 1.25 * -(-len(panels) // 3)
    return Chart(name="errors", caption=caption, table="traces", panels=panels, columns=3, height=height)
