"""What the event filter achieves, over many seeds: against the published figures and against theory.

A share of 200 runs has the deviation sqrt(p (1 - p)/200) <= 0.035, the difference of two such studies 0.05. The
published figures are held to 0.08.
"""

from dataclasses import replace

import numpy as np
import pytest

from vvdp.estimation.event_filter import event_filter
from vvdp.sensing.wheel import equal_wheel

WHEEL = equal_wheel(8)
SECTOR = np.pi / 4.0
PUBLISHED = event_filter(WHEEL)
CONSTANT_SPEED = replace(PUBLISHED, manoeuvre_gate=1e6)
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


@pytest.mark.parametrize(
    ("frequency", "clock", "threshold", "angle_share", "speed_share", "always_share"),
    [
        (25.0, False, False, 0.99, 0.55, 0.32),
        (25.0, False, True, 0.95, 0.46, 0.12),
        (25.0, True, False, 0.75, 1.00, 1.00),
        (24.7, True, False, 1.00, 0.38, 0.07),
    ],
)
def test_published_case(edge_times, filtered, frequency, clock, threshold, angle_share, speed_share, always_share):
    """Section 3.5 of wang2017: 0.06 rad and 0.3 rad/s at 0.1 s. The angle is reached, the speed only by a clock that
    ticks five times in every sector, whose angle is off by up to half a tick for good.
    """
    found = []
    for seed in range(RUNS):
        time, angle_error, speed_error = errors_of(edge_times, filtered, seed, frequency, clock, threshold)
        at = np.searchsorted(time, 0.1, side="right") - 1
        after = np.abs(speed_error[at:])
        found.append((abs(angle_error[at]) < 0.06, after[0] < 0.3, np.max(after) < 0.3))
    np.testing.assert_allclose(np.mean(found, axis=0), [angle_share, speed_share, always_share], atol=0.1)
    np.testing.assert_allclose(np.mean(found, axis=0)[:2], [angle_share, speed_share], atol=0.08)


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
    for seed in range(40):
        rows, start = noisy_rows(edge_times, seed, frequency, clock, False)
        shown, memory = filtered(PUBLISHED, rows, speed=50.0)
        error = shown[-1, :2] - [start + 2.0 * np.pi * frequency * rows[-1, 0], 2.0 * np.pi * frequency]
        assert abs(error[0]) < 0.1
        assert memory.missed_edges == 0.0
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
    np.testing.assert_allclose(np.sqrt(np.mean(squares, axis=0)), [angle_rms, speed_rms], rtol=0.1)


def test_innovations_of_the_right_model_are_normalised(edge_times, filtered):
    """NIS: the mean of innovation^2 / S is 1 if the noise is what the filter takes it for.

    The speed walks with q = 0.25 rad^2/s^3 from where the filter's start says, edges pass with a normal error of
    variance R_2 and are seen with an even delay. An even part R_1 has the fourth moment 1.8 R_1^2, so the variance of a
    normalised square is 2 - 1.2 (R_1/S)^2 = 1.85; innovations are uncorrelated. Four deviations of the mean.
    """
    settings = replace(CONSTANT_SPEED, angle_variance=0.01, speed_variance=1.0)
    squares = []
    h, q = 1e-4, 0.25
    mix = np.linalg.cholesky(q * np.array([[h**3 / 3.0, h**2 / 2.0], [h**2 / 2.0, h]]))
    for seed in range(RUNS):
        rng = np.random.default_rng(seed)
        kick = rng.normal(size=(10000, 2)) @ mix.T
        speed = 157.0 + rng.normal() + np.concatenate([[0.0], np.cumsum(kick[:, 1])])
        angle = 0.1 * rng.normal() + 0.2 + np.concatenate([[0.0], np.cumsum(h * speed[:-1] + kick[:, 0])])
        numbers, angles = edge_times.angles(WHEEL.edges, 1, 190)
        angles = angles + np.sqrt(3.47e-3) * rng.normal(size=angles.size)
        passed = np.interp(angles, angle, h * np.arange(10001))
        inside = angles < angle[-1]
        rows = edge_times.scattered(passed[inside], 1.0 - 2.0 * (numbers[inside] % 2.0), rng, 0.99)
        shown, _ = filtered(settings, rows, angle=0.2, speed=157.0)
        used = shown[:, 5] > 0.0
        squares.append(np.square(shown[used, 4] / shown[used, 5]))
    nis = np.concatenate(squares)
    assert nis.size > 35000
    assert abs(np.mean(nis) - 1.0) < 4.0 * np.sqrt(1.85 / nis.size)
    assert np.var(nis) == pytest.approx(1.85, rel=0.05)


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


