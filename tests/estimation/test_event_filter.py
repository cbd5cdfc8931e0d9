"""The event filter's step: by hand, against filterpy, in all situations that an acquisition can bring about."""

from dataclasses import replace

import numpy as np
import pytest

from vvdp.base.errors import ParameterError
from vvdp.estimation.between_edges import inflate
from vvdp.estimation.event_filter import event_filter_estimator, event_filter_step
from vvdp.estimation.event_memory import LastEdge, Manoeuvre, event_filter_start
from vvdp.estimation.event_settings import event_filter
from vvdp.estimation.expected_edge import edge_angle_variance
from vvdp.numerics.kalman import AngleSpeed, predict
from vvdp.sensing.reading import Reading
from vvdp.sensing.wheel import edge_angle, equal_wheel
from vvdp.simulation.replay import Replay

WHEEL, INDEXED = equal_wheel(8), equal_wheel(8, 0.25)
SECTOR = np.pi / 4.0
PUBLISHED = event_filter(WHEEL)
NEVER_STOPS = replace(PUBLISHED, stop_rate=0.0)
STEADY = replace(PUBLISHED, manoeuvre_gate=1e6)
NOTHING = Reading(1.0, 0.0, 0.0, 0.0, 0.0)


def steady_rows(edge_times, speed=155.0, duration=1.0, phase=0.3, wheel=WHEEL, deviation=0.0, seed=0):
    rng = np.random.default_rng(seed)
    numbers, angles = edge_times.angles(wheel.edges, 1, int(duration * speed / SECTOR) + 16)
    times = (angles + deviation * rng.normal(size=angles.size)) / speed
    return edge_times.clocked(times, 1.0 - 2.0 * (numbers % 2.0), phase, duration)


def test_noise_by_hand():
    """157.08 rad/s in 1 ms: 0.15708^2/12 = 2.0562e-3, and 3.47e-3 to it: the published 5.53e-3 rad^2."""
    assert edge_angle_variance(157.08, 1e-3, PUBLISHED) == pytest.approx(5.5262e-3, abs=1e-7)
    assert edge_angle_variance(68.7, 1e-3, PUBLISHED) == pytest.approx(3.47e-3 + 3.9331e-4, abs=1e-7)
    assert edge_angle_variance(157.08, 0.0, PUBLISHED) == 3.47e-3
    lowest = (2.0 * np.pi * 1e-3) ** 2 / 12.0 + 3.47e-3
    assert edge_angle_variance(1.0, 1e-3, PUBLISHED) == edge_angle_variance(-5.0, 1e-3, PUBLISHED) == lowest


def test_first_edge_by_hand():
    """Falling edge 1 at pi/4, stamped at 10 ms, seen at 11 ms. P11- = 2 + 0.01^2 x 1000 = 2.1 (and q h^3/3 = 8.3e-8),
    P12- = 10 (and 1.25e-5); R = 0.01; innovation 0.785398 - 0.5 = 0.285398. S = 2.11: K = (0.995261, 4.739342).
    """
    settings = replace(PUBLISHED, edge_variance=0.01, angle_variance=2.0)
    memory = event_filter_start(settings, 0.0, 0.0, 50.0)
    memory, estimate = event_filter_step(memory, Reading(0.011, 1.0, 0.01, 0.0, -1.0), settings)
    assert memory.last.number == 1.0
    assert estimate.innovation == pytest.approx(0.285398, abs=1e-6)
    assert estimate.innovation_deviation == pytest.approx(np.sqrt(2.11), rel=1e-6)
    assert memory.belief.angle == pytest.approx(0.5 + 0.995261 * 0.285398, abs=2e-6)
    assert estimate.speed == pytest.approx(50.0 + 4.739342 * 0.285398, abs=2e-5)
    assert estimate.angle == pytest.approx(memory.belief.angle + 1e-3 * estimate.speed, abs=1e-12)
    assert memory.belief.angle_variance == pytest.approx(2.1 * 0.01 / 2.11, rel=1e-6)


