"""The smoother: equal to conditioning one big Gaussian, symmetric in time, and honest about its errors."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from vvdp.base.errors import ParameterError
from vvdp.estimation.smoother import (
    EdgePassed,
    Forward,
    Reached,
    SpeedWalk,
    filter_edges,
    filtered_step,
    run_on_columns,
    run_plainly,
    smooth_edges,
    smoothed_at,
    smoothed_portions,
    smoothed_step,
    smoothing_overlap,
)
from vvdp.numerics.kalman import AngleSpeed
from vvdp.simulation.replay import Replay

Q = 0.25
PRIOR = AngleSpeed(1.0, 140.0, 2.0, 0.3, 900.0)
DIFFUSE = AngleSpeed(0.0, 0.0, 1e9, 0.0, 1e9)


def transition(h):
    return np.array([[1.0, h], [0.0, 1.0]])


def noise(h, q):
    return q * np.array([[h**3 / 3, h**2 / 2], [h**2 / 2, h]])


def drawn_record(rng, n, q, prior, mean_interval=5e-3):
    """Edge times, true states, measured angles and their variances, drawn from the model itself."""
    times = 3.0 + np.cumsum(rng.uniform(0.2, 1.8, n)) * mean_interval
    variances = rng.uniform(2e-3, 8e-3, n)
    P = np.array([[prior.angle_variance, prior.covariance], [prior.covariance, prior.speed_variance]])
    x = rng.multivariate_normal([prior.angle, prior.speed], P)
    states = [x]
    for h in np.diff(times):
        x = rng.multivariate_normal(transition(h) @ x, noise(h, q))
        states.append(x)
    states = np.array(states)
    return times, states, states[:, 0] + np.sqrt(variances) * rng.standard_normal(n), variances


def joint(times, q, prior):
    """Mean (2 m,) and covariance (2 m, 2 m) of the states at `times` before anything is measured; prior at times[0].

    Cov(x_i, x_j) = P_i F(t_j - t_i)' for i <= j, with P_i propagated from the prior by quadrature-free matrices.
    """
    m = len(times)
    x = np.array([prior.angle, prior.speed])
    P = np.array([[prior.angle_variance, prior.covariance], [prior.covariance, prior.speed_variance]])
    mean, covariance = np.empty(2 * m), np.empty((2 * m, 2 * m))
    for i, t in enumerate(times):
        F = transition(t - times[0])
        mean[2 * i : 2 * i + 2] = F @ x
        P_i = F @ P @ F.T + noise(t - times[0], q)
        for j in range(i, m):
            block = P_i @ transition(times[j] - t).T
            covariance[2 * i : 2 * i + 2, 2 * j : 2 * j + 2] = block
            covariance[2 * j : 2 * j + 2, 2 * i : 2 * i + 2] = block.T
    return mean, covariance


def conditioned(mean, covariance, seen, angles, variances):
    """The joint Gaussian given angles at the states numbered `seen`."""
    H = np.zeros((len(seen), mean.size))
    H[np.arange(len(seen)), 2 * np.asarray(seen)] = 1.0
    S = H @ covariance @ H.T + np.diag(variances)
    K = np.linalg.solve(S, H @ covariance).T
    return mean + K @ (angles - H @ mean), covariance - K @ S @ K.T


def assert_beliefs(motion, mean, covariance, rel=1e-9):
    """Means to 1e-9 of their size, variances to 1e-9 of theirs."""
    n = motion.angle.size
    blocks = np.array([covariance[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] for i in range(n)])
    np.testing.assert_allclose(motion.angle, mean[0::2], rtol=rel, atol=1e-9)
    np.testing.assert_allclose(motion.speed, mean[1::2], rtol=rel, atol=1e-8)
    scale = np.sqrt(blocks[:, 0, 0] * blocks[:, 1, 1])
    np.testing.assert_allclose(motion.angle_variance, blocks[:, 0, 0], rtol=rel)
    np.testing.assert_allclose(motion.speed_variance, blocks[:, 1, 1], rtol=rel)
    assert np.all(abs(motion.covariance - blocks[:, 0, 1]) < rel * scale)


def compiled(step, memory, row, walk, rows):
    replayed = Replay(step, memory, row, walk)(memory, rows)
    return replayed.memory, replayed.shown


@pytest.fixture(scope="module")
def short_record():
    return drawn_record(np.random.default_rng(5), 12, 200.0, PRIOR)


def test_two_edges_by_hand():
    """Prior diag(1, 1), q = 3, R = 1, edges of angle 0 and 1 one second apart.

    First edge: P11 = 1/2, P22 = 1, x = (0, 0). Moved by 1 s: M11 = 1/2 + 1 + 3/3 = 5/2, M12 = 1 + 3/2 = 5/2,
    M22 = 1 + 3 = 4. Second edge: S = 7/2, K = (5/7, 5/7); x = (5/7, 5/7), P11 = 5/7, P12 = 5/7,
    P22 = 4 - 25/14 = 31/14.
    Back: angle_0 has with angle_1 (unseen second edge) the covariance P11 = 1/2, speed_0 has P22 = 1, so
    x_0 = (1/2, 1)/S = (1/7, 2/7), its variances 1/2 - (1/4)/S = 3/7 and 1 - 1/S = 5/7, covariance -(1/2)/S = -1/7.
    """
    record = smooth_edges([0.0, 1.0], [0.0, 1.0], [1.0, 1.0], 3.0, AngleSpeed(0.0, 0.0, 1.0, 0.0, 1.0))
    motion = np.array(record.beliefs)
    np.testing.assert_allclose(motion[:, 0], [1 / 7, 2 / 7, 3 / 7, -1 / 7, 5 / 7], rtol=1e-14)
    np.testing.assert_allclose(motion[:, 1], [5 / 7, 5 / 7, 5 / 7, 5 / 7, 31 / 14], rtol=1e-14)


@pytest.mark.parametrize("q", [0.25, 200.0, 2e4])
def test_filter_and_smoother_equal_the_dense_posterior(q):
    times, _, angles, variances = drawn_record(np.random.default_rng(int(q)), 12, q, PRIOR)
    mean, covariance = joint(times, q, PRIOR)
    seen = np.arange(12)
    record = smooth_edges(times, angles, variances, q, PRIOR)
    posterior, P = conditioned(mean, covariance, seen, angles, variances)
    assert_beliefs(record.beliefs, posterior, P)
    for i in range(11):
        block = P[2 * i : 2 * i + 2, 2 * i + 2 : 2 * i + 4]
        size = np.sqrt(np.outer(np.diag(P)[2 * i : 2 * i + 2], np.diag(P)[2 * i + 2 : 2 * i + 4]))
        assert np.all(abs(record.lagged[i] - block) < 1e-9 * size)
    forward = filter_edges(times, angles, variances, q, PRIOR)
    for i in (0, 3, 11):
        known, P = conditioned(mean, covariance, seen[: i + 1], angles[: i + 1], variances[: i + 1])
        here = type(forward)(*(column[i : i + 1] for column in forward))
        assert_beliefs(here, known[2 * i : 2 * i + 2], P[2 * i : 2 * i + 2, 2 * i : 2 * i + 2])


def test_any_time_equals_the_dense_posterior(short_record):
    """Instants between the edges, and after the last, as further states of the same big Gaussian."""
    times, _, angles, variances = short_record
    q = 200.0
    rng = np.random.default_rng(8)
    asked = np.sort(rng.uniform(times[0], times[-1] + 0.01, 25))
    everything = np.sort(np.concatenate([times, asked]))
    mean, covariance = joint(everything, q, PRIOR)
    seen = np.searchsorted(everything, times)
    mean, covariance = conditioned(mean, covariance, seen, angles, variances)
    pick = np.searchsorted(everything, asked)
    rows = np.ravel(np.column_stack([2 * pick, 2 * pick + 1]))
    motion = smoothed_at(asked, smooth_edges(times, angles, variances, q, PRIOR))
    assert_beliefs(motion, mean[rows], covariance[np.ix_(rows, rows)])


def bridged_by_matrices(times, record):
    """Angle and speed (2, n), covariance (2, 2, n) between edges, with the joint covariance of both neighbours."""
    left = np.searchsorted(record.times, times, side="right") - 1
    h = record.times[left + 1] - record.times[left]
    s = (times - record.times[left]) / h
    r = 1.0 - s
    weights = np.array(
        [
            [r * r * (1.0 + 2.0 * s), h * s * r * r, s * s * (1.0 + 2.0 * r), -h * s * s * r],
            [-6.0 * s * r / h, r * (r - 2.0 * s), 6.0 * s * r / h, s * (s - 2.0 * r)],
        ]
    )
    motion = np.array(record.beliefs)
    blocks = motion[[2, 3, 3, 4]].reshape(2, 2, -1)
    before, after, lagged = blocks[..., left], blocks[..., left + 1], np.moveaxis(record.lagged[left], 0, -1)
    joint = np.empty((4, 4, left.size))
    joint[:2, :2], joint[2:, 2:], joint[:2, 2:], joint[2:, :2] = before, after, lagged, lagged.swapaxes(0, 1)
    turned = motion[0, left + 1] - motion[0, left]
    states = np.stack([np.zeros_like(turned), motion[1, left], turned, motion[1, left + 1]])
    mean = np.einsum("ikn,kn->in", weights, states)
    q = record.acceleration_density
    rest = [[(h * s * r) ** 3 / 3.0, (h * s * r) ** 2 * (r - s) / 2.0],
            [(h * s * r) ** 2 * (r - s) / 2.0, h * s * r * (1.0 - 3.0 * s * r)]]  # fmt: skip
    mean[0] += motion[0, left]
    return mean, np.einsum("ikn,kln,jln->ijn", weights, joint, weights) + q * np.array(rest)


@pytest.mark.parametrize("run", [run_plainly, run_on_columns, compiled])
def test_the_bridge_is_that_of_the_joint_covariance_of_both_neighbours(long_record, run):
    """Written out in scalars it is the product of matrices to 1e-12, however it is run."""
    times, _, angles, variances = long_record
    record = smooth_edges(times, angles, variances, 20.0, PRIOR)
    asked = np.random.default_rng(3).uniform(times[0], times[-1], 2000)
    mean, P = bridged_by_matrices(asked, record)
    motion = smoothed_at(asked, record, run)
    np.testing.assert_allclose(np.array(motion[:2]), mean, rtol=1e-12)
    np.testing.assert_allclose(motion.angle_variance, P[0, 0], rtol=1e-12)
    np.testing.assert_allclose(motion.speed_variance, P[1, 1], rtol=1e-12)
    assert np.all(abs(motion.covariance - P[0, 1]) < 1e-12 * np.sqrt(P[0, 0] * P[1, 1]))


def test_the_bridge_meets_both_ends(short_record):
    times, _, angles, variances = short_record
    record = smooth_edges(times, angles, variances, 200.0, PRIOR)
    np.testing.assert_allclose(np.array(smoothed_at(times, record)), np.array(record.beliefs), rtol=1e-12)
    # A variance changes by 2 |P12| e and the like over e = 1e-12 s: 1e-9 of it is far more.
    just_before = np.array(smoothed_at(times[1:] - 1e-12, record))
    np.testing.assert_allclose(just_before, np.array(record.beliefs)[:, 1:], rtol=1e-6, atol=1e-8)


def test_speed_is_the_slope_of_the_angle(short_record):
    """And the covariance is half the slope of the angle's variance, as speed is the rate of angle."""
    times, _, angles, variances = short_record
    record = smooth_edges(times, angles, variances, 200.0, PRIOR)
    middle = 0.3 * times[:-1] + 0.7 * times[1:]
    e = 1e-6
    ahead, behind, here = (smoothed_at(middle + d, record) for d in (e, -e, 0.0))
    # Central differences of smooth functions over 1e-6 of 1e-3 s: relative error about 1e-6, rounding 1e-16/1e-6.
    np.testing.assert_allclose((ahead.angle - behind.angle) / (2 * e), here.speed, rtol=1e-6)
    slope = (ahead.angle_variance - behind.angle_variance) / (2 * e)
    np.testing.assert_allclose(slope, 2 * here.covariance, atol=1e-5 * abs(here.covariance).max())


