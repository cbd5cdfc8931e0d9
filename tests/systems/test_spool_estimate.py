"""What a run says of the estimate of a watched spool: errors, what it states of them, and when the two do not agree."""

import numpy as np
import pytest
from tests.words import wording

from vvdp.base.tables import parsed_table
from vvdp.evaluation.bench_report import BenchReport
from vvdp.numerics.kalman import chance_band
from vvdp.programs.estimate_report import (
    EstimateReport,
    ShaftWatch,
    estimate_doubts,
    estimate_errors,
    estimate_numbers,
    estimate_quantities,
    mean_speed,
)
from vvdp.systems.system import built_system, load_system

PITCH = 2.0 * np.pi / 3.0
AT_INSTANT = ShaftWatch("estimate", "encoder", "spool", 0.0)


def shown(times, angle_error=0.0, speed_error=0.0, standstill=0.0):
    """An estimate that states 0.1 rad and 2 rad/s of a spool at 10 rad/s, and where the spool stands."""
    sampled = {"time": times, "angle": 10.0 * times, "speed": np.full(times.size, 10.0)}
    estimate = {
        "angle": sampled["angle"] + angle_error,
        "speed": sampled["speed"] + speed_error,
        "angle_deviation": np.full(times.size, 0.1),
        "speed_deviation": np.full(times.size, 2.0),
        "missed_edges": np.zeros(times.size),
        "standstill": np.zeros(times.size) + standstill,
    }
    return estimate, sampled


def test_numbers_by_hand():
    """From 0.5 to 4.5 s; 1 s of it the speed is 6 rad/s off, else 3: mean square (36 + 27)/4, a quarter outside."""
    times = np.linspace(0.0, 4.5, 4501)
    off = np.where((times > 1.0) & (times <= 2.0), 6.0, -3.0)
    found = estimate_numbers(times, *shown(times, 0.05, off, np.where(times > 4.2, 1.0, np.nan)), AT_INSTANT)
    assert found["spool_speed_error_rms_rad_s"] == pytest.approx(np.sqrt(63.0 / 4.0), rel=1e-3)
    assert found["spool_speed_deviation_rms_rad_s"] == pytest.approx(2.0)
    assert found["spool_speed_coverage"] == pytest.approx(0.75, abs=1e-3)
    assert found["spool_speed_nees"] == pytest.approx(63.0 / 16.0, rel=1e-3)
    assert found["spool_speed_errors"] == 3.0  # below, above, below
    assert (found["spool_angle_coverage"], found["spool_angle_errors"]) == (pytest.approx(1.0), 1.0)
    assert found["spool_angle_nees"] == pytest.approx(0.25)
    assert found["standstill_time_s"] == pytest.approx(0.3, abs=1e-3)
    assert found.keys() == estimate_quantities(AT_INSTANT).keys()


def test_the_mean_over_a_pwm_period_knows_no_ripple():
    """dt = (1 + 0.3 cos 3 theta) dtheta/omega: each third of a turn takes 2 pi/(3 omega), wherever it begins."""
    angle = np.linspace(1.0, 30.0, 5001)
    times = (angle + 0.1 * np.sin(3.0 * angle)) / 150.0
    assert mean_speed(times, angle, PITCH) == pytest.approx(150.0, rel=1e-6)
    speed = 150.0 / (1.0 + 0.3 * np.cos(3.0 * angle))
    sampled = {"time": times, "angle": angle, "speed": speed}
    told = {"angle": angle, "speed": np.full(angle.size, 150.0)}
    assert estimate_errors(told, sampled, PITCH).speed == pytest.approx(0.0, abs=1e-3)
    assert estimate_errors(told, sampled, 0.0).speed == pytest.approx(150.0 - speed)


def test_a_spool_that_turns_less_than_a_period_has_the_mean_of_all():
    times = np.linspace(0.0, 2.0, 21)
    assert mean_speed(times, 0.4 * times, PITCH) == pytest.approx(0.4)
    assert mean_speed(times, 0.0 * times, PITCH) == pytest.approx(0.0)


