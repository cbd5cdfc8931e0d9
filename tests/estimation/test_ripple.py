"""The ripple beside the event filter: against the filter of four states, the exact course, and what is learnt of it."""

from dataclasses import replace

import numpy as np
import pytest
from tests.dense_filter import predict_n, update_n

from vvdp.estimation.event_settings import event_filter
from vvdp.estimation.ripple import (
    Ripple,
    displacement,
    of_the_instant,
    place_of,
    predict_ripple,
    ripple_start,
    seen_variance,
    update_with_ripple,
    without_covariance,
)
from vvdp.numerics.kalman import AngleSpeed, predict, update
from vvdp.sensing.wheel import equal_wheel

SECTOR = np.pi / 4.0


def split(mean, P):
    """The belief and the ripple of a mean (4,) and covariance (4, 4) of angle, speed, a and b."""
    belief = AngleSpeed(mean[0], mean[1], P[0, 0], P[0, 1], P[1, 1])
    ripple = Ripple(
        cosine=mean[2],
        sine=mean[3],
        cosine_variance=P[2, 2],
        cross=P[2, 3],
        sine_variance=P[3, 3],
        angle_cosine=P[0, 2],
        angle_sine=P[0, 3],
        speed_cosine=P[1, 2],
        speed_sine=P[1, 3],
    )
    return belief, ripple


def numbers(belief, ripple):
    return np.array([*belief, *ripple])


def some_beliefs(count=20):
    """Means and covariances of four states, of a spool at about 155 rad/s with a few per cent of ripple."""
    rng = np.random.default_rng(4)
    for _ in range(count):
        mean = rng.normal([3.0, 155.0, 0.0, 0.0], [2.0, 5.0, 0.03, 0.03])
        factor = rng.normal(size=(4, 4)) * np.array([0.03, 1.0, 0.02, 0.02])
        yield mean, factor.T @ factor


def test_displacement_by_hand():
    """a = 0.06, b = 0.03, N = 3 at 30 degrees, where 3 theta = 90: a/3 = 0.02 ahead; at 60 degrees b/3 = 0.01 ahead."""
    ripple = ripple_start(1e-4)._replace(cosine=0.06, sine=0.03)
    assert displacement(ripple, place_of(np.pi / 6.0, 3.0)) == pytest.approx(0.02, abs=1e-15)
    assert displacement(ripple, place_of(np.pi / 3.0, 3.0)) == pytest.approx(0.01, abs=1e-15)


def test_scalars_are_the_filter_of_four_states():
    """Predicted by F, Q and corrected with H = (1, 0, sin(N theta)/N, -cos(N theta)/N), by the general functions."""
    q, drift, order, h, R, nu = 0.25, 1e-4, 3.0, 5e-3, 4e-3, 0.03
    F, Q = np.eye(4), np.zeros((4, 4))
    F[0, 1] = h
    Q[:2, :2] = q * np.array([[h**3 / 3.0, h * h / 2.0], [h * h / 2.0, h]])
    Q[2, 2] = Q[3, 3] = drift * h
    for edge, (mean, P) in enumerate(some_beliefs()):
        belief, ripple = split(mean, P)
        belief, ripple = predict(belief, h, q), predict_ripple(ripple, h, drift)
        mean, P = predict_n(mean, P, F, Q)
        np.testing.assert_allclose(numbers(belief, ripple), numbers(*split(mean, P)), rtol=1e-12, atol=1e-15)
        angle = edge * SECTOR
        H = np.array([1.0, 0.0, np.sin(order * angle) / order, -np.cos(order * angle) / order])
        place = place_of(angle, order)
        assert seen_variance(belief, ripple, place) == pytest.approx(H @ P @ H, rel=1e-12)
        mean, P = update_n(mean, P, H, nu, R)
        after = numbers(*update_with_ripple(belief, ripple, place, nu, R))
        np.testing.assert_allclose(after, numbers(*split(mean, P)), rtol=1e-11, atol=1e-14)


def test_without_a_ripple_it_is_the_plain_filter():
    belief, none = AngleSpeed(1.0, 155.0, 0.01, 0.1, 4.0), ripple_start(0.0)
    after, learnt = update_with_ripple(belief, none, place_of(1.1, 3.0), 0.1, 4e-3)
    assert after == pytest.approx(update(belief, 0.1, 4e-3), rel=1e-12) and learnt == none
    assert of_the_instant(belief, none, 3.0) == pytest.approx(belief, rel=1e-15)


