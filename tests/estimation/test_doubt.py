"""After a silence: the odds against the likelihoods of whole records; a dropout is taken up again, a stop is not."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from vvdp.estimation.doubt import DECIDED, LONGEST, NumberedEdge, carry_on, is_settled, no_doubt
from vvdp.estimation.event_filter import event_filter_step
from vvdp.estimation.event_memory import event_filter_start
from vvdp.estimation.event_settings import event_filter
from vvdp.estimation.ripple import ripple_start
from vvdp.numerics.kalman import AngleSpeed, predict, update
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import equal_wheel

WHEEL = equal_wheel(8)
SECTOR = np.pi / 4.0
PUBLISHED = event_filter(WHEEL)


def log_likelihood(belief, times, angles, q, R):
    """Of all edges at once, by their joint normal distribution: no filter has a part in it."""
    P = np.array([[belief.angle_variance, belief.covariance], [belief.covariance, belief.speed_variance]])
    F = np.column_stack([np.ones_like(times), times])
    one, other = np.meshgrid(times, times)
    first, second = np.where(one < other, (one, other), (other, one))
    walk = q * first**2 * (3.0 * second - first) / 6.0
    covariance = F @ P @ F.T + walk + R * np.eye(times.size)
    return multivariate_normal(belief.angle + times * belief.speed, covariance).logpdf(angles)


def test_odds_are_those_of_two_records():
    """Five edges as a wheel at 155 rad/s and one at 100 rad/s have them, met by both; odds of 1/e before."""
    went_on, began = AngleSpeed(0.1, 155.0, 4e-3, 0.01, 4.0), AngleSpeed(0.0, 80.0, 5e-3, 0.0, 900.0)
    q, R, start = 0.25, 4e-3, -1.0
    rng = np.random.default_rng(3)
    for speed in (155.0, 100.0):
        times = (SECTOR * np.arange(1, 6) + 0.06 * rng.normal(size=5)) / speed
        silent, stood = SECTOR * np.round(155.0 * times / SECTOR), SECTOR * np.arange(1, 6)
        exact = start + log_likelihood(went_on, times, silent, q, R) - log_likelihood(began, times, stood, q, R)
        doubt = no_doubt(went_on)._replace(odds=start)
        belief, before = began, 0.0
        for time, seen, counted in zip(times, silent, stood, strict=True):
            belief, other = (predict(each, time - before, q) for each in (belief, doubt.belief))
            nu, S, before = counted - belief.angle, belief.angle_variance + R, time
            doubt = carry_on(doubt, other, NumberedEdge(0.0, seen), R, nu * nu / S + np.log(S))
            belief = update(belief, nu, R)
        assert doubt.odds == pytest.approx(exact, rel=1e-9) and doubt.edges == 5.0


def test_what_missed_edges_cost_is_a_likelihood():
    """p = 1/20 of two more missed edges: the odds fall by ln 20 beside what the innovations say."""
    doubt, prior = no_doubt(AngleSpeed(0.0, 1.0, 1.0, 0.0, 1.0))._replace(odds=0.0), AngleSpeed(0.0, 1.0, 1.0, 0.0, 1.0)
    assert carry_on(doubt, prior, NumberedEdge(1.0, 0.0), 1.0, np.log(2.0)).odds == pytest.approx(0.0, abs=1e-15)
    told = carry_on(doubt, prior, NumberedEdge(1.0, 0.0), 1.0, np.log(2.0) + 2.0 * np.log(0.05))
    assert told.odds == pytest.approx(-np.log(20.0))


def test_settled_by_odds_or_by_length():
    doubt = no_doubt(AngleSpeed(0.0, 1.0, 1.0, 0.0, 1.0))
    for odds, edges, settled in ((0.0, 3.0, False), (DECIDED, 3.0, False), (1.01 * DECIDED, 3.0, True)):
        assert is_settled(doubt._replace(odds=odds, edges=edges)) is settled
        assert is_settled(doubt._replace(odds=-odds, edges=edges)) is settled
    assert is_settled(doubt._replace(odds=0.1, edges=LONGEST)) and is_settled(doubt)


def record(speed, until=3.0, seed=0, deviation=0.0589, ripple=0.0):
    """Time, angle and speed on a fine grid; angles and stamped times of the edges that pass on the way."""
    rng, t = np.random.default_rng(seed), np.arange(0.0, until, 2e-5)
    phi = np.concatenate([[0.0], np.cumsum(speed(t[1:]) * 2e-5)]) + 0.7 * rng.random()
    theta = phi
    for _ in range(8):
        theta = phi + ripple * np.sin(3.0 * theta) / 3.0
    numbers = np.arange(1, int(theta[-1] / SECTOR) + 1)
    angles = SECTOR * numbers
    seen = angles + deviation * rng.normal(size=numbers.size)
    first = np.searchsorted(theta, seen)
    order = np.argsort(first)
    kept = order[(first[order] > 0) & (first[order] < t.size)]
    return t, theta, t[first[kept]], numbers[kept]


def rows_of(times, numbers, until=3.0):
    """Samples at 1 kHz, with the last edge of each stamped; none where `numbers` is empty."""
    time = np.arange(1e-3, until, 1e-3)
    rows = np.zeros((time.size, 5))
    rows[:, 0] = time
    at = np.searchsorted(time, times)
    for i, at_time, number in zip(at, times, numbers, strict=True):
        if i < time.size:
            rows[i] = rows[i, 0], rows[i, 1] + 1.0, at_time, 0.0, 1.0 - 2.0 * (number % 2.0)
    return rows


@pytest.mark.parametrize(("gap", "deviation", "ripple"), [(0.1, 0.0589, 0.0), (0.3, 0.0589, 0.0), (0.15, 0.02, 0.14)])
def test_a_dropout_is_taken_up_again(filtered, gap, deviation, ripple):
    """20 to 60 edges do not come: the wheel is thought to stand, and a few edges later to have gone on. No sector is
    lost, in ten records; with a ripple that puts edges off by more than their noise it is weighed beside it."""
    settings = replace(PUBLISHED, edge_variance=deviation**2)
    if ripple:
        settings = replace(settings, ripple_order=3.0, ripple_variance=0.5 * ripple**2)
    for seed in range(10):
        t, theta, times, numbers = record(lambda t: 155.0 + 0.0 * t, seed=seed, deviation=deviation, ripple=ripple)
        lost = (times > 2.0) & (times < 2.0 + gap)
        rows = rows_of(times[~lost], numbers[~lost])
        shown, memory = filtered(settings, rows, speed=155.0)
        time = rows[:, 0]
        error = shown[:, 0] - np.interp(time, t, theta)
        assert np.max(shown[(time > 2.0) & (time < 2.0 + gap), 7]) > 0.5
        assert abs(np.median(error[time > 2.8]) - np.median(error[(time > 1.0) & (time < 1.9)])) < 0.1
        assert memory.doubt.odds == -np.inf and abs(memory.tally.missed_edges - np.count_nonzero(lost)) <= 2.0
        assert np.all(shown[time > 2.8, 7] < 0.5)


def test_a_doubt_is_about_the_mean_course():
    """Exact edges of a spool whose ripple of 12 % is known: the belief carried on stays on the mean course, angle and
    speed, from which edges off by up to 0.12/3 = 0.04 rad would draw it away."""
    settings = replace(PUBLISHED, ripple_order=3.0, ripple_variance=1e-12)
    start = event_filter_start(settings, 0.0, 0.0, 155.0)
    memory = start._replace(
        belief=start.belief._replace(angle_variance=1e-4, speed_variance=1e-4),
        ripple=ripple_start(1e-12)._replace(cosine=0.1, sine=0.06),
    )
    angles = SECTOR * np.arange(1, 120)
    times = (angles - (0.1 * np.sin(3.0 * angles) - 0.06 * np.cos(3.0 * angles)) / 3.0) / 155.0
    lost = (times > 0.3) & (times < 0.4)
    met = 0
    for row in rows_of(times[~lost], np.arange(1, 120)[~lost], until=0.5).tolist():
        memory, _ = event_filter_step(memory, Reading(*row), settings)
        if memory.doubt.odds > -np.inf and row[1] > 0.0:
            met += 1
            assert memory.doubt.belief.angle == pytest.approx(155.0 * memory.time, abs=1e-4)
            assert memory.doubt.belief.speed == pytest.approx(155.0, abs=0.01)
    assert met >= 2 and memory.doubt.odds == -np.inf


def test_a_stop_is_not_taken_for_a_dropout(filtered):
    """From 155 rad/s to rest within 50 ms and back after half a second, in ten records: the angle is right to the
    sector within which the wheel may have turned back, and that is stated."""
    for seed in range(10):
        t, theta, times, numbers = record(
            lambda t: 155.0 * (np.clip(1.0 - (t - 1.5) / 0.05, 0.0, 1.0) + np.clip((t - 2.05) / 0.05, 0.0, 1.0)),
            seed=seed,
        )
        rows = rows_of(times, numbers)
        shown, memory = filtered(PUBLISHED, rows, speed=155.0)
        time = rows[:, 0]
        error = shown[:, 0] - np.interp(time, t, theta)
        moved = np.median(error[time > 2.7]) - np.median(error[(time > 1.0) & (time < 1.5)])
        assert abs(moved) < SECTOR and np.all(shown[time > 2.7, 2] > 0.9 * SECTOR / np.sqrt(3.0))
        assert memory.doubt.odds == -np.inf
        assert np.all(shown[(time > 1.65) & (time < 2.0), 7] > 0.5)
        assert shown[-1, 1] == pytest.approx(155.0, abs=2.0) and shown[-1, 7] < 0.5