def test_the_band_of_two_squared_errors_is_that_of_the_exponential_distribution():
    """Half the sum of two squared normal numbers is exponential with mean 1."""
    assert chance_band(2) == pytest.approx((-np.log(0.975), -np.log(0.025)))


@pytest.mark.parametrize(("scale", "doubts"), [(2.0, 0), (6.0, 1), (1.2, 0), (0.4, 1)])
def test_an_estimate_is_doubted_where_it_is_too_sure_or_not_sure_enough(scale, doubts):
    times = np.linspace(0.0, 2.0, 2001)
    errors = scale * np.random.default_rng(5).standard_normal(times.size)
    found = estimate_numbers(times, *shown(times, 0.05 * errors, errors), AT_INSTANT)
    said = list(estimate_doubts(found, AT_INSTANT))
    assert len(said) == 2 * doubts
    if scale == 6.0:
        assert wording.systems.spool_speed.format(speed="19.1 rpm") in said[1]
        assert wording.systems.two_deviations in said[1]


@pytest.mark.parametrize("height", [0.5, 2.2])
def test_few_errors_of_one_sign_prove_nothing(height):
    """A second of an error that swings once, in stated deviations: all of it inside, or a quarter outside."""
    times = np.linspace(0.0, 1.5, 1501)
    slow = height * np.sin(2.0 * np.pi * times)
    found = estimate_numbers(times, *shown(times, 0.1 * slow, 2.0 * slow), AT_INSTANT)
    outside = 1.0 - 2.0 / np.pi * np.arcsin(min(2.0 / height, 1.0))
    assert found["spool_speed_coverage"] == pytest.approx(1.0 - outside, abs=2e-3)
    assert not list(estimate_doubts(found, AT_INSTANT))


def test_one_error_far_outside_is_told():
    """A speed twice the true one is one error, but none of chance."""
    times = np.linspace(0.0, 1.5, 1501)
    found = estimate_numbers(times, *shown(times, 0.1, 10.0), AT_INSTANT)
    assert found["spool_speed_errors"] == 1.0
    assert len(list(estimate_doubts(found, AT_INSTANT))) == 1


def test_names_say_what_the_speed_is():
    """Where the ripple is left out, all of the speed's numbers are of means over a PWM period."""
    for pitch, words in ((PITCH, "mean over a PWM period"), (0.0, "of the instant")):
        labels = [
            label
            for key, (_, label) in estimate_quantities(AT_INSTANT._replace(pitch=pitch)).items()
            if key.startswith("spool_speed")
        ]
        assert len(labels) == 5
        assert all(words in label for label in labels)


def test_a_bench_without_an_encoder_has_none_of_it():
    assert "spool_speed_coverage" not in BenchReport(load_system("prototype-constant-load")).QUANTITIES


WHEELS = """
[nodes]
wheel = { type = "driven-shaft", speed = "1500 rpm" }
tank = { type = "tank" }
line = { type = "volume", volume = "1 l", start = "20 bar" }

[components]
drain = { type = "orifice", a = "line", b = "tank", area = "6 mm^2" }

[parts.watch]
type = "spool-encoder"
angle = { from = "wheel.angle" }
speed = { from = "wheel.speed" }

[run]
until = "0.1 s"
sample_period = "1 ms"
"""


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ("", []),
        ('[programs.watch.encoder]\nsectors = "6"\n', ["(8 sectors, watch_encoder has 6)"]),
        ('[programs.watch.filter]\nindex_shift = "0.2"\n', ["(other edges)"]),
    ],
)
def test_a_filter_that_takes_the_wheel_for_another_is_doubted(changes, told):
    network = built_system(
        parsed_table(WHEELS.replace("[run]", f"{changes}\n[run]"), "own.toml"), "own"
    ).circuit.network
    doubts = [*EstimateReport(network, "watch_filter", 1e-3).warnings({})]
    assert len(doubts) == len(told) and all(words in doubt for words, doubt in zip(told, doubts, strict=True))
