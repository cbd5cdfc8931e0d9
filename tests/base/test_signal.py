"""Prescribed values over time against their plain definition."""

import bisect
import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vvdp.base.signal import Signal, constant, ramp, signal_stop, signal_value, sine, step, table

NUMBERS = st.floats(-1e6, 1e6)
TIMES = st.floats(0.0, 100.0)
POINTS = st.lists(
    st.tuples(st.sampled_from([0.0, 0.5, 1.0, 1.5, 2.0, 7.25]) | TIMES, NUMBERS), min_size=1, max_size=8
).map(lambda points: sorted(points, key=lambda point: point[0]))
CHANGES = st.lists(st.tuples(TIMES, st.just(0.0) | st.floats(1e-9, 10.0), NUMBERS), max_size=5)
SINES = st.lists(st.tuples(NUMBERS, st.floats(0.0, 100.0), st.floats(-7.0, 7.0)), max_size=3)


@st.composite
def signals(draw: st.DrawFn) -> Signal:
    changes, sines = draw(CHANGES), draw(SINES)
    columns = [tuple(entry[i] for entry in rows) for rows in (changes, sines) for i in range(3)]
    return Signal(draw(NUMBERS), *columns)


def brute(t: float, signal: Signal) -> float:
    """The definition, with `if`s."""
    value = signal.base
    for begin, duration, change in zip(signal.start, signal.duration, signal.change, strict=True):
        if t >= begin + duration and t >= begin:
            value += change
        elif t > begin:
            value += change * (t - begin) / duration
    for amplitude, frequency, phase in zip(signal.amplitude, signal.frequency, signal.phase, strict=True):
        value += amplitude * math.sin(2 * math.pi * frequency * t + phase)
    return value


@given(signals(), st.floats(-1.0, 120.0))
def test_values_are_those_of_the_definition(signal: Signal, t: float) -> None:
    size = 1.0 + sum(map(abs, (signal.base, *signal.change, *signal.amplitude)))
    assert signal_value(t, signal) == pytest.approx(brute(t, signal), rel=0.0, abs=1e-12 * size)


@given(signals(), st.lists(st.floats(-1.0, 120.0), min_size=1, max_size=5))
def test_arrays_of_times_give_arrays_of_values(signal: Signal, times: list[float]) -> None:
    # The sine of an array may differ from that of a number in its last digit.
    size = 1.0 + sum(map(abs, (signal.base, *signal.change, *signal.amplitude)))
    whole = np.broadcast_to(signal_value(np.array(times), signal), len(times))
    assert whole == pytest.approx([signal_value(t, signal) for t in times], rel=0.0, abs=1e-12 * size)


@given(POINTS)
def test_a_table_goes_through_its_points_and_holds_outside(points: list[tuple[float, float]]) -> None:
    times, values = [t for t, _ in points], [v for _, v in points]
    signal = table(times, values)
    size = 1.0 + 2.0 * sum(map(abs, values))
    for t in (-1.0, *times, *np.linspace(0.0, 110.0, 50)):
        after = bisect.bisect_right(times, t)
        if after == 0:
            expected = values[0]
        elif after == len(times):
            expected = values[-1]
        else:
            (t0, v0), (t1, v1) = points[after - 1], points[after]
            if 0.0 < t1 - t0 < 1e-9:
                continue  # steeper than the rounding of the times can tell
            expected = v0 + (v1 - v0) * (t - t0) / (t1 - t0)
        steepest = max(
            (abs(v1 - v0) / (t1 - t0) for (t0, v0), (t1, v1) in itertools.pairwise(points) if t1 > t0),
            default=0.0,
        )
        assert signal_value(float(t), signal) == pytest.approx(expected, rel=0.0, abs=1e-12 * size + 2e-14 * steepest)


def test_a_table_with_two_points_at_one_time_jumps() -> None:
    signal = table([0.0, 1.0, 1.0, 2.0], [0.0, 1.0, 5.0, 5.0])
    assert signal_value(math.nextafter(1.0, 0.0), signal) == pytest.approx(1.0)
    assert signal_value(1.0, signal) == 5.0


def test_tables_that_are_none_are_refused() -> None:
    for times, values in (([], []), ([0.0], [1.0, 2.0]), ([1.0, 0.0], [1.0, 2.0])):
        with pytest.raises(ValueError, match=r"expected the same number|backwards"):
            table(times, values)


