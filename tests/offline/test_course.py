"""The course of the spool by the whole record, and how far rows are from it."""

import numpy as np
import pytest

from vvdp.estimation.smoother import filter_edges, run_plainly
from vvdp.numerics.kalman import AngleSpeed
from vvdp.offline.course import AROUND, Explanation, course_of, squared_errors
from vvdp.offline.likelihood import Likelihood, fit
from vvdp.offline.noise_fit import fit_noise
from vvdp.offline.passage import Noise, Passage, passage_start, restarting_step
from vvdp.offline.passed_edges import Passed
from vvdp.simulation.replay import Compiled

TURN = 2.0 * np.pi
PITCH, SPEED = TURN / 8, 120.0
NOISE = Noise(50.0, 4e-4)
EVEN = Explanation(NOISE, 3.47e-3, np.zeros(8), None)


def edges_of(times, angles, variance=3.47e-3):
    return np.array([times, angles, np.full(times.size, variance)])


def rows_of(times, angles, speeds):
    return {"time": times, "angle": angles, "speed": speeds, "standstill": np.zeros(times.size)}


def wander(count, seed):
    """A motion of the model at regular edges: times [s], angles [rad], speeds [rad/s], and angles as they are seen."""
    random, h = np.random.default_rng(seed), PITCH / SPEED
    root = np.linalg.cholesky(NOISE.acceleration_density * np.array([[h**3 / 3.0, h**2 / 2.0], [h**2 / 2.0, h]]))
    pushes = random.normal(size=(count, 2)) @ root.T
    speeds = SPEED + np.cumsum(pushes[:, 1])
    angles = np.cumsum(h * np.concatenate([[SPEED], speeds[:-1]]) + pushes[:, 0])
    seen = angles + random.normal(0.0, np.sqrt(NOISE.edge_variance), count)
    return h * np.arange(1, count + 1), angles, speeds, seen


@pytest.mark.parametrize("taken", [Noise(0.25, 3.47e-3), NOISE, Noise(5e4, 4e-4)])
def test_the_mean_square_of_any_estimate_follows_from_the_smoothed_course(taken):
    """E (x - x_f)^2 = P + E (x_s - x_f)^2 for a filter that is too slow, right, and too quick; of 20000 edges one in
    the time constant of 2 to 60 is independent."""
    times, angles, speeds, seen = wander(20_000, 3)
    start = AngleSpeed(seen[0], SPEED, 1.0, 0.0, 100.0)
    variances = np.full(times.size, taken.edge_variance)
    told = filter_edges(times, seen, variances, taken.acceleration_density, start, Compiled())
    run = Compiled()
    course = course_of(edges_of(times, seen), np.zeros(times.size, int), EVEN, run)
    chosen, squares = squared_errors(rows_of(times, told.angle, told.speed), course, run)
    chosen[:200] = False
    assert np.all(np.isfinite(squares["speed"]) >= chosen)
    assert np.mean(squares["speed"][chosen]) == pytest.approx(np.mean((told.speed - speeds)[chosen] ** 2), rel=0.1)
    assert np.mean(squares["angle"][chosen]) == pytest.approx(np.mean((told.angle - angles)[chosen] ** 2), rel=0.1)


def test_a_row_off_by_a_constant_has_that_as_its_deviation():
    """Exact edges at 120 rad/s, rows with 121 and 0.01 rad more: 1 rad/s and 0.01 rad, and what is left of the course:
    sqrt(2) q^(3/4) (R T)^(1/4) = 0.8 rad^2/s^2 of a filter, less of a smoother."""
    times = np.arange(400) * PITCH / SPEED
    angles = np.arange(400) * PITCH
    run = Compiled()
    course = course_of(edges_of(times, angles), np.zeros(400, int), EVEN, run)
    at = np.linspace(times[50], times[350], 1000)
    exact = rows_of(at, SPEED * at, np.full(at.size, SPEED))
    off = rows_of(at, SPEED * at + 0.01, np.full(at.size, SPEED + 1.0))
    (_, left), (_, found) = (squared_errors(rows, course, run) for rows in (exact, off))
    assert found["speed"] - left["speed"] == pytest.approx(1.0, rel=1e-6)
    assert found["angle"] - left["angle"] == pytest.approx(1e-4, rel=1e-6)
    steady = np.sqrt(2.0) * NOISE.acceleration_density**0.75 * (NOISE.edge_variance * PITCH / SPEED) ** 0.25
    assert 0.1 * steady < np.mean(left["speed"]) < steady


