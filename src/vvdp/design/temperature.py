"""The valve from cold to hot oil, and where on the way its model leaves the range in which it holds."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt

from vvdp.base.arrays import Array
from vvdp.base.errors import ParameterError
from vvdp.base.kinds import Kind, Ratio
from vvdp.base.params import Params
from vvdp.base.units import ATMOSPHERE
from vvdp.design.problem import require_flow, shown
from vvdp.design.quantities import KINDS, Setup, key, quantities, setup
from vvdp.fluid.oil import density, dynamic_viscosity
from vvdp.systems.bench import rotary_bench
from vvdp.systems.system import System
from vvdp.valve.bearing import bearing_eccentricity, bearing_force, radial_jet_force
from vvdp.valve.condition import Condition
from vvdp.valve.flow_map import averaged_spool_speed
from vvdp.valve.gap_flow import (
    carried_temperature_rise,
    cavitation_number,
    gap_reynolds_number,
    sheared_temperature_rise,
    taylor_number,
)
from vvdp.valve.operating_point import TURBULENT
from vvdp.valve.torque import pwm_frequency

_KELVIN = Kind("temperature difference", "K", -1e4, 1e4, "5 K")
TemperatureRise = Annotated[float, _KELVIN]
SpecificHeat = Annotated[float, Kind("specific heat", "J/(kg*K)", 1.0, 1e5, "1900 J/(kg*K)")]
ThermalConductivity = Annotated[float, Kind("thermal conductivity", "W/(m*K)", 1e-3, 1e3, "0.13 W/(m*K)")]
COLDEST, HOTTEST, STEP = 283.15, 353.15, 2.5


class RangeLimits(Params):
    """From where on the model is in doubt, and what is taken for what systems do not say.

    `specific_heat` and `thermal_conductivity` are those of mineral oil; `excess_share` is how much more than its share
    the strongest nozzle takes.
    """

    reynolds_number: Ratio = TURBULENT
    cavitation_number: Ratio = 0.4
    taylor_number: Ratio = 41.2
    temperature_rise: TemperatureRise = 5.0
    eccentricity: Ratio = 0.3
    excess_share: Ratio = 0.158
    specific_heat: SpecificHeat = 1900.0
    thermal_conductivity: ThermalConductivity = 0.13


ORIGINS: Mapping[str, str] = {
    "reynolds_number": "usual limit of turbulent flow in a duct",
    "cavitation_number": "assumed",
    "taylor_number": "taylor1923",
    "temperature_rise": "assumed; 5 K change the viscosity by about a fifth",
    "eccentricity": "assumed; the leakage of the lands then grows by 13 %",
    "excess_share": "wang2017, section 2.7: the strongest nozzle of the final design has 15.8 % more",
    "specific_heat": "assumed, mineral oil",
    "thermal_conductivity": "assumed, mineral oil",
}


@dataclass(frozen=True)
class Check:
    """A number that must stay on one side of a limit for the model to hold, over the temperatures."""

    name: str
    words: str
    kind: Kind
    values: Array
    limit: float
    at_least: bool
    otherwise: str

    @property
    def outside(self) -> npt.NDArray[np.bool_]:
        """Where the limit is not kept."""
        found: npt.NDArray[np.bool_] = self.values < self.limit if self.at_least else self.values > self.limit
        return found


@dataclass(frozen=True)
class OverTemperature:
    """Columns over the oil's temperatures [K], and the checks."""

    system: System
    temperatures: Array
    columns: Mapping[str, Array]
    kinds: Mapping[str, Kind]
    checks: tuple[Check, ...]
    limits: RangeLimits

    @property
    def warnings(self) -> list[str]:
        """A sentence for every check that is not kept somewhere."""
        return [_sentence(self.temperatures, check) for check in self.checks if np.any(check.outside)]


