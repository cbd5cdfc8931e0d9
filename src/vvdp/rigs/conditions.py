"""What a test was made under, in words: fluid, temperature, set points."""

import numpy as np

from vvdp.base.units import ATMOSPHERE
from vvdp.fluid.oil import density, dynamic_viscosity
from vvdp.steady.test_stand import Stand

BAR, LPM, RPM, CELSIUS = 1e5, 1e-3 / 60.0, 2.0 * np.pi / 60.0, 273.15


def conditions(stand: Stand) -> dict[str, str]:
    """Fluid, temperature, pump, relief setting, spool drive, load and motor of a stand, as a reader wants them."""
    here, bench = stand.set_point, stand.bench
    oil, pump, relief = bench.oil, bench.pump, bench.relief_valve
    volume = pump.displacement * 2.0 * np.pi * 1e6
    override = f", {relief.override_pressure / BAR:.4g} bar override" if relief.override_pressure > 0.0 else ", ideal"
    found = {
        "fluid": f"{fluid(stand)}, {100.0 * oil.air_fraction:.3g} % free air, "
        f"bulk modulus {oil.liquid_bulk_modulus / 1e9:.4g} GPa without it",
        "temperature": f"{here.oil_temperature - CELSIUS:.4g} °C",
        "pump": f"{volume:.4g} cm³/rev at {here.pump_speed / RPM:.5g} rpm, {stand.pump_flow(here) / LPM:.4g} lpm",
        "motor": f"{bench.motor.rated_power / 1e3:.4g} kW",
        "relief valve": f"{gauge(stand.relief_pressure)} bar{override}",
        "tank": f"{gauge(stand.tank_pressure)} bar",
        "spool": "driven by a motor" if stand.is_driven else "spun by the flow",
    }
    if line := bench.load_line:
        gas = f", {1e6 * line.gas_volume:.4g} cm³ gas at {gauge(line.precharge_pressure)} bar"
        found["load"] = f"line of {1e3 * line.oil_volume:.4g} l{gas if line.gas_volume > 0.0 else ''}, then an orifice"
    else:
        found["load"] = "a source that holds its pressure"
    return found


def fluid(stand: Stand) -> str:
    """Density and kinematic viscosity of the oil at the stand's temperature, in words."""
    oil, temperature = stand.bench.oil, stand.set_point.oil_temperature
    rho = float(density(temperature, oil))
    nu = float(dynamic_viscosity(temperature, oil)) / rho
    return f"{1e6 * nu:.4g} mm²/s and {rho:.4g} kg/m³ at {temperature - CELSIUS:.4g} °C"


def gauge(pressure: float) -> str:
    """An absolute pressure level [Pa] as gauge [bar], to four digits."""
    return f"{round((pressure - ATMOSPHERE) / BAR, 6):.4g}"


def span(values: tuple[float, ...], scale: float, unit: str, datum: float = 0.0) -> str:
    """An axis in words: its value, or its ends and how many there are."""
    ends = [f"{round((v - datum) / scale, 6):.5g}" for v in (values[0], values[-1])]
    unit = f" {unit}" if unit else ""
    return f"{ends[0]}{unit}" if len(values) == 1 else f"{ends[0]} to {ends[1]}{unit}, {len(values)} values"
