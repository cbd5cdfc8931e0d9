"""Edges out of waves, counters and stamps, whole or in portions."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vvdp.offline.config import Comparator
from vvdp.offline.edges import CountEdges, Debounce, Edges, StampEdges, WaveEdges, join, no_edges, part, plateaus

AUTOMATIC = Comparator(None, 0.25, True, False)


def ramps(times, crossings, width, first_rises=True):
    """Brightness 0 to 1 that crosses one half at each of `crossings`, up and down by turns, on ramps of `width`."""
    values = np.zeros(times.size) if first_rises else np.ones(times.size)
    for k, at in enumerate(crossings):
        step = np.clip((times - at) / width + 0.5, 0.0, 1.0)
        values += step if (k % 2 == 0) == first_rises else -step
    return values


def even(crossings):
    return np.where(np.arange(len(crossings)) % 2 == 0, 1.0, -1.0)


def plain(times, polarities=None):
    t = np.asarray(times, float)
    return Edges(t, np.zeros(t.size), np.zeros(t.size) if polarities is None else np.asarray(polarities, float),
                 np.ones(t.size))  # fmt: skip


# Plateaus


@pytest.mark.parametrize("samples", [2, 3, 5])
def test_plateaus_of_a_comparator_with_few_samples_a_sector(samples):
    """A step as high as the swing every few samples is no noise."""
    rng = np.random.default_rng(samples)
    found = plateaus(np.repeat(np.tile([0.2, 4.3], 400), samples) + rng.normal(0.0, 0.02, 800 * samples))
    assert (found.low, found.high) == pytest.approx((0.2, 4.3), abs=0.1)


def test_plateaus_of_a_square_wave():
    # 50 samples at 1 V, 50 at 4 V: the middle is 2.5 V, whatever their order.
    found = plateaus(np.repeat([1.0, 4.0, 1.0, 4.0], 25))
    assert found is not None
    assert (found.low, found.high, found.middle, found.swing) == (1.0, 4.0, 2.5, 3.0)


@pytest.mark.parametrize("share", [0.03, 0.3, 0.97])
def test_the_middle_does_not_depend_on_how_long_the_wave_is_up(share):
    rng = np.random.default_rng(0)
    up = np.arange(20_000) % 1000 < 1000 * share
    found = plateaus(0.5 + 3.0 * up + rng.normal(0.0, 0.05, up.size))
    assert found is not None
    assert found.middle == pytest.approx(2.0, abs=0.03)  # a fifth's boundary lies 0.84 deviations out on either side
    assert found.noise == pytest.approx(0.05, rel=0.15)


@pytest.mark.parametrize("seed", range(5))
def test_noise_and_a_constant_are_no_wave(seed):
    assert plateaus(np.random.default_rng(seed).normal(2.0, 0.1, 5000)) is None
    assert plateaus(np.full(5000, 3.3)) is None


# Wave


def test_crossings_lie_between_the_samples():
    # Ramps of 4 ms, samples every ms: a straight line crosses exactly where the line between two samples does.
    crossings = np.array([0.0132, 0.0307, 0.0411, 0.0605])
    t = np.arange(0.0, 0.075, 1e-3)
    found = WaveEdges(AUTOMATIC).push(t, 1.0 + 3.0 * ramps(t, crossings, 4e-3), 1e-3)
    assert found.times == pytest.approx(crossings, abs=1e-12)
    assert np.array_equal(found.polarities, [1.0, -1.0, 1.0, -1.0])
    # A quarter of the swing passes between two samples: its square of a millisecond hides when.
    assert found.intervals == pytest.approx(np.full(4, 1e-3 / 16), rel=1e-9)


def test_without_interpolation_an_edge_lies_anywhere_in_its_interval():
    crossings = np.array([0.0132, 0.0307, 0.0411, 0.0605])
    t = np.arange(0.0, 0.075, 1e-3)
    found = WaveEdges(Comparator(None, 0.25, False, False)).push(t, ramps(t, crossings, 4e-3), 1e-3)
    assert found.times == pytest.approx([0.0135, 0.0305, 0.0415, 0.0605])
    assert found.intervals == pytest.approx(np.full(4, 1e-3))


def test_a_jump_of_the_whole_swing_hides_when_it_happened():
    t = np.arange(0.0, 0.06, 1e-3)
    found = WaveEdges(AUTOMATIC).push(t, np.where(np.mod(t, 0.02) < 0.0105, 0.0, 5.0), 1e-3)
    assert found.intervals == pytest.approx(np.full(found.times.size, 1e-3))


def test_an_inverted_wave_turns_the_polarity():
    t = np.arange(0.0, 0.075, 1e-3)
    v = ramps(t, [0.0132, 0.0307, 0.0411], 4e-3)
    up, down = (WaveEdges(Comparator(None, 0.25, True, inverted)).push(t, v, 1e-3) for inverted in (False, True))
    assert np.array_equal(up.polarities, -down.polarities)
    assert np.array_equal(up.times, down.times)


def test_hysteresis_keeps_noise_from_making_edges():
    rng = np.random.default_rng(3)
    crossings = np.arange(1, 200) * 5.1e-3
    t = np.arange(0.0, 1.03, 1e-5)
    v = ramps(t, crossings, 3e-3) + rng.normal(0.0, 0.02, t.size)
    bare = WaveEdges(Comparator(None, 0.0, True, False)).push(t, v, 1e-5)
    held = WaveEdges(AUTOMATIC).push(t, v, 1e-5)
    assert bare.times.size > crossings.size  # the test would see a comparator without hysteresis
    assert held.times.size == crossings.size
    # Noise of 0.02 on a slope of 1/3 ms: 60 us a crossing; the mean of first and last crossing is no worse.
    assert np.std(held.times - crossings) < 60e-6
    # and what is said of it is of that size: sqrt(12) * 60 us wide
    assert np.median(held.intervals) == pytest.approx(np.sqrt(12.0) * 60e-6, rel=0.6)


@given(st.lists(st.integers(1, 700), max_size=8), st.integers(0, 99))
def test_portions_give_the_same_edges_as_the_whole(cuts, seed):
    rng = np.random.default_rng(seed)
    crossings = np.cumsum(rng.uniform(4e-3, 8e-3, 60))
    t = np.arange(0.0, crossings[-1] + 0.01, 5e-4)
    v = ramps(t, crossings, 3e-3) + rng.normal(0.0, 0.01, t.size)
    fixed = Comparator(0.5, 0.2, True, False)
    whole_finder, finder = WaveEdges(fixed), WaveEdges(fixed)
    whole_finder.plateaus = finder.plateaus = plateaus(v)  # the band is a share of the swing
    whole = whole_finder.push(t, v, 5e-4)
    ends = sorted({min(cut, t.size) for cut in cuts} | {t.size})
    parts, start = [], 0
    for end in ends:
        finder.plateaus = plateaus(v)
        parts.append(finder.push(t[start:end], v[start:end], 5e-4))
        start = end
    found = join(parts)
    assert np.array_equal(found.times, whole.times)
    assert np.array_equal(found.polarities, whole.polarities)


def test_an_edge_in_a_gap_is_not_placed():
    t = np.concatenate([np.arange(0.0, 0.02, 1e-3), np.arange(0.04, 0.06, 1e-3)])
    finder = WaveEdges(AUTOMATIC)
    found = finder.push(t, np.where(t < 0.03, 0.0, 1.0) - np.where(t > 0.0505, 1.0, 0.0), 1e-3)
    assert found.times == pytest.approx([0.0505], abs=6e-4)
    assert finder.lost == 1


def test_a_threshold_follows_a_lamp_that_fades():
    t = np.arange(0.0, 2.0, 1e-3)
    v = (2.0 - 0.6 * t) * ramps(t, np.arange(1, 300) * 6.3e-3, 3e-3)
    finder = WaveEdges(AUTOMATIC)
    for begin in range(0, t.size, 200):
        finder.push(t[begin : begin + 200], v[begin : begin + 200], 1e-3)
    assert finder.levels[0] > 1.5 * finder.levels[-1]
    assert finder.found == pytest.approx(299, abs=1)


# Counter


def test_edges_of_a_counter_are_the_steps_in_their_sampling_intervals():
    t = np.arange(6) * 1e-3
    found = CountEdges().push(t, np.array([5.0, 5.0, 6.0, 6.0, 9.0, 9.0]))
    assert found.times == pytest.approx([1.5e-3, 4e-3 - 1e-3 / 6.0])  # the last of three, in the last third
    assert np.array_equal(found.counts, [1.0, 3.0])
    assert found.intervals == pytest.approx([1e-3, 1e-3])
    assert np.array_equal(found.polarities, [0.0, 0.0])


@pytest.mark.parametrize("bits", [4, 8, 16, 32])
@given(st.lists(st.integers(0, 2), min_size=5, max_size=60), st.integers(1, 20))
def test_a_counter_may_roll_over(bits, steps, cut):
    true = np.cumsum([2**bits - 6, *steps]).astype(float)
    t = np.arange(true.size) * 1e-3
    finder = CountEdges()
    shown = np.mod(true, 2.0**bits)
    found = join([finder.push(t[:cut], shown[:cut]), finder.push(t[cut:], shown[cut:])])
    assert np.sum(found.counts) == true[-1] - true[0]
    assert finder.resets == 0


def test_a_reset_is_told_and_adds_nothing():
    finder = CountEdges()
    found = finder.push(np.arange(6) * 1e-3, np.array([1000.0, 1001.0, 0.0, 1.0, 2.0, 2.0]))
    assert np.sum(found.counts) == 3 and finder.resets == 1 and finder.rollovers == 0


def test_jitter_at_an_edge_is_waited_out():
    finder = CountEdges()
    found = finder.push(np.arange(8.0), np.array([3.0, 4.0, 3.0, 4.0, 4.0, 5.0, 4.0, 6.0]))
    assert np.array_equal(found.times, [0.5, 4.5, 6.5])
    assert finder.backward == 2


def test_a_counter_that_counts_down_goes_on():
    finder = CountEdges()
    found = finder.push(np.arange(5.0), np.array([9.0, 8.0, 7.0, 7.0, 5.0]))
    assert np.array_equal(found.counts, [1.0, 1.0, 2.0]) and finder.downward


# Stamps


def test_two_columns_are_merged_with_their_polarity():
    finder = StampEdges(True)
    one = finder.push(np.array([0.1, 0.3, 0.5]), np.array([0.2, np.nan, 0.4]), last=False)
    two = finder.push(np.array([0.7]), np.array([0.6, 0.8]), last=False)
    rest = finder.push(np.empty(0), np.empty(0), last=True)
    found = join([one, two, rest])
    assert np.array_equal(found.times, [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8])
    assert np.array_equal(found.polarities, even(found.times))


def test_stamps_that_are_no_numbers_are_left_out():
    found = StampEdges(False).push(np.array([0.1, np.nan, 0.3]), np.empty(0), last=True)
    assert np.array_equal(found.times, [0.1, 0.3]) and np.array_equal(found.polarities, [0.0, 0.0])


# Bounces


def test_an_edge_that_bounced_is_one_and_a_glitch_is_none():
    t = np.arange(1, 41) * 5e-3
    bounced = np.sort(np.concatenate([t, [t[10] + 1e-4, t[10] + 2e-4], [t[20] + 2.5e-3, t[20] + 2.6e-3]]))
    finder = Debounce()
    found = finder.push(plain(bounced, even(bounced)), last=True)
    assert finder.doubled == 4
    assert found.times.size == 40
    assert found.times[10] == pytest.approx(t[10] + 1e-4)  # the middle of the bounce
    assert np.array_equal(found.polarities, even(t))
    assert found.intervals[10] == pytest.approx(2e-4)


def test_without_polarity_a_cluster_is_one_edge():
    t = np.arange(1, 41) * 5e-3
    doubled = np.sort(np.concatenate([t, t[::2] + 1e-4]))
    finder = Debounce()
    found = finder.push(plain(doubled), last=True)
    assert np.array_equal(found.times, t)
    assert finder.doubled == 20


def test_missed_edges_and_changing_speed_are_no_bounces():
    t = np.cumsum(np.concatenate([np.full(30, 0.02), np.geomspace(0.02, 0.004, 30), np.full(200, 0.004)]))
    kept = np.delete(t, [40, 41, 100, 150, 151, 152])
    finder = Debounce()
    assert np.array_equal(finder.push(plain(kept), last=True).times, kept)
    assert finder.doubled == 0


@settings(max_examples=50)
@given(st.lists(st.integers(1, 120), max_size=6), st.integers(0, 99))
def test_bounces_in_portions_are_those_of_the_whole(cuts, seed):
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(4.5e-3, 5.5e-3, 100))
    noisy = np.sort(np.concatenate([t, rng.choice(t, 5) + 1e-4]))
    whole = Debounce().push(plain(noisy), last=True)
    finder, parts, start = Debounce(), [], 0
    for end in sorted({min(cut, noisy.size) for cut in cuts} | {noisy.size}):
        parts.append(finder.push(part(plain(noisy), slice(start, end))))
        start = end
    parts.append(finder.push(no_edges(), last=True))
    assert np.array_equal(join(parts).times, whole.times)


@pytest.mark.parametrize("ends", [(-5.0,), (9.0,), (9.0, 19.0), (9.0, 19.0, 29.0), (-15.0, -5.0, 9.0, 19.0)])
def test_edges_that_stand_alone_at_the_ends_make_no_bounces_of_others(ends):
    t = np.arange(1, 401) * 5e-3
    lonely = np.sort(np.concatenate([t, ends]))
    finder = Debounce()
    assert np.array_equal(finder.push(plain(lonely), last=True).times, lonely)
    assert finder.doubled == 0


def test_a_wheel_that_turns_much_slower_afterwards_makes_no_bounces():
    t = np.cumsum(np.concatenate([np.full(50, 5e-3), np.full(50, 1.0), np.full(50, 5e-3)]))
    finder = Debounce()
    assert np.array_equal(finder.push(plain(t), last=True).times, t)


NAN = np.nan


@pytest.mark.parametrize(
    ("rising", "falling", "count"),
    [
        ([0.1, NAN, 0.2, np.inf], [], 2),
        ([0.1, 0.2, NAN, NAN], [], 0),  # the column ends before its table does
        ([-np.inf, NAN, 0.2], [], 2),
        ([0.1, NAN, 0.3], [0.15, 0.25, 0.35], 1),
        ([0.1, NAN, 0.3, NAN], [NAN, 0.2, NAN, 0.4], 0),  # a list of events, each in one of two columns
        ([0.1, NAN, 0.3, NAN], [NAN, NAN, NAN, 0.4], 1),
    ],
)
@pytest.mark.parametrize("at_once", [1, 2, 9])
def test_times_that_are_no_numbers_are_counted(rising, falling, count, at_once):
    finder = StampEdges(bool(falling))
    for begin in range(0, len(rising), at_once if not falling else 9):
        end = begin + (at_once if not falling else 9)
        finder.push(np.array(rising[begin:end]), np.array(falling[begin:end], float), last=False)
    assert finder.not_numbers == count
