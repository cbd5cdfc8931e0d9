"""Oils for the tests of the fluid."""

from collections.abc import Callable

import pytest

from vvdp.fluid.oil import Oil


@pytest.fixture(scope="session")
def make_oil() -> Callable[..., Oil]:
    """Makes a mineral oil of grade 46 with 1 % air, or one that differs from it in the given fields."""

    def made(**changed: float) -> Oil:
        usual = {
            "density": 876.0,
            "thermal_expansion": 7e-4,
            "viscosity_40": 44.178e-6,
            "viscosity_100": 6.65e-6,
            "liquid_bulk_modulus": 1.4e9,
            "air_fraction": 0.01,
            "polytropic_exponent": 1.4,
            "reference_pressure": 101325.0,
        }
        return Oil(**(usual | changed))

    return made
