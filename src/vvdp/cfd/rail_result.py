"""Flow through an inlet rail as a result: drop, split, areas, and how well it has settled."""

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from vvdp.base.display import percent, with_unit
from vvdp.base.kinds import (
    ANGLE,
    AREA,
    COUNT,
    DENSITY,
    DURATION,
    DYNAMIC_VISCOSITY,
    EFFICIENCY,
    FLAG,
    FLOW,
    NUMBER,
    PRESSURE_DIFFERENCE,
    SIGNED_PRESSURE,
)
from vvdp.base.tables import Sourced
from vvdp.cfd.convergence import LARGEST_IMBALANCE
from vvdp.cfd.rail import RailOrder, outlets
from vvdp.cfd.rail_study import RailRun
from vvdp.cfd.state_table import QUALITY, Ordered, approach, quality_listings, residual_findings
from vvdp.geometry.result import origin_rows
from vvdp.results.chart import Bars, Chart, Colour, Level, Line, Lines
from vvdp.results.result import Column, Finding, Grade, Listing, Result, Section, Table, listing_of, numbers_of
from vvdp.valve.branch import turbulent_drops

VERB = "cfd rail"
METHOD = (
    "Steady flow of constant density and viscosity, computed by OpenFOAM (simpleFoam) on hexahedra: Reynolds-averaged "
    "equations with a model of turbulence, upwind schemes to begin with, then limited schemes of second order, or "
    "upwind schemes to the end where first order is chosen. A run "
    "has settled where means of the drop over 50 iterations no longer change by 0.1 %, and what leaves is within 0.1 % "
    "of what enters."
)
MANNER = (
    f"{METHOD} The oil enters by the port and leaves by the nozzles into the open bore. The drop is the mean static "
    "pressure at the port less that in the bore."
)
LEFT_OUT = (
    "The spool: the bore is open, its pressure the same everywhere.",
    "Cavitation, and the warming of the oil.",
    "What a finer mesh would change; compare the grids.",
)
LENGTHS = (
    "Lengths of the rail that no hydraulic formula uses. None is published; the moment arm of the nozzles was chosen "
    "so that flow simulation of a simpler rail gave the published drop, so the drop is calibrated; the split is not."
)
SHOWN_LENGTHS = ("nozzle_", "rail_", "port_")
LARGEST_AREA_ERROR = 0.02
"""Of a mouth in the mesh; the drop goes with its square."""
QUANTITIES = {
    "flow_m3_s": (FLOW, "flow"),
    "pressure_drop_Pa": (PRESSURE_DIFFERENCE, "pressure drop"),
    "pressure_drop_spread_Pa": (PRESSURE_DIFFERENCE, "its range over the last 50 iterations"),
    "pressure_drop_law_Pa": (SIGNED_PRESSURE, "pressure drop by the system's own law"),
    "discharge_coefficient": (NUMBER, "discharge coefficient on the opening"),
    "opening_area_m2": (AREA, "opening of all nozzles in the bore"),
    "jet_area_m2": (AREA, "section across all jets"),
    "mesh_area_m2": (AREA, "opening of all nozzles in the mesh"),
    "mass_imbalance": (EFFICIENCY, "what leaves less what enters, over the flow"),
    "cells": (COUNT, "cells"),
    "non_orthogonality_rad": (ANGLE, "largest non-orthogonality of the mesh"),
    "skewness": (NUMBER, "largest skewness of the mesh"),
    "density_kg_m3": (DENSITY, "density"),
    "viscosity_Pa_s": (DYNAMIC_VISCOSITY, "dynamic viscosity"),
    "iterations": (COUNT, "iterations"),
    "y_plus_least": (NUMBER, "y+ at the walls, least"),
    "y_plus_mean": (NUMBER, "y+ at the walls, mean of the faces"),
    "y_plus_largest": (NUMBER, "y+ at the walls, largest"),
    "residual_share": (NUMBER, "largest residual over its criterion"),
    "has_settled": (FLAG, "whether it has settled"),
}


class Told(NamedTuple):
    """Texts of an order beside its numbers: names of system and grid, the oil in words, origins of lengths."""

    system: str
    grid: str
    oil: str
    rows: tuple[Sourced, ...]

    @property
    def sources(self) -> tuple[str, ...]:
        """Keys of the dissertation and of every source of a length, each once."""
        return tuple(dict.fromkeys(("wang2017", *(row.source for row in self.rows if row.source))))

    def conditions(self, own: dict[str, str], order: Ordered) -> dict[str, str]:
        """Conditions of a result: its `own`, then oil, grid and how the `order` is solved."""
        return {**own, "oil": self.oil, "grid": self.grid, **approach(order)}


