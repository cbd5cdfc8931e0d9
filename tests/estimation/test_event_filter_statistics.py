"""What the event filter achieves, over many seeds: against the published figures and against theory.

The tables of the published case and of the step are in test_event_filter_tables.py.
"""

from dataclasses import replace

import numpy as np
import pytest

from vvdp.estimation.event_settings import event_filter
from vvdp.sensing.wheel import equal_wheel

WHEEL = equal_wheel(8)
SECTOR = np.pi / 4.0
PUBLISHED = event_filter(WHEEL)
CONSTANT_SPEED = replace(PUBLISHED, manoeuvre_gate=1e6, stop_rate=0.0)
FLAT = replace(CONSTANT_SPEED, edge_variance=5.53e-3)
"""With rows whose interval is set to 0, R = 5.53e-3 rad^2 whatever the speed."""
RUNS = 200


def noisy_rows(edge_times, seed, frequency, clock, threshold, duration=1.0):
    """Rows of a steady wheel that starts at a random angle of its first sector, and that angle.

    `clock`      a fixed clock of random phase; otherwise the delays are independent
    `threshold`  triangular error of the edges within half of 1.5 ms
    """
    rng = np.random.default_rng(seed)
    speed = 2.0 * np.pi * frequency
    start = SECTOR * rng.random()
    numbers, angles = edge_times.angles(WHEEL.edges, 1, int(duration * 8.0 * frequency) + 16)
    if threshold:
        angles = angles + edge_times.triangular(rng, angles.size, 0.5 * speed * 1.5e-3)
    times, polarity = (angles - start) / speed, 1.0 - 2.0 * (numbers % 2.0)
    if clock:
        return edge_times.clocked(times, polarity, rng.random(), duration), start
    return edge_times.scattered(times, polarity, rng, duration), start


def errors_of(edge_times, filtered, seed, frequency, clock, threshold, settings=FLAT, flat=True, duration=1.0):
    """Times, and the errors of angle and speed."""
    rows, start = noisy_rows(edge_times, seed, frequency, clock, threshold, duration)
    if flat:
        rows[:, 3] = 0.0
    shown, _ = filtered(settings, rows, speed=50.0)
    speed = 2.0 * np.pi * frequency
    return rows[:, 0], shown[:, 0] - start - speed * rows[:, 0], shown[:, 1] - speed


def test_exact_commensurability_biases_the_angle(edge_times, filtered):
    """25.000 Hz on a 1 kHz clock: every edge lies at the same part of its sample, so that the angle's error stays and
    is even within +-0.0785 rad over the runs: deviation 0.0453.
    """
    ends = []
    for seed in range(RUNS):
        _, angle_error, speed_error = errors_of(edge_times, filtered, seed, 25.0, True, False)
        ends.append(angle_error[-1])
        assert abs(speed_error[-1]) < 1e-3
    assert np.max(np.abs(ends)) < 0.0786
    assert np.std(ends) == pytest.approx(np.pi / 40.0 / np.sqrt(3.0), rel=4.0 * np.sqrt(0.2 / RUNS))  # kurtosis 1.8


@pytest.mark.parametrize("frequency", [10.9, 20.3, 24.7, 33.1, 40.0])
@pytest.mark.parametrize("clock", [True, False])
def test_speeds_and_clock_phases(edge_times, filtered, frequency, clock):
    """At every speed the right sector, and errors at 1 s of the size that the filter says.

    With R_2 kept in the filter though the edges have no threshold error, it may only be too careful.
    """
    scaled = []
    for seed in range(RUNS):
        rows, start = noisy_rows(edge_times, seed, frequency, clock, False)
        shown, memory = filtered(PUBLISHED, rows, speed=50.0)
        error = shown[-1, :2] - [start + 2.0 * np.pi * frequency * rows[-1, 0], 2.0 * np.pi * frequency]
        assert abs(error[0]) < 0.1
        assert memory.tally.missed_edges == 0.0
        scaled.append(error / shown[-1, 2:4])
    commensurate = clock and frequency == 40.0
    assert np.all(np.mean(np.square(scaled), axis=0) < (30.0 if commensurate else 2.0))


