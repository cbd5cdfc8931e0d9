"""A slider over one value of a system, for notebooks: whole runs, made before, whose curves follow."""

import sys
from dataclasses import dataclass, field
from html import escape

import numpy as np

from vvdp.api.run import Run, chart_on_view
from vvdp.api.system import System
from vvdp.base.arrays import Array
from vvdp.base.display import with_unit
from vvdp.base.errors import ConfigError, Fault, RunError, VvdpError
from vvdp.base.kinds import Kind
from vvdp.base.tables import Sourced, suggestion
from vvdp.base.units import parse
from vvdp.report.notebook import Step, live_frame
from vvdp.workbench.work import slider_ends


@dataclass(frozen=True, eq=False)
class Slider:
    """Runs of a system at several values of one parameter; `left_out` are the values that it refuses, with reasons."""

    key: str
    kind: Kind = field(repr=False)
    values: tuple[float, ...]
    runs: tuple[Run, ...] = field(repr=False)
    left_out: tuple[str, ...] = ()

    def _repr_html_(self) -> str:
        steps = [
            Step(with_unit(value, self.kind), chart, run.result.tables)
            for value, run in zip(self.values, self.runs, strict=True)
            if (chart := chart_on_view(run)) is not None
        ]
        missing = f"<p>Left out: {escape('; '.join(self.left_out))}.</p>" if self.left_out else ""
        return live_frame(steps, self.key) + missing


def slider(
    system: System,
    key: str,
    low: str | float | None = None,
    high: str | float | None = None,
    *,
    count: int = 9,
    until: str | float | None = None,
) -> Slider:
    """A slider over the value `key`, in a notebook: the curves of `count` whole runs, evenly from `low` to `high`.

    >>> vvdp.slider(system, "operation.duty_ratio", "0.2", "0.8")

    Without ends it covers the range that the file gives, or a tenth to ten times the value. `until` is as of
    `System.run`. The count of runs is shown on stderr. Values that the system refuses are left out. Raises ConfigError
    for an unknown key or a value that is no number, and where no run is possible.
    """
    row = next((each for each in system.rows if each.setting == key), None)
    if row is None:
        raise _fault(system, key, f"unknown{suggestion(key, [each.setting for each in system.rows])}")
    if (usual := slider_ends(row)) is None:
        raise _fault(system, key, "is no number that a slider could move")
    if count < 1:
        raise _fault(system, key, f"count {count}: must be at least 1")
    first, last = (
        end if given is None else parse(given, row.kind) if isinstance(given, str) else float(given)
        for given, end in zip((low, high), usual, strict=True)
    )
    return _runs(system, row, np.linspace(first, last, count), until)


def _runs(system: System, row: Sourced, places: Array, until: str | float | None) -> Slider:
    """The runs at all places that the system accepts. Raises ConfigError where it accepts none."""
    values, runs, left_out = list[float](), list[Run](), list[str]()
    for done, value in enumerate(map(float, places), 1):
        print(f"\rrun {done} of {len(places)}", end="\n" if done == len(places) else "", file=sys.stderr, flush=True)
        words = with_unit(value, row.kind)
        try:
            run = system.with_values(**{row.table: {row.key: value}}).run(until)
            if chart_on_view(run) is None:
                raise RunError("the run is too short for a chart")
        except VvdpError as problem:
            left_out.append(f"{words} ({problem})")
            continue
        values.append(value)
        runs.append(run)
    if not runs:
        raise _fault(system, row.setting, f"no value can be run: {'; '.join(left_out)}")
    return Slider(row.setting, row.kind, tuple(values), tuple(runs), tuple(left_out))


def _fault(system: System, key: str, message: str) -> ConfigError:
    return ConfigError([Fault(system.name, 0, key, message)])
