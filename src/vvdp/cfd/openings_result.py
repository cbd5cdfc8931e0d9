"""Partly open nozzles: effective area and torque over the spool angle, while closing and while opening."""

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
    FLOW,
    FRACTION,
    LENGTH,
    NUMBER,
    SIGNED_PRESSURE,
    TORQUE,
)
from vvdp.cfd.centre import CentreOrder
from vvdp.cfd.centre_result import LENGTHS, centre_lengths
from vvdp.cfd.centre_study import CentreRun
from vvdp.cfd.rail_result import METHOD, Told
from vvdp.cfd.state_table import QUALITY, quality_listings, restless_findings, state_columns
from vvdp.numerics.least_squares import fit
from vvdp.results.chart import Chart, Colour, Line, Lines, Stroke
from vvdp.results.result import Column, Finding, Result, Section, Table, listing_of, numbers_of
from vvdp.valve.geometry import jet_skews, port_openings, port_shape
from vvdp.valve.torque import inlet_torque

VERB = "cfd openings"
STANDING = (
    "The spool stands still at each angle. At a positive angle the load's barriers close over the nozzles, coming from "
    "upstream of the oblique jets; at the negative one they open them. The effective opening is the flow over the root "
    "of the total drop, over the same of open nozzles; the formula is the open fraction of the nozzles' area."
)
JETS = (
    "Exponent and asymmetry of the jets are fitted to the torque at constant flow, which the law has as a^-s times "
    "1 + eps (1 - a) while closing, 1 - eps (1 - a) while opening."
)
QUANTITIES = {
    "flow_m3_s": (FLOW, "flow"),
    "stub_length_m": (LENGTH, "length of the nozzles"),
    "open_area_m2": (AREA, "effective area of open nozzles"),
    "closing_difference": (EFFICIENCY, "effective opening against the formula, closing, mean"),
    "opening_difference": (EFFICIENCY, "effective opening against the formula, opening, mean"),
    "jet_exponent": (NUMBER, "exponent of the jets, fitted"),
    "jet_exponent_error": (NUMBER, "half of its interval"),
    "jet_exponent_law": (NUMBER, "exponent of the system"),
    "jet_asymmetry": (NUMBER, "asymmetry of the jets, fitted"),
    "jet_asymmetry_error": (NUMBER, "half of its interval"),
    "jet_asymmetry_law": (NUMBER, "asymmetry of the system"),
    "density_kg_m3": (DENSITY, "density"),
}


def both_ways(angles: Sequence[float]) -> tuple[float, ...]:
    """Spool angles to be computed: 0, then each of `angles` [rad] while closing and while opening."""
    return (0.0, *(sign * angle for angle in angles for sign in (1.0, -1.0)))


def openings_result(runs: Sequence[CentreRun], told: Told) -> Result:
    """The result of runs at the angles of `both_ways`, two or more each way.

    Raises ParameterError where there are fewer.
    """
    order = runs[0].order
    table = _angles(runs)
    numbers = _numbers(order, table)
    return Result(
        verb=VERB,
        title="Partly open nozzles",
        system=told.system,
        manner=f"{METHOD} {STANDING}",
        references=told.sources,
        conditions=told.conditions({"flow": with_unit(order.flow, FLOW)}, order),
        left_out=("The turning of the spool: what it does to a jet within a transition.",
                  "Rail and nozzles upstream, leakage, cavitation."),
        numbers=numbers_of(numbers, QUANTITIES),
        listings={
            "fits": listing_of(numbers, QUANTITIES), "lengths": centre_lengths(told),
            **quality_listings([with_unit(run.order.angle, ANGLE) for run in runs], [run.solved for run in runs]),
        },
        tables={
            "angles": table,
        },
        charts={"opening-over-angle": _chart()},
        findings=tuple(_findings(numbers, runs)),
        sections=(
            Section(title="Openings and jets", words=(STANDING, JETS), shows=("fits", "opening-over-angle", "angles")),
            Section(title="The open section", words=(LENGTHS,), shows=("geometry", "lengths"), starts_page=True),
            Section(title="The flow through open nozzles", shows=("sections", "streamlines"), starts_page=True),
            QUALITY,
            Section(title="How it was done", words=(METHOD,), shows=("conditions",)),
        ),
        seconds=math.fsum(run.seconds for run in runs),
    )  # fmt: skip