def test_time_reversed_record_gives_the_mirrored_motion():
    """With next to no prior nothing tells forward from backward: angle and variances stay, speed changes its sign.

    The prior holds at the first edge in one case and at the last in the other. It is worth one part in 1e9 per unit of
    variance, and the smoothed variances are below 20; rounding beside 1e9 leaves as much again.
    """
    times, _, angles, variances = drawn_record(np.random.default_rng(2), 40, 20.0, PRIOR)
    forward = smooth_edges(times, angles, variances, 20.0, DIFFUSE)
    backward = smooth_edges(-times[::-1], angles[::-1], variances[::-1], 20.0, DIFFUSE)
    asked = np.linspace(times[0] - 0.02, times[-1] + 0.02, 301)
    one, other = smoothed_at(asked, forward), smoothed_at(-asked, backward)
    assert one.speed_variance.max() < 20.0
    np.testing.assert_allclose(other.angle, one.angle, rtol=1e-7)
    np.testing.assert_allclose(-other.speed, one.speed, rtol=1e-7)
    np.testing.assert_allclose(other.angle_variance, one.angle_variance, rtol=1e-7)
    np.testing.assert_allclose(other.speed_variance, one.speed_variance, rtol=1e-7)
    np.testing.assert_allclose(-other.covariance, one.covariance, atol=1e-7 * abs(one.covariance).max())


