"""The settings that a log speaks for: the likelihood itself, and what is found where the noise is known."""

from dataclasses import replace

import h5py
import numpy as np
import pytest
from scipy.stats import chi2, multivariate_normal
from tests.offline.rippling import passing_times

from vvdp.estimation.event_settings import event_filter
from vvdp.numerics.kalman import AngleSpeed, predict, update
from vvdp.offline.likelihood import Likelihood, fit, speed_errors, time_resolution
from vvdp.offline.noise_fit import careful_drift, fit_noise, fitted_filter
from vvdp.offline.passage import Noise, Passage, passage_start, passage_step
from vvdp.offline.passed_edges import Passed, longest_pieces
from vvdp.offline.pattern_fit import foretold_gain, likeliest_ripple
from vvdp.offline.turn_pattern import SpeedRipple
from vvdp.sensing.wheel import TURN, equal_wheel
from vvdp.simulation.replay import Replay

PITCH = TURN / 8.0
SPEED = 120.0


def errors_of(likelihood, found, step=0.05):
    """Standard errors of ln q and ln R_2 from the curvature of ln L; infinite where a value lies at its floor."""
    at, free = np.log(np.array(found.noise)), ~np.array(found.at_floor)
    axes = step * np.eye(2)[free]

    def L(place):
        return likelihood.logarithm(Noise(*np.exp(place).tolist()))

    mixed = [[L(at + a - b) + L(at - a + b) - L(at + a + b) - L(at - a - b) for b in axes] for a in axes]
    errors = np.full(2, np.inf)
    errors[free] = np.sqrt(np.diag(np.linalg.inv(np.array(mixed) / (4.0 * step**2))))
    return errors


def passed(times, angles, sampled=0.0, pieces=1.0):
    one = np.ones(times.size)
    return Passed(times, np.round(angles / PITCH), angles, sampled * one, pieces * one)


def wandering(count, noise, seed, speed=SPEED):
    """Angles at regular times, measured with noise, and the true speed: exactly the model of the filter."""
    rng = np.random.default_rng(seed)
    h, q = PITCH / speed, noise.acceleration_density
    root = np.linalg.cholesky(q * np.array([[h**3 / 3.0, h**2 / 2.0], [h**2 / 2.0, h]]))
    pushes = rng.normal(size=(count, 2)) @ root.T
    speeds = speed + np.cumsum(pushes[:, 1])
    before = np.concatenate([[speed], speeds[:-1]])
    true = np.cumsum(h * before + pushes[:, 0])
    times = h * np.arange(1, count + 1)
    return passed(times, true + rng.normal(0.0, np.sqrt(noise.edge_variance), count)), speeds


def test_the_third_edge_says_what_the_second_difference_does():
    # nu = y3 - 2 y2 + y1. Noise: (1 + 4 + 1) R. White acceleration of density q: with u the time from the middle edge,
    # the second difference weighs it by h - |u|, so its variance is 2 q int_0^h (h - u)^2 du = 2/3 q h^3.
    q, R, h = 30.0, 4e-4, 0.01
    memory, shown = passage_start(), None
    for angle, first in ((0.0, 1.0), (0.3, 0.0), (0.35, 0.0)):
        memory, shown = passage_step(memory, Passage(h, angle, 0.0, first), Noise(q, R))
    assert shown.innovation == pytest.approx(0.35 - 0.3)
    assert shown.variance == pytest.approx(6.0 * R + 2.0 / 3.0 * q * h**3, rel=1e-12)


def test_the_likelihood_is_that_of_the_second_differences():
    # Second differences of angles at even times are Gaussian, with the covariances R (6, -4, 1) and, of integrated
    # white noise, q h^3 (2/3, 1/6): an independent way to the same number, since they map onto y3, y4, ... with
    # determinant 1.
    noise = Noise(42.0, 3.8e-4)
    edges, _ = wandering(80, noise, 1)
    h = float(np.diff(edges.times)[0])
    n = 78
    C = sum(value * (np.eye(n, k=k) + (np.eye(n, k=-k) if k else 0.0)) for k, value in enumerate((
        6.0 * noise.edge_variance + 2.0 / 3.0 * noise.acceleration_density * h**3,
        -4.0 * noise.edge_variance + noise.acceleration_density * h**3 / 6.0,
        noise.edge_variance,
    )))  # fmt: skip
    expected = multivariate_normal(np.zeros(n), C).logpdf(np.diff(edges.angles, 2))
    assert Likelihood(edges, 8).logarithm(noise) == pytest.approx(expected, rel=1e-9)


