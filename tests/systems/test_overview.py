"""What a summary says of nodes, in lines."""

import pytest

from vvdp.evaluation.overview import node_lines
from vvdp.systems.system import load_system, shipped_systems


class Found(dict):
    """A summary in which every lowest value is 1, every mean 2 and every highest 3."""

    def __missing__(self, key):
        return {"min": 1.0, "mean": 2.0, "max": 3.0}[key.split("_")[1]]


@pytest.mark.parametrize("name", shipped_systems())
def test_lowest_mean_and_highest_are_not_mixed_up(name):
    lines = list(node_lines(load_system(name), Found()))
    assert lines
    for line in lines:
        assert (line.low, line.high) == (1.0, 3.0)
        assert line.mean == (None if line.quantity == "position" else 2.0)
