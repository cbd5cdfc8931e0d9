"""Bulk-modulus laws of aerated oil from the literature, and the energy stored under any of them.

The laws are formulas. The energies take the law as an argument and integrate it with SciPy; they are for analysis.
"""

from collections.abc import Callable
from typing import Annotated, TypeVar

import numpy as np
from scipy.integrate import quad

from vvdp.base.kinds import AirFraction, BulkModulus, Kind, Polytropic, Pressure
from vvdp.base.params import Params
from vvdp.base.rules import require_less, require_positive
from vvdp.base.select import clip, maximum
from vvdp.fluid.parts import RAREFIED

DISSOLVING_RATE = Kind("rate at which air dissolves", "1/Pa", 0.0, 1e-5, "1e-8 1/Pa")
DissolvingRate = Annotated[float, DISSOLVING_RATE]


class IsothermalAir(Params):
    """Oil with free air at constant temperature; `air_fraction` is the air's volume at `reference_pressure`.

    Raises `ParameterError` unless the reference pressure, absolute, is above zero.
    """

    liquid_bulk_modulus: BulkModulus
    air_fraction: AirFraction
    reference_pressure: Pressure

    def check(self) -> None:
        """Refuse a vacuum as reference."""
        require_positive(self, "reference_pressure")


class PolytropicAir(IsothermalAir):
    """Oil with free air that is compressed along a polytrope."""

    polytropic_exponent: Polytropic


class YuAir(PolytropicAir):
    """Oil with air that dissolves in proportion to gauge pressure, at `dissolving_rate`."""

    dissolving_rate: DissolvingRate


class DissolvingAir(PolytropicAir):
    """Oil with air that is dissolved altogether at `critical_pressure` (absolute).

    Raises `ParameterError` unless that lies above the reference pressure.
    """

    critical_pressure: Pressure

    def check(self) -> None:
        """Refuse air that is dissolved before it is compressed."""
        require_less(self, "reference_pressure", "critical_pressure")


Fluid = TypeVar("Fluid")
Law = Callable[[float, Fluid], float]
"""A bulk modulus [Pa] as a function of absolute pressure [Pa] and of parameters."""


def yu_bulk_modulus(pressure: float, params: YuAir) -> float:
    """Bulk modulus by Yu, Chen and Lu [Pa].

    1/beta = (1 - v)/E + v/(n P), v = R (1 - c1 (P - P0)) (P0/P)^(1/n), the bracket not below zero.
    pressure: P, absolute [Pa], held at P0/100 below it.

    Source  yu1994; form ours, docs/models/fluid.md
    """
    P0, n, E = params.reference_pressure, params.polytropic_exponent, params.liquid_bulk_modulus
    P: float = maximum(pressure, RAREFIED * P0)
    undissolved = maximum(1.0 - params.dissolving_rate * (P - P0), 0.0)
    v: float = params.air_fraction * undissolved * (P0 / P) ** (1.0 / n)
    return 1.0 / ((1.0 - v) / E + v / (n * P))


def cho_bulk_modulus(pressure: float, params: PolytropicAir) -> float:
    """Bulk modulus by Cho, Lee and Oh [Pa].

    beta = (v_l + v_g)/(v_l/E + v_g/(n P)), v_l = e^(-(P - P0)/E), v_g = R (P0/P)^(1/n); R is air per volume of oil.
    pressure: P, absolute [Pa], held at P0/100 below it.

    Source  cho2002, bulk modulus
    """
    P0, n, E = params.reference_pressure, params.polytropic_exponent, params.liquid_bulk_modulus
    P: float = maximum(pressure, RAREFIED * P0)
    v_l = np.exp((P0 - P) / E)
    v_g = params.air_fraction * (P0 / P) ** (1.0 / n)
    beta: float = (v_l + v_g) / (v_l / E + v_g / (n * P))
    return beta


def nykanen_bulk_modulus(pressure: float, params: PolytropicAir) -> float:
    """Bulk modulus of the Nykanen type [Pa]: the oil's own volume is taken as constant.

    beta = E (1 + v)/(1 + E v/(n P)), v = R (P0/P)^(1/n); R is air per volume of oil.
    pressure: P, absolute [Pa], held at P0/100 below it.

    Source  nykanen2000
    """
    P0, n, E = params.reference_pressure, params.polytropic_exponent, params.liquid_bulk_modulus
    P: float = maximum(pressure, RAREFIED * P0)
    v: float = params.air_fraction * (P0 / P) ** (1.0 / n)
    return E * (1.0 + v) / (1.0 + E * v / (n * P))


