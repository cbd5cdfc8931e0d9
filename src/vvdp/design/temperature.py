"""The valve from cold to hot oil, and where on the way its model leaves the range in which it holds."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from vvdp.base.arrays import Array
from vvdp.base.display import with_unit
from vvdp.base.errors import ParameterError
from vvdp.base.kinds import (
    NUMBER,
    POWER,
    TEMPERATURE,
    TEMPERATURE_DIFFERENCE,
    Kind,
    Ratio,
    SpecificHeat,
    TemperatureDifference,
    ThermalConductivity,
)
from vvdp.base.params import Params
from vvdp.design.problem import require_flow
from vvdp.design.quantities import KINDS, Setup, quantities, setup, switching_condition
from vvdp.evaluation.bench import rotary_bench
from vvdp.fluid.oil import density, dynamic_viscosity, film_viscosity
from vvdp.systems.system import System
from vvdp.valve.bearing import bearing_eccentricity, bearing_force, radial_jet_force
from vvdp.valve.flow_map import averaged_spool_speed
from vvdp.valve.gap_flow import (
    carried_temperature_rise,
    cavitation_number,
    gap_reynolds_number,
    sheared_temperature_rise,
    taylor_number,
)
from vvdp.valve.torque import pwm_frequency
from vvdp.valve.validity import CAVITATION_NUMBER, SHEAR_WARMING, TAYLOR_NUMBER, TURBULENT

COLDEST, HOTTEST, STEP = 283.15, 353.15, 2.5


class RangeLimits(Params):
    """From where on the model is in doubt, and what is taken for what systems do not say.

    `specific_heat` and `thermal_conductivity` are those of mineral oil; `excess_share` is how much more than its share
    the strongest nozzle takes.
    """

    reynolds_number: Ratio = TURBULENT
    cavitation_number: Ratio = CAVITATION_NUMBER
    taylor_number: Ratio = TAYLOR_NUMBER
    temperature_rise: TemperatureDifference = SHEAR_WARMING
    eccentricity: Ratio = 0.3
    excess_share: Ratio = 0.158
    specific_heat: SpecificHeat = 1900.0
    thermal_conductivity: ThermalConductivity = 0.13


ORIGINS: Mapping[str, str] = {
    "reynolds_number": "usual limit of turbulent flow in a duct",
    "cavitation_number": "assumed",
    "taylor_number": "taylor1923",
    "temperature_rise": "assumed; 5 K change the viscosity by about a fifth",
    "eccentricity": "assumed; leakage then grows by 13.5 %, friction by 5 %",
    "excess_share": "wang2017, section 2.7: the strongest nozzle of the final design has 15.8 % more",
    "specific_heat": "assumed, mineral oil",
    "thermal_conductivity": "assumed, mineral oil",
}


@dataclass(frozen=True)
class Check:
    """A number that must stay on one side of a limit for the model to hold, over the temperatures.

    `whole` is what a limit of zero is measured with.
    """

    name: str
    label: str
    kind: Kind
    values: Array
    limit: float
    at_least: bool
    otherwise: str
    whole: float = 0.0

    @property
    def outside(self) -> npt.NDArray[np.bool_]:
        """Where the limit is not kept."""
        found: npt.NDArray[np.bool_] = self.values < self.limit if self.at_least else self.values > self.limit
        return found

    @property
    def usage(self) -> Array:
        """How much of the limit is used up: above 1 the model is in doubt."""
        if self.whole:
            return 1.0 - self.values / self.whole
        return self.limit / self.values if self.at_least else self.values / self.limit


@dataclass(frozen=True)
class OverTemperature:
    """Columns over the oil's temperatures [K], and the checks."""

    system: System
    temperatures: Array
    columns: Mapping[str, Array]
    checks: tuple[Check, ...]
    limits: RangeLimits

    @property
    def warnings(self) -> list[str]:
        """A sentence for every check that is not kept somewhere."""
        return [_sentence(self.temperatures, check) for check in self.checks if np.any(check.outside)]


