"""The result of a comparison of estimators: scores, cost and robustness, traces, charts."""

from collections.abc import Iterator, Mapping

import numpy as np

from vvdp.base.display import number
from vvdp.base.kinds import (
    ANGLE_ERROR,
    COUNT,
    DURATION,
    FLAG,
    FRACTION,
    FREQUENCY,
    NUMBER,
    SAMPLE_COST,
    SPEED_ERROR,
    TIME,
    Kind,
)
from vvdp.comparison.charts import comparison_charts
from vvdp.comparison.results import Comparison, Traced
from vvdp.comparison.scores import error_key
from vvdp.results.result import Column, Finding, Grade, Number, Result, Section, Table

SPEED = "speed_error_rms_rad_s"
MOST_COLUMNS = 6
"""Scenarios beside each other in a table of a page."""
TIE = 1.05
"""Errors that differ by a factor of less count as the same."""
TINY = 1e-6
"""Errors below this are the rounding of the arithmetic [rad, rad/s]."""
MANNER = (
    "A wheel of bright and dark sectors turns past a photodiode. Every scenario is run many times, each time with "
    "another phase of the clock, another position of the wheel and other noise; in each run all estimators get the "
    "same edges."
)
DEFINITIONS = (
    "Errors are estimate less truth, from 0.5 s on. Mean 95 %: exceeded in 5 % of a run, mean over the runs, so it may "
    "lie below the rms, which is taken over all runs; worst: of all runs; mean: the bias. The angle counts modulo a "
    "turn, relative to the unknown index. Settling: from the step on until the speed stays within 5 % of the step of "
    "its final value, median over the runs; a dash where it does not. Delay: the shift of the true speed that comes "
    "closest to the estimate. Lost: sectors gained or lost in a run, on average. NIS: mean normalised innovation "
    "squared, 1 where the stated uncertainty is right. Within 2 σ: share of errors within two stated deviations, 95 % "
    "where they are right, a dash where none are stated."
)
FIGURES: Mapping[str, tuple[Kind, str]] = {
    "speed_error_rms_rad_s": (SPEED_ERROR, "speed rms"),
    "speed_error_rms_low_rad_s": (SPEED_ERROR, "speed rms, exceeded by 95 % of the runs"),
    "speed_error_rms_high_rad_s": (SPEED_ERROR, "speed rms, exceeded by 5 % of the runs"),
    "speed_error_95_rad_s": (SPEED_ERROR, "speed, mean 95 %"),
    "speed_error_worst_rad_s": (SPEED_ERROR, "worst"),
    "speed_error_mean_rad_s": (SPEED_ERROR, "mean"),
    "speed_coverage": (FRACTION, "within 2 σ"),
    "angle_error_rms_rad": (ANGLE_ERROR, "angle rms"),
    "angle_error_rms_low_rad": (ANGLE_ERROR, "angle rms, exceeded by 95 % of the runs"),
    "angle_error_rms_high_rad": (ANGLE_ERROR, "angle rms, exceeded by 5 % of the runs"),
    "angle_error_95_rad": (ANGLE_ERROR, "angle, mean 95 %"),
    "angle_error_worst_rad": (ANGLE_ERROR, "worst"),
    "angle_error_mean_rad": (ANGLE_ERROR, "mean"),
    "angle_coverage": (FRACTION, "within 2 σ"),
    "settling_median_s": (TIME, "settles"),
    "settling_90_s": (TIME, "settles, 90 % of the runs"),
    "settled": (FRACTION, "share that settles"),
    "delay_s": (TIME, "delay"),
    "lost_sectors": (NUMBER, "lost"),
    "nis": (NUMBER, "NIS"),
}
"""Kind and label of each figure of a score."""
SHOWN = (
    "scenario", "estimator", "speed_error_rms_rad_s", "speed_error_95_rad_s", "speed_error_worst_rad_s",
    "speed_error_mean_rad_s", "speed_coverage", "angle_error_rms_rad", "angle_error_95_rad", "angle_error_worst_rad",
    "angle_coverage", "lost_sectors", "nis", "settling_median_s", "delay_s",
)  # fmt: skip


def comparison_result(found: Comparison) -> Result:
    """The result of a comparison: scores of each pair, cost and robustness of each estimator, traces, charts."""
    tables = {"comparison": _score_table(found), "estimators": _estimator_table(found)}
    speeds = _speed_tables(found)
    tables |= speeds | {"least": _least_table(found)}
    if found.traced:
        tables["traces"] = _trace_table(found.traced)
    charts = {chart.name: chart for chart in comparison_charts(found, tables)}
    runs = sum(played.runs for played in found.scenarios.values())
    return Result(
        verb="compare estimators",
        title="Estimators of angle and speed on a coarse encoder",
        system="",
        manner=MANNER,
        conditions={
            "wheel": f"{found.sectors} sectors",
            "sample rate": f"{number(found.rate)} Hz",
            **{name: f"{played.title}, {played.runs} runs" for name, played in found.scenarios.items()},
        },
        numbers={
            "sectors": Number(float(found.sectors), COUNT, "sectors of the wheel"),
            "rate_Hz": Number(found.rate, FREQUENCY, "sample rate"),
            "seeds": Number(float(found.seeds), COUNT, "runs of each scenario that were asked for"),
            "runs": Number(float(runs), COUNT, "runs that were made"),
        },
        tables=tables,
        charts=charts,
        findings=tuple(_findings(found, runs)),
        sections=(
            Section(title="Error of the speed", words=(MANNER,), shows=("conditions", *speeds, "least", *charts)),
            Section(title="Scenario by scenario", words=(DEFINITIONS,), shows=("comparison",), starts_page=True),
            Section(title="Cost and robustness", shows=("estimators",)),
        ),
        seconds=found.seconds,
        finished=found.finished,
    )


