"""Results of a study: a row for every case, ranges, and its results over what was varied."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vvdp.base.display import key_suffix, plain, with_unit
from vvdp.base.kinds import COUNT, Kind
from vvdp.results.chart import Chart, Field, Line, Lines, Stroke
from vvdp.results.result import Column, Finding, Grade, Listing, Number, Result, Row, Table
from vvdp.studies.study import Study
from vvdp.systems.system import System

FEWEST = 3
"""Values of either axis from which on a result is drawn as a field; with fewer it is drawn as lines."""
MOST_TOLD = 10
"""Failed cases that are reported one by one."""


@dataclass(frozen=True)
class Failure:
    """A case that could not be carried to its end."""

    case: int
    settings: Mapping[str, object]
    reason: str


@dataclass(frozen=True)
class Doubt:
    """Warning on some cases: its text, in the words of the first of them, and the numbers of these cases."""

    text: str
    cases: tuple[int, ...]


@dataclass(frozen=True, kw_only=True)
class StudyResults:
    """Inputs (by `table.key`) and outputs of all cases of a study, in SI, in its order; nan where a case has none.

    An input is text where it is no number in some case. `missing` are the cases still to be run after an interruption;
    `doubts` are of the cases that are not trusted, have not settled or lack an efficiency; `ran` says how many were run
    this time.
    """

    study: Study
    system: System
    directory: Path
    inputs: Mapping[str, Column]
    outputs: Mapping[str, Column]
    failures: tuple[Failure, ...]
    missing: tuple[int, ...]
    ran: int = 0
    seconds: float = 0.0
    doubts: tuple[Doubt, ...] = ()

    @property
    def is_finished(self) -> bool:
        """Whether every case has been run."""
        return not self.missing


def study_result(results: StudyResults) -> Result:
    """The result of a study: table of all cases, range of each column, charts where one or two values are varied."""
    table = study_table(results)
    charts = {chart.name: chart for chart in _charts(results, table)}
    failed = len(results.failures)
    count = table.rows
    numbers = {"cases": (count, "cases"), "failed_cases": (failed, "cases that failed")}
    numbers["missing_cases"] = (len(results.missing), "cases that were not run yet")
    columns = (*results.inputs.items(), *results.outputs.items())
    return Result(
        verb="study",
        title=results.study.title or f"Study of {count} cases",
        system=results.system.name,
        numbers={key: Number(float(value), COUNT, label) for key, (value, label) in numbers.items()},
        listings={"ranges": Listing(title="Ranges", heads=RANGE, rows=tuple(_range(*each) for each in columns))},
        tables={"study": table},
        charts=charts,
        findings=tuple(_findings(results)),
        seconds=results.seconds,
        finished=results.is_finished,
    )


def study_table(results: StudyResults) -> Table:
    """A row for every case; the last column says why one failed, or that it was not run yet."""
    reasons = {failure.case: failure.reason for failure in results.failures}
    reasons |= dict.fromkeys(results.missing, "not run yet")
    count = len(next(iter(results.outputs.values())).values)
    columns = {"case": Column(np.arange(float(count)), COUNT, "case")}
    columns |= {_key(name, column.kind): column for name, column in results.inputs.items()}
    columns |= dict(results.outputs)
    columns["failure"] = Column(np.array([reasons.get(case, "") for case in range(count)]), None, "failure")
    given = results.study.variations
    axes = [name for name in given if results.inputs[name].kind] if isinstance(given, Mapping) else []
    shown = tuple(key for key in columns if key != "failure" or reasons)
    axes = [_key(name, results.inputs[name].kind) for name in axes]
    return Table(title="Cases", columns=columns, axes=tuple(axes), shown=shown)


def _key(name: str, kind: Kind | None) -> str:
    return name + (key_suffix(kind) if kind else "")


RANGE = ("lowest", "highest", "mean")


def _range(name: str, column: Column) -> Row:
    label = column.label or name
    if column.kind is None:
        return Row(label, None, (f"{len(np.unique(column.values))} different", "", ""))
    values = np.asarray(column.values, float)
    known = values[np.isfinite(values)]
    return Row(label, column.kind, tuple(float(f(known)) if known.size else None for f in (np.min, np.max, np.mean)))


def _findings(results: StudyResults) -> Iterator[Finding]:
    for failure in results.failures[:MOST_TOLD]:
        yield Finding(text=f"case {failure.case} failed: {failure.reason}", grade=Grade.WARNING)
    if (more := len(results.failures) - MOST_TOLD) > 0:
        words = "1 more case" if more == 1 else f"{more} more cases"
        yield Finding(text=f"{words} failed; the column failure says why.", grade=Grade.WARNING)
    for doubt in results.doubts:
        yield Finding(text=_doubt_words(doubt), grade=Grade.WARNING)


def _doubt_words(doubt: Doubt) -> str:
    """A warning with the cases that it is about."""
    cases = ", ".join(map(str, doubt.cases[:MOST_TOLD]))
    more = f" and {len(doubt.cases) - MOST_TOLD} more" if len(doubt.cases) > MOST_TOLD else ""
    return f"{'case' if len(doubt.cases) == 1 else 'cases'} {cases}{more}: {doubt.text}"


def _charts(results: StudyResults, table: Table) -> Iterator[Chart]:
    """A chart of each result over the one value that varies, or over the two."""
    varied = [name for name, column in results.inputs.items() if len(set(column.values.tolist())) > 1]
    if not 1 <= len(varied) <= 2 or any(results.inputs[name].kind is None for name in varied):
        return
    axes = sorted(
        (_key(name, results.inputs[name].kind) for name in varied), key=lambda key: -np.unique(table[key]).size
    )
    for key, column in results.outputs.items():
        values = np.asarray(column.values, float)
        if len(axes) == 1:
            yield _chart(key, table, axes, _lines(table, axes[0], key))
        elif _is_grid(table, axes) and np.unique(values[np.isfinite(values)]).size > 1:
            few = np.unique(table[axes[1]]).size < FEWEST
            panel = _family(table, axes, key) if few else Field(x=axes[0], y=axes[1], z=key)
            yield _chart(key, table, axes, panel)


def _chart(key: str, table: Table, axes: Sequence[str], panel: Lines | Field) -> Chart:
    over = " and ".join(table.columns[axis].label for axis in axes)
    caption = f"{table.columns[key].label[:1].upper()}{table.columns[key].label[1:]} over {over}."
    return Chart(name=f"over-{key}", caption=caption, table="study", panels=(panel,))


def _lines(table: Table, x: str, key: str) -> Lines:
    rows = tuple(np.argsort(table[x], kind="stable").tolist())
    return Lines(lines=(Line(x=x, y=key, rows=rows, stroke=Stroke.MARKED),))


def _family(table: Table, axes: Sequence[str], key: str) -> Lines:
    """A line for each value of the second axis."""
    x, other = axes
    kind = table.columns[other].kind
    order = np.argsort(table[x], kind="stable")
    lines = [
        Line(
            x=x,
            y=key,
            label=with_unit(float(value), kind) if kind else plain(float(value)),
            rows=tuple(order[table[other][order] == value].tolist()),
            stroke=Stroke.MARKED,
        )
        for value in np.unique(table[other])
    ]
    return Lines(lines=tuple(lines), legend=table.columns[other].label)


def _is_grid(table: Table, axes: Sequence[str]) -> bool:
    """Whether there is a case at every point of both axes."""
    points = set(zip(*(table[axis].tolist() for axis in axes), strict=True))
    return len(points) == np.prod([np.unique(table[axis]).size for axis in axes])
