"""A wheel of four sectors has the fewest edges that tell of an index: all of a turn, the one that has just come too."""

import numpy as np
import pytest

from vvdp.estimation.index import index_after_edge, index_start
from vvdp.sensing.wheel import edge_angle, equal_wheel

WHEEL = equal_wheel(4, 0.25)


@pytest.mark.parametrize("off", [0.0, 1.0, 2.0, 3.0])
def test_numbers_off_by_any_number_of_edges_are_put_right(off):
    memory, shifted, found_at = index_start(WHEEL), 0.0, np.inf
    for true in range(20):
        number = true + off + shifted
        time = edge_angle(float(true), WHEEL) / 155.0
        found = index_after_edge(memory, number, time, 0.0, 5e-3, 2.0, WHEEL)
        memory, shifted = found.memory, shifted + found.edges
        found_at = min(found_at, true if memory.found else np.inf)
    assert (off + shifted) % 4.0 == 0.0 and found_at <= 9