def isothermal_bulk_modulus(pressure: float, params: IsothermalAir) -> float:
    """Bulk modulus with little isothermal air [Pa].

    beta = E/(1 + E R P0/P^2).  pressure: P, absolute [Pa], held at P0/100 below it.

    Source  wylie1993
    """
    P0, E = params.reference_pressure, params.liquid_bulk_modulus
    P: float = maximum(pressure, RAREFIED * P0)
    return E / (1.0 + E * params.air_fraction * P0 / (P * P))


def dissolving_bulk_modulus(pressure: float, params: DissolvingAir) -> float:
    """Bulk modulus of oil whose air is compressed and dissolves, all of it at the critical pressure [Pa].

    beta = (v_l + v_g th)/(v_l/E + v_g (th/(n P) - th')), th = 1 - 3 x^2 + 2 x^3, x = (P - P0)/(Pc - P0) within [0, 1],
    v_l and v_g as by Cho, Lee and Oh. From Pc on it is E.  pressure: P, absolute [Pa], held at P0/100 below it.

    Source  ours, docs/models/fluid.md
    """
    P0, n, E = params.reference_pressure, params.polytropic_exponent, params.liquid_bulk_modulus
    P, span = maximum(pressure, RAREFIED * P0), params.critical_pressure - P0
    x = clip((P - P0) / span, 0.0, 1.0)
    th, slope = 1.0 - x * x * (3.0 - 2.0 * x), -6.0 * x * (1.0 - x) / span
    v_l = np.exp((P0 - P) / E)
    v_g = params.air_fraction * (P0 / P) ** (1.0 / n)
    beta: float = (v_l + v_g * th) / (v_l / E + v_g * (th / (n * P) - slope))
    return beta


def specific_volume_exponent(pressure: float, from_pressure: float, law: Law[Fluid], params: Fluid) -> float:
    """Logarithm of the ratio of densities at two pressures, g(P, P') = int_P'^P dP/beta = ln(rho(P)/rho(P')) [1].

    pressure: P; from_pressure: P', both absolute and above zero [Pa]; law: bulk modulus of (pressure, `params`).

    Source  wang2017, eq. 5.5
    """

    def compression(u: float) -> float:
        return float(np.exp(u) / law(np.exp(u), params))

    low = float(np.log(from_pressure))
    width = float(np.log1p((pressure - from_pressure) / from_pressure))
    return float(quad(compression, low, low + width, epsabs=0.0, epsrel=1e-11, limit=200)[0])


def mean_modulus(pressure: float, from_pressure: float, law: Law[Fluid], params: Fluid) -> float:
    """Mean bulk modulus of a compression, (P - Pd)^2 / (2 W_V) [Pa]; at P = Pd it is beta(P).

    1/mean = 2 int_0^1 t e^g(P, P')/beta(P') dt, P' = Pd + t (P - Pd), which has no difference that cancels.
    pressure: P; from_pressure: Pd, both absolute and above zero [Pa]; law: bulk modulus of (pressure, `params`).

    Source  wang2017, eq. 5.23
    """
    relative = (pressure - from_pressure) / from_pressure
    if relative == 0.0:
        return float(law(pressure, params))
    width = float(np.log1p(relative))

    def compression(s: float) -> float:
        P = from_pressure * np.exp(s * width)
        t, rate = np.expm1(s * width) / relative, P / from_pressure * width / relative
        return float(t * rate * np.exp(specific_volume_exponent(pressure, P, law, params)) / law(P, params))

    return 0.5 / float(quad(compression, 0.0, 1.0, epsabs=0.0, epsrel=1e-10, limit=200)[0])


def compression_energy_per_volume(pressure: float, from_pressure: float, law: Law[Fluid], params: Fluid) -> float:
    """Energy stored by going from one pressure to another, per volume at the final one, W_V [J/m3].

    W_V = int_Pd^P (e^g(P, P') - 1) dP' = (P - Pd)^2 / (2 mean modulus)
    pressure: P; from_pressure: Pd, both absolute and above zero [Pa]; law: bulk modulus of (pressure, `params`).

    Source  wang2017, eq. 5.22
    """
    return 0.5 * (pressure - from_pressure) ** 2 / mean_modulus(pressure, from_pressure, law, params)


def compression_energy_per_mass(
    pressure: float, from_pressure: float, from_density: float, law: Law[Fluid], params: Fluid
) -> float:
    """Energy stored by going from one pressure to another, per mass, W_m = W_V/rho(P) [J/kg].

    rho(P) = rho(Pd) e^g(P, Pd).  pressure: P; from_pressure: Pd, both absolute and above zero [Pa];
    from_density: density at Pd [kg/m3]; law: bulk modulus of (pressure, `params`).

    Source  wang2017, eq. 5.14
    """
    final = from_density * float(np.exp(specific_volume_exponent(pressure, from_pressure, law, params)))
    return compression_energy_per_volume(pressure, from_pressure, law, params) / final