def exact_instant(state, order):
    """Angle and speed of theta = phi + (a sin N theta - b cos N theta)/N, solved by iteration to rounding."""
    phi, speed, a, b = state
    theta = phi
    for _ in range(60):
        theta = phi + (a * np.sin(order * theta) - b * np.cos(order * theta)) / order
    return np.array([theta, speed / (1.0 - a * np.cos(order * theta) - b * np.sin(order * theta))])


def test_of_the_instant_is_the_exact_course():
    """Mean by iteration, covariance by the gradients of it in differences; r = 4 % leaves r^3/N of an angle and r^3
    of a speed; without the second step these would be r^2, 25 times as much."""
    for mean, P in some_beliefs():
        mean[2:] *= 0.04 / np.hypot(*mean[2:])
        shown = of_the_instant(*split(mean, P), 3.0)
        exact = exact_instant(mean, 3.0)
        assert shown.angle == pytest.approx(exact[0], abs=1.1 * 0.04**3 / 3.0)
        assert shown.speed == pytest.approx(exact[1], abs=1.1 * 0.04**3 * mean[1])
        steps = 1e-6 * np.eye(4)
        J = np.column_stack([exact_instant(mean + x, 3.0) - exact_instant(mean - x, 3.0) for x in steps]) / 2e-6
        C = J @ P @ J.T
        found = np.array([[shown.angle_variance, shown.covariance], [shown.covariance, shown.speed_variance]])
        scale = np.sqrt(np.outer(np.diag(C), np.diag(C)))
        assert np.max(np.abs(found - C) / scale) < 3e-3


def test_speed_of_the_instant_is_the_rate_of_its_angle():
    """Along the mean course: theta(t + h) - theta(t) over h."""
    (mean, P), h = next(some_beliefs(1)), 1e-6
    belief, ripple = split(mean, P)
    here = of_the_instant(belief, ripple, 3.0)
    there = of_the_instant(belief._replace(angle=belief.angle + h * belief.speed), ripple, 3.0)
    assert (there.angle - here.angle) / h == pytest.approx(here.speed, rel=1e-4)


def edges_of(amplitude, phase, count, order=3.0, speed=155.0):
    """Times at which the edges of eight sectors pass a spool of a ripple a = r cos phase, b = r sin phase."""
    a, b = amplitude * np.cos(phase), amplitude * np.sin(phase)
    angles = SECTOR * np.arange(1, count + 1)
    return angles, (angles - (a * np.sin(order * angles) - b * np.cos(order * angles)) / order) / speed


def learnt(amplitude, phase, count, deviation, seed, variance=6e-4):
    """The ripple after so many edges, whose noise is that of an angle, and the belief."""
    angles, times = edges_of(amplitude, phase, count)
    times = times + deviation * np.random.default_rng(seed).normal(size=count) / 155.0
    belief, ripple, before = AngleSpeed(0.0, 150.0, 1.0, 0.0, 100.0), ripple_start(variance), 0.0
    for angle, time in zip(angles, times, strict=True):
        belief, ripple = predict(belief, time - before, 0.25), predict_ripple(ripple, time - before, 0.0)
        place, before = place_of(angle, 3.0), time
        innovation = angle - belief.angle - displacement(ripple, place)
        belief, ripple = update_with_ripple(belief, ripple, place, innovation, deviation**2)
    return belief, ripple


@pytest.mark.parametrize("phase", [0.0, 1.0, 2.5, -2.0])
def test_a_ripple_that_is_there_is_learnt(phase):
    """3.5 %, edges good to 0.02 rad, 2000 of them: a and b within three standard errors, and these N sqrt(2 R/n)."""
    _, ripple = learnt(0.035, phase, 2000, 0.02, seed=int(10 * phase) + 30)
    error = 3.0 * np.sqrt(2.0 * 0.02**2 / 2000)
    assert np.sqrt([ripple.cosine_variance, ripple.sine_variance]) == pytest.approx([error, error], rel=0.02)
    assert abs(ripple.cosine - 0.035 * np.cos(phase)) < 3.0 * error
    assert abs(ripple.sine - 0.035 * np.sin(phase)) < 3.0 * error


