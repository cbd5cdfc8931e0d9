"""What is usual of the filter, brought to the wheel and to the pace of a log."""

from dataclasses import replace

import numpy as np
import pytest

from vvdp.estimation.event_settings import event_filter
from vvdp.offline.beginning import PACE, at_pace
from vvdp.offline.config import Option, load_estimation
from vvdp.sensing.wheel import equal_wheel

USUAL = event_filter(equal_wheel(8))
PITCH = np.pi / 4


def test_a_wheel_of_sixteen_sectors_has_edges_twice_as_exact():
    def variance(**keys):
        given = {"sensor.edges": "edge", **{key.replace("__", "."): value for key, value in keys.items()}}
        return load_estimation(None, [Option(key, key, value) for key, value in given.items()]).filter.edge_variance

    assert variance(sensor__sectors=16) == pytest.approx(3.47e-3 / 4.0, rel=1e-12)
    assert variance(sensor__sectors=8) == variance() == USUAL.edge_variance
    assert variance(sensor__sectors=16, filter__edge_variance="2e-3 rad^2") == 2e-3


def test_ten_times_slower_by_hand():
    """15.5 rad/s: a thousandth of q, a hundredth of the variance; in the 50.7 ms of a sector the speed may change by
    itself, 15.5^2/0.0507 = 4742 rad^2/s^3."""
    slow = at_pace(USUAL, 10.0 * PITCH / PACE)
    assert slow.acceleration_density == pytest.approx(0.25e-3, rel=1e-12)
    assert slow.speed_variance == pytest.approx(10.0, rel=1e-12)
    assert slow.lowest_speed == pytest.approx(0.2 * np.pi, rel=1e-12)
    assert slow.stop_rate == pytest.approx(1e-3, rel=1e-12)
    assert slow.manoeuvre_density == pytest.approx(4742.0, rel=1e-3)
    assert slow.edge_variance == USUAL.edge_variance


@pytest.mark.parametrize("times", [0.0, 0.1, 1.0, 3.9])
def test_near_its_pace_nothing_changes(times):
    assert at_pace(USUAL, times * PITCH / PACE) is USUAL


def test_what_was_given_stays():
    given = replace(USUAL, acceleration_density=0.1, stop_rate=0.0)
    slow = at_pace(given, 10.0 * PITCH / PACE)
    assert (slow.acceleration_density, slow.stop_rate) == (0.1, 0.0)
    assert slow.speed_variance == pytest.approx(10.0, rel=1e-12)
