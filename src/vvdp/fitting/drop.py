"""The law of a drop over the flow, and over the spool diameter where there are several: m, n, k and C_d."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import number
from vvdp.base.kinds import FLOW, LENGTH, NUMBER, PRESSURE_DIFFERENCE
from vvdp.fitting.fitted import Coefficient, Fitted, Host, Interval, around, around_log, power_of, valve_value
from vvdp.fitting.table import DROP_COLUMN, FLOW_COLUMN, Quantity
from vvdp.fluid.oil import density
from vvdp.numerics.least_squares import Fit, fit
from vvdp.numerics.power_laws import drop_laws, power_columns
from vvdp.results.chart import Chart, Colour, Line, Lines, Stroke
from vvdp.results.result import Column, Finding, Grade, Table
from vvdp.valve.branch import turbulent_drops

COLUMNS = {
    "flow": FLOW_COLUMN,
    "pressure_drop": DROP_COLUMN,
    "diameter": Quantity(LENGTH, is_optional=True),
}
Valued = dict[str, Coefficient]


@dataclass(frozen=True)
class Drops:
    """Measured drops from a table [SI]; one diameter for all where the table has none."""

    flow: Array
    drop: Array
    diameter: Array | None

    def columns(self) -> list[Array]:
        """Summands of the logarithm of the drop: 1, log Q and -log D."""
        return power_columns(self.flow) + ([-np.log(self.diameter)] if self.diameter is not None else [])


def fit_drop(columns: Mapping[str, Array], values: Valued) -> Fitted:
    """The power law of a drop beside `values` that were fitted for the square of the flow.

    Raises ParameterError where there are too few points.
    """
    seen, found = _power(columns)
    return _drop_law(seen, found, None, "", values, [*_depends_on_flow(found)])


MOST_OFF_SQUARE = 0.1
"""Distance of the exponent from 2 from which on a flow coefficient changes by more than 12 % over a decade of flow."""


def _depends_on_flow(found: Fit) -> Iterator[Finding]:
    value, low, high = _at(found, 1)
    if not low <= 2.0 <= high and abs(value - 2.0) > MOST_OFF_SQUARE:
        yield Finding(
            title="The coefficient depends on the flow",
            grade=Grade.WARNING,
            text=f"The pressure drop grows with the flow to the power {number(low, 3)} to {number(high, 3)}; an "
            "orifice has 2, a laminar path 1.",
            remedy="Fit only the flows that are used; for a power near 1 use a laminar-gap instead.",
        )


def fit_nozzle(columns: Mapping[str, Array], host: Host | None) -> Fitted:
    """The drop of the nozzles: its discharge coefficient on the area of the `host`.

    Raises ParameterError where there are too few points.
    """
    area = host.valve.nozzle_area if host else 0.0
    return _orifice(columns, host, "nozzle", area, 0.0)


def fit_outlet(columns: Mapping[str, Array], host: Host | None) -> Fitted:
    """The drop of an outlet turbine with its rail: its discharge coefficient on the area of the `host`.

    Raises ParameterError where there are too few points.
    """
    area, rail = (host.valve.outlet_area, host.valve.rail_coefficient) if host else (0.0, 0.0)
    return _orifice(columns, host, "outlet", area, rail)


def fit_centre(columns: Mapping[str, Array], host: Host | None) -> Fitted:
    """The drop of the centre section: m, n and k of Q^m/(k D^n), n that of the `host` unless diameters differ.

    Raises ParameterError where there are too few points.
    """
    seen, found = _power(columns)
    values: Valued = {}
    said: list[Finding] = []
    if host:
        exponent, outside = valve_value("centre_flow_exponent", _alone(found, 1), "flow exponent of the centre section")
        said += outside
        if seen.diameter is not None:
            values["centre_diameter_exponent"], outside = valve_value(
                "centre_diameter_exponent", _alone(found, 2), "diameter exponent of the centre section"
            )
            said += outside
        values = {"centre_flow_exponent": exponent, **values}
        values["centre_coefficient"], outside = _centre_coefficient(seen, host, values)
        said += outside
    return _drop_law(seen, found, host, "centre section", values, said)


def _centre_coefficient(seen: Drops, host: Host, values: Valued) -> tuple[Coefficient, tuple[Finding, ...]]:
    """k with the exponents as they are written: the mean of the logarithm of Q^m/(drop D^n)."""
    m = values["centre_flow_exponent"].interval.value
    written = values.get("centre_diameter_exponent")
    n = written.interval.value if written else host.valve.centre_diameter_exponent
    D = seen.diameter if seen.diameter is not None else np.full_like(seen.flow, 2.0 * host.valve.spool_radius)
    mean = fit([np.ones_like(seen.flow)], m * np.log(seen.flow) - np.log(seen.drop) - n * np.log(D))
    k = around_log(float(mean.coefficients[0]), float(mean.half_widths[0]))
    return valve_value("centre_coefficient", k, "coefficient of the centre section")


def _orifice(columns: Mapping[str, Array], host: Host | None, part: str, area: float, rail: float) -> Fitted:
    """C_d of c Q^2 = (rho / (2 (C_d A)^2) + k_rail) Q^2, from the orifice law that comes closest to all drops."""
    seen, found = _power(columns)
    if not host:
        return _drop_law(seen, found, None, part, {}, [])
    orifice = drop_laws(seen.flow, seen.drop).orifice
    c = around(float(orifice.coefficients[0]) - rail, float(orifice.half_widths[0]))
    factor = np.sqrt(0.5 * float(density(host.temperature, host.oil))) / area
    name = f"{part}_discharge_coefficient"
    label = "discharge coefficient of the " + {"nozzle": "nozzles", "outlet": "outlet turbine"}[part]
    value, said = valve_value(name, power_of(c, float(factor), -0.5), label)
    return _drop_law(seen, found, host, part, {name: value}, [*said, *_not_quadratic(found)])


def _not_quadratic(found: Fit) -> Iterator[Finding]:
    low, high = _at(found, 1)[1:]
    if not low <= 2.0 <= high:
        yield Finding(
            title="Not quadratic",
            grade=Grade.WARNING,
            text=f"The law of this part has the flow squared; the table has it to the power {number(low, 3)} to "
            f"{number(high, 3)}.",
            remedy="The discharge coefficient is ruled by the largest flows; take those of use.",
        )


def _power(columns: Mapping[str, Array]) -> tuple[Drops, Fit]:
    seen = Drops(columns["flow"], columns["pressure_drop"], columns.get("diameter"))
    return seen, fit(seen.columns(), np.log(seen.drop))


def _at(found: Fit, place: int) -> Interval:
    return around(float(found.coefficients[place]), float(found.half_widths[place]))


def _alone(found: Fit, place: int) -> Interval:
    """An exponent of the valve without its interval, within which k would have to move along."""
    return Interval(float(found.coefficients[place]), np.nan, np.nan)


def _drop_law(seen: Drops, found: Fit, host: Host | None, part: str, values: Valued, said: list[Finding]) -> Fitted:
    coefficients = {
        "coefficient": Coefficient(
            around_log(float(found.coefficients[0]), float(found.half_widths[0])), NUMBER, "coefficient c, SI"
        ),
        "exponent": Coefficient(_at(found, 1), NUMBER, "exponent m of the flow"),
    }
    if seen.diameter is not None:
        coefficients["diameter_exponent"] = Coefficient(_at(found, 2), NUMBER, "exponent n of the diameter")
    law = "Δp = c Qᵐ/Dⁿ" if seen.diameter is not None else "Δp = c Qᵐ"
    points = _points(seen, found)
    return Fitted(
        title="Pressure drop over the flow",
        formula=f"{law}, fitted by least squares of the logarithm, so that each point counts by its relative distance.",
        coefficients=coefficients,
        valve=values,
        scatter=float(np.sqrt(np.mean(found.residuals**2))),
        points=points,
        curve=_curve(seen, found, host, part),
        chart=_chart(host),
        findings=tuple(said),
    )


def _points(seen: Drops, found: Fit) -> Table:
    law = seen.drop / np.exp(found.residuals)
    columns = {
        "flow_m3_s": Column(seen.flow, FLOW, "flow"),
        "pressure_drop_Pa": Column(seen.drop, PRESSURE_DIFFERENCE, "pressure drop"),
        "fitted_Pa": Column(law, PRESSURE_DIFFERENCE, "law, fitted"),
        "distance": Column(seen.drop / law - 1.0, NUMBER, "relative residual"),
    }
    if seen.diameter is not None:
        columns = {"diameter_m": Column(seen.diameter, LENGTH, "spool diameter"), **columns}
    return Table(title="Points", columns=columns)


def _curve(seen: Drops, found: Fit, host: Host | None, part: str) -> Table:
    """The law and its band over the flow, at the middle diameter where there are several."""
    flows = np.linspace(0.6 * seen.flow.min(), 1.1 * seen.flow.max(), 61)
    middle = None if seen.diameter is None else np.full_like(flows, np.median(seen.diameter))
    rows = Drops(flows, flows, middle).columns()
    law, half = np.column_stack(rows) @ found.coefficients, found.half_band(rows)
    columns = {
        "flow_m3_s": Column(flows, FLOW, "flow"),
        "fitted_Pa": Column(np.exp(law), PRESSURE_DIFFERENCE, "law, fitted"),
        "low_Pa": Column(np.exp(law - half), PRESSURE_DIFFERENCE, "band of 95 %, lower end"),
        "high_Pa": Column(np.exp(law + half), PRESSURE_DIFFERENCE, "band of 95 %, upper end"),
    }
    if host:
        drops = [turbulent_drops(float(q), 1.0, float(density(host.temperature, host.oil)), host.valve) for q in flows]
        place = ("nozzle", "centre section", "outlet").index(part)
        before = np.array([each[place] for each in drops])
        columns["law_Pa"] = Column(before, PRESSURE_DIFFERENCE, "law of the system")
    return Table(title="Law over the flow", columns=columns, is_data=True)


def _chart(host: Host | None) -> Chart:
    points = Line(x="flow_m3_s", y="pressure_drop_Pa", stroke=Stroke.POINTS, label="points", colour=Colour.INK, width=2)
    law = Line(
        x="flow_m3_s",
        y="fitted_Pa",
        label="law, fitted",
        table="curve",
        low="low_Pa",
        high="high_Pa",
        colour=Colour.LOAD,
    )
    before = Line(
        x="flow_m3_s", y="law_Pa", label="law of the system", table="curve", stroke=Stroke.DOTTED, colour=Colour.RELIEF
    )
    lines = (law, *((before,) if host else ()), points)
    return Chart(
        name="fit",
        caption="Points of the table, the law fitted to them with its band of 95 %"
        + (", and the law of the system." if host else "."),
        table="points",
        panels=(Lines(lines=lines, label="pressure drop", low=0.0, left=0.0),),
    )
