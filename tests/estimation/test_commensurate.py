"""Edges in step with the samples: what hides, how much and for how long, against brute force."""

from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from math import gcd

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import norm

from vvdp.base.errors import ParameterError
from vvdp.estimation.baselines.time_stamping import time_stamping, time_stamping_estimator
from vvdp.estimation.commensurate import (
    Commensurate,
    beat_time,
    commensurate_clock,
    commensurate_warning,
    hidden_angle,
    hidden_speed,
)
from vvdp.estimation.event_settings import event_filter
from vvdp.sensing.wheel import equal_wheel

WHEEL = equal_wheel(8)
SECTOR = np.pi / 4.0
FRACTIONS = [(p, q) for q in range(1, 9) for p in range(1, q + 1) if gcd(p, q) == 1] + [(1, 9), (3, 20), (7, 9)]


def detected_late(edge_times):
    """By how much the middle of the sampling interval comes after an edge, in sampling periods."""
    return np.ceil(edge_times) - 0.5 - edge_times


@pytest.mark.parametrize("p, q", FRACTIONS)
def test_p_edges_in_q_samples_fall_on_p_places(p, q):
    """Exactly, in fractions; the places are 1/p apart."""
    places = sorted({(Fraction(1, 997) + Fraction(q, p) * j) % 1 for j in range(5 * p * q)})
    assert len(places) == p
    assert {b - a for a, b in pairwise(places)} <= {Fraction(1, p)}


@pytest.mark.parametrize("p, q", FRACTIONS)
def test_the_hidden_angle_is_a_sector_over_2q_at_most_and_evenly_distributed(p, q):
    """Means over 20 rounds, at 4001 places of the first edge; an even distribution has the deviation bound/sqrt 3."""
    first = np.linspace(0.0, 1.0, 4001) + 1e-7
    late = detected_late(first[:, None] + q / p * np.arange(20 * p)).mean(axis=1)
    angle = SECTOR * p / q * late  # omega dT = sector p/q
    bound = hidden_angle(Commensurate(p, q, p / q, 1.0), SECTOR)
    assert bound == pytest.approx(SECTOR * p / q / (2 * p))
    assert np.abs(angle).max() == pytest.approx(bound, rel=2e-2)
    assert np.abs(angle).max() <= bound * (1.0 + 1e-5)
    assert angle.std() == pytest.approx(bound / np.sqrt(3.0), rel=1e-2)


@pytest.mark.parametrize("p, q", [(1, 5), (2, 5), (3, 7), (5, 8)])
def test_an_index_changes_the_hidden_angle_by_an_eighth_of_the_sampling_error_at_most(p, q):
    moved = np.arange(24 * p) + np.where(np.arange(24 * p) % 8 == 1, 0.25, 0.0)
    first = np.linspace(0.0, 1.0, 1001) + 1e-7
    angle = SECTOR * p / q * detected_late(first[:, None] + q / p * moved).mean(axis=1)
    step, bound = SECTOR * p / q, hidden_angle(Commensurate(p, q, p / q, 1.0), SECTOR)
    assert np.abs(angle).max() <= bound + step / 8.0
    assert np.abs(angle).max() <= step * gcd(p, 8) / (2 * p) * (1.0 + 1e-5)


