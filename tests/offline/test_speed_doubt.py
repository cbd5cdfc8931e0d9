"""Doubt about the speed: ripples that make the same edges, and those that the wheel's offsets hide."""

import numpy as np
import pytest
from tests.offline.rippling import passing_times
from tests.words import wording

from vvdp.offline.speed_doubt import NO_DOUBT, Doubt, doubt_of, ripple_doubt
from vvdp.offline.turn_pattern import EXPECTED, Candidate, SpeedRipple, candidates

TURN = 2.0 * np.pi
SPEED = 100.0
THREE, FIVE = SpeedRipple(3, 0.02, 0.0, 0.0), SpeedRipple(5, 0.0, 0.03, 0.0)
BOTH = (Candidate(THREE, 0.75), Candidate(FIVE, 0.25))


def orders(found):
    return sorted(each.ripple.order for each in found)


def test_two_orders_by_hand():
    """Of 0.02 with 3/4 and of 0.03 with 1/4: (0.75 4e-4 + 0.25 9e-4)/2 = 2.625e-4 of the squared speed if neither is
    estimated; if the first is, the second counts as 1/2: 0.5 (4e-4 + 9e-4)/2 = 3.25e-4."""
    ratio, angle = ripple_doubt(BOTH, SpeedRipple(0, 0.0, 0.0, 0.0))
    assert (ratio, angle) == pytest.approx((2.625e-4, 0.5 * (0.75 * 4e-4 / 9 + 0.25 * 9e-4 / 25)), rel=1e-12)
    ratio, angle = ripple_doubt(BOTH, THREE)
    assert (ratio, angle) == pytest.approx((3.25e-4, 0.25 * (4e-4 / 9 + 9e-4 / 25)), rel=1e-12)
    seldom = (Candidate(THREE, 0.96), Candidate(FIVE, 0.04))
    assert ripple_doubt(seldom, THREE)[0] == pytest.approx(0.02 * 13e-4, rel=1e-12)
    assert Doubt(1.625e-4, 0.0).speed_deviation(100.0) == pytest.approx(np.sqrt(1.625), rel=1e-12)


def test_the_doubt_is_the_mean_square_of_the_difference_of_two_waves():
    """A ripple of 5 while one of 3 is estimated, over one turn: what `ripple_doubt` has for the whole of a chance."""
    angles = np.arange(4096) * TURN / 4096
    error = 0.02 * np.cos(3 * angles) - 0.03 * np.sin(5 * angles)
    assert ripple_doubt((Candidate(FIVE, 1.0),), THREE)[0] == pytest.approx(np.mean(error**2), rel=1e-12)


def test_a_pattern_that_may_be_the_wheels_tells_no_more_than_was_expected():
    """The mean square lies between that seen of exact offsets, and that expected beforehand of useless ones."""
    assert SpeedRipple(3, 0.02, 0.01, 0.0).expected_square == pytest.approx(5e-4, rel=1e-12)
    assert SpeedRipple(3, 0.02, 0.01, 1e3).expected_square == pytest.approx(EXPECTED**2, rel=1e-6)
    # as likely the wheel's as the motion's: k = 1/2, 0.01^2 + 2 0.5 t^2
    half = SpeedRipple(3, 0.02, 0.0, np.sqrt(0.5) * EXPECTED)
    assert half.expected_square == pytest.approx(1e-4 + 0.5 * EXPECTED**2, rel=1e-12)


@pytest.mark.parametrize(("sectors", "order"), [(8, 3), (8, 5), (10, 3), (12, 2), (14, 4)])
def test_of_an_even_wheel_all_aliases_fit(sectors, order):
    angles = np.arange(sectors) * TURN / sectors
    offsets = SpeedRipple(order, 0.006, -0.004, 0.0).offsets(angles)
    found = candidates(offsets, angles, order, 1e-12)
    most = 2 * sectors
    same = [k for k in range(2, most) if (k - order) % sectors == 0 or (k + order) % sectors == 0]
    seen = {each.ripple.order: each.ripple for each in found}
    possible = [k for k in same if k * np.hypot(0.006, 0.004) / order <= 0.1]
    assert orders(found) == possible
    assert sum(each.chance for each in found) == pytest.approx(1.0, rel=1e-12)
    for other, ripple in seen.items():  # the amplitude of the offsets is one
        assert ripple.amplitude / other == pytest.approx(np.hypot(0.006, 0.004) / order, rel=1e-6)


