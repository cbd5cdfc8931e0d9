"""The force that makes the errors fade, its exact rate, and the effort."""

import numpy as np
import pytest
from tests.displacement_case import settings_of_chapter_6

from vvdp.base.errors import ParameterError
from vvdp.control.cylinder_force import ForceGains, Motion, desired_force, total_effort
from vvdp.control.reference import Reference

SETTINGS = settings_of_chapter_6()
GAINS, CYLINDER = SETTINGS.gains, SETTINGS.cylinder


def test_force_by_hand():
    """e = 1 mm, e' = 5 mm/s, e_v = 5 + 10 = 15 mm/s, x_d'' = 0.2: 100 (0.2 - 0.05) + 2000 0.055 + 1000 - 90 - 40."""
    reference, motion = Reference(0.1, 0.05, 0.2, 0.0), Motion(0.101, 0.055, -1000.0, 100.0)
    found = desired_force(reference, motion, 0.0, GAINS, CYLINDER)
    assert found.force == pytest.approx(15.0 + 110.0 + 1000.0 - 90.0 - 40.0)
    assert found.velocity_error == pytest.approx(0.015)
    assert found.reference_velocity == pytest.approx(0.04)
    assert found.reference_acceleration == pytest.approx(0.15)


def test_rate_is_the_derivative_along_the_motion():
    """Against a difference quotient over the true motion under a force; quadratic in the step, so 1e-6 of the size."""
    rng, h = np.random.default_rng(8), 1e-5
    for _ in range(30):
        x, v, F, load = (float(each) for each in rng.uniform((0.1, -0.1, -5e3, -3e3), (0.2, 0.1, 5e3, 3e3)))
        p, dp, ddp, j = rng.uniform((0.1, -0.1, -1.0, -10.0), (0.2, 0.1, 1.0, 10.0)).tolist()
        a = (F - CYLINDER.viscous_friction * v + load) / 100.0

        def at(t, x=x, v=v, a=a, p=p, dp=dp, ddp=ddp, j=j, F=F, load=load):
            reference = Reference(p + t * dp + t * t * ddp / 2.0, dp + t * ddp + t * t * j / 2.0, ddp + t * j, j)
            return desired_force(reference, Motion(x + t * v, v + t * a, load, 100.0), F, GAINS, CYLINDER)

        quotient = (at(h).force - at(-h).force) / (2.0 * h)
        assert at(0.0).rate == pytest.approx(quotient, rel=1e-6, abs=0.2)


def test_errors_of_motion_fade_under_the_desired_force():
    """m e_v' = -K_v e_v - K_p e where F_H = F_v (eq. 6.9 in 6.7)."""
    reference, motion = Reference(0.1, 0.05, 0.2, 0.0), Motion(0.103, 0.02, -700.0, 100.0)
    force = desired_force(reference, motion, 0.0, GAINS, CYLINDER).force
    acceleration = (force - CYLINDER.viscous_friction * motion.velocity + motion.load_force) / 100.0
    found = desired_force(reference, motion, force, GAINS, CYLINDER)
    rate = acceleration - found.reference_acceleration
    fading = -GAINS.velocity_gain * found.velocity_error - GAINS.position_gain * found.position_error
    assert 100.0 * rate == pytest.approx(fading, rel=1e-12)


def test_effort_by_hand():
    """S r = 3e6 0.04 = 1.2e5, F_v' at half its weight, 28 1/s times 100 N; robust rate and pressure rate add."""
    reference, motion = Reference(0.1, 0.05, 0.2, 0.0), Motion(0.101, 0.055, -1000.0, 100.0)
    desired = desired_force(reference, motion, 1095.0, GAINS, CYLINDER)
    assert total_effort(3e6, desired, 1095.0, 0.5, GAINS) == pytest.approx(1.2e5 + 0.5 * desired.rate - 2800.0)
    robust = ForceGains(error_rate=10.0, position_gain=4e4, velocity_gain=6e3, pressure_rate=20.0, robust_rate=8.0)
    assert total_effort(3e6, desired, 1095.0, 0.5, robust) == pytest.approx(
        total_effort(3e6, desired, 1095.0, 0.5, GAINS)
    )


@pytest.mark.parametrize("name", ["error_rate", "velocity_gain", "pressure_rate"])
def test_gains_that_damp_nothing_are_refused(name):
    values = {"error_rate": 10.0, "position_gain": 4e4, "velocity_gain": 6e3, "pressure_rate": 28.0}
    with pytest.raises(ParameterError, match=name):
        ForceGains(**{**values, name: 0.0})