@pytest.mark.parametrize(
    ("frequency", "clock", "threshold", "angle_rms", "speed_rms"),
    [(24.7, True, False, 0.0072, 0.049), (25.0, False, True, 0.0143, 0.079)],
)
def test_rms_of_the_published_comparison(edge_times, filtered, frequency, clock, threshold, angle_rms, speed_rms):
    """RMS after 0.5 s. The errors forget in about 1/9.75 s, so that 200 runs of 0.5 s count as about 1000 numbers and
    an RMS is known to 2.2 %; the published ones come from fewer runs: 10 %.
    """
    squares = []
    for seed in range(RUNS):
        time, angle_error, speed_error = errors_of(edge_times, filtered, seed, frequency, clock, threshold)
        late = time > 0.5
        squares.append((np.mean(angle_error[late] ** 2), np.mean(speed_error[late] ** 2)))
    print(np.sqrt(np.mean(squares, axis=0)))
    np.testing.assert_allclose(np.sqrt(np.mean(squares, axis=0)), [angle_rms, speed_rms], rtol=0.1)


def walking(edge_times, seed):
    """When the edges of a shaft pass whose speed walks with q = 0.25 rad^2/s^3 from about 157 rad/s, each with a normal
    error of variance R_2; their polarity; and angle and speed at the times of a fine grid.
    """
    h, q, rng = 1e-4, 0.25, np.random.default_rng(seed)
    mix = np.linalg.cholesky(q * np.array([[h**3 / 3.0, h**2 / 2.0], [h**2 / 2.0, h]]))
    kick = rng.normal(size=(10000, 2)) @ mix.T
    speed = 157.0 + rng.normal() + np.concatenate([[0.0], np.cumsum(kick[:, 1])])
    angle = 0.1 * rng.normal() + 0.2 + np.concatenate([[0.0], np.cumsum(h * speed[:-1] + kick[:, 0])])
    numbers, angles = edge_times.angles(WHEEL.edges, 1, 190)
    angles = angles + np.sqrt(3.47e-3) * rng.normal(size=angles.size)
    grid = h * np.arange(10001)
    inside = angles < angle[-1]
    passed = np.interp(angles[inside], angle, grid)
    return rng, passed, 1.0 - 2.0 * (numbers[inside] % 2.0), grid, angle, speed


WALKING = replace(CONSTANT_SPEED, angle_variance=0.01, speed_variance=1.0)
"""The start of those walks."""


def test_innovations_of_the_right_model_are_normalised(edge_times, filtered):
    """NIS: the mean of innovation^2 / S is 1 if the noise is what the filter takes it for.

    Edges are seen with an even delay. An even part R_1 has the fourth moment 1.8 R_1^2, so the variance of a
    normalised square is 2 - 1.2 (R_1/S)^2 = 1.85; innovations are uncorrelated. Four deviations of the mean.
    """
    squares = []
    for seed in range(RUNS):
        rng, passed, polarity, *_ = walking(edge_times, seed)
        shown, _ = filtered(WALKING, edge_times.scattered(passed, polarity, rng, 0.99), angle=0.2, speed=157.0)
        used = shown[:, 5] > 0.0
        squares.append(np.square(shown[used, 4] / shown[used, 5]))
    nis = np.concatenate(squares)
    assert nis.size > 35000
    assert abs(np.mean(nis) - 1.0) < 4.0 * np.sqrt(1.85 / nis.size)
    assert np.var(nis) == pytest.approx(1.85, rel=0.05)


def test_stamped_edges_pass_the_chi_square_test(edge_times, filtered):
    """With stamped edges all is normal: the sum of n normalised squares of a run is chi-square with n degrees, so its
    probability is even from 0 to 1 over the runs (Kolmogorov and Smirnov's test, 1 in 1000 by chance); neighbouring
    innovations are uncorrelated (four deviations); and so is the error at the end, with 2 degrees.
    """
    from scipy.stats import chi2, kstest

    sums, ends, products, count = [], [], 0.0, 0
    for seed in range(RUNS):
        _, passed, polarity, grid, angle, speed = walking(edge_times, seed)
        none = np.zeros_like(passed)
        rows = np.column_stack([passed, none + 1.0, passed, none, polarity])
        rows = rows[np.argsort(passed, kind="stable")]
        shown, memory = filtered(WALKING, rows, angle=0.2, speed=157.0)
        z = shown[:, 4] / shown[:, 5]
        sums.append(chi2.cdf(np.sum(z * z), z.size))
        products, count = products + np.sum(z[1:] * z[:-1]), count + z.size - 1
        b = memory.belief
        off = [b.angle - np.interp(memory.time, grid, angle), b.speed - np.interp(memory.time, grid, speed)]
        P = np.array([[b.angle_variance, b.covariance], [b.covariance, b.speed_variance]])
        ends.append(chi2.cdf(off @ np.linalg.solve(P, off), 2))
    assert kstest(sums, "uniform").pvalue > 1e-3
    assert kstest(ends, "uniform").pvalue > 1e-3
    assert abs(products / count) < 4.0 / np.sqrt(count)