def test_samples_between_edges_are_predictions(edge_times):
    """Taken with every sample or with the edges alone, the estimates at the edges are the same."""
    rows = steady_rows(edge_times)
    memory, whole = event_filter_estimator(PUBLISHED, speed=50.0).memory, []
    sparse = memory
    for row in rows.tolist():
        reading = Reading(*row)
        memory, estimate = event_filter_step(memory, reading, PUBLISHED)
        belief = predict(memory.belief, reading.time - memory.time, memory.manoeuvre.density)
        assert estimate[:4] == pytest.approx(
            (belief.angle, belief.speed, np.sqrt(belief.angle_variance), np.sqrt(belief.speed_variance)), rel=1e-12
        )
        if reading.edges:
            sparse, shown = event_filter_step(sparse, reading, PUBLISHED)
            assert shown == estimate
        else:
            assert estimate.innovation == estimate.innovation_deviation == 0.0
        whole.append(estimate)
    speeds = np.array([estimate.speed for estimate in whole])
    assert np.all(np.diff(speeds)[rows[1:, 1] == 0.0] == 0.0)


def test_filterpy_gives_the_same(edge_times):
    from filterpy.kalman import KalmanFilter

    rows = steady_rows(edge_times, deviation=0.05)
    other = KalmanFilter(dim_x=2, dim_z=1)
    other.x, other.P = np.array([[0.0], [50.0]]), np.diag([1000.0, 1000.0])
    other.H = np.array([[1.0, 0.0]])
    memory = event_filter_estimator(STEADY, speed=50.0).memory
    used = 0
    for row in rows.tolist():
        before = memory
        memory, estimate = event_filter_step(memory, Reading(*row), STEADY)
        if estimate.innovation_deviation == 0.0:
            continue
        h = memory.time - before.time
        other.F = np.array([[1.0, h], [0.0, 1.0]])
        other.Q = 0.25 * np.array([[h**3 / 3.0, h**2 / 2.0], [h**2 / 2.0, h]])
        other.R = np.array([[edge_angle_variance(before.belief.speed, 1e-3, STEADY)]])
        other.predict()
        other.update(edge_angle(memory.last.number, WHEEL))
        b = memory.belief
        np.testing.assert_allclose([b.angle, b.speed], other.x[:, 0], rtol=1e-9)
        np.testing.assert_allclose([b.angle_variance, b.covariance, b.speed_variance], other.P.ravel()[[0, 1, 3]], 1e-9)
        used += 1
    assert used > 150


def test_covariance_is_that_of_the_information_form(edge_times):
    """P+ = (P-^-1 + H R^-1 H')^-1 and K = P+ H R^-1 (eqs. 3.8 and 3.9 put right), to 1e-9 at every edge."""
    memory, compared = event_filter_estimator(STEADY, speed=50.0).memory, 0
    for row in steady_rows(edge_times, deviation=0.05).tolist():
        before = memory
        memory, estimate = event_filter_step(memory, Reading(*row), STEADY)
        if estimate.innovation_deviation == 0.0:
            continue
        prior = predict(before.belief, memory.time - before.time, STEADY.acceleration_density)
        R = edge_angle_variance(before.belief.speed, 1e-3, STEADY)
        P = np.array([[prior.angle_variance, prior.covariance], [prior.covariance, prior.speed_variance]])
        after = np.linalg.inv(np.linalg.inv(P) + np.diag([1.0 / R, 0.0]))
        b = memory.belief
        np.testing.assert_allclose([b.angle_variance, b.covariance, b.speed_variance], after.ravel()[[0, 1, 3]], 1e-9)
        gain = after[:, 0] / R * estimate.innovation
        np.testing.assert_allclose([b.angle - prior.angle, b.speed - prior.speed], gain, rtol=1e-8, atol=1e-12)
        compared += 1
    assert compared > 150


def covariances(s, t, p, q):
    """Covariance of (theta, omega) at s with (theta, omega) at t >= s, as they were diag(p, p) at 0.

    omega = omega_0 + W and theta = theta_0 + omega_0 t + int W, with E[W(s) W(t)] = q min(s, t).
    """
    return np.array(
        [
            [p + p * s * t + q * s * s * (3.0 * t - s) / 6.0, p * s + 0.5 * q * s * s],
            [p * t + q * s * (t - 0.5 * s), p + q * s],
        ]
    )


