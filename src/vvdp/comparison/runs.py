"""Runs side by side: parameters that differ, numbers with their differences, series over each other."""

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from vvdp.base.display import display_unit, key_suffix, number, plain, readable
from vvdp.base.errors import unusable
from vvdp.base.kinds import COUNT, FLAG, Kind
from vvdp.base.signal import Signal
from vvdp.base.tables import Sourced
from vvdp.evaluation.accuracy import OF_THE_RUN
from vvdp.results.chart import Chart, Line, Lines
from vvdp.results.result import Column, Finding, Grade, Listing, Result, Row, Section, Table
from vvdp.runs.run import RecordedRun, open_run
from vvdp.runs.tables import series_table

RUNS = "runs"
"""Name of the table of all runs."""
MOST_PANELS = 6
"""Panels of one figure."""
SAME_VALUE, SAME_NUMBER = 1e-12, 1e-6
"""Parameters and numbers that differ by less, over the first, count as equal."""
GROUPS = {
    "pressure": "Pressures",
    "flow": "Flows",
    "speed": "Speeds",
    "position": "Positions",
    "velocity": "Velocities",
    "command": "Commands of programs",
}
"""What the names of series begin with, and what a caption calls them."""


def compare_runs(directories: Sequence[Path], trust: str = "") -> Result:
    """The runs in two or more directories side by side; differences are to the first.

    `trust` is a module, by name or file, that may be run to draw a circuit. Raises ConfigError for fewer than two, and
    for a directory that holds no run, UntrustedModuleError where its circuit needs code that may not be run.
    """
    if len(directories) < 2:
        raise unusable("compare runs", f"{len(directories)} directory is given; expected two or more")
    runs = dict(zip(_names(directories), (open_run(each, trust) for each in directories), strict=True))
    parameters, numbers = list(_parameters(runs)), list(_numbers(runs))
    changed = [row for row, is_same in numbers if not is_same]
    series = {name: series_table(run) for name, run in runs.items()}
    charts = list(_charts(runs, series))
    words = f"{_count(len(parameters), 'parameter')} and {len(changed)} of {_count(len(numbers), 'number')} differ."
    return Result(
        verb="compare runs",
        title=f"Comparison of {len(runs)} runs",
        system=", ".join(dict.fromkeys(run.system.name for run in runs.values())),
        listings={
            "parameters": Listing(title="Parameters that differ", heads=tuple(runs), rows=tuple(parameters)),
            "numbers": Listing(
                title="Numbers that differ",
                heads=(*runs, *_difference_heads(runs)),
                rows=tuple(changed),
                note="Pressures are gauge. Differences are to the first run.",
            ),
        },
        tables={RUNS: _run_table(runs)} | dict(zip(_series_names(runs), series.values(), strict=True)),
        charts={chart.name: chart for chart in charts},
        findings=(*_warnings(runs), Finding(text=words)),
        sections=(
            Section(title="Parameters", shows=("parameters",)),
            Section(title="Numbers", shows=("numbers",)),
            Section(title="Course of the runs", shows=tuple(chart.name for chart in charts), starts_page=True),
        ),
    )


def _names(directories: Sequence[Path]) -> list[str]:
    """The last part of each path where that distinguishes them, else the whole path with a number for one given
    twice.
    """
    names = [readable(path.resolve().name) for path in directories]
    if len(set(names)) < len(names):
        names = [str(path) for path in directories]
    return [name if name not in names[:k] else f"{name} ({k + 1})" for k, name in enumerate(names)]


def _count(count: int, word: str) -> str:
    return f"{count} {word}{'' if count == 1 else 's'}"


def _difference_heads(runs: Mapping[str, RecordedRun]) -> tuple[str, ...]:
    others = list(runs)[1:]
    return ("difference",) if len(others) == 1 else tuple(f"{name}, difference" for name in others)


def _warnings(runs: Mapping[str, RecordedRun]) -> Iterator[Finding]:
    first, *others = runs
    if different := [name for name in others if runs[name].system.circuit.digest != runs[first].system.circuit.digest]:
        text = f"{' and '.join(different)} have another circuit than {first}." if len(different) > 1 else ""
        yield Finding(
            text=text or f"{different[0]} has another circuit than {first}.",
            grade=Grade.WARNING,
            title="The circuits differ",
            remedy="Only what has the same name in all is compared; it need not be the same thing.",
        )
    for name, run in runs.items():
        if not run.has("finished"):
            yield Finding(text=f"{name} was interrupted at {run.number('duration_s'):.4g} s.", grade=Grade.WARNING)
        if not run.summary.get("trusted", True):
            yield Finding(text=f"The balances of {name} do not close.", grade=Grade.WARNING)


def _rows(runs: Mapping[str, RecordedRun]) -> dict[str, list[Sourced | None]]:
    """The values of all systems by `table.key`, one for each run; None where a system has none."""
    found = [{f"{row.table}.{row.key}": row for row in run.system.rows} for run in runs.values()]
    keys = dict.fromkeys(key for each in found for key in each)
    return {key: [each.get(key) for each in found] for key in keys}


