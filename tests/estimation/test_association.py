"""Which edge it was: by hand, with edges missed and doubled, for ten minutes."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vvdp.base.signal import constant
from vvdp.estimation.association import (
    Sighting,
    associated_edge,
    counted_edge,
    first_edge,
    irregular_share,
    sector,
)
from vvdp.estimation.event_settings import event_filter
from vvdp.sensing.encoder import NO_FAULTS, SAMPLED, Encoder, Shaft, encoder_start, encoder_step
from vvdp.sensing.photodiode import LightSpot
from vvdp.sensing.wheel import edge_angle, equal_wheel
from vvdp.simulation.replay import Replay

WHEEL = equal_wheel(8)
SECTOR = np.pi / 4.0
SHIPPED = event_filter(WHEEL)
SETTINGS = replace(SHIPPED, stop_rate=0.0)
"""A silence says nothing here: edges are missed, and the wheel turns on."""
SPEED = 2.0 * np.pi * 24.7


def sighting(sectors, polarity, fresh=1.0, since=1.0, ignored=0.0, odds=12.0, irregular=0.01, deviations=(0.08, 0.08)):
    """Where the belief is, in sectors of an equal wheel, and `since`, the sectors that should have passed."""
    S, S_m = (d * d for d in deviations)
    return Sighting(sectors * SECTOR, since * SECTOR, S, S_m, odds, ignored, fresh, polarity, irregular)


def test_counting_by_hand():
    assert counted_edge(4.0, 1.0, -1.0) == 5.0
    assert counted_edge(4.0, 1.0, 1.0) == 6.0  # 5 falls: one was missed
    assert counted_edge(4.0, 2.0, 1.0) == 6.0
    assert counted_edge(4.0, 3.0, 0.0) == 7.0
    assert counted_edge(-4.0, 1.0, -1.0) == -3.0


def test_first_edge_by_hand():
    """From 0.1 sectors on edge 1, which falls, comes first; if it rises, the error of the start hid edge 0 or 2."""
    assert first_edge(0.1 * SECTOR, -1.0, WHEEL) == 1.0
    assert first_edge(0.1 * SECTOR, 1.0, WHEEL) == 0.0
    assert first_edge(0.9 * SECTOR, 1.0, WHEEL) == 2.0
    assert first_edge(0.1 * SECTOR, 0.0, WHEEL) == 1.0
    assert first_edge(0.0, 0.0, WHEEL) == 1.0
    assert sector(WHEEL) == pytest.approx(0.785398, abs=1e-6)


def test_share_by_hand():
    """Nothing irregular: 0.2 x 63/64; one missed and one regular: (1 - 0.8 x 63/64) 63/64."""
    assert irregular_share(0.2, 0.0, 1.0) == pytest.approx(0.196875)
    assert irregular_share(0.2, 1.0, 1.0) == pytest.approx((1.0 - 0.7875) * 0.984375)


@given(st.floats(0.0, 1.0), st.integers(0, 20), st.integers(0, 20))
def test_share_stays_one(share, irregular, regular):
    assert 0.0 <= irregular_share(share, float(irregular), float(regular)) <= 1.0


@given(st.integers(-100, 100), st.integers(1, 12), st.floats(-0.45, 0.45), st.booleans())
def test_capture_range(last, passed, off, known):
    """Edges may be missed at will: within 0.45 sectors the right one is found, with its polarity within 0.75.

    Near the end of the capture range (0.5 and 1) the next edge after a manoeuvre may be likelier: by hand below.
    """
    number = last + passed
    polarity = 1.0 - 2.0 * (number % 2) if known else 0.0
    reach = 0.75 / 0.45 if known else 1.0
    if abs(reach * off) > 0.2 and passed < 4:
        return
    seen = sighting(number + reach * off, polarity, since=float(passed), odds=1e6)
    found = associated_edge(float(last), seen, WHEEL)
    assert found.used == 1.0
    assert found.edge == number


def test_likelier_of_missed_edges_and_a_manoeuvre():
    """Last edge 10, a falling one seen where the belief is at 12.4 sectors: 13 after two missed ones, or 11 after a
    manoeuvre. 13: 0.6 sectors = 5.9 deviations of 0.08, cost 17.3, and -2 ln p: 9.2 for p = 0.01, 3.2 for 0.2.
    11: 1.4 sectors = 13.7 deviations of 0.08 cost 94.4, of 0.2 15.1 and ln 2.5 = 0.9; and the odds against.
    """
    assert associated_edge(10.0, sighting(12.4, -1.0, since=2.4), WHEEL).edge == 13.0
    wide = (0.08, 0.2)
    assert associated_edge(10.0, sighting(12.4, -1.0, since=2.4, deviations=wide), WHEEL).edge == 13.0  # 26.5 < 28.0
    reliable = sighting(12.4, -1.0, since=2.4, deviations=wide, irregular=1e-3)
    assert associated_edge(10.0, reliable, WHEEL).edge == 11.0  # 17.3 + 13.8 = 31.1 > 28.0
    begun = sighting(12.4, -1.0, since=2.4, deviations=wide, odds=6.0)
    assert associated_edge(10.0, begun, WHEEL).edge == 11.0  # 22.0 < 26.5
    begun = sighting(12.4, -1.0, since=2.4, deviations=wide, odds=6.0, irregular=0.2)
    assert associated_edge(10.0, begun, WHEEL).edge == 13.0  # 20.5 < 22.0


def test_an_edge_that_the_count_misses_too_costs_nothing():
    """Last edge 10, a rising one seen where the belief is at 14 sectors. 14, the belief's own, costs -2 ln p for two
    more missed edges than 12, the next that rises: 9.2. 12: 2 sectors = 0.079 deviations of 20 rad cost nothing, ln 250
    = 5.5, and the odds against a manoeuvre, 4: 9.5. Were 11 charged to 14 alone, it would cost 13.8.
    """
    wide = (0.08, 20.0)
    assert associated_edge(10.0, sighting(14.0, 1.0, since=4.0, deviations=wide, odds=4.0), WHEEL).edge == 14.0
    assert associated_edge(10.0, sighting(14.0, 1.0, since=4.0, deviations=wide, odds=3.6), WHEEL).edge == 12.0


def test_a_signal_that_fails_is_not_a_shaft_that_stops():
    """Last edge 10, a rising one seen where the belief is at 40.1 sectors. 40: 0.1 sectors = 0.98 deviations cost 0.5,
    28 more missed edges than 12 asks for -ln 1e-6 = 13.8, not 28 ln 100 = 129. 12, the next that rises: 28.1 sectors =
    1.10 deviations of 20 rad cost 0.6, ln 250 = 5.5, and the odds against a manoeuvre, 12: 18.1 in all, or 12.1 with
    one already in sight.
    """
    wide = (0.08, 20.0)
    assert associated_edge(10.0, sighting(40.1, 1.0, since=30.1, deviations=wide), WHEEL).edge == 40.0
    assert associated_edge(10.0, sighting(40.1, 1.0, since=30.1, deviations=wide, odds=6.0), WHEEL).edge == 12.0


def test_faster_than_believed_is_the_next_edge():
    """Where the nearest of the polarity lies behind the last edge, the next one is counted."""
    late = sighting(10.4, 0.0, since=0.6)
    assert associated_edge(10.0, late, WHEEL)[:2] == (11.0, 1.0)


def test_bounce_is_not_an_edge():
    """Two edges in one interval shortly after edge 10 or together with edge 11; one that comes back; three in one."""
    assert associated_edge(10.0, sighting(10.2, 1.0, fresh=2.0, since=0.2), WHEEL).used == 0.0
    assert associated_edge(10.0, sighting(11.0, 1.0, fresh=2.0, since=1.0), WHEEL).used == 0.0
    assert associated_edge(10.0, sighting(10.2, -1.0, since=0.2), WHEEL).used == 0.0
    assert associated_edge(10.0, sighting(10.2, 1.0, since=0.2), WHEEL).used == 0.0
    assert associated_edge(10.0, sighting(11.0, -1.0, fresh=3.0, since=1.0), WHEEL)[:2] == (11.0, 1.0)
    assert associated_edge(10.0, sighting(11.1, -1.0, since=1.1, ignored=2.0), WHEEL)[:2] == (11.0, 1.0)
    assert associated_edge(10.0, sighting(12.0, 1.0, fresh=2.0, since=2.0), WHEEL)[:2] == (12.0, 1.0)


def watched(edge_times, filtered, seed, speed, duration, missed=0.0, bounced=0.0, settings=SETTINGS, noise=True):
    """Rows of a steady wheel, and the errors of angle and speed after 2 s; edges are missed from the 20th on."""
    rng = np.random.default_rng(seed)
    numbers, angles = edge_times.angles(settings.wheel.edges, 1, int(duration * speed / SECTOR) + 8)
    errors = np.sqrt(3.47e-3) * rng.normal(size=angles.size) * noise
    times, polarity = (angles + errors) / speed, 1.0 - 2.0 * (numbers % 2.0)
    kept = (rng.random(times.size) >= missed) | (np.arange(times.size) < 20)
    times, polarity = times[kept], polarity[kept]
    if bounced:
        at = np.nonzero(rng.random(times.size) < bounced)[0]
        back = times[at] + 1e-3 * rng.random(at.size)
        again = back + 0.5e-3 * rng.random(at.size)
        times = np.concatenate([times, back, again])
        polarity = np.concatenate([polarity, -polarity[at], polarity[at]])
    rows = edge_times.clocked(times, polarity, rng.random(), duration)
    shown, memory = filtered(settings, rows, speed=speed - 20.0)
    late = rows[:, 0] > 2.0
    errors = shown[late, 0] - speed * rows[late, 0], shown[late, 1] - speed
    return rows, *errors, memory, np.sum(~kept), shown[late, 2]


@pytest.mark.parametrize("missed", [0.02, 0.2])
@pytest.mark.parametrize("speed", [SPEED, 68.7])
def test_missed_edges_for_ten_minutes(edge_times, filtered, missed, speed):
    """Published: at most 0.033 and 0.034 rad at 24.7 Hz, by the sampling alone, in 4 s and 4 seeds.

    In 600 s and with the threshold's noise 5 deviations of an edge's angle may come together; a lost sector is 0.785.
    A counter would be off by the edges missed.
    """
    rows, angle_error, _, memory, lost, _ = watched(edge_times, filtered, 11, speed, 600.0, missed)
    assert np.max(np.abs(angle_error)) < 0.15
    assert abs(memory.tally.missed_edges - lost) <= 4.0
    counter = np.sum(rows[:, 1]) * SECTOR
    assert speed * rows[-1, 0] - counter > 0.9 * missed * speed * 600.0


@pytest.mark.sampled(4)
@pytest.mark.parametrize("frequency", [10.9, 20.3, 24.7, 33.1])
@pytest.mark.parametrize("missed", [0.02, 0.2])
def test_missed_edges_over_seeds(edge_times, filtered, missed, frequency):
    """200 records of 10 s each, with the noise of the threshold: no sector lost in any.

    But at 10.9 Hz, the slowest of the machine, and a fifth missed: there an edge three or four sectors late, after two
    that came late by chance, may as well be the next one of a wheel that slows down. 1 of 1000 records; 2 of 200 or
    fewer with a chance of 0.999.
    """
    lost = 0
    for seed in range(200):
        _, angle_error, *_ = watched(edge_times, filtered, seed, 2.0 * np.pi * frequency, 10.0, missed)
        lost += np.max(np.abs(angle_error)) > 0.25
    assert lost <= (2 if frequency == 10.9 and missed == 0.2 else 0)


@pytest.mark.parametrize("frequency", [10.9, 24.7, 33.1])
@pytest.mark.parametrize("missed", [0.02, 0.2])
def test_a_filter_that_hears_the_silence_keeps_the_sectors_too(edge_times, filtered, missed, frequency):
    """100 records of 10 s. Where several edges in a row are missed a halt is thought of, for an instant. At the end the
    sector is right in all but two, and 97 % of all errors of the angle lie within three stated deviations.
    """
    lost, within = 0, []
    for seed in range(100):
        _, angle_error, _, _, _, deviation = watched(
            edge_times, filtered, seed, 2.0 * np.pi * frequency, 10.0, missed, settings=SHIPPED
        )
        lost += abs(angle_error[-1]) > 0.25
        within.append(np.mean(np.abs(angle_error) < 3.0 * deviation))
    assert lost <= 2
    assert np.mean(within) > 0.97


@pytest.mark.parametrize("seed", range(10))
def test_no_sector_is_lost_in_ten_minutes(edge_times, filtered, seed):
    """A fifth of 118 000 edges missed: never half a sector off, at no sample."""
    _, angle_error, _, _, lost, _ = watched(edge_times, filtered, 100 + seed, SPEED, 600.0, 0.2)
    assert lost > 20000
    assert np.max(np.abs(angle_error)) < 0.5 * SECTOR / 2.0


def test_encoder_that_misses_edges_for_ten_minutes(filtered):
    """The package's own encoder, a fifth of its edges missed, with the noise of its light: 0.08 x 0.49 = 0.039 rad."""
    encoder = Encoder(
        wheel=WHEEL,
        spot=LightSpot(width=5e-3, track_radius=10.19e-3, roundness=0.0),
        threshold=constant(0.5),
        hysteresis=0.0,
        noise=0.08,
        counter_bits=16.0,
        acquisition=SAMPLED,
        faults=replace(NO_FAULTS, missed_edges=0.2),
    )
    time = 1e-3 * np.arange(1, 600001)
    shaft = np.column_stack([time, 0.2 + SPEED * time, np.full_like(time, SPEED)])
    start = encoder_start(encoder, 0.0, 0.2, 5.0)
    rows = Replay(encoder_step, start, Shaft(0.0, 0.0, 0.0), encoder)(start, shaft).shown
    assert np.sum(rows[:, 1]) == pytest.approx(0.8 * 600.0 * SPEED / SECTOR, rel=0.01)
    shown, _ = filtered(SETTINGS, rows, angle=0.2, speed=SPEED - 20.0)
    assert np.max(np.abs(shown[2000:, 0] - shaft[2000:, 1])) < 0.15