@pytest.mark.parametrize("edges", [1, 2, 5, 20])
def test_it_is_the_posterior_of_the_whole_record(edge_times, edges):
    """All angles at once: the joint normal distribution of the record, conditioned on its edges without a recursion."""
    memory, times, angles, variances = event_filter_estimator(STEADY, speed=50.0).memory, [], [], []
    for row in steady_rows(edge_times, deviation=0.05, seed=edges).tolist():
        before = memory
        memory, estimate = event_filter_step(memory, Reading(*row), STEADY)
        if estimate.innovation_deviation > 0.0:
            times.append(memory.time)
            angles.append(edge_angle(memory.last.number, WHEEL))
            variances.append(edge_angle_variance(before.belief.speed, 1e-3, STEADY))
        if len(times) == edges:
            break
    t, p, q = np.array(times), 1000.0, STEADY.acceleration_density
    seen = np.array([[covariances(min(a, b), max(a, b), p, q)[0, 0] for a in t] for b in t]) + np.diag(variances)
    last = np.array([covariances(a, t[-1], p, q)[0] for a in t])  # of each angle with the last angle and speed
    weights = np.linalg.solve(seen, last).T
    mean = np.array([50.0 * t[-1], 50.0]) + weights @ (np.array(angles) - 50.0 * t)
    covariance = covariances(t[-1], t[-1], p, q) - weights @ last
    b = memory.belief
    np.testing.assert_allclose([b.angle, b.speed], mean, rtol=1e-7)
    np.testing.assert_allclose(
        [b.angle_variance, b.covariance, b.speed_variance], covariance.ravel()[[0, 1, 3]], rtol=1e-5, atol=1e-9
    )


def test_plain_and_compiled_agree(edge_times, filtered):
    for settings, deviation in ((PUBLISHED, 0.06), (event_filter(INDEXED), 0.06)):
        rows = steady_rows(edge_times, wheel=settings.wheel, deviation=deviation, duration=0.6)
        estimator = event_filter_estimator(settings, speed=140.0)
        memory, plain = estimator.memory, []
        for row in rows.tolist():
            memory, estimate = event_filter_step(memory, Reading(*row), settings)
            plain.append(estimate)
        shown, last = filtered(settings, rows, speed=140.0)
        np.testing.assert_allclose(shown, plain, rtol=1e-12, atol=1e-12)
        np.testing.assert_array_equal(last.search.numbers, memory.search.numbers)
        assert last.last.number == memory.last.number
        assert last.search.found == settings.index_turns / 2.0


def test_portions_and_another_origin_of_time_change_nothing(edge_times, filtered):
    """2^10 s and millisecond steps in binary: times stay exact to 2e-13 s."""
    rows = steady_rows(edge_times, deviation=0.05)
    shown, _ = filtered(PUBLISHED, rows, speed=100.0)
    later = rows.copy()
    later[:, [0, 2]] += 1024.0
    moved, _ = filtered(PUBLISHED, later, time=1024.0, speed=100.0)
    np.testing.assert_allclose(moved, shown, rtol=1e-7, atol=1e-7)
    estimator = event_filter_estimator(PUBLISHED, speed=100.0)
    replay = Replay(estimator.step, estimator.memory, NOTHING, PUBLISHED)
    first = replay(estimator.memory, rows[:333])
    np.testing.assert_array_equal(np.vstack([first.shown, replay(first.memory, rows[333:]).shown]), shown)


def test_before_any_edge_the_start_is_carried_on():
    estimator = event_filter_estimator(PUBLISHED, time=5.0, angle=0.3, speed=2.0)
    _, estimate = event_filter_step(estimator.memory, Reading(6.0, 0.0, 0.0, 0.0, 0.0), PUBLISHED)
    expected = predict(AngleSpeed(0.3, 2.0, 1000.0, 0.0, 1000.0), 1.0, 0.25)
    assert estimate.angle == pytest.approx(2.3)
    assert estimate.angle_deviation == pytest.approx(np.sqrt(expected.angle_variance))
    assert estimate.speed_deviation == pytest.approx(np.sqrt(1000.25))
    assert np.all(np.isfinite(estimate))


