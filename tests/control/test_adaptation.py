"""What is learned: rates by hand, bounds, and the terms that they take out of the rate of the storage."""

import pytest

from vvdp.base.errors import ParameterError
from vvdp.control.adaptation import Adaptation, Excitation, adaptation_start, adaptation_step

ALL = Adaptation(load_gain=4e4, mass_gain=2e4, compliance_gain=1e-19)
SEEN = Excitation(
    load_force=-1000.0,
    velocity_error=0.01,
    reference_acceleration=0.5,
    force_error=200.0,
    force_rate=1e4,
    slenderness=4e-3,
)


def test_rates_by_hand():
    """4e4 0.01 = 400 N/s, -2e4 0.01 0.5 = -100 kg/s, -1e-19 200 1e4/4e-3 = -5e-11 1/(Pa s); over 10 ms."""
    found = adaptation_step(adaptation_start(100.0, 1e9), SEEN, 0.01, ALL)
    assert found == pytest.approx((4.0, 99.0, 1e-9 - 5e-13), rel=1e-12)


def test_what_has_no_gain_stays():
    """Also outside bounds that it would be held to."""
    start = adaptation_start(5.0, 1e11)
    assert adaptation_step(start, SEEN, 0.01, Adaptation()) == start


def test_bounds_hold_the_load_itself_not_its_correction():
    found = adaptation_step(adaptation_start(100.0, 1e9), SEEN._replace(velocity_error=1e3), 1.0, ALL)
    assert found.load_correction + SEEN.load_force == pytest.approx(5e3)
    assert found.moving_mass == 20.0
    assert adaptation_step(found, SEEN._replace(velocity_error=-1e3), 1.0, ALL)[:2] == pytest.approx((-4e3, 600.0))
    assert adaptation_step(found, SEEN._replace(force_error=-1e9), 1.0, ALL).compliance == 5e-9


def test_learning_cancels_its_own_terms_in_the_rate_of_the_storage():
    """With errors dF, dm, dc of what is believed, W' gets e_v (dm r' - dF) + (F_H - F_v) F_v' dc/L, and
    dF^2/(2 g_F) + dm^2/(2 g_m) + dc^2/(2 g_b) the opposite."""
    rate = 1e-6
    before = adaptation_start(100.0, 1e9)
    after = adaptation_step(before, SEEN, rate, ALL)
    dF, dm, dc = 300.0, -40.0, 2e-10
    grown = [(b - a) / rate for a, b in zip(before, after, strict=True)]
    parameters = dF * grown[0] / ALL.load_gain + dm * grown[1] / ALL.mass_gain + dc * grown[2] / ALL.compliance_gain
    ev, dr = SEEN.velocity_error, SEEN.reference_acceleration
    storage = ev * (dm * dr - dF) + SEEN.force_error * SEEN.force_rate * dc / SEEN.slenderness
    assert parameters == pytest.approx(-storage, rel=1e-6)


def test_bounds_that_cross_are_refused():
    with pytest.raises(ParameterError, match="lowest_mass"):
        Adaptation(lowest_mass=700.0)
