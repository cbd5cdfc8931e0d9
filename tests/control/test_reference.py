"""The filtered reference against another discretisation, its derivatives, and the published trapezoid."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import cont2discrete

from vvdp.base.errors import ParameterError
from vvdp.base.signal import signal_value, table
from vvdp.control.reference import Pauses, Reference, ReferenceFilter, reference_at_rest, reference_step, trapezoid

FILTER = ReferenceFilter(filter_rate=150.0)


def companion(w):
    """The filter as x' = A x + B u of position, velocity, acceleration and jerk."""
    A = np.diag(np.ones(3), 1)
    A[3] = -(w**4), -4.0 * w**3, -6.0 * w**2, -4.0 * w
    return A, np.array([[0.0], [0.0], [0.0], [w**4]])


@pytest.mark.parametrize("interval", [1e-4, 1e-3, 0.02, 1.0])
def test_step_is_the_exact_discretisation_of_four_poles(interval):
    """Against SciPy's matrix exponential, in the time of the filter: w = 1, where the matrix is well scaled."""
    w = FILTER.filter_rate
    A, B = companion(1.0)
    Ad, Bd, *_ = cont2discrete((A, B, np.eye(4), np.zeros((4, 1))), w * interval, method="zoh")
    scale = np.array([1.0, w, w**2, w**3])
    rng = np.random.default_rng(1)
    for before, wanted in zip(rng.normal(size=(20, 4)), rng.normal(size=20), strict=True):
        found = np.array(reference_step(Reference(*(before * scale)), wanted, interval, FILTER)) / scale
        assert found == pytest.approx(Ad @ before + Bd[:, 0] * wanted, abs=1e-13 * 20)


def test_step_response_by_hand():
    """At w t = 1 a unit step has come to 1 - e^-1 (1 + 1 + 1/2 + 1/6), its velocity to w e^-1/6."""
    found = reference_step(reference_at_rest(0.0), 1.0, 1.0 / 150.0, FILTER)
    assert found.position == pytest.approx(1.0 - np.exp(-1.0) * (8.0 / 3.0), rel=1e-13)
    assert found.velocity == pytest.approx(150.0 * np.exp(-1.0) / 6.0, rel=1e-13)
    assert found.acceleration == pytest.approx(150.0**2 * np.exp(-1.0) * (1 / 2 - 1 / 6), rel=1e-12)
    assert found.jerk == pytest.approx(150.0**3 * np.exp(-1.0) * (1.0 - 1.0 + 1 / 6), rel=1e-12)


@given(st.floats(0.0, 0.1), st.floats(0.0, 0.1), st.floats(-0.02, 0.02))
def test_two_steps_are_one(first, second, wanted):
    start = Reference(0.01, 0.1, -3.0, 200.0)
    once = reference_step(start, wanted, first + second, FILTER)
    twice = reference_step(reference_step(start, wanted, first, FILTER), wanted, second, FILTER)
    size = np.array([0.02, 3.0, 450.0, 7e4])
    assert np.max(np.abs(np.array(once) - np.array(twice)) / size) < 1e-12


def test_derivatives_are_those_of_the_position():
    """Fourth-order differences over a twentieth of the filter's time."""
    h, start, wanted = 0.05 / 150.0, Reference(0.0, 0.1, 5.0, -100.0), 0.01
    points = [reference_step(start, wanted, 0.01 + i * h, FILTER) for i in (-2, -1, 1, 2)]
    middle = reference_step(start, wanted, 0.01, FILTER)
    for lower, higher in (("position", "velocity"), ("velocity", "acceleration"), ("acceleration", "jerk")):
        a, b, c, d = (getattr(point, lower) for point in points)
        assert (a - 8.0 * b + 8.0 * c - d) / (12.0 * h) == pytest.approx(getattr(middle, higher), rel=2e-4)


def test_a_ramp_is_followed_four_time_constants_late():
    x, slope, period = reference_at_rest(0.0), 0.4, 1e-4
    for k in range(10000):
        x = reference_step(x, slope * k * period, period, FILTER)
    # held over the sample, the raw ramp is half a period late itself
    assert x.position == pytest.approx(slope * (1.0 - 4.0 / 150.0 - 0.5 * period), rel=1e-6)
    assert x.velocity == pytest.approx(slope, rel=1e-5)


def test_published_trapezoid():
    """(4.16) with mod(t, 5) in all its branches, inches: continuous, and the same in every period."""

    def corrected(t):
        s = t % 5.0
        ways = 0.8, 0.8 + 0.8 * (s - 1.0), 1.6, 1.6 - 0.8 * (s - 4.0)
        return ways[int(s >= 1.0) + int(s > 2.0) + int(s >= 4.0)]

    signal = table(*zip(*trapezoid(0.8, 1.6, Pauses(1.0, 2.0), 1.0, periods=3), strict=True))
    for t in np.linspace(0.0, 14.999, 1234):
        assert signal_value(t, signal) == pytest.approx(corrected(t), abs=1e-12)
    assert signal_value(40.0, signal) == pytest.approx(0.8)


def test_a_filter_that_never_moves_is_refused():
    with pytest.raises(ParameterError, match="must be greater than 0"):
        ReferenceFilter(filter_rate=0.0)