_NUMBER = Kind("number", "1", -1e12, 1e12, "1")
_HERTZ = KINDS["pwm_frequency"]
_WATT = KINDS["loss_total"]
_NEWTON = Kind("force", "N", -1e9, 1e9, "5 N")
_VISCOSITY = Kind("dynamic viscosity", "Pa*s", 0.0, 1e2, "0.0387 Pa*s")
SHOWN = (
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
        ends = ", ".join(f"{t - 273.15:g} degC" for t in (coldest, hottest))
        raise ParameterError(f"from, to: {ends}, in steps of {step:g} K; expected a range of temperatures")
    limits = limits or RangeLimits()
    steps = int(np.ceil((hottest - coldest) / step - 1e-9))
    temperatures: Array = np.linspace(coldest, hottest, steps + 1)
    at, bench = setup(system), rotary_bench(system, "design")
    rows: list[dict[str, float]] = []
    for temperature in temperatures:
        row = _row(at._replace(temperature=float(temperature)), limits, bench.limits.cavitation_pressure)
        rows.append(row)
        if progress:
            progress(len(rows), len(temperatures))
    columns = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    kinds = {name: KINDS.get(name, _EXTRA.get(name, _NUMBER)) for name in columns}
    return OverTemperature(
        system, temperatures, columns, kinds, _checks(columns, limits, bench.motor.rated_power, at), limits
    )


_EXTRA: Mapping[str, Kind] = {
    "pwm_frequency_averaged": _HERTZ,
    "viscosity": _VISCOSITY,
    "input_power": _WATT,
    "sheared_temperature_rise": _KELVIN,
    "carried_temperature_rise": _KELVIN,
    "radial_force": _NEWTON,
    "bearing_capacity": _NEWTON,
}
FULL = 0.9
"""Eccentricity at which the capacity of the lands is stated: close to touching."""


def _row(at: Setup, limits: RangeLimits, cavitation_pressure: float) -> dict[str, float]:
    valve, Q = at.valve, at.flow
    rho, mu = density(at.temperature, at.oil), dynamic_viscosity(at.temperature, at.oil)
    q = quantities(at)
    omega = 2.0 * np.pi * q.pwm_frequency / valve.sections
    averaged = q.pwm_frequency
    if at.coupling == 0.0:
        condition = Condition(
            flow=Q,
            load_pressure=at.load_pressure,
            relief_pressure=at.relief_pressure,
            tank_pressure=at.tank_pressure,
            density=rho,
        )
        averaged = pwm_frequency(averaged_spool_speed(at.duty_ratio, condition, mu, valve), valve)
    behind = q.pressure_drop_centre_section + q.pressure_drop_outlet_turbine
    force = radial_jet_force(Q, limits.excess_share, rho, valve)
    difference = at.load_pressure - at.tank_pressure
    return {
        **{name: float(getattr(q, name)) for name in SHOWN},
        "pwm_frequency_averaged": float(averaged),
        "viscosity": mu,
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


def _checks(columns: Mapping[str, Array], limits: RangeLimits, rated_power: float, at: Setup) -> tuple[Check, ...]:
    c = columns
    kappa = np.full_like(c["taylor_number"], float(quantities(at).transition_fraction))
    room = min(at.duty_ratio, 1.0 - at.duty_ratio)
    return (
        Check(
            "nozzle_reynolds_number", "Reynolds number of the nozzles", _NUMBER, c["nozzle_reynolds_number"],
            limits.reynolds_number, True, "a discharge coefficient from a turbulent model is uncertain",
        ),
        Check(
            "cavitation_number_open", "cavitation number of the nozzles, tank port open", _NUMBER,
            c["cavitation_number_open"], limits.cavitation_number, True,
            "air or vapour comes out behind the nozzles: less flow at the same drop, and erosion",
        ),
        Check(
            "cavitation_number_closing", "cavitation number of the nozzles while the tank port closes", _NUMBER,
            c["cavitation_number_closing"], limits.cavitation_number, True,
            "the closing port cavitates for part of every period, which the orifice law leaves out",
        ),
        Check(
            "taylor_number", "Taylor number of the clearance", _NUMBER, c["taylor_number"], limits.taylor_number,
            False, "vortices in the clearance: friction is above the linear law",
        ),
        Check(
            "sheared_temperature_rise", "warming of the film by its shear", _KELVIN, c["sheared_temperature_rise"],
            limits.temperature_rise, False, "the film is thinner than the oil's temperature says: less friction",
        ),
        Check(
            "carried_temperature_rise", "warming of the leaking oil, if it carries off all heat", _KELVIN,
            c["carried_temperature_rise"], limits.temperature_rise, False,
            "an upper bound, without the heat that goes into the walls: friction may be less, frequency and leakage "
            "more than shown",
        ),
        Check(
            "input_power", "power of the pump's motor", Kind("power", "W", 0.0, 1e9, "5.6 kW"), c["input_power"],
            rated_power, False, "the motor is overloaded",
        ),
        Check(
            "eccentricity", "eccentricity of the spool under the jets", _NUMBER, c["eccentricity"],
            limits.eccentricity, False, "the lands leak more than those of a centred spool and may touch",
        ),
        Check(
            "relief_margin", "relief setting above load and open drop", KINDS["relief_margin"],
            at.relief_pressure - at.load_pressure - c["pressure_drop_total"], 0.0, True,
            "the relief valve is open even with the load port fully open, and the analytic losses do not hold",
        ),
        Check(
            "transition_fraction", "transition fraction", _NUMBER, kappa, room, False,
            f"at duty ratio {at.duty_ratio:.4g} a port never opens fully: the analytic transition loss does not hold",
        ),
    )  # fmt: skip


def _sentence(temperatures: Array, check: Check) -> str:
    outside = np.flatnonzero(check.outside)
    values = check.values[outside]
    worst = float(np.min(values) if check.at_least else np.max(values))
    side = "below" if check.at_least else "above"
    number = shown(worst, check.kind, 3)
    extreme = "down to" if check.at_least else "up to"
    where, limit = _spans(temperatures, outside), shown(check.limit, check.kind, 4)
    return f"{check.words} {extreme} {number} {where}, {side} {limit}; {check.otherwise}"


def _spans(temperatures: Array, places: Any) -> str:
    """Runs of temperatures in words."""
    if len(places) == len(temperatures):
        return "at all temperatures"
    runs = np.split(places, np.flatnonzero(np.diff(places) > 1) + 1)
    ends = [(temperatures[run[0]] - 273.15, temperatures[run[-1]] - 273.15) for run in runs]
    return "at " + ", ".join(f"{a:.4g} degC" if a == b else f"{a:.4g} to {b:.4g} degC" for a, b in ends)


def temperature_columns(found: OverTemperature) -> dict[str, Array]:
    """All columns, SI units in the names."""
    return {"temperature_K": found.temperatures} | {
        key(name, found.kinds[name]): column for name, column in found.columns.items()
    }


def temperature_content(found: OverTemperature) -> dict[str, Any]:
    """The study as JSON can hold it."""
    at = setup(found.system)
    return {
        "system": found.system.name,
        "title": found.system.title,
        "flow_m3_s": at.flow,
        "duty_ratio": at.duty_ratio,
        "load_pressure_Pa": at.load_pressure - ATMOSPHERE,
        "relief_pressure_Pa": at.relief_pressure - ATMOSPHERE,
        "temperatures": found.temperatures.tolist(),
        "columns": {name: column.tolist() for name, column in found.columns.items()},
        "units": {name: kind.unit for name, kind in found.kinds.items()},
        "checks": [
            {
                "name": each.name, "words": each.words, "limit": shown(each.limit, each.kind, 4),
                "low": shown(float(np.min(each.values)), each.kind, 4),
                "high": shown(float(np.max(each.values)), each.kind, 4),
                "at_least": each.at_least, "outside": each.outside.tolist(),
            }
            for each in found.checks
        ],
        "warnings": found.warnings,
        "limits": [
            {"name": name, "value": getattr(found.limits, name), "origin": origin} for name, origin in ORIGINS.items()
        ],
    }  # fmt: skip


def by_temperature(found: OverTemperature, wanted: Sequence[float]) -> list[int]:
    """The rows closest to the temperatures `wanted` [K]."""
    return [int(np.argmin(np.abs(found.temperatures - t))) for t in wanted]
