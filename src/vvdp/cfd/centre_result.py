"""Flow through a centre section over flow and diameter, as a result: laws of its drop, torque of the jets."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import number, with_unit
from vvdp.base.kinds import (
    ANGLE,
    AREA,
    COUNT,
    DENSITY,
    FLOW,
    LENGTH,
    NUMBER,
    POSITION,
    PRESSURE_DIFFERENCE,
    SIGNED_PRESSURE,
    TORQUE,
)
from vvdp.base.params import field_kinds
from vvdp.cfd.centre_study import CentreRun
from vvdp.cfd.rail_result import METHOD, Told
from vvdp.cfd.state_table import QUALITY, quality_listings, restless_findings, state_columns
from vvdp.geometry.result import origin_rows
from vvdp.geometry.shape import perpendicular_area
from vvdp.numerics.least_squares import fit
from vvdp.results.chart import Chart, Colour, Line, Lines, Stroke
from vvdp.results.result import Column, Finding, Grade, Listing, Result, Section, Table, listing_of, numbers_of
from vvdp.valve.branch import turbulent_drops
from vvdp.valve.rotary import RotaryValve
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
EXPONENTS = ("centre_flow_exponent", "centre_diameter_exponent")
SHOWN_LENGTHS = ("hub_", "pocket_", "window_", "ring_", "nozzle_")
QUANTITIES = {
    "flow_exponent": (NUMBER, "exponent of the flow in the static drop"),
    "flow_exponent_error": (NUMBER, "half of its interval"),
    "flow_exponent_law": (NUMBER, "exponent of the system"),
    "diameter_exponent": (NUMBER, "exponent of the diameter under the static drop; the system's where one is given"),
    "diameter_exponent_error": (NUMBER, "half of its interval"),
    "diameter_exponent_law": (NUMBER, "exponent of the system"),
    "largest_misfit_Pa": (PRESSURE_DIFFERENCE, "largest distance of the static drop from its law"),
    "total_exponent": (NUMBER, "exponent of the flow in the total drop"),
    "total_exponent_error": (NUMBER, "half of its interval"),
    "total_diameter_exponent": (NUMBER, "exponent of the diameter under the total drop"),
    "total_diameter_exponent_error": (NUMBER, "half of its interval"),
    "centre_coefficient": (NUMBER, "coefficient k of the static drop Q^m/(k D^n), SI"),
    "centre_coefficient_law": (NUMBER, "coefficient of the system, SI"),
    "inlet_area_ratio": (NUMBER, "effective area of the jets' torque over that of the nozzles, fitted"),
    "inlet_area_ratio_low": (NUMBER, "its interval, lower end"),
    "inlet_area_ratio_high": (NUMBER, "its interval, upper end"),
    "inlet_area_ratio_law": (NUMBER, "ratio of the system"),
    "jet_area_m2": (AREA, "section across all jets"),
    "stub_area_m2": (AREA, "area of the stubs' ends in the mesh"),
    "stub_length_m": (LENGTH, "length of the stubs"),
    "spool_angle_rad": (ANGLE, "spool angle"),
    "axial_position_m": (POSITION, "axial position of the spool"),
    "density_kg_m3": (DENSITY, "density"),
}


def centre_result(runs: Sequence[CentreRun], told: Told) -> Result:
    """The result of runs at several flows, of one diameter or more; its sections name drawings that the page has.

    Raises ParameterError where there are too few for the laws.
    """
    order = runs[0].order
    table = _runs(runs)
    flows, static = table["flow_m3_s"], table["static_drop_Pa"]
    numbers = _numbers(runs, table)
    span = f"{with_unit(flows.min(), FLOW)} to {with_unit(flows.max(), FLOW)}"
    return Result(
        verb=VERB,
        title="Pressure drop of the centre section over the flow",
        system=told.system,
        manner=METHOD,
        references=told.sources,
        conditions=told.conditions({"flow": span}, order),
        left_out=("Rail and nozzles upstream: the stubs have a uniform inflow and walls without friction.",
                  "The turning of the spool, leakage, cavitation, and the warming of the oil."),
        numbers=numbers_of(numbers, QUANTITIES),
        listings={
            "fits": listing_of(numbers, QUANTITIES), "lengths": centre_lengths(told),
            **quality_listings(_names(runs), [run.solved for run in runs]),
        },
        tables={"runs": table},
        charts={"drop-over-flow": _chart(Stroke.POINTS if np.ptp(table["diameter_m"]) else Stroke.MARKED)},
        findings=tuple(_findings(numbers, span, runs, static)),
        sections=(
            Section(title="Drop and torque", words=(DROPS,), shows=("fits", "drop-over-flow", "runs")),
            Section(title="The centre section", words=(LENGTHS,), shows=("geometry", "lengths"), starts_page=True),
            Section(title="The flow", shows=("sections", "streamlines"), starts_page=True),
            QUALITY,
            Section(title="How it was done", words=(METHOD,), shows=("conditions",)),
        ),
        seconds=math.fsum(run.seconds for run in runs),
    )  # fmt: skip


class _Power(NamedTuple):
    """A drop Q^m/(k D^n): k [SI], m and n with half of their intervals, and the largest residual [Pa]."""

    coefficient: float
    exponent: float
    exponent_error: float
    diameter_exponent: float
    diameter_exponent_error: float
    misfit: float


def _power(table: Table, key: str, usual: float) -> _Power:
    """The law that comes closest to the logarithm of a drop; of one diameter alone its exponent is the `usual` one.

    All are nan where a drop is negative, as a mesh too coarse may have it.
    """
    drops, flows, diameters = (table[name] for name in (key, "flow_m3_s", "diameter_m"))
    if not (drops > 0.0).all():
        return _Power(**dict.fromkeys(_Power._fields, math.nan))
    several = np.ptp(diameters) > 0.0
    columns = [np.ones_like(drops), np.log(flows), *((-np.log(diameters),) if several else ())]
    found = fit(columns, np.log(drops) + (0.0 if several else usual) * np.log(diameters))
    (log_c, m), (_, error) = found.coefficients[:2], found.half_widths[:2]
    misfit = drops - drops * np.exp(-found.residuals)
    return _Power(
        coefficient=float(np.exp(-log_c)),
        exponent=float(m),
        exponent_error=float(error),
        diameter_exponent=float(found.coefficients[2]) if several else usual,
        diameter_exponent_error=float(found.half_widths[2]) if several else math.nan,
        misfit=float(np.abs(misfit).max()),
    )


def _runs(runs: Sequence[CentreRun]) -> Table:
    orders, density = [run.order for run in runs], runs[0].order.fluid.density
    flows = np.array([order.flow for order in orders])
    total = np.array([run.solved.judgement.value for run in runs])
    jets = flows / np.array([perpendicular_area(order.shape, order.valve) for order in orders])
    law = np.array([turbulent_drops(order.flow, 1.0, density, order.valve).centre_section for order in orders])
    torque = np.array([inlet_torque(order.flow, 1.0, density, order.valve) for order in orders])
    columns = {
        "diameter_m": Column(np.array([2.0 * order.valve.spool_radius for order in orders]), LENGTH, "spool diameter"),
        "flow_m3_s": Column(flows, FLOW, "flow"),
        "total_drop_Pa": Column(total, SIGNED_PRESSURE, "total drop"),
        "static_drop_Pa": Column(total - 0.5 * density * jets**2, SIGNED_PRESSURE, "static drop"),
        "static_drop_law_Pa": Column(law, SIGNED_PRESSURE, "law of the system"),
        "torque_N_m": Column(np.array([run.torque for run in runs]), TORQUE, "torque"),
        "torque_law_N_m": Column(torque, TORQUE, "torque, law of the system"),
        "cells": Column(np.array([float(run.solved.mesh.cells) for run in runs]), COUNT, "cells"),
        **state_columns([run.solved for run in runs]),
    }
    return Table(title="Runs", columns=columns, axes=("diameter_m", "flow_m3_s"))


def _names(runs: Sequence[CentreRun]) -> list[str]:
    return [
        f"{with_unit(2.0 * run.order.valve.spool_radius, LENGTH)}, {with_unit(run.order.flow, FLOW)}" for run in runs
    ]


def _jets(runs: Sequence[CentreRun]) -> dict[str, float]:
    """The area that gives the torque of the jets, rho R Q^2/(r A), over that of the nozzles: r, and its interval."""
    full = [inlet_torque(each.flow, 1.0, each.fluid.density, replace(each.valve, inlet_area_ratio=1.0))
            for each in (run.order for run in runs)]  # fmt: skip
    found = fit([np.array(full)], np.array([run.torque for run in runs]))
    (share,), (half,) = found.coefficients, found.half_widths
    return {
        "inlet_area_ratio": float(1.0 / share),
        "inlet_area_ratio_low": float(1.0 / (share + half)),
        "inlet_area_ratio_high": float(1.0 / (share - half)) if share > half else math.nan,
    }


def _numbers(runs: Sequence[CentreRun], table: Table) -> dict[str, float]:
    order, valve = runs[0].order, runs[0].order.valve
    static, total = (_power(table, key, valve.centre_diameter_exponent) for key in ("static_drop_Pa", "total_drop_Pa"))
    return {
        "flow_exponent": static.exponent,
        "flow_exponent_error": static.exponent_error,
        "flow_exponent_law": valve.centre_flow_exponent,
        "diameter_exponent": static.diameter_exponent,
        "diameter_exponent_error": static.diameter_exponent_error,
        "diameter_exponent_law": valve.centre_diameter_exponent,
        "largest_misfit_Pa": static.misfit,
        "total_exponent": total.exponent,
        "total_exponent_error": total.exponent_error,
        "total_diameter_exponent": total.diameter_exponent,
        "total_diameter_exponent_error": total.diameter_exponent_error,
        "centre_coefficient": static.coefficient,
        "centre_coefficient_law": valve.centre_coefficient,
        **_jets(runs),
        "inlet_area_ratio_law": valve.inlet_area_ratio,
        "jet_area_m2": perpendicular_area(order.shape, valve),
        "stub_area_m2": runs[0].stub_area,
        "stub_length_m": order.stub * order.valve.spool_radius,
        "spool_angle_rad": order.angle,
        "axial_position_m": order.position,
        "density_kg_m3": order.fluid.density,
    }


def centre_lengths(told: Told) -> Listing:
    """The lengths of a centre section with their origin."""
    rows = [row for row in told.rows if row.key.startswith(SHOWN_LENGTHS)]
    return Listing(title="", heads=("value",), rows=origin_rows(rows))


def _chart(stroke: Stroke) -> Chart:
    law = Stroke.POINTS if stroke is Stroke.POINTS else Stroke.DOTTED
    drops = (
        Line(x="flow_m3_s", y="total_drop_Pa", stroke=stroke, colour=Colour.TANK),
        Line(x="flow_m3_s", y="static_drop_Pa", stroke=stroke, colour=Colour.LOAD),
        Line(x="flow_m3_s", y="static_drop_law_Pa", stroke=law, colour=Colour.RELIEF),
    )
    torques = (
        Line(x="flow_m3_s", y="torque_N_m", stroke=stroke, colour=Colour.LOAD),
        Line(x="flow_m3_s", y="torque_law_N_m", stroke=law, colour=Colour.RELIEF),
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
    low, found, high = (number(numbers[f"inlet_area_ratio{end}"], 3) for end in ("_low", "", "_high"))
    yield Finding(
        text=f"The torque is that of jets of {found} ({low} to {high}) times the nozzles' area; the system has "
        f"{number(numbers['inlet_area_ratio_law'], 3)}."
    )
    if not math.isnan(numbers["diameter_exponent_error"]):
        fall, error = number(numbers["diameter_exponent"], 3), number(numbers["diameter_exponent_error"], 2)
        yield Finding(
            text=f"It falls with the diameter to the power {fall} ± {error}, lengths along the spool as they are; the "
            f"system has {number(numbers['diameter_exponent_law'], 3)}."
        )
    if not (static > 0.0).all():
        yield Finding(title="No static drop", grade=Grade.WARNING, text="The mesh is too coarse for the static drop.",
                      remedy="Take a finer grid.")  # fmt: skip
    yield from restless_findings([run.solved for run in runs])


def fitted_settings(result: Result) -> tuple[str, ...]:
    """Laws of drop and torque that were found, as settings of a system with their origin, where there are any.

    A spool that is turned closes nozzles, and the laws are those of open ones.
    """
    numbers = {key: each.value for key, each in result.numbers.items()}
    if numbers["spool_angle_rad"]:
        return ()
    made = result.conditions
    note = (
        f"fitted to computed flow, {made['flow']}, {made['turbulence']}, {result.tables['runs']['cells'][0]:.0f} cells"
    )
    ratio, low, high = (numbers[f"inlet_area_ratio{end}"] for end in ("", "_low", "_high"))
    spread = {"inlet_area_ratio": f'range=["{low:.6g}", "{high:.6g}"], '} if high > 0.0 else {}
    values = {"inlet_area_ratio": f"{ratio:.6g}"} if ratio > 0.0 else {}
    if not math.isnan(numbers["flow_exponent"]):
        exponents = [_within_range(key, numbers[key.removeprefix("centre_")]) for key in EXPONENTS]
        values |= {key: f"{exponent:.6g}" for key, exponent in zip(EXPONENTS, exponents, strict=True)}
        values["centre_coefficient"] = f"{_coefficient(result.tables['runs'], *exponents):.6g} SI"
    return tuple(
        f'valve.{key}={{value="{text}", {spread.get(key, "")}status="derived", note="{note}"}}'
        for key, text in values.items()
    )


def _coefficient(table: Table, exponent: float, diameter_exponent: float) -> float:
    """The k of Q^m/(k D^n) that comes closest to the logarithm of the static drop at given exponents [SI]."""
    flows, diameters, drops = (np.log(table[key]) for key in ("flow_m3_s", "diameter_m", "static_drop_Pa"))
    return float(np.exp(np.mean(exponent * flows - diameter_exponent * diameters - drops)))


def _within_range(key: str, value: float) -> float:
    """A value of the valve, moved into the range that the valve takes."""
    kind = field_kinds(RotaryValve)[key]
    assert kind is not None
    return min(max(value, kind.low), kind.high)
