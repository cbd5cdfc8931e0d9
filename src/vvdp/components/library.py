"""The library by the names that a system file uses: the components and assemblies of the modules of this package."""

import importlib
import pkgutil
from collections.abc import Iterator, Mapping

import vvdp.components
from vvdp.base.kinds import (
    AirFraction,
    BulkModulus,
    Density,
    KinematicViscosity,
    Polytropic,
    Pressure,
    ThermalExpansion,
)
from vvdp.fluid.oil import Oil
from vvdp.network.assembly import Assembly
from vvdp.network.component import Component


class UsualOil(Oil):
    """A mineral oil of viscosity grade 46 with 1 % of free air, where a file gives no other values.

    Source  wang2017, section 2.3.1 (density, viscosity at 40 degC); the others are usual values, assumed
    """

    density: Density = 876.0
    thermal_expansion: ThermalExpansion = 7e-4
    viscosity_40: KinematicViscosity = 44.1780822e-6
    viscosity_100: KinematicViscosity = 6.65e-6
    liquid_bulk_modulus: BulkModulus = 1.4e9
    air_fraction: AirFraction = 0.01
    polytropic_exponent: Polytropic = 1.4
    reference_pressure: Pressure = 101325.0


def _offers() -> Iterator[Component | Assembly]:
    """Components and assemblies that the modules of this package offer."""
    for module in pkgutil.iter_modules(vvdp.components.__path__, "vvdp.components."):
        for value in vars(importlib.import_module(module.name)).values():
            if isinstance(value, Assembly) or (isinstance(value, Component) and value.offered):
                yield value


COMPONENTS: Mapping[str, Component | Assembly] = dict(
    sorted((component.name.replace("_", "-"), component) for component in _offers())
)
"""Components that a system file can name, by their type."""


def __getattr__(name: str) -> Component | Assembly:
    """A component by the name of its record, as in `from vvdp.components.library import CHECK_VALVE`."""
    found = COMPONENTS.get(name.lower().replace("_", "-")) if name.isupper() else None
    if found is None:
        raise AttributeError(f"the library has no {name}")
    return found
