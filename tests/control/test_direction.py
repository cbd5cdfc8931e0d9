"""The direction: the bare sign chatters, hysteresis and dwell hold it."""

import pytest

from vvdp.control.direction import DirectionSettings, direction_start, direction_step

S = 3e6


def follow(efforts, settings):
    """The directions that a row of efforts gives, 10 ms apart."""
    memory, found = direction_start(), []
    for effort in efforts:
        memory = direction_step(memory, effort, S, 0.01, settings)
        found.append(memory.direction)
    return found


def test_bare_sign():
    assert follow([1.0, -1.0, 0.0, -1.0], DirectionSettings()) == [1.0, -1.0, 1.0, -1.0]


def test_first_sample_takes_the_sign_whatever_the_hysteresis():
    assert follow([-1.0], DirectionSettings(hysteresis=1e4, dwell=1.0)) == [-1.0]


def test_hysteresis_holds_the_direction_until_exceeded():
    efforts = [2e4, -9e3, -1.1e4, 9e3, 1.1e4]
    assert follow(efforts, DirectionSettings(hysteresis=1e4)) == [1.0, 1.0, -1.0, -1.0, 1.0]


def test_hysteresis_scales_with_the_stiffness():
    """0.012 m/s times 3e6 N/m: 3.6e4 N/s."""
    efforts = [1.0, -3.5e4, -3.7e4]
    assert follow(efforts, DirectionSettings(hysteresis_velocity=0.012)) == [1.0, 1.0, -1.0]


def test_dwell_allows_one_switch_in_its_time():
    """Switched at the second sample; the next is allowed 30 ms later."""
    efforts = [1.0, -1.0, 1.0, 1.0, 1.0, 1.0]
    assert follow(efforts, DirectionSettings(dwell=0.0299)) == [1.0, -1.0, -1.0, -1.0, 1.0, 1.0]


@pytest.mark.parametrize("settings", [DirectionSettings(), DirectionSettings(hysteresis=10.0, dwell=0.02)])
def test_direction_is_never_zero_after_a_sample(settings):
    assert set(follow([0.0, -0.0, 5.0, -5.0, 50.0, -50.0], settings)) <= {-1.0, 1.0}