@pytest.mark.parametrize("order", [2, 3, 5])
def test_an_index_tells_the_orders_apart(order):
    angles = np.arange(8) * TURN / 8
    angles[1] += 0.25 * TURN / 8
    offsets = SpeedRipple(order, 0.02, 0.01, 0.0).offsets(angles)
    assert orders(candidates(offsets, angles, order, 1e-10)) == [order]
    # with edges that scatter by more than the patterns differ all are possible again
    assert len(candidates(offsets, angles, order, 1e-3)) > 1


def test_a_pattern_too_large_for_a_ripple_is_none():
    angles = np.arange(8) * TURN / 8
    assert candidates(SpeedRipple(3, 0.15, 0.0, 0.0).offsets(angles), angles, 3, 1e-12) == ()


def log_of(places, order, amplitude, turns=120, jitter=0.002):
    """The angles of edges at `places` on the wheel, met by a spool whose speed ripples."""
    angles = (TURN * np.arange(turns)[:, None] + places).ravel()[1:]
    seen = angles + np.random.default_rng(5).normal(0.0, jitter, angles.size)
    return passing_times(seen, order, amplitude, SPEED)


def error_of(kept, order, amplitude):
    """Errors of the speed [rad/s] after the second turn, and their stated deviations."""
    t = kept.column("time")
    fine = np.linspace(0.0, SPEED * (t[-1] + 0.1), 400_000)
    at = np.interp(t, passing_times(fine, order, amplitude, SPEED), fine)
    used = (t > 0.3) & np.isfinite(kept.column("speed"))
    true = SPEED * (1.0 + amplitude * np.cos(order * at))
    return (kept.column("speed") - true)[used], kept.column("speed_deviation")[used]


@pytest.mark.parametrize("fit", [False, True])
def test_an_order_that_looks_like_another_is_named_and_covered(estimated, fit):
    """Five per turn on eight edges look like three: without the doubt the squared error is 95 to 411 times stated."""
    log = {"edge": (log_of(np.arange(8) * TURN / 8, 5, 0.02), "s")}
    kept = estimated(log, sensor__edges="edge", filter__fit=fit or None)
    assert kept.result.tables["ripples"]["order"].tolist()[:3] == [3.0, 5.0, 11.0]
    error, stated = error_of(kept, 5, 0.02)
    assert np.mean(error**2) < 5.0 * np.mean(stated**2)
    assert kept.summary["speed_doubt_rad_s"] == pytest.approx(np.median(stated), rel=0.1)
    said = " ".join(finding.text for finding in kept.findings)
    assert wording.estimate.same_edges in said


@pytest.mark.sampled(3)
@pytest.mark.parametrize("fit", [False, True])
@pytest.mark.parametrize("amplitude", [0.01, 0.05])
def test_uneven_sectors_do_not_hide_a_ripple_without_doubt(estimated, amplitude, fit):
    """Sectors off by 5 %: the offsets took all of the ripple, and the squared error was 40 to 770 times stated."""
    places = np.arange(8) * TURN / 8 + np.random.default_rng(2).normal(0.0, 0.05 * TURN / 8, 8)
    kept = estimated({"edge": (log_of(places, 3, amplitude), "s")}, sensor__edges="edge", filter__fit=fit or None)
    error, stated = error_of(kept, 3, amplitude)
    assert np.mean(error**2) < 4.0 * np.mean(stated**2)
    assert np.mean(stated**2) < (EXPECTED * SPEED) ** 2  # no more than is expected of any spool
    assert wording.estimate.hidden_ripple in {finding.title for finding in kept.findings}


def test_a_sound_record_has_no_doubt(estimated):
    kept = estimated({"edge": (log_of(np.arange(8) * TURN / 8, 3, 0.0, jitter=0.03), "s")}, sensor__edges="edge")
    assert kept.summary["speed_doubt_rad_s"] == 0.0
    assert kept.result.tables["ripples"].rows == 0
    assert doubt_of(None, 0.0) == NO_DOUBT


def test_edges_that_may_be_counted_wrongly_count_in_the_angle():
    doubt = Doubt(0.0, 0.01).with_count(2.0, 0.5)
    assert (doubt.angle, doubt.miscounted) == pytest.approx((1.01, 2.0), rel=1e-12)
