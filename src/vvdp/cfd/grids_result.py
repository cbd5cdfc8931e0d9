"""Results of three grids of one family for the flow through a part of the valve, and their errors."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from vvdp.base.display import number, percent, with_unit
from vvdp.base.kinds import (
    AREA,
    COUNT,
    DENSITY,
    DURATION,
    EFFICIENCY,
    FLAG,
    LENGTH,
    NUMBER,
    PRESSURE_DIFFERENCE,
    SIGNED_PRESSURE,
    TORQUE,
)
from vvdp.cfd.centre_result import LENGTHS as CENTRE_LENGTHS
from vvdp.cfd.centre_result import centre_lengths
from vvdp.cfd.centre_study import CentreRun
from vvdp.cfd.rail import RailOrder
from vvdp.cfd.rail_result import (
    LENGTHS,
    MANNER,
    METHOD,
    Told,
    drop_columns,
    rail_lengths,
)
from vvdp.cfd.rail_study import RailRun
from vvdp.cfd.refinement import grid_convergence
from vvdp.cfd.solve import Solved
from vvdp.cfd.state_table import QUALITY, approach, quality_listings, restless_findings, state_columns
from vvdp.cfd.turbine_result import LENGTHS as TURBINE_LENGTHS
from vvdp.cfd.turbine_result import turbine_lengths
from vvdp.cfd.turbine_study import TurbineRun
from vvdp.geometry.shape import perpendicular_area
from vvdp.results.chart import Chart, Colour, Line, Lines, Stroke
from vvdp.results.result import Column, Finding, Grade, Listing, Result, Section, Table, listing_of, numbers_of

VERB = "cfd grids"
INDEX = (
    "Order, extrapolation and convergence index by the usual procedure for three grids. For the last two an order "
    "above 2, that of the schemes, counts as 2; values that drift apart have no order, and the index of the first. "
    "Where a value does not move one way they mean little; then the spread is the better measure."
)
LARGE_INDEX = 0.05
DROPS = {
    "pressure_drop_finest_Pa": (PRESSURE_DIFFERENCE, "pressure drop, finest grid"),
    "pressure_drop_extrapolated_Pa": (PRESSURE_DIFFERENCE, "pressure drop, extrapolated to cells of no size"),
    "grid_convergence_index": (EFFICIENCY, "grid convergence index of the finest grid"),
    "observed_order": (NUMBER, "observed order"),
    "is_monotone": (FLAG, "whether the drop moves one way"),
    "spread": (EFFICIENCY, "spread of the drop over all grids"),
    "density_kg_m3": (DENSITY, "density"),
}
TORQUES = {
    "torque_finest_N_m": (TORQUE, "torque, finest grid"),
    "torque_extrapolated_N_m": (TORQUE, "torque, extrapolated to cells of no size"),
    "torque_convergence_index": (EFFICIENCY, "grid convergence index of the torque"),
    "torque_observed_order": (NUMBER, "observed order of the torque"),
    "torque_spread": (EFFICIENCY, "spread of the torque over all grids"),
}


class OnGrids(NamedTuple):
    """A part of the valve on several grids, the coarsest first.

    columns  of a table with a row for each grid: `pressure_drop_Pa`, and others
    lines    of them that are drawn beside the drop, and what they are
    """

    title: str
    manner: str
    solved: Sequence[Solved]
    columns: Mapping[str, Column]
    lines: tuple[tuple[str, ...], str]
    lengths: tuple[str, Listing]


def rail_on_grids(runs: Sequence[RailRun], about: Told) -> OnGrids:
    """The inlet rail on several grids."""
    nozzles = range(1, len(runs[0].mouths) + 1)
    columns = {
        **drop_columns(runs),
        "mesh_area_m2": Column(np.array([sum(run.mesh_areas) for run in runs]), AREA, "openings in the mesh"),
    }
    return OnGrids(
        title="The inlet rail",
        manner=MANNER,
        solved=[run.solved for run in runs],
        columns=columns,
        lines=(tuple(f"split_{place}" for place in nozzles), "share of the flow"),
        lengths=(LENGTHS, rail_lengths(about)),
    )


def centre_on_grids(runs: Sequence[CentreRun], about: Told) -> OnGrids:
    """The centre section on several grids, judged by the total drop."""
    total = np.array([run.solved.judgement.value for run in runs])
    jets = np.array([run.order.flow / perpendicular_area(run.order.shape, run.order.valve) for run in runs])
    static = total - 0.5 * runs[0].order.fluid.density * jets**2
    columns = {
        "pressure_drop_Pa": Column(total, SIGNED_PRESSURE, "total drop"),
        "static_drop_Pa": Column(static, SIGNED_PRESSURE, "static drop"),
        "torque_N_m": Column(np.array([run.torque for run in runs]), TORQUE, "torque"),
        "mesh_area_m2": Column(np.array([run.stub_area for run in runs]), AREA, "stubs' ends in the mesh"),
    }
    return OnGrids(
        title="The centre section",
        manner=METHOD,
        solved=[run.solved for run in runs],
        columns=columns,
        lines=(("torque_N_m",), "torque"),
        lengths=(CENTRE_LENGTHS, centre_lengths(about)),
    )


def turbine_on_grids(runs: Sequence[TurbineRun], about: Told) -> OnGrids:
    """The outlet turbine on several grids, judged by the drop as far as the collector."""
    behind = np.array([run.behind for run in runs])
    total = np.array([run.solved.judgement.value for run in runs])
    columns = {
        "pressure_drop_Pa": Column(total - behind, PRESSURE_DIFFERENCE, "drop of the turbine"),
        "collector_drop_Pa": Column(behind, PRESSURE_DIFFERENCE, "drop of the collector"),
        "torque_N_m": Column(np.array([run.torques.forces for run in runs]), TORQUE, "torque"),
        "torque_momentum_N_m": Column(
            np.array([run.torques.momentum for run in runs]), TORQUE, "torque by angular momentum"
        ),
    }
    return OnGrids(
        title="The outlet turbine",
        manner=METHOD,
        solved=[run.solved for run in runs],
        columns=columns,
        lines=(("torque_N_m",), "torque"),
        lengths=(TURBINE_LENGTHS, turbine_lengths(about)),
    )


def grids_result(order: RailOrder, part: OnGrids, told: Sequence[str], about: Told) -> Result:
    """The result of a part of the valve of `order` on three grids, `told` their names, the coarsest first.

    Sections name drawings that the page has.
    """
    table = _grids(order, part, told)
    numbers = {**_drop_numbers(table), "density_kg_m3": order.fluid.density}
    quantities = DROPS
    if "torque_N_m" in table.columns:
        numbers, quantities = {**numbers, **_torque_numbers(table)}, {**DROPS, **TORQUES}
    words, lengths = part.lengths
    return Result(
        verb=VERB,
        title=f"{part.title} on three grids",
        system=about.system,
        manner=part.manner,
        references=("celik2008", "wang2017"),
        conditions={"oil": about.oil, "grids": ", ".join(told), **approach(order)},
        left_out=("Cavitation, and the warming of the oil.",),
        numbers=numbers_of(numbers, quantities),
        listings={
            "convergence": listing_of(numbers, quantities),
            "lengths": lengths,
            **quality_listings(told, part.solved),
        },
        tables={"grids": table},
        charts={"drop-over-cells": _chart(*part.lines)},
        findings=tuple(_findings(numbers, part.solved)),
        sections=(
            Section(title="Convergence", words=(INDEX,), shows=("convergence", "drop-over-cells", "grids")),
            Section(title=part.title, words=(words,), shows=("geometry", "lengths"), starts_page=True),
            Section(title="The flow on the coarsest grid", shows=("sections", "streamlines"), starts_page=True),
            QUALITY,
            Section(title="How it was done", words=(part.manner,), shows=("conditions",)),
        ),
        seconds=float(table["time_s"].sum()),
    )


def _drop_numbers(table: Table) -> dict[str, float]:
    found = grid_convergence(tuple(table["cell_size_m"][::-1]), tuple(table["pressure_drop_Pa"][::-1]))
    return {
        "pressure_drop_finest_Pa": float(table["pressure_drop_Pa"][-1]),
        "pressure_drop_extrapolated_Pa": found.extrapolated,
        "grid_convergence_index": found.band,
        "observed_order": found.order,
        "is_monotone": float(found.is_monotone),
        "spread": found.spread,
    }


def _torque_numbers(table: Table) -> dict[str, float]:
    found = grid_convergence(tuple(table["cell_size_m"][::-1]), tuple(table["torque_N_m"][::-1]))
    return {
        "torque_finest_N_m": float(table["torque_N_m"][-1]),
        "torque_extrapolated_N_m": found.extrapolated,
        "torque_convergence_index": found.band,
        "torque_observed_order": found.order,
        "torque_spread": found.spread,
    }


def _grids(order: RailOrder, part: OnGrids, told: Sequence[str]) -> Table:
    """A row for each grid; the size of its cells is the cube root of their mean volume, up to a common factor."""
    cells = np.array([float(run.mesh.cells) for run in part.solved])
    seconds = np.array([sum(run.seconds.values()) for run in part.solved])
    columns = {
        "grid": Column(np.array(told, str), None, "grid"),
        "cells": Column(cells, COUNT, "cells"),
        "cell_size_m": Column(order.valve.spool_radius / np.cbrt(cells), LENGTH, "cell size"),
        **part.columns,
        **state_columns(part.solved),
        "time_s": Column(seconds, DURATION, "time"),
    }
    note = "The cell size is the spool radius over the cube root of the number of cells."
    return Table(title="Grids", columns=columns, note=note)


def _chart(keys: tuple[str, ...], label: str) -> Chart:
    drop = Line(x="cell_size_m", y="pressure_drop_Pa", stroke=Stroke.MARKED, colour=Colour.LOAD)
    lines = tuple(Line(x="cell_size_m", y=key, stroke=Stroke.MARKED) for key in keys)
    return Chart(
        name="drop-over-cells",
        caption=f"Pressure drop and {label} over the size of the cells; the finest grid is on the left.",
        table="grids",
        panels=(
            Lines(lines=(drop,), label="pressure drop", left=0.0),
            Lines(lines=lines, label=label, left=0.0),
        ),
        side_by_side=True,
    )


def _findings(numbers: dict[str, float], solved: Sequence[Solved]) -> Iterator[Finding]:
    drop, index = with_unit(numbers["pressure_drop_finest_Pa"], PRESSURE_DIFFERENCE), numbers["grid_convergence_index"]
    order = numbers["observed_order"]
    observed = "no observed order" if math.isnan(order) else f"an observed order of {number(order, 3)}"
    yield Finding(
        text=f"On the finest grid the drop is {drop}, with a convergence index of {percent(index)} and {observed}."
    )
    if not numbers["is_monotone"] or not index < LARGE_INDEX:
        yield Finding(
            title="Not converged over the grids",
            grade=Grade.WARNING,
            text=f"The drop spreads by {percent(numbers['spread'])} over the grids"
            + (" without moving one way." if not numbers["is_monotone"] else "."),
            remedy="Take the larger of spread and index for its error.",
        )
    if "torque_spread" in numbers:
        torque, spread = with_unit(numbers["torque_finest_N_m"], TORQUE), percent(numbers["torque_spread"])
        yield Finding(text=f"The torque on the finest grid is {torque}; it spreads by {spread} over the grids.")
    yield from restless_findings(solved)
