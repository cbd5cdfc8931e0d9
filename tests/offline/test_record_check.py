"""What is wrong with a record is found, wherever the portions end, and the rest is cut into pieces that are sound."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.words import wording

from vvdp.logs.channel import Portion
from vvdp.logs.source import open_log
from vvdp.offline import record_check
from vvdp.offline.record_check import Inspection, findings, pieces


def inspected(times, values, cuts=()):
    """Findings and pieces (number, times, values) of a record given in portions that end at `cuts`."""
    inspection = Inspection("c")
    borders = [0, *sorted(cuts), len(times)]
    portions = [Portion(times[a:b], values[a:b]) for a, b in pairwise(borders)]
    joined = {}
    for number, t, v in pieces(portions, inspection):
        joined.setdefault(number, []).append((t, v))
    parts = [tuple(np.concatenate(column) for column in zip(*joined[k], strict=True)) for k in sorted(joined)]
    return inspection.findings(), parts


def noisy(count):
    return np.random.default_rng(0).normal(size=count)


def test_a_sound_record_has_no_findings_and_one_piece():
    times, values = 0.001 * np.arange(1000), noisy(1000)
    found, parts = inspected(times, values, (100, 333))
    assert not found and len(parts) == 1
    assert np.array_equal(parts[0][0], times) and np.array_equal(parts[0][1], values)


def test_a_gap_is_found_and_cuts():
    times, values = 0.5 * np.arange(100), noisy(100)
    keep = (np.arange(100) < 40) | (np.arange(100) >= 43)
    (gap,), parts = inspected(times[keep], values[keep])
    # Samples 40, 41, 42 are missing, between 19.5 s and 21.5 s; the next row is row 40 of the file.
    assert gap == record_check.Finding("c", record_check.GAP_FOUND, 19.5, 21.5, 3, 40)
    assert str(gap) == "c: " + wording.estimate.gap.format(begin="19.5 s", end="21.5 s", row=40, samples=3)
    assert [part[0].size for part in parts] == [40, 57]


def test_one_and_a_half_intervals_are_no_gap():
    times = np.array([0.0, 1, 2, 3, 4.5, 5.5, 6.5, 8.01])
    found, parts = inspected(times, noisy(8))
    assert [(f.what, f.row) for f in found] == [(record_check.GAP_FOUND, 7)] and len(parts) == 2


def test_time_that_goes_back_cuts_and_time_that_stands_leaves_out():
    times = np.array([0.0, 1, 2, 3, 3, 3, 4, 5, 0, 1, 2, 3])
    found, parts = inspected(times, noisy(12), (5,))
    assert found == (
        record_check.Finding("c", record_check.STANDS, 3.0, 3.0, 2, 4),
        record_check.Finding("c", record_check.BACKWARDS, 5.0, 0.0, 1, 8),
    )
    assert [part[0].tolist() for part in parts] == [[0, 1, 2, 3, 4, 5], [0, 1, 2, 3]]


def test_a_time_that_is_no_number_is_left_out_and_not_bridged():
    times = np.arange(8.0)
    times[3:5] = np.nan
    found, parts = inspected(times, noisy(8))
    assert [(f.what, f.begin, f.count, f.row) for f in found] == [
        (record_check.GAP_FOUND, 2.0, 2, 5), (record_check.NO_TIME, 2.0, 2, 3),
    ][::-1]  # fmt: skip
    assert [part[0].tolist() for part in parts] == [[0, 1, 2], [5, 6, 7]]


def test_values_that_are_no_numbers_are_found_and_kept():
    values = noisy(50)
    values[[7, 20, 21, 22]] = np.nan
    found, parts = inspected(np.arange(50.0), values, (21,))
    assert found == (
        record_check.Finding("c", record_check.NAN, 7.0, 7.0, 1, 7),
        record_check.Finding("c", record_check.NAN, 20.0, 22.0, 3, 20),
    )
    assert np.array_equal(parts[0][1], values, equal_nan=True)


def test_a_dead_channel():
    (dead,), _ = inspected(np.arange(10.0), np.full(10, 2.5), (4,))
    assert dead == record_check.Finding("c", record_check.CONSTANT, 0.0, 9.0, 10, 0)
    assert not inspected(np.arange(1.0), np.ones(1))[0]


def test_saturation_of_a_clipped_signal():
    times = 0.001 * np.arange(5000)
    wave = 3 * np.sin(2 * np.pi * 7 * times)
    for low, high, expected in (
        (-9, 2, {record_check.HIGH}),
        (-2, 9, {record_check.LOW}),
        (-2, 2, {record_check.HIGH, record_check.LOW}),
    ):
        found, _ = inspected(times, np.clip(wave, low, high), (1, 777, 2000))
        assert {finding.what for finding in found} == expected
        for finding in found:
            limit = high if finding.what == record_check.HIGH else low
            at = np.flatnonzero(np.clip(wave, low, high) == limit)
            assert (finding.count, finding.row, finding.end) == (at.size, at[0], times[at[-1]])


def test_what_is_no_saturation():
    """A square wave rests at its levels; a coarse converter rests on the crest of a sine; noise rests nowhere."""
    times = 1e-4 * np.arange(40_000)
    wave = np.sin(2 * np.pi * 11 * times + 0.3)
    for values in (np.sign(wave) * 5, np.round(wave * 127), np.round(wave * 2047), wave, noisy(40_000)):
        assert not inspected(times, values, (9999,))[0]


def test_many_findings_are_counted_together():
    values = noisy(1000)
    values[::2] = np.nan
    for cuts in ((), (11, 12, 500), tuple(range(1, 1000))):
        found, _ = inspected(np.arange(1000.0), values, cuts)
        assert len(found) == record_check.MOST + 1
        assert sum(finding.count for finding in found) == 500
        assert found[-1].what == record_check.NAN + record_check.FURTHER


@given(
    odd=st.lists(st.tuples(st.integers(0, 299), st.sampled_from("nsbgt")), max_size=12),
    cuts=st.sets(st.integers(1, 299), max_size=3),
)
def test_findings_do_not_depend_on_the_portions(odd, cuts):
    """Times with steps of 1; portions that are long enough to know the usual interval."""
    cuts = {cut - cut % 60 for cut in cuts} - {0}
    steps, values, times_missing = np.ones(300), noisy(300), []
    for at, kind in odd:
        if kind == "n":
            values[at] = np.nan
        elif kind == "t":
            times_missing.append(at)
        else:
            steps[at] = {"s": 0.0, "b": -7.5, "g": 5.0}[kind]
    times = np.cumsum(steps)
    times[times_missing] = np.nan
    whole, whole_parts = inspected(times, values)
    cut, cut_parts = inspected(times, values, cuts)
    assert list(map(repr, whole)) == list(map(repr, cut))
    assert all(
        np.array_equal(a, b, equal_nan=True)
        for p, q in zip(whole_parts, cut_parts, strict=True)
        for a, b in zip(p, q, strict=True)
    )
    for times_of_part, _ in whole_parts:
        intervals = np.diff(times_of_part)
        assert np.all(intervals > 0) and np.all(intervals <= record_check.GAP)
    # Nothing is lost but samples without a time of their own, and nothing is added.
    left = sum(part[0].size for part in whole_parts)
    assert left == 300 - sum(f.count for f in whole if f.what in (record_check.NO_TIME, record_check.STANDS))


@given(st.lists(st.integers(-3, 3), min_size=1, max_size=60), st.sets(st.integers(1, 59), max_size=6))
def test_extremes_do_not_depend_on_the_portions(levels, cuts):
    values = np.array(levels, float)
    inspection = Inspection("c")
    borders = [0, *sorted(cut for cut in cuts if cut < values.size), values.size]
    for a, b in pairwise(borders):
        inspection.pieces(Portion(np.arange(a, b, dtype=float), values[a:b]))
    high = inspection._high
    top = values.max()
    below = values[values < top]
    assert (high.value, high.count) == (top, np.count_nonzero(values == top))
    if below.size:
        assert (high.next_value, high.next_count) == (below.max(), np.count_nonzero(values == below.max()))
    runs = "".join("x" if value == top else " " for value in values).split()
    assert high.longest == max(map(len, runs))


def test_findings_of_a_log(tmp_path):
    lines = ["t [s],v,dead", *(f"{k},{k % 17 + k * 0.1},3" for k in range(100) if k not in (50, 51))]
    (tmp_path / "a.csv").write_text("\n".join(lines) + "\n")
    with open_log(tmp_path / "a.csv") as log:
        found = findings(log, ["v", "dead"], 30)
    assert [f.what for f in found["v"]] == [record_check.GAP_FOUND]
    assert [f.what for f in found["dead"]] == [record_check.CONSTANT, record_check.GAP_FOUND]
    assert found["v"][0].count == 2 and found["v"][0].row == 50


def test_empty_portions_do_nothing():
    assert not inspected(np.empty(0), np.empty(0))[0]
    inspection = Inspection("c")
    assert inspection.pieces(Portion(np.empty(0), np.empty(0))) == []
    all_nan = inspection.pieces(Portion(np.arange(3.0), np.full(3, np.nan)))
    assert all_nan[0].times.size == 3
    assert [f.what for f in inspection.findings()] == [record_check.NAN]


def test_jitter_is_no_gap():
    random = np.random.default_rng(4)
    times = np.cumsum(random.uniform(0.8, 1.2, 1000))
    found, parts = inspected(times, noisy(1000), (250,))
    assert not found and len(parts) == 1
    assert parts[0][0].size == pytest.approx(1000)
