"""What is remembered of a piece of edges while it is cut: the same however many come at once."""

from itertools import pairwise

import numpy as np
import pytest

from vvdp.offline.bridging import RECENT
from vvdp.offline.cutting import Course
from vvdp.offline.passages import SEEN_BEFORE

TIMES = np.cumsum(np.random.default_rng(33).uniform(0.5, 1.5, RECENT))


@pytest.mark.parametrize("portions", [(0, 1), (0, 1, 2), (0, 2, 3, 9), (0, 7, 8)])
def test_a_course_does_not_depend_on_its_portions(portions):
    """The first portion of a single edge included: no time between two edges is lost."""
    course = Course()
    for begin, end in pairwise((*portions, TIMES.size)):
        course.add(TIMES[begin:end])
    assert np.array_equal(course.times, TIMES[-SEEN_BEFORE - 1 :])
    assert np.array_equal(course.steps, np.diff(TIMES)[-RECENT:])


def test_a_single_edge_first_leaves_its_time():
    course = Course()
    course.add(np.array([1.0]))
    course.add(np.array([1.5, 2.5]))
    assert course.steps.tolist() == [0.5, 1.0]