def test_where_the_record_begins_in_time_and_angle_does_not_matter():
    noise = Noise(42.0, 3.8e-4)
    edges, _ = wandering(200, noise, 2)
    moved = edges._replace(times=edges.times + 64.0, angles=edges.angles + 512.0)
    one, other = (Likelihood(each, 8).logarithm(noise) for each in (edges, moved))
    assert other == pytest.approx(one, rel=1e-8)


def test_known_noise_is_recovered_within_the_standard_errors():
    # Of 24 records, the sums of the squared errors of ln q and of ln R_2 over their variances are chi-square with 24
    # degrees each; the bounds leave out 1e-4 at either end.
    noise = Noise(50.0, 4e-4)
    z = []
    for seed in range(24):
        likelihood = Likelihood(wandering(1000, noise, 100 + seed)[0], 8)
        found = fit(likelihood)
        assert found.at_floor == (False, False)
        z.append((np.log(np.array(found.noise)) - np.log(np.array(noise))) / errors_of(likelihood, found))
    low, high = chi2.ppf([1e-4, 1.0 - 1e-4], 24)
    squares = np.sum(np.square(z), axis=0)
    assert np.all((low < squares) & (squares < high)), squares
    # ... and no bias: the mean of 24 has a standard error of 1/sqrt(24)
    assert np.all(np.abs(np.mean(z, axis=0)) < 4.0 / np.sqrt(24.0))


def test_what_sampling_makes_is_not_taken_for_the_edges_own():
    noise, sampled = Noise(50.0, 4e-4), 6e-4
    edges, _ = wandering(3000, Noise(50.0, noise.edge_variance + sampled), 5)
    likelihood = Likelihood(edges._replace(sampling_variances=np.full(3000, sampled)), 8)
    found = fit(likelihood)
    error = errors_of(likelihood, found)[1]
    assert abs(np.log(found.noise.edge_variance / noise.edge_variance)) < 4.0 * error


def test_a_constant_speed_and_exact_edges_end_at_the_floors():
    times = np.round(0.1 + np.arange(1000) * PITCH / SPEED, 9)
    found = fit(Likelihood(passed(times, np.arange(1000) * PITCH), 8))
    assert found.at_floor == (True, True)
    assert found.noise.edge_variance == pytest.approx((SPEED * 1e-9) ** 2 / 12.0, rel=1e-6)
    # q T^3/R = n^-4
    assert found.noise.acceleration_density == pytest.approx(
        found.noise.edge_variance / 1000.0**4 / (PITCH / SPEED) ** 3, rel=1e-4
    )


@pytest.mark.parametrize(("step", "begin"), [(1e-9, 0.0), (1e-6, 1.7e5), (1e-3, 0.2)])
def test_the_resolution_of_written_times(step, begin):
    times = begin + np.round(np.sort(np.random.default_rng(0).uniform(0.0, 10.0, 500)) / step) * step
    assert time_resolution(times) == pytest.approx(step)
    assert time_resolution(np.random.default_rng(0).uniform(0.5, 0.99, 500)) == np.spacing(0.99)