@settings(max_examples=40)
@given(
    st.integers(1, 60),
    st.floats(-3.0, 5.0),
    st.floats(-4.5, 0.5),
    st.integers(0, 10**6),
)
def test_more_edges_never_make_it_less_certain(n, decades, interval_decades, seed):
    """Smoothed variances are at most the filtered ones, whatever the record; both are proper covariances."""
    rng, q = np.random.default_rng(seed), 10.0**decades
    times = np.cumsum(rng.uniform(0.1, 2.0, n)) * 10.0**interval_decades
    variances = 10.0 ** rng.uniform(-5.0, -1.0, n)
    angles = 150.0 * times + rng.standard_normal(n)
    forward = filter_edges(times, angles, variances, q, PRIOR)
    record = smooth_edges(times, angles, variances, q, PRIOR)
    assert np.all(record.beliefs.angle_variance <= forward.angle_variance * (1 + 1e-9))
    assert np.all(record.beliefs.speed_variance <= forward.speed_variance * (1 + 1e-9))
    between = smoothed_at(rng.uniform(times[0] - 0.1, times[-1] + 0.1, 50), record)
    for motion in (record.beliefs, between):
        assert np.all(motion.angle_variance > 0.0)
        assert np.all(motion.covariance**2 <= motion.angle_variance * motion.speed_variance * (1 + 1e-9))