def rail_result(order: RailOrder, run: RailRun, told: Told) -> Result:
    """The result of a run; its sections name drawings that the page has: geometry, sections."""
    numbers = _numbers(order, run)
    return Result(
        verb=VERB,
        title="Flow through the inlet rail",
        system=told.system,
        manner=MANNER,
        references=told.sources,
        conditions=told.conditions({"flow": with_unit(order.flow, FLOW)}, order),
        left_out=LEFT_OUT,
        numbers=numbers_of(numbers, QUANTITIES),
        listings={
            "found": listing_of(numbers, QUANTITIES),
            "lengths": rail_lengths(told),
            **quality_listings(("rail",), (run.solved,)),
        },
        tables={
            "flow": _split(run),
            "history": _history(order, run),
            "steps": _steps(run),
        },
        charts={"drop": _drop_chart(run), "split": _split_chart()},
        findings=tuple(_findings(numbers, order, run)),
        sections=(
            Section(title="What was found", shows=("found", "split", "flow")),
            Section(title="The rail", words=(LENGTHS,), shows=("geometry", "lengths"), starts_page=True),
            Section(title="The flow", shows=("sections", "streamlines"), starts_page=True),
            Section(title="How it settled", shows=("drop", "steps"), starts_page=True),
            QUALITY,
            Section(title="How it was done", words=(MANNER,), shows=("conditions",)),
        ),
        seconds=run.seconds,
    )


def _numbers(order: RailOrder, run: RailRun) -> dict[str, float]:
    solved, density = run.solved, order.fluid.density
    opening = sum(mouth.opening for mouth in run.mouths)
    drop = solved.judgement.value
    return {
        "flow_m3_s": order.flow,
        "pressure_drop_Pa": drop,
        "pressure_drop_spread_Pa": solved.judgement.spread,
        "pressure_drop_law_Pa": float(turbulent_drops(order.flow, 1.0, density, order.valve).nozzle),
        "discharge_coefficient": order.flow / opening / math.sqrt(2.0 * drop / density),
        "opening_area_m2": opening,
        "jet_area_m2": sum(mouth.across_jet for mouth in run.mouths),
        "mesh_area_m2": sum(run.mesh_areas),
        "mass_imbalance": solved.judgement.imbalance,
        "cells": float(solved.mesh.cells),
        "non_orthogonality_rad": math.radians(solved.mesh.non_orthogonality),
        "skewness": solved.mesh.skewness,
        "density_kg_m3": density,
        "viscosity_Pa_s": order.fluid.viscosity,
        "iterations": float(solved.judgement.iteration),
        **dict(zip(("y_plus_least", "y_plus_mean", "y_plus_largest"), solved.quality.over_all_walls, strict=True)),
        "residual_share": solved.quality.residual_share,
        "has_settled": float(solved.settled),
    }


def drop_columns(runs: Sequence[RailRun]) -> dict[str, Column]:
    """Columns of a table with a row for each run: the drop, and the shares of the nozzles."""
    passed = np.array([run.flows for run in runs])
    drops = np.array([run.solved.judgement.value for run in runs])
    shares = passed / passed.sum(1)[:, None]
    return {
        "pressure_drop_Pa": Column(drops, PRESSURE_DIFFERENCE, "pressure drop"),
        **{
            f"split_{place + 1}": Column(share, EFFICIENCY, f"nozzle {place + 1}")
            for place, share in enumerate(shares.T)
        },
    }


def rail_lengths(told: Told) -> Listing:
    """The lengths of a rail with their origin."""
    rows = [row for row in told.rows if row.key.startswith(SHOWN_LENGTHS)]
    return Listing(title="", heads=("value",), rows=origin_rows(rows))


def _split(run: RailRun) -> Table:
    flows = np.array(run.flows)
    numbers = [f"nozzle {number + 1}" for number in range(len(flows))]
    return Table(
        title="Flow through the nozzles",
        columns={
            "nozzle": Column(np.array(numbers, str), None, ""),
            "rate_m3_s": Column(flows, FLOW, "flow"),
            "split": Column(flows / flows.sum(), EFFICIENCY, "share of the flow"),
            "opening_m2": Column(np.array([mouth.opening for mouth in run.mouths]), AREA, "opening in the bore"),
            "across_jet_m2": Column(
                np.array([mouth.across_jet for mouth in run.mouths]), AREA, "section across the jet"
            ),
            "mesh_area_m2": Column(np.array(run.mesh_areas), AREA, "opening in the mesh"),
        },
        note="Nozzle 1 lies at the angle 0, the others follow in the direction in which the spool turns.",
    )