def _findings(found: Comparison, runs: int) -> Iterator[Finding]:
    if not found.finished:
        yield Finding(
            text=f"{runs} of {found.seeds * len(found.scenarios)} runs were made.",
            grade=Grade.WARNING,
            title="Not all runs were made",
        )
    yield Finding(text=f"{runs} runs of {len(found.estimators)} estimators on the same readings.")


def _score_table(found: Comparison) -> Table:
    """A row for every scenario and estimator; the standard error of a figure in a column with `se`."""
    pairs = list(found.scores)
    columns = {
        "scenario": Column(np.array([scenario for scenario, _ in pairs]), None, "scenario"),
        "estimator": Column(np.array([estimator for _, estimator in pairs]), None, "estimator"),
        "runs": Column(np.array([float(found.scenarios[scenario].runs) for scenario, _ in pairs]), COUNT, "runs"),
    }
    for key, (kind, label) in FIGURES.items():
        values, errors = np.array([found.scores[pair][key] for pair in pairs]).T
        columns[key] = Column(values, kind, label)
        columns[error_key(key)] = Column(errors, kind, f"{label}, standard error")
    shown = SHOWN if found.first_step else SHOWN[:-2]
    return Table(title="Scenario by scenario", columns=columns, shown=shown)


def _estimator_table(found: Comparison) -> Table:
    """What each estimator is, what it costs, and in which scenarios it loses count in one run or more."""
    names = list(found.estimators)
    values, errors = np.array([found.costs[name] for name in names]).T
    lost = [
        ", ".join(
            scenario for scenario in found.scenarios_run if found.scores[scenario, name]["lost_sectors"].value > 0.0
        )
        for name in names
    ]
    columns = {
        "name": Column(np.array(names), None, "estimator"),
        "title": Column(np.array([found.estimators[name].title for name in names]), None, "what it is"),
        "causal": Column(np.array([float(found.estimators[name].causal) for name in names]), FLAG, "causal"),
        "cost_s": Column(values, SAMPLE_COST, "time of a sample"),
        "cost_se_s": Column(errors, SAMPLE_COST, "time of a sample, standard error"),
        "relative_cost": Column(values / values[0], NUMBER, "relative"),
        "lost_in": Column(np.array([each or "none" for each in lost]), None, "sectors lost in"),
    }
    shown = ("name", "title", "cost_s", "relative_cost", "lost_in")
    return Table(title="Cost and robustness", columns=columns, shown=shown)


def _speed_tables(found: Comparison) -> dict[str, Table]:
    """The speed error of each estimator by scenario, as many scenarios in a table as a page has room for."""
    names, played = list(found.estimators), list(found.scenarios_run)
    tables = {}
    for count, first in enumerate(range(0, len(played), MOST_COLUMNS), 1):
        columns = {"estimator": Column(np.array(names), None, "estimator")}
        for scenario in played[first : first + MOST_COLUMNS]:
            values = np.array([found.scores[scenario, name][SPEED].value for name in names])
            columns[f"{scenario}_rad_s"] = Column(values, SPEED_ERROR, scenario)
        tables[f"speed-{count}"] = Table(title="Error of the speed", columns=columns, note="Rms over all runs.")
    return tables


def _least_table(found: Comparison) -> Table:
    """The causal estimators with the least speed error in each scenario, and those that come within 5 % of it."""
    causal = [name for name, entered in found.estimators.items() if entered.causal]
    least = []
    for scenario in found.scenarios_run:
        errors = {name: found.scores[scenario, name][SPEED].value for name in causal}
        limit = TIE * max(min(errors.values(), default=0.0), TINY)
        least.append(", ".join(name for name, error in errors.items() if error <= limit))
    columns = {
        "scenario": Column(np.array(list(found.scenarios_run)), None, "scenario"),
        "least": Column(np.array(least), None, "least error of the speed"),
    }
    note = "Of those that work as the samples come, with what comes within 5 % of it."
    return Table(title="Least error of the speed", columns=columns, note=note)


def _trace_table(traced: Traced) -> Table:
    columns = {
        "time_s": Column(traced.time, DURATION, "time", "t"),
        "true_speed_rad_s": Column(traced.speed, SPEED_ERROR, "speed"),
    }
    columns |= {f"{name}_speed_rad_s": Column(each, SPEED_ERROR, "speed") for name, each in traced.estimated.items()}
    return Table(title="Traces", columns=columns, is_data=True)


def scenario_tables(found: Comparison, result: Result) -> dict[str, Table]:
    """The scores of each scenario that was run, in a table of its own, as a screen has room for."""
    table = result.tables["comparison"]
    keys = ("estimator", "speed_error_rms_rad_s", "speed_error_95_rad_s", "speed_coverage", "angle_error_rms_rad",
            "angle_error_95_rad", "angle_coverage", "lost_sectors", "nis")  # fmt: skip
    tables = {}
    for name, played in found.scenarios_run.items():
        here = table["scenario"] == name
        chosen = (*keys, "settling_median_s", "delay_s") if played.is_step else keys
        columns = {key: Column(column.values[here], column.kind, column.label, column.symbol)
                   for key, column in table.columns.items()}  # fmt: skip
        tables[name] = Table(title=f"{name}: {played.title}", columns=columns, shown=chosen)
    return tables