def test_agrees_with_filterpy():
    """filterpy 1.4.5, `KalmanFilter` and `rts_smoother`, an independent implementation."""
    kalman = pytest.importorskip("filterpy.kalman")
    times, _, angles, variances = drawn_record(np.random.default_rng(11), 200, Q, PRIOR)
    kf = kalman.KalmanFilter(dim_x=2, dim_z=1)
    kf.x = np.array([[PRIOR.angle], [PRIOR.speed]])
    kf.P = np.array([[PRIOR.angle_variance, PRIOR.covariance], [PRIOR.covariance, PRIOR.speed_variance]])
    kf.H = np.array([[1.0, 0.0]])
    steps = np.diff(times, prepend=times[0])
    Fs, Qs = [transition(h) for h in steps], [noise(h, Q) for h in steps]
    means, covariances, _, _ = kf.batch_filter(angles[:, None], Fs=Fs, Qs=Qs, Rs=list(variances))
    forward = filter_edges(times, angles, variances, Q, PRIOR)
    np.testing.assert_allclose(forward.speed, means[:, 1, 0], rtol=1e-9)
    np.testing.assert_allclose(forward.speed_variance, covariances[:, 1, 1], rtol=1e-9)
    means, covariances, _, _ = kf.rts_smoother(means, covariances, Fs=Fs, Qs=Qs)
    record = smooth_edges(times, angles, variances, Q, PRIOR)
    np.testing.assert_allclose(record.beliefs.angle, means[:, 0, 0], rtol=1e-9)
    np.testing.assert_allclose(record.beliefs.speed, means[:, 1, 0], rtol=1e-9)
    np.testing.assert_allclose(record.beliefs.angle_variance, covariances[:, 0, 0], rtol=1e-8)
    np.testing.assert_allclose(record.beliefs.covariance, covariances[:, 0, 1], rtol=1e-7)
    np.testing.assert_allclose(record.beliefs.speed_variance, covariances[:, 1, 1], rtol=1e-8)


