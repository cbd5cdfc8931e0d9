import pytest

from vvdp.fluid.oil import Oil


@pytest.fixture(scope="session")
def oil() -> Oil:
    return Oil(
        density=876.0,
        thermal_expansion=7e-4,
        viscosity_40=44.2e-6,
        viscosity_100=6.8e-6,
        liquid_bulk_modulus=1.4e9,
        air_fraction=0.01,
        polytropic_exponent=1.4,
        reference_pressure=101325.0,
    )