def _angles(runs: Sequence[CentreRun]) -> Table:
    order, density = runs[0].order, runs[0].order.fluid.density
    angles = np.array([run.order.angle for run in runs])
    drops = np.array([run.solved.judgement.value for run in runs])
    formula = np.array([port_openings(angle, order.position, order.valve).load for angle in angles.tolist()])
    area = order.flow / np.sqrt(2.0 * drops / density)
    law = [_law_torque(order, angle, share) for angle, share in zip(angles.tolist(), formula.tolist(), strict=True)]
    columns = {
        "spool_angle_rad": Column(angles, ANGLE, "spool angle"),
        "opening_formula": Column(formula, FRACTION, "opening, formula"),
        "opening_effective": Column(area / area[0], FRACTION, "opening, effective"),
        "difference": Column(area / area[0] / formula - 1.0, EFFICIENCY, "difference"),
        "total_drop_Pa": Column(drops, SIGNED_PRESSURE, "total drop"),
        "effective_area_m2": Column(area, AREA, "effective area"),
        "torque_N_m": Column(np.array([run.torque for run in runs]), TORQUE, "torque"),
        "torque_law_N_m": Column(np.array(law), TORQUE, "torque, law of the system"),
        "cells": Column(np.array([float(run.solved.mesh.cells) for run in runs]), COUNT, "cells"),
        **state_columns([run.solved for run in runs]),
    }
    return Table(title="Angles", columns=columns)


def _law_torque(order: CentreOrder, angle: float, opening: float) -> float:
    valve = order.valve
    skew = jet_skews(angle, order.position, valve.jet_asymmetry, port_shape(valve)).load
    return inlet_torque(order.flow / opening, opening, order.fluid.density, valve, skew)


def _numbers(order: CentreOrder, table: Table) -> dict[str, float]:
    """At constant flow T = T0 a^-s (1 +- eps (1 - a)): the mean of both ways gives s, their difference eps."""
    torque, difference, valve = table["torque_N_m"], table["difference"], order.valve
    share: Array = table["opening_formula"][1::2]
    closing, opening = torque[1::2], torque[2::2]
    exponent = fit([-np.log(share)], np.log(0.5 * (closing + opening) / torque[0]))
    asymmetry = fit([1.0 - share], (closing - opening) / (closing + opening))
    return {
        "flow_m3_s": order.flow,
        "stub_length_m": order.stub * valve.spool_radius,
        "open_area_m2": float(table["effective_area_m2"][0]),
        "closing_difference": float(difference[1::2].mean()),
        "opening_difference": float(difference[2::2].mean()),
        "jet_exponent": float(exponent.coefficients[0]),
        "jet_exponent_error": float(exponent.half_widths[0]),
        "jet_exponent_law": valve.jet_exponent,
        "jet_asymmetry": float(asymmetry.coefficients[0]),
        "jet_asymmetry_error": float(asymmetry.half_widths[0]),
        "jet_asymmetry_law": valve.jet_asymmetry,
        "density_kg_m3": order.fluid.density,
    }


def _chart() -> Chart:
    x = "spool_angle_rad"
    openings = (
        Line(x=x, y="opening_formula", stroke=Stroke.POINTS, colour=Colour.RELIEF),
        Line(x=x, y="opening_effective", stroke=Stroke.POINTS, colour=Colour.LOAD, width=2),
    )
    torques = (
        Line(x=x, y="torque_law_N_m", stroke=Stroke.POINTS, colour=Colour.RELIEF),
        Line(x=x, y="torque_N_m", stroke=Stroke.POINTS, colour=Colour.LOAD, width=2),
    )
    return Chart(
        name="opening-over-angle",
        caption="Left: open fraction of the nozzles by formula, and as the flow finds it. Right: torque of the jets at "
        "constant flow. Nozzles close at positive angles and open at negative ones.",
        table="angles",
        panels=(Lines(lines=openings, label="opening", low=0.0), Lines(lines=torques, label="torque", low=0.0)),
        side_by_side=True,
    )


def _findings(numbers: dict[str, float], runs: Sequence[CentreRun]) -> Iterator[Finding]:
    closing, opening = (percent(numbers[f"{way}_difference"], 0) for way in ("closing", "opening"))
    yield Finding(text=f"The effective opening is {closing} off the formula while closing, {opening} while opening.")
    for name, words in (("jet_exponent", "exponent"), ("jet_asymmetry", "asymmetry")):
        found, error, given = (number(numbers[key], 3) for key in (name, f"{name}_error", f"{name}_law"))
        yield Finding(text=f"The {words} of the jets is {found} ± {error}; the system has {given}.")
    yield from restless_findings([run.solved for run in runs])
