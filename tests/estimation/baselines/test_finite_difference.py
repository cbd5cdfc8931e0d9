"""Counting, and the speed counted in a window."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vvdp.base.errors import ParameterError
from vvdp.estimation.baselines.finite_difference import finite_difference, finite_difference_estimator
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import equal_wheel
from vvdp.simulation.replay import Replay

WHEEL = equal_wheel(8)
INDEXED = equal_wheel(8, 0.25)
SECTOR, TURN = np.pi / 4.0, 2.0 * np.pi
QUIET = Reading(0.0, 0.0, 0.0, 0.0, 0.0)


def steady(frequency, phase, duration=1.5):
    times = 1e-3 * np.arange(int(duration * 1e3) + 1)
    return times, phase + TURN * frequency * times


@pytest.fixture(scope="module")
def replay():
    found = finite_difference_estimator(finite_difference(WHEEL))
    return Replay(found.step, found.memory, QUIET, found.settings)


def errors(replay, sampled_edges, window, frequency):
    """RMS of angle and speed after 0.5 s over 50 phases of the sampling within a sector."""
    angle, speed = [], []
    for phase in SECTOR * (np.arange(50) + 0.5) / 50.0:
        times, angles = steady(frequency, phase)
        found = finite_difference_estimator(finite_difference(WHEEL, window), 0.0, phase)
        rows = sampled_edges(WHEEL.edges, times, angles)
        compiled = replay if window == 20.0 else Replay(found.step, found.memory, QUIET, found.settings)
        shown = compiled(found.memory, rows).shown[times > 0.5]
        angle.append(shown[:, 0] - angles[times > 0.5])
        speed.append(shown[:, 1] - TURN * frequency)
    return np.sqrt(np.mean(np.square(angle))), np.sqrt(np.mean(np.square(speed)))


@pytest.mark.parametrize("window, angle, speed", [(10.0, 0.079, 12.0), (20.0, 0.066, 8.4), (40.0, 0.058, 5.8)])
def test_errors_at_24_7_hz_on_a_fixed_clock(replay, sampled_edges, window, angle, speed):
    """The speed is N or N + 1 sectors / W, the larger with probability f: RMS = (sector / W) sqrt(f (1 - f)).

    197.6 edges/s x 10 ms = 1.976: 78.54 sqrt(0.976 x 0.024) = 12.02 rad/s. The angles are from an independent program.
    """
    found = errors(replay, sampled_edges, window, 24.7)
    f = 197.6e-3 * window % 1.0
    assert found[1] == pytest.approx(SECTOR / (1e-3 * window) * np.sqrt(f * (1.0 - f)), rel=0.01)
    assert found[1] == pytest.approx(speed, rel=0.02)
    assert found[0] == pytest.approx(angle, rel=0.10)


@given(frequency=st.floats(3.0, 60.0), phase=st.floats(0.0, TURN), index=st.booleans())
def test_speed_is_off_by_less_than_one_sector_in_the_window(sampled_edges, stepped, frequency, phase, index):
    wheel = INDEXED if index else WHEEL
    times, angles = steady(frequency, phase, 0.5)
    shown, _ = stepped(
        finite_difference_estimator(finite_difference(wheel), 0.0, phase), sampled_edges(wheel.edges, times, angles)
    )
    late = times > 0.4
    widest = SECTOR * (1.25 if index else 1.0)
    assert np.abs(shown[late, 1] - TURN * frequency).max() < widest / 20e-3 + 1e-9
    assert np.abs(shown[late, 0] - angles[late]).max() <= widest + 1e-9  # it knows the sector


def test_a_window_of_two_samples_by_hand(stepped):
    """Edges at the samples 2, 4 and 5; the window is full two samples after the first edge."""
    at = 1e-3 * np.arange(1, 8)
    passed = np.array([0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0])
    rows = np.column_stack([at, passed, at - 0.5e-3, 0.0 * at + 1e-3, 0.0 * at])
    shown, _ = stepped(finite_difference_estimator(finite_difference(WHEEL, 2.0), 0.0, 0.0, 7.0), rows)
    np.testing.assert_allclose(shown[:, 1], [7.0, 7.0, 7.0, *(SECTOR / 2e-3 * np.array([1.0, 2.0, 1.0, 0.0]))])


def test_a_window_of_whole_turns_is_exact_whatever_the_widths(sampled_edges, stepped):
    """25 Hz: 40 samples hold 8 edges."""
    times, angles = steady(25.0, 0.3, 0.3)
    shown, _ = stepped(
        finite_difference_estimator(finite_difference(INDEXED, 40.0), 0.0, 0.3),
        sampled_edges(INDEXED.edges, times, angles),
    )
    np.testing.assert_allclose(shown[times > 0.1, 1], 50.0 * np.pi, rtol=1e-12)


def test_times_and_turns_may_begin_anywhere(sampled_edges, stepped):
    times, angles = steady(24.7, 0.3, 0.3)
    settings = finite_difference(INDEXED)
    shown, _ = stepped(finite_difference_estimator(settings, 0.0, 0.3), sampled_edges(INDEXED.edges, times, angles))
    later, _ = stepped(
        finite_difference_estimator(settings, 4096.0, 0.3 + 10.0 * TURN),
        sampled_edges(INDEXED.edges, times + 4096.0, angles + 10.0 * TURN),
    )
    np.testing.assert_allclose(later[:, 0] - 10.0 * TURN, shown[:, 0], atol=1e-8)
    np.testing.assert_allclose(later[:, 1], shown[:, 1], rtol=1e-9)


def test_before_an_edge_the_start_is_shown_as_far_as_it_can_be_true(sampled_edges, stepped):
    """Speed at the start 100 rad/s, and no edge comes: 0.785 rad may be passed, so at 10 ms at most 78.5 rad/s."""
    times = 1e-3 * np.arange(1, 101)
    found = finite_difference_estimator(finite_difference(WHEEL), 0.0, 0.1, 100.0)
    shown, _ = stepped(found, sampled_edges(WHEEL.edges, times, np.full(100, 0.1)))
    np.testing.assert_allclose(shown[:7, 1], 100.0)
    np.testing.assert_allclose(shown[:6, 0], 0.1 + 100.0 * times[:6])
    np.testing.assert_allclose(shown[8:, 1], SECTOR / times[8:])
    assert shown[:, 0].max() == SECTOR
    assert np.isnan(shown[:, 2:4]).all()
    assert not shown[:, 4:7].any()


def test_polarity_of_the_first_edge_says_in_which_sector_the_start_was(stepped):
    """The shaft is believed in the bright sector 0; a rising edge ends a dark one. The next is the one near by, 0."""
    found = finite_difference_estimator(finite_difference(WHEEL), 0.0, 0.1)
    rising = np.array([[1e-3, 1.0, 0.5e-3, 1e-3, 1.0]])
    assert stepped(found, rising)[1].last.number == 0.0
    assert stepped(found, rising * [1.0, 1.0, 1.0, 1.0, -1.0])[1].last.number == 1.0
    assert stepped(found, rising * [1.0, 1.0, 1.0, 1.0, 0.0])[1].last.number == 1.0
    assert stepped(found, rising * [1.0, 3.0, 1.0, 1.0, -1.0])[1].last.number == 3.0


def test_a_missed_edge_is_not_detected(sampled_edges, stepped):
    times, angles = steady(24.7, 0.3, 0.5)
    rows = sampled_edges(WHEEL.edges, times, angles)
    rows[np.flatnonzero(rows[:, 1])[40], 1] = 0.0
    shown, _ = stepped(finite_difference_estimator(finite_difference(WHEEL), 0.0, 0.3), rows)
    behind = (angles - shown[:, 0])[times > 0.3]
    assert np.mean(behind) == pytest.approx(SECTOR, abs=0.05)
    assert not shown[:, 6].any()


def test_a_stopped_shaft_is_shown_at_rest_after_the_window(sampled_edges, stepped):
    times = 1e-3 * np.arange(301)
    angles = 155.0 * times.clip(max=0.1)
    shown, _ = stepped(finite_difference_estimator(finite_difference(WHEEL)), sampled_edges(WHEEL.edges, times, angles))
    assert not shown[times > 0.121, 1].any()
    assert np.abs(shown[-1, 0] - angles[-1]) < SECTOR


def test_compiled_is_plain_also_in_portions(replay, sampled_edges, stepped):
    times, angles = steady(24.7, 0.3, 0.4)
    rows = sampled_edges(WHEEL.edges, times, angles)
    found = finite_difference_estimator(finite_difference(WHEEL))
    plain, memory = stepped(found, rows)
    compiled = replay(found.memory, rows)
    np.testing.assert_allclose(compiled.shown, plain, rtol=1e-12)
    np.testing.assert_array_equal(compiled.memory.times, memory.times)
    first = replay(found.memory, rows[:137])
    second = replay(first.memory, rows[137:])
    np.testing.assert_array_equal(np.vstack([first.shown, second.shown]), compiled.shown)


def test_the_memory_that_was_given_is_left_alone(sampled_edges, stepped):
    times, angles = steady(24.7, 0.3, 0.1)
    found = finite_difference_estimator(finite_difference(WHEEL))
    stepped(found, sampled_edges(WHEEL.edges, times, angles))
    assert not found.memory.times.any()
    assert not found.memory.angles.any()


@pytest.mark.parametrize("window", [0.0, 2.5])
def test_windows_that_cannot_be_are_refused(window):
    with pytest.raises(ParameterError, match=f"{window:g} must be a whole number"):
        replace(finite_difference(WHEEL), window=window)
