"""What flows and motion do to the force of the oil, by hand and against the equations of the pressures."""

from dataclasses import replace

import numpy as np
import pytest
from tests.displacement_case import ATMOSPHERE, settings_of_chapter_6

from vvdp.base.errors import ParameterError
from vvdp.control.capacities import CircuitPressures, SupplyLine, capacities, oil_force, return_flow, sides

CYLINDER = settings_of_chapter_6().cylinder
LINE = SupplyLine(oil_volume=4e-4, hose_compliance=0.0, gas_volume=1e-4, precharge_pressure=5e5, gas_exponent=1.25)


def test_bare_cylinder_by_hand():
    """x = 0.1 m: V_a = 1.0 + 0.2026 = 1.2026 l, V_b = 1.2 - 0.1077 = 1.0923 l, beta 7e8 Pa.

    H = 7e8 20.26e-4/1.2026e-3 = 1.17928e9, G = 7e8 10.77e-4/1.0923e-3 = 6.90195e8 N/m^3,
    S = 20.26e-4 H + 10.77e-4 G = 2.38922e6 + 7.43340e5 N/m.
    """
    found = capacities(1.0, 0.1, ATMOSPHERE, CYLINDER)
    assert found == pytest.approx((1.17928e9, 6.90195e8, 3.13256e6), rel=1e-5)


def test_signs_and_sides_go_with_the_direction():
    """Retracting, H belongs to chamber b and G to chamber a, both below zero; S is the same without a line."""
    out, back = capacities(1.0, 0.1, ATMOSPHERE, CYLINDER), capacities(-1.0, 0.1, ATMOSPHERE, CYLINDER)
    assert (back.supply_gain, back.return_gain) == (-out.return_gain, -out.supply_gain)
    assert back.stiffness == pytest.approx(out.stiffness, rel=1e-15)
    pressures = CircuitPressures(2e6, 3e6, 1e6)
    assert sides(1.0, pressures, CYLINDER) == (CYLINDER.area_a, CYLINDER.area_b, 2e6, 3e6)
    assert sides(-1.0, pressures, CYLINDER) == (CYLINDER.area_b, CYLINDER.area_a, 3e6, 2e6)


def test_line_and_gas_soften_the_supply_by_hand():
    """At 20 bar the gas takes 1e-4 (5/20)^0.8 = 3.2988e-5 m^3 and yields that/(1.25 2e6) = 1.31951e-11 m^3/Pa; line
    and chamber (1.2026e-3 + 4e-4)/7e8 = 2.28943e-12, together 1.54845e-11; H = 20.26e-4 over it."""
    cylinder = replace(CYLINDER, line=LINE)
    found = capacities(1.0, 0.1, 2e6, cylinder)
    assert found.supply_gain == pytest.approx(20.26e-4 / 1.54845e-11, rel=2e-4)  # the seat of the bladder: 3e-5
    assert found.return_gain == capacities(1.0, 0.1, 2e6, CYLINDER).return_gain
    below = capacities(1.0, 0.1, 2e5, cylinder).supply_gain
    assert below == pytest.approx(20.26e-4 / 2.28943e-12, rel=1e-2)


def test_rate_of_the_force_is_that_of_the_pressures():
    """F_H' = H Q + G Psi u - S v, with P' = beta/V (flows - dV/dt) in each chamber (eqs. 6.1 to 6.3)."""
    rng = np.random.default_rng(3)
    for _ in range(50):
        direction = float(rng.choice((-1.0, 1.0)))
        x, v, Q, u = (float(each) for each in rng.uniform((0.05, -0.1, 0.0, 0.0), (0.3, 0.1, 4e-4, 1.0)))
        P = CircuitPressures(*rng.uniform(3e5, 8e6, 3).tolist())
        at = sides(direction, P, CYLINDER)
        out = u * return_flow(at.return_pressure, 1e-9, CYLINDER)
        into_a, into_b = (Q, -out) if direction > 0.0 else (-out, Q)
        A, B, beta = CYLINDER.area_a, CYLINDER.area_b, CYLINDER.bulk_modulus
        rate_a = beta / (CYLINDER.oil_volume_a + A * x) * (into_a - A * v)
        rate_b = beta / (CYLINDER.oil_volume_b - B * x) * (into_b + B * v)
        found = capacities(direction, x, ATMOSPHERE, CYLINDER)
        rate = found.supply_gain * Q + found.return_gain * out - found.stiffness * v
        assert rate == pytest.approx(A * rate_a - B * rate_b, rel=1e-10, abs=1e-3)


def test_force_by_hand():
    """20 bar gauge on 20.26 cm^2 and 30 bar on 10.77 cm^2: 4052 - 3231 = 821 N."""
    P = CircuitPressures(20e5 + ATMOSPHERE, 30e5 + ATMOSPHERE, ATMOSPHERE)
    assert oil_force(P, CYLINDER) == pytest.approx(821.0)


def test_return_flow_by_hand_and_floor():
    """0.8e-7 sqrt(25e5) = 1.26491e-4 m^3/s; below tank pressure the floor."""
    assert return_flow(25e5 + ATMOSPHERE, 1e-5, CYLINDER) == pytest.approx(1.26491e-4, rel=1e-5)
    assert return_flow(0.5 * ATMOSPHERE, 1e-5, CYLINDER) == 1e-5


def test_position_beyond_the_stroke_counts_as_its_end():
    """A sensor that is off must not empty a chamber."""
    assert capacities(1.0, 9.0, ATMOSPHERE, CYLINDER) == capacities(1.0, 0.35, ATMOSPHERE, CYLINDER)


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"area_a": 0.0}, "area_a"),
        ({"oil_volume_a": 0.0}, "oil_volume_a"),
        ({"oil_volume_b": 3e-4}, "oil_volume_b"),
        ({"return_conductance": 0.0}, "return_conductance"),
        ({"lowest_position": 0.4}, "lowest_position"),
    ],
)
def test_impossible_cylinders_are_refused(change, word):
    with pytest.raises(ParameterError, match=word):
        replace(CYLINDER, **change)


def test_gas_without_precharge_is_refused():
    with pytest.raises(ParameterError, match="precharge_pressure"):
        replace(LINE, precharge_pressure=0.0)
