"""Several shapes of an inlet rail side by side: drop, division of the flow, and the force that follows."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from vvdp.base.display import percent, with_unit
from vvdp.base.kinds import COUNT, DENSITY, EFFICIENCY, FLOW, FORCE, NUMBER, PRESSURE_DIFFERENCE, VOLUME
from vvdp.cfd.rail import RailOrder
from vvdp.cfd.rail_result import (
    LEFT_OUT,
    LENGTHS,
    MANNER,
    Told,
    drop_columns,
    rail_lengths,
)
from vvdp.cfd.rail_study import RailRun
from vvdp.cfd.state_table import QUALITY, approach, quality_listings, restless_findings, state_columns
from vvdp.results.chart import Bars, Chart, Colour
from vvdp.results.result import Column, Finding, Result, Section, Table, numbers_of
from vvdp.valve.bearing import radial_force

VERB = "cfd designs"
FORCES = (
    "The radial force is what the momentum of the jets leaves over: each carries its flow squared over its opening, "
    "towards the axis."
)
NEAR = 0.003
"""Shares of the flow nearer than this are called equal."""
QUANTITIES = {"flow_m3_s": (FLOW, "flow"), "density_kg_m3": (DENSITY, "density")}


def designs_result(orders: Mapping[str, RailOrder], runs: Sequence[RailRun], told: Told) -> Result:
    """The result of runs of several shapes at one flow, `orders` by the names of the shapes.

    Sections name drawings that the page has.
    """
    order = next(iter(orders.values()))
    table = _designs(tuple(orders), order, runs)
    return Result(
        verb=VERB,
        title="Shapes of the inlet rail side by side",
        system=told.system,
        manner=MANNER,
        references=("wang2017",),
        conditions={
            "flow": with_unit(order.flow, FLOW),
            "oil": told.oil,
            "grid": told.grid,
            **approach(order),
        },
        left_out=LEFT_OUT,
        numbers=numbers_of({"flow_m3_s": order.flow, "density_kg_m3": order.fluid.density}, QUANTITIES),
        listings={"lengths": rail_lengths(told), **quality_listings(tuple(orders), [run.solved for run in runs])},
        tables={"designs": table},
        charts={"shares": _chart(len(runs[0].mouths))},
        findings=tuple(_findings(table, runs)),
        sections=(
            Section(title="The shapes", words=(FORCES,), shows=("shares", "designs")),
            Section(title="The first of them", words=(LENGTHS,), shows=("geometry", "lengths"), starts_page=True),
            Section(title="The flow through the first of them", shows=("sections", "streamlines"), starts_page=True),
            QUALITY,
            Section(title="How it was done", words=(MANNER,), shows=("conditions",)),
        ),
        seconds=sum(run.seconds for run in runs),
    )


def _designs(names: Sequence[str], order: RailOrder, runs: Sequence[RailRun]) -> Table:
    """A row for each shape; the first is what the others are compared with."""
    drops = np.array([run.solved.judgement.value for run in runs])
    flows = np.array([run.flows for run in runs])
    openings = np.array([[mouth.opening for mouth in run.mouths] for run in runs])
    forces = [radial_force(q, area, order.fluid.density) for q, area in zip(flows, openings, strict=True)]
    columns = {
        "design": Column(np.array(names, str), None, "shape"),
        "volume_m3": Column(np.array([run.volume for run in runs]), VOLUME, "oil in rail and nozzles"),
        **drop_columns(runs),
        "drop_change": Column(drops / drops[0] - 1.0, EFFICIENCY, "against the first"),
        "largest_nozzle": Column(1.0 + flows.argmax(1), COUNT, "nozzle with the largest share"),
        "smallest_nozzle": Column(1.0 + flows.argmin(1), COUNT, "nozzle with the smallest share"),
        "radial_force_N": Column(np.array(forces), FORCE, "radial force"),
        "discharge_coefficient": Column(
            order.flow / openings.sum(1) / np.sqrt(2.0 * drops / order.fluid.density), NUMBER, "discharge coefficient"
        ),
        "cells": Column(np.array([float(run.solved.mesh.cells) for run in runs]), COUNT, "cells"),
        **state_columns([run.solved for run in runs]),
    }
    note = "Nozzle 1 lies at the angle 0, the others follow in the direction in which the spool turns."
    return Table(title="Shapes", columns=columns, note=note)


def _chart(nozzles: int) -> Chart:
    shares = tuple(f"split_{place + 1}" for place in range(nozzles))
    return Chart(
        name="shares",
        caption="Shares of the nozzles and pressure drop of each shape.",
        table="designs",
        panels=(
            Bars(names="design", values=shares, colours=(Colour.INLET, Colour.LOAD, Colour.TANK)[:nozzles]),
            Bars(names="design", values=("pressure_drop_Pa",), colours=(Colour.LOAD,)),
        ),
        side_by_side=True,
        height=3.0,
    )


def _findings(table: Table, runs: Sequence[RailRun]) -> Iterator[Finding]:
    shares = np.array([[flow / sum(run.flows) for flow in run.flows] for run in runs])
    for name, drop, change, row, force in zip(
        table["design"], table["pressure_drop_Pa"], table["drop_change"], shares, table["radial_force_N"], strict=True
    ):
        first, second = np.sort(row)[::-1][:2]
        most = f"nozzle {row.argmax() + 1} has most, {percent(first)}"
        level = f"the largest shares are level within {percent(NEAR)}"
        against = f", {percent(change, 0)} against the first" if change else ""
        yield Finding(
            text=f"{name}: {with_unit(drop, PRESSURE_DIFFERENCE)}{against}; "
            f"{most if first - second > NEAR else level}; radial force {with_unit(force, FORCE)}."
        )
    yield from restless_findings([run.solved for run in runs])
