"""Hydraulic oil at tank pressure: density and viscosity over temperature."""

import numpy as np

from vvdp.base.errors import ParameterError
from vvdp.base.kinds import (
    AirFraction,
    BulkModulus,
    Density,
    KinematicViscosity,
    Polytropic,
    Pressure,
    ThermalExpansion,
)
from vvdp.base.params import Params

WARM = 313.15
"""The lower of the two temperatures at which a data sheet gives viscosity, 40 degC [K]."""
HOT = 373.15
"""The higher one, 100 degC [K]."""


class Oil(Params):
    """An oil as its data sheet describes it, with the free air that it carries.

    `density` holds at 40 degC, the two viscosities are kinematic, `air_fraction` is the share of the volume that is
    free air at `reference_pressure` (absolute), and `liquid_bulk_modulus` is that of the oil without air. Raises
    `ParameterError` where the oil does not thin as it warms, or is too thin for the viscosity law (0.3 mm2/s).
    """

    density: Density
    thermal_expansion: ThermalExpansion
    viscosity_40: KinematicViscosity
    viscosity_100: KinematicViscosity
    liquid_bulk_modulus: BulkModulus
    air_fraction: AirFraction
    polytropic_exponent: Polytropic
    reference_pressure: Pressure

    def check(self) -> None:
        """Refuse viscosities that no straight line of the viscosity chart can join, and a vacuum as reference."""
        warm, hot = 1e6 * self.viscosity_40, 1e6 * self.viscosity_100
        if not warm > hot:
            raise ParameterError(
                f"Oil.viscosity_40: {warm:g} cSt at 40 degC does not exceed {hot:g} cSt at 100 degC (viscosity_100)"
            )
        if not hot > 0.3:
            raise ParameterError(
                f"Oil.viscosity_100: {hot:g} cSt is too thin; the viscosity law needs more than 0.3 cSt"
            )
        if not self.reference_pressure > 0.0:
            raise ParameterError(
                f"Oil.reference_pressure: {self.reference_pressure:g} Pa; expected an absolute pressure above zero"
            )


def density(temperature: float, oil: Oil) -> float:
    """Density of the oil at its reference pressure [kg/m3].

    rho = rho40 / (1 + alpha (T - 313.15 K)).  temperature: T [K].

    Source  merritt1967, ch. 2; the volume, not the density, is linear in temperature
    Holds   at the reference pressure; `fluid_density` has that under pressure

    >>> print(round(density(353.15, oil), 1))
    852.1
    """
    return oil.density / (1.0 + oil.thermal_expansion * (temperature - WARM))


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