@pytest.mark.parametrize("silence", [0.1, 0.3])
def test_a_dropout_is_told_from_a_stop_by_the_edges_after_it(edge_times, filtered, silence):
    """No edge for up to 59 sectors is taken for a stop while it lasts. The edges after it come as if the wheel had
    turned on, which no wheel that starts again does: in 57 of 60 runs the sector is right in the end."""
    right = 0
    for seed in range(60):
        rng = np.random.default_rng(seed)
        numbers, angles = edge_times.angles(WHEEL.edges, 1, 900)
        times = (angles + np.sqrt(3.47e-3) * rng.normal(size=angles.size)) / SPEED
        kept = (times < 2.0) | (times > 2.0 + silence)
        rows = edge_times.clocked(times[kept], 1.0 - 2.0 * (numbers[kept] % 2.0), rng.random(), 4.0)
        shown, memory = filtered(SHIPPED, rows, speed=140.0)
        during = (rows[:, 0] > 2.05) & (rows[:, 0] < 2.0 + silence)
        assert np.all(shown[during, 7] > 0.5)
        kept_up = abs(shown[-1, 0] - SPEED * rows[-1, 0]) < 0.15
        right += kept_up and memory.tally.missed_edges == np.sum(~kept)
    assert right >= 57


@pytest.mark.parametrize("silence", [0.1, 0.3, 0.6, 1.0])
def test_sector_is_kept_through_a_dropout(edge_times, filtered, silence):
    """No edge for up to 200 sectors: the prediction is good to P11 of the last edges carried on, the next edge is the
    nearest to it. At 1 s the deviation is sqrt(q/3) = 0.29 rad and more, but at an even speed the error is smaller.
    """
    for seed in range(100):
        rng = np.random.default_rng(seed)
        numbers, angles = edge_times.angles(WHEEL.edges, 1, 900)
        times = (angles + np.sqrt(3.47e-3) * rng.normal(size=angles.size)) / SPEED
        kept = (times < 2.0) | (times > 2.0 + silence)
        rows = edge_times.clocked(times[kept], 1.0 - 2.0 * (numbers[kept] % 2.0), rng.random(), 4.0)
        shown, memory = filtered(SETTINGS, rows, speed=140.0)
        assert np.max(np.abs(shown[rows[:, 0] > 1.0, 0] - SPEED * rows[rows[:, 0] > 1.0, 0])) < 0.6
        assert abs(shown[-1, 0] - SPEED * rows[-1, 0]) < 0.15
        assert memory.tally.missed_edges == np.sum(~kept)