def test_errors_are_as_large_as_they_are_said_to_be():
    """Normalised squared error of the state, over 300 records drawn from the model, at an edge and between two.

    Records are independent, so the sum over n records is chi-squared with 2 n degrees of freedom; the band is the
    central 99.9 % of that.
    """
    n, q = 300, 50.0
    at_edge, between = 0.0, 0.0
    for seed in range(n):
        rng = np.random.default_rng(1000 + seed)
        times, states, angles, variances = drawn_record(rng, 25, q, PRIOR)
        # The truth between edges 12 and 13 by hiding an edge: one state more in the record, which is not measured.
        keep = np.arange(25) != 13
        record = smooth_edges(times[keep], angles[keep], variances[keep], q, PRIOR)
        asked = smoothed_at(times[[10, 13]], record)
        for i, truth in enumerate(states[[10, 13]]):
            error = truth - np.array([asked.angle[i], asked.speed[i]])
            P = np.array(
                [[asked.angle_variance[i], asked.covariance[i]], [asked.covariance[i], asked.speed_variance[i]]]
            )
            nees = error @ np.linalg.solve(P, error)
            at_edge, between = (at_edge + nees, between) if i == 0 else (at_edge, between + nees)
    low, high = stats.chi2.ppf([0.0005, 0.9995], 2 * n)
    assert low < at_edge < high
    assert low < between < high


def test_constant_speed_limit_is_the_straight_line_fit():
    """As q goes to nothing and the prior tells nothing, the weighted least-squares line through the edges remains."""
    times, _, angles, variances = drawn_record(np.random.default_rng(4), 30, 1e-12, PRIOR)
    record = smooth_edges(times, angles, variances, 1e-12, AngleSpeed(0.0, 0.0, 1e6, 0.0, 1e8))
    slope, at_zero = np.polyfit(times - times[0], angles, 1, w=1 / np.sqrt(variances))
    assert record.beliefs.speed[7] == pytest.approx(slope, rel=1e-6)
    assert record.beliefs.angle[7] == pytest.approx(at_zero + slope * (times[7] - times[0]), rel=1e-6)
    w, x = 1 / variances, times - times[0]
    spread = w.sum() * (w * x * x).sum() - (w * x).sum() ** 2
    assert record.beliefs.speed_variance[7] == pytest.approx(w.sum() / spread, rel=1e-5)


def test_compiled_passes_are_the_plain_ones():
    times, _, angles, variances = drawn_record(np.random.default_rng(9), 300, Q, PRIOR)
    plain = smooth_edges(times, angles, variances, Q, PRIOR)
    fast = smooth_edges(times, angles, variances, Q, PRIOR, compiled)
    np.testing.assert_allclose(np.array(fast.beliefs), np.array(plain.beliefs), rtol=1e-12)
    np.testing.assert_allclose(fast.lagged, plain.lagged, rtol=1e-12)


