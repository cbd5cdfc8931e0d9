"""Pressure drop of the rotary valve and its sections against flow, based on ISO 4411."""

import itertools
import time
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import number, percent, plain, with_unit
from vvdp.base.kinds import FLOW, FRACTION, MEAN_POWER, NUMBER, PRESSURE_DIFFERENCE, TEMPERATURE
from vvdp.fluid.oil import density, dynamic_viscosity
from vvdp.results.chart import Chart, Colour, Line, Lines, Stroke, shades
from vvdp.results.result import Column, Finding, Result, Table, numbers_of
from vvdp.rigs.conditions import axis_words, conditions
from vvdp.steady.test_stand import Stand
from vvdp.valve.branch import turbulent_drops
from vvdp.valve.operating_point import nozzle_reynolds_number
from vvdp.valve.validity import TURBULENT

DROPS = "pressure-drop"
"""Name of the table of all drops."""
OPENINGS = (1.0, 0.5, 0.25)
MANNER = (
    "Differential pressure over flow, based on ISO 4411, for the whole valve from the inlet rail to an outlet "
    "port and for its sections in series: nozzles, centre section, outlet turbine. The spool stands still with the "
    "ports at a fixed open fraction; the branches to load and tank have the same law."
)
LEFT_OUT = (
    "Pipes and fittings between the pressure taps, whose own drop a test subtracts.",
    "The swirl of a turning spool, and the drop of the outlet rail unless a rail coefficient is given.",
    "The transition to a linear law at very small drops, which keeps the simulation smooth at zero flow.",
    "Viscosity: the coefficients of the sections hold for one viscosity; only the density follows the temperature.",
    "Leakage past the spool.",
)
SECTIONS = {
    "total": ("whole valve", Colour.INK),
    "nozzle": ("nozzles", Colour.INLET),
    "outlet_turbine": ("outlet turbine", Colour.TANK),
    "centre_section": ("centre section", Colour.LOAD),
}
QUANTITIES = {
    "flow_m3_s": (FLOW, "pump flow"),
    **{f"pressure_drop_{name}_Pa": (PRESSURE_DIFFERENCE, label) for name, (label, _) in SECTIONS.items()},
    "flow_exponent": (NUMBER, "exponent of the flow in the pressure drop"),
}
STROKES = (Stroke.SOLID, Stroke.DASHED, Stroke.DOTTED)


def default_flows(stand: Stand, count: int = 31) -> tuple[float, ...]:
    """From a thirtieth of one and a half times the pump flow up to it [m^3/s]."""
    most = 1.5 * stand.pump_flow(stand.set_point)
    return tuple(float(q) for q in np.linspace(most / (count - 1), most, count - 1))


def pressure_drop(
    stand: Stand,
    flows: Sequence[float] | None = None,
    temperatures: Sequence[float] | None = None,
    openings: Sequence[float] = OPENINGS,
) -> Result:
    """Drops of the valve's sections [Pa] at each temperature [K], open fraction [1] and flow [m^3/s].

    Source  wang2017, eqs. 2.3 to 2.5, based on iso4411
    """
    began = time.perf_counter()
    flows = tuple(flows or default_flows(stand))
    temperatures = tuple(temperatures or (stand.set_point.oil_temperature,))
    table = _table(stand, np.array(list(itertools.product(temperatures, openings, flows)), float).T)
    numbers = _numbers(stand, table)
    return Result(
        verb="rig pressure-drop",
        title="Pressure drop of the valve against flow",
        system=stand.name,
        manner=MANNER,
        references=("iso4411",),
        conditions={
            "fluid": conditions(stand)["fluid"],
            "temperature": axis_words(temperatures, TEMPERATURE),
            "flow": axis_words(flows, FLOW),
            "open fraction": ", ".join(plain(x, 3) for x in openings),
        },
        left_out=LEFT_OUT,
        tables={DROPS: table},
        charts={"drop-over-flow": _chart(table)},
        numbers=numbers_of(numbers, QUANTITIES),
        findings=tuple(_findings(numbers, table)),
        seconds=time.perf_counter() - began,
    )