def test_missed_edges_without_threshold_noise(edge_times, filtered):
    """The published figures themselves, 4 s at 24.7 Hz, within the factor 1.5 of a maximum over few seeds."""
    for missed in (0.02, 0.2):
        worst = [
            np.max(np.abs(watched(edge_times, filtered, seed, SPEED, 6.0, missed, noise=False)[1])) for seed in range(4)
        ]
        assert max(worst) < 1.5 * 0.034


@pytest.mark.parametrize("speed", [SPEED, 68.7])
def test_bounce_for_a_minute(edge_times, filtered, speed):
    """2 % of edges bounce within 1.5 ms, so that one to three are seen, in one sample or in several."""
    for seed in range(3):
        _, angle_error, *_ = watched(edge_times, filtered, seed, speed, 60.0, bounced=0.02)
        assert np.max(np.abs(angle_error)) < 0.15


def test_wheel_that_stood_still_is_taken_up_again(edge_times, filtered):
    """3 s at 150 rad/s, 4 s without an edge, then 60 rad/s: nothing is taken for known any more, so the speed is right
    to 5 % after 7 or 8 edges of 13 ms and stays. The angle is, where the silence is taken for a stop; a filter to which
    it says nothing guesses how far the wheel went.
    """
    numbers, angles = edge_times.angles(WHEEL.edges, 1, 800)
    for seed in range(10):
        rng = np.random.default_rng(seed)
        seen = angles + np.sqrt(3.47e-3) * rng.normal(size=angles.size)
        times = np.where(angles < 450.0, seen / 150.0, 7.0 + (seen - 450.0) / 60.0)
        rows = edge_times.clocked(times, 1.0 - 2.0 * (numbers % 2.0), rng.random(), 8.0)
        for settings, known in ((SETTINGS, 7.12), (SHIPPED, 7.2)):
            shown, _ = filtered(settings, rows, speed=140.0)
            assert np.all(np.isfinite(shown))
            assert np.max(np.abs(shown[rows[:, 0] > known, 1] - 60.0)) < 4.5
        standing = (rows[:, 0] > 3.05) & (rows[:, 0] < 6.95)
        assert np.all(shown[standing, 7] > 0.5) and np.max(np.abs(shown[standing, 1])) < 10.0
        assert abs(shown[-1, 0] - 450.0 - 60.0 * (rows[-1, 0] - 7.0)) < 0.15


@pytest.mark.parametrize("factor", [0.5, 2.0, 3.0])
def test_multiple_of_the_speed_is_not_believed(edge_times, filtered, factor):
    """Unknown polarity and a start that is sure of half, twice or three times the speed: found out within 2 s."""
    rows, *_ = watched(edge_times, filtered, 5, 70.0, 4.0)
    rows = rows.copy()
    rows[:, 4] = 0.0
    sure = replace(SETTINGS, angle_variance=0.01, speed_variance=1.0)
    shown, _ = filtered(sure, rows, speed=70.0 * factor)
    assert np.max(np.abs(shown[rows[:, 0] > 2.5, 1] - 70.0)) < 1.0


def test_edge_angle_of_a_number_is_what_is_used():
    assert edge_angle(13.0, WHEEL) == pytest.approx(13.0 * SECTOR)
