"""The event filter with times since the last edges and angles without whole revolutions."""

from itertools import pairwise

import numpy as np
import pytest

from vvdp.estimation.bounded_filter import PassedEdges, bounded_start, bounded_step, relative
from vvdp.estimation.event_filter import event_filter_step
from vvdp.estimation.event_memory import event_filter_start
from vvdp.estimation.event_settings import event_filter
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import equal_wheel

WHEEL = equal_wheel(8, 0.25)


def test_times_and_whole_revolutions_are_taken_out():
    """By hand: edge 19 of a wheel with 8 edges is edge 3 of the third revolution; 13 rad - 4 pi = 0.43363 rad."""
    memory = event_filter_start(event_filter(WHEEL), 2.0, 13.0, 5.0)
    moved = relative(memory, 0.5, 2.0, WHEEL)
    assert memory.last.number == 16.0  # 13 rad lie behind edge 0 of the third revolution, at 12.57 rad
    assert (moved.last.number, moved.last.time, moved.time) == (0.0, 1.5, 1.5)
    assert moved.belief.angle == pytest.approx(0.4336293856408275, rel=1e-14)
    assert moved.belief.speed == 5.0
    assert moved.doubt == memory.doubt  # there is none
    doubtful = memory._replace(doubt=memory.doubt._replace(odds=1.0, number=17.0))
    assert relative(doubtful, 0.5, 2.0, WHEEL).doubt.number == 1.0


def samples():
    """Readings of 4 s at 1 ms: 20 to 60 rad/s, a stop of 0.5 s, and on; each edge at its true time."""
    t = 1e-3 * np.arange(4001)
    speed = np.where((t > 1.5) & (t < 2.0), 0.0, 40.0 + 20.0 * np.sin(3.0 * t))
    angle = np.concatenate([[0.0], np.cumsum(1e-3 * speed[1:])])
    edges = np.floor(angle / (np.pi / 4.0))
    for i, (one, two) in enumerate(pairwise(range(t.size))):
        passed = edges[two] - edges[one]
        age = (angle[two] - edges[two] * np.pi / 4.0) / speed[two] if passed else 0.0
        yield t[two], 1e-3 if i else t[two], passed, age


def test_estimates_are_those_of_the_filter_but_for_rounding():
    """Each sample of 4 s, with a standstill; neither times nor angles of the memory grow."""
    settings = event_filter(equal_wheel(8))
    memory, bounded = event_filter_start(settings, 0.0, 0.0, 0.0), bounded_start(settings)
    for t, elapsed, passed, age in samples():
        memory, plain = event_filter_step(memory, Reading(t, passed, t - age, 0.0, 0.0), settings)
        bounded, estimate = bounded_step(bounded, PassedEdges(elapsed, passed, age, 0.0, 0.0), settings)
        assert estimate.angle == 2.0 * np.pi * bounded.revolutions + estimate.remainder
        assert estimate.angle == pytest.approx(plain.angle, abs=1e-10)
        assert estimate.speed == pytest.approx(plain.speed, abs=1e-9)
        assert -0.1 < estimate.remainder < 8.0
        assert abs(bounded.filter.time) < 0.6
    assert bounded.revolutions > 15.0
