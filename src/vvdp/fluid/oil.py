"""Hydraulic oil: density and modulus over temperature, viscosity over temperature and pressure.

Derived in docs/models/fluid.md, "Density and viscosity over temperature" and "Viscosity over pressure".
"""

from typing import Annotated, NamedTuple

import numpy as np

from vvdp.base.kinds import (
    AirFraction,
    BulkModulus,
    Density,
    Fall,
    Fraction,
    Kind,
    KinematicViscosity,
    Polytropic,
    Pressure,
    Ratio,
    Temperature,
    ThermalExpansion,
    Time,
)
from vvdp.base.params import Params
from vvdp.base.powers import expm1
from vvdp.base.rules import field_text, refuse, require_positive

PressureViscosity = Annotated[float, Kind("pressure-viscosity coefficient", "1/Pa", 0.0, 1e-7, "2e-8 1/Pa")]

WARM = 313.15
"""The lower of the two temperatures at which a data sheet gives viscosity, 40 degC [K]."""
HOT = 373.15
"""The higher one, 100 degC [K]."""


class Oil(Params):
    """An oil as its data sheet describes it, with the free air that it carries.

    `density` holds at `density_temperature`, the two viscosities are kinematic and grow by `pressure_viscosity` per
    pressure, `air_fraction` is the share of the volume that is free air at `reference_pressure` (absolute), and
    `liquid_bulk_modulus` is the tangent modulus of the oil without air at that pressure and 40 degC; it grows by
    `bulk_modulus_slope` over pressure and falls by `bulk_modulus_fall` over temperature. Below `vapour_pressure`
    (absolute; 0: none) the oil boils. With a `bunsen_coefficient`, the volume of air at the reference pressure that a
    volume of oil dissolves at it, free air nears its equilibrium within `dissolving_time` or `release_time`; 0 leaves
    it free. Raises `ParameterError` where the oil does not thin as it warms, or is too thin for the viscosity law
    (0.3 mm2/s), or where values do not fit.
    """

    density: Density
    thermal_expansion: ThermalExpansion
    viscosity_40: KinematicViscosity
    viscosity_100: KinematicViscosity
    liquid_bulk_modulus: BulkModulus
    air_fraction: AirFraction
    polytropic_exponent: Polytropic
    reference_pressure: Pressure
    pressure_viscosity: PressureViscosity = 0.0
    density_temperature: Temperature = WARM
    bulk_modulus_slope: Ratio = 0.0
    bulk_modulus_fall: Fall = 0.0
    vapour_pressure: Pressure = 0.0
    bunsen_coefficient: Fraction = 0.0
    dissolving_time: Time = 0.0
    release_time: Time = 0.0

    def check(self) -> None:
        """Refuse viscosities that no straight line of the viscosity chart can join, and a vacuum as reference."""
        if not self.viscosity_40 > self.viscosity_100:
            limit = field_text(self, "viscosity_100")
            refuse(self, "viscosity_40", f"at 40 degC must be greater than viscosity_100 at 100 degC, {limit}")
        if not self.viscosity_100 > 0.3e-6:
            refuse(self, "viscosity_100", "must be greater than 0.3 cSt, where the viscosity equation ends")
        require_positive(self, "reference_pressure")
        if not self.vapour_pressure < self.reference_pressure:
            limit = field_text(self, "reference_pressure")
            refuse(
                self, "vapour_pressure", f"must be less than reference_pressure, {limit}, at which the oil would boil"
            )
        if self.bunsen_coefficient > 0.0:
            require_positive(self, "dissolving_time", "release_time", why="bunsen_coefficient is greater than 0")


def density(temperature: float, oil: Oil) -> float:
    """Density of the oil at its reference pressure [kg/m3].

    rho = rho_r / (1 + alpha (T - T_r)), rho_r the data sheet's at T_r.  temperature: T [K].

    Source  merritt1967, ch. 2; the volume, not the density, is linear in temperature
    Holds   at the reference pressure; `fluid_density` has that under pressure

    >>> print(round(density(353.15, oil), 1))
    852.1
    """
    return oil.density / (1.0 + oil.thermal_expansion * (temperature - oil.density_temperature))


def modulus_at(temperature: float, oil: Oil) -> float:
    """Bulk modulus of the oil without air at a temperature and its reference pressure [Pa]: K40 e^(-c (T - 313.15 K)).

    temperature: T [K].

    Source  hayward1970, fall over temperature
    Holds   for a run whose temperature changes little: the stored energy depends on the modulus, which must not change

    >>> from dataclasses import replace
    >>> print(round(modulus_at(333.15, replace(oil, bulk_modulus_fall=5.5e-3)) / 1e9, 3))  # GPa, 60 degC
    1.254
    """
    share: float = np.exp(-oil.bulk_modulus_fall * (temperature - WARM))
    return oil.liquid_bulk_modulus * share