def _history(order: RailOrder, run: RailRun) -> Table:
    history = run.solved.history
    window = order.phases[-1].window
    means = np.convolve(history.value, np.full(window, 1.0 / window))[: len(history.value)]
    means[: run.solved.since + window] = np.nan
    shares = {
        f"split_{number + 1}": Column(history.flows[mouth] / order.flow, EFFICIENCY, f"nozzle {number + 1}")
        for number, mouth in enumerate(outlets(order.valve))
    }
    columns = {
        "iteration": Column(history.iterations, COUNT, "iteration"),
        "pressure_drop_Pa": Column(history.value, SIGNED_PRESSURE, "pressure drop"),
        "mean_drop_Pa": Column(means, SIGNED_PRESSURE, f"mean of {window} iterations"),
        **shares,
    }
    return Table(title="The run over its iterations", columns=columns, is_data=True)


def _steps(run: RailRun) -> Table:
    steps = run.solved.seconds
    return Table(
        title="Time of each step",
        columns={
            "step": Column(np.array(list(steps), str), None, "step"),
            "time_s": Column(np.array(list(steps.values())), DURATION, "time"),
        },
    )


def _drop_chart(run: RailRun) -> Chart:
    settled = run.solved.judgement.value
    drop = (
        Line(x="iteration", y="pressure_drop_Pa", colour=Colour.TANK),
        Line(x="iteration", y="mean_drop_Pa", colour=Colour.LOAD, width=1.8),
    )
    shares = tuple(Line(x="iteration", y=f"split_{number + 1}") for number in range(len(run.mouths)))
    change = Level(value=float(run.solved.since), label="second order from here", upright=True)
    even = 1.0 / len(run.mouths)
    return Chart(
        name="drop",
        caption="Pressure drop and shares of the nozzles over the iterations. The run ends where the moving mean of "
        "the drop no longer changes and the flows balance.",
        table="history",
        panels=(
            Lines(
                lines=drop, label="pressure drop", low=0.5 * settled, high=1.6 * settled, levels=(change,), height=1.4
            ),
            Lines(lines=shares, label="share of the flow", low=even - 0.06, high=even + 0.06),
        ),
        height=4.2,
    )


def _split_chart() -> Chart:
    return Chart(
        name="split",
        caption="Shares of the flow. A rail that feeds all nozzles alike has no radial force on the spool.",
        table="flow",
        panels=(Bars(names="nozzle", values=("split",), colours=(Colour.LOAD,)),),
        height=1.6,
    )


def _findings(numbers: dict[str, float], order: RailOrder, run: RailRun) -> Iterator[Finding]:
    drop, law = numbers["pressure_drop_Pa"], numbers["pressure_drop_law_Pa"]
    yield Finding(
        text=f"At {with_unit(order.flow, FLOW)} the rail and its nozzles take {with_unit(drop, PRESSURE_DIFFERENCE)}, "
        f"{percent(drop / law - 1.0, 0)} off the law of the system, {with_unit(law, PRESSURE_DIFFERENCE)}."
    )
    if not run.solved.settled:
        change = percent(run.solved.judgement.change, 2)
        yield Finding(
            title="Not settled",
            grade=Grade.WARNING,
            text=f"After all its iterations the mean of the drop still changes by {change}.",
            remedy="The flow may be unsteady; its mean is an estimate.",
        )
    if numbers["mass_imbalance"] > LARGEST_IMBALANCE:
        yield Finding(title="Not balanced", grade=Grade.WARNING, text="The mass balance is not satisfied.")
    worst = max(abs(area / mouth.opening - 1.0) for area, mouth in zip(run.mesh_areas, run.mouths, strict=True))
    if worst > LARGEST_AREA_ERROR:
        yield Finding(
            title="Coarse mouths",
            grade=Grade.WARNING,
            text=f"A mouth of the mesh is {percent(worst)} off its area, and the drop goes with its square.",
            remedy="Take a finer grid.",
        )
    yield from residual_findings((run.solved,))
