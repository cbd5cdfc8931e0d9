"""Scores of estimates whose errors are known."""

import numpy as np
import pytest

from vvdp.comparison.figures import quantile
from vvdp.comparison.motion import Lag, Ramps, steady
from vvdp.comparison.result import FIGURES
from vvdp.comparison.scores import (
    Score,
    Traces,
    Truth,
    equivalent_delay,
    score,
    settling_time,
    summary,
    without_direction,
)

SECTOR = np.pi / 4
TIME = np.arange(3000) * 1e-3
STEP = Lag(70.0, 150.0, 1.0, 0.03)


def truth(motion):
    return Truth(TIME, motion.angle(TIME), motion.speed(TIME))


def scored(angle_error, speed_error, motion=None, deviation=0.0):
    motion = motion or steady(150.0)
    true = truth(motion)
    still = np.zeros(TIME.size)
    traces = Traces(
        angle=true.angle + angle_error,
        speed=true.speed + speed_error,
        innovation=still + 0.2,
        innovation_deviation=still + deviation,
        angle_deviation=still + 0.02,
        speed_deviation=still + (1.0 if deviation >= 0.0 else np.nan),
    )
    return score(traces, true, motion, 0.5, SECTOR)


def test_constant_errors_are_found():
    found = scored(0.03, -2.0)
    assert found.angle_mean_square == pytest.approx(9e-4)
    assert (found.angle_tail, found.angle_worst, found.angle_bias) == pytest.approx((0.03, 0.03, 0.03))
    assert (found.speed_tail, found.speed_worst, found.speed_bias) == pytest.approx((2.0, 2.0, -2.0))
    assert found.lost_sectors == 0.0
    assert np.isnan(found.settling) and np.isnan(found.delay)


def test_sines_are_found():
    """A sine of amplitude a over whole periods: mean square a^2/2, 95 % below a sin(0.95 pi/2) = 0.99692 a, mean 0."""
    wave = np.sin(2 * np.pi * 2.0 * TIME)
    found = scored(0.1 * wave, 4.0 * wave)
    assert found.speed_mean_square == pytest.approx(8.0, rel=1e-3)
    assert found.speed_tail == pytest.approx(4.0 * 0.99692, rel=1e-3)
    assert found.angle_bias == pytest.approx(0.0, abs=1e-4)


@pytest.mark.parametrize("pairs", [-7, 0, 3])
def test_the_unknown_index_does_not_count_but_polarity_does(pairs):
    assert scored(2 * pairs * SECTOR + 0.03, 0.0).angle_bias == pytest.approx(0.03)
    assert abs(scored((2 * pairs + 1) * SECTOR, 0.0).angle_bias) == pytest.approx(SECTOR)


def test_sectors_lost_on_the_way_are_counted():
    """Five sectors are passed over at 2 s; modulo a turn of eight that is an error of 3 sectors from then on."""
    lost = np.where(TIME < 2.0, 0.0, -5 * SECTOR)
    found = scored(lost, 0.0)
    assert found.lost_sectors == 5.0
    assert found.angle_worst == pytest.approx(3 * SECTOR)


def test_coverage_is_the_share_within_two_deviations():
    """Deviations of 0.02 rad and 1 rad/s; the speed is 3 off for the last second of the 2.5 that count."""
    found = scored(0.03, np.where(TIME < 2.0, 1.9, 3.0))
    assert found.angle_coverage == 1.0 and scored(0.05, 0.0).angle_coverage == 0.0
    assert found.speed_coverage == pytest.approx(0.6, abs=1e-3)
    assert np.isnan(scored(0.0, 0.0, deviation=np.nan).speed_coverage)


def test_of_a_reversal_the_way_counts_and_not_the_direction():
    """From 100 to -100 rad/s within 1 s: at 2.9 s it has turned through 100 + 50 + 90 = 240 rad."""
    motion = Ramps((0.0, 1.0, 2.0), (100.0, 100.0, -100.0))
    found = without_direction(truth(motion), motion)
    assert found.angle[2900] == pytest.approx(240.0) and found.speed[2900] == pytest.approx(100.0)
    assert found.angle[500] == pytest.approx(50.0)


def test_nis_counts_only_edges_that_were_used():
    assert scored(0.0, 0.0, deviation=0.1).nis == pytest.approx(4.0)
    assert np.isnan(scored(0.0, 0.0, deviation=0.0).nis)
    assert np.isnan(scored(0.0, 0.0, deviation=np.nan).nis)


