"""Pressure drop of the rotary valve and its sections against flow, in the manner of ISO 4411."""

import itertools
import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from vvdp.base.arrays import Array
from vvdp.fluid.oil import density, dynamic_viscosity
from vvdp.rigs.conditions import BAR, CELSIUS, LPM, conditions, span
from vvdp.rigs.result import Column, RigResult, Sheet
from vvdp.steady.test_stand import Stand
from vvdp.valve.branch import turbulent_drops
from vvdp.valve.operating_point import TURBULENT, nozzle_reynolds_number

OPENINGS = (1.0, 0.5, 0.25)
MANNER = (
    "Differential pressure over flow in the manner of ISO 4411, for the whole valve from the inlet rail to an outlet "
    "port and for its sections in series: nozzles, centre section, outlet turbine. The spool stands still with the "
    "ports at a fixed open fraction; the branches to load and tank have the same law."
)
LEFT_OUT = (
    "Pipes and fittings between the pressure taps, whose own drop a test subtracts.",
    "The swirl of a turning spool, and the drop of the outlet rail unless a rail coefficient is given.",
    "The transition to a linear law at very small drops, which keeps the simulation smooth at zero flow.",
    "Viscosity: the section's coefficients were found at one; only the density follows the temperature.",
    "Leakage past the spool.",
)


def default_flows(stand: Stand, count: int = 31) -> tuple[float, ...]:
    """From a thirtieth of one and a half times the pump flow up to it [m^3/s]."""
    most = 1.5 * stand.pump_flow(stand.set_point)
    return tuple(float(q) for q in np.linspace(most / (count - 1), most, count - 1))


def pressure_drop(
    stand: Stand,
    flows: Sequence[float] | None = None,
    temperatures: Sequence[float] | None = None,
    openings: Sequence[float] = OPENINGS,
) -> RigResult:
    """Drops of the valve's sections [Pa] at each temperature [K], open fraction [1] and flow [m^3/s].

    Source  wang2017, eqs. 2.3 to 2.5, in the manner of iso4411
    """
    began = time.perf_counter()
    flows = tuple(flows or default_flows(stand))
    temperatures = tuple(temperatures or (stand.set_point.oil_temperature,))
    points = np.array(list(itertools.product(temperatures, openings, flows)), float)
    t, a, q = _formulas(points.T)
    oil, valve = stand.bench.oil, stand.bench.valve
    rho, mu = density(t, oil), dynamic_viscosity(t, oil)
    drops: Any = turbulent_drops(q, a, rho, valve)
    total: Any = drops.nozzle + drops.centre_section + drops.outlet_turbine
    reynolds: Any = nozzle_reynolds_number(q, rho, mu, valve)
    columns = {
        "oil_temperature_K": Column(t, "K", "oil"),
        "opening": Column(a, "", "open fraction"),
        "flow_m3_s": Column(q, "m^3/s", "flow"),
        "pressure_drop_nozzle_Pa": Column(drops.nozzle, "Pa", "nozzles"),
        "pressure_drop_centre_section_Pa": Column(drops.centre_section, "Pa", "centre section"),
        "pressure_drop_outlet_turbine_Pa": Column(drops.outlet_turbine, "Pa", "outlet turbine"),
        "pressure_drop_total_Pa": Column(total, "Pa", "whole valve"),
        "loss_W": Column(total * q, "W", "power lost"),
        "nozzle_reynolds_number": Column(reynolds, "", "Reynolds number"),
    }
    numbers = _numbers(stand, t, a, q, total)
    return RigResult(
        rig="pressure-drop",
        title="Pressure drop of the valve against flow",
        system=stand.name,
        manner=MANNER,
        references=("iso4411",),
        conditions={
            "fluid": conditions(stand)["fluid"],
            "temperature": span(temperatures, 1.0, "°C", CELSIUS),
            "flow": span(flows, LPM, "lpm"),
            "open fraction": ", ".join(f"{x:.3g}" for x in openings),
        },
        left_out=LEFT_OUT,
        sheets={"pressure-drop": Sheet("Pressure drop and flow", columns)},
        numbers=numbers,
        findings=_findings(numbers, columns),
        seconds=time.perf_counter() - began,
    )


def _formulas(columns: Any) -> tuple[Any, ...]:
    """Columns as formulas take them: written for floats, they work on arrays too."""
    return tuple(columns)


def _numbers(stand: Stand, t: Array, a: Array, q: Array, total: Array) -> dict[str, float]:
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
    widest = (a == a.max()) & (t == t[0])
    if np.count_nonzero(widest) > 1:
        slope, _ = np.polyfit(np.log(q[widest]), np.log(total[widest]), 1)
        found["flow_exponent"] = float(slope)
    return found


def _findings(numbers: dict[str, float], columns: dict[str, Column]) -> tuple[str, ...]:
    total = numbers["pressure_drop_total_Pa"]
    parts = ", ".join(
        f"{words} {100.0 * numbers[f'pressure_drop_{name}_Pa'] / total:.0f} %"
        for name, words in (("nozzle", "nozzles"), ("centre_section", "centre section"), ("outlet_turbine", "outlet"))
    )
    sentences = [
        f"At the pump flow of {numbers['flow_m3_s'] / LPM:.4g} lpm the open valve takes {total / BAR:.4g} bar: {parts}."
    ]
    if "flow_exponent" in numbers:
        sentences.append(f"Its drop grows with the flow to the power {numbers['flow_exponent']:.3g}.")
    reynolds: Any = columns["nozzle_reynolds_number"].values
    if np.any(reynolds < TURBULENT):
        sentences.append(
            f"The Reynolds number of the nozzles is {np.min(reynolds):.3g} to {np.max(reynolds):.4g}: below "
            f"{TURBULENT:.0f} a discharge coefficient from a turbulent model is uncertain."
        )
    return tuple(sentences)