def test_a_row_far_off_counts_by_itself_and_for_those_around():
    times = np.arange(200) * PITCH / SPEED
    run = Compiled()
    course = course_of(edges_of(times, np.arange(200) * PITCH), np.zeros(200, int), EVEN, run)
    at = times[20:180] + 1e-4  # one row in each sector
    rows = rows_of(at, SPEED * at, np.full(at.size, SPEED))
    rows["speed"][80] += 50.0
    _, squares = squared_errors(rows, course, run)
    assert squares["speed"][80] == pytest.approx(2500.0, rel=1e-2)
    assert squares["speed"][80 + AROUND] == pytest.approx(2500.0 / (2 * AROUND + 1), rel=1e-2)
    assert squares["speed"][81 + AROUND] < 1.0


def test_an_edge_beyond_four_standard_deviations_begins_anew_by_hand():
    """The third edge has S = 6 R + 2/3 q h^3 = 2.43e-3 rad^2, 0.0493 rad: 0.19 rad is within four of it, 0.2 not."""
    h = 0.01
    for late, here in ((0.19, 0.0), (0.2, 1.0)):
        memory = passage_start()
        for angle, first in ((0.0, 1.0), (0.3, 0.0), (0.3 - late, 0.0)):
            memory, told = restarting_step(memory, Passage(h, angle, 0.0, first), NOISE)
        assert told.here == here
        assert memory.seen == 2.0 - here


def test_a_step_of_the_speed_parts_the_course():
    """From 120 to 180 rad/s at edge 200: nothing is known from an edge before it to one after it."""
    steps = np.where(np.arange(399) < 200, PITCH / SPEED, PITCH / 180.0)
    times = np.append(0.0, np.cumsum(steps))
    run = Compiled()
    course = course_of(edges_of(times, np.arange(400) * PITCH), np.zeros(400, int), EVEN, run)
    assert np.flatnonzero(~course.known).tolist() == [0, 199, 200, 201]
    assert course.smoothed.beliefs.speed[100] == pytest.approx(SPEED, rel=1e-6)
    assert course.smoothed.beliefs.speed[300] == pytest.approx(180.0, rel=1e-6)


def test_a_course_of_sudden_changes_alone_is_none():
    """Each twentieth sector takes twice as long: that is noise of another kind."""
    steps = np.where(np.arange(399) % 20 == 0, 2.0, 1.0) * PITCH / SPEED
    times = np.append(0.0, np.cumsum(steps))
    assert course_of(edges_of(times, np.arange(400) * PITCH), np.zeros(400, int), EVEN, run_plainly) is None


def test_a_single_step_is_no_noise_that_lasts():
    """From 100 to 150 rad/s in one place: with it the likeliest density is a hundred times that of the rest."""
    numbers = np.arange(2000.0)
    steps = np.where(numbers < 1000, 1.0, 100.0 / 150.0) * (PITCH / 100.0)
    jitter = np.random.default_rng(1).normal(0.0, 0.01, 2000)
    passed = Passed(np.cumsum(steps), numbers, numbers * PITCH + jitter, np.zeros(2000), np.ones(2000))
    told = fit_noise(passed, 8, Noise(0.25, 3.47e-3), 3)
    whole = fit(Likelihood(passed, 8)).noise
    assert told.plain.noise == whole
    assert told.fit.noise.acceleration_density < 0.01 * whole.acceleration_density
    assert told.fit.noise.edge_variance == pytest.approx(1e-4, rel=0.1)
    assert told.fit.edges == 2000 and told.outliers == pytest.approx(1 / 2000, abs=2 / 2000)