def _table(stand: Stand, points: Any) -> Table:
    """Temperatures, open fractions and flows, and what the valve does there. Formulas for floats take arrays too."""
    t, a, q = points
    oil, valve = stand.bench.oil, stand.bench.valve
    rho, mu = density(t, oil), dynamic_viscosity(t, oil)
    drops: Any = turbulent_drops(q, a, rho, valve)
    total: Any = drops.nozzle + drops.centre_section + drops.outlet_turbine
    reynolds: Any = nozzle_reynolds_number(q, rho, mu, valve)
    return Table(
        title="Pressure drop and flow",
        columns={
            "oil_temperature_K": Column(t, TEMPERATURE, "oil temperature"),
            "opening": Column(a, FRACTION, "open fraction"),
            "flow_m3_s": Column(q, FLOW, "flow"),
            "pressure_drop_nozzle_Pa": Column(drops.nozzle, PRESSURE_DIFFERENCE, "nozzles"),
            "pressure_drop_centre_section_Pa": Column(drops.centre_section, PRESSURE_DIFFERENCE, "centre section"),
            "pressure_drop_outlet_turbine_Pa": Column(drops.outlet_turbine, PRESSURE_DIFFERENCE, "outlet turbine"),
            "pressure_drop_total_Pa": Column(total, PRESSURE_DIFFERENCE, "whole valve"),
            "loss_W": Column(total * q, MEAN_POWER, "power lost"),
            "nozzle_reynolds_number": Column(reynolds, NUMBER, "Reynolds number"),
        },
        axes=("flow_m3_s", "oil_temperature_K", "opening"),
    )


def _numbers(stand: Stand, table: Table) -> dict[str, float]:
    """The drop at the pump flow and its parts, and the power law that comes closest to the open valve."""
    here = stand.set_point
    flow, oil, valve = stand.pump_flow(here), stand.bench.oil, stand.bench.valve
    drops = turbulent_drops(flow, 1.0, float(density(here.oil_temperature, oil)), valve)
    found = {
        "flow_m3_s": flow,
        "pressure_drop_nozzle_Pa": float(drops.nozzle),
        "pressure_drop_centre_section_Pa": float(drops.centre_section),
        "pressure_drop_outlet_turbine_Pa": float(drops.outlet_turbine),
        "pressure_drop_total_Pa": float(drops.nozzle + drops.centre_section + drops.outlet_turbine),
    }
    widest = _rows(table, table["oil_temperature_K"][0], table["opening"].max())
    if len(widest) > 1:
        q, total = (np.log(table[key][widest]) for key in ("flow_m3_s", "pressure_drop_total_Pa"))
        found["flow_exponent"] = float(np.polyfit(q, total, 1)[0])
    return found


def _rows(table: Table, temperature: float, opening: float) -> list[int]:
    there = (table["oil_temperature_K"] == temperature) & (table["opening"] == opening)
    return [int(row) for row in np.flatnonzero(there)]


def _chart(table: Table) -> Chart:
    temperatures: Array = np.unique(table["oil_temperature_K"])
    openings: Array = np.unique(table["opening"])[::-1]
    opened = tuple(_rows(table, temperatures[0], openings[0]))
    sections = (
        Line(x="flow_m3_s", y=f"pressure_drop_{name}_Pa", rows=opened, colour=colour)
        for name, (_, colour) in SECTIONS.items()
    )
    whole = (
        Line(
            x="flow_m3_s",
            y="pressure_drop_total_Pa",
            label=plain(opening, 3) + (f" at {with_unit(t, TEMPERATURE)}" if temperatures.size > 1 else ""),
            rows=tuple(_rows(table, t, opening)),
            colour=colour,
            stroke=STROKES[place % len(STROKES)],
        )
        for opening, colour in zip(openings, shades(openings.size)[::-1], strict=True)
        for place, t in enumerate(temperatures)
    )
    return Chart(
        name="drop-over-flow",
        caption="Left: the open valve and its sections in series. Right: the whole valve at fixed open fractions.",
        table=DROPS,
        panels=(
            Lines(lines=tuple(sections), label="pressure drop", low=0.0, left=0.0),
            Lines(lines=tuple(whole), label="pressure drop", legend="open fraction", low=0.0, left=0.0),
        ),
        side_by_side=True,
    )


def _findings(numbers: dict[str, float], table: Table) -> Iterator[Finding]:
    total = numbers["pressure_drop_total_Pa"]
    parts = ", ".join(
        f"{words} {percent(numbers[f'pressure_drop_{name}_Pa'] / total, 0)}"
        for name, words in (("nozzle", "nozzles"), ("centre_section", "centre section"), ("outlet_turbine", "outlet"))
    )
    flow, drop = with_unit(numbers["flow_m3_s"], FLOW), with_unit(total, PRESSURE_DIFFERENCE)
    yield Finding(text=f"At the pump flow of {flow} the open valve takes {drop}: {parts}.")
    if "flow_exponent" in numbers:
        yield Finding(text=f"Its drop grows with the flow to the power {number(numbers['flow_exponent'], 3)}.")
    reynolds: Array = table["nozzle_reynolds_number"]
    if np.any(reynolds < TURBULENT):
        ends = f"{plain(reynolds.min(), 3)} to {plain(reynolds.max(), 4)}"
        yield Finding(
            text=f"The Reynolds number of the nozzles is {ends}: below {TURBULENT:.0f} a discharge coefficient from a "
            "turbulent model is uncertain."
        )