def test_a_true_copy_settles_when_the_shaft_does():
    """A first-order lag is within 5 % after ln 20 = 2.9957 time constants, 89.87 ms; the next sample is at 90 ms."""
    assert scored(0.0, 0.0, STEP).settling == pytest.approx(0.090)


def test_settling_means_staying():
    late = STEP.speed(TIME)
    late[2000] += 5.0  # more than 5 % of 80 rad/s
    assert settling_time(TIME, late, STEP) == pytest.approx(1.001)
    late[-1] += 5.0
    assert settling_time(TIME, late, STEP) == np.inf
    assert settling_time(TIME, np.full(TIME.size, 150.0), STEP) == 0.0
    assert settling_time(TIME, np.full(TIME.size, np.nan), STEP) == np.inf


@pytest.mark.parametrize("delay", [0.0, 0.0123, 0.05, 0.1507])
def test_delays_are_found(delay):
    shown = STEP.speed(TIME - delay)
    assert equivalent_delay(TIME, shown, STEP) == pytest.approx(delay, abs=2e-5)


def test_a_delay_beyond_what_is_sought_is_not_measured():
    assert equivalent_delay(TIME, STEP.speed(TIME - 0.3), STEP) == np.inf
    scores = np.zeros((3, len(Score._fields)))
    scores[:, Score._fields.index("delay")] = 0.01, np.inf, 0.02
    mean = summary(scores)["delay_s"]
    assert mean.value == np.inf and np.isnan(mean.error)


def test_a_lag_delays_by_about_its_time_constant():
    """Through a further lag of 10 ms a slow ramp comes 10 ms late."""
    slow = Lag(0.0, 150.0, 0.2, 1.0)
    shown = np.empty(TIME.size)
    shown[0], keep = 0.0, np.exp(-1e-3 / 0.01)
    for k in range(1, TIME.size):
        shown[k] = keep * shown[k - 1] + (1.0 - keep) * slow.speed(TIME[k : k + 1] - 0.5e-3)[0]
    assert equivalent_delay(TIME, shown, slow) == pytest.approx(0.01, abs=5e-4)


def test_quantiles_take_what_never_settles_as_long():
    values = np.array([1.0, 2.0, 3.0, np.inf, np.inf])
    assert quantile(values, 0.5).value == 3.0
    assert quantile(values, 0.9).value == np.inf
    assert np.isnan(quantile(np.array([1.0, np.nan]), 0.5).value)


def test_the_mean_of_95_per_cent_may_lie_below_the_rms_and_is_called_a_mean():
    """Two runs whose angle is off by 0.01 and by 0.05 rad throughout: mean 0.03, rms sqrt(1.3e-3) = 0.0361."""
    runs = [Score(*[0.0] * len(Score._fields))._replace(angle_mean_square=e * e, angle_tail=e) for e in (0.01, 0.05)]
    found = summary(np.array(runs))
    assert found["angle_error_95_rad"].value == pytest.approx(0.03)
    assert found["angle_error_rms_rad"].value == pytest.approx(0.03606, abs=1e-5)
    assert all(
        "mean 95 %" in FIGURES[f"{name}_error_95_{unit}"][1] for name, unit in (("angle", "rad"), ("speed", "rad_s"))
    )


def test_standard_errors_are_those_of_repeated_studies():
    """400 studies of 200 normal errors each: the spread of their figures is the standard error that each states.

    The spread of 400 values is known to 1/sqrt(800) = 3.5 %; four of these are 14 %. The quantile's error is itself an
    estimate from two ordered values, so its mean over the studies is compared, to 25 %.
    """
    random = np.random.default_rng(5)
    found = []
    for _ in range(400):
        rows = np.zeros((200, len(Score._fields)))
        rows[:, Score._fields.index("speed_mean_square")] = random.normal(size=200) ** 2
        rows[:, Score._fields.index("speed_bias")] = random.normal(size=200)
        rows[:, Score._fields.index("settling")] = random.normal(size=200)
        found.append(summary(rows))
    for key, tolerance in (
        ("speed_error_rms_rad_s", 0.14),
        ("speed_error_mean_rad_s", 0.14),
        ("settling_median_s", 0.25),
    ):
        spread = np.std([each[key].value for each in found])
        assert np.mean([each[key].error for each in found]) == pytest.approx(spread, rel=tolerance)
