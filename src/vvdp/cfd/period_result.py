"""A PWM period as a result: effective area and torque over the spool angle, beside the product of ramps."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import number, percent, with_unit
from vvdp.base.kinds import (
    ANGLE,
    AREA,
    COUNT,
    DENSITY,
    DURATION,
    EFFICIENCY,
    FLOW,
    FRACTION,
    NUMBER,
    PRESSURE_DIFFERENCE,
    SPEED,
    TORQUE,
)
from vvdp.cfd.centre_result import LENGTHS, centre_lengths
from vvdp.cfd.numerics import PASSING
from vvdp.cfd.period import STEPS, PeriodRun
from vvdp.cfd.rail_result import METHOD, Told
from vvdp.cfd.state_table import QUALITY, quality_listings
from vvdp.numerics.least_squares import Fit, fit
from vvdp.results.chart import Chart, Colour, Line, Lines
from vvdp.results.result import Column, Finding, Grade, Result, Section, Table, listing_of, numbers_of
from vvdp.valve.geometry import jet_skews, port_shape
from vvdp.valve.torque import inlet_torque

VERB = "cfd period"
BALANCED = 0.01
"""Share of the flow that may get lost where meshes slide."""
TURNING = (
    f"The spool turns through one PWM period in {STEPS} steps, from rest with closed nozzles, under a total "
    "drop that is "
    "held. Its oil is a mesh that slides within the bore; mouths and pockets see each other as far as they cover each "
    "other, and are walls for the rest (cyclicACMI). Convection is upwind. Until the nozzles open, the torque is that "
    "of the period's end."
)
FACTORS = (
    "The effective opening is the flow over the root of the total drop, over the same at the angle 0. A factor to the "
    "formula is fitted to each ramp and is offered as a correction: the effective opening is the factor times the "
    "formula. The oil's inertia is in it, so it holds for this speed and for stubs as short as these."
)
QUANTITIES = {
    "total_drop_Pa": (PRESSURE_DIFFERENCE, "total drop that is held"),
    "spool_speed_rad_s": (SPEED, "spool speed"),
    "open_area_m2": (AREA, "effective area of open nozzles"),
    "closing_factor": (NUMBER, "effective opening over the formula, closing"),
    "closing_factor_error": (NUMBER, "half of its interval"),
    "opening_factor": (NUMBER, "effective opening over the formula, opening"),
    "opening_factor_error": (NUMBER, "half of its interval"),
    "mean_opening_effective": (FRACTION, "effective opening, mean over the period"),
    "mean_opening_formula": (FRACTION, "opening by the formula, mean over the period"),
    "lag_rad": (ANGLE, "angle by which the middle of the effective opening is behind that of the formula"),
    "mean_flow_m3_s": (FLOW, "flow, mean over the period"),
    "mean_torque_N_m": (TORQUE, "torque, mean over the period"),
    "mean_torque_law_N_m": (TORQUE, "torque by the law of the jets, mean over the period"),
    "mass_imbalance": (EFFICIENCY, "imbalance, mean over the period"),
    "begin_angle_rad": (ANGLE, "angle at which the period begins"),
    "cells": (COUNT, "cells"),
    "density_kg_m3": (DENSITY, "density"),
}


class Ramps(NamedTuple):
    """Factors of the effective opening over the formula, where nozzles close and where they open."""

    closing: Fit
    opening: Fit


def period_result(run: PeriodRun, told: Told) -> Result:
    """The result of a period; its sections name drawings that the page has."""
    centre = run.order.centre
    table = _angles(run)
    numbers = _numbers(run, table)
    return Result(
        verb=VERB,
        title="A PWM period of the turning spool",
        system=told.system,
        manner=f"{METHOD} {TURNING}",
        references=told.sources,
        conditions=told.conditions(
            {
                "spool speed": with_unit(centre.speed, SPEED),
                "total drop": with_unit(run.order.drop, PRESSURE_DIFFERENCE),
            },
            centre._replace(phases=(PASSING,)),
        ),
        left_out=("Rail and nozzles upstream, whose oil would take longer to get under way; leakage, cavitation.",
                  "The side of the tank, which is the mirror image half a pitch on."),
        numbers=numbers_of(numbers, QUANTITIES),
        listings={
            "found": listing_of(numbers, QUANTITIES), "lengths": centre_lengths(told),
            **quality_listings(("end of the period",), (run.solved,)),
        },
        tables={"angles": table},
        charts={"period": _chart()},
        findings=tuple(_findings(numbers)),
        sections=(
            Section(title="Openings and torque", words=(TURNING, FACTORS), shows=("found", "period")),
            Section(title="The flow as the spool turns", shows=("frames",), starts_page=True),
            Section(title="The section", words=(LENGTHS,), shows=("geometry", "lengths"), starts_page=True),
            QUALITY,
            Section(title="How it was done", words=(METHOD,), shows=("conditions",)),
        ),
        seconds=run.solved.took,
    )  # fmt: skip


def _angles(run: PeriodRun) -> Table:
    centre = run.order.centre
    valve, density = centre.valve, centre.fluid.density
    jet = float(np.sqrt(2.0 * run.order.drop / density))
    area = run.entering / jet
    whole = float(np.interp(0.0, run.angle, area))
    full = whole * jet
    skews = [jet_skews(angle, centre.position, valve.jet_asymmetry, port_shape(valve)).load for angle in run.angle]
    law = [
        inlet_torque(full, share, density, valve, skew) for share, skew in zip(run.opening.tolist(), skews, strict=True)
    ]
    columns = {
        "time_s": Column((run.angle - run.order.begin) / centre.speed, DURATION, "time"),
        "spool_angle_rad": Column(run.angle, ANGLE, "spool angle"),
        "opening_formula": Column(run.opening, FRACTION, "opening, formula"),
        "opening_effective": Column(area / whole, FRACTION, "opening, effective"),
        "effective_area_m2": Column(area, AREA, "effective area"),
        "flow_m3_s": Column(run.entering, FLOW, "flow in"),
        "flow_out_m3_s": Column(run.leaving, FLOW, "flow out"),
        "torque_N_m": Column(run.torque, TORQUE, "torque"),
        "torque_law_N_m": Column(np.array(law), TORQUE, "torque, law of the jets"),
    }
    return Table(title="Angles", columns=columns, is_data=True)


def fit_ramps(angle: Array, formula: Array, effective: Array) -> Ramps:
    """A factor by least squares for each ramp, the angles in order; the nozzles close at positive angles.

    >>> angle, formula = np.array([-2.0, -1.0, 1.0, 2.0]), np.array([0.5, 0.8, 0.8, 0.5])
    >>> [round(float(each.coefficients[0]), 4) for each in fit_ramps(angle, formula, np.array([0.6, 0.9, 0.7, 0.4]))]
    [0.8539, 1.1461]
    """
    partly = (formula > 0.0) & (formula < 1.0)
    ways = (partly & (angle > 0.0), partly & (angle < 0.0))
    return Ramps(*(fit([formula[rows]], effective[rows]).in_series() for rows in ways))


def _numbers(run: PeriodRun, table: Table) -> dict[str, float]:
    angle, formula, effective = (table[key] for key in ("spool_angle_rad", "opening_formula", "opening_effective"))
    ramps = fit_ramps(angle, formula, effective)
    middle, expected = (float((angle * share).sum() / share.sum()) for share in (effective, formula))
    return {
        "total_drop_Pa": run.order.drop,
        "spool_speed_rad_s": run.order.centre.speed,
        "open_area_m2": float(np.interp(0.0, angle, table["effective_area_m2"])),
        "closing_factor": float(ramps.closing.coefficients[0]),
        "closing_factor_error": float(ramps.closing.half_widths[0]),
        "opening_factor": float(ramps.opening.coefficients[0]),
        "opening_factor_error": float(ramps.opening.half_widths[0]),
        "mean_opening_effective": float(effective.mean()),
        "mean_opening_formula": float(formula.mean()),
        "lag_rad": middle - expected,
        "mean_flow_m3_s": float(run.entering.mean()),
        "mean_torque_N_m": float(run.torque.mean()),
        "mean_torque_law_N_m": float(table["torque_law_N_m"].mean()),
        "mass_imbalance": float(abs(run.leaving - run.entering).mean() / run.entering.mean()),
        "begin_angle_rad": run.order.begin,
        "cells": float(run.solved.mesh.cells),
        "density_kg_m3": run.order.centre.fluid.density,
    }


def _chart() -> Chart:
    x = "spool_angle_rad"
    openings = (
        Line(x=x, y="opening_formula", colour=Colour.RELIEF),
        Line(x=x, y="opening_effective", colour=Colour.LOAD, width=2),
    )
    torques = (
        Line(x=x, y="torque_law_N_m", colour=Colour.RELIEF),
        Line(x=x, y="torque_N_m", colour=Colour.LOAD, width=2),
    )
    return Chart(
        name="period",
        caption="Left: open fraction of the nozzles by formula, and as the flow finds it. Right: torque on the spool, "
        "and "
        "that of the jets by the system's law for a spool at rest. Nozzles open at negative angles and close at "
        "positive ones.",
        table="angles",
        panels=(Lines(lines=openings, label="opening", low=0.0), Lines(lines=torques, label="torque")),
        side_by_side=True,
    )


def _findings(numbers: dict[str, float]) -> Iterator[Finding]:
    for way in ("closing", "opening"):
        factor, error = (number(numbers[key], 3) for key in (f"{way}_factor", f"{way}_factor_error"))
        yield Finding(text=f"While {way}, the effective opening is {factor} ± {error} times the formula.")
    change = numbers["mean_opening_effective"] / numbers["mean_opening_formula"] - 1.0
    yield Finding(text=f"Over the period the mean of the effective opening is {percent(change)} off the formula.")
    if numbers["mass_imbalance"] > BALANCED:
        text = f"{percent(numbers['mass_imbalance'])} of the flow are lost where the meshes slide."
        yield Finding(title="Flows do not balance", grade=Grade.WARNING, text=text, remedy="Take a finer grid.")