def test_the_wheel_is_told_from_the_speed():
    places = 0.05 * np.array([1.0, -1.0, 0.5, 0.0, -0.5, 0.0, 0.3, -0.3])
    edges, _ = wandering(2000, Noise(50.0, 4e-4), 7)
    numbers = np.arange(2000.0)
    edges = edges._replace(numbers=numbers)
    # a ripple at 4 per turn cannot be seen whole by 8 edges: all that repeats is the wheel's
    none = fit_noise(edges, 8, Noise(50.0, 4e-4), 4)
    assert none.wheel is None and none.settings_gain < 10.0 and not none.matters
    # an edge that lies further on is measured at an angle that is smaller than where it is
    seen = edges._replace(angles=edges.angles - places[np.mod(numbers, 8).astype(int)])
    found = fit_noise(seen, 8, Noise(50.0, 4e-4), 4)
    assert found.wheel is not None and found.wheel_gain > 100.0
    # 250 turns: 2 % of a deviation of 0.02 rad each, and a little more since the speed wanders
    assert np.allclose(found.offsets, places - np.mean(places), atol=0.008)
    q, R = found.wheel.noise
    errors = errors_of(found.likelihood.without(places - np.mean(places)), found.wheel)
    assert np.all(np.abs(np.log([q / 50.0, R / 4e-4])) < 4.0 * errors)
    # 7 of 2000 degrees of freedom went into the offsets, which the filter is not told of
    assert found.advised.edge_variance == pytest.approx(R * 2000.0 / 1993.0 + np.mean(found.offsets**2))
    assert found.ripple is None
    assert found.period_gain(9) < 0.0 and found.period_gain(2) == 0.0
    assert found.period_gain(10) < 0.5 * found.wheel_gain  # what it shares with 8: even and odd edges


def rippling(turns, order, amplitude, jitter=0.0):
    """Edges of a spool whose speed is SPEED (1 + amplitude cos(order angle)), stamped to 1 ns."""
    angles = PITCH * np.arange(1.0, 8.0 * turns + 1.0)
    late = np.random.default_rng(2).normal(0.0, jitter / SPEED, angles.size) if jitter else 0.0
    return passed(np.round(0.3 + passing_times(angles, order, amplitude, SPEED) + late, 9), angles)


def test_a_ripple_of_the_speed_is_not_taken_for_the_wheel():
    found = fit_noise(rippling(250, 3, 0.032), 8, Noise(0.25, 3.47e-3), 3)
    assert found.ripple.order == 3 and found.ripple.amplitude == pytest.approx(0.032, rel=1e-3)
    assert found.ripple.sine == pytest.approx(0.0, abs=1e-4)
    # the wave of twice the frequency that is left, a^2/(4 N) = 8.5e-5 rad, and no more, is the wheel's
    assert np.sqrt(np.mean(found.offsets**2)) == pytest.approx(0.032**2 / 12.0 / np.sqrt(2.0), rel=0.02)
    jittered = fit_noise(rippling(250, 3, 0.032, jitter=0.01), 8, Noise(0.25, 3.47e-3), 3)
    assert abs(jittered.ripple.cosine - 0.032) < 4.0 * jittered.ripple.error < 0.01


def test_the_spools_ripple_alone_is_found_where_all_offsets_are_not_worth_their_price():
    """3 % beside a jitter of 0.06 rad: 3200 edges know each part to 3 sqrt(2/3200) 0.06 = 0.0045, so ln L rises by
    0.5 (0.03/0.0045)^2 = 22. All seven offsets cost 28; of the ripple that is expected the odds are e^(22 - 3.5)."""
    found = fit_noise(rippling(400, 3, 0.03, jitter=0.06), 8, Noise(0.25, 3.47e-3), 3)
    assert found.ripple.order == 3 and np.all(found.offsets == 0.0)
    assert found.ripple.error == pytest.approx(3.0 * np.sqrt(2.0 / 3200.0) * 0.06, rel=0.05)
    assert abs(found.ripple.cosine - 0.03) < 3.0 * found.ripple.error > abs(found.ripple.sine)
    assert found.wheel_gain == pytest.approx(0.5 * (found.ripple.amplitude / found.ripple.error) ** 2, rel=0.1)
    assert fit_noise(rippling(400, 3, 0.0, jitter=0.06), 8, Noise(0.25, 3.47e-3), 3).ripple is None


