"""The parts of oil with air under pressure: free air, oil, vapour, each with its volume and what its compression takes.

Source  ours, docs/models/fluid.md, where a function names no other.
"""

from typing import NamedTuple

import numpy as np

from vvdp.base.kinds import Ratio
from vvdp.base.modes import side
from vvdp.base.powers import expm1, power
from vvdp.base.select import clip, maximum, minimum, select
from vvdp.fluid.oil import Oil

RAREFIED = 0.01
"""Share of the reference pressure below which the gas law is not followed."""
VAPOUR_GROWTH = 4.0
"""Volume of vapour, per tank volume of oil, at 1/e of the vapour pressure."""


class FluidPart(NamedTuple):
    """Volume [1] of a part of the fluid per volume at the reference pressure, -dV/dP [1/Pa], and int V dP [J/m3]."""

    volume: float
    yielding: float
    enthalpy: float


class PowerGrowth(NamedTuple):
    """A power of a ratio, and how far it has grown from 1 over its exponent."""

    power: Ratio
    growth: float


def power_growth(ratio: float, exponent: float) -> PowerGrowth:
    """x^k and (x^k - 1)/k [1], the latter ln x at k = 0 and exact close to it.

    ratio     x, greater than zero [1]
    exponent  k, 0 or greater [1]
    """
    k, L = exponent, np.log(ratio)
    e = np.expm1(k * L)
    return PowerGrowth(1.0 + e, select(k > 0.0, e / select(k > 0.0, k, 1.0), L))


def power_growth_compiled(ratio: float, exponent: float) -> PowerGrowth:
    """The same as `power_growth`, which it replaces in compiled code: where k is not small, one power does.

    ratio     x, greater than zero [1]
    exponent  k, 0 or greater [1]
    """
    k = exponent
    per_k = 1.0 / select(k > 0.0, k, 1.0)  # not where it is used: here all states of an oil share it
    if k > 0.01:
        grown = power(ratio, k)
        return PowerGrowth(grown, (grown - 1.0) * per_k)
    L = np.log(ratio)
    e = np.expm1(k * L)
    return PowerGrowth(1.0 + e, select(k > 0.0, e * per_k, L))


def air_part(pressure: float, oil: Oil) -> FluidPart:
    """Free air, per volume of it at the reference pressure: a = (P/P0)^(-1/n), below P0/100 its tangent.

    pressure: P, absolute [Pa].

    Source  cho2002, bulk modulus; enthalpy ours, docs/models/fluid.md
    """
    P0, n = oil.reference_pressure, oil.polytropic_exponent
    Pg = maximum(pressure, RAREFIED * P0)
    below = Pg - pressure
    air = power_growth(Pg / P0, 1.0 - 1.0 / n)
    a = P0 * air.power / Pg
    slope = a / (n * Pg)
    return FluidPart(a + slope * below, slope, P0 * air.growth - below * (a + 0.5 * slope * below))


def liquid_part(pressure: float, oil: Oil) -> FluidPart:
    """Oil without air, per volume of it at the reference pressure: l = (1 + m (P - P0)/b)^(-1/m), b its modulus there.

    The modulus is b + m (P - P0); at m = 0, l = e^(-(P - P0)/b).  pressure: P, absolute [Pa].

    Source  murnaghan1944; enthalpy ours, docs/models/fluid.md

    >>> from dataclasses import replace
    >>> stiffer = liquid_part(300e5, replace(oil, bulk_modulus_slope=11.0))
    >>> print(round(stiffer.volume / stiffer.yielding / 1e9, 3))  # GPa, 1.4 at the tank
    1.729
    """
    d, b, m = pressure - oil.reference_pressure, oil.liquid_bulk_modulus, oil.bulk_modulus_slope
    volume: float = np.exp(-density_growth(d, b, m))
    return FluidPart(volume, volume / (b + m * d), liquid_enthalpy(d, b, m))


def liquid_enthalpy(rise: float, modulus: float, slope: float) -> float:
    """int l dP of oil over a rise of its pressure, l = 1 at first [J/m3]: b (e^((m - 1) g) - 1)/(m - 1).

    g = ln(1 + m d/b)/m is the logarithm of the density's ratio, d/b at m = 0.

    rise     d [Pa]
    modulus  b, at first [Pa]
    slope    m, of the modulus over pressure [1]

    Source  ours, docs/models/fluid.md
    """
    g, k = density_growth(rise, modulus, slope), slope - 1.0
    level = abs(k) < 1e-12
    return modulus * select(level, g, expm1(k * g) / select(level, 1.0, k))


def density_growth(rise: float, modulus: float, slope: float) -> float:
    """Logarithm of the ratio by which oil without air becomes denser over a rise of its pressure, int dP/beta [1].

    rise     of the pressure [Pa]
    modulus  at first [Pa]
    slope    of the modulus over pressure [1]
    """
    m = select(slope > 0.0, slope, 1.0)
    growth: float = select(slope > 0.0, np.log1p(slope * rise / modulus) / m, rise / modulus)
    return growth


def vapour_part(pressure: float, oil: Oil) -> FluidPart:
    """Vapour, per tank volume: v = C L^2, L = ln(Pv/P), below the vapour pressure, none above; C is `VAPOUR_GROWTH`.

    int v dP = C (P (L^2 + 2 L + 2) - 2 Pv). Below Pv/100 it grows along its tangent.  pressure: P, absolute [Pa].

    Source  ours, docs/models/fluid.md
    Holds   for a pressure near the vapour pressure, not at it: there is as much vapour as oil at 0.61 of it
    """
    Pv = oil.vapour_pressure
    unit, C = select(Pv > 0.0, Pv, 1.0), select(Pv > 0.0, VAPOUR_GROWTH, 0.0)
    Pr = unit * clip(pressure / unit, RAREFIED, 1.0)
    below, L = Pr - minimum(pressure, Pr), np.log(unit / Pr)
    grown, slope = C * L * L, 2.0 * C * L / Pr
    return FluidPart(
        volume=grown + slope * below,
        yielding=slope,
        enthalpy=Pr * (grown + 2.0 * C * (L + 1.0)) - 2.0 * C * unit - below * (grown + 0.5 * slope * below),
    )


def vapour_side(pressure: float, oil: Oil) -> float:
    """Whether oil boils at a pressure as the side of a kink [1], see `base.modes.side`: its modulus jumps there.

    pressure  absolute [Pa]
    """
    return side((pressure - oil.vapour_pressure) / oil.reference_pressure)
