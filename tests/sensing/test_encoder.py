from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import kstest

from vvdp.base.errors import ParameterError
from vvdp.base.signal import constant
from vvdp.sensing.encoder import (
    INTERPOLATED,
    Shaft,
    capture_unit,
    counter_difference,
    edge_deviation,
    encoder_reading,
    encoder_start,
    encoder_step,
    sample_times,
)
from vvdp.sensing.photodiode import LightSpot, ramp_width
from vvdp.sensing.wheel import CodeWheel, edge_angle, equal_wheel, nearest_edge

RATE = 1000.0
EXACT = capture_unit(0.0)


def constant_speed(hertz, phase=0.37, until=2.0, first=0.1):
    """Times, angles and the speed of a shaft that turns evenly."""
    w = 2 * np.pi * hertz
    t = sample_times(RATE, phase, until)
    return t, first + w * t, w


def edge_errors(found, angle_at, encoder):
    """Angle at the told time of each edge, less that of the nearest edge of its polarity."""
    angles = angle_at(found.edge_time)
    numbers = [nearest_edge(a, p, encoder.wheel) for a, p in zip(angles.tolist(), found.polarity.tolist(), strict=True)]
    return angles - np.array([edge_angle(n, encoder.wheel) for n in numbers])


# What is right


def test_edges_are_stamped_where_they_pass(make_encoder, read):
    encoder = make_encoder(acquisition=EXACT)
    t, angle, w = constant_speed(24.7)
    found = read(encoder, t, angle, w)
    assert found.edges.sum() == np.floor((angle[-1]) / (np.pi / 4)) - np.floor(0.1 / (np.pi / 4))
    assert edge_errors(found, lambda x: 0.1 + w * x, encoder) == pytest.approx(0.0, abs=1e-9 * w)


def test_a_cubic_motion_is_met_exactly(make_encoder, read):
    encoder = make_encoder(acquisition=EXACT)
    t = sample_times(RATE, 0.2, 1.0)
    angle, speed = 40 * t + 60 * t**2 - 15 * t**3, 40 + 120 * t - 45 * t**2
    found = read(encoder, t, angle, speed)
    errors = edge_errors(found, lambda x: 40 * x + 60 * x**2 - 15 * x**3, encoder)
    assert errors == pytest.approx(0.0, abs=1e-7)  # 48 bisections of 1 ms: far below 1e-9 s


def test_time_of_an_edge_converges_with_the_fourth_power(make_encoder, read):
    """The cubic's remainder is h^4/384 times the fourth derivative."""
    encoder, worst = make_encoder(acquisition=EXACT), []
    rates = np.array([100.0, 200.0, 400.0])
    for rate in rates:
        t = sample_times(rate, 0.3, 4.0)
        found = read(encoder, t, 9 * t + 0.2 * np.sin(25 * t), 9 + 5 * np.cos(25 * t))
        worst.append(np.max(np.abs(edge_errors(found, lambda x: 9 * x + 0.2 * np.sin(25 * x), encoder))))
    order = -np.polyfit(np.log(rates), np.log(worst), 1)[0]
    assert order == pytest.approx(4.0, abs=0.5)
    assert max(worst) <= 0.2 * 25**4 / 384 / 100**4 * 1.05


def test_delay_to_the_sample_is_even_on_a_clock_that_does_not_fit(make_encoder, read):
    """Kolmogorov and Smirnov on edge times within their interval; p above 0.001 for a fixed phase."""
    t, angle, w = constant_speed(24.7361, until=20.0)
    sampled, stamped = read(make_encoder(), t, angle, w), read(make_encoder(acquisition=EXACT), t, angle, w)
    delay = (sampled.time - stamped.edge_time) * RATE
    assert np.all((delay >= 0.0) & (delay <= 1.0))
    assert kstest(delay, "uniform").pvalue > 1e-3
    assert sampled.edge_time == pytest.approx(sampled.time - 0.5 / RATE)
    assert sampled.interval == pytest.approx(1.0 / RATE)


def test_every_edge_has_the_same_delay_at_five_samples_per_sector(make_encoder, read):
    """25 Hz, 8 sectors, 1 kHz."""
    t, angle, w = constant_speed(25.0)
    wheel = equal_wheel(8)
    sampled = read(make_encoder(wheel=wheel), t, angle, w)
    stamped = read(make_encoder(wheel=wheel, acquisition=EXACT), t, angle, w)
    assert np.ptp(sampled.time - stamped.edge_time) < 1e-9


