"""The law of the jets' torque over the open fraction of the ports: exponent and asymmetry."""

from collections.abc import Mapping

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.errors import ParameterError
from vvdp.base.kinds import FLOW, FRACTION, NUMBER, TORQUE
from vvdp.fitting.fitted import Coefficient, Fitted, Host, around, around_log, valve_value
from vvdp.fitting.table import Quantity
from vvdp.fluid.oil import density
from vvdp.numerics.least_squares import Fit, fit
from vvdp.results.chart import Chart, Colour, Line, Lines, Stroke
from vvdp.results.result import Column, Table
from vvdp.valve.torque import inlet_torque

SIDES = {"closing": 1.0, "opening": -1.0, "": 0.0}
COLUMNS = {
    "opening": Quantity(FRACTION),
    "torque": Quantity(TORQUE),
    "flow": Quantity(FLOW, is_optional=True),
    "port": Quantity(NUMBER, is_optional=True, words=SIDES),
}
LINES = {"closing": (1.0, Colour.LOAD), "opening": (-1.0, Colour.TANK), "both": (0.0, Colour.LOAD)}

MOST_STEPS = 50
LEAST_FACTOR = 0.05
"""Of 1 +- eps (1 - a) on the way to the asymmetry: below it the logarithm has no meaning."""


def fit_jet(columns: Mapping[str, Array], host: Host | None) -> Fitted:
    """Exponent s and, where ports close and open, asymmetry eps of the jets' torque at constant flow.

    Torques at several flows are carried to the largest by its square. Raises ParameterError where the points do not
    distinguish the coefficients.
    """
    openings, flows = columns["opening"], columns.get("flow")
    sides = columns.get("port", np.zeros_like(openings))
    torques, flow = columns["torque"], None
    if flows is not None:
        flow = float(flows.max())
        torques = torques * (flow / flows) ** 2
    found = jet_law(openings, torques, sides)
    exponent = around(float(found.coefficients[1]), float(found.half_widths[1]))
    log_torque = float(found.coefficients[0]), float(found.half_widths[0])
    coefficients = {
        "coefficient": Coefficient(around_log(*log_torque), NUMBER, "torque of open ports, N m"),
        "exponent": Coefficient(exponent, NUMBER, "exponent s of the jets"),
    }
    written = {"jet_exponent": (exponent, "exponent of the jets")}
    if sides.any():
        asymmetry = around(float(found.coefficients[2]), float(found.half_widths[2]))
        coefficients["asymmetry"] = Coefficient(asymmetry, NUMBER, "asymmetry ε of the jets")
        written["jet_asymmetry"] = (asymmetry, "asymmetry of the jets")
    values = {key: valve_value(key, *each) for key, each in written.items()} if host else {}
    return Fitted(
        title="Torque of the jets over the opening",
        formula="T = c a⁻ˢ (1 ± ε (1 − a)) at constant flow, + while the port closes and − while it opens, fitted by "
        "least squares of the logarithm.",
        coefficients=coefficients,
        valve={key: value for key, (value, _) in values.items()},
        scatter=float(np.sqrt(np.mean(found.residuals**2))),
        points=_points(openings, torques, sides, found),
        curve=_curve(openings, sides, found, host, flow),
        chart=_chart(sides, has_law=host is not None and flow is not None),
        findings=tuple(each for _, said in values.values() for each in said),
    )


def jet_law(openings: Array, torques: Array, sides: Array) -> Fit:
    """The logarithm of T = T_0 a^-s (1 + eps (1 - a)) of closing ports, 1 - eps (1 - a) of opening ones.

    Coefficients log T_0, s and, unless all `sides` are 0, eps. By Gauss and Newton.

    openings  open fraction a, above 0 [1]
    torques   of the jets at constant flow [N m]
    sides     1 of a closing port, -1 of an opening one, 0 of the mean of both

    Raises ParameterError where the values do not show the coefficients apart, or no asymmetry fits.
    """
    seen = np.log(torques)
    if not sides.any():
        return fit(jet_columns(openings, sides, 0.0)[:2], seen)
    asymmetry = 0.0
    for _ in range(MOST_STEPS):
        columns, factor = jet_columns(openings, sides, asymmetry), 1.0 + sides * asymmetry * (1.0 - openings)
        found = fit(columns, seen - np.log(factor) + asymmetry * columns[2])
        step = float(found.coefficients[2]) - asymmetry
        if abs(step) < 1e-10:
            return found
        while (1.0 + sides * (asymmetry + step) * (1.0 - openings)).min() < LEAST_FACTOR:
            step *= 0.5
        asymmetry += step
    raise ParameterError("no asymmetry of the jets comes close to the torques while closing and while opening")