def test_standard_errors_are_those_of_many_records():
    """The scatter of a and b over 200 records is what the filter states, within three errors of a deviation."""
    ripples = [learnt(0.035, 0.7, 160, 0.02, seed)[1] for seed in range(200)]
    found = np.array([(each.cosine, each.sine, each.cosine_variance) for each in ripples])
    stated = np.sqrt(found[0, 2])
    for part, true in ((found[:, 0], np.cos(0.7)), (found[:, 1], np.sin(0.7))):
        rms = np.sqrt(np.mean((part - 0.035 * true) ** 2))
        assert rms == pytest.approx(stated, rel=3.0 / np.sqrt(400.0))


def test_a_drifting_ripple_is_known_to_its_steady_variance():
    """dP/dt = d - lambda P^2/(2 N^2 R) is 0 at P = N sqrt(2 d R/lambda): 3 sqrt(2 x 1e-6 x 4e-4/197.35) = 6.04e-6."""
    belief, ripple, h = AngleSpeed(0.0, 155.0, 1e-4, 0.0, 0.01), ripple_start(6e-4), SECTOR / 155.0
    for edge in range(1, 4000):
        belief, ripple = predict(belief, h, 0.25), predict_ripple(ripple, h, 1e-6)
        belief, ripple = update_with_ripple(belief, ripple, place_of(edge * SECTOR, 3.0), 0.0, 4e-4)
    assert [ripple.cosine_variance, ripple.sine_variance] == pytest.approx([6.04e-6, 6.04e-6], rel=0.02)


def test_edges_out_of_place_look_the_same_at_any_speed():
    """A wheel whose edges lie (a sin N theta - b cos N theta)/N too far ahead passes them at the very same times."""
    for speed in (60.0, 155.0):
        angles, times = edges_of(0.035, 0.4, 64, speed=speed)
        a, b = 0.035 * np.cos(0.4), 0.035 * np.sin(0.4)
        seen = angles - (a * np.sin(3.0 * angles) - b * np.cos(3.0 * angles)) / 3.0
        assert times * speed == pytest.approx(seen, rel=1e-14)


def test_a_course_begun_anew_keeps_its_ripple():
    _, ripple = split(*next(some_beliefs(1)))
    alone = without_covariance(ripple)
    assert alone[:5] == ripple[:5] and alone[5:] == (0.0,) * 4


def test_speed_of_a_rippling_spool(filtered):
    """3.2 %, three a turn, stamped edges good to 0.01 rad: the error of the speed is as stated, and a fifth of what it
    is without the ripple, 0.032/sqrt(2) x 155 = 3.5 rad/s."""
    wheel, rng = equal_wheel(8), np.random.default_rng(1)
    _, passed = edges_of(0.032, 0.9, 1000)
    passed = np.sort(passed + 0.01 * rng.normal(size=1000) / 155.0)
    time = np.arange(0.001, 4.8, 1e-3)
    sample = np.searchsorted(time, passed)
    kept = sample < time.size
    rows = np.zeros((time.size, 5))
    rows[:, 0] = time
    rows[sample[kept], 1:] = np.column_stack(
        [np.ones(1000), passed, np.zeros(1000), np.where(np.arange(1000) % 2, 1.0, -1.0)]
    )[kept]
    phi = 155.0 * time
    true = np.array([exact_instant((x, 155.0, 0.032 * np.cos(0.9), 0.032 * np.sin(0.9)), 3.0)[1] for x in phi])
    plain = replace(event_filter(wheel), edge_variance=1e-4, stop_rate=0.0)
    rippling = replace(plain, ripple_order=3.0, ripple_variance=6e-4)
    errors, deviations = [], []
    for told in (plain, rippling):
        shown, _ = filtered(told, rows, speed=155.0)
        errors.append((shown[:, 1] - true)[time > 1.0])
        deviations.append(shown[time > 1.0, 3])
    without, with_it = (np.sqrt(np.mean(error**2)) for error in errors)
    assert without == pytest.approx(3.5, rel=0.05) and with_it < 0.2 * without
    assert np.mean(np.abs(errors[1]) < 2.0 * deviations[1]) > 0.9
