"""A ripple of the speed against a wheel whose edges lie elsewhere: what can be told, and what is taken for granted."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.stats import f

from vvdp.estimation.ripple import displacement, place_of, ripple_start
from vvdp.estimation.smoother import Beliefs
from vvdp.offline.turn_pattern import EXPECTED, SpeedRipple, chance_of, is_whole, ripple_in
from vvdp.sensing.wheel import TURN


def places(edges):
    return np.arange(edges) * (TURN / edges)


def test_offsets_of_a_ripple_by_hand():
    # 3 % at 3 per turn are 0.03/3 = 0.01 rad: at 30 degrees the spool is so much ahead of its mean, the edge early.
    cosine, sine = SpeedRipple(3, 0.03, 0.0, 0.0), SpeedRipple(2, 0.0, 0.04, 0.0)
    assert cosine.offsets(np.array([0.0, TURN / 12.0])) == pytest.approx([0.0, -0.01], abs=1e-15)
    # with a sine of 4 % at 2 per turn it is 0.02 rad behind at 0, where the speed passes its mean
    assert sine.offsets(np.array([0.0, TURN / 8.0])) == pytest.approx([0.02, 0.0], abs=1e-15)
    assert SpeedRipple(2, 0.03, 0.04, 0.0).amplitude == pytest.approx(0.05)


def test_it_is_the_ripple_of_the_filter():
    given, angles = SpeedRipple(3, 0.02, -0.03, 0.0), places(8)
    state = ripple_start(0.0)._replace(cosine=given.cosine, sine=given.sine)
    ahead = [displacement(state, place_of(angle, 3.0)) for angle in angles]
    assert given.offsets(angles) == pytest.approx(-np.array(ahead), abs=1e-15)


def test_the_motion_of_a_course_has_it_and_its_slope():
    """theta = phi - d(theta) to the third order of the ripple; the speed is the slope of the angle to the second."""
    ripple, slope, e = SpeedRipple(3, 0.03, -0.02, 1e-3), 150.0, 1e-6
    times = np.linspace(0.0, 0.1, 200)

    def motion(times):
        zero, one = np.zeros(times.size), np.ones(times.size)
        return ripple.motion(Beliefs(slope * times, slope * one, 1e-6 * one, zero, 0.04 * one))

    here = motion(times)
    assert here.angle + ripple.offsets(here.angle) == pytest.approx(slope * times, abs=ripple.amplitude**3 / 3.0)
    rate = (motion(times + e).angle - motion(times - e).angle) / (2.0 * e)
    assert rate == pytest.approx(here.speed, rel=ripple.amplitude**2)
    # where the ripple is at its mean the course's own deviation is left, and 150 rad/s times what it is known to
    known = 1e-3**2 + ripple.amplitude**4 / 4.0
    assert np.mean(here.speed_variance) == pytest.approx(0.04 + known * slope**2, rel=0.01)
    assert np.mean(here.angle_variance) == pytest.approx(1e-6 + known / 9.0, rel=0.01)


@pytest.mark.parametrize(("order", "cosine", "sine"), [(3, 0.032, 0.0), (2, -0.01, 0.02), (1, 0.005, 0.01)])
def test_a_ripple_shifts_edges_as_it_delays_them(order, cosine, sine):
    """The walk at an edge is the time at which it passes, times the mean speed: the integral of d theta over
    1 + a cos + b sin. Its terms of second order, a^2/(4 N) and smaller, are left out."""
    ripple = SpeedRipple(order, cosine, sine, 0.0)
    angles = places(16)
    times = np.array([quad(lambda x: 1.0 / (1.0 + cosine * np.cos(order * x) + sine * np.sin(order * x)), 0.0, theta)[0]
                      for theta in angles])  # fmt: skip
    mean = quad(lambda x: 1.0 / (1.0 + cosine * np.cos(order * x) + sine * np.sin(order * x)), 0.0, TURN)[0] / TURN
    seen = times / mean - angles
    expected = ripple.offsets(angles)
    rest = (seen - np.mean(seen)) - (expected - np.mean(expected))
    assert np.max(np.abs(rest)) < 1.2 * ripple.amplitude**2 / (4.0 * order)
    found = ripple_in(seen, angles, order)
    assert (found.order, found.cosine, found.sine) == pytest.approx((order, cosine, sine), rel=0.01, abs=1e-4)


def test_an_uneven_wheel_sees_the_same_ripple():
    angles = places(8) + np.array([0.0, 0.2, 0.0, -0.1, 0.0, 0.0, 0.1, 0.0])
    given = SpeedRipple(3, 0.02, -0.03, 0.0)
    found = ripple_in(given.offsets(angles) + 0.7, angles, 3)
    assert found == pytest.approx((3, 0.02, -0.03, 0.0), abs=1e-12)


def test_one_edge_that_lies_elsewhere_is_the_wheels():
    one = np.zeros(8)
    one[5] = 0.1
    assert ripple_in(one - np.mean(one), places(8), 3) is None
    assert ripple_in(np.zeros(8), places(8), 3) is None


@pytest.mark.parametrize("error", [2e-3, 1e-2])
def test_the_odds_are_those_of_two_gaussians(error):
    """Where a ripple of the prior and an error, or the error alone, have the same density, the decision turns."""
    wide = np.sqrt(0.5 * EXPECTED**2 + error**2)

    def odds(amplitude):
        return 2.0 * np.log(error / wide) - 0.5 * amplitude**2 * (1.0 / wide**2 - 1.0 / error**2)

    even = brentq(odds, 0.0, 0.1)
    assert chance_of(SpeedRipple(3, even, 0.0, error)) == pytest.approx(0.5, rel=1e-6)
    assert chance_of(SpeedRipple(3, 0.0, even, error), 1.0 / 3.0) == pytest.approx(0.25, rel=1e-6)
    assert chance_of(SpeedRipple(3, 0.11, 0.0, error)) == 0.0


def test_what_no_spool_does_is_the_wheels():
    assert ripple_in(SpeedRipple(3, 0.099, 0.0, 0.0).offsets(places(8)), places(8), 3) is not None
    assert ripple_in(SpeedRipple(3, 0.101, 0.0, 0.0).offsets(places(8)), places(8), 3) is None


def test_another_order_has_to_explain_the_offsets_nearly_alone():
    other, rest = SpeedRipple(2, 0.02, 0.01, 0.0).offsets(places(16)), np.random.default_rng(1).normal(size=16)
    rest *= np.std(other) / np.std(rest)
    assert ripple_in(other, places(16), 3).order == 2
    # shares of 1/(1 + 0.25^2) = 94 % and 1/(1 + 0.5^2) = 80 %
    assert ripple_in(other + 0.25 * rest, places(16), 3).order == 2
    assert ripple_in(other + 0.5 * rest, places(16), 3) is None
    # one wave over the turn is an eccentric wheel, unless the spool has one section
    eccentric = SpeedRipple(1, 0.02, 0.01, 0.0).offsets(places(16))
    assert ripple_in(eccentric, places(16), 3) is None and ripple_in(eccentric, places(16), 1).order == 1


def test_beside_the_wheels_own_offsets_the_ripple_of_the_spool_stands_out():
    both = SpeedRipple(3, 0.03, 0.02, 0.0).offsets(places(16)) + np.random.default_rng(2).normal(0.0, 5e-3, 16)
    found = ripple_in(both, places(16), 3)
    assert found.order == 3
    assert abs(found.cosine - 0.03) < 3.0 * found.error and abs(found.sine - 0.02) < 3.0 * found.error
    # N sqrt(2/p) of a deviation: the wheel may have as much of the pattern
    assert found.error == pytest.approx(3.0 * np.sqrt(2.0 / 16.0) * 5e-3, rel=0.4)


def test_a_wheel_of_chance_is_seldom_taken_for_a_ripple():
    # 5 % by the level of the test, and of 8 edges 0.1^2.5 = 0.3 % where order 2 stands nearly alone; four deviations
    rng, n = np.random.default_rng(3), 3000
    count = sum(ripple_in(1e-3 * rng.normal(size=8), places(8), 3) is not None for _ in range(n))
    share = 0.05 + 0.95 * 0.1**2.5
    assert abs(count - n * share) < 4.0 * np.sqrt(n * share * (1.0 - share))


def test_the_standard_error_is_that_of_the_wheels_own_offsets():
    # squared error over its variance, mean of both parts: F with 2 and p - 3 degrees; half lie below the median
    rng, given, n = np.random.default_rng(4), SpeedRipple(3, 0.05, -0.05, 0.0), 1000
    below = 0
    for _ in range(n):
        found = ripple_in(given.offsets(places(16)) + rng.normal(0.0, 2e-3, 16), places(16), 3)
        squares = (found.cosine - given.cosine) ** 2 + (found.sine - given.sine) ** 2
        below += squares / (2.0 * found.error**2) < f.median(2, 13)
    assert abs(below - 0.5 * n) < 4.0 * np.sqrt(0.25 * n)


@pytest.mark.parametrize(("order", "edges", "whole"), [(3, 8, True), (3, 7, True), (3, 6, False), (3, 4, False),
                                                       (4, 8, False), (1, 3, False), (1, 4, True)])  # fmt: skip
def test_a_turn_needs_more_than_two_edges_to_a_wave(order, edges, whole):
    assert is_whole(order, edges) is whole
    if not whole:
        # 3 per turn at 4 edges look like 1 per turn, an eccentric wheel: nothing is taken for that ripple
        seen = SpeedRipple(order, 0.03, 0.01, 0.0).offsets(places(edges))
        found = ripple_in(seen - np.mean(seen), places(edges), order)
        assert found is None or found.order != order
