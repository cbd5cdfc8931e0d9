"""The operations that floats, arrays and symbols share."""

import casadi
import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from vvdp.base.select import clip, maximum, minimum, select

NUMBERS = st.floats(-1e9, 1e9)


@given(NUMBERS, NUMBERS, NUMBERS)
def test_floats_stay_floats(a: float, b: float, c: float) -> None:
    low, high = min(b, c), max(b, c)
    assert minimum(a, b) == min(a, b) and maximum(a, b) == max(a, b)
    assert clip(a, low, high) == min(max(a, low), high)
    assert select(a < b, a, b) == min(a, b)
    assert all(isinstance(value, float) for value in (minimum(a, b), maximum(a, b), clip(a, low, high)))


@given(st.lists(st.tuples(NUMBERS, NUMBERS), min_size=1, max_size=5))
def test_arrays_and_symbols_agree_with_floats(pairs: list[tuple[float, float]]) -> None:
    a, b = (np.array(column) for column in zip(*pairs, strict=True))
    x, y = casadi.SX.sym("x"), casadi.SX.sym("y")
    for operation in (minimum, maximum):
        alone = [operation(u, v) for u, v in pairs]
        assert operation(a, b).tolist() == alone
        symbolic = casadi.Function("f", [x, y], [operation(x, y)])
        assert [float(symbolic(u, v)) for u, v in pairs] == alone


def test_a_condition_over_time_chooses_point_by_point() -> None:
    assert select(np.array([True, False]), 1.0, np.array([2.0, 3.0])).tolist() == [1.0, 3.0]
    assert clip(np.array([-1.0, 0.5, 2.0]), 0.0, 1.0).tolist() == [0.0, 0.5, 1.0]
