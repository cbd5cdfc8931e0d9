"""The cylinder of chapter 6, in its own model and in the whole machine: runs that several items share."""

from dataclasses import replace
from functools import cache

import numpy as np

import vvdp
from vvdp.api.run import Run
from vvdp.base.arrays import Array
from vvdp.control.displacement import DisplacementSettings
from vvdp.reproduction.item import Reproduction
from vvdp.results.result import Table
from vvdp.results.verdict import Statement

MODEL, MACHINE = "displacement-chapter6", "displacement-control"
PERIOD = 1e-3
"""Of the control [s]."""


@cache
def model_run() -> Run:
    """The nominal case: two strokes out and back, pump as a lagging source."""
    return vvdp.load(MODEL).run()


@cache
def printed_run() -> Run:
    """The same with the law as printed: sign(U*), no expected flow, the opening from the flow that is asked for."""
    printed = {"direction": {"hysteresis": 0.0}, "flow_split": {"expected_flow": 0.0, "uses_delivered_flow": 0.0}}
    return vvdp.load(MODEL, **printed).run()


@cache
def machine_run() -> Run:
    """The whole machine with the spinning valve through the same stroke."""
    return vvdp.load(MACHINE).run()


@cache
def nominal_settings() -> DisplacementSettings:
    """Settings of the controller of the model."""
    found = vvdp.load(MODEL).circuit.network.programs["control"].settings
    assert isinstance(found, DisplacementSettings)
    return found


def at_samples(run: Run, column: str, begin: float = 1.0) -> Array:
    """A series of a run at every sample of the control from `begin` [s] on."""
    series = run.to_pandas()[column]
    times = np.arange(begin, run.times[-1], PERIOD)
    found: Array = np.interp(times, series.index.to_numpy(), series.to_numpy())
    return found


def as_drawn(run: Run, chart: str, statements: tuple[Statement, ...], name: str) -> Reproduction:
    """A chart of a run under another name, with the table that it draws."""
    shown = run.result.charts[chart]
    table: Table = run.result.tables[shown.table]
    return Reproduction(statements=statements, tables={shown.table: table}, charts=(replace(shown, name=name),))
