"""The chamber drive at rest and shut, worked by hand."""

import numpy as np
import pytest

from vvdp.hydraulics.chamber_drive import holding_pressure, oil_stiffness, spring_frequency, static_reach
from vvdp.hydraulics.cylinder import Plunger, plunger_force
from vvdp.hydraulics.rod import Spring, spring_force

ATMOSPHERE = 101325.0
PSI = 6894.757
PISTON = Plunger(area_a=1.74e-4, moving_mass=0.5)
SPRING = Spring(stiffness=2594.0, preload=211.5, rest_position=0.0)


@pytest.mark.parametrize(("psi", "reach"), [(190.0, 6.34e-3), (220.0, 20.2e-3), (230.0, 24.8e-3), (250.0, 34.08e-3)])
def test_reach_of_a_supply(psi, reach):
    """250 psi would go beyond the 26.4 mm of full use; the stop ends the stroke there."""
    found = static_reach(ATMOSPHERE + psi * PSI, ATMOSPHERE, PISTON, SPRING)
    assert found == pytest.approx(reach, abs=0.06e-3)


def test_position_0_needs_its_gauge_pressure():
    """12.16 bar gauge, F_0/A; the spring is compressed by 81.5 mm there."""
    assert holding_pressure(0.0, ATMOSPHERE, PISTON, SPRING) - ATMOSPHERE == pytest.approx(12.155e5, rel=1e-4)
    assert SPRING.preload / SPRING.stiffness == pytest.approx(81.5e-3, rel=1e-3)


def test_reach_and_holding_pressure_are_inverse_and_in_balance():
    for position in (-6.2e-3, 0.0, 0.01, 0.0264):
        pressure = holding_pressure(position, ATMOSPHERE, PISTON, SPRING)
        assert static_reach(pressure, ATMOSPHERE, PISTON, SPRING) == pytest.approx(position, abs=1e-15)
        force = plunger_force(pressure, ATMOSPHERE, PISTON) + spring_force(position, SPRING)
        assert force == pytest.approx(0.0, abs=1e-10)


def test_absolute_pressure_in_the_balance_would_reach_too_far():
    """With the pressure counted from vacuum the same supply would reach 6.8 mm more: 1 atm A/K."""
    gauge = static_reach(ATMOSPHERE + 190.0 * PSI, ATMOSPHERE, PISTON, SPRING)
    absolute = static_reach(ATMOSPHERE + 190.0 * PSI, 0.0, PISTON, SPRING)
    assert absolute - gauge == pytest.approx(6.797e-3, rel=1e-3)


def test_frequency_of_the_rod_on_its_spring():
    assert spring_frequency(PISTON.moving_mass, SPRING) / (2.0 * np.pi) == pytest.approx(11.464, abs=1e-3)


def test_stiffness_of_the_shut_chamber():
    """beta A^2/V: 1.2e8 Pa, 60 cc: 60.6 kN/m, 23 times the spring's."""
    assert oil_stiffness(60e-6, 1.2e8, PISTON) == pytest.approx(60552.0, rel=1e-5)
