"""What three grids of one family say of the flow through an inlet rail: drop and shares, and how far they are off."""

from collections.abc import Iterator, Sequence

import numpy as np

from vvdp.base.display import number, percent, with_unit
from vvdp.base.kinds import AREA, COUNT, DENSITY, EFFICIENCY, FLAG, LENGTH, NUMBER, PRESSURE_DIFFERENCE
from vvdp.cfd.rail import RailOrder
from vvdp.cfd.rail_result import (
    LEFT_OUT,
    LENGTHS,
    MANNER,
    Told,
    drop_columns,
    rail_lengths,
    restless_findings,
    state_columns,
)
from vvdp.cfd.rail_study import RailRun
from vvdp.cfd.refinement import grid_convergence
from vvdp.results.chart import Chart, Colour, Line, Lines, Stroke
from vvdp.results.result import Column, Finding, Grade, Listing, Result, Row, Section, Table, numbers_of

VERB = "cfd grids"
INDEX = (
    "Order, extrapolation and convergence index by the usual procedure for three grids. Where the drop does not move "
    "one way they mean little; then the spread is the better measure."
)
LARGE_INDEX = 0.05
QUANTITIES = {
    "pressure_drop_finest_Pa": (PRESSURE_DIFFERENCE, "pressure drop, finest grid"),
    "pressure_drop_extrapolated_Pa": (PRESSURE_DIFFERENCE, "pressure drop, extrapolated to cells of no size"),
    "grid_convergence_index": (EFFICIENCY, "grid convergence index of the finest grid"),
    "observed_order": (NUMBER, "observed order"),
    "is_monotone": (FLAG, "whether the drop moves one way"),
    "spread": (EFFICIENCY, "spread of the drop over all grids"),
    "density_kg_m3": (DENSITY, "density"),
}


def grids_result(order: RailOrder, runs: Sequence[RailRun], told: Sequence[str], about: Told) -> Result:
    """The result of runs of one order on three grids, `told` their names, the coarsest first.

    Sections name drawings that the page has.
    """
    table = _grids(order, runs, told)
    found = grid_convergence(tuple(table["cell_size_m"][::-1]), tuple(table["pressure_drop_Pa"][::-1]))
    numbers = {
        "pressure_drop_finest_Pa": float(table["pressure_drop_Pa"][-1]),
        "pressure_drop_extrapolated_Pa": found.extrapolated,
        "grid_convergence_index": found.band,
        "observed_order": found.order,
        "is_monotone": float(found.is_monotone),
        "spread": found.spread,
        "density_kg_m3": order.fluid.density,
    }
    rows = tuple(Row(label, kind, (numbers[key],)) for key, (kind, label) in QUANTITIES.items())
    return Result(
        verb=VERB,
        title="The inlet rail on three grids",
        system=about.system,
        manner=MANNER,
        references=("celik2008", "wang2017"),
        conditions={"oil": about.oil, "grids": ", ".join(told), "turbulence": order.turbulence.model},
        left_out=LEFT_OUT,
        numbers=numbers_of(numbers, QUANTITIES),
        listings={"convergence": Listing(title="", heads=("value",), rows=rows), "lengths": rail_lengths(about)},
        tables={"grids": table},
        charts={"drop-over-cells": _chart(len(runs[0].mouths))},
        findings=tuple(_findings(numbers, runs)),
        sections=(
            Section(title="Convergence", words=(INDEX,), shows=("convergence", "drop-over-cells", "grids")),
            Section(title="The rail", words=(LENGTHS,), shows=("geometry", "lengths"), starts_page=True),
            Section(title="The flow on the coarsest grid", shows=("sections",), starts_page=True),
            Section(title="How it was done", words=(MANNER,), shows=("conditions",)),
        ),
        seconds=sum(run.seconds for run in runs),
    )


def _grids(order: RailOrder, runs: Sequence[RailRun], told: Sequence[str]) -> Table:
    """A row for each grid; the size of its cells is the cube root of their mean volume, up to a common factor."""
    cells = np.array([float(run.solved.mesh.cells) for run in runs])
    columns = {
        "grid": Column(np.array(told, str), None, "grid"),
        "cells": Column(cells, COUNT, "cells"),
        "cell_size_m": Column(order.valve.spool_radius / np.cbrt(cells), LENGTH, "cell size"),
        **drop_columns(runs),
        "mesh_area_m2": Column(np.array([sum(run.mesh_areas) for run in runs]), AREA, "openings in the mesh"),
        **state_columns(runs),
    }
    note = "The cell size is the spool radius over the cube root of the number of cells."
    return Table(title="Grids", columns=columns, note=note)


def _chart(nozzles: int) -> Chart:
    drop = Line(x="cell_size_m", y="pressure_drop_Pa", stroke=Stroke.MARKED, colour=Colour.LOAD)
    shares = tuple(Line(x="cell_size_m", y=f"split_{place + 1}", stroke=Stroke.MARKED) for place in range(nozzles))
    return Chart(
        name="drop-over-cells",
        caption="Pressure drop and shares of the nozzles over the size of the cells; the finest grid is on the left.",
        table="grids",
        panels=(
            Lines(lines=(drop,), label="pressure drop", left=0.0),
            Lines(lines=shares, label="share of the flow", left=0.0),
        ),
        side_by_side=True,
    )


def _findings(numbers: dict[str, float], runs: Sequence[RailRun]) -> Iterator[Finding]:
    drop, index = with_unit(numbers["pressure_drop_finest_Pa"], PRESSURE_DIFFERENCE), numbers["grid_convergence_index"]
    yield Finding(
        text=f"On the finest grid the drop is {drop}, with a convergence index of {percent(index)} and an observed "
        f"order of {number(numbers['observed_order'], 3)}."
    )
    if not numbers["is_monotone"] or not index < LARGE_INDEX:
        yield Finding(
            title="Not converged over the grids",
            grade=Grade.WARNING,
            text=f"The drop spreads by {percent(numbers['spread'])} over the grids"
            + (" without moving one way." if not numbers["is_monotone"] else "."),
            remedy="Take its spread for its error.",
        )
    yield from restless_findings(runs)