def test_a_ripple_has_to_foretell_edges_it_was_not_fitted_to():
    """Of 3 % over a jitter of 0.06 rad ln L rises by 22; what the first of 64 parts cannot foretell is about the sum of
    1/b, b to 63: 4.7. Noise alone is foretold in less than 0.57/64 of all logs, by chance in none of 40."""
    likelihood = Likelihood(rippling(400, 3, 0.03, jitter=0.06), 8)
    found = fit(likelihood)
    ripple = likeliest_ripple(likelihood, found.noise, 3)
    gain = 0.5 * (ripple.amplitude / ripple.error) ** 2
    assert foretold_gain(likelihood, found.noise, 3) == pytest.approx(gain - 4.7, abs=4.0)
    noise, rng = Noise(1e-9, 0.01), np.random.default_rng(7)
    even = np.arange(640) * PITCH
    logs = [Likelihood(passed(even / SPEED, even + rng.normal(0.0, 0.1, 640)), 8) for _ in range(40)]
    assert sum(foretold_gain(each, noise, 3) > 0.0 for each in logs) <= 2  # 3 or more of 40 at 0.9 %: 6e-3


def test_exact_edges_are_no_surer_than_the_pattern_that_was_learnt_lets_them_be():
    # Without the pattern the times' step of 1 ns would be the floor, 1.2e-15 rad^2. One edge among the 2000 - 7 that
    # tell may be as far off as those of the pattern, (0.032/3)^2/2 = 5.7e-5 rad^2.
    found = fit_noise(rippling(250, 3, 0.032), 8, Noise(0.25, 3.47e-3), 3)
    assert found.wheel.at_floor[1]
    assert found.wheel.noise.edge_variance == pytest.approx((0.032 / 3.0) ** 2 / 2.0 / 1993.0, rel=0.01)
    even = fit_noise(rippling(250, 3, 0.0), 8, Noise(0.25, 3.47e-3), 3)
    assert even.wheel is None and even.advised.edge_variance < 1e-14


@pytest.mark.thorough
def test_offsets_that_were_learnt_leave_fewer_degrees_of_freedom():
    # 64 edges of a known wheel in 40 records; plain maximum likelihood would find 57/64 of the variance. What is
    # advised contains the mean square of the offsets as found, that of the true ones and 7/64 R of their errors.
    places, R, advised = 0.1 * np.array([1.0, -1.0, 0.5, 0.0, -0.5, 0.0, 0.3, -0.3]), 4e-4, []
    numbers = np.arange(64)
    for seed in range(40):
        angles = numbers * PITCH + np.random.default_rng(seed).normal(0.0, np.sqrt(R), 64) - places[numbers % 8]
        edges = passed(numbers * PITCH / SPEED, angles)._replace(numbers=numbers.astype(float))
        found = fit_noise(edges, 8, Noise(1e-3, R), 3)
        assert found.wheel is not None
        advised.append(found.advised.edge_variance - np.mean(places**2))
    # a standard error of sqrt(2/57/40) = 3 %, and of the offsets' cross term as much again; three times both
    assert np.mean(advised) == pytest.approx(R * (1.0 + 7.0 / 64.0), rel=0.13)


def test_the_speed_error_is_what_a_filter_has():
    true, taken = Noise(50.0, 4e-4), Noise(0.25, 3.47e-3)
    edges, speeds = wandering(4000, true, 11)
    likelihood = Likelihood(edges, 8)
    errors = speed_errors(likelihood, taken, true)
    belief, left = AngleSpeed(edges.angles[0], SPEED, 1.0, 0.0, 1.0), []
    for k, h in enumerate(np.diff(edges.times).tolist()):
        belief = predict(belief, h, taken.acceleration_density)
        belief = update(belief, edges.angles[k + 1] - belief.angle, taken.edge_variance)
        left.append(belief.speed - speeds[k + 1])
    # the filter remembers (R T/q)^(1/4) = 0.1 s of 26 s: some 250 independent values, 4.5 %; four times that
    assert np.sqrt(np.mean(np.square(left[1000:]))) == pytest.approx(errors.true, rel=0.2)
    assert errors.stated == pytest.approx(np.sqrt(belief.speed_variance), rel=0.05)
    best = speed_errors(likelihood, true, true)
    assert best.stated == pytest.approx(best.true, rel=1e-9)
    for factor in (0.1, 10.0):
        assert speed_errors(likelihood, Noise(50.0 * factor, 4e-4), true).true > best.true