def test_a_line_through_two_samples_of_the_ramp_is_exact_for_a_strip(make_encoder, read):
    encoder = make_encoder(acquisition=INTERPOLATED)
    t, angle, w = constant_speed(24.7)  # a ramp takes 3.2 ms
    found = read(encoder, t, angle, w)
    assert found.interval == pytest.approx(0.0)
    assert edge_errors(found, lambda x: 0.1 + w * x, encoder) == pytest.approx(0.0, abs=1e-9)


def test_off_the_ramp_interpolation_claims_nothing(make_encoder, read):
    """At 120 Hz a ramp takes 0.65 ms: one of two samples always lies on a plateau."""
    t, angle, w = constant_speed(120.0)
    found = read(make_encoder(acquisition=INTERPOLATED), t, angle, w)
    assert found.interval == pytest.approx(1.0 / RATE)


# The threshold


@pytest.mark.parametrize("threshold", [0.35, 0.65])
def test_wrong_threshold_moves_edges_by_turns(make_encoder, read, threshold):
    """delta = (c - 0.5) w; 0.15 * 0.4909 = 0.0736 rad for c = 0.65; the sum over a turn is nothing."""
    encoder = make_encoder(acquisition=EXACT, threshold=constant(threshold))
    t, angle, w = constant_speed(24.7)
    found = read(encoder, t, angle, w)
    errors = edge_errors(found, lambda x: 0.1 + w * x, encoder)
    assert errors == pytest.approx(found.polarity * (threshold - 0.5) * 0.490874, abs=1e-6)
    assert np.sum(errors[:8]) == pytest.approx(0.0, abs=1e-6)


def test_hysteresis_delays_both_polarities(make_encoder, read):
    """Half of it each way, 0.05 of the light, or 0.05 w later."""
    encoder = make_encoder(acquisition=EXACT, hysteresis=0.1)
    t, angle, w = constant_speed(24.7)
    errors = edge_errors(read(encoder, t, angle, w), lambda x: 0.1 + w * x, encoder)
    assert errors == pytest.approx(0.05 * ramp_width(encoder.spot), abs=1e-6)


def test_noise_of_the_light_is_noise_of_the_angle(make_encoder, read):
    """Mean 0 and deviation sigma w, each within 4 standard errors of 4000 edges."""
    encoder = make_encoder(acquisition=EXACT, noise=0.05)
    t, angle, w = constant_speed(24.7, until=20.3)
    errors = edge_errors(read(encoder, t, angle, w), lambda x: 0.1 + w * x, encoder)
    n, sigma = errors.size, edge_deviation(encoder)
    assert sigma == pytest.approx(0.05 * 0.490874, rel=1e-5)
    assert abs(errors.mean()) < 4 * sigma / np.sqrt(n)
    assert abs(errors.std() / sigma - 1.0) < 4 / np.sqrt(2 * n)
    assert n == pytest.approx(20.3 * 24.7 * 8, abs=2)  # no bounces


# The counter


def test_a_counter_that_starts_again_loses_nothing(make_encoder, read):
    t, angle, w = constant_speed(60.0)
    small, large = read(make_encoder(counter_bits=3.0), t, angle, w), read(make_encoder(), t, angle, w)
    assert small.edges.sum() == large.edges.sum() > 2**3
    assert counter_difference(1.0, 65535.0, 16.0) == 2.0


def test_edges_within_one_interval_are_all_counted(make_encoder, read):
    """300 Hz: 2.4 edges per millisecond, or an odd one with the index; the last one is told."""
    t, angle, w = constant_speed(300.0)
    found = read(make_encoder(acquisition=EXACT), t, angle, w)
    assert set(found.edges) == {2.0, 3.0}
    assert found.edges.sum() == pytest.approx(w * (t[-1] - t[0]) / (np.pi / 4), abs=2)
    assert found.edges.mean() == pytest.approx(2.4, abs=0.01)
    assert np.all(found.time - found.edge_time <= 1.0 / (300 * 8 * 0.75))


