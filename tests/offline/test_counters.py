"""Counters that are read much faster or much slower than edges come."""

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from tests.offline.records import TURN, Motion, counted, even_edges
from tests.words import wording

from vvdp.base.errors import ConfigError
from vvdp.offline.alignment import first_speed
from vvdp.offline.edges import CountEdges


@pytest.mark.sampled(2)
@settings(max_examples=12, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.floats(np.log(0.05), np.log(50.0)), st.sampled_from([None, 0.25]))
@example(0.03, None)  # a little more than one edge a sample: the two that come now and then are no bounce
@example(0.1, None)
@example(np.log(10.0), None)
@example(np.log(10.0), 0.25)
@example(np.log(40.0), 0.25)
def test_any_number_of_edges_between_two_samples_gives_the_speed(estimated, logarithm, shift):
    speed, sectors = 155.3, 8
    per_sample = float(np.exp(logarithm))
    rate = speed * sectors / TURN / per_sample
    motion = Motion(lambda t: speed, 60.0 / rate + 1.0, step=1e-4)
    edges = even_edges(sectors, 1 if shift else None, shift or 0.0)
    kept = estimated(counted(motion, edges, rate), sensor__counts="n", sensor__index_shift=shift)
    found = kept.summary
    assert np.isfinite(kept.column("speed")[np.isfinite(kept.column("angle"))]).all()
    # 60 samples of half a sector of doubt at either end: 0.3 %; as good as the deviation that is stated
    off = abs(found["spool_speed_mean_rad_s"] - speed)
    assert off < max(0.01 * speed, 2.0 * found["speed_deviation_mean_rad_s"])
    assert off < 0.03 * speed


def test_the_speed_comes_from_the_first_two_times_that_differ():
    # 40 edges at once, 0.2 s on 40 more: 40 sectors of pi/4 in 0.2 s
    assert first_speed(np.array([1.0, 1.0, 1.2]), np.array([0.0, 0.0, 40.0]), 8) == pytest.approx(50.0 * np.pi)
    assert first_speed(np.full(3, 2.0), np.arange(3.0), 8) == 0.0


def test_the_last_of_several_edges_lies_in_the_last_part_of_its_interval():
    found = CountEdges().push(np.array([0.0, 0.2, 0.4]), np.array([0.0, 0.0, 40.0]))
    assert found.times == pytest.approx([0.4 - 0.5 * 0.2 / 40.0])


def test_a_counter_with_two_steps_is_told_to_be_read_too_slowly(estimated):
    t = np.arange(3) * 0.2
    with pytest.raises(ConfigError, match=wording.estimate.only_steps.format(count=2)):
        estimated({"time": (t, "s"), "n": (40.0 * np.arange(3), "")}, sensor__counts="n")


@pytest.mark.parametrize("nonsense", [1e9, 1e15, 1e251, -1e251, np.inf])
def test_a_count_that_nothing_can_have_reached_is_left_out(estimated, nonsense):
    """The filter looked for so many edges one by one, and did not end."""
    t = np.arange(0.0, 3.0, 1e-3)
    n = np.floor(155.0 * t / (2.0 * np.pi / 8))
    n[1500] = nonsense
    kept = estimated({"time": (t, "s"), "n": (n, "")}, sensor__counts="n")
    assert kept.summary["spool_speed_mean_rad_s"] == pytest.approx(155.0, rel=0.02)