@pytest.mark.parametrize("interval", [0.0, 1e-3])
@pytest.mark.parametrize("known", [True, False])
def test_time_stamps_and_unknown_polarity(edge_times, filtered, interval, known):
    """Exact time stamps of a steady wheel leave no error but rounding once the start has faded: 1/n^2 of 2.6 rad/s
    and below 1e-3 rad/s after 1 s. Without a polarity the sectors are told by counting alone.
    """
    speed = 155.0
    numbers, angles = edge_times.angles(WHEEL.edges, 1, 240)
    times = angles / speed
    rows = edge_times.clocked(times, 1.0 - 2.0 * (numbers % 2.0), 0.4, 1.0)
    if interval == 0.0:
        rows[rows[:, 1] > 0.0, 2] = times[: int(np.sum(rows[:, 1]))]
        rows[:, 3] = 0.0
    if not known:
        rows[:, 4] = 0.0
    shown, _ = filtered(PUBLISHED, rows, speed=150.0)
    late = rows[:, 0] > 0.8
    tolerance = (1e-3, 2e-3) if interval == 0.0 else (0.04, 0.5)
    assert np.max(np.abs(shown[late, 0] - speed * rows[late, 0])) < tolerance[0]
    assert np.max(np.abs(shown[late, 1] - speed)) < tolerance[1]


@pytest.mark.parametrize(("rise", "fall", "edge"), [(0.0, 0.0, 507.0), (5.6, 0.0, 507.0), (0.0, 5.6, 505.0)])
def test_only_late_edges_make_a_slower_wheel_likely(rise, fall, edge):
    """Three edges of 503 to 507 missed at 68.5 rad/s, the fourth just where it is expected: two more than for 505, the
    next that falls, -2 ln 0.05 = 6.0. 505 is 2 sectors = 1.57 rad behind: after a manoeuvre 1.96 deviations,
    sqrt(2e4 0.0459^3/3) = 0.8 and ln(0.80/0.075) = 2.4: 4.3, and the odds against it, 12 or, after late edges only,
    2 (6 - 5.6) = 0.8: 5.1.
    """
    still = event_filter_start(PUBLISHED, 0.0, 0.0, 68.5)
    belief = AngleSpeed(edge_angle(503.0, WHEEL), 68.5, 1.1e-3, 7e-3, 0.04)
    q = PUBLISHED.acceleration_density
    memory = still._replace(
        belief=belief,
        last=LastEdge(503.0, 0.0),
        tally=still.tally._replace(started=1.0, associating=1.0, irregular=0.05),
        manoeuvre=Manoeuvre(density=q, unrest=q, rise=rise, fall=fall),
    )
    passed = 4.0 * SECTOR / 68.5
    after, _ = event_filter_step(memory, Reading(passed + 5e-4, 1.0, passed, 1e-3, -1.0), NEVER_STOPS)
    assert after.last.number == edge


@pytest.mark.parametrize("late", [-0.15, 0.0, 0.15])
def test_innovations_are_summed_up_by_side(late):
    """With z = innovation / deviation `rise` gains z - 1 and `fall` -z - 1, neither below 0; a late edge has z < 0."""
    speed, variance = 150.0, 1e-4
    q, start = PUBLISHED.acceleration_density, event_filter_start(PUBLISHED, 0.0, 0.0, speed)
    memory = start._replace(
        belief=AngleSpeed(0.0, speed, variance, 0.0, 0.01),
        last=LastEdge(0.0, 0.0),
        tally=start.tally._replace(started=1.0, associating=1.0, irregular=0.01),
        manoeuvre=Manoeuvre(density=q, unrest=q, rise=1.5, fall=2.5),
    )
    t = (SECTOR + late) / speed
    after, estimate = event_filter_step(memory, Reading(t, 1.0, t, 0.0, -1.0), PUBLISHED)
    z = estimate.innovation / estimate.innovation_deviation
    assert z == pytest.approx(-late / np.sqrt(variance + 3.47e-3), rel=1e-2, abs=1e-6)
    assert after.manoeuvre.rise == pytest.approx(max(1.5 + z - 1.0, 0.0))
    assert after.manoeuvre.fall == pytest.approx(max(2.5 - z - 1.0, 0.0))


def test_more_acceleration_than_was_thought_is_the_propagation_with_it():
    belief = AngleSpeed(1.0, 68.5, 1.1e-3, 7e-3, 0.04)
    np.testing.assert_allclose(
        inflate(predict(belief, 0.011, 3.0), 0.011, 2e4), predict(belief, 0.011, 2e4 + 3.0), rtol=1e-14
    )