QUANTITIES = (
    "pressure_drop_total",
    "pwm_frequency",
    "loss_full_open",
    "loss_transition",
    "loss_leakage",
    "loss_compressibility",
    "spool_drive_power",
    "loss_total",
    "efficiency",
    "leakage_flow",
    "load_flow",
)


def over_temperature(
    system: System,
    *,
    coldest: float = COLDEST,
    hottest: float = HOTTEST,
    step: float = STEP,
    limits: RangeLimits | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> OverTemperature:
    """The valve of a system over the temperature of its oil [K], both ends included, all else as at the start of a run.

    The steps are even, and at most `step`.
    Raises ParameterError where the temperatures make no range, ConfigError where nothing flows through the valve.
    """
    require_flow(system)
    if not (200.0 <= coldest < hottest <= 450.0 and step > 0.0):
        ends = ", ".join(with_unit(t, TEMPERATURE) for t in (coldest, hottest))
        raise ParameterError(f"from, to: {ends}, in steps of {step:g} K; expected a range of temperatures")
    limits = limits or RangeLimits()
    steps = int(np.ceil((hottest - coldest) / step - 1e-9))
    temperatures: Array = np.linspace(coldest, hottest, steps + 1)
    at, bench = setup(system), rotary_bench(system, "design")
    rows: list[dict[str, float]] = []
    for temperature in temperatures:
        row = _row(at._replace(temperature=float(temperature)), limits, bench.cavitation_pressure)
        rows.append(row)
        if progress:
            progress(len(rows), len(temperatures))
    columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    checks = _checks(columns, limits, bench.rated_power, at)
    return OverTemperature(system, temperatures, columns, checks, limits)


FULL = 0.9
"""Eccentricity at which the capacity of the lands is stated: close to touching."""


def _row(at: Setup, limits: RangeLimits, cavitation_pressure: float) -> dict[str, float]:
    valve, Q, rho = at.valve, at.flow, density(at.temperature, at.oil)
    mu = film_viscosity(at.temperature, at.load_pressure, at.tank_pressure, at.oil)
    q = quantities(at)
    omega = 2.0 * np.pi * q.pwm_frequency / valve.sections
    averaged = q.pwm_frequency
    if at.coupling == 0.0:
        condition = switching_condition(at)
        averaged = pwm_frequency(averaged_spool_speed(at.duty_ratio, condition, mu, valve), valve)
    behind = q.pressure_drop_centre_section + q.pressure_drop_outlet_turbine
    force = radial_jet_force(Q, limits.excess_share, rho, valve)
    difference = at.load_pressure - at.tank_pressure
    return {
        **{name: float(getattr(q, name)) for name in QUANTITIES},
        "pwm_frequency_averaged": float(averaged),
        "viscosity": dynamic_viscosity(at.temperature, at.oil),
        "input_power": float(q.input_power),
        "nozzle_reynolds_number": float(q.nozzle_reynolds_number),
        "cavitation_number_open": cavitation_number(
            at.tank_pressure + q.pressure_drop_total, at.tank_pressure + behind, cavitation_pressure
        ),
        "cavitation_number_closing": cavitation_number(at.relief_pressure, at.tank_pressure, cavitation_pressure),
        "gap_reynolds_number": gap_reynolds_number(omega, rho, mu, valve),
        "taylor_number": taylor_number(omega, rho, mu, valve),
        "sheared_temperature_rise": sheared_temperature_rise(omega, mu, limits.thermal_conductivity, valve),
        "carried_temperature_rise": carried_temperature_rise(
            q.spool_friction_power, difference, q.leakage_flow, rho, limits.specific_heat
        ),
        "radial_force": float(force),
        "bearing_capacity": bearing_force(FULL, omega, mu, valve),
        "eccentricity": float(bearing_eccentricity(force, omega, mu, valve)),
    }


class _Demand(NamedTuple):
    """Demand of a check: its label, the consequence if it is not kept, and its kind."""

    label: str
    otherwise: str
    kind: Kind = NUMBER
    at_least: bool = False


_DEMANDS = {
    "nozzle_reynolds_number": _Demand(
        "Reynolds number of the nozzles",
        "a discharge coefficient from a turbulent model is uncertain",
        at_least=True,
    ),
    "cavitation_number_open": _Demand(
        "cavitation number, tank port open",
        "air or vapour comes out behind the nozzles: less flow at the same drop, and erosion",
        at_least=True,
    ),
    "cavitation_number_closing": _Demand(
        "cavitation number, tank port closing",
        "the closing port cavitates for part of every period, which the orifice law leaves out",
        at_least=True,
    ),
    "taylor_number": _Demand(
        "Taylor number of the clearance", "vortices in the clearance: friction is above the linear law"
    ),
    "sheared_temperature_rise": _Demand(
        "warming of the film by its shear",
        "the film is thinner than the oil's temperature says: less friction",
        TEMPERATURE_DIFFERENCE,
    ),
    "carried_temperature_rise": _Demand(
        "warming of the leaking oil, at most",
        "an upper bound, without the heat that goes into the walls: friction may be less, frequency and leakage more "
        "than shown",
        TEMPERATURE_DIFFERENCE,
    ),
    "input_power": _Demand("power of the pump's motor", "the motor is overloaded", POWER),
    "eccentricity": _Demand(
        "eccentricity of the spool", "leakage and friction are above those of a centred spool, and the lands may touch"
    ),
    "relief_margin": _Demand(
        "relief setting above load and open drop",
        "the relief valve is open even with the load port fully open, and the analytic losses do not hold",
        KINDS["relief_margin"],
        at_least=True,
    ),
    "transition_fraction": _Demand(
        "transition fraction",
        "a port never opens fully at this duty ratio: the analytic transition loss does not hold",
    ),
}


def _checks(columns: Mapping[str, Array], limits: RangeLimits, rated_power: float, at: Setup) -> tuple[Check, ...]:
    margin = at.relief_pressure - at.load_pressure - columns["pressure_drop_total"]
    fraction = np.full_like(margin, float(quantities(at).transition_fraction))
    values = {**columns, "relief_margin": margin, "transition_fraction": fraction}
    ends = {
        "nozzle_reynolds_number": limits.reynolds_number,
        "cavitation_number_open": limits.cavitation_number,
        "cavitation_number_closing": limits.cavitation_number,
        "taylor_number": limits.taylor_number,
        "sheared_temperature_rise": limits.temperature_rise,
        "carried_temperature_rise": limits.temperature_rise,
        "input_power": rated_power,
        "eccentricity": limits.eccentricity,
        "relief_margin": 0.0,
        "transition_fraction": min(at.duty_ratio, 1.0 - at.duty_ratio),
    }
    return tuple(
        Check(
            name=name,
            label=each.label,
            kind=each.kind,
            values=values[name],
            limit=ends[name],
            at_least=each.at_least,
            otherwise=each.otherwise,
            whole=at.relief_pressure if name == "relief_margin" else 0.0,
        )
        for name, each in _DEMANDS.items()
    )


def _sentence(temperatures: Array, check: Check) -> str:
    values = check.values[check.outside]
    worst = with_unit(float(np.min(values) if check.at_least else np.max(values)), check.kind, 3)
    extreme, side = ("down to", "below") if check.at_least else ("up to", "above")
    where, limit = temperature_spans(temperatures, check.outside), with_unit(check.limit, check.kind, 4)
    return f"{check.label}: {extreme} {worst} {where}, {side} {limit}; {check.otherwise}"


def temperature_spans(temperatures: Array, where: npt.NDArray[np.bool_]) -> str:
    """The temperatures [K] at which something holds, in words."""
    if np.all(where):
        return "at all temperatures"
    places = np.flatnonzero(where)
    runs = np.split(places, np.flatnonzero(np.diff(places) > 1) + 1)
    ends = [tuple(with_unit(float(temperatures[k]), TEMPERATURE) for k in (run[0], run[-1])) for run in runs]
    return "at " + ", ".join(a if a == b else f"{a} to {b}" for a, b in ends)