@pytest.mark.parametrize(("variance", "expected"), [(5.53e-3, 0.776), (4.37e-3, 0.982)])
def test_innovations_show_the_printed_noise_too_large(edge_times, filtered, variance, expected):
    """n1 + triangular n2, together 4.369e-3 rad^2, seen by a filter with R and q = 0.25 while the speed stands.

    In the steady state the gain K is fixed, the error e- before an edge follows e- <- F (I - K H') e- - F K n, and the
    normalised square is (4.369e-3 + var e-)/(P11- + R): 0.776, and 0.982 with R put right (0.74 and 0.93 without the
    error of the estimate). Deviation of the mean over 200 runs of 100 edges: 0.009.
    """
    from scipy.linalg import solve_discrete_are, solve_discrete_lyapunov

    h, q, noise = 5e-3, 0.25, (0.157080**2) / 12.0 + 0.117810**2 / 6.0
    assert noise == pytest.approx(4.369e-3, abs=1e-6)
    F, H = np.array([[1.0, h], [0.0, 1.0]]), np.array([[1.0], [0.0]])
    P = solve_discrete_are(F.T, H, q * np.array([[h**3 / 3.0, h**2 / 2.0], [h**2 / 2.0, h]]), np.array([[variance]]))
    S = P[0, 0] + variance
    K = P @ H / S
    error = solve_discrete_lyapunov(F @ (np.eye(2) - K @ H.T), noise * F @ K @ K.T @ F.T)
    assert (noise + error[0, 0]) / S == pytest.approx(expected, abs=1e-3)

    settings = replace(FLAT, edge_variance=variance)
    squares = []
    for seed in range(RUNS):
        rows, _ = noisy_rows(edge_times, seed, 25.0, False, True)
        rows[:, 3] = 0.0
        shown, _ = filtered(settings, rows, speed=50.0)
        used = (shown[:, 5] > 0.0) & (rows[:, 0] > 0.5)
        squares.append(np.mean(np.square(shown[used, 4] / shown[used, 5])))
    assert np.mean(squares) == pytest.approx(expected, abs=4.0 * 0.009)


def test_false_alarms_are_rare(edge_times, filtered):
    """Ten minutes at a steady speed, 118 000 edges. For normal innovations the mean distance of two alarms is
    exp(2 (6 + 1.166))/4 = 4e5 edges, and the even part of the noise makes it longer: at most two, and the RMS keeps.
    """
    rng = np.random.default_rng(8)
    speed = 2.0 * np.pi * 24.7
    numbers, angles = edge_times.angles(WHEEL.edges, 1, int(600.0 * 8.0 * 24.7) + 16)
    times = (angles + np.sqrt(3.47e-3) * rng.normal(size=angles.size)) / speed
    rows = edge_times.clocked(times, 1.0 - 2.0 * (numbers % 2.0), 0.3, 600.0)
    rms, alarms = [], []
    for settings in (PUBLISHED, replace(PUBLISHED, stop_rate=0.0), CONSTANT_SPEED):
        shown, _ = filtered(settings, rows, speed=150.0)
        late = rows[:, 0] > 2.0
        rms.append(np.sqrt(np.mean(np.square(shown[late, 1] - speed))))
        alarms.append(np.sum(np.diff(shown[late, 3] > 3.0) > 0))
    assert max(alarms[1:]) <= 4  # a filter that hears the silence suspects more than it declares
    assert max(rms[:2]) < 1.06 * rms[2]
