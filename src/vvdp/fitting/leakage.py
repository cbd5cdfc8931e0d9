"""The law of the leakage over the pressure difference: conductance, and the clearance that it comes from."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import number
from vvdp.base.errors import ParameterError
from vvdp.base.kinds import CONDUCTANCE, FLOW, NUMBER, PRESSURE_DIFFERENCE, TEMPERATURE
from vvdp.fitting.fitted import Coefficient, Fitted, Host, Interval, around, around_log, power_of, valve_value
from vvdp.fitting.table import DROP_COLUMN, Quantity
from vvdp.fluid.oil import film_viscosity
from vvdp.numerics.least_squares import Fit, fit
from vvdp.numerics.power_laws import power_columns, power_law
from vvdp.results.chart import Chart, Colour, Line, Lines, Stroke
from vvdp.results.result import Column, Finding, Grade, Table
from vvdp.valve.leakage import leakage_conductance

COLUMNS = {
    "pressure_drop": DROP_COLUMN,
    "leakage": Quantity(FLOW),
    "temperature": Quantity(TEMPERATURE, is_optional=True),
}


class Leaks(NamedTuple):
    """Measured leakages from a table [SI], at the viscosity of the operating point."""

    drop: Array
    flow: Array


def fit_leakage(columns: Mapping[str, Array], host: Host | None) -> Fitted:
    """Conductance and exponent of the leakage, and the radial clearance of the `host` that gives it.

    With a host each flow is carried to the viscosity at its operating point. Raises ParameterError where temperatures
    stand in the table and no host has an oil, or there are too few points.
    """
    if "temperature" in columns and not host:
        raise ParameterError("the table has a column temperature; --on SYSTEM is needed for the viscosity of its oil")
    seen = _at_one_viscosity(columns, host)
    power = power_law(seen.drop, seen.flow)
    slope = fit([np.ones_like(seen.drop)], np.log(seen.flow / seen.drop))
    conductance = around_log(float(slope.coefficients[0]), float(slope.half_widths[0]))
    factor, exponent = around_log(*_term(power, 0)), around(*_term(power, 1))
    coefficients = {
        "coefficient": Coefficient(factor, NUMBER, "coefficient c, SI"),
        "exponent": Coefficient(exponent, NUMBER, "exponent m of the pressure difference"),
        "conductance_m3_s_Pa": Coefficient(conductance, CONDUCTANCE, "conductance with the exponent 1"),
    }
    said = [*_not_laminar(exponent)]
    values = {}
    if host:
        values["radial_clearance"], outside = valve_value(
            "radial_clearance", power_of(conductance, _clearance_factor(host), 1.0 / 3.0), "radial clearance"
        )
        said += outside
    return Fitted(
        title="Leakage over the pressure difference",
        formula="Q = c Δpᵐ, fitted by least squares of the logarithm; laminar clearances have m = 1.",
        coefficients=coefficients,
        valve=values,
        scatter=float(np.sqrt(np.mean(power.residuals**2))),
        points=_points(seen, power),
        curve=_curve(seen, power, host),
        chart=_chart(host),
        findings=tuple(said),
    )


def _term(found: Fit, place: int) -> tuple[float, float]:
    return float(found.coefficients[place]), float(found.half_widths[place])


def _at_one_viscosity(columns: Mapping[str, Array], host: Host | None) -> Leaks:
    drop, flow = columns["pressure_drop"], columns["leakage"]
    if not host:
        return Leaks(drop, flow)
    temperatures = columns.get("temperature", np.full_like(drop, host.temperature))
    pairs = zip(temperatures.tolist(), drop.tolist(), strict=True)
    films = [film_viscosity(T, host.tank_pressure + dp, host.tank_pressure, host.oil) for T, dp in pairs]
    return Leaks(drop, flow * np.array(films) / _film(host))


def _film(host: Host) -> float:
    return float(film_viscosity(host.temperature, host.load_pressure, host.tank_pressure, host.oil))


def _clearance_factor(host: Host) -> float:
    """Clearance over the cube root of the conductance, which is proportional to its cube."""
    unit = replace(host.valve, radial_clearance=1e-5)
    return float(1e-5 / leakage_conductance(_film(host), unit) ** (1.0 / 3.0))


def _not_laminar(exponent: Interval) -> Iterator[Finding]:
    if not exponent.low <= 1.0 <= exponent.high:
        yield Finding(
            title="Not laminar",
            grade=Grade.WARNING,
            text=f"Leakage through narrow clearances goes with the pressure difference; the table has it to the power "
            f"{number(exponent.low, 3)} to {number(exponent.high, 3)}.",
            remedy="Look for another path, for oil that warms up, or for parts that give way.",
        )


def _points(seen: Leaks, power: Fit) -> Table:
    law = seen.flow / np.exp(power.residuals)
    columns = {
        "pressure_drop_Pa": Column(seen.drop, PRESSURE_DIFFERENCE, "pressure difference"),
        "leakage_m3_s": Column(seen.flow, FLOW, "leakage"),
        "fitted_m3_s": Column(law, FLOW, "law, fitted"),
        "distance": Column(seen.flow / law - 1.0, NUMBER, "relative residual"),
    }
    return Table(title="Points", columns=columns)


def _curve(seen: Leaks, power: Fit, host: Host | None) -> Table:
    drops = np.linspace(0.6 * seen.drop.min(), 1.1 * seen.drop.max(), 61)
    rows = power_columns(drops)
    law, half = np.column_stack(rows) @ power.coefficients, power.half_band(rows)
    columns = {
        "pressure_drop_Pa": Column(drops, PRESSURE_DIFFERENCE, "pressure difference"),
        "fitted_m3_s": Column(np.exp(law), FLOW, "law, fitted"),
        "low_m3_s": Column(np.exp(law - half), FLOW, "band of 95 %, lower end"),
        "high_m3_s": Column(np.exp(law + half), FLOW, "band of 95 %, upper end"),
    }
    if host:
        before = leakage_conductance(_film(host), host.valve) * drops
        columns["law_m3_s"] = Column(before, FLOW, "law of the system")
    return Table(title="Law over the pressure difference", columns=columns, is_data=True)


def _chart(host: Host | None) -> Chart:
    x = "pressure_drop_Pa"
    points = Line(x=x, y="leakage_m3_s", stroke=Stroke.POINTS, label="points", colour=Colour.INK, width=2)
    law = Line(
        x=x, y="fitted_m3_s", label="law, fitted", table="curve", low="low_m3_s", high="high_m3_s", colour=Colour.LOAD
    )
    before = Line(
        x=x, y="law_m3_s", label="law of the system", table="curve", stroke=Stroke.DOTTED, colour=Colour.RELIEF
    )
    lines = (law, *((before,) if host else ()), points)
    return Chart(
        name="fit",
        caption="Points of the table, the law fitted to them with its band of 95 %"
        + (", and the law of the system." if host else "."),
        table="points",
        panels=(Lines(lines=lines, label="leakage", low=0.0, left=0.0),),
    )