LAG, SLOW, FAST, END = 28.2e-3, 68.7, 150.8, 4.0


def stepped_rows(edge_times, seed, before=SLOW, after=FAST, normal=True, missed=0.0):
    """Rows, true angle and speed, and the time of a step of the pump: the speed follows with the lag of the spool.

    1 kHz clock of any phase, wheel at any angle, edges with the error R_2 = 3.47e-3 rad^2.
    """
    rng = np.random.default_rng(seed)
    start, at = SECTOR * rng.random(), 1.0 + 0.1 * rng.random()

    def angle(time):
        s = np.where(time > at, time - at, 0.0)
        return start + before * time + (after - before) * (s + LAG * np.expm1(-s / LAG))

    numbers, angles = edge_times.angles(WHEEL.edges, 1, int(END * max(before, after) / SECTOR) + 16)
    error = np.sqrt(3.47e-3) * (
        rng.normal(size=angles.size) if normal else edge_times.triangular(rng, angles.size, np.sqrt(6.0))
    )
    times = edge_times.passed(angle, angles + error, 2.0 * END)
    kept = (rng.random(times.size) >= missed) | (np.arange(times.size) < 20)
    rows = edge_times.clocked(times[kept], 1.0 - 2.0 * (numbers[kept] % 2.0), rng.random(), END)
    speed = np.where(rows[:, 0] < at, before, after + (before - after) * np.exp((at - rows[:, 0]) / LAG))
    return rows, angle(rows[:, 0]), speed, at


def step_figures(edge_times, filtered, settings, seed, share=0.05, source=False, **truth):
    """Settling time, RMS of the speed from 1 s after the step, greatest and last error of the angle."""
    rows, angle, speed, at = stepped_rows(edge_times, seed, **truth)
    if source:
        rows[:, 3] = np.sqrt(12.0 * 5.53e-3) / 157.08
    shown, _ = filtered(settings, rows, speed=speed[0])
    since = rows[:, 0] - at
    outside = np.abs(shown[:, 1] - speed[-1]) > share * abs(speed[-1] - speed[0])
    settled = since[np.flatnonzero(outside)[-1] + 1] if not outside[-1] else np.inf
    late = since > 1.0
    off = shown[:, 0] - angle
    return (
        settled,
        np.sqrt(np.mean(np.square(shown[late, 1] - speed[late]))),
        np.max(np.abs(off[since > -0.1])),
        abs(off[-1]),
    )


@pytest.mark.parametrize("normal", [True, False])
def test_step_of_the_pump(edge_times, filtered, normal):
    """26.7 to 40 lpm: within 5 % of the step for good before 0.16 s in 90 % of 200 runs, where the spool itself takes
    0.084 s; no sector lost; and afterwards as steady as the filter for a constant speed, which it has become again.

    Two RMS from 200 runs of 2 s, each about 4000 independent numbers, differ by up to 4 sqrt(2/8000) = 6 %.
    """
    found = np.array([step_figures(edge_times, filtered, PUBLISHED, seed, normal=normal) for seed in range(RUNS)])
    assert np.quantile(found[:, 0], 0.9) < 0.16
    assert np.median(found[:, 0]) < 0.13
    assert np.all(found[:, 3] < 0.2)
    assert np.quantile(found[:, 2], 0.9) < SECTOR
    steady = [
        step_figures(edge_times, filtered, CONSTANT_SPEED, seed, before=FAST, normal=normal)[1] for seed in range(RUNS)
    ]
    assert np.sqrt(np.mean(found[:, 1] ** 2)) < 1.06 * np.sqrt(np.mean(np.square(steady)))


