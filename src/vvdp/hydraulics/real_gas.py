"""Nitrogen as an ideal or a real gas: pressure, energy, heat capacity of an amount of it.

Redlich and Kwong's equation, whose attraction and own volume a factor of 0 takes away: the ideal gas is left.

Source  redlich1949; heat capacity of a diatomic gas, 5/2 R
Holds   for nitrogen above -70 degC, up to some 400 bar
Error   open; the only data of the gas in the equation is its critical point; errors of a few percent at most
"""

from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.kinds import NUMBER, Kind

GAS_CONSTANT = 8.314462618
"""Molar gas constant [J/(mol K)]."""
CRITICAL_TEMPERATURE, CRITICAL_PRESSURE = 126.19, 3.396e6
"""Of nitrogen [K], [Pa]: 126.192 K and 3.3958 MPa of Span and others, 2000, rounded."""
ATTRACTION = 0.42748 * GAS_CONSTANT**2 * CRITICAL_TEMPERATURE**2.5 / CRITICAL_PRESSURE
"""a [Pa m^6 K^0.5/mol^2]."""
OWN_VOLUME = 0.08664 * GAS_CONSTANT * CRITICAL_TEMPERATURE / CRITICAL_PRESSURE
"""b [m^3/mol]."""
ITERATIONS = 20
"""Of Newton's method; the pressure is convex in the volume, so that it closes in from one side."""

GAS_TEMPERATURE = Kind("gas temperature", "K", 150.0, 1500.0, "20 degC", scale=1.0, units=("degC", "K", "degF"))
GasTemperature = Annotated[float, GAS_TEMPERATURE]
Quantity = Annotated[float, NUMBER]


class GasProperties(NamedTuple):
    """Pressure of a gas [Pa], its slopes over temperature and molar volume, heat capacity per mole at rest."""

    pressure: Quantity
    per_temperature: Quantity
    per_volume: Quantity
    heat_capacity: Quantity


def gas_state(volume: float, temperature: float, real: float) -> GasProperties:
    """State of nitrogen: p = R T/(v - b) - a/(root(T) v (v + b)), its slopes, and c_v.

    volume       molar, v [m^3/mol]
    temperature  T [K]
    real         1 for a real gas, 0 for an ideal one

    >>> print(round(gas_state(2.4942e-4, 300.0, 0.0).pressure / 1e5, 1))  # bar: R T/v
    100.0
    """
    v, T, R = volume, temperature, GAS_CONSTANT
    a, b = real * ATTRACTION, real * OWN_VOLUME
    root, room, wide = np.sqrt(T), v - b, v * (v + OWN_VOLUME)
    pull = a / (root * wide)
    wells = 0.75 * a * np.log1p(OWN_VOLUME / v) / (OWN_VOLUME * T * root)
    return GasProperties(
        pressure=R * T / room - pull,
        per_temperature=R / room + 0.5 * pull / T,
        per_volume=-R * T / (room * room) + pull * (2.0 * v + OWN_VOLUME) / wide,
        heat_capacity=2.5 * R + wells,
    )


def gas_internal_energy(volume: float, temperature: float, real: float) -> float:
    """Internal energy of a mole of nitrogen [J]: 5/2 R T - 3 a/(2 b root(T)) ln(1 + b/v).

    volume       molar, v [m^3/mol]
    temperature  T [K]
    real         1 for a real gas, 0 for an ideal one
    """
    attracted = 1.5 * real * ATTRACTION * np.log1p(OWN_VOLUME / volume) / (OWN_VOLUME * np.sqrt(temperature))
    energy: float = 2.5 * GAS_CONSTANT * temperature - attracted
    return energy


def molar_volume(pressure: float, temperature: float, real: float) -> float:
    """Volume of a mole of nitrogen [m^3] under a pressure, by Newton's method.

    pressure     absolute [Pa]
    temperature  [K]
    real         1 for a real gas, 0 for an ideal one

    >>> [float(round(1e5 * molar_volume(30e6, 300.0, real), 2)) for real in (0.0, 1.0)]  # 11 % more
    [8.31, 9.2]
    """
    v = GAS_CONSTANT * temperature / pressure + real * OWN_VOLUME
    for _ in range(ITERATIONS):
        state = gas_state(v, temperature, real)
        v = v - (state.pressure - pressure) / state.per_volume
    return v
