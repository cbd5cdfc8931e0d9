"""Certificates, poles and sampling limits against matrices and eigenvalues."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vvdp.control.chamber import desired_rate_sensitivities
from vvdp.control.tuning import (
    backstepping_certificate,
    held_sampling_limits,
    passivity_certificate,
    sampled_radius,
    sampling_limits,
    sampling_warning,
)

COMPLIANCES = st.floats(-13.5, -10.5).map(lambda power: 10.0**power)


def matrix(weight, corner, gains, drive):
    """The matrices of (5.38) and (5.41): `weight` is V/beta or lambda_2."""
    alpha = desired_rate_sensitivities(gains, drive)
    e, ev = 0.5 * weight * alpha.position, 0.5 * weight * alpha.velocity
    first, mixed = gains.error_rate * (drive.stiffness + gains.position_gain), -0.5 * gains.friction * gains.error_rate
    return np.array([[first, mixed, e], [mixed, gains.velocity_gain + gains.friction, ev], [e, ev, corner]])


def is_positive(M):
    """Positive definite, its variables scaled so that eigenvalues can be told from rounding."""
    scale = 1.0 / np.sqrt([M[0, 0], M[1, 1], max(abs(M[2, 2]), 1e-300)])
    return np.min(np.linalg.eigvalsh(M * np.outer(scale, scale))) > 0.0


@given(COMPLIANCES, st.floats(-12.0, -8.0).map(lambda power: 10.0**power), st.sampled_from([0.0, 20.0, 210.0, 1e4]))
def test_passivity_certificate_is_that_of_its_matrix(drive, passive, compliance, flow_gain, friction):
    passive = replace(passive, friction=friction)
    found = passivity_certificate(compliance, flow_gain, passive, drive)
    alpha = desired_rate_sensitivities(passive, drive)
    if np.isinf(found.needed) or abs(found.margin) > 1e-6 * max(abs(found.offered), found.needed):
        corner = flow_gain + alpha.pressure * compliance
        assert found.holds == is_positive(matrix(compliance, corner, passive, drive))


@given(COMPLIANCES)
def test_backstepping_certificate_is_that_of_its_matrix(drive, backstepping, compliance):
    found = backstepping_certificate(compliance, backstepping, drive)
    if abs(found.margin) > 1e-6 * max(abs(found.offered), found.needed):
        corner = 4e-10 * 3e-12 / compliance - 140.0 * 3e-12
        assert found.holds == is_positive(matrix(3e-12, corner, backstepping, drive))


def test_published_gains_of_the_passivity_law_are_certified(drive, passive):
    """3.7e-10 against 1.2e-12 at V/beta = 5e-13, 2.3e-10 against 4.3e-11 at 3e-12."""
    here, soft = (passivity_certificate(c, 4e-10, passive, drive) for c in (5e-13, 3e-12))
    assert (here.offered, here.needed) == (pytest.approx(3.71e-10, rel=1e-6), pytest.approx(1.19e-12, rel=5e-3))
    assert (soft.offered, soft.needed) == (pytest.approx(2.26e-10, rel=1e-6), pytest.approx(4.28e-11, rel=5e-3))
    assert here.holds and soft.holds


def test_published_gains_of_backstepping_are_not_certified_with_much_air(drive, backstepping):
    """lambda_2 = V/beta = 3e-12: 4e-10 - 140 * 3e-12 = -2e-11. At 5e-13 they are, with 3.3e-10 against 4.4e-12."""
    soft = backstepping_certificate(3e-12, backstepping, drive)
    assert soft.offered == pytest.approx(-2e-11, rel=1e-9)
    assert not soft.holds
    stiff = backstepping_certificate(5e-13, replace(backstepping, pressure_weight=5e-13), drive)
    assert (stiff.offered, stiff.needed) == (pytest.approx(3.3e-10, rel=1e-9), pytest.approx(4.41e-12, rel=5e-3))
    assert stiff.holds


def test_sampling_limits_of_the_published_gains():
    """811 1/s: 2.47 ms; with 1 % air 4895 1/s: 0.41 ms, between the 0.4 ms that work and the 0.6 ms that do not."""
    assert sampling_limits(4e-10, 4.93e-13) == pytest.approx((811.4, 2.465e-3, 1.2325e-3), rel=1e-4)
    assert sampling_limits(4e-10, 4e-10 / 4895.0).limit == pytest.approx(0.4086e-3, rel=1e-3)


def test_sampling_warnings():
    limits = sampling_limits(4e-10, 4.93e-13)
    assert sampling_warning(limits, 1e-3) == ""
    assert sampling_warning(limits, 2e-3).endswith("a sample period of 2 ms is above the 1.23 ms advised")
    assert "sampled every 4 ms it will limit-cycle: its limit is 2.47 ms" in sampling_warning(limits, 4e-3)


def test_a_loop_that_is_sampled_often_has_the_poles_of_the_continuous_one(drive, passive):
    """e' = e_v - l e, M e_v' = -(K + K_p) e - K_v e_v + A p and C p' = -lambda_3 p - A e_v: its slowest pole."""
    C, M, A, l, Kv = 5e-13, 0.5, 1.74e-4, 50.0, 4.0
    loop = np.array([[-l, 1.0, 0.0], [-(2594.0 + 55.0) / M, -Kv / M, A / M], [0.0, -A / C, -4e-10 / C]])
    slowest = np.max(np.linalg.eigvals(loop).real)
    radius = sampled_radius(1e-6, 4e-10, C, passive, drive)
    assert (radius - 1.0) / 1e-6 == pytest.approx(slowest, rel=2e-3)


def test_sampling_limit_of_a_held_law(drive, passive):
    """5.08e-13 m^3/Pa at 5.25 mm: 2.25 ms with the whole gain, 5.95 ms with its mean over the hold."""
    C = 5.0756e-13
    assert sampled_radius(2.2e-3, 4e-10, C, passive, drive) < 1.0 < sampled_radius(2.3e-3, 4e-10, C, passive, drive)
    limits = held_sampling_limits(C, passive, drive)
    assert limits.limit == pytest.approx(5.95e-3, rel=2e-3)
    assert limits.recommended == 0.5 * limits.limit
    assert "5.95 ms" in sampling_warning(limits, 6e-3) and not sampling_warning(limits, 2.9e-3)