def test_between_edges_another_sensor_may_tell_the_angle():
    """Edge 503 passed at 0, the belief was renewed 5 ms later. At 6.5 ms the wheel has turned by 0.445 rad, more than
    half of a sector: the edge that comes 0.34 rad early (4.6 deviations) is no bounce. Since 5 ms it were 0.10 rad.

    S_m grows from 0 as well: 2e4 0.0065^3/3 = 1.83e-3 rad^2 above R and P11.
    """
    start = event_filter_start(PUBLISHED, 0.0, 0.0, 68.5)
    belief = AngleSpeed(edge_angle(503.0, WHEEL) + 5e-3 * 68.5, 68.5, 3e-4, 1e-3, 0.04)
    q = PUBLISHED.acceleration_density
    memory = start._replace(
        time=5e-3,
        belief=belief,
        last=LastEdge(503.0, 0.0),
        tally=start.tally._replace(started=1.0, associating=1.0, irregular=0.01),
        manoeuvre=Manoeuvre(density=q, unrest=q, rise=0.0, fall=0.0),
    )
    edge = Reading(7e-3, 1.0, 6.5e-3, 1e-3, 1.0)
    after, estimate = event_filter_step(memory, edge, PUBLISHED)
    assert (*after.last, after.time) == (504.0, 6.5e-3, 6.5e-3)
    assert estimate.innovation == pytest.approx(SECTOR - 6.5e-3 * 68.5, abs=1e-12)
    assert after.manoeuvre.density == PUBLISHED.manoeuvre_density
    prior = predict(belief, 1.5e-3, 0.0)
    R = edge_angle_variance(68.5, 1e-3, PUBLISHED)
    assert estimate.innovation_deviation**2 == pytest.approx(
        prior.angle_variance + 2e4 * 6.5e-3**3 / 3.0 + R, rel=1e-12
    )


def test_printed_gain_diverges(edge_times):
    """K = P H as printed in equation 3.8 has the unit rad^2: by 1 s the angle is off by thousands of rad.

    The same data with the right gain stay within 0.1 rad.
    """
    rng = np.random.default_rng(0)
    speed = 157.08
    _, angles = edge_times.angles(WHEEL.edges, 1, 199)
    belief, time = AngleSpeed(0.0, 50.0, 1000.0, 0.0, 1000.0), 0.0
    for angle in angles:
        passed = angle / speed + 1e-3 * (rng.random() - 0.5)
        belief, time = predict(belief, passed - time, 0.25), passed
        P = np.array([[belief.angle_variance, belief.covariance], [belief.covariance, belief.speed_variance]])
        gain = P[:, 0]
        P = np.linalg.inv(np.linalg.inv(P) + np.diag([1.0 / 5.53e-3, 0.0]))
        innovation = angle - belief.angle
        belief = AngleSpeed(
            belief.angle + gain[0] * innovation, belief.speed + gain[1] * innovation, P[0, 0], P[0, 1], P[1, 1]
        )
    assert abs(belief.angle - speed * time) > 1000.0
    assert abs(belief.speed - speed) > 1000.0


def test_settings_that_contradict_are_refused():
    with pytest.raises(ParameterError, match="no edge is known exactly"):
        replace(PUBLISHED, edge_variance=0.0)
    with pytest.raises(ParameterError, match=r"manoeuvre_edges: 0\.5"):
        replace(PUBLISHED, manoeuvre_edges=0.5)
    with pytest.raises(ParameterError, match=r"must be at least acceleration_density, 0\.25 rad"):
        replace(PUBLISHED, manoeuvre_density=0.1)
    with pytest.raises(ParameterError, match="looks the same after less than a revolution"):
        replace(PUBLISHED, index_turns=2.0)
    with pytest.raises(ParameterError, match="ripple of order 3"):
        replace(PUBLISHED, ripple_order=3.0)
    assert PUBLISHED.index_turns == 0.0
    assert event_filter(INDEXED).index_turns == 2.0


def test_memory_given_is_left_alone(edge_times):
    settings = event_filter(INDEXED)
    memory = event_filter_estimator(settings, speed=150.0).memory
    for row in steady_rows(edge_times, wheel=INDEXED, duration=0.2).tolist():
        kept = [memory.search.numbers.copy(), memory.search.times.copy(), memory.search.evidence.copy()]
        later, _ = event_filter_step(memory, Reading(*row), settings)
        for before, now in zip(kept, memory.search[:3], strict=True):
            np.testing.assert_array_equal(before, now)
        memory = later