def test_a_shaft_that_turns_back_gives_the_opposite_polarity(make_encoder, read):
    """A slow swing over edge 0 alone: dark to bright, bright to dark, with the counter going on."""
    t = sample_times(RATE, 0.0, 1.0)
    found = read(make_encoder(acquisition=EXACT), t, -0.2 + 0.4 * np.sin(np.pi * t), 0.4 * np.pi * np.cos(np.pi * t))
    assert found.polarity.tolist() == [1.0, -1.0]
    assert found.edge_time == pytest.approx([1 / 6, 5 / 6], abs=1e-7)  # sin = 1/2


# Faults


def test_missed_edges_leave_the_polarity_true(make_encoder, read):
    """20 % of 3952 edges, within 4 deviations of the binomial; what is seen is where it should be."""
    encoder = make_encoder(acquisition=EXACT, faults={"missed_edges": 0.2})
    t, angle, w = constant_speed(24.7, until=20.0)
    found = read(encoder, t, angle, w)
    n = 20.0 * 24.7 * 8
    assert abs(found.edges.sum() - 0.8 * n) < 4 * np.sqrt(0.16 * n)
    assert edge_errors(found, lambda x: 0.1 + w * x, encoder) == pytest.approx(0.0, abs=1e-7)
    assert np.any(found.polarity[1:] == found.polarity[:-1])


def test_an_edge_that_bounces_counts_three_times(make_encoder, read):
    t, angle, w = constant_speed(24.7, until=20.0)
    found = read(make_encoder(faults={"double_edges": 0.1}), t, angle, w)
    n = found.edges.size
    assert set(found.edges) == {1.0, 3.0}
    assert abs(np.sum(found.edges == 3.0) - 0.1 * n) < 4 * np.sqrt(0.09 * n)
    assert np.all(found.polarity[1:] == -found.polarity[:-1])


def test_nothing_is_told_during_a_dropout(make_encoder, read):
    encoder = make_encoder(acquisition=EXACT, faults={"dropout_begin": 0.5, "dropout_end": 1.5})
    t, angle, w = constant_speed(24.7)
    found = read(encoder, t, angle, w)
    assert not np.any((found.time >= 0.5) & (found.time < 1.5))
    assert found.time.max() > 1.9
    assert edge_errors(found, lambda x: 0.1 + w * x, encoder) == pytest.approx(0.0, abs=1e-7)


def test_an_eccentric_wheel_moves_each_edge_the_same_way_each_turn(make_encoder, read):
    """theta + e sin(theta - direction) = edge; to first order the edge is seen e sin too early."""
    encoder = make_encoder(acquisition=EXACT, faults={"eccentricity": 0.02, "eccentric_direction": 1.0})
    t, angle, w = constant_speed(24.7)
    found = read(encoder, t, angle, w)
    at = 0.1 + w * found.edge_time
    apparent = at + 0.02 * np.sin(at - 1.0)
    nearest = [
        edge_angle(nearest_edge(a, p, encoder.wheel), encoder.wheel)
        for a, p in zip(apparent, found.polarity, strict=True)
    ]
    assert apparent == pytest.approx(nearest, abs=1e-7)


def test_dirt_shifts_an_edge_and_too_much_of_it_hides_a_sector(make_encoder, read):
    """Half the light on edge 2: the spot must be wholly bright, 0.5 w later. Less light: edges 2 and 3 are not seen."""
    t, angle, w = constant_speed(24.7)
    dirt = {"dirt_angle": np.pi / 2 - 0.1, "dirt_width": 0.2}
    dim = make_encoder(acquisition=EXACT, faults={**dirt, "dirt_depth": 0.4})
    errors = edge_errors(read(dim, t, angle, w), lambda x: 0.1 + w * x, dim)
    assert np.max(errors) == pytest.approx((0.5 / 0.6 - 0.5) * ramp_width(dim.spot), abs=1e-6)
    assert np.sum(errors > 1e-6) == pytest.approx(2.0 * 24.7, abs=1.0)
    dark = make_encoder(acquisition=EXACT, faults={**dirt, "dirt_depth": 0.6})
    assert read(dark, t, angle, w).edges.sum() == pytest.approx(6 * 2.0 * 24.7, abs=6)


