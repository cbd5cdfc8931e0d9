"""The tables and figures that results of all comparisons share: scores by scenario and contender."""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import COUNT, Kind
from vvdp.comparison.contest import Contest
from vvdp.comparison.figures import error_key
from vvdp.results.chart import Chart, Dots
from vvdp.results.result import Column, Finding, Grade, Number, Table

SCORES = "comparison"
"""Name of the table of all scores."""
MOST_COLUMNS = 6
"""Scenarios beside each other in a table of a page."""
COLUMNS = 4
"""Panels beside each other in the figures of errors."""
TIE = 1.05
"""Errors that differ by a factor of less count as the same."""


class Figures(NamedTuple):
    """What is compared, such as "estimator"; kind and label of each figure of a score, and which a page shows."""

    contender: str
    kinds: Mapping[str, tuple[Kind, str]]
    shown: tuple[str, ...]


class ErrorFigure(NamedTuple):
    """A figure drawn and tabulated for all scenarios: its key, what it is, where the logarithmic scale begins, and what
    is the rounding of the arithmetic [SI]."""

    key: str
    title: str
    least: float
    tiny: float


def score_table(found: Contest, figures: Figures) -> Table:
    """A row for every scenario and contender; the standard error of a figure in a column with `se`."""
    pairs = list(found.scores)
    columns = {
        "scenario": Column(np.array([scenario for scenario, _ in pairs]), None, "scenario"),
        figures.contender: Column(np.array([contender for _, contender in pairs]), None, figures.contender),
        "runs": Column(np.array([float(found.scenarios[scenario].runs) for scenario, _ in pairs]), COUNT, "runs"),
    }
    for key, (kind, label) in figures.kinds.items():
        values, errors = np.array([found.scores[pair][key] for pair in pairs]).T
        columns[key] = Column(values, kind, label)
        columns[error_key(key)] = Column(errors, kind, f"{label}, standard error")
    shown = ("scenario", figures.contender, *figures.shown)
    return Table(title="Scenario by scenario", columns=columns, shown=shown)


def scenario_tables(found: Contest, scores: Table, keys: Mapping[str, Sequence[str]]) -> dict[str, Table]:
    """The scores of each scenario that was run, in a table of its own, as a screen has room for.

    keys  of the columns of each scenario
    """
    tables = {}
    for name, played in found.scenarios_run.items():
        here = scores["scenario"] == name
        columns = {
            key: Column(column.values[here], column.kind, column.label, column.symbol)
            for key, column in scores.columns.items()
        }
        tables[name] = Table(title=f"{name}: {played.title}", columns=columns, shown=tuple(keys[name]))
    return tables


def error_tables(found: Contest, figures: Figures, error: ErrorFigure, stem: str) -> dict[str, Table]:
    """A figure of each contender by scenario, as many scenarios in a table as a page has room for."""
    names, played = list(found.contenders), list(found.scenarios_run)
    kind, tables = figures.kinds[error.key][0], {}
    unit = kind.unit.replace("/", "_")
    for count, first in enumerate(range(0, len(played), MOST_COLUMNS), 1):
        columns = {figures.contender: Column(np.array(names), None, figures.contender)}
        for scenario in played[first : first + MOST_COLUMNS]:
            values = np.array([found.scores[scenario, name][error.key].value for name in names])
            columns[f"{scenario}_{unit}"] = Column(values, kind, scenario)
        tables[f"{stem}-{count}"] = Table(title=error.title, columns=columns, note="Rms over all runs.")
    return tables


def least_table(found: Contest, error: ErrorFigure, among: Sequence[str], note: str) -> Table:
    """The contenders, `among` those named, with the least of an error in each scenario, and those within 5 % of it."""
    least = []
    for scenario in found.scenarios_run:
        errors = {name: found.scores[scenario, name][error.key].value for name in among}
        limit = TIE * max(np.nanmin([np.inf, *errors.values()]), error.tiny)
        least.append(", ".join(name for name, each in errors.items() if each <= limit))
    title = f"Least {error.title[0].lower()}{error.title[1:]}"
    columns = {
        "scenario": Column(np.array(list(found.scenarios_run)), None, "scenario"),
        "least": Column(np.array(least), None, title.lower()),
    }
    return Table(title=title, columns=columns, note=note)


def error_chart(found: Contest, table: Table, figures: Figures, error: ErrorFigure, words: tuple[str, str]) -> Chart:
    """A panel for each scenario: a dot for each contender, and a bar where 90 % of the runs lie.

    words  name and caption of the chart
    """
    stem, rms, unit = error.key.partition("_rms")
    panels = tuple(
        Dots(
            names=figures.contender,
            value=error.key,
            low=f"{stem}{rms}_low{unit}",
            high=f"{stem}{rms}_high{unit}",
            least=error.least,
            title=name,
            rows=scenario_rows(table, name),
        )
        for name in found.scenarios_run
    )
    height = 0.55 + -(-len(panels) // COLUMNS) * (0.42 + 0.145 * len(found.contenders))
    return Chart(
        name=words[0], caption=words[1], table=SCORES, panels=panels, columns=COLUMNS, share=True, height=height
    )


def scenario_rows(table: Table, scenario: str) -> tuple[int, ...]:
    """The rows of a scenario."""
    return tuple(np.flatnonzero(table["scenario"] == scenario).tolist())


def run_numbers(found: Contest) -> dict[str, Number]:
    """How many runs were asked for and made."""
    return {
        "seeds": Number(float(found.seeds), COUNT, "runs of each scenario that were asked for"),
        "runs": Number(float(found.runs), COUNT, "runs that were made"),
    }


def run_conditions(found: Contest) -> dict[str, str]:
    """Each scenario with its runs."""
    return {name: f"{played.title}, {played.runs} runs" for name, played in found.scenarios.items()}


def run_findings(found: Contest, together: str) -> Iterator[Finding]:
    """Whether all runs were made, and how many; `together` says of whom, in what they are equal."""
    if not found.finished:
        yield Finding(
            text=f"{found.runs} of {found.seeds * len(found.scenarios)} runs were made.",
            grade=Grade.WARNING,
            title="Not all runs were made",
        )
    yield Finding(text=f"{found.runs} runs of {len(found.contenders)} {together}.")