@pytest.mark.parametrize(("before", "after"), [(FAST, SLOW), (40.0, 200.0), (FAST, 120.0)])
def test_other_steps_lose_no_sector(edge_times, filtered, before, after):
    """Down is harder: an edge that is late looks like one that comes after two missed ones. 1 % of runs may slip."""
    found = np.array(
        [step_figures(edge_times, filtered, PUBLISHED, seed, before=before, after=after) for seed in range(RUNS)]
    )
    assert np.quantile(found[:, 0], 0.9) < 0.22
    assert np.mean(found[:, 3] < 0.25) >= 0.98


def test_step_with_missed_edges(edge_times, filtered):
    """A fifth of the edges missed as well: the speed is as quick; 20 % of runs may be two sectors off."""
    found = np.array([step_figures(edge_times, filtered, PUBLISHED, seed, missed=0.2) for seed in range(100)])
    assert np.quantile(found[:, 0], 0.9) < 0.16
    assert np.mean(found[:, 3] < 0.25) > 0.8


def test_gate_that_is_shut_makes_a_constant_speed_filter(edge_times, filtered):
    """It loses count in the step, as q = 0.25 has a bandwidth of 9.75 rad/s."""
    found = step_figures(edge_times, filtered, CONSTANT_SPEED, 3)
    assert found[0] > 0.3
    assert found[2] > SECTOR


@pytest.mark.parametrize(
    ("density", "source", "settling", "angle_error"),
    [
        (0.25, True, 0.457, 3.09),
        (25.0, True, 0.128, 0.84),
        (0.25, False, 0.331, 3.46),
        (25.0, False, 0.137, 1.00),
    ],
)
def test_step_with_one_density_throughout(edge_times, filtered, density, source, settling, angle_error):
    """The same step, edges counted and q fixed; the noise after the source's rule, everything with omega^2, or with
    the sampling's part alone. Figures of an independent implementation, 60 runs each.
    """
    settings = replace(
        PUBLISHED,
        association_speed_deviation=0.0,
        acceleration_density=density,
        edge_variance=1e-9 if source else 3.47e-3,
    )
    found = np.array([step_figures(edge_times, filtered, settings, seed, source=source) for seed in range(60)])
    assert np.median(found[:, 0]) == pytest.approx(settling, abs=0.01)
    assert np.median(found[:, 2]) == pytest.approx(angle_error, rel=0.04)


def test_false_alarms_are_rare(edge_times, filtered):
    """Ten minutes at a steady speed, 118 000 edges. For normal innovations the mean distance of two alarms is
    exp(2 (6 + 1.166))/4 = 4e5 edges, and the even part of the noise makes it longer: at most two, and the RMS keeps.
    """
    rng = np.random.default_rng(8)
    speed = 2.0 * np.pi * 24.7
    numbers, angles = edge_times.angles(WHEEL.edges, 1, int(600.0 * 8.0 * 24.7) - 8)
    times = (angles + np.sqrt(3.47e-3) * rng.normal(size=angles.size)) / speed
    rows = edge_times.clocked(times, 1.0 - 2.0 * (numbers % 2.0), 0.3, 600.0)
    rms = []
    for settings in (PUBLISHED, CONSTANT_SPEED):
        shown, _ = filtered(settings, rows, speed=150.0)
        late = rows[:, 0] > 2.0
        rms.append(np.sqrt(np.mean(np.square(shown[late, 1] - speed))))
        assert np.sum(np.diff(shown[late, 3] > 3.0) > 0) <= 4
    assert rms[0] < 1.06 * rms[1]