def _different(runs: Mapping[str, RecordedRun]) -> Iterator[tuple[str, list[Sourced | None]]]:
    for key, rows in _rows(runs).items():
        values = [_constant(row) for row in rows]
        numbers = [value for value in values if value is not None]
        same = {row and row.value for row in rows} if len(numbers) < len(rows) else ()
        if len(same) > 1 or (not same and not _are_same(numbers, SAME_VALUE)):
            yield key, rows


def _are_same(values: Sequence[float], limit: float) -> bool:
    first = values[0]
    return all(
        value == first or abs(value - first) <= limit * abs(first) or (math.isnan(value) and math.isnan(first))
        for value in values
    )


def _parameters(runs: Mapping[str, RecordedRun]) -> Iterator[Row]:
    for key, rows in _different(runs):
        kind = next(row.kind for row in rows if row)
        known = [value for row in rows if (value := _constant(row)) is not None]
        if len(known) < len(rows):
            yield Row(key, None, tuple(row.display_text if row else "" for row in rows))
        else:
            unit = display_unit(kind)
            cells = ["" if math.isnan(value) else plain(float(unit.from_si(value)), 8) for value in known]
            yield Row(key, kind, tuple(cells))


def _constant(row: Sourced | None) -> float | None:
    """A value [SI] that does not change over time, nan where a system has none; None for any other."""
    value = row.value if row else math.nan
    if isinstance(value, Signal):
        return value.base if value.is_constant else None
    return value if isinstance(value, float | int) else None


def _numbers(runs: Mapping[str, RecordedRun]) -> Iterator[tuple[Row, bool]]:
    """A row for each number of a summary, and whether it is the same in all runs."""
    for key, (kind, label, values) in _number_values(runs).items():
        if key in OF_THE_RUN:
            continue
        cells = [None if math.isnan(value) else value for value in values]
        differences = (_difference(value, values[0], kind) for value in values[1:])
        yield Row(label, kind, (*cells, *differences)), _are_same(values, SAME_NUMBER)


def _number_values(runs: Mapping[str, RecordedRun]) -> dict[str, tuple[Kind, str, list[float]]]:
    """Kind, label and values [SI] of all numbers, nan where a run has none."""
    known = {key: (n.kind, n.label) for run in runs.values() for key, n in run.numbers.items()}
    return {
        key: (*what, [run.numbers[key].value if key in run.numbers else math.nan for run in runs.values()])
        for key, what in known.items()
    }


def _difference(value: float, first: float, kind: Kind) -> str:
    """A difference in the unit in which the values are shown, with its sign."""
    if kind is FLAG or math.isnan(value - first):
        return ""
    unit = display_unit(kind)
    found = float(unit.from_si(value) - unit.from_si(first))
    if kind is COUNT:
        return plain(found)
    return ("+" if found > 0.0 else "") + number(found, 3)


def _run_table(runs: Mapping[str, RecordedRun]) -> Table:
    """A row for each run: parameters that differ, numbers, and differences to the first."""
    columns = {"run": Column(np.array(list(runs)), None, "run")}
    for key, rows in _different(runs):
        kind = next(row.kind for row in rows if row)
        values = [value for row in rows if (value := _constant(row)) is not None]
        if len(values) < len(rows):
            columns[key] = Column(np.array([row.display_text if row else "" for row in rows]), None, key)
        else:
            columns[key + key_suffix(kind)] = Column(np.array(values), kind, key)
    numbers = {key: each for key, each in _number_values(runs).items() if key != "finished"}
    columns |= {key: Column(np.array(values), kind, label) for key, (kind, label, values) in numbers.items()}
    for key, (kind, label, values) in numbers.items():
        if kind is not FLAG:
            columns[f"difference_{key}"] = Column(np.array(values) - values[0], kind, f"{label}, difference")
    return Table(title="Runs", columns=columns, is_data=True)


def _series_names(runs: Mapping[str, RecordedRun]) -> list[str]:
    """Names of the tables of series."""
    return [f"series-{number}" for number in range(1, len(runs) + 1)]


def _charts(runs: Mapping[str, RecordedRun], series: Mapping[str, Table]) -> Iterator[Chart]:
    first, *others = series.values()
    common = [key for key in first.columns if all(key in table.columns for table in others)]
    seen = next(iter(runs.values())).detail().rows
    if any(table.rows < 2 for table in series.values()):
        return
    left, right = (float(first["time_s"][seen[place]]) for place in (0, -1))
    for group, words in GROUPS.items():
        keys = [key for key in common if key.startswith(f"{group}_")]
        parts = [keys[place : place + MOST_PANELS] for place in range(0, len(keys), MOST_PANELS)]
        for count, part in enumerate(parts, 1):
            panels = tuple(_panel(key, first.columns[key].label, runs, left, right) for key in part)
            name = group if len(parts) == 1 else f"{group}-{count}"
            caption = f"{words} of the runs over time; seen are the last periods of the first."
            yield Chart(
                name=name, caption=caption, table=_series_names(runs)[0], panels=panels, height=0.8 + 1.3 * len(panels)
            )


def _panel(key: str, label: str, runs: Mapping[str, RecordedRun], left: float, right: float) -> Lines:
    names = zip(_series_names(runs), runs, strict=True)
    lines = tuple(Line(x="time_s", y=key, label=name, table=table) for table, name in names)
    return Lines(lines=lines, label=label, left=left, right=right)
