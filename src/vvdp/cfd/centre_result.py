"""What the flow through a centre section comes to over a range of flows: laws of its drop, torque of the jets."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import number, percent, with_unit
from vvdp.base.kinds import (
    ANGLE,
    AREA,
    COUNT,
    DENSITY,
    EFFICIENCY,
    FLAG,
    FLOW,
    NUMBER,
    POSITION,
    SIGNED_PRESSURE,
    TORQUE,
)
from vvdp.cfd.centre import CentreOrder
from vvdp.cfd.centre_study import CentreRun
from vvdp.cfd.rail_result import METHOD, Told
from vvdp.geometry.result import origin_rows
from vvdp.geometry.shape import perpendicular_area
from vvdp.numerics.least_squares import Fit, fit
from vvdp.results.chart import Chart, Colour, Line, Lines, Stroke
from vvdp.results.result import Column, Finding, Grade, Listing, Result, Row, Section, Table, numbers_of
from vvdp.valve.branch import turbulent_drops
from vvdp.valve.torque import inlet_torque

VERB = "cfd centre"
DROPS = (
    "The total drop is what the jets lose of static and dynamic pressure from the stubs' ends on. The static drop is "
    "the total less the dynamic pressure of jets as wide as the nozzles: a small difference of two large numbers, so "
    "an error of the mesh weighs several times in it."
)
LENGTHS = (
    "None of these is published. The windows were chosen so that flow simulation gave about the published drop, so the "
    "drop is calibrated; the exponent of the flow is not."
)
SHOWN_LENGTHS = ("hub_", "pocket_", "window_", "ring_", "nozzle_")
QUANTITIES = {
    "flow_exponent": (NUMBER, "exponent of the flow in the static drop"),
    "flow_exponent_error": (NUMBER, "half of its interval"),
    "flow_exponent_law": (NUMBER, "exponent of the system"),
    "total_exponent": (NUMBER, "exponent of the flow in the total drop"),
    "total_exponent_error": (NUMBER, "half of its interval"),
    "centre_coefficient": (NUMBER, "coefficient k of the static drop Q^m/(k D^n), SI"),
    "centre_coefficient_law": (NUMBER, "coefficient of the system, SI"),
    "jet_area_m2": (AREA, "section across all jets"),
    "stub_area_m2": (AREA, "area of the stubs' ends in the mesh"),
    "spool_angle_rad": (ANGLE, "spool angle"),
    "axial_position_m": (POSITION, "axial position of the spool"),
    "cells": (COUNT, "cells"),
    "density_kg_m3": (DENSITY, "density"),
}


def centre_result(order: CentreOrder, runs: Sequence[CentreRun], told: Told) -> Result:
    """The result of runs of one order at several flows; its sections name drawings that the page has.

    Raises ParameterError where there are fewer than three.
    """
    table = _runs(order, runs)
    flows, static, total = (table[key] for key in ("flow_m3_s", "static_drop_Pa", "total_drop_Pa"))
    powers = [_power(flows, drops) for drops in (static, total)]
    numbers = _numbers(order, runs, powers)
    span = f"{with_unit(flows.min(), FLOW)} to {with_unit(flows.max(), FLOW)}"
    return Result(
        verb=VERB,
        title="Pressure drop of the centre section over the flow",
        system=told.system,
        manner=METHOD,
        references=tuple(dict.fromkeys(("wang2017", *(row.source for row in told.rows if row.source)))),
        conditions={"flow": span, "oil": told.oil, "grid": told.grid, "turbulence": order.turbulence.model},
        left_out=("Rail and nozzles upstream: the stubs have a uniform inflow and walls without friction.",
                  "The turning of the spool, leakage, cavitation, and the warming of the oil."),
        numbers=numbers_of(numbers, QUANTITIES),
        listings={"fits": _fits(numbers), "lengths": centre_lengths(told)},
        tables={"runs": table},
        charts={"drop-over-flow": _chart()},
        findings=tuple(_findings(numbers, span, runs, static)),
        sections=(
            Section(title="Drop and torque", words=(DROPS,), shows=("fits", "drop-over-flow", "runs")),
            Section(title="The centre section", words=(LENGTHS,), shows=("geometry", "lengths"), starts_page=True),
            Section(title="The flow", shows=("sections",), starts_page=True),
            Section(title="How it was done", words=(METHOD,), shows=("conditions",)),
        ),
        seconds=math.fsum(run.seconds for run in runs),
    )  # fmt: skip


def _power(flows: Array, drops: Array) -> Fit | None:
    """The power of the flow that comes closest; None where a drop is negative, as a mesh too coarse may have it."""
    return fit([np.ones_like(flows), np.log(flows)], np.log(drops)) if (drops > 0.0).all() else None


def _runs(order: CentreOrder, runs: Sequence[CentreRun]) -> Table:
    flows = np.array([run.order.flow for run in runs])
    total = np.array([run.solved.judgement.value for run in runs])
    density, valve = order.fluid.density, order.valve
    jets = flows / perpendicular_area(order.shape, valve)
    law = np.array([turbulent_drops(run.order.flow, 1.0, density, valve).centre_section for run in runs])
    torque = np.array([inlet_torque(run.order.flow, 1.0, density, valve) for run in runs])
    columns = {
        "flow_m3_s": Column(flows, FLOW, "flow"),
        "total_drop_Pa": Column(total, SIGNED_PRESSURE, "total drop"),
        "static_drop_Pa": Column(total - 0.5 * density * jets**2, SIGNED_PRESSURE, "static drop"),
        "static_drop_law_Pa": Column(law, SIGNED_PRESSURE, "law of the system"),
        "torque_N_m": Column(np.array([run.torque for run in runs]), TORQUE, "torque"),
        "torque_law_N_m": Column(torque, TORQUE, "torque, law of the system"),
        "mass_imbalance": Column(np.array([run.solved.judgement.imbalance for run in runs]), EFFICIENCY, "imbalance"),
        "iterations": Column(np.array([float(run.solved.judgement.iteration) for run in runs]), COUNT, "iterations"),
        "has_settled": Column(np.array([float(run.solved.settled) for run in runs]), FLAG, "settled"),
    }
    return Table(title="Runs", columns=columns, axes=("flow_m3_s",))


def _numbers(order: CentreOrder, runs: Sequence[CentreRun], powers: Sequence[Fit | None]) -> dict[str, float]:
    """Of a power law c Q^m, k is 1 / (c D^n)."""
    valve, (static, total) = order.valve, powers
    nothing = np.full(2, np.nan)
    (log_c, m), (_, error) = (static.coefficients, static.half_widths) if static else (nothing, nothing)
    (_, all_m), (_, all_error) = (total.coefficients, total.half_widths) if total else (nothing, nothing)
    diameter = 2.0 * valve.spool_radius
    return {
        "flow_exponent": float(m),
        "flow_exponent_error": float(error),
        "flow_exponent_law": valve.centre_flow_exponent,
        "total_exponent": float(all_m),
        "total_exponent_error": float(all_error),
        "centre_coefficient": float(np.exp(-log_c) / diameter**valve.centre_diameter_exponent),
        "centre_coefficient_law": valve.centre_coefficient,
        "jet_area_m2": perpendicular_area(order.shape, valve),
        "stub_area_m2": runs[0].stub_area,
        "spool_angle_rad": order.angle,
        "axial_position_m": order.position,
        "cells": float(runs[0].solved.mesh.cells),
        "density_kg_m3": order.fluid.density,
    }


def _fits(numbers: dict[str, float]) -> Listing:
    rows = (Row(label, kind, (numbers[key],)) for key, (kind, label) in QUANTITIES.items())
    return Listing(title="", heads=("value",), rows=tuple(rows))


def centre_lengths(told: Told) -> Listing:
    """The lengths of a centre section with their origin."""
    rows = [row for row in told.rows if row.key.startswith(SHOWN_LENGTHS)]
    return Listing(title="", heads=("value",), rows=origin_rows(rows))


def _chart() -> Chart:
    drops = (
        Line(x="flow_m3_s", y="total_drop_Pa", stroke=Stroke.MARKED, colour=Colour.TANK),
        Line(x="flow_m3_s", y="static_drop_Pa", stroke=Stroke.MARKED, colour=Colour.LOAD),
        Line(x="flow_m3_s", y="static_drop_law_Pa", stroke=Stroke.DOTTED, colour=Colour.RELIEF),
    )
    torques = (
        Line(x="flow_m3_s", y="torque_N_m", stroke=Stroke.MARKED, colour=Colour.LOAD),
        Line(x="flow_m3_s", y="torque_law_N_m", stroke=Stroke.DOTTED, colour=Colour.RELIEF),
    )
    return Chart(
        name="drop-over-flow",
        caption="Left: total and static drop of the centre section, and the system's law of the static one. Right: "
        "torque of the jets on the spool at rest.",
        table="runs",
        panels=(
            Lines(lines=drops, label="pressure drop", low=0.0, left=0.0),
            Lines(lines=torques, label="torque", low=0.0, left=0.0),
        ),
        side_by_side=True,
    )


def _findings(numbers: dict[str, float], span: str, runs: Sequence[CentreRun], static: Array) -> Iterator[Finding]:
    exponent, error = number(numbers["flow_exponent"], 3), number(numbers["flow_exponent_error"], 2)
    yield Finding(
        text=f"From {span} the static drop grows with the flow to the power {exponent} ± {error}; the system has "
        f"{number(numbers['flow_exponent_law'], 3)}."
    )
    if not (static > 0.0).all():
        yield Finding(title="No static drop", grade=Grade.WARNING, text="The mesh is too coarse for the static drop.",
                      remedy="Take a finer grid.")  # fmt: skip
    if restless := [run for run in runs if not run.solved.settled]:
        worst = percent(max(run.solved.judgement.change for run in restless), 2)
        text = f"{len(restless)} of {len(runs)} runs still changed at their end, by up to {worst}."
        yield Finding(title="Not settled", grade=Grade.WARNING, text=text, remedy="Take a finer grid.")


def fitted_settings(result: Result) -> tuple[str, ...]:
    """Exponent and coefficient that were found, as settings of a system with their origin, where there are any."""
    numbers = {key: each.value for key, each in result.numbers.items()}
    if math.isnan(numbers["flow_exponent"]):
        return ()
    made = result.conditions
    note = f"fitted to computed flow, {made['flow']}, {made['turbulence']}, {numbers['cells']:.0f} cells"
    values = {
        "centre_flow_exponent": f"{numbers['flow_exponent']:.6g}",
        "centre_coefficient": f"{numbers['centre_coefficient']:.6g} SI",
    }
    return tuple(f'valve.{key}={{value="{text}", status="derived", note="{note}"}}' for key, text in values.items())
