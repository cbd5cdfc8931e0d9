"""The polynomial through time-stamped edges: against numpy.polyfit, and without edges for long."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vvdp.base.errors import ParameterError
from vvdp.estimation.baselines.time_stamping import (
    fitted_polynomial,
    polynomial,
    time_stamping,
    time_stamping_estimator,
)
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import equal_wheel
from vvdp.simulation.replay import Replay

pytestmark = pytest.mark.heavy

WHEEL = equal_wheel(8)
INDEXED = equal_wheel(8, 0.25)
SECTOR, TURN = np.pi / 4.0, 2.0 * np.pi


def steady(frequency, phase, duration=0.5):
    times = 1e-3 * np.arange(int(duration * 1e3) + 1)
    return times, phase + TURN * frequency * times


def test_line_and_parabola_by_hand():
    """Through (-2, 0), (-1, 1), (0, 5): line 4.5 + 2.5 t (mean 2 at -1, slope 5/2); parabola 5 + 5.5 t + 1.5 t^2."""
    times, values = np.array([7.0, 6.0, 5.0]), np.array([5.0, 1.0, 0.0])
    np.testing.assert_allclose(fitted_polynomial(times, values, 2), [4.5, 2.5], atol=1e-14)
    np.testing.assert_allclose(fitted_polynomial(times, values, 3), [5.0, 5.5, 1.5], atol=1e-14)
    np.testing.assert_allclose(fitted_polynomial(times, values, 5), [5.0, 5.5, 1.5, 0.0, 0.0], atol=1e-14)
    assert polynomial(np.array([5.0, 5.5, 1.5]), 2.0) == (22.0, 11.5)


@given(order=st.integers(1, 5), more=st.integers(0, 15), seed=st.integers(0, 10**6))
def test_fit_is_that_of_numpy(order, more, seed):
    random = np.random.default_rng(seed)
    times = -5e-3 * np.cumsum(random.uniform(0.5, 1.5, order + 1 + more))
    values = random.normal(size=times.size)
    wanted = np.polynomial.Polynomial.fit(times, values, order)
    found = fitted_polynomial(times, values, order + 1)
    at = np.append(times, times[0] + 5e-3)
    shown = np.array([polynomial(found, x - times[0]) for x in at])
    # rounding counts against the largest term of the sum
    span = times[0] - times[-1]
    size = np.abs(wanted(at)).max() + np.abs(found * span ** np.arange(order + 1)).max()
    np.testing.assert_allclose(shown[:, 0], wanted(at), atol=1e-10 * size)
    np.testing.assert_allclose(shown[:, 1], wanted.deriv()(at), atol=1e-10 * order * size / 5e-3)


@pytest.mark.parametrize("n", [3, 8, 20])
def test_noise_of_the_slope_is_the_known_one(n):
    """n times T apart: variance of the slope 12 s^2/(n (n^2 - 1) T^2), at the newest 2 s^2 (2n - 1)/(n (n + 1))."""
    T = 5e-3
    weights = np.array([fitted_polynomial(-T * np.arange(n), one, 2) for one in np.eye(n)])
    assert np.sum(weights[:, 1] ** 2) == pytest.approx(12.0 / (n * (n * n - 1.0) * T * T), rel=1e-12)
    assert np.sum(weights[:, 0] ** 2) == pytest.approx(2.0 * (2.0 * n - 1.0) / (n * (n + 1.0)), rel=1e-12)


@pytest.mark.thorough
@given(frequency=st.floats(4.0, 150.0), phase=st.floats(0.0, TURN), order=st.integers(1, 3))
def test_stamped_edges_at_constant_speed_give_it_exactly(sampled_edges, stepped, frequency, phase, order):
    omega = TURN * frequency
    times, angles = steady(frequency, phase, 1.0)
    rows = sampled_edges(INDEXED.edges, times, angles, lambda angle: (angle - phase) / omega)
    shown, _ = stepped(time_stamping_estimator(time_stamping(INDEXED, 6.0, float(order)), 0.0, phase, omega), rows)
    known = np.cumsum(rows[:, 1] > 0.0) >= 2
    np.testing.assert_allclose(shown[known, 1], omega, rtol=1e-8)
    np.testing.assert_allclose(shown[known, 0], angles[known], atol=1e-8)


def test_a_parabola_follows_an_even_acceleration_exactly_where_a_line_lags(sampled_edges, stepped):
    times = 1e-3 * np.arange(401)
    angles = 60.0 * times + 100.0 * times**2
    rows = sampled_edges(WHEEL.edges, times, angles, lambda angle: (-60.0 + np.sqrt(3600.0 + 400.0 * angle)) / 200.0)
    late = times > 0.2
    shown, _ = stepped(time_stamping_estimator(time_stamping(WHEEL, 6.0, 2.0)), rows)
    np.testing.assert_allclose(shown[late, 1], (60.0 + 200.0 * times)[late], rtol=1e-9)
    np.testing.assert_allclose(shown[late, 0], angles[late], atol=1e-9)
    line, _ = stepped(time_stamping_estimator(time_stamping(WHEEL, 6.0, 1.0)), rows)
    assert np.all(line[late, 1] < (60.0 + 200.0 * times)[late])


@pytest.mark.parametrize("edges, order", [(8.0, 1.0), (5.0, 2.0), (9.0, 3.0)])
def test_every_sample_is_numpy_s_fit_of_the_last_edges(sampled_edges, stepped, edges, order):
    """Within the bounds: angle in the sector, speed from 0 to order x sector / (time that has passed for certain)."""
    times = 1e-3 * np.arange(301)
    angles = 0.3 + 150.0 * times + 5.0 * np.sin(20.0 * times)
    rows = sampled_edges(INDEXED.edges, times, angles)
    shown, _ = stepped(time_stamping_estimator(time_stamping(INDEXED, edges, order), 0.0, 0.3), rows)
    seen_at, seen, number = [], [], 0
    ends = [*INDEXED.edges, TURN]
    for row, estimate in zip(rows, shown, strict=True):
        number += int(row[1])
        low = TURN * (number // 8) + ends[number % 8]
        high = TURN * (number // 8) + ends[number % 8 + 1]
        if row[1]:
            seen_at, seen = [*seen_at, row[2]][-int(edges) :], [*seen, low][-int(edges) :]
        if len(seen) < 2:
            continue
        fit = np.polyfit(np.array(seen_at) - seen_at[-1], seen, min(int(order), len(seen) - 1))
        now = row[0] - seen_at[-1]
        passed = max(now - 0.5e-3, 1e-9)
        assert estimate[0] == pytest.approx(np.clip(np.polyval(fit, now), low, high), abs=1e-9)
        wanted = np.clip(np.polyval(np.polyder(fit), now), 0.0, order * (high - low) / passed)
        assert estimate[1] == pytest.approx(wanted, rel=1e-8, abs=1e-8)


@pytest.mark.parametrize("order", [1.0, 2.0, 3.0, 5.0])
@pytest.mark.parametrize("final", [-300.0, 300.0])
def test_nothing_runs_away_when_no_edge_comes(sampled_edges, stepped, order, final):
    """Faster or slower, then stopped for 10 s."""
    times = 1e-3 * np.arange(10001)
    moving = times.clip(max=0.2)
    angles = 100.0 * moving + final * moving**2
    rows = sampled_edges(WHEEL.edges, times, angles)
    shown, _ = stepped(time_stamping_estimator(time_stamping(WHEEL, 8.0, order)), rows)
    last = np.flatnonzero(rows[:, 1])[-1]
    since = times[last + 1 :] - times[last]
    assert np.all(shown[:, 1] >= 0.0)
    assert np.all(shown[last + 1 :, 1] <= order * SECTOR / since * (1.0 + 1e-9))
    assert np.all(np.abs(shown[last:, 0] - angles[last:]) <= SECTOR)
    assert shown[-1, 1] < order * SECTOR / 9.79  # the last edge came before 0.2 s


def test_before_two_edges_the_speed_of_the_start_is_shown(sampled_edges, stepped):
    times, angles = steady(25.0, 0.1, 0.01)
    rows = sampled_edges(WHEEL.edges, times, angles)
    shown, _ = stepped(time_stamping_estimator(time_stamping(WHEEL), 0.0, 0.1, 90.0), rows)
    known = np.cumsum(rows[:, 1] > 0.0)
    np.testing.assert_array_equal(shown[known < 2, 1], 90.0)
    np.testing.assert_allclose(shown[known == 0, 0], 0.1 + 90.0 * times[known == 0])
    assert shown[-1, 1] == pytest.approx(50.0 * np.pi)
    assert np.isnan(shown[:, 2:4]).all()
    assert np.isfinite(shown[:, [0, 1, 4, 5, 6]]).all()


def test_two_edges_with_one_stamp_are_one(stepped):
    rows = np.array([[1e-3, 1.0, 0.5e-3, 0.0, -1.0], [2e-3, 1.0, 0.5e-3, 0.0, 1.0], [8e-3, 1.0, 7.5e-3, 0.0, -1.0]])
    shown, memory = stepped(time_stamping_estimator(time_stamping(WHEEL), 0.0, 0.1, 90.0), rows)
    assert memory.known == 2.0
    assert np.isfinite(shown[:, :2]).all()


def test_times_may_begin_anywhere(sampled_edges, stepped):
    times, angles = steady(24.7, 0.3, 0.3)
    settings = time_stamping(WHEEL, 8.0, 2.0)
    shown, _ = stepped(time_stamping_estimator(settings, 0.0, 0.3), sampled_edges(WHEEL.edges, times, angles))
    later, _ = stepped(
        time_stamping_estimator(settings, 4096.0, 0.3), sampled_edges(WHEEL.edges, times + 4096.0, angles)
    )
    np.testing.assert_allclose(later[:, :2], shown[:, :2], rtol=1e-6, atol=1e-6)


def test_compiled_is_plain(sampled_edges, stepped):
    times, angles = steady(24.7, 0.3)
    rows = sampled_edges(INDEXED.edges, times, angles)
    found = time_stamping_estimator(time_stamping(INDEXED, 8.0, 2.0))
    replay = Replay(found.step, found.memory, Reading(0.0, 0.0, 0.0, 0.0, 0.0), found.settings)
    np.testing.assert_allclose(replay(found.memory, rows).shown, stepped(found, rows)[0], rtol=1e-10, atol=1e-10)
    assert not found.memory.times.any()


@pytest.mark.parametrize(
    "edges, order, told", [(8.0, 0.0, "order: 0 must"), (2.0, 2.0, "at least 3"), (4.5, 1.0, "edges: 4.5 must")]
)
def test_fits_that_cannot_be_are_refused(edges, order, told):
    with pytest.raises(ParameterError, match=told):
        replace(time_stamping(WHEEL), edges=edges, order=order)