def test_the_longest_pieces_are_taken(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        assert longest_pieces(file, 3e-3) is None
        counts = {1.0: 300, 2.0: 9000, 3.0: 10, 4.0: 2000} | {5.0 + k: 900 for k in range(20)}
        t = np.concatenate([piece * 1000.0 + np.arange(count) * 0.01 for piece, count in counts.items()])
        pieces, one = np.repeat([*counts], [*counts.values()]), np.ones(t.size)
        columns = {"time": t, "number": t * 100.0, "angle": t, "variance": 5e-3 * one, "piece": pieces, "settled": one}
        for name, values in columns.items():
            file[f"edges/{name}"] = values
        edges = longest_pieces(file, 3e-3)
        assert edges.times.size == 4096 and set(edges.pieces) == {2.0}
        assert np.allclose(edges.sampling_variances, 2e-3)
        file["edges/settled"][pieces == 2.0] = 0.0
        # now the longest have 2000, 900, 900 and 900 edges; of the last one only what is missing is taken
        edges = longest_pieces(file, 3e-3)
        assert {piece: np.count_nonzero(edges.pieces == piece) for piece in set(edges.pieces)} == {
            4.0: 2000, 5.0: 900, 6.0: 900, 7.0: 296,
        }  # fmt: skip


def test_a_manoeuvre_is_no_calmer_than_what_was_fitted():
    told = replace(fit_noise(rippling(20, 3, 0.0), 8, Noise(0.25, 3.47e-3), 3), advised=Noise(3e4, 1e-5))
    found = fitted_filter(event_filter(equal_wheel(8)), told)
    assert (found.acceleration_density, found.manoeuvre_density, found.edge_variance) == (3e4, 3e4, 1e-5)
    assert found.ripple_order == 0.0


def test_the_filter_is_told_of_the_ripple_as_far_as_it_is_known():
    told = fit_noise(rippling(250, 3, 0.032, jitter=0.01), 8, Noise(0.25, 3.47e-3), 3)
    found = fitted_filter(event_filter(equal_wheel(8)), told)
    assert found.ripple_order == 3.0
    # cosine and sine each have half of the mean square, and the error
    assert found.ripple_variance == pytest.approx(0.5 * told.ripple.amplitude**2 + told.ripple.error**2)
    assert found.edge_variance == pytest.approx(1e-4, rel=0.2)


@pytest.mark.parametrize("R", [1e-3, 1e-5, 1e-8])
def test_the_drift_is_that_of_the_steady_filter(R):
    """A walk of one part, each edge telling it with the variance r = 2 N^2 R: its Riccati equation, run to the end."""
    drift, period = careful_drift(SpeedRipple(3, 0.03, 0.0, 1e-3), R, 5e-3), 5e-3
    r, known = 2.0 * 9.0 * R, 1.0
    for _ in range(200_000):
        known = known * r / (known + r) + drift * period
    assert known == pytest.approx(1e-3**2 + 0.25 * 0.03**4, rel=1e-6)


def test_plain_python_and_replay_agree_about_a_passage():
    edges, _ = wandering(60, Noise(50.0, 4e-4), 3)
    likelihood = Likelihood(edges._replace(pieces=np.repeat([1.0, 2.0], 30)), 8)
    replay = Replay(passage_step, passage_start(), Passage(0.0, 0.0, 0.0, 1.0), Noise(1.0, 1.0))
    shown = replay(passage_start(), likelihood._rows, Noise(50.0, 4e-4)).shown
    memory = passage_start()
    for row, expected in zip(likelihood._rows, shown, strict=True):
        memory, surprise = passage_step(memory, Passage(*row.tolist()), Noise(50.0, 4e-4))
        assert tuple(surprise) == pytest.approx(tuple(expected), rel=1e-12, abs=1e-15)