def test_a_clock_that_gains_stretches_all_times(make_encoder, read):
    t, angle, w = constant_speed(24.7)
    right = read(make_encoder(acquisition=EXACT), t, angle, w)
    fast = read(make_encoder(acquisition=EXACT, faults={"clock_drift": 1e-3}), t, angle, w)
    assert fast.edge_time == pytest.approx(1.001 * right.edge_time)
    assert sample_times(RATE, 0.0, 1.0, 1e-3)[-1] == pytest.approx(1.0, abs=1e-12)
    assert sample_times(RATE, 0.0, 1.0, 1e-3).size == 1002


def test_jitter_delays_edges_by_a_sample_now_and_then(make_encoder, read):
    """A sample shows the shaft up to 0.5 ms before its time: on average a quarter of the edges come a sample later."""
    t, angle, w = constant_speed(24.7361, until=20.0)
    late = read(make_encoder(faults={"clock_jitter": 5e-4}), t, angle, w)
    right = read(make_encoder(), t, angle, w)
    n = min(late.time.size, right.time.size)
    delay = np.round((late.time[:n] - right.time[:n]) * RATE)
    assert set(delay) == {0.0, 1.0}
    assert abs(delay.mean() - 0.25) < 4 * np.sqrt(0.1875 / n)


# Plain, compiled, seeds, refusals


def everything_wrong(make_encoder):
    return make_encoder(
        acquisition=INTERPOLATED,
        noise=0.03,
        hysteresis=0.02,
        spot=LightSpot(width=4e-3, track_radius=0.0102, roundness=1.0),
        faults={"missed_edges": 0.05, "double_edges": 0.05, "eccentricity": 0.01, "clock_jitter": 1e-4,
                "dirt_width": 1.0, "dirt_depth": 0.2, "clock_drift": 1e-4},
    )  # fmt: skip


def test_compiled_is_plain(make_encoder, read):
    encoder = everything_wrong(make_encoder)
    t, angle, w = constant_speed(24.7, until=0.6)
    memory, plain = encoder_start(encoder, 0.0, 0.1, 5.0), []
    for row in zip(t.tolist(), angle.tolist(), strict=True):
        memory, reading = encoder_step(memory, Shaft(*row, w), encoder)
        plain.append(reading)
    found = read(encoder, t, angle, w, start=(0.0, 0.1), seed=5.0)
    assert np.array(plain) == pytest.approx(found.all, rel=1e-12, abs=1e-12)
    assert found.edges.size > 80


def test_equal_seeds_are_equal_and_others_are_not(make_encoder, read):
    encoder = everything_wrong(make_encoder)
    t, angle, w = constant_speed(24.7, until=1.0)
    one, again, other = (read(encoder, t, angle, w, seed=s).all for s in (3.0, 3.0, 4.0))
    np.testing.assert_array_equal(one, again)
    assert not np.array_equal(one, other)


def test_without_noise_and_faults_the_seed_is_nothing(make_encoder, read):
    t, angle, w = constant_speed(24.7, until=1.0)
    np.testing.assert_array_equal(*(read(make_encoder(), t, angle, w, seed=s).all for s in (3.0, 4.0)))


def test_the_threshold_may_be_given_from_outside(make_encoder):
    encoder = make_encoder(threshold=constant(0.7))
    memory = encoder_start(encoder, 0.0, 0.1, 1.0)
    shaft = Shaft(1e-3, 0.3, 150.0)
    assert encoder_reading(memory, shaft, 0.7, encoder) == encoder_step(memory, shaft, encoder)


def test_what_does_not_fit_is_refused(make_encoder):
    encoder = make_encoder()
    with pytest.raises(ParameterError, match=r"covers 45 deg .* narrowest sector, 33\.75 deg"):
        replace(encoder, spot=LightSpot(width=8e-3, track_radius=encoder.spot.track_radius, roundness=0.0))
    with pytest.raises(ParameterError, match=r"counter_bits = 2\.5"):
        replace(encoder, counter_bits=2.5)
    with pytest.raises(ParameterError, match=r"eccentricity: 68\.75 deg"):
        make_encoder(faults={"eccentricity": 1.2})
    with pytest.raises(ParameterError, match="3 edges"):
        CodeWheel((0.0, 1.0, 2.0))
