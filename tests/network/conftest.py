"""Values that the tests of networks share."""

from types import SimpleNamespace

import pytest

from vvdp.components.library import UsualOil
from vvdp.fluid.oil import Oil
from vvdp.hydraulics.check_valve import CheckValve
from vvdp.hydraulics.cylinder import Cylinder
from vvdp.hydraulics.flow_source import FlowSource
from vvdp.hydraulics.orifice import Orifice
from vvdp.hydraulics.pump import Pump
from vvdp.hydraulics.relief_valve import ReliefValve
from vvdp.network.nodes import Chamber

OIL = UsualOil()
VALUES = SimpleNamespace(
    chamber=Chamber(volume=2e-4),
    orifice=Orifice(discharge_coefficient=0.61, transition_pressure=1e4),
    source=FlowSource(counted_at_outlet=0.0),
    pump=Pump(
        displacement=3.6e-6, leakage_conductance=2e-12, ripple_amplitude=0.02, ripple_count=9.0, friction_torque=1.0
    ),
    cylinder=Cylinder(area_a=2e-3, area_b=1e-3, stroke=0.5, moving_mass=10.0, leakage_conductance=0.0),
    check=CheckValve(
        cracking_pressure=5e4, rated_flow=1e-3, rated_drop=3e5, reverse_opening=0.0, opening_time=0.0
    ),
    relief=ReliefValve(cracking_pressure=1e7, rated_flow=1e-3, override_pressure=0.0, opening_time=0.0),
)  # fmt: skip


@pytest.fixture(scope="session")
def oil() -> Oil:
    return OIL


@pytest.fixture(scope="session")
def of() -> SimpleNamespace:
    """Values of components, by a word for each."""
    return VALUES
