"""Oil with free air under pressure: its compressibility, and the energy that it carries and stores.

Every volume here is per volume of the same fluid at the reference pressure. All laws follow from one function, the
specific-volume ratio, so mass and energy books that use them close exactly.

Source  ours, docs/models/fluid.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import BulkModulus, EnergyDensity, Pressure, Ratio
from vvdp.base.powers import expm1
from vvdp.base.select import maximum, select
from vvdp.fluid.oil import Oil, density
from vvdp.fluid.parts import (
    RAREFIED,
    air_part,
    density_growth,
    liquid_enthalpy,
    liquid_part,
    power_growth,
    vapour_part,
)

NODES, WEIGHTS = (tuple(map(float, 0.5 * column)) for column in np.polynomial.legendre.leggauss(16))


class FluidState(NamedTuple):
    """Properties of the fluid at one absolute pressure, as a passage or a chamber needs them."""

    pressure: Pressure
    volume_ratio: Ratio
    bulk_modulus: BulkModulus
    enthalpy: EnergyDensity


def plain_state(pressure: float, oil: Oil) -> FluidState:
    """The state of an oil with neither vapour nor a modulus that grows, see `fluid_state`, at one pressure.

    With x = P/P0, a = phi x^(-1/n) and l = (1 - phi) e^(-(P - P0)/b):
    nu = a + l,  1/beta = (a/(n P) + l/b)/nu = -nu'/nu,
    h = phi P0 (x^k - 1)/k + b (1 - phi - l), k = 1 - 1/n (phi P0 ln x at n = 1), so that dh = nu dP and h(P0) = 0.
    Below P0/100 the air expands along its tangent, which keeps the relations and allows any trial pressure.
    pressure: P, absolute [Pa].

    Source  cho2002, bulk modulus; enthalpy ours, docs/models/fluid.md
    """
    P, P0 = pressure, oil.reference_pressure
    n, phi, b = oil.polytropic_exponent, oil.air_fraction, oil.liquid_bulk_modulus
    Pg = maximum(P, RAREFIED * P0)
    below = Pg - P
    # Reciprocals of what all states of an oil have in common, calculated once in compiled code.
    per_P0, per_b, per_Pg = 1.0 / P0, 1.0 / b, 1.0 / Pg
    air = power_growth(Pg * per_P0, 1.0 - 1.0 / n)
    a = phi * P0 * air.power * per_Pg
    slope = a * (1.0 / n) * per_Pg
    m = expm1((P0 - P) * per_b)
    l = (1.0 - phi) * (1.0 + m)
    nu = a + slope * below + l
    air_enthalpy = phi * P0 * air.growth - below * (a + 0.5 * slope * below)
    return FluidState(
        pressure=P,
        volume_ratio=nu,
        bulk_modulus=nu / (slope + l * per_b),
        enthalpy=air_enthalpy - (1.0 - phi) * b * m,
    )


def is_plain(oil: Oil) -> bool:
    """Whether neither vapour nor a modulus that grows over pressure belongs to an oil, so that `plain_state` holds."""
    return oil.vapour_pressure == 0.0 and oil.bulk_modulus_slope == 0.0


def fluid_state(pressure: float, oil: Oil) -> FluidState:
    """Specific-volume ratio [1], bulk modulus [Pa] and enthalpy per tank volume [J/m3] at one pressure.

    nu = phi a + (1 - phi) l + v, with a, l, v the volumes of `air_part`, `liquid_part` and `vapour_part`, 1/beta =
    -nu'/nu, and dh = nu dP, h(P0) = 0.  pressure: P, absolute [Pa].

    Source  cho2002, bulk modulus; enthalpy ours, docs/models/fluid.md
    """
    return aerated_state(pressure, oil.air_fraction, oil)


def fluid_state_compiled(pressure: float, oil: Oil) -> FluidState:
    """The same as `fluid_state`, which it replaces in compiled code: most oils are plain.

    pressure  absolute [Pa]
    """
    if oil.vapour_pressure == 0.0 and oil.bulk_modulus_slope == 0.0:
        return plain_state(pressure, oil)
    return aerated_state(pressure, oil.air_fraction, oil)


def aerated_state(pressure: float, free_air: float, oil: Oil) -> FluidState:
    """The state of oil at one pressure, see `fluid_state`, some of whose air has dissolved or come out of solution.

    pressure  absolute [Pa]
    free_air  volume at the reference pressure, per tank volume [1]

    Source  cho2002, bulk modulus; enthalpy ours, docs/models/fluid.md
    """
    air, liquid, vapour = air_part(pressure, oil), liquid_part(pressure, oil), vapour_part(pressure, oil)
    share = 1.0 - oil.air_fraction
    nu = free_air * air.volume + share * liquid.volume + vapour.volume
    return FluidState(
        pressure=pressure,
        volume_ratio=nu,
        bulk_modulus=nu / (free_air * air.yielding + share * liquid.yielding + vapour.yielding),
        enthalpy=free_air * air.enthalpy + share * liquid.enthalpy + vapour.enthalpy,
    )


def state_at(pressure: float, known: FluidState, oil: Oil) -> FluidState:
    """The state of plain oil at a pressure, see `plain_state`; in compiled code `known` where that is its pressure.

    pressure  absolute [Pa]
    known     the state at some pressure

    Source  cho2002, bulk modulus; enthalpy ours, docs/models/fluid.md
    """
    return plain_state(pressure, oil)


def state_at_compiled(pressure: float, known: FluidState, oil: Oil) -> FluidState:
    """The same as `state_at`, which it replaces in compiled code: a pressure that is constant costs a comparison.

    pressure  absolute [Pa]
    known     the state at some pressure

    Source  cho2002, bulk modulus; enthalpy ours, docs/models/fluid.md
    """
    if pressure == known.pressure:
        return known
    return plain_state(pressure, oil)


def specific_volume_ratio(pressure: float, oil: Oil) -> float:
    """Volume of a mass of fluid over its volume at the reference pressure, nu [1].  pressure: absolute [Pa].

    nu = phi (P/P0)^(-1/n) + (1 - phi) e^(-(P - P0)/b) of a plain oil; see `fluid_state`.

    Source  cho2002, bulk modulus
    Holds   for air that stays free, at pressures changing too fast for it to dissolve

    >>> print(round(specific_volume_ratio(100e5, oil), 5))
    0.9834
    """
    return fluid_state(pressure, oil).volume_ratio


def bulk_modulus(pressure: float, oil: Oil) -> float:
    """Bulk modulus of the fluid, beta = -nu/nu' [Pa].  pressure: absolute [Pa].

    beta = (a + l)/(a/(n P) + l/b), a and l the volume of air and of oil per volume at the reference pressure.

    Source  cho2002, bulk modulus
    Holds   for air that stays free; see `fluid.modulus` for laws in which it dissolves

    >>> print(*[round(bulk_modulus(p, oil) / 1e6) for p in (2e5, 100e5, 300e5)])
    44 1349 1392
    """
    return fluid_state(pressure, oil).bulk_modulus


def enthalpy(pressure: float, oil: Oil) -> float:
    """Enthalpy per volume at the reference pressure, h = int nu dP [J/m3].  pressure: absolute [Pa]."""
    return fluid_state(pressure, oil).enthalpy


def strain_energy(pressure: float, oil: Oil) -> float:
    """Energy stored against the reference pressure, per volume at that pressure [J/m3].

    w = h - (P - P0) nu = int (P' - P0) (-dnu).  pressure: P, absolute [Pa].

    Source  wang2017, eq. 5.11; closed form ours, docs/models/fluid.md
    """
    state = fluid_state(pressure, oil)
    return state.enthalpy - (pressure - oil.reference_pressure) * state.volume_ratio


def mean_bulk_modulus(pressure: float, oil: Oil) -> float:
    """The constant bulk modulus that stores as much in a rigid chamber filled from the reference pressure [Pa].

    (P - P0)^2 / (2 W), W = int_P0^P (P' - P0)/beta(P') dP', by 16 Gauss points in ln P; at P0 it is beta(P0).
    pressure: P, absolute [Pa], held at P0/100 below it.

    Source  wang2017, eq. 2.10 (W), eq. 5.19; ours, docs/models/fluid.md

    >>> print(round(mean_bulk_modulus(100e5, oil) / 1e6))
    1197
    """
    P0 = oil.reference_pressure
    L = np.log(maximum(pressure, RAREFIED * P0) / P0)
    span = np.expm1(L)
    at_reference = abs(span) < 1e-12
    rate = select(at_reference, 1.0, L / select(at_reference, 1.0, span))
    total = 0.0
    for i in range(16):
        s = 0.5 + NODES[i]
        x = np.exp(s * L)
        t = select(at_reference, s, np.expm1(s * L) / select(at_reference, 1.0, span))
        total = total + WEIGHTS[i] * t * x * rate / bulk_modulus(x * P0, oil)
    return 0.5 / total


def fluid_density(pressure: float, temperature: float, oil: Oil) -> float:
    """Density of the fluid under pressure, rho(T)/nu(P) [kg/m3].  pressure: absolute [Pa]; temperature: [K].

    Source  wang2017, eq. 5.8
    """
    return density(temperature, oil) / fluid_state(pressure, oil).volume_ratio


def compression_energy_per_volume(pressure: float, from_pressure: float, oil: Oil) -> float:
    """Energy stored by going from one pressure to another, per volume at the final one, W_V [J/m3].

    W_V = int_Pd^P (nu(P')/nu(P) - 1) dP'. With d = P - Pd, y = Pd/P, k = 1 - 1/n (-ln y for the fraction at n = 1),
    e the oil's own integral of l(P')/l(P) (b (e^(d/b) - 1) for a constant modulus), v the vapour:
    nu W_V = l (e - d) + a (P (1 - y^k)/k - d) + int v dP' - v d, exact for small d too.
    pressure: P; from_pressure: Pd, both absolute [Pa], held at P0/100 below it.

    Source  wang2017, eq. 5.22; closed form ours, docs/models/fluid.md
    Error   none but rounding: a closed form

    >>> print(round(compression_energy_per_volume(100e5, 101325.0, oil)))  # oil without air: 35 000
    41062
    """
    P0, n, m = oil.reference_pressure, oil.polytropic_exponent, oil.bulk_modulus_slope
    P = maximum(pressure, RAREFIED * P0)
    Pd = maximum(from_pressure, RAREFIED * P0)
    d = P - Pd
    k = (n - 1.0) / n
    L = np.log1p(-d / P)
    a = oil.air_fraction * (P0 / P) ** (1.0 / n)
    liquid, vapour = liquid_part(P, oil), vapour_part(P, oil)
    l = (1.0 - oil.air_fraction) * liquid.volume
    oil_expansion = -liquid_enthalpy(-d, oil.liquid_bulk_modulus + m * (P - P0), m)
    expansion = P * select(k > 0.0, -np.expm1(k * L) / select(k > 0.0, k, 1.0), -L)
    boiled = vapour.enthalpy - vapour_part(Pd, oil).enthalpy - d * vapour.volume
    energy: float = (l * (oil_expansion - d) + a * (expansion - d) + boiled) / (a + l + vapour.volume)
    return energy


def density_rise(pressure: float, from_pressure: float, oil: Oil) -> float:
    """Relative rise of the fluid's density from another pressure, rho(P)/rho(Pd) - 1 = e^g(P, Pd) - 1 [1].

    (nu(Pd) - nu(P))/nu(P), part by part: a ((P/Pd)^(1/n) - 1) of the air, l (l(Pd)/l(P) - 1) of the oil; exact for
    small differences too.  pressure: P; from_pressure: Pd, both absolute [Pa], held at P0/100 below it.

    Source  wang2017, eq. 5.5; closed form ours, docs/models/fluid.md

    >>> print(f"{density_rise(14e5, 10e5, oil):.4e}")  # oil without air: 2.8576e-04
    7.0562e-04
    """
    P0, n, m = oil.reference_pressure, oil.polytropic_exponent, oil.bulk_modulus_slope
    P = maximum(pressure, RAREFIED * P0)
    Pd = maximum(from_pressure, RAREFIED * P0)
    d = P - Pd
    a = oil.air_fraction * (P0 / P) ** (1.0 / n)
    liquid, vapour = liquid_part(P, oil), vapour_part(P, oil)
    l = (1.0 - oil.air_fraction) * liquid.volume
    air_rise = a * np.expm1(-np.log1p(-d / P) / n)
    oil_rise = l * np.expm1(-density_growth(-d, oil.liquid_bulk_modulus + m * (P - P0), m))
    rise: float = (air_rise + oil_rise + vapour_part(Pd, oil).volume - vapour.volume) / (a + l + vapour.volume)
    return rise


def compression_energy_per_mass(pressure: float, from_pressure: float, temperature: float, oil: Oil) -> float:
    """Energy stored by going from one pressure to another, per mass, W_m = W_V/rho(P) [J/kg].

    pressure, from_pressure: absolute [Pa]; temperature: [K].

    Source  wang2017, eq. 5.14
    """
    return compression_energy_per_volume(pressure, from_pressure, oil) / fluid_density(pressure, temperature, oil)
