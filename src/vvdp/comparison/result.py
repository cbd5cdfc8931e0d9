"""The result of a comparison of estimators: scores, cost and robustness, traces, charts."""

from collections.abc import Mapping

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
from vvdp.comparison.charts import SMALLEST, comparison_charts
from vvdp.comparison.results import Comparison, Traced
from vvdp.comparison.score_tables import (
    SCORES,
    ErrorFigure,
    Figures,
    error_tables,
    least_table,
    run_conditions,
    run_findings,
    run_numbers,
    scenario_tables,
    score_table,
)
from vvdp.results.result import Column, Number, Result, Section, Table

ERROR = ErrorFigure("speed_error_rms_rad_s", "Error of the speed", SMALLEST, 1e-6)
MANNER = (
    "A wheel of bright and dark sectors turns past a photodiode. Every scenario is run many times, each time with "
    "another phase of the clock, another position of the wheel and other noise; in each run all estimators get the "
    "same edges."
)
DEFINITIONS = (
    "Errors are estimate minus truth, from 0.5 s on. Mean 95 %: exceeded in 5 % of a run, mean over the runs, "
    "so it may "
    "lie below the rms, which is taken over all runs; worst: of all runs; mean: the bias. The angle counts modulo a "
    "turn, relative to the unknown index. Settling: from the step on until the speed stays within 5 % of the step of "
    "its final value, median over the runs; a dash where it does not. Delay: the shift of the true speed that comes "
    "closest to the estimate. Lost: sectors gained or lost in a run, on average. NIS: mean normalised innovation "
    "squared, 1 where the stated uncertainty is right. Within 2 σ: share of errors within two stated standard "
    "deviations, 95 % "
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
    "speed_error_rms_rad_s", "speed_error_95_rad_s", "speed_error_worst_rad_s",
    "speed_error_mean_rad_s", "speed_coverage", "angle_error_rms_rad", "angle_error_95_rad", "angle_error_worst_rad",
    "angle_coverage", "lost_sectors", "nis", "settling_median_s", "delay_s",
)  # fmt: skip


def figures_of(found: Comparison) -> Figures:
    """The figures of the estimators; those of a step only where there is one."""
    return Figures("estimator", FIGURES, SHOWN if found.first_step else SHOWN[:-2])


def comparison_result(found: Comparison) -> Result:
    """The result of a comparison: scores of each pair, cost and robustness of each estimator, traces, charts."""
    figures = figures_of(found)
    scores = score_table(found, figures)
    speeds = error_tables(found, figures, ERROR, "speed")
    causal = [name for name in found.contenders if name in found.causal]
    note = "Of those that work as the samples come, with what comes within 5 % of it."
    traces = {"traces": _trace_table(found.traced)} if found.traced else {}
    charts = {chart.name: chart for chart in comparison_charts(found, figures, scores)}
    return Result(
        verb="compare estimators",
        title="Estimators of angle and speed on a coarse encoder",
        system="",
        manner=MANNER,
        conditions={
            "wheel": f"{found.sectors} sectors",
            "sample rate": f"{number(found.rate)} Hz",
            **run_conditions(found),
        },
        numbers={
            "sectors": Number(float(found.sectors), COUNT, "sectors of the wheel"),
            "rate_Hz": Number(found.rate, FREQUENCY, "sample rate"),
            **run_numbers(found),
        },
        tables={
            SCORES: scores,
            "estimators": _estimator_table(found),
            **speeds,
            "least": least_table(found, ERROR, causal, note),
            **traces,
        },
        charts=charts,
        findings=tuple(run_findings(found, "estimators on the same readings")),
        sections=(
            Section(title="Error of the speed", words=(MANNER,), shows=("conditions", *speeds, "least", *charts)),
            Section(title="Scenario by scenario", words=(DEFINITIONS,), shows=(SCORES,), starts_page=True),
            Section(title="Cost and robustness", shows=("estimators",)),
        ),
        seconds=found.seconds,
        finished=found.finished,
    )


def _estimator_table(found: Comparison) -> Table:
    """Description and cost of each estimator, and in which scenarios it loses count in one run or more."""
    names = list(found.contenders)
    values, errors = np.array([found.costs[name] for name in names]).T
    lost = [
        ", ".join(
            scenario for scenario in found.scenarios_run if found.scores[scenario, name]["lost_sectors"].value > 0.0
        )
        for name in names
    ]
    columns = {
        "name": Column(np.array(names), None, "estimator"),
        "title": Column(np.array([found.contenders[name] for name in names]), None, "what it is"),
        "causal": Column(np.array([float(name in found.causal) for name in names]), FLAG, "causal"),
        "cost_s": Column(values, SAMPLE_COST, "time of a sample"),
        "cost_se_s": Column(errors, SAMPLE_COST, "time of a sample, standard error"),
        "relative_cost": Column(values / values[0], NUMBER, "relative"),
        "lost_in": Column(np.array([each or "none" for each in lost]), None, "sectors lost in"),
    }
    shown = ("name", "title", "cost_s", "relative_cost", "lost_in")
    return Table(title="Cost and robustness", columns=columns, shown=shown)


def _trace_table(traced: Traced) -> Table:
    columns = {
        "time_s": Column(traced.time, DURATION, "time", "t"),
        "true_speed_rad_s": Column(traced.speed, SPEED_ERROR, "speed"),
    }
    columns |= {f"{name}_speed_rad_s": Column(each, SPEED_ERROR, "speed") for name, each in traced.estimated.items()}
    return Table(title="Traces", columns=columns, is_data=True)


def screen_tables(found: Comparison, result: Result) -> dict[str, Table]:
    """The scores of each scenario that was run, in a table of its own, as a screen has room for."""
    keys = ("estimator", "speed_error_rms_rad_s", "speed_error_95_rad_s", "speed_coverage", "angle_error_rms_rad",
            "angle_error_95_rad", "angle_coverage", "lost_sectors", "nis")  # fmt: skip
    chosen = {
        name: (*keys, "settling_median_s", "delay_s") if name in found.steps else keys for name in found.scenarios
    }
    return scenario_tables(found, result.tables[SCORES], chosen)
