"""Flow through an outlet turbine over flow and speed, as a result: torque, drops, and their laws."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import number, percent, with_unit
from vvdp.base.kinds import (
    AREA,
    COUNT,
    DENSITY,
    EFFICIENCY,
    FLOW,
    NUMBER,
    PRESSURE_DIFFERENCE,
    SPEED,
    TORQUE,
    Kind,
)
from vvdp.cfd.rail_result import METHOD, Told
from vvdp.cfd.state_table import QUALITY, quality_listings, restless_findings, state_columns
from vvdp.cfd.turbine import TurbineOrder
from vvdp.cfd.turbine_study import TurbineRun
from vvdp.geometry.result import origin_rows
from vvdp.numerics.least_squares import Fit, fit
from vvdp.results.chart import Chart, Colour, Line, Lines, Stroke
from vvdp.results.result import Column, Finding, Listing, Result, Section, Table, listing_of, numbers_of
from vvdp.valve.torque import outlet_torque

VERB = "cfd turbine"
FRAME = (
    "The oil within the spool's radius is solved in the frame that turns with the spool, which stands at one angle to "
    "the collector: what the passing of the channels does to the flow is left out. Torque is fitted by the square of "
    "the flow, and flow times speed."
)
LENGTHS = (
    "None of these is published. Arm and entry taper of the channels were chosen so that flow simulation of a turbine "
    "with another chamber gave the published torque and drop, so both are calibrated; the fall with the speed is not."
)
SHOWN_LENGTHS = ("outlet_", "chamber_", "collector_", "groove_", "port_")
SLOPE = Kind("torque over speed", "N*m*s", -1e6, 1e6, "1e-4 N*m*s")
RAIL = Kind("quadratic flow resistance", "Pa*s^2/m^6", 0.0, 1e18, "2e10 Pa*s^2/m^6")
QUANTITIES = {
    "flow_m3_s": (FLOW, "flow, the largest"),
    "torque_at_rest_N_m": (TORQUE, "torque at rest, fitted"),
    "torque_at_rest_error_N_m": (TORQUE, "half of its interval"),
    "torque_slope_N_m_s": (SLOPE, "torque over speed, fitted"),
    "torque_slope_error_N_m_s": (SLOPE, "half of its interval"),
    "torque_slope_law_N_m_s": (SLOPE, "torque over speed by the system's own law"),
    "effective_area_m2": (AREA, "effective area of the jets"),
    "effective_area_law_m2": (AREA, "effective area of the system"),
    "turbine_drop_Pa": (PRESSURE_DIFFERENCE, "drop of the turbine, slowest run"),
    "collector_drop_Pa": (PRESSURE_DIFFERENCE, "drop of collector and port, slowest run"),
    "rail_coefficient_Pa_s2_m6": (RAIL, "drop of collector and port over the square of the flow"),
    "discharge_coefficient": (NUMBER, "discharge coefficient of the turbine"),
    "discharge_coefficient_law": (NUMBER, "discharge coefficient of the system"),
    "momentum_imbalance": (EFFICIENCY, "largest difference of the torque by angular momentum"),
    "cells": (COUNT, "cells"),
    "density_kg_m3": (DENSITY, "density"),
}


def turbine_result(runs: Sequence[TurbineRun], told: Told) -> Result:
    """The result of runs at several speeds and one flow or more; its sections name drawings that the page has.

    Raises ParameterError where there are fewer than three.
    """
    order = max((run.order for run in runs), key=lambda each: each.flow)
    table = _runs(runs)
    flows, speeds = table["flow_m3_s"], table["speed_rad_s"]
    law = fit([flows**2, flows * speeds], table["torque_N_m"])
    line = law.scale(np.array([order.flow**2, order.flow]))
    numbers = _numbers(order, table, line)
    span = " to ".join(with_unit(each, FLOW) for each in sorted({flows.min(), flows.max()}))
    return Result(
        verb=VERB,
        title="Torque of the outlet turbine over the speed",
        system=told.system,
        manner=f"{METHOD} {FRAME}",
        references=told.sources,
        conditions=told.conditions({"flow": span}, order),
        left_out=("Centre section and windows upstream: the oil enters the chamber along the axis, without swirl.",
                  "Leakage, cavitation, and the warming of the oil."),
        numbers=numbers_of(numbers, QUANTITIES),
        listings={
            "fits": listing_of(numbers, QUANTITIES), "lengths": turbine_lengths(told),
            **quality_listings(_names(runs), [run.solved for run in runs]),
        },
        tables={"runs": table, "line": _line(order, speeds, line)},
        charts={"torque-over-speed": _chart()},
        findings=tuple(_findings(order, numbers, runs)),
        sections=(
            Section(title="Torque and drop", words=(FRAME,), shows=("fits", "torque-over-speed", "runs")),
            Section(title="The turbine", words=(LENGTHS,), shows=("geometry", "lengths"), starts_page=True),
            Section(title="The flow", shows=("sections", "streamlines"), starts_page=True),
            QUALITY,
            Section(title="How it was done", words=(METHOD,), shows=("conditions",)),
        ),
        seconds=sum(run.seconds for run in runs),
    )  # fmt: skip


def _runs(runs: Sequence[TurbineRun]) -> Table:
    total = np.array([run.solved.judgement.value for run in runs])
    behind = np.array([run.behind for run in runs])
    columns = {
        "flow_m3_s": Column(np.array([run.order.flow for run in runs]), FLOW, "flow"),
        "speed_rad_s": Column(np.array([run.order.speed for run in runs]), SPEED, "spool speed"),
        "torque_N_m": Column(np.array([run.torques.forces for run in runs]), TORQUE, "torque"),
        "torque_spread_N_m": Column(np.array([run.torques.spread for run in runs]), TORQUE, "its range"),
        "torque_momentum_N_m": Column(
            np.array([run.torques.momentum for run in runs]), TORQUE, "torque by angular momentum"
        ),
        "torque_law_N_m": Column(np.array([_law(run.order) for run in runs]), TORQUE, "law of the system"),
        "turbine_drop_Pa": Column(total - behind, PRESSURE_DIFFERENCE, "drop of the turbine"),
        "collector_drop_Pa": Column(behind, PRESSURE_DIFFERENCE, "drop of the collector"),
        "cells": Column(np.array([float(run.solved.mesh.cells) for run in runs]), COUNT, "cells"),
        **state_columns([run.solved for run in runs]),
    }
    return Table(title="Runs", columns=columns, axes=("flow_m3_s", "speed_rad_s"))


def _names(runs: Sequence[TurbineRun]) -> list[str]:
    return [f"{with_unit(run.order.flow, FLOW)}, {with_unit(run.order.speed, SPEED)}" for run in runs]


def _law(order: TurbineOrder) -> float:
    return outlet_torque(order.flow, order.speed, order.fluid.density, order.valve)


def _numbers(order: TurbineOrder, table: Table, line: Fit) -> dict[str, float]:
    """Torque rho R Q^2 / A_eff - rho R^2 Q omega; drop of the turbine rho Q^2 / (2 Cd^2 A^2), of the rail k Q^2."""
    valve, density, flow = order.valve, order.fluid.density, order.flow
    (at_rest, slope), (at_rest_error, slope_error) = line.coefficients.tolist(), line.half_widths.tolist()
    drop, behind = (_over_square(table, key) for key in ("turbine_drop_Pa", "collector_drop_Pa"))
    radius = valve.outlet_radius
    return {
        "flow_m3_s": flow,
        "torque_at_rest_N_m": at_rest,
        "torque_at_rest_error_N_m": at_rest_error,
        "torque_slope_N_m_s": slope,
        "torque_slope_error_N_m_s": slope_error,
        "torque_slope_law_N_m_s": -density * radius**2 * flow,
        "effective_area_m2": density * radius * flow**2 / at_rest,
        "effective_area_law_m2": valve.outlet_effective_area,
        "turbine_drop_Pa": drop * flow**2,
        "collector_drop_Pa": behind * flow**2,
        "rail_coefficient_Pa_s2_m6": behind,
        "discharge_coefficient": 1.0 / valve.outlet_area / math.sqrt(2.0 * drop / density),
        "discharge_coefficient_law": valve.outlet_discharge_coefficient,
        "momentum_imbalance": float(np.max(abs(table["torque_momentum_N_m"] / table["torque_N_m"] - 1.0))),
        "cells": float(table["cells"][0]),
        "density_kg_m3": density,
    }


def _over_square(table: Table, key: str) -> float:
    """Of the slowest runs, a drop over the square of the flow by least squares [Pa s^2/m^6]."""
    speeds = np.abs(table["speed_rad_s"])
    slowest = speeds == speeds.min()
    square = table["flow_m3_s"][slowest] ** 2
    return float(square @ table[key][slowest] / (square @ square))


def turbine_lengths(told: Told) -> Listing:
    """The lengths of an outlet turbine with their origin."""
    rows = [row for row in told.rows if row.key.startswith(SHOWN_LENGTHS)]
    return Listing(title="", heads=("value",), rows=origin_rows(rows))


def _line(order: TurbineOrder, speeds: Array, line: Fit) -> Table:
    """The fitted line and the law of the system over the speed."""
    over = np.linspace(min(0.0, float(speeds.min())), 1.05 * float(speeds.max()), 2)
    at_rest, slope = line.coefficients
    return Table(
        title="Laws over the speed",
        columns={
            "speed_rad_s": Column(over, SPEED, "spool speed"),
            "fitted_N_m": Column(at_rest + slope * over, TORQUE, "straight line, fitted"),
            "law_N_m": Column(
                np.array([_law(order._replace(speed=speed)) for speed in over.tolist()]), TORQUE, "law of the system"
            ),
        },
        is_data=True,
    )


def _chart() -> Chart:
    x = "speed_rad_s"
    lines = (
        Line(x=x, y="fitted_N_m", label="straight line, fitted", table="line", colour=Colour.LOAD),
        Line(x=x, y="law_N_m", label="law of the system", table="line", colour=Colour.RELIEF, stroke=Stroke.DOTTED),
        Line(x=x, y="torque_N_m", label="computed", colour=Colour.INK, stroke=Stroke.POINTS, width=2),
    )
    drops = (
        Line(x=x, y="turbine_drop_Pa", colour=Colour.LOAD, stroke=Stroke.POINTS, width=2),
        Line(x=x, y="collector_drop_Pa", colour=Colour.TANK, stroke=Stroke.POINTS, width=2),
    )
    return Chart(
        name="torque-over-speed",
        caption="Left: torque of the outlet turbine on the spool, with its law at the largest flow. Right: drop of the "
        "turbine, from its chamber to the walls of the collector, and that of collector and port.",
        table="runs",
        panels=(Lines(lines=lines, label="torque", low=0.0), Lines(lines=drops, label="pressure drop", low=0.0)),
        side_by_side=True,
    )


def _findings(order: TurbineOrder, numbers: dict[str, float], runs: Sequence[TurbineRun]) -> Iterator[Finding]:
    at_rest = with_unit(numbers["torque_at_rest_N_m"], TORQUE)
    areas = [with_unit(numbers[key], AREA, 3) for key in ("effective_area_m2", "effective_area_law_m2")]
    yield Finding(
        text=f"At {with_unit(order.flow, FLOW)} the torque at rest is {at_rest}, as of jets with an effective area of "
        f"{areas[0]}; the system has {areas[1]}."
    )
    ratio = numbers["torque_slope_N_m_s"] / numbers["torque_slope_law_N_m_s"]
    yield Finding(text=f"It falls with the speed {number(ratio, 3)} times as fast as the law of the system says.")
    found, given = numbers["discharge_coefficient"], numbers["discharge_coefficient_law"]
    yield Finding(
        text=f"The turbine takes {with_unit(numbers['turbine_drop_Pa'], PRESSURE_DIFFERENCE)}, a discharge coefficient "
        f"of {number(found, 3)} where the system has {number(given, 3)}; collector and port take "
        f"{with_unit(numbers['collector_drop_Pa'], PRESSURE_DIFFERENCE)} more."
    )
    off = percent(numbers["momentum_imbalance"])
    yield Finding(text=f"By angular momentum the torque is up to {off} off that of pressure and friction on the spool.")
    yield from restless_findings([run.solved for run in runs])


def fitted_settings(result: Result) -> tuple[str, ...]:
    """Effective area and discharge coefficient that were found, as settings of a system with their origin."""
    numbers = {key: each.value for key, each in result.numbers.items()}
    made = result.conditions
    note = f"fitted to computed flow, {made['flow']}, {made['turbulence']}, {numbers['cells']:.0f} cells"
    values = {
        "outlet_effective_area": f"{1e6 * numbers['effective_area_m2']:.6g} mm^2",
        "outlet_discharge_coefficient": f"{numbers['discharge_coefficient']:.6g}",
        "rail_coefficient": f"{numbers['rail_coefficient_Pa_s2_m6']:.6g} Pa*s^2/m^6",
    }
    return tuple(f'valve.{key}={{value="{text}", status="derived", note="{note}"}}' for key, text in values.items())
