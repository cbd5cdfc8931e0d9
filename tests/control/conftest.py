"""The actuator of the source with its oil, and the published gains."""

import pytest

from vvdp.fluid.oil import Oil

ATMOSPHERE = 1e5
BAR = 1e5


@pytest.fixture(scope="session")
def oil():
    """10 % of air per oil, that is 0.0909 of the mixture."""
    return Oil(
        density=876.0,
        thermal_expansion=7e-4,
        viscosity_40=44.178e-6,
        viscosity_100=6.65e-6,
        liquid_bulk_modulus=1.7e9,
        air_fraction=0.1 / 1.1,
        polytropic_exponent=1.4,
        reference_pressure=ATMOSPHERE,
    )