def test_steps_can_be_taken_one_by_one():
    walk = SpeedWalk(acceleration_density=Q)
    memory, belief = filtered_step(Reached(0.0, PRIOR), EdgePassed(0.1, 15.0, 1e-2), walk)
    memory, later = filtered_step(memory, EdgePassed(0.105, 15.8, 1e-2), walk)
    _, drawn = smoothed_step(memory, Forward(0.1, *belief), walk)
    record = smooth_edges([0.1, 0.105], [15.0, 15.8], [1e-2, 1e-2], Q, filtered_prior(0.1))
    assert drawn.speed == pytest.approx(record.beliefs.speed[0], rel=1e-12)
    assert later.speed == pytest.approx(record.beliefs.speed[1], rel=1e-12)


def filtered_prior(h):
    """PRIOR carried on for h seconds with matrices."""
    P = np.array([[PRIOR.angle_variance, PRIOR.covariance], [PRIOR.covariance, PRIOR.speed_variance]])
    P = transition(h) @ P @ transition(h).T + noise(h, Q)
    return AngleSpeed(PRIOR.angle + h * PRIOR.speed, PRIOR.speed, P[0, 0], P[0, 1], P[1, 1])


@pytest.fixture(scope="module")
def long_record():
    return drawn_record(np.random.default_rng(21), 1500, 20.0, PRIOR)


@pytest.mark.parametrize("size", [25, 40, 333, 5000])
def test_overlapping_portions_give_the_whole(long_record, size):
    """Pieces differ from the whole by less than the promised share of a deviation, and meet at their ends.

    The variance of an edge is uniform in 2 to 8e-3 rad^2; `smoothing_overlap` holds for the steady filter, so its
    largest variance and interval (9e-3 s) stand for the rest.
    """
    times, _, angles, variances = long_record
    share = 1e-3
    overlap = smoothing_overlap(20.0, 8e-3, 9e-3, share)
    cuts = range(0, 1500, size)
    portions = ((times[i : i + size], angles[i : i + size], variances[i : i + size]) for i in cuts)
    pieces = list(smoothed_portions(portions, 20.0, PRIOR, overlap))
    for before, after in pairwise(pieces):
        assert before.times[-1] == after.times[0]
        assert before.times.size > 1
    whole = smooth_edges(times, angles, variances, 20.0, PRIOR)
    joined = np.concatenate([p.times[:-1] for p in pieces[:-1]] + [pieces[-1].times])
    assert np.array_equal(joined, times)
    for piece in pieces:
        here = np.searchsorted(times, piece.times)
        deviation = np.sqrt(whole.beliefs.speed_variance[here])
        assert np.all(abs(piece.beliefs.speed - whole.beliefs.speed[here]) < 3 * share * deviation)
        deviation = np.sqrt(whole.beliefs.angle_variance[here])
        assert np.all(abs(piece.beliefs.angle - whole.beliefs.angle[here]) < 3 * share * deviation)


def test_overlap_is_the_decay_of_the_filter():
    """q = 0.25, R = 5.53e-3 at 200 edges a second: omega_n = (0.25/(5.53e-3 0.005))^(1/4) = 9042^(1/4) = 9.751 rad/s.

    To a thousandth: 1.4142 6.9078/9.751 = 1.0018 s.
    """
    assert smoothing_overlap(0.25, 5.53e-3, 0.005, 1e-3) == pytest.approx(1.0018, rel=1e-4)


