"""The figures of the campaign, of errors whose honesty is known."""

import numpy as np
import pytest
from tests.campaign.scoring import Traces, band, coverage, errors, independent_edges, pool, stands, wrong_by_a_factor

TIME = np.arange(2000) * 1e-3


def traces(off_angle=0.0, off_speed=0.0, speed=100.0, deviation=1.0):
    true = np.column_stack([100.0 * TIME, np.broadcast_to(speed, TIME.shape)])
    off = np.column_stack([np.broadcast_to(each, TIME.shape) for each in (off_angle, off_speed)])
    return Traces(TIME, true + off, true, np.full_like(true, deviation))


def test_normal_errors_are_covered_as_they_should():
    """95.45 % of normal errors lie within two deviations; of 2000 that is known to 0.47 %. Their NEES is 1 +- 0.03."""
    random = np.random.default_rng(2)
    found = pool([errors(traces(random.normal(size=2000), random.normal(size=2000)), 1e9, 2000.0)])
    assert (found.speed_coverage, found.angle_coverage) == pytest.approx((0.9545, 0.9545), abs=4 * 0.0047)
    assert found.low < found.speed_nees < found.high and found.low < found.angle_nees < found.high
    assert (found.low, found.high) == pytest.approx((1.0 - 0.104, 1.0 + 0.104), abs=0.005)  # 3.29 sqrt(2/2000)


def test_where_the_wheel_stood_at_first_is_not_known():
    found = errors(traces(off_angle=3.0 * 0.7 + 0.05), 0.7, 10.0)
    assert found.angle == pytest.approx(0.05)


def test_a_sector_lost_on_the_way_counts():
    found = errors(traces(off_angle=np.where(TIME > 1.0, 0.7, 0.0), deviation=0.1), 0.7, 10.0)
    assert coverage(found.angle) == pytest.approx(0.5, abs=1e-3)


def test_what_stands_counts_by_itself():
    """From 1 s on the wheel stands; a tenth of a second of that still counts as moving."""
    stopped = traces(speed=np.where(TIME < 1.0, 100.0, 0.0))
    assert stands(stopped).sum() == pytest.approx(900, abs=2)
    found = errors(stopped, 1e9, 10.0)
    assert found.speed.size + found.still.shape[0] == TIME.size and found.still.shape == (stands(stopped).sum(), 2)


def test_what_nobody_can_know_yet_is_covered_or_not_but_no_normal_error():
    found = errors(traces(off_speed=np.where(TIME > 1.0, 30.0, 0.0)), 1e9, 10.0, ((1.0, 1.5),))
    assert coverage(found.speed) == pytest.approx(0.5, abs=2e-3)
    assert np.count_nonzero(~found.knowable) == pytest.approx(500, abs=2)
    assert pool([found]).speed_nees == pytest.approx(900.0 * 499 / 1499, rel=5e-3)


def test_a_filter_that_remembers_has_fewer_independent_errors():
    """An edge every 5 ms, R = 4e-3 rad^2, q = 0.25 rad^2/s^3: (4e-3 5e-3/0.25)^(1/4) = 94.6 ms each."""
    assert independent_edges(np.arange(0.0, 2.0, 5e-3), 0.25, 4e-3) == pytest.approx(1.995 / 94.57e-3, rel=1e-3)
    assert independent_edges(np.arange(0.0, 2.0, 0.5), 0.25, 1e-12) == pytest.approx(3.0)


def test_the_band_holds_as_often_as_it_says():
    """Of 100 000 means of 20 squares a thousandth lies outside, 100 +- 40."""
    low, high = band(20.0)
    means = np.random.default_rng(3).chisquare(20.0, 100_000) / 20.0
    assert np.count_nonzero((means < low) | (means > high)) == pytest.approx(100, abs=40)


@pytest.mark.parametrize(("off", "wrong"), [(0.0, False), (-19.0, False), (-21.0, True), (26.0, True)])
def test_a_factor_is_told(off, wrong):
    assert wrong_by_a_factor(traces(off_speed=off), 100.0) is wrong
    short = np.where(TIME < 0.3, off, 0.0)
    assert wrong_by_a_factor(traces(off_speed=short), 100.0) is False


def test_a_deviation_may_say_it():
    assert wrong_by_a_factor(traces(off_speed=30.0, deviation=14.0), 100.0) is True
    assert wrong_by_a_factor(traces(off_speed=30.0, deviation=16.0), 100.0) is False


def test_next_to_nothing_is_no_factor():
    stopped = np.where(TIME < 1.0, 100.0, 0.0)
    assert wrong_by_a_factor(traces(off_speed=4.0, speed=stopped), 100.0) is False
    assert wrong_by_a_factor(traces(off_speed=6.0, speed=stopped), 100.0) is True
