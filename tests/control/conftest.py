"""The actuator of the source with its oil, and the published gains."""

import numpy as np
import pytest

from vvdp.control.backstepping import BacksteppingGains
from vvdp.control.chamber import ChamberDrive
from vvdp.control.orifice import ChamberValve
from vvdp.control.passivity import PassivityGains
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


@pytest.fixture(scope="session")
def drive(oil):
    """Section 5.7.1, 190 psi."""
    valve = ChamberValve(
        conductance=0.62 * 20e-6 * np.sqrt(2.0 / 876.0),
        supply_pressure=1.310e6 + ATMOSPHERE,
        tank_pressure=ATMOSPHERE,
    )
    return ChamberDrive(
        area=1.74e-4, moving_mass=0.5, stiffness=2594.0, preload=211.5, oil_volume=60e-6, oil=oil, valve=valve
    )


@pytest.fixture(scope="session")
def passive():
    """Table 5.1."""
    return PassivityGains(error_rate=50.0, position_gain=55.0, velocity_gain=4.0, flow_gain=4e-10)


@pytest.fixture(scope="session")
def backstepping():
    """Table 5.1."""
    return BacksteppingGains(
        error_rate=50.0, position_gain=550.0, velocity_gain=45.0, pressure_weight=3e-12, flow_gain=4e-10
    )