def jet_columns(openings: Array, sides: Array, asymmetry: float) -> list[Array]:
    """The slopes of the logarithm of `jet_law` over its coefficients at an asymmetry [1]."""
    skew = sides * (1.0 - openings)
    return [np.ones_like(openings), -np.log(openings), skew / (1.0 + asymmetry * skew)]


def _points(openings: Array, torques: Array, sides: Array, found: Fit) -> Table:
    law = torques / np.exp(found.residuals)
    words = {value: word for word, value in SIDES.items()}
    columns = {
        "opening": Column(openings, FRACTION, "open fraction"),
        "torque_N_m": Column(torques, TORQUE, "torque"),
        "fitted_N_m": Column(law, TORQUE, "law, fitted"),
        "distance": Column(torques / law - 1.0, NUMBER, "relative residual"),
    }
    if sides.any():
        columns = {"port": Column(np.array([words[side] for side in sides.tolist()]), None, "port"), **columns}
    return Table(title="Points", columns=columns)


def _drawn_sides(sides: Array) -> list[str]:
    """The sides of which a law is drawn: the mean of both only where there is nothing else."""
    return [name for name, (side, _) in LINES.items() if (sides == side).any() and (side or not sides.any())]


def _curve(openings: Array, sides: Array, found: Fit, host: Host | None, flow: float | None) -> Table:
    """The law and its band over the open fraction, for each side of which there are points."""
    shares = np.linspace(0.8 * openings.min(), 1.0, 61)
    columns = {"opening": Column(shares, FRACTION, "open fraction")}
    asymmetry = float(found.coefficients[2]) if len(found.coefficients) > 2 else 0.0
    for name in _drawn_sides(sides):
        side = np.full_like(shares, LINES[name][0])
        rows = jet_columns(shares, side, asymmetry)[: len(found.coefficients)]
        torque, exponent = found.coefficients[:2]
        law = torque - exponent * np.log(shares) + np.log(1.0 + side * asymmetry * (1.0 - shares))
        half = found.half_band(rows)
        word = "" if name == "both" else f", {name}"
        columns |= {
            f"{name}_N_m": Column(np.exp(law), TORQUE, f"law, fitted{word}"),
            f"{name}_low_N_m": Column(np.exp(law - half), TORQUE, f"band of 95 %, lower end{word}"),
            f"{name}_high_N_m": Column(np.exp(law + half), TORQUE, f"band of 95 %, upper end{word}"),
        }
        if host and flow is not None:
            law_torque = _law_torque(shares, float(side[0]), flow, host)
            columns[f"{name}_law_N_m"] = Column(law_torque, TORQUE, f"law of the system{word}")
    return Table(title="Law over the opening", columns=columns, is_data=True)


def _law_torque(shares: Array, side: float, flow: float, host: Host) -> Array:
    rho, valve = float(density(host.temperature, host.oil)), host.valve
    return np.array(
        [inlet_torque(flow / a, a, rho, valve, side * valve.jet_asymmetry * a * (1.0 - a)) for a in shares.tolist()]
    )


def _chart(sides: Array, *, has_law: bool) -> Chart:
    x, lines = "opening", []
    for name in _drawn_sides(sides):
        colour = LINES[name][1]
        word = "" if name == "both" else f", {name}"
        key, low, high = f"{name}_N_m", f"{name}_low_N_m", f"{name}_high_N_m"
        lines.append(Line(x=x, y=key, label=f"law, fitted{word}", table="curve", colour=colour, low=low, high=high))
        if has_law:
            label, key = f"law of the system{word}", f"{name}_law_N_m"
            lines.append(Line(x=x, y=key, label=label, table="curve", stroke=Stroke.DOTTED, colour=Colour.RELIEF))
    points = Line(x=x, y="torque_N_m", stroke=Stroke.POINTS, label="points", colour=Colour.INK, width=2)
    return Chart(
        name="fit",
        caption="Torque of the jets at the largest flow of the table, the law fitted to it with its band of 95 %"
        + (", and the law of the system." if has_law else "."),
        table="points",
        panels=(Lines(lines=(*lines, points), label="torque", low=0.0),),
    )
