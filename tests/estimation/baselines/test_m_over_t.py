"""The M/T method: whole sectors over the time that they took."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vvdp.base.errors import ParameterError
from vvdp.estimation.baselines.inverse_time import inverse_time, inverse_time_estimator
from vvdp.estimation.baselines.m_over_t import m_over_t, m_over_t_estimator
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import equal_wheel
from vvdp.simulation.replay import Replay

WHEEL = equal_wheel(8)
INDEXED = equal_wheel(8, 0.25)
SECTOR, TURN = np.pi / 4.0, 2.0 * np.pi


def steady(frequency, phase, duration=0.5):
    times = 1e-3 * np.arange(int(duration * 1e3) + 1)
    return times, phase + TURN * frequency * times


def windows(shown, rows):
    """Whether a first window has closed: the speed of the start, NaN-safe 0 here, is gone."""
    return np.cumsum(rows[:, 1]) * (shown[:, 1] > 0.0) > 0.0


@given(frequency=st.floats(4.0, 100.0), phase=st.floats(0.0, TURN), window=st.floats(1e-3, 0.05))
def test_stamped_edges_at_constant_speed_give_it_exactly(sampled_edges, stepped, frequency, phase, window):
    omega = TURN * frequency
    times, angles = steady(frequency, phase)
    rows = sampled_edges(INDEXED.edges, times, angles, lambda angle: (angle - phase) / omega)
    shown, _ = stepped(m_over_t_estimator(m_over_t(INDEXED, window), 0.0, phase), rows)
    closed = windows(shown, rows)
    assert closed[-1]
    np.testing.assert_allclose(shown[closed, 1], omega, rtol=1e-9)
    np.testing.assert_allclose(shown[closed, 0], angles[closed], atol=1e-9)


@given(frequency=st.floats(4.0, 60.0), phase=st.floats(0.0, TURN), window=st.floats(2e-3, 0.05))
def test_sampled_edges_are_off_by_less_than_a_sampling_period_in_the_window(
    sampled_edges, stepped, frequency, phase, window
):
    """omega^ = omega T / T^, |T^ - T| <= dT, T^ >= window: |omega^ - omega| <= omega dT / window."""
    omega = TURN * frequency
    times, angles = steady(frequency, phase)
    rows = sampled_edges(WHEEL.edges, times, angles)
    shown, _ = stepped(m_over_t_estimator(m_over_t(WHEEL, window), 0.0, phase), rows)
    closed = windows(shown, rows)
    assert np.abs(shown[closed, 1] - omega).max() <= omega * 1e-3 / window * (1.0 + 1e-9)


def test_a_window_shorter_than_any_sector_is_inverse_time(sampled_edges, stepped):
    times = 1e-3 * np.arange(1501)
    angles = 60.0 * times + 40.0 * times * times
    rows = sampled_edges(INDEXED.edges, times, angles)
    short, _ = stepped(m_over_t_estimator(m_over_t(INDEXED, 1e-4)), rows)
    inverse, _ = stepped(inverse_time_estimator(inverse_time(INDEXED)), rows)
    np.testing.assert_array_equal(short, inverse)


def test_windows_follow_each_other_without_a_gap(stepped):
    """Edges at 1, 5, 12, 16, 30, 41 ms, window 10 ms: 1 to 12 (2 sectors), 12 to 30 (2), 30 to 41 (1)."""
    at = 1e-3 * np.array([1.0, 5.0, 12.0, 16.0, 30.0, 41.0])
    rows = np.column_stack([at, np.ones(6), at, np.zeros(6), (-1.0) ** np.arange(1, 7)])
    shown, _ = stepped(m_over_t_estimator(m_over_t(WHEEL, 0.01), speed=7.0), rows)
    np.testing.assert_allclose(
        shown[:, 1], [7.0, 7.0, *[2 * SECTOR / 11e-3] * 2, 2 * SECTOR / 18e-3, SECTOR / 11e-3], rtol=1e-9
    )


def test_the_speed_falls_when_the_next_edge_is_overdue(sampled_edges, stepped):
    times = 1e-3 * np.arange(2001)
    angles = 155.0 * times.clip(max=0.1)
    rows = sampled_edges(WHEEL.edges, times, angles)
    shown, _ = stepped(m_over_t_estimator(m_over_t(WHEEL)), rows)
    last = np.flatnonzero(rows[:, 1])[-1]
    np.testing.assert_allclose(shown[last + 10 :, 1], SECTOR / (times[last + 10 :] - times[last]), rtol=1e-9)
    assert 0.0 <= shown[-1, 0] - angles[-1] < SECTOR


def test_compiled_is_plain(sampled_edges, stepped):
    times, angles = steady(24.7, 0.3)
    rows = sampled_edges(INDEXED.edges, times, angles)
    found = m_over_t_estimator(m_over_t(INDEXED))
    replay = Replay(found.step, found.memory, Reading(0.0, 0.0, 0.0, 0.0, 0.0), found.settings)
    np.testing.assert_allclose(replay(found.memory, rows).shown, stepped(found, rows)[0], rtol=1e-12)


def test_a_window_of_nothing_is_refused():
    with pytest.raises(ParameterError, match="window: 0 ms must be greater than 0"):
        replace(m_over_t(WHEEL), window=0.0)
