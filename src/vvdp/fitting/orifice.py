"""The flow coefficient K of any restriction, Q = K sqrt(dp), and C_d of an orifice of known area."""

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from vvdp.base.arrays import Array
from vvdp.base.display import with_unit
from vvdp.base.errors import ParameterError
from vvdp.base.kinds import AREA, DENSITY, DISCHARGE_COEFFICIENT, FLOW_COEFFICIENT
from vvdp.base.params import Params, field_kinds
from vvdp.base.signal import Signal, signal_value
from vvdp.fitting.drop import COLUMNS, fit_drop
from vvdp.fitting.fitted import Coefficient, Fitted, around_log, power_of
from vvdp.fluid.oil import density
from vvdp.hydraulics.orifice import Orifice
from vvdp.network.network import Network
from vvdp.network.nodes import HydraulicNode
from vvdp.numerics.least_squares import fit
from vvdp.results.result import Finding, Grade

WITHOUT_DIAMETER = {key: quantity for key, quantity in COLUMNS.items() if key != "diameter"}
SHOWN = replace(FLOW_COEFFICIENT, example="2 lpm/bar^0.5")
"""A flow coefficient as data sheets of valves give it."""
CD, K = "discharge_coefficient", "flow_coefficient"
USUAL_TEMPERATURE = 313.15
"""Of the usual oil, if the oil that was measured is not stated [K]."""
KEYS = {CD: CD, K: "conductance"}
"""The fitted quantity, and the key of a component that takes it."""


class Restriction(NamedTuple):
    """A restriction that was measured [SI]; `part` and `values` are those of the component that takes the fit, `table`
    is that of the file in which they stand."""

    density: float
    area: float | None = None
    name: str = ""
    part: str = ""
    values: Params | None = None
    table: str = ""

    @property
    def conditions(self) -> dict[str, str]:
        """The basis of the fit, as text."""
        area = {"area": with_unit(self.area, AREA)} if self.area else {}
        return {"density": with_unit(self.density, DENSITY), **area}

    def present(self, key: str) -> float:
        """The value of the component that a fitted one takes the place of; nan without one."""
        return float(getattr(self.values, KEYS[key], np.nan))

    def place(self, key: str) -> str | None:
        """Where a system file has the value; None if the component takes another one."""
        taken = self.values is not None and KEYS[key] in field_kinds(type(self.values))
        return f"{self.table}.{KEYS[key]}" if taken else None


def restriction_of(network: Network, system: str, part: str, table: str) -> Restriction:
    """The values of a component of a circuit, in a `table` of its file.

    Raises ParameterError if it is neither an orifice nor has a `conductance`.
    """
    if part not in network.parts:
        raise ParameterError(f"{part!r} is no component of {system}; it has {', '.join(network.parts)}")
    own = network.parts[part]
    nodes = [network.nodes[own.nodes[port]] for port in own.component.hydraulic_ports]
    oils = [node.oil for node in nodes if isinstance(node, HydraulicNode)]
    taken = [each for each in own.values if isinstance(each, Orifice) or _has_conductance(each)]
    if not oils or not taken:
        raise ParameterError(f"{part}: a {own.component.name} has neither {CD} nor a conductance in m^3/(s*Pa^0.5)")
    source = own.inputs.get("area")
    area = float(signal_value(0.0, source)) if isinstance(source, Signal) else None
    temperature = float(signal_value(0.0, network.temperature))
    return Restriction(
        density=float(density(temperature, oils[0])), area=area, name=system, part=part, values=taken[0], table=table
    )


def _has_conductance(values: Params) -> bool:
    return field_kinds(type(values)).get(KEYS[K]) == FLOW_COEFFICIENT


def fit_orifice(columns: Mapping[str, Array], known: Restriction) -> Fitted:
    """K of Q = K sqrt(dp), each point by its relative distance, and C_d = K sqrt(rho/2)/A if the area is known.

    A C_d that no orifice has is a warning. Raises ParameterError for fewer than three points, and for such a C_d if a
    component is to take it.
    """
    flow, drop = columns["flow"], columns["pressure_drop"]
    mean = fit([np.ones_like(flow)], np.log(flow) - 0.5 * np.log(drop))
    k = around_log(float(mean.coefficients[0]), float(mean.half_widths[0]))
    values = {K: Coefficient(k, SHOWN, "flow coefficient K = Q/√Δp")}
    if known.area:
        cd = power_of(k, float(np.sqrt(0.5 * known.density)) / known.area, 1.0)
        values[CD] = Coefficient(cd, DISCHARGE_COEFFICIENT, "discharge coefficient")
        if not _is_plausible(cd.value):
            found = fit_drop(columns, values)
            return replace(found, findings=(*found.findings, _implausible(cd.value, known)))
    return fit_drop(columns, values)


def _is_plausible(cd: float) -> bool:
    return DISCHARGE_COEFFICIENT.low <= cd <= DISCHARGE_COEFFICIENT.high


def _implausible(cd: float, known: Restriction) -> Finding:
    """The warning of a C_d that no orifice has. Raises ParameterError if a component is to take it."""
    ends = f"{DISCHARGE_COEFFICIENT.low:g} to {DISCHARGE_COEFFICIENT.high:g}"
    text = f"The table gives C_d = {cd:.3f}, outside {ends}, with an area of {with_unit(known.area or 0.0, AREA)}."
    remedy = "Check the area, the density and the units of the table."
    if known.part:
        raise ParameterError(f"{known.part}: {text} {remedy}")
    return Finding(title="Discharge coefficient not plausible", grade=Grade.WARNING, text=text, remedy=remedy)


def key_line(found: Fitted) -> str:
    """The line of a system file with the coefficient that was fitted."""
    key = CD if CD in found.valve and _is_plausible(found.valve[CD].interval.value) else K
    unit = "" if key == CD else f" {SHOWN.unit}"
    return f'{KEYS[key]} = "{found.valve[key].interval.value:.4g}{unit}"'