@pytest.mark.parametrize("p, q, off", [(1, 5, 3e-4), (1, 5, -8e-4), (3, 7, 5e-4), (5, 8, -5e-4), (2, 3, 9e-4)])
def test_beside_the_fraction_the_hidden_angle_drifts_through_all_values_in_the_beat_time(p, q, off):
    """Sampling rate 1000/s, means over p edges: a sawtooth of period 1/|q f_e - p f_s| and of the hidden speed."""
    f_s, f_e = 1000.0, 1000.0 * p / q * (1.0 + off)
    found = commensurate_clock(f_e, f_s)
    assert (found.edges, found.samples) == (p, q)
    beat, bound = beat_time(found), hidden_angle(found, SECTOR)
    assert beat == pytest.approx(1.0 / (f_e * q * abs(off)), rel=2.0 * abs(off))
    at = np.arange(int(5.0 * beat * f_e) // p * p) / f_e
    # a late stamp makes the angle small at a given time: error = - omega x lateness
    angle = (-SECTOR * f_e / f_s * detected_late(f_s * at + 0.123)).reshape(-1, p).mean(axis=1)
    at = at.reshape(-1, p).mean(axis=1)
    jumps = np.flatnonzero(np.abs(np.diff(angle)) > bound)
    # a round that holds the jump lies between: two large differences, and a start known to two rounds
    starts = at[jumps[np.insert(np.diff(jumps) > 2, 0, True)]]
    np.testing.assert_allclose(np.diff(starts), beat, atol=2.0 * p / f_e)
    slope = np.median(np.diff(angle) / np.diff(at))
    assert slope == pytest.approx(hidden_speed(found, SECTOR), rel=0.01)
    assert np.ptp(angle) == pytest.approx(2.0 * bound, rel=0.03)


@pytest.mark.parametrize("beats", [1.0, 1.5, 2.5, 4.3])
def test_a_mean_over_beats_keeps_a_quarter_over_their_number(beats):
    """25.02 Hz, 8 sectors, 1 kHz: beat 1/|5 x 200.16 - 1000| = 1.25 s."""
    found = commensurate_clock(200.16, 1000.0)
    assert beat_time(found) == pytest.approx(1.25)
    angle = -SECTOR * 0.20016 * detected_late(1000.0 / 200.16 * np.arange(4000))
    n = round(beats * 1.25 * 200.16)
    means = np.convolve(angle, np.full(n, 1.0 / n), "valid")
    bound = hidden_angle(found, SECTOR)
    assert np.abs(means).max() <= bound / (4.0 * beats) + 2.0 * bound / n
    if beats % 1.0 == 0.5:
        assert np.abs(means).max() == pytest.approx(bound / (4.0 * beats), rel=0.05)


def test_noise_of_the_edges_uncovers_it():
    """The sawtooth's first harmonic, (1/pi) dT/p, is left times exp(-2 (pi p sigma/dT)^2): at 0.4 dT, 4 %."""
    sigma, p, q = 0.4, 1, 5
    share = (np.arange(20000) + 0.5) / 20000
    noise = sigma * norm.ppf(share)
    means = [detected_late(q / p * 3 + first + noise).mean() for first in np.linspace(0.0, 1.0, 50, endpoint=False)]
    assert np.max(np.abs(means)) == pytest.approx(np.exp(-2.0 * (np.pi * p * sigma) ** 2) / np.pi, rel=0.02)


@pytest.mark.parametrize("place", [0.1, 0.35, 0.5, 0.8])
def test_an_estimator_shows_the_bias_and_no_error_of_the_speed(sampled_edges, stepped, place):
    """25.000 Hz on 1 kHz: an edge `place` of a period after a sample is stamped 0.5 - place too early."""
    omega = 50.0 * np.pi
    times = 1e-3 * np.arange(401)
    angles = omega * (times - 1e-3 * place) + SECTOR
    shown, _ = stepped(
        time_stamping_estimator(time_stamping(WHEEL), 0.0, angles[0]), sampled_edges(WHEEL.edges, times, angles)
    )
    late = times > 0.1
    np.testing.assert_allclose(shown[late, 1], omega, rtol=1e-9)
    np.testing.assert_allclose((shown[:, 0] - angles)[late], omega * 1e-3 * (place - 0.5), atol=1e-9)
    assert abs(omega * 1e-3 * (place - 0.5)) <= hidden_angle(commensurate_clock(200.0, 1000.0), SECTOR)


@pytest.mark.parametrize(
    "rate, fraction",
    [
        (200.0, (1, 5)),
        (200.19, (1, 5)),
        (200.99, (1, 5)),  # beat 1/(5 x 0.99) = 0.2020 s
        (201.01, None),
        (197.6, None),  # 24.7 Hz
        (500.0, (1, 2)),
        (125.0, (1, 8)),
        (1000.0 / 11.0, (1, 11)),
        (1000.0 / 12.0, None),
        (999.5, (1, 1)),
        (1000.0, None),
        (1500.0, None),
        (0.0, None),
        (428.6, (3, 7)),
    ],
)
def test_known_rates(rate, fraction):
    found = commensurate_clock(rate, 1000.0)
    assert (None if found is None else (found.edges, found.samples)) == fraction


def test_more_samples_may_be_looked_at():
    assert commensurate_clock(1000.0 / 13.0, 1000.0, largest=13)[:2] == (1, 13)


@given(st.floats(10.0, 990.0), st.floats(0.01, 10.0))
def test_in_step_is_what_beats_longer_than_the_memory(rate, memory):
    """Also where p and q are large: at 7/8 of 1000/s a tenth of a percent beats in 1/(8 x 0.875) = 0.143 s."""
    found = commensurate_clock(rate, 1000.0, 0.0, memory)
    beats = [1.0 / max(abs(q * rate - 1000.0 * round(q * rate / 1000.0)), 1e-12) for q in range(1, 12)]
    near = [q for q, beat in zip(range(1, 12), beats, strict=True) if beat >= memory and round(q * rate / 1000.0)]
    assert (found is not None) == bool(near)
    if found:
        assert found.samples == near[0]
        assert beat_time(found) >= memory


@pytest.mark.thorough
def test_a_usual_warning_tells_where_the_filter_is_off_by_more_than_it_says(edge_times, filtered):
    """Rates from 60/s to 700/s on 1000/s, every 3.4/s and about all fractions, 8 phases each, edges without noise.

    Of 100 rates at which the RMS of the angle exceeds the filter's own deviation 9 in 10 are warned of, and none of
    the others is off by more than 1.6 deviations; a fraction of up to 8 samples and 0.1 % alone would leave half of
    them out, some off by more than 4 deviations.
    """
    settings = replace(event_filter(WHEEL), manoeuvre_gate=1e6, stop_rate=0.0)
    near = [p / q * (1.0 + e) for q in range(1, 13) for p in range(1, q) if gcd(p, q) == 1
            for e in (0.0, 5e-4, 1e-3, 2e-3, 3e-3, 4e-3, 6e-3)]  # fmt: skip
    rates = np.concatenate([np.arange(60.0, 700.0, 3.4), 1000.0 * np.array(near)])
    rates = rates[rates < 700.0]
    ratios = []
    for rate in rates:
        speed, squares = rate * SECTOR, []
        for phase in range(8):
            start = SECTOR * ((0.618 * phase) % 1.0)
            numbers, angles = edge_times.angles(WHEEL.edges, 1, int(3.0 * rate) - 4)
            times = (angles - start) / speed
            rows = edge_times.clocked(times, 1.0 - 2.0 * (numbers % 2.0), (0.382 * phase) % 1.0, 2.9)
            shown, _ = filtered(settings, rows, speed=speed - 5.0)
            late = (rows[:, 0] > 1.5) & (rows[:, 0] < times[-1])
            squares.append(np.mean(np.square(shown[late, 0] - start - speed * rows[late, 0])))
        ratios.append(np.sqrt(np.mean(squares)) / np.mean(shown[late, 2]))
    ratios = np.array(ratios)
    warned = np.array([commensurate_clock(rate, 1000.0) is not None for rate in rates])
    narrow = np.array([commensurate_clock(rate, 1000.0, 1e-3, np.inf, 8) is not None for rate in rates])
    off = ratios > 1.0
    even = np.arange(rates.size) < 189
    print(f"off {off.sum()}, not warned of {np.sum(off & ~warned)} (0.1 %, q <= 8: {np.sum(off & ~narrow)}), warned of "
          f"{warned[even].mean():.3f} of all rates, {off[even].mean():.3f} are off; worst {ratios[~warned].max():.2f} "
          f"({ratios[~narrow].max():.2f})")  # fmt: skip
    assert np.mean(warned[off]) > 0.9
    assert ratios[~warned].max() < 1.6
    assert np.mean(narrow[off]) < 0.6
    assert ratios[~narrow].max() > 4.0
    assert warned[even].mean() < 0.08


@given(ratio=st.floats(1e-3, 0.9999), scale=st.floats(1e-2, 1e4), tolerance=st.floats(0.0, 5e-3))
def test_what_is_found_is_so_and_what_is_not_found_is_not(ratio, scale, tolerance):
    found = commensurate_clock(ratio, 1.0, tolerance, np.inf, 8)
    near = [(p, q) for p, q in FRACTIONS if q <= 8 and abs(ratio * q / p - 1.0) <= tolerance]
    assert (found is not None) == bool(near)
    if found:
        assert found[:2] == min(near, key=lambda fraction: fraction[1])
        again = commensurate_clock(ratio * scale, scale, tolerance * (1.0 + 1e-12) + 1e-15, np.inf, 8)
        assert again[:2] == found[:2]


def test_the_warning_has_the_numbers():
    """200.1/s on 1000/s: off by 5e-4, beat 1/|1000.5 - 1000| = 2 s, 0.7854/10 = 0.0785 rad."""
    told = commensurate_warning(commensurate_clock(200.1, 1000.0), SECTOR)
    for piece in ("200.1/s", "1/5", "1000/s", "0.0005", "one place", "0.0785 rad", "1/10", "2 s", "5 s"):
        assert piece in told
    exact = commensurate_warning(commensurate_clock(2.0e3 / 3.0, 1000.0), SECTOR)
    assert "2 places" in exact
    assert "0.131 rad" in exact
    assert "no average removes it" in commensurate_warning(commensurate_clock(200.0, 1000.0), SECTOR)


def test_nonsense_is_refused():
    with pytest.raises(ParameterError, match="sampling rate: 0 Hz must be greater than 0"):
        commensurate_clock(200.0, 0.0)
    with pytest.raises(ParameterError, match="tolerance -1"):
        commensurate_clock(200.0, 1000.0, -1.0)
    with pytest.raises(ParameterError, match="memory: 0 ms"):
        commensurate_clock(200.0, 1000.0, 1e-3, 0.0)