def test_influence_of_an_edge_dies_out_as_the_overlap_says():
    """Move one edge by 1 rad and look at what that does to the states before: an oscillation within e^(-t/tau).

    tau = sqrt(2)/omega_n. Means are linear in the edges, so the difference of two runs is the influence itself. Its
    envelope is fitted over 3 to 13 tau; sampling at 0.05/omega_n makes the continuous rate good to 2 %.
    """
    n, interval, R, q = 600, 5e-3, 5.53e-3, 0.25
    times = interval * np.arange(n)
    moved = np.zeros(n)
    moved[-1] = 1.0
    felt = abs(smooth_edges(times, moved, np.full(n, R), q, DIFFUSE).beliefs.speed)
    tau = smoothing_overlap(q, R, interval, np.exp(-1.0))
    half_wave = np.pi * tau
    blocks = [
        felt[(times[-1] - times >= a) & (times[-1] - times < a + half_wave)].max() for a in half_wave * np.arange(1, 5)
    ]
    rates = -np.diff(np.log(blocks)) / half_wave
    np.testing.assert_allclose(rates, 1.0 / tau, rtol=0.02)


def test_four_times_as_certain_as_the_filter_in_the_long_run():
    """Dense edges far from both ends: R T omega_n/(2 sqrt 2) and R T omega_n^3/(2 sqrt 2), the filter four times that.

    The closed forms are those of continuous measurement; edges 0.02/omega_n apart stand for that. The filter's
    variances jump by omega_n T sqrt(2) = 2.8 % at every edge, so those after an edge are compared to within 3 %.
    """
    R, interval = 5.53e-3, 1e-3
    bandwidth = 0.02 / interval
    q = bandwidth**4 * R * interval
    n = 3000
    times = interval * np.arange(n)
    record = smooth_edges(times, np.zeros(n), np.full(n, R), q, DIFFUSE)
    forward = filter_edges(times, np.zeros(n), np.full(n, R), q, DIFFUSE)
    steady = R * interval * bandwidth / (2.0 * np.sqrt(2.0))
    assert record.beliefs.angle_variance[n // 2] == pytest.approx(steady, rel=1e-3)
    assert record.beliefs.speed_variance[n // 2] == pytest.approx(steady * bandwidth**2, rel=1e-3)
    assert record.beliefs.covariance[n // 2] == pytest.approx(0.0, abs=1e-9 * steady)
    assert forward.angle_variance[-1] == pytest.approx(4.0 * steady, rel=0.03)
    assert forward.speed_variance[-1] == pytest.approx(4.0 * steady * bandwidth**2, rel=0.03)


def test_a_single_edge():
    record = smooth_edges([2.0], [10.0], [1e-2], Q, PRIOR)
    assert record.lagged.shape == (0, 2, 2)
    here = smoothed_at([1.9, 2.0, 2.1], record)
    assert here.angle[1] == record.beliefs.angle[0]
    assert here.speed_variance[0] == pytest.approx(here.speed_variance[2])
    assert here.speed_variance[0] == pytest.approx(record.beliefs.speed_variance[0] + 0.1 * Q)


@pytest.mark.parametrize(
    ("times", "angles", "variances", "words"),
    [
        ([0.0, 1.0], [0.0], [1.0, 1.0], "shapes"),
        ([], [], [], "at least 1"),
        ([0.0, 1.0, 1.0], [0.0, 1.0, 2.0], [1.0, 1.0, 1.0], "edge 2 at 1 s"),
        ([0.0, 1.0], [0.0, np.nan], [1.0, 1.0], "not finite"),
        ([0.0, 1.0], [0.0, 1.0], [1.0, 0.0], "0 rad"),
    ],
)
def test_records_that_make_no_sense_are_refused(times, angles, variances, words):
    with pytest.raises(ParameterError, match=words):
        smooth_edges(times, angles, variances, Q, PRIOR)


def test_portions_out_of_order_are_refused():
    portions = [([0.0, 1.0], [0.0, 1.0], [1.0, 1.0]), ([0.5], [2.0], [1.0])]
    with pytest.raises(ParameterError, match="follows"):
        list(smoothed_portions(portions, Q, PRIOR, 0.0))


def test_a_speed_that_cannot_change_is_refused():
    with pytest.raises(ParameterError, match="must be greater than 0"):
        smooth_edges([0.0], [0.0], [1.0], 0.0, PRIOR)
    with pytest.raises(ParameterError, match="share"):
        smoothing_overlap(Q, 1e-3, 5e-3, 1.0)