@given(signals(), TIMES)
def test_stops_increase_and_miss_no_corner(signal: Signal, t: float) -> None:
    corners = sorted(
        {c for c in (*signal.start, *(a + d for a, d in zip(signal.start, signal.duration, strict=True))) if c > t}
    )
    found = []
    while (stop := signal_stop(t, signal)) != math.inf:
        assert stop > t
        found.append(stop)
        t = stop
    assert found == corners


@given(signals(), st.floats(-1.0, 120.0))
def test_the_extremes_bound_every_value(signal: Signal, t: float) -> None:
    low, high = signal.extremes
    size = 1e-12 * (1.0 + sum(map(abs, (signal.base, *signal.change, *signal.amplitude))))
    assert low - size <= signal_value(t, signal) <= high + size


@given(POINTS)
def test_the_extremes_are_reached_where_nothing_swings(points: list[tuple[float, float]]) -> None:
    signal = table([t for t, _ in points], [v for _, v in points])
    # On either side of each time stands the first or the last of the points that share it.
    shown = [points[0][1], points[-1][1]]
    for before, (t, v), after in zip([(-1.0, 0.0), *points], points, [*points[1:], (1e9, 0.0)], strict=False):
        if before[0] != t or after[0] != t:
            shown.append(v)
    size = 1e-12 * (1.0 + 2.0 * sum(abs(v) for _, v in points))
    assert signal.extremes == (pytest.approx(min(shown), abs=size), pytest.approx(max(shown), abs=size))


def test_the_extremes_see_a_peak_that_ends_in_a_jump() -> None:
    assert table([0.0, 1.0, 1.0, 2.0], [0.0, 10.0, 5.0, 5.0]).extremes == (0.0, 10.0)


def test_a_jump_passes_over_what_is_between_its_ends() -> None:
    """A ramp from -1 to 1 is 0 once, a jump never; -1 to 1, from where a jump goes to -3 and a sine of 2 to -1."""
    assert ramp(-1.0, 1.0, 1.0, 2.0).may_be(0.0) and not step(-1.0, 1.0, 1.0).may_be(0.0)
    assert constant(2.0).may_be(2.0) and not constant(2.0).may_be(2.1)
    peak = table([0.0, 1.0, 1.0, 2.0], [1.0, 4.0, -3.0, -2.0])
    assert [peak.may_be(value) for value in (-3.1, -2.5, -1.0, 0.9, 3.9)] == [False, True, False, False, True]
    swinging = Signal(0.0, (1.0,), (0.0,), (10.0,), (2.0,), (5.0,), (0.0,))
    assert [swinging.may_be(value) for value in (-2.0, 2.1, 7.9, 8.0, 12.1)] == [True, False, False, True, False]


def test_words_make_what_they_say() -> None:
    assert constant(3.0).is_constant and signal_value(1e9, constant(3.0)) == 3.0
    jump = step(1.0, 2.0, 0.5)
    assert [signal_value(t, jump) for t in (0.0, 0.4999, 0.5, 9.0)] == [1.0, 1.0, 2.0, 2.0]
    rise = ramp(1.0, 3.0, 1.0, 2.0)
    assert [signal_value(t, rise) for t in (0.0, 1.0, 1.25, 2.0, 9.0)] == [1.0, 1.0, 1.5, 3.0, 3.0]
    assert (signal_stop(0.0, rise), signal_stop(1.0, rise), signal_stop(2.0, rise)) == (1.0, 2.0, math.inf)
    swing = sine(10.0, 2.0, 5.0, math.pi / 2)
    assert signal_value(0.0, swing) == 12.0 and signal_value(0.1, swing) == pytest.approx(8.0)
    assert swing.extremes == (8.0, 12.0) and not swing.is_constant
    assert signal_stop(0.0, swing) == math.inf
    assert sine(1.0, 0.0, 5.0).is_constant and step(1.0, 1.0, 3.0).is_constant


def test_what_changes_between_two_times_is_told_from_what_changed_before_or_will():
    jump, slope, swing = step(1.0, 2.0, 3.0), ramp(1.0, 2.0, 3.0, 5.0), sine(1.0, 0.1, 2.0)
    assert not any(jump.is_constant_within(*times) for times in ((2.0, 4.0), (3.0, 4.0), (1.0, 3.0)))
    assert jump.is_constant_within(3.1, 4.0) and jump.is_constant_within(1.0, 2.9)
    assert slope.is_constant_within(5.1, 9.0) and not slope.is_constant_within(4.0, 4.5)
    assert constant(1.0).is_constant_within(0.0, 9.0) and not swing.is_constant_within(0.0, 9.0)
