"""Conditions of a test in words: fluid, temperature, operating points."""

from collections.abc import Iterator, Sequence

from vvdp.base import kinds
from vvdp.base.display import plain, with_unit
from vvdp.fluid.oil import density, dynamic_viscosity
from vvdp.results.result import Finding, Grade
from vvdp.steady.steady_states import Steady
from vvdp.steady.test_stand import Stand


def conditions(stand: Stand) -> dict[str, str]:
    """Fluid, temperature, pump, relief setting, spool drive, load and motor of a stand, as a reader wants them."""
    here, bench = stand.set_point, stand.bench
    oil, relief = bench.oil, bench.relief_valve
    override = with_unit(relief.override_pressure, kinds.PRESSURE_DIFFERENCE) + " override"
    return {
        "fluid": f"{fluid(stand)}, {plain(100.0 * oil.air_fraction, 3)} % free air, "
        f"bulk modulus {with_unit(oil.liquid_bulk_modulus, kinds.BULK_MODULUS)} without it",
        "temperature": with_unit(here.oil_temperature, kinds.TEMPERATURE),
        "pump": f"{with_unit(bench.pump.displacement, kinds.DISPLACEMENT)} at "
        f"{with_unit(here.pump_speed, kinds.SPEED, 5)}, {with_unit(stand.pump_flow(here), kinds.FLOW)}",
        "motor": with_unit(bench.rated_power, kinds.POWER),
        "relief valve": f"{with_unit(stand.relief_pressure, kinds.PRESSURE_LEVEL)}, "
        f"{override if relief.override_pressure > 0.0 else 'ideal'}",
        "tank": with_unit(stand.tank_pressure, kinds.PRESSURE_LEVEL),
        "spool": "driven by a motor" if stand.is_driven else "spun by the flow",
        "load": _load(stand),
    }


def _load(stand: Stand) -> str:
    line = stand.bench.load_line
    if line is None:
        return "a source that holds its pressure"
    precharge = with_unit(line.precharge_pressure, kinds.PRESSURE_LEVEL)
    gas = f", {with_unit(line.gas_volume, kinds.VOLUME)} gas at {precharge}"
    return f"line of {with_unit(line.oil_volume, kinds.VOLUME)}{gas if line.gas_volume > 0.0 else ''}, then an orifice"


def fluid(stand: Stand) -> str:
    """Density and kinematic viscosity of the oil at the stand's temperature, in words."""
    oil, temperature = stand.bench.oil, stand.set_point.oil_temperature
    rho = float(density(temperature, oil))
    nu = float(dynamic_viscosity(temperature, oil)) / rho
    words = f"{with_unit(nu, kinds.KINEMATIC_VISCOSITY)} and {with_unit(rho, kinds.DENSITY)}"
    return f"{words} at {with_unit(temperature, kinds.TEMPERATURE)}"


def limit_findings(stand: Stand) -> Iterator[Finding]:
    """Effects in the system that no quasi-steady average contains, a warning each."""
    for limit in stand.bench.unit.average_limits():
        yield Finding(
            text=f"The averages do not hold: {limit}.",
            grade=Grade.WARNING,
            title="Analytic averages not applicable",
            remedy="Simulate it.",
        )


def within_validity(states: Sequence[Steady]) -> list[float]:
    """For each state whether all laws are within their range there, 0 where one is not."""
    return [float(state.summary.get("within_validity", 1.0)) for state in states]


def validity_findings(flags: Sequence[float]) -> Iterator[Finding]:
    """A warning where a law is used outside its range; a flag for each point, 0 where one is."""
    outside = sum(flag == 0.0 for flag in flags)
    if outside:
        yield Finding(
            text=f"At {outside} of {len(flags)} points a law is used outside its range.",
            grade=Grade.WARNING,
            title="Outside the range of a law",
            remedy="`vvdp run` at such a point names the law.",
        )


def axis_words(values: Sequence[float], kind: kinds.Kind) -> str:
    """An axis in words: its value, or its ends and how many values there are."""
    if len(values) == 1:
        return with_unit(values[0], kind, 5)
    first, last = (with_unit(value, kind, 5) for value in (values[0], values[-1]))
    return f"{first.partition(' ')[0]} to {last}, {len(values)} values"
