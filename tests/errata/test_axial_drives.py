"""Misprints and gaps of chapters 4 and 5 of wang2017 about the axial drives: each number of a row worked out anew."""

import numpy as np
import pytest

from vvdp.components.library import UsualOil
from vvdp.fluid.mixture import fluid_state
from vvdp.hydraulics.chamber_drive import holding_pressure, static_reach
from vvdp.hydraulics.cylinder import Plunger
from vvdp.hydraulics.rod import Spring
from vvdp.reproduction.chapter_4.observer import printed_jump, printed_trapezoid

PISTON, SPRING = Plunger(area_a=1.74e-4, moving_mass=0.5), Spring(stiffness=2594.0, preload=211.5, rest_position=0.0)
ATMOSPHERE, PSI, INCH = 101325.0, 6894.757, 25.4e-3
AERATED = UsualOil(air_fraction=0.1 / 1.1, liquid_bulk_modulus=1.7e9)
"""10 % of air per oil."""


def reference(t: float, ramp_time: float) -> float:
    """Eq. 4.16 [inch], with the time that its ramps count as `ramp_time`."""
    inside = t % 5.0
    if inside < 1.0:
        return 0.8
    if inside <= 2.0:
        return 0.8 + 0.8 * (ramp_time - 1.0)
    return 1.6 if inside < 4.0 else 1.6 - 0.8 * (ramp_time - 4.0)


def test_printed_trapezoid_jumps():
    """With mod(t, 1) in its ramps it falls from 0.8 to 0 in at 1 s and rises from 1.6 to 4.8 in at 4 s."""
    assert reference(1.0 - 1e-9, 0.0) == pytest.approx(0.8)
    assert reference(1.0, 1.0 % 1.0) == pytest.approx(0.0)
    assert reference(4.0 - 1e-9, 0.0) == pytest.approx(1.6)
    assert reference(4.0, 4.0 % 1.0) == pytest.approx(4.8)
    for t in (0.5, 1.0, 1.3, 2.0, 3.0, 4.0, 4.7, 6.0, 9.0):
        assert printed_trapezoid(t) == pytest.approx(reference(t, t % 1.0) * INCH, abs=1e-12)
    assert printed_jump(1.0) == pytest.approx(-20.32e-3, abs=1e-9)
    assert printed_jump(4.0) == pytest.approx(81.28e-3, abs=1e-9)
    times = np.arange(0.0, 10.0, 1e-3)
    corrected = np.array([reference(t, t % 5.0) for t in times])
    assert np.max(np.abs(np.diff(corrected))) < 0.8e-3 * 1.001
    assert np.ptp(corrected) * INCH == pytest.approx(20.32e-3)
    assert np.max(np.diff(corrected)) * INCH / 1e-3 == pytest.approx(20.32e-3, rel=1e-6)


def test_pressure_of_the_force_balance_is_gauge():
    """The atmosphere is on the other side of the piston: read as absolute, P would reach 6.8 mm further."""
    gauge = static_reach(ATMOSPHERE + 190.0 * PSI, ATMOSPHERE, PISTON, SPRING)
    absolute = static_reach(ATMOSPHERE + 190.0 * PSI, 0.0, PISTON, SPRING)
    assert gauge == pytest.approx(6.34e-3, abs=5e-6)
    assert absolute == pytest.approx(13.13e-3, abs=5e-6)
    assert holding_pressure(0.0, ATMOSPHERE, PISTON, SPRING) - ATMOSPHERE == pytest.approx(12.16e5, rel=1e-3)


def test_bulk_modulus_of_the_gauge_pressure_would_be_too_small():
    """At 12.99 bar gauge, 14 bar absolute: beta of the number 12.99 bar is 11 % less; at 0 gauge hardly any is left."""
    true = fluid_state(14.0e5, AERATED).bulk_modulus
    wrong = fluid_state(14.0e5 - ATMOSPHERE, AERATED).bulk_modulus
    assert wrong / true == pytest.approx(0.887, abs=2e-3)
    assert fluid_state(1e3, AERATED).bulk_modulus < 2e3


def test_supply_of_the_experiments_does_not_reach_the_stroke():
    """20.32 mm take 220.2 psi, full use of the duty ratio 233.4 psi; 190 psi end at 6.34 mm."""
    stroke = (holding_pressure(20.32e-3, ATMOSPHERE, PISTON, SPRING) - ATMOSPHERE) / PSI
    full = (holding_pressure(26.416e-3, ATMOSPHERE, PISTON, SPRING) - ATMOSPHERE) / PSI
    assert stroke == pytest.approx(220.2, abs=0.1)
    assert full == pytest.approx(233.4, abs=0.1)
    assert static_reach(ATMOSPHERE + 190.0 * PSI, ATMOSPHERE, PISTON, SPRING) < 0.32 * 20.32e-3


def test_bulk_modulus_has_no_lower_bound_with_air():
    """1/beta = (a/(n P) + l/b)/(a + l) with a growing as P^(-1/n): beta goes to 0, for P to 0 as n P."""
    phi, n, b, P0 = 0.1 / 1.1, 1.4, 1.7e9, ATMOSPHERE

    def modulus(P: float) -> float:
        a, l = phi * (P0 / P) ** (1.0 / n), (1.0 - phi) * np.exp((P0 - P) / b)
        return (a + l) / (a / (n * P) + l / b)

    assert modulus(2e4) == pytest.approx(1.16e5, rel=5e-3)
    assert modulus(2e4) == pytest.approx(fluid_state(2e4, AERATED).bulk_modulus, rel=1e-9)
    assert [modulus(P) / (n * P) for P in (1.0, 1e-3)] == pytest.approx([1.0, 1.0], abs=5e-3)
    built = [fluid_state(P, AERATED).bulk_modulus for P in np.linspace(0.0, 1e5, 2001)]
    assert min(built) == pytest.approx(1.95e3, rel=1e-2)
