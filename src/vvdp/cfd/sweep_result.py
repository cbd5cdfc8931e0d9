"""Flow through an inlet rail over a range of flows, as a result: laws of its drop, with their confidence."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import number, with_unit
from vvdp.base.kinds import (
    AREA,
    COUNT,
    DENSITY,
    FLOW,
    NUMBER,
    PRESSURE_DIFFERENCE,
    SIGNED_PRESSURE,
    Kind,
)
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
from vvdp.cfd.state_table import QUALITY, quality_listings, restless_findings, state_columns
from vvdp.numerics.power_laws import DropLaws, drop_laws
from vvdp.results.chart import Chart, Colour, Line, Lines, Stroke
from vvdp.results.result import Column, Finding, Result, Section, Table, listing_of, numbers_of
from vvdp.valve.branch import turbulent_drops

VERB = "cfd sweep"
FITS = (
    "The laws are fitted by least squares of the drop, the power by that of its logarithm; intervals hold a "
    "coefficient with 95 % if the scatter about the law is all that is uncertain. The error of the mesh is not in "
    "them. They hold within the flows that were computed. An orifice law is ruled by the largest flow."
)
CURVES = {"orifice": "orifice law, fitted", "two_term": "two-term law, fitted", "law": "law of the system"}
LINEAR = Kind("linear resistance", "Pa*s/m^3", -1e15, 1e15, "1e8 Pa*s/m^3")
QUADRATIC = Kind("quadratic resistance", "Pa*s^2/m^6", -1e18, 1e18, "1e11 Pa*s^2/m^6")
QUANTITIES = {
    "discharge_coefficient": (NUMBER, "discharge coefficient on the opening, fitted"),
    "discharge_coefficient_low": (NUMBER, "its interval, lower end"),
    "discharge_coefficient_high": (NUMBER, "its interval, upper end"),
    "discharge_coefficient_law": (NUMBER, "discharge coefficient of the system"),
    "flow_exponent": (NUMBER, "exponent of the flow in the drop"),
    "flow_exponent_error": (NUMBER, "half of its interval"),
    "linear_term_Pa_s_m3": (LINEAR, "linear term of the two-term law"),
    "quadratic_term_Pa_s2_m6": (QUADRATIC, "quadratic term of the two-term law"),
    "orifice_misfit_Pa": (PRESSURE_DIFFERENCE, "largest misfit of the orifice law"),
    "two_term_misfit_Pa": (PRESSURE_DIFFERENCE, "largest misfit of the two-term law"),
    "opening_area_m2": (AREA, "opening of all nozzles in the bore"),
    "jet_area_m2": (AREA, "section across all jets"),
    "cells": (COUNT, "cells"),
    "density_kg_m3": (DENSITY, "density"),
}


def sweep_result(order: RailOrder, runs: Sequence[RailRun], told: Told) -> Result:
    """The result of runs of one order at several flows; its sections name drawings that the page has.

    Raises ParameterError where there are fewer than three.
    """
    table = _sweep(order, runs)
    laws = drop_laws(table["flow_m3_s"], table["pressure_drop_Pa"])
    numbers = _numbers(order, runs, laws)
    flows = table["flow_m3_s"]
    span = f"{with_unit(flows.min(), FLOW)} to {with_unit(flows.max(), FLOW)}"
    return Result(
        verb=VERB,
        title="Pressure drop of the inlet rail over the flow",
        system=told.system,
        manner=MANNER,
        references=told.sources,
        conditions=told.conditions({"flow": span}, order),
        left_out=LEFT_OUT,
        numbers=numbers_of(numbers, QUANTITIES),
        listings={
            "fits": listing_of(numbers, QUANTITIES),
            "lengths": rail_lengths(told),
            **quality_listings([with_unit(flow, FLOW) for flow in flows.tolist()], [run.solved for run in runs]),
        },
        tables={
            "sweep": table,
            "curve": _curve(order, table, laws),
        },
        charts={"drop-over-flow": _chart()},
        findings=tuple(_findings(numbers, span, runs)),
        sections=(
            Section(title="Laws of the drop", words=(FITS,), shows=("fits", "drop-over-flow", "sweep")),
            Section(title="The rail", words=(LENGTHS,), shows=("geometry", "lengths"), starts_page=True),
            Section(title="The flow", shows=("sections", "streamlines"), starts_page=True),
            QUALITY,
            Section(title="How it was done", words=(MANNER,), shows=("conditions",)),
        ),
        seconds=sum(run.seconds for run in runs),
    )


def _sweep(order: RailOrder, runs: Sequence[RailRun]) -> Table:
    """A row for each flow; the law of the system, and whether the run has settled, beside the drop."""
    flows = np.array([sum(run.flows) for run in runs])
    opening = sum(mouth.opening for mouth in runs[0].mouths)
    drops = np.array([run.solved.judgement.value for run in runs])
    jets = np.sqrt(2.0 * drops / order.fluid.density)
    columns = {
        "flow_m3_s": Column(flows, FLOW, "flow"),
        **drop_columns(runs),
        "spread_Pa": Column(np.array([run.solved.judgement.spread for run in runs]), PRESSURE_DIFFERENCE, "its range"),
        "pressure_drop_law_Pa": Column(_law(order, flows), SIGNED_PRESSURE, "law of the system"),
        "point_coefficient": Column(flows / opening / jets, NUMBER, "discharge coefficient"),
        **state_columns([run.solved for run in runs]),
    }
    return Table(title="Runs", columns=columns, axes=("flow_m3_s",))


def _law(order: RailOrder, flows: Array) -> Array:
    return np.array([turbulent_drops(float(q), 1.0, order.fluid.density, order.valve).nozzle for q in flows])


def _numbers(order: RailOrder, runs: Sequence[RailRun], laws: DropLaws) -> dict[str, float]:
    """A coefficient c of c Q^2 is rho / (2 Cd^2 A^2)."""
    opening = sum(mouth.opening for mouth in runs[0].mouths)

    def coefficient(c: float) -> float:
        return math.sqrt(0.5 * order.fluid.density / c) / opening if c > 0.0 else math.nan

    (c,), (width,) = laws.orifice.coefficients, laws.orifice.half_widths
    return {
        "discharge_coefficient": coefficient(c),
        "discharge_coefficient_low": coefficient(c + width),
        "discharge_coefficient_high": coefficient(c - width),
        "discharge_coefficient_law": order.valve.nozzle_discharge_coefficient,
        "flow_exponent": float(laws.power.coefficients[1]),
        "flow_exponent_error": float(laws.power.half_widths[1]),
        "linear_term_Pa_s_m3": float(laws.two_term.coefficients[0]),
        "quadratic_term_Pa_s2_m6": float(laws.two_term.coefficients[1]),
        "orifice_misfit_Pa": float(abs(laws.orifice.residuals).max()),
        "two_term_misfit_Pa": float(abs(laws.two_term.residuals).max()),
        "opening_area_m2": opening,
        "jet_area_m2": sum(mouth.across_jet for mouth in runs[0].mouths),
        "cells": float(runs[0].solved.mesh.cells),
        "density_kg_m3": order.fluid.density,
    }


def _curve(order: RailOrder, sweep: Table, laws: DropLaws) -> Table:
    """Laws over the flow, and at the flows that were computed what each leaves over."""
    flows = np.linspace(0.0, 1.05 * sweep["flow_m3_s"].max(), 61)[1:]
    (c,), (a, b) = laws.orifice.coefficients, laws.two_term.coefficients
    return Table(
        title="Laws over the flow",
        columns={
            "flow_m3_s": Column(flows, FLOW, "flow"),
            "orifice_Pa": Column(c * flows**2, SIGNED_PRESSURE, CURVES["orifice"]),
            "two_term_Pa": Column(a * flows + b * flows**2, SIGNED_PRESSURE, CURVES["two_term"]),
            "law_Pa": Column(_law(order, flows), SIGNED_PRESSURE, CURVES["law"]),
        },
        is_data=True,
    )


def _chart() -> Chart:
    laws = (
        ("orifice", Stroke.DASHED, Colour.INLET),
        ("two_term", Stroke.SOLID, Colour.LOAD),
        ("law", Stroke.DOTTED, Colour.RELIEF),
    )
    lines = [
        Line(x="flow_m3_s", y=f"{key}_Pa", label=CURVES[key], stroke=stroke, table="curve", colour=colour)
        for key, stroke, colour in laws
    ]
    points = Line(
        x="flow_m3_s", y="pressure_drop_Pa", stroke=Stroke.POINTS, label="computed", colour=Colour.INK, width=2
    )
    coefficient = Line(x="flow_m3_s", y="point_coefficient", stroke=Stroke.MARKED, colour=Colour.LOAD)
    return Chart(
        name="drop-over-flow",
        caption="Left: computed pressure drops, laws fitted to them, and the law of the system. Right: the discharge "
        "coefficient that each single flow would give; it is the same everywhere where the drop is quadratic.",
        table="sweep",
        panels=(
            Lines(lines=(*lines, points), label="pressure drop", low=0.0, left=0.0),
            Lines(lines=(coefficient,), label="discharge coefficient", left=0.0),
        ),
        side_by_side=True,
    )


def _findings(numbers: dict[str, float], span: str, runs: Sequence[RailRun]) -> Iterator[Finding]:
    low, high = numbers["discharge_coefficient_low"], numbers["discharge_coefficient_high"]
    found, given = numbers["discharge_coefficient"], numbers["discharge_coefficient_law"]
    yield Finding(
        text=f"From {span} the discharge coefficient is {number(found, 3)} ({number(low, 3)} to "
        f"{number(high, 3)}); the system has {number(given, 3)}."
    )
    exponent, error = numbers["flow_exponent"], numbers["flow_exponent_error"]
    yield Finding(text=f"The drop grows with the flow to the power {number(exponent, 3)} ± {number(error, 2)}.")
    yield from restless_findings([run.solved for run in runs])


def fitted_settings(result: Result) -> tuple[str]:
    """The discharge coefficient that was found, as a setting of a system with its interval and origin."""
    numbers = {key: each.value for key, each in result.numbers.items()}
    made = result.conditions
    note = f"fitted to computed flow, {made['flow']}, {made['turbulence']}, {numbers['cells']:.0f} cells"
    low, high = numbers["discharge_coefficient_low"], numbers["discharge_coefficient_high"]
    setting = (
        f'valve.nozzle_discharge_coefficient={{value="{numbers["discharge_coefficient"]:.6g}", '
        f'range=["{low:.6g}", "{high:.6g}"], status="derived", note="{note}"}}'
    )
    return (setting,)