def kinematic_viscosity(temperature: float, oil: Oil) -> float:
    """Kinematic viscosity of the oil [m2/s] by the viscosity-temperature chart, through 40 and 100 degC.

    log10 log10(v + 0.7) = A - B log10 T, v in mm2/s; with y = ln(v + 0.7) the same line is
    y = y40 (T / 313.15 K)^-B.  temperature: T [K].

    Source  astm-d341, simplified equation; walther1931
    Holds   above 2 mm2/s, and best between the two temperatures of the data sheet

    >>> print(round(1e6 * kinematic_viscosity(333.15, oil), 1))  # at 60 degC
    20.0
    """
    y40 = np.log(1e6 * oil.viscosity_40 + 0.7)
    y100 = np.log(1e6 * oil.viscosity_100 + 0.7)
    steps = np.log(temperature / WARM) / np.log(HOT / WARM)
    shifted: float = np.exp(y40 * (y100 / y40) ** steps)
    return 1e-6 * (shifted - 0.7)


def dynamic_viscosity(temperature: float, oil: Oil) -> float:
    """Dynamic viscosity of the oil [Pa s], mu = rho v at the reference pressure.  temperature: [K].

    Source  merritt1967, ch. 2
    """
    return density(temperature, oil) * kinematic_viscosity(temperature, oil)


class FilmRatios(NamedTuple):
    """Ratio of a thin film's viscosity to that of the oil at the reference pressure, and of its fluidity, the
    inverse."""

    viscosity: Ratio
    fluidity: Ratio


def film_ratios(first_pressure: float, second_pressure: float, oil: Oil) -> FilmRatios:
    """Viscosity and fluidity of a thin film, thickened by the pressures on both its sides, over those of its oil [1].

    With mu = mu_0 exp(alpha (P - P_0)) both the flow and the mean shear of the film are those of the one viscosity
    mu_0 alpha (P_1 - P_2)/(exp(-alpha (P_2 - P_0)) - exp(-alpha (P_1 - P_0))), that is mu_0 exp(alpha (P_m - P_0))
    (x/2)/sinh(x/2), with P_m the mean pressure and x = alpha (P_1 - P_2).

    first_pressure, second_pressure  on its two sides, absolute [Pa]

    Source  barus1893; the film is ours, docs/models/fluid.md
    Holds   for laminar films, warmed evenly
    Error   the series of sinh ends with an error of x^6/322560: 2e-10 for 100 bar, 8e-7 for 400 bar at 2e-8 1/Pa

    >>> print(round(film_ratios(100e5 + 101325.0, 101325.0, oil).viscosity, 4))
    1.1033
    """
    return barus_ratios(first_pressure - oil.reference_pressure, second_pressure - oil.reference_pressure, oil)


def film_ratios_compiled(first_pressure: float, second_pressure: float, oil: Oil) -> FilmRatios:
    """The same as `film_ratios`, which it replaces in compiled code: oil that does not thicken costs nothing.

    first_pressure, second_pressure  on its two sides, absolute [Pa]

    Source  barus1893; the film is ours, docs/models/fluid.md
    """
    if oil.pressure_viscosity == 0.0:
        return FilmRatios(1.0, 1.0)
    return barus_ratios(first_pressure - oil.reference_pressure, second_pressure - oil.reference_pressure, oil)


def barus_ratios(first_rise: float, second_rise: float, oil: Oil) -> FilmRatios:
    """The law of `film_ratios` [1].

    first_rise, second_rise  pressures above the reference pressure on the film's two sides [Pa]

    Source  barus1893; the film is ours, docs/models/fluid.md
    """
    x = oil.pressure_viscosity * (first_rise - second_rise)
    # 2 sinh(x/2)/x by its power series, which has no quotient of zeros.
    spread = 1.0 + x * x / 24.0 * (1.0 + x * x / 80.0)
    viscosity = (1.0 + expm1(0.5 * oil.pressure_viscosity * (first_rise + second_rise))) / spread
    return FilmRatios(viscosity, 1.0 / viscosity)


def film_viscosity(temperature: float, first_pressure: float, second_pressure: float, oil: Oil) -> float:
    """Dynamic viscosity that a thin film between two pressures shows [Pa s], for its flow and its friction alike.

    temperature                      [K]
    first_pressure, second_pressure  on its two sides, absolute [Pa]

    Source  barus1893; the film is ours, docs/models/fluid.md
    """
    return dynamic_viscosity(temperature, oil) * film_ratios(first_pressure, second_pressure, oil).viscosity
